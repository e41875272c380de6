//! Sections of thin straight walls, open and closed: area, moments, torsion constant, shear centre, from the middle lines alone.
//!
//! ```text
//! min over ω of  Σ t/l (ω_j - ω_i + r l)²,    J = its least value + Σ l t³/3 of walls without flow
//! ∫ (ω + a y - b x) x dA = 0,  ∫ (ω + a y - b x) y dA = 0      for the shear centre (a, b) from the centroid
//! ```
//!
//! r is the distance of a wall from the centroid, ω the warping along it for a unit twist: the flow of shear along closed cells is
//! Bredt's, for any number of cells and fins. A wall has no bending stiffness about its own middle line.
//!
//! Source: V. Z. Vlasov, Thin-Walled Elastic Beams, 1961, chapters I and V; W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 2002, section 10.3.

use retune::linalg::{DMatrix, DVector};

/// Constants of a section of walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Walls {
    pub area: f64,
    pub centroid: [f64; 2],
    /// ∫ y² dA, ∫ x² dA, ∫ x y dA about the centroid.
    pub i11: f64,
    pub i22: f64,
    pub i12: f64,
    pub j: f64,
    pub shear_centre: [f64; 2],
}

/// Points that are nearer than this share of the size of the section are one.
const SAME: f64 = 1e-9;
/// A wall carries flow where that is more than this share of what it would be in a wall of the whole section.
const FLOWS: f64 = 1e-9;

/// The constants of walls along a line of points, each with its thickness; zero makes a way from one branch to another.
///
/// # Errors
/// Walls along one straight line, which have no stiffness across it; walls that are not joined.
pub(super) fn walls(points: &[[f64; 2]], thickness: &[f64]) -> Result<Walls, &'static str> {
    let size = points.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut nodes: Vec<[f64; 2]> = Vec::new();
    let mut node_of = |p: [f64; 2]| {
        let is_same = |q: &[f64; 2]| (q[0] - p[0]).hypot(q[1] - p[1]) <= SAME * size;
        nodes.iter().position(is_same).unwrap_or_else(|| {
            nodes.push(p);
            nodes.len() - 1
        })
    };
    let at: Vec<usize> = points.iter().map(|p| node_of(*p)).collect();
    let whole = at.windows(2).zip(thickness).map(|(w, t)| ([w[0], w[1]], *t)).filter(|(w, t)| *t > 0.0 && w[0] != w[1]);
    // A wall is joined to what meets it between its ends.
    let mut lines: Vec<([usize; 2], f64)> = Vec::new();
    for (ends, t) in whole {
        let mut last = ends[0];
        for n in between(&nodes, ends, SAME * size).into_iter().chain([ends[1]]) {
            lines.push(([last, n], t));
            last = n;
        }
    }
    if lines.is_empty() {
        return Err("no wall has a length and a thickness");
    }
    let length = |w: [usize; 2]| (nodes[w[1]][0] - nodes[w[0]][0]).hypot(nodes[w[1]][1] - nodes[w[0]][1]);
    // ∫ f g dA of what is linear along each wall.
    let integral = |f: &dyn Fn(usize) -> f64, g: &dyn Fn(usize) -> f64| -> f64 {
        let one = |([i, j], t): &([usize; 2], f64)| {
            let (a, b) = ((f(*i), f(*j)), (g(*i), g(*j)));
            t * length([*i, *j]) / 6.0 * (2.0 * a.0 * b.0 + a.0 * b.1 + a.1 * b.0 + 2.0 * a.1 * b.1)
        };
        lines.iter().map(one).sum()
    };
    let one = |_: usize| 1.0;
    let area = integral(&one, &one);
    let centroid = [0, 1].map(|c| integral(&one, &|n| nodes[n][c]) / area);
    let (x, y) = (|n: usize| nodes[n][0] - centroid[0], |n: usize| nodes[n][1] - centroid[1]);
    let (i11, i22, i12) = (integral(&y, &y), integral(&x, &x), integral(&x, &y));
    let determinant = i11 * i22 - i12 * i12;
    if determinant <= 1e-12 * (i11 + i22).powi(2) {
        return Err("all walls lie along one line, across which thin walls have no stiffness");
    }
    // Every node that a wall touches must be reached from the first.
    let mut reached = vec![false; nodes.len()];
    reached[lines[0].0[0]] = true;
    for _ in 0..lines.len() {
        for ([i, j], _) in &lines {
            let either = reached[*i] || reached[*j];
            (reached[*i], reached[*j]) = (either, either);
        }
    }
    if lines.iter().any(|(w, _)| !reached[w[0]]) {
        return Err("its walls are not all joined");
    }
    // Nodes that no wall touches, and one that is, do not warp.
    let n = nodes.len();
    let mut matrix = DMatrix::zeros(n, n);
    let mut right = DVector::zeros(n);
    let turned = |[i, j]: [usize; 2]| x(i) * (y(j) - y(i)) - y(i) * (x(j) - x(i));
    for ([i, j], t) in &lines {
        let k = t / length([*i, *j]);
        let r = turned([*i, *j]);
        for (a, b, sign) in [(*i, *i, 1.0), (*j, *j, 1.0), (*i, *j, -1.0), (*j, *i, -1.0)] {
            matrix[(a, b)] += sign * k;
        }
        right[*i] += k * r;
        right[*j] -= k * r;
    }
    let fixed = lines[0].0[0];
    for a in (0..n).filter(|a| *a == fixed || !reached[*a]) {
        matrix.row_mut(a).fill(0.0);
        matrix.column_mut(a).fill(0.0);
        (matrix[(a, a)], right[a]) = (1.0, 0.0);
    }
    let warp = matrix.cholesky().ok_or("its walls are not all joined")?.solve(&right);
    let mean = integral(&one, &|n| warp[n]) / area;
    let w = |n: usize| warp[n] - mean;
    let slip = |[i, j]: [usize; 2]| warp[j] - warp[i] + turned([i, j]);
    let mut torsion = 0.0;
    for (ends, t) in &lines {
        let (l, s) = (length(*ends), slip(*ends));
        torsion += t / l * s * s;
        if s.abs() <= FLOWS * size * l {
            torsion += l * t.powi(3) / 3.0;
        }
    }
    // a i12 - b i22 = -∫ ω x dA, a i11 - b i12 = -∫ ω y dA.
    let (wx, wy) = (integral(&w, &x), integral(&w, &y));
    let a = (wx * i12 - wy * i22) / determinant;
    let b = (wx * i11 - wy * i12) / determinant;
    Ok(Walls { area, centroid, i11, i22, i12, j: torsion, shear_centre: [centroid[0] + a, centroid[1] + b] })
}

/// Nodes on a wall between its ends, in their order.
fn between(nodes: &[[f64; 2]], [a, b]: [usize; 2], near: f64) -> Vec<usize> {
    let along = [0, 1].map(|c| nodes[b][c] - nodes[a][c]);
    let l = along[0].hypot(along[1]);
    let place = |n: usize| {
        let d = [0, 1].map(|c| nodes[n][c] - nodes[a][c]);
        let (s, off) = ((d[0] * along[0] + d[1] * along[1]) / l, (d[0] * along[1] - d[1] * along[0]) / l);
        (s > near && s < l - near && off.abs() <= near).then_some((s, n))
    };
    let mut found: Vec<(f64, usize)> = (0..nodes.len()).filter_map(place).collect();
    found.sort_by(|x, y| x.0.total_cmp(&y.0));
    found.into_iter().map(|f| f.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, size: f64) {
        assert!((a - b).abs() < 1e-12 * size, "{a} is not {b}");
    }

    /// A channel of height h and flanges b: e = 3 b² t_f/(h t_w + 6 b t_f) behind its web (Vlasov), J = Σ l t³/3.
    #[test]
    fn a_channel_has_its_shear_centre_behind_the_web() {
        let (b, h, tf, tw) = (0.05, 0.12, 0.004, 0.003);
        let points = [[b, -h / 2.0], [0.0, -h / 2.0], [0.0, h / 2.0], [b, h / 2.0]];
        let w = walls(&points, &[tf, tw, tf]).unwrap();
        near(w.shear_centre[0], -3.0 * b * b * tf / (h * tw + 6.0 * b * tf), h);
        near(w.shear_centre[1], 0.0, h);
        near(w.j, (2.0 * b * tf.powi(3) + h * tw.powi(3)) / 3.0, w.j);
        near(w.i11, tw * h.powi(3) / 12.0 + 2.0 * b * tf * h * h / 4.0, w.i11);
        near(w.centroid[0], b * b * tf / (2.0 * b * tf + h * tw), b);
    }

    /// A box of uneven walls: Bredt's 4 A²/Σ(l/t); with a fin, which adds l t³/3.
    #[test]
    fn a_cell_has_the_torsion_constant_of_bredt() {
        let corners = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1], [0.0, 0.0]];
        let t = [0.002, 0.003, 0.004, 0.005];
        let bredt = 4.0 * 0.02_f64.powi(2) / (0.2 / 0.002 + 0.1 / 0.003 + 0.2 / 0.004 + 0.1 / 0.005);
        let w = walls(&corners, &t).unwrap();
        near(w.j, bredt, bredt);
        let fin = [corners.as_slice(), &[[-0.1, 0.0]]].concat();
        near(walls(&fin, &[t.as_slice(), &[0.001]].concat()).unwrap().j, bredt + 0.1 * 1e-9 / 3.0, bredt);
        // Two equal cells side by side: the flow in the wall between them vanishes.
        let two = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1], [0.0, 0.0], [-0.1, 0.0], [-0.1, 0.1], [0.0, 0.1]];
        let found = walls(&two, &[0.002; 7]).unwrap();
        let outer = 4.0 * 0.02_f64.powi(2) / (0.6 / 0.002);
        near(found.j, outer + 0.1 * 8e-9 / 3.0, outer);
        near(found.shear_centre[0], 0.0, 0.1);
        near(found.shear_centre[1], 0.05, 0.1);
    }

    /// A tee by a way without thickness: its shear centre is where its walls meet. A circle that is slit: 2 r from its middle (Roark).
    #[test]
    fn branches_and_slits() {
        let tee = walls(&[[-0.05, 0.1], [0.05, 0.1], [0.0, 0.1], [0.0, 0.0]], &[0.004, 0.0, 0.003]).unwrap();
        near(tee.area, 0.1 * 0.004 + 0.1 * 0.003, tee.area);
        near(tee.shear_centre[0], 0.0, 0.1);
        near(tee.shear_centre[1], 0.1, 0.1);
        let n = 400;
        let slit: Vec<[f64; 2]> = (0..=n)
            .map(|i| std::f64::consts::TAU * (f64::from(i) / f64::from(n) * (1.0 - 2e-6) + 1e-6))
            .map(|a| [a.cos(), a.sin()])
            .collect();
        let found = walls(&slit, &vec![0.01; n as usize]).unwrap();
        assert!((found.shear_centre[0] + 2.0).abs() < 1e-3 && found.shear_centre[1].abs() < 1e-9, "{found:?}");
    }

    /// Moments of inertia and of warping by a fine sum over the middle line, for a lipped section without symmetry.
    #[test]
    fn moments_are_those_of_a_fine_sum() {
        let points = [[0.02, 0.01], [0.0, 0.0], [0.01, 0.08], [0.06, 0.09], [0.07, 0.05]];
        let t = [0.002, 0.003, 0.0015, 0.004];
        let w = walls(&points, &t).unwrap();
        let n = 20_000;
        let (mut sums, mut omega) = ([0.0_f64; 6], [0.0_f64; 3]);
        let mut swept = 0.0;
        for (p, t) in points.windows(2).zip(t) {
            let d = [(p[1][0] - p[0][0]) / f64::from(n), (p[1][1] - p[0][1]) / f64::from(n)];
            let part = d[0].hypot(d[1]) * t;
            for i in 0..n {
                let at = [0, 1].map(|c| p[0][c] + d[c] * (f64::from(i) + 0.5));
                // The sector about the shear centre that the radius has swept.
                let r = [at[0] - w.shear_centre[0], at[1] - w.shear_centre[1]];
                let step = r[0] * d[1] - r[1] * d[0];
                let (x, y) = (at[0] - w.centroid[0], at[1] - w.centroid[1]);
                let here = swept + 0.5 * step;
                swept += step;
                for (sum, v) in sums.iter_mut().zip([1.0, at[0], at[1], y * y, x * x, x * y]) {
                    *sum += v * part;
                }
                for (sum, v) in omega.iter_mut().zip([here * x, here * y, here]) {
                    *sum += v * part;
                }
            }
        }
        for (a, b) in [(w.area, sums[0]), (w.centroid[0], sums[1] / sums[0]), (w.centroid[1], sums[2] / sums[0])] {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} is not {b}");
        }
        for (a, b) in [(w.i11, sums[3]), (w.i22, sums[4]), (w.i12, sums[5])] {
            assert!((a / b - 1.0).abs() < 1e-7, "{a} is not {b}");
        }
        // About the shear centre, sectors are orthogonal to x and y: what remains is the middle of the sum.
        let size = (w.i11 * w.area).sqrt() * 0.1;
        assert!(omega[0].abs() < 1e-7 * size && omega[1].abs() < 1e-7 * size, "{omega:?} of {size}");
    }

    #[test]
    fn what_has_no_stiffness_is_refused() {
        assert!(walls(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], &[0.1, 0.1]).unwrap_err().contains("one line"));
        let apart = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert!(walls(&apart, &[0.1, 0.0, 0.1]).unwrap_err().contains("not all joined"));
    }
}
