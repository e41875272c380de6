//! Stiffness and mass of a shell in its mean plane, carried to its nodes.

use super::super::direction::unit;
use super::super::{ElementError, PointWithin};
use super::Input;
use super::material::{self, Section, lumping, mass_of, offset};
use super::plane::{DOFS, Flat, MOST, Modes, Plane, Row};
use crate::linalg::vector3::{Vector3, cross, dot, minus};
use crate::linalg::{DMatrix, SymMatrix};

/// The mean plane of the nodes.
pub(super) struct Frame {
    /// Axes x, y and the normal, in element axes.
    pub(super) axes: [Vector3; 3],
    /// Nodes in the plane.
    pub(super) at: Vec<[f64; 2]>,
    /// Height of the nodes over the plane.
    pub(super) height: Vec<f64>,
    /// From the plane's x axis to that of the element's axes, projected onto the plane; to y where x is normal to it.
    pub(super) material_angle: f64,
}

impl Frame {
    /// The plane through the mean of the nodes along both diagonals (of three nodes: their plane), x along the first edge.
    pub(super) fn new(points: &[Vector3]) -> Result<Self, ElementError> {
        let n = points.len();
        let centre: Vector3 = std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n as f64);
        let (p, q) = (
            minus(points[2], points[0]),
            if n == 4 { minus(points[3], points[1]) } else { minus(points[2], points[1]) },
        );
        let normal = unit(cross(p, q))?;
        let edge = minus(points[1], points[0]);
        let along = dot(edge, normal);
        let x = unit(std::array::from_fn(|i| edge[i] - along * normal[i]))?;
        let y = cross(normal, x);
        let of_plane = |p: &Vector3| minus(*p, centre);
        // 1e-6: nearer to the normal, rounding would choose the direction.
        let reference = if normal[0].abs() < 1.0 - 1e-6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        Ok(Self {
            at: points.iter().map(of_plane).map(|p| [dot(p, x), dot(p, y)]).collect(),
            height: points.iter().map(of_plane).map(|p| dot(p, normal)).collect(),
            material_angle: dot(reference, y).atan2(dot(reference, x)),
            axes: [x, y, normal],
        })
    }

    /// Dofs of the mid-surface in the plane's axes from those of its node, which stands `arm` below it along the normal:
    /// u_s = R (u + θ × arm n), θ_s = R θ.
    pub(super) fn carry(&self, arm: f64) -> [[f64; DOFS]; DOFS] {
        let [x, y, normal] = self.axes;
        let mut t = [[0.0; DOFS]; DOFS];
        for (row, axis) in [x, y, normal].into_iter().enumerate() {
            // axis · (θ × n) = θ · (n × axis)
            let turned = cross(normal, axis);
            for k in 0..3 {
                t[row][k] = axis[k];
                t[row][3 + k] = arm * turned[k];
                t[3 + row][3 + k] = axis[k];
            }
        }
        t
    }

    /// Tᵀ A T, (6 nodes) x (6 nodes).
    pub(super) fn to_nodes(&self, a: &DMatrix<f64>, offset: f64) -> SymMatrix {
        let n = self.at.len();
        let block = self.carry(offset);
        let mut out = SymMatrix::zeros(DOFS * n);
        for (k, l) in (0..n).flat_map(|k| (0..=k).map(move |l| (k, l))) {
            let between = |i: usize, j: usize| {
                let (to, from) = (DOFS * k + i, DOFS * l + j);
                0.5 * (a[(to, from)] + a[(from, to)])
            };
            let right: [[f64; DOFS]; DOFS] =
                std::array::from_fn(|i| std::array::from_fn(|j| (0..DOFS).map(|m| between(i, m) * block[m][j]).sum()));
            for i in 0..DOFS {
                for j in (0..DOFS).filter(|j| k != l || *j <= i) {
                    out.add(DOFS * k + i, DOFS * l + j, (0..DOFS).map(|m| block[m][i] * right[m][j]).sum());
                }
            }
        }
        out
    }
}

/// Adds w Σ_ab row_a D_ab row_bᵀ.
pub(super) fn add_energy<const N: usize>(k: &mut DMatrix<f64>, rows: &[Row; N], d: &[[f64; N]; N], w: f64) {
    let n = k.nrows();
    for i in 0..n {
        let stress: [f64; N] = std::array::from_fn(|b| w * (0..N).map(|a| rows[a][i] * d[a][b]).sum::<f64>());
        if stress.iter().all(|s| *s == 0.0) {
            continue;
        }
        for j in 0..n {
            k[(i, j)] += (0..N).map(|b| stress[b] * rows[b][j]).sum::<f64>();
        }
    }
}

/// The strains that the membrane adds of itself: their energy, and what each does to the dofs.
pub(super) struct Enhanced {
    own: DMatrix<f64>,
    with_dofs: DMatrix<f64>,
}

impl Enhanced {
    pub(super) fn new(n: usize) -> Self {
        Self { own: DMatrix::zeros(4, 4), with_dofs: DMatrix::zeros(4, n) }
    }

    /// * `rows`, `d` - strains of membrane and bending, and what they give the forces of the membrane
    pub(super) fn add<const N: usize>(&mut self, modes: &Modes, rows: &[Row; N], d: &[[f64; N]; N], w: f64) {
        for a in 0..4 {
            let force: [f64; N] = std::array::from_fn(|j| w * (0..3).map(|i| modes[i][a] * d[i][j]).sum::<f64>());
            for b in 0..4 {
                self.own[(a, b)] += (0..3).map(|j| force[j] * modes[j][b]).sum::<f64>();
            }
            for j in 0..self.with_dofs.ncols() {
                self.with_dofs[(a, j)] += force.iter().zip(rows).map(|(f, row)| f * row[j]).sum::<f64>();
            }
        }
    }

    /// Their amplitudes by the dofs, -H⁻¹ L.
    pub(super) fn amplitudes(self) -> Result<DMatrix<f64>, ElementError> {
        Ok(-self.own.cholesky().ok_or(ElementError::Inverted)?.solve(&self.with_dofs))
    }

    /// Takes away what they give up: K - Lᵀ H⁻¹ L.
    fn condense(self, k: &mut DMatrix<f64>) -> Result<(), ElementError> {
        let with_dofs = self.with_dofs.clone();
        *k += with_dofs.tr_mul(&self.amplitudes()?);
        Ok(())
    }
}

/// Adds the geometric stiffness ∫ ∇uᵀ N ∇u dA of each displacement: a strip that is pulled is stiffer across its plane and in it.
fn add_preload(
    k: &mut DMatrix<f64>,
    flat: &Flat<'_>,
    input: &Input<'_>,
    material_angle: f64,
) -> Result<(), ElementError> {
    let Some(forces) = material::preload(input, material_angle) else { return Ok(()) };
    for (xi, weight) in (flat.plane.rules[2])() {
        let at = flat.local(xi)?;
        for axis in 0..3 {
            let mut slopes: [Row; 2] = [[0.0; MOST]; 2];
            for (i, d) in at.d.iter().enumerate().take(flat.n_nodes()) {
                for (slope, d) in slopes.iter_mut().zip(d) {
                    slope[DOFS * i + axis] = *d;
                }
            }
            add_energy(k, &slopes, &forces, weight * at.det);
        }
    }
    Ok(())
}

/// Stiffness, (6 nodes) x (6 nodes), in element axes.
///
/// Errors: a material that is not complete or stores no energy; an element without area, or folded over.
pub(super) fn stiffness(plane: &'static Plane, input: &Input<'_>) -> Result<SymMatrix, ElementError> {
    let frame = Frame::new(input.points)?;
    let flat = Flat { plane, at: &frame.at, height: &frame.height };
    let n = DOFS * frame.at.len();
    let Some(section) = material::section(input, frame.material_angle)? else {
        for (xi, _) in (plane.rules[1])() {
            flat.local(xi)?;
        }
        let mut k = DMatrix::zeros(n, n);
        add_preload(&mut k, &flat, input, frame.material_angle)?;
        return Ok(frame.to_nodes(&k, offset(input)));
    };
    let Section { membrane, bending, coupling, shear, .. } = section;
    let whole = section.whole();
    let mut k = DMatrix::zeros(n, n);
    let mut enhanced = Enhanced::new(n);
    for (xi, weight) in (plane.rules[0])() {
        let at = flat.local(xi)?;
        let area = weight * at.det;
        let stretch = (plane.membrane)(&flat, xi, &at);
        let bend = flat.bending(&at);
        let modes = plane.modes.map(|modes| modes(&flat, xi, &at)).transpose()?;
        if coupling.is_none() {
            add_energy(&mut k, &stretch, &membrane, area);
            add_energy(&mut k, &bend, &bending, area);
            if let Some(modes) = modes {
                enhanced.add(&modes, &stretch, &membrane, area);
            }
            continue;
        }
        let rows: [Row; 6] = std::array::from_fn(|i| if i < 3 { stretch[i] } else { bend[i - 3] });
        add_energy(&mut k, &rows, &whole, area);
        if let Some(modes) = modes {
            enhanced.add(&modes, &rows, &whole, area);
        }
    }
    if plane.modes.is_some() {
        enhanced.condense(&mut k)?;
    }
    (plane.drilling)(&flat, &section, &mut k)?;
    add_preload(&mut k, &flat, input, frame.material_angle)?;
    let thickness2 = material::thickness(input)?.powi(2);
    let softened = thickness2 / (thickness2 + plane.softening * flat.longest_edge().powi(2));
    for (xi, weight) in (plane.rules[1])() {
        let at = flat.local(xi)?;
        add_energy(&mut k, &flat.shear(xi, &at), &shear, softened * weight * at.det);
    }
    Ok(frame.to_nodes(&k, offset(input)))
}

/// Mass, (6 nodes) x (6 nodes), in element axes: displacements by the functions of the corners, rotary inertia ρ t³/12 about both axes in
/// the plane, none about the normal, and the first moment of plies; lumped, a share of the area's mass at every node and neither of them.
pub(super) fn mass(plane: &'static Plane, input: &Input<'_>) -> Result<SymMatrix, ElementError> {
    material::check(input)?;
    let frame = Frame::new(input.points)?;
    let flat = Flat { plane, at: &frame.at, height: &frame.height };
    Ok(frame.to_nodes(&plane_mass(&flat, input, lumping(input))?, offset(input)))
}

/// The mass in the plane.
///
/// * `lumping` - share of it that is lumped at the nodes
pub(super) fn plane_mass(flat: &Flat<'_>, input: &Input<'_>, lumping: f64) -> Result<DMatrix<f64>, ElementError> {
    let [per_area, moment, rotary] = mass_of(input)?;
    let nodes = flat.n_nodes();
    let mut m = DMatrix::zeros(DOFS * nodes, DOFS * nodes);
    for (xi, weight) in (flat.plane.rules[2])() {
        let at = flat.local(xi)?;
        let area = weight * at.det;
        for i in 0..nodes {
            for d in 0..3 {
                m[(DOFS * i + d, DOFS * i + d)] += lumping * area * per_area * at.n[i];
            }
            for j in 0..nodes {
                let both = (1.0 - lumping) * area * at.n[i] * at.n[j];
                for d in 0..3 {
                    m[(DOFS * i + d, DOFS * j + d)] += per_area * both;
                }
                for d in 3..5 {
                    m[(DOFS * i + d, DOFS * j + d)] += rotary * both;
                }
                // u + z θy and v - z θx.
                for (along, about, sign) in [(0, 4, 1.0), (1, 3, -1.0)] {
                    m[(DOFS * i + along, DOFS * j + about)] += sign * moment * both;
                    m[(DOFS * i + about, DOFS * j + along)] += sign * moment * both;
                }
            }
        }
    }
    Ok(m)
}

/// The point of the surface through the nodes, by the functions of the corners, that is nearest to a place: displacements and rotations are
/// those of the nodes by the same functions.
pub(super) fn nearest(plane: &'static Plane, input: &Input<'_>, place: Vector3) -> Result<PointWithin, ElementError> {
    let points = input.points;
    let n = points.len();
    let of = |weights: &[f64]| -> Vector3 {
        std::array::from_fn(|i| weights.iter().zip(points).map(|(w, p)| w * p[i]).sum())
    };
    let is_inside = |[x, y]: [f64; 2]| {
        const EDGE: f64 = 1.0 + 1e-9;
        if n == 4 { x.abs() <= EDGE && y.abs() <= EDGE } else { x >= 1.0 - EDGE && y >= 1.0 - EDGE && x + y <= EDGE }
    };
    let mut xi = if n == 4 { [0.0; 2] } else { [1.0 / 3.0; 2] };
    // A plane one is there after the first step, a warped one after a few.
    for _ in 0..20 {
        let (weights, slopes) = (plane.corner)(xi);
        let miss = minus(place, of(&weights[..n]));
        let tangent = |k: usize| of(&slopes[..n].iter().map(|s| s[k]).collect::<Vec<_>>());
        let [a, b] = [tangent(0), tangent(1)];
        let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
        let det = aa * bb - ab * ab;
        if det.is_nan() || det <= 1e-12 * aa * bb {
            return Err(ElementError::Inverted);
        }
        let (ma, mb) = (dot(a, miss), dot(b, miss));
        let step = [(bb * ma - ab * mb) / det, (aa * mb - ab * ma) / det];
        xi = [0, 1].map(|k: usize| (xi[k] + step[k]).clamp(-10.0, 10.0));
        if step[0].abs().max(step[1].abs()) < 1e-13 {
            break;
        }
    }
    let mut weights = (plane.corner)(xi).0[..n].to_vec();
    if !is_inside(xi) {
        let on_edge = |i: usize| {
            let j = (i + 1) % n;
            let along = minus(points[j], points[i]);
            let t = (dot(minus(place, points[i]), along) / dot(along, along)).clamp(0.0, 1.0);
            let mut weights = vec![0.0; n];
            weights[i] += 1.0 - t;
            weights[j] += t;
            let miss = minus(place, of(&weights));
            (dot(miss, miss), weights)
        };
        let nearest = (0..n).map(on_edge).min_by(|a, b| a.0.total_cmp(&b.0));
        weights = nearest.map_or(weights, |(_, w)| w);
    }
    let row = |d: usize| (0..DOFS * n).map(|k| if k % DOFS == d { weights[k / DOFS] } else { 0.0 }).collect();
    Ok(PointWithin { at: of(&weights), rows: std::array::from_fn(row) })
}
