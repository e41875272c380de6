//! Cross-sections of flat walls that enclose no cell: I, channel, angle, tee.
//!
//! ```text
//!        i               channel            angle              tee
//!   =========            =======            |              =========
//!       |        z       |                  |                  |
//!       |        |       |                  |                  |
//!     =====      +--- y  =======            |_______           |
//! ```
//!
//! Area and moments are those of the rectangles and of the fillets in their corners, exactly. The torsion constant is that of the walls with
//! what their free ends lose and their junctions gain, `J = Σ b t³ (1/3 - ends) + Σ α D⁴`, D the diameter of the largest circle in a
//! junction: within 2 % of Saint-Venant's where flanges are at least five times as wide as thick.
//!
//! Sources: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, McGraw-Hill 2002, table 10.1; I. A. El Darwish, B. G. Johnston,
//! Torsion of structural shapes, J. Struct. Div. ASCE 91 (1965) 203-227, whose α of a tee is the one that the tables of European sections are
//! computed with; shear centres: V. Z. Vlasov, Thin-Walled Elastic Beams, 1961.

use std::f64::consts::{FRAC_PI_4, PI};

/// A cross-section about its centroid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct Profile {
    /// m².
    pub(in crate::model) area: f64,
    /// ∫ z² dA and ∫ y² dA about the principal axes, m⁴.
    pub(in crate::model) iy: f64,
    pub(in crate::model) iz: f64,
    /// m⁴.
    pub(in crate::model) j: f64,
    /// (y, z) of the shear centre from the centroid along the principal axes, m.
    pub(in crate::model) shear_centre: [f64; 2],
    /// From the axes of the shape to the principal axes, about x, rad; at most π/4.
    pub(in crate::model) turn: f64,
}

/// Sizes of an I: height in all, then width and thickness of the flange at the top, of the one at the bottom, the web, and the fillets, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct ISizes {
    pub(in crate::model) height: f64,
    pub(in crate::model) top: [f64; 2],
    pub(in crate::model) bottom: [f64; 2],
    pub(in crate::model) web: f64,
    pub(in crate::model) fillet: f64,
}

/// Sizes of a channel or a tee: height and width in all, web, flange, fillets, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct FlangedSizes {
    pub(in crate::model) height: f64,
    pub(in crate::model) width: f64,
    pub(in crate::model) web: f64,
    pub(in crate::model) flange: f64,
    pub(in crate::model) fillet: f64,
}

/// An I or H: web along z, flanges along y.
pub(in crate::model) fn i_section(s: ISizes) -> Result<Profile, String> {
    let ISizes { height, top: [bt, tt], bottom: [bb, tb], web, fillet: r } = s;
    let clear = height - tt - tb;
    fits(clear > 0.0, "the flanges leave no web: `height` must be above the thickness of both")?;
    fits(web <= bt.min(bb), "the web is thicker than a flange is wide")?;
    fits(2.0 * r <= clear && web + 2.0 * r <= bt.min(bb), "the fillets do not fit between web and flanges")?;
    let mut m = Moments::default();
    m.rectangle([-0.5 * bb, 0.5 * bb], [0.0, tb]);
    m.rectangle([-0.5 * web, 0.5 * web], [tb, height - tt]);
    m.rectangle([-0.5 * bt, 0.5 * bt], [height - tt, height]);
    for side in [-1.0, 1.0] {
        m.fillet([side * 0.5 * web, tb], [side, 1.0], r);
        m.fillet([side * 0.5 * web, height - tt], [side, -1.0], r);
    }
    let j =
        both_ends(bt, tt) + both_ends(bb, tb) + clear * web.powi(3) / 3.0 + across(tt, web, r)? + across(tb, web, r)?;
    // Each flange takes its share of a force along y by its stiffness.
    let [it, ib] = [tt * bt.powi(3), tb * bb.powi(3)];
    let centre = (it * (height - 0.5 * tt) + ib * 0.5 * tb) / (it + ib);
    Ok(m.profile(j, [0.0, centre]))
}

/// A channel: web along z, at the side of small y, flanges along y.
pub(in crate::model) fn channel(s: FlangedSizes) -> Result<Profile, String> {
    let FlangedSizes { height, width, web, flange, fillet: r } = s;
    let (clear, overhang) = (height - 2.0 * flange, width - web);
    fits(clear > 0.0, "the flanges leave no web: `height` must be above twice their thickness")?;
    fits(overhang > 0.0, "the web leaves no flange: `width` must be above its thickness")?;
    fits(2.0 * r <= clear && r <= overhang, "the fillets do not fit between web and flanges")?;
    let mut m = Moments::default();
    m.rectangle([0.0, web], [0.0, height]);
    for (z, up) in [([0.0, flange], 1.0), ([height - flange, height], -1.0)] {
        m.rectangle([web, width], z);
        m.fillet([web, if up > 0.0 { z[1] } else { z[0] }], [1.0, up], r);
    }
    // Two angles, whose walls at the middle of the web go on.
    let walls = if flange >= web {
        2.0 * both_ends(width, flange) + clear * web.powi(3) / 3.0
    } else {
        both_ends(height, web) + 2.0 * one_end(overhang, flange)
    };
    let j = walls + 2.0 * corner(flange, web, r)?;
    let (b, h) = (width - 0.5 * web, height - flange);
    let behind = 3.0 * b * b * flange / (h * web + 6.0 * b * flange);
    Ok(m.profile(j, [0.5 * web - behind, 0.5 * height]))
}

/// A tee: web along z, flange along y at the top.
pub(in crate::model) fn tee(s: FlangedSizes) -> Result<Profile, String> {
    let FlangedSizes { height, width, web, flange, fillet: r } = s;
    let clear = height - flange;
    fits(clear > 0.0, "the flange leaves no web: `height` must be above its thickness")?;
    fits(web <= width, "the web is thicker than the flange is wide")?;
    fits(r <= clear && web + 2.0 * r <= width, "the fillets do not fit between web and flange")?;
    let mut m = Moments::default();
    m.rectangle([-0.5 * width, 0.5 * width], [clear, height]);
    m.rectangle([-0.5 * web, 0.5 * web], [0.0, clear]);
    for side in [-1.0, 1.0] {
        m.fillet([side * 0.5 * web, clear], [side, -1.0], r);
    }
    let j = both_ends(width, flange) + one_end(clear, web) + across(flange, web, r)?;
    Ok(m.profile(j, [0.0, height - 0.5 * flange]))
}

/// An angle: one leg along y, one along z, the corner at small y and z.
///
/// * `width`, `height` - outer lengths of the legs along y and along z
pub(in crate::model) fn angle(width: f64, height: f64, thickness: f64, fillet: f64) -> Result<Profile, String> {
    let t = thickness;
    let (short, long) = (width.min(height), width.max(height));
    fits(t < short, "the legs are thicker than long")?;
    fits(fillet <= short - t, "the fillet does not fit between the legs")?;
    let mut m = Moments::default();
    m.rectangle([0.0, t], [0.0, height]);
    m.rectangle([t, width], [0.0, t]);
    m.fillet([t, t], [1.0, 1.0], fillet);
    let j = both_ends(long, t) + one_end(short - t, t) + corner(t, t, fillet)?;
    Ok(m.profile(j, [0.5 * t, 0.5 * t]))
}

fn fits(is: bool, else_why: &str) -> Result<(), String> {
    if is { Ok(()) } else { Err(else_why.to_string()) }
}

/// Torsion constant of a wall with both ends free, which is a rectangle; error below 0.01 %: Roark's Formulas for Stress and Strain,
/// table 10.7.
pub(in crate::model) fn both_ends(length: f64, thickness: f64) -> f64 {
    let (long, short) = (length.max(thickness), length.min(thickness));
    let r = short / long;
    long * short.powi(3) * (1.0 / 3.0 - 0.21 * r * (1.0 - r.powi(4) / 12.0))
}

/// The same with one end free, the other in a junction.
fn one_end(length: f64, thickness: f64) -> f64 {
    // Half of a wall twice as long.
    0.5 * both_ends(2.0 * length, thickness)
}

/// What a wall that meets the middle of another one adds: α D⁴.
fn across(flange: f64, web: f64, r: f64) -> Result<f64, String> {
    check(flange, web, r)?;
    let d = ((flange + r).powi(2) + web * (r + 0.25 * web)) / (2.0 * r + flange);
    let alpha = flange.min(web) / flange.max(web) * (0.145 + 0.1 * r / flange);
    Ok(alpha * d.powi(4))
}

/// What the corner of two walls adds: α D⁴.
fn corner(one: f64, other: f64, r: f64) -> Result<f64, String> {
    let (thick, thin) = (one.max(other), one.min(other));
    check(thin, thick, r)?;
    let d = 2.0 * (thin + thick + 3.0 * r - (2.0 * (2.0 * r + thick) * (2.0 * r + thin)).sqrt());
    Ok(thin / thick * (0.07 + 0.076 * r / thick) * d.powi(4))
}

/// The circle in a junction touches the far side of `wall`, which must not be so thin that the circle falls out of the `other` wall.
fn check(wall: f64, other: f64, r: f64) -> Result<(), String> {
    if other < 2.0 * (wall + r) {
        return Ok(());
    }
    Err("one wall is twice as thick as the other or more: there is no formula for the torsion of such a section; give `A`, `Iy`, `Iz` and `J`".to_string())
}

/// ∫ of 1, y, z, y², z², yz over an area.
#[derive(Debug, Default)]
struct Moments {
    area: f64,
    y: f64,
    z: f64,
    yy: f64,
    zz: f64,
    yz: f64,
}

impl Moments {
    /// An area with its centroid and its moments about that: ∫ y², ∫ z², ∫ yz.
    fn add(&mut self, area: f64, [y, z]: [f64; 2], [yy, zz, yz]: [f64; 3]) {
        self.area += area;
        self.y += area * y;
        self.z += area * z;
        self.yy += yy + area * y * y;
        self.zz += zz + area * z * z;
        self.yz += yz + area * y * z;
    }

    fn rectangle(&mut self, y: [f64; 2], z: [f64; 2]) {
        let (b, h) = (y[1] - y[0], z[1] - z[0]);
        let area = b * h;
        self.add(area, [0.5 * (y[0] + y[1]), 0.5 * (z[0] + z[1])], [area * b * b / 12.0, area * h * h / 12.0, 0.0]);
    }

    /// The fillet in a corner that is open towards `out`: a square less a quarter of a circle.
    fn fillet(&mut self, corner: [f64; 2], out: [f64; 2], r: f64) {
        let area = (1.0 - FRAC_PI_4) * r * r;
        // From the centre of the circle.
        let away = r / (6.0 * (1.0 - FRAC_PI_4));
        let own = r.powi(4) * (1.0 / 3.0 - PI / 16.0) - area * away * away;
        let product = out[0] * out[1] * (0.125 * r.powi(4) - area * away * away);
        let at = [0, 1].map(|i| corner[i] + out[i] * (r - away));
        self.add(area, at, [own, own, product]);
    }

    fn profile(&self, j: f64, shear_centre: [f64; 2]) -> Profile {
        let (area, y, z) = (self.area, self.y / self.area, self.z / self.area);
        let (yy, zz) = (self.yy - area * y * y, self.zz - area * z * z);
        let yz = self.yz - area * y * z;
        let from = [shear_centre[0] - y, shear_centre[1] - z];
        // Rounding is not a product of inertia.
        if yz.abs() < 1e-12 * yy.max(zz) {
            return Profile { area, iy: zz, iz: yy, j, shear_centre: from, turn: 0.0 };
        }
        // The smaller of the two turns: tan 2α = 2 Iyz/(Iz - Iy).
        let side = if zz > yy * (1.0 + 1e-9) { -1.0 } else { 1.0 };
        let turn = 0.5 * (side * 2.0 * yz).atan2(side * (yy - zz));
        let (mean, half) = (0.5 * (yy + zz), (0.5 * (yy - zz)).hypot(yz));
        let (sin, cos) = turn.sin_cos();
        let shear_centre = [from[0] * cos + from[1] * sin, from[1] * cos - from[0] * sin];
        Profile { area, iy: mean - side * half, iz: mean + side * half, j, shear_centre, turn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::SQRT_2;

    fn i(height: f64, width: f64, web: f64, flange: f64, fillet: f64) -> Profile {
        i_section(ISizes { height, top: [width, flange], bottom: [width, flange], web, fillet }).unwrap()
    }

    fn flanged(height: f64, width: f64, web: f64, flange: f64, fillet: f64) -> FlangedSizes {
        FlangedSizes { height, width, web, flange, fillet }
    }

    /// All that a table states, in cm, agrees to the share of it.
    #[track_caller]
    fn agrees(name: &str, own: &[f64], table: &[f64], share: f64) {
        for (k, (own, table)) in own.iter().zip(table).enumerate() {
            assert!((own / table - 1.0).abs() < share, "{name}, column {k}: {own} beside {table}");
        }
    }

    fn in_cm(p: &Profile) -> [f64; 4] {
        [p.area, p.iy, p.iz, p.j]
    }

    /// EN 10365: A, Iy, Iz, It of rolled sections with their fillets, to the digits of the tables; the flanges of UPE are parallel. It of a
    /// channel, which the tables compute in another way, within 4 %.
    #[test]
    fn rolled_sections_are_those_of_the_tables() {
        agrees("IPE 200", &in_cm(&i(20.0, 10.0, 0.56, 0.85, 1.2)), &[28.48, 1943.0, 142.4, 6.98], 5e-4);
        agrees("HEA 200", &in_cm(&i(19.0, 20.0, 0.65, 1.0, 1.8)), &[53.83, 3692.0, 1336.0, 20.98], 5e-4);
        agrees("HEB 300", &in_cm(&i(30.0, 30.0, 1.1, 1.9, 2.7)), &[149.1, 25170.0, 8563.0, 185.0], 5e-4);
        let upe = channel(flanged(20.0, 8.0, 0.6, 1.1, 1.3)).unwrap();
        agrees("UPE 200", &in_cm(&upe)[..3], &[29.0, 1909.0, 187.3], 5e-4);
        agrees("UPE 200", &[upe.j, -upe.shear_centre[0]], &[8.88, 5.41], 0.04);
        // ym of the table, from the centroid to the shear centre, which is behind the web.
        assert!((upe.shear_centre[0] + 5.41).abs() < 5e-3 && upe.shear_centre[1].abs() < 1e-12, "{upe:?}");
    }

    /// Without fillets an IPE 200 has 4 % less area, 5 % less Iy and 27 % less torsion constant: what is left out by leaving out `fillet`.
    #[test]
    fn fillets_matter_most_in_torsion() {
        let sharp = i(20.0, 10.0, 0.56, 0.85, 0.0);
        agrees("IPE 200", &in_cm(&sharp), &[28.48 * 0.957, 1943.0 * 0.950, 142.4 * 0.997, 6.98 * 0.730], 2e-3);
        let walls = (2.0 * 10.0 * 0.85_f64.powi(3) + 18.3 * 0.56_f64.powi(3)) / 3.0;
        assert!((sharp.j / walls - 1.0).abs() < 0.02, "{} {walls}", sharp.j);
    }

    /// EN 10056: equal and unequal angles. The toes, which have half the radius of the fillet, are taken off by hand in the area; their share
    /// of the moments about the strong axis, where they are farthest out, is 2.5 %.
    #[test]
    fn angles_are_about_their_principal_axes() {
        let toes = 2.0 * (1.0 - FRAC_PI_4) * 0.36;
        let equal = angle(10.0, 10.0, 1.0, 1.2).unwrap();
        agrees("L 100x100x10", &[equal.area - toes, equal.iz, equal.iy], &[19.15, 280.0, 73.0], 0.03);
        assert!((equal.turn + FRAC_PI_4).abs() < 1e-12, "{}", equal.turn);
        // From the centroid to the corner of the middle lines, on the axis of symmetry.
        let [y, z] = equal.shear_centre;
        assert!(y.abs() < 1e-12 && (z + SQRT_2 * (2.82 - 0.5)).abs() < 0.04, "{y} {z}");
        let flat = angle(15.0, 10.0, 1.0, 1.2).unwrap();
        agrees("L 150x100x10", &[flat.area - toes, flat.iz, flat.iy], &[24.2, 637.0, 114.0], 0.03);
        assert!((flat.turn.tan() + 0.438).abs() < 5e-3, "{}", flat.turn.tan());
        // Stood up it is its own mirror image about the line between y and z.
        let tall = angle(10.0, 15.0, 1.0, 1.2).unwrap();
        agrees("stood up", &[tall.iy, tall.iz, -tall.turn, tall.j], &[flat.iz, flat.iy, flat.turn, flat.j], 1e-12);
        agrees("stood up", &tall.shear_centre, &[flat.shear_centre[1], flat.shear_centre[0]], 1e-12);
    }

    /// Invariants of an angle of two rectangles, and ∫ y' z' = 0 about the axes that it was turned to, by summation over a grid.
    #[test]
    fn principal_axes_have_no_product_of_inertia() {
        let p = angle(7.0, 4.0, 0.5, 0.0).unwrap();
        let (n, mut sums) = (400, [0.0; 6]);
        let cell = 7.0 / f64::from(n);
        let mut points = Vec::new();
        for a in 0..n {
            for b in 0..n {
                let (y, z) = ((f64::from(a) + 0.5) * cell, (f64::from(b) + 0.5) * cell);
                if z < 4.0 && (y < 0.5 || z < 0.5) {
                    points.push((y, z));
                }
            }
        }
        let count = points.len() as f64;
        let (cy, cz) =
            (points.iter().map(|p| p.0).sum::<f64>() / count, points.iter().map(|p| p.1).sum::<f64>() / count);
        let (sin, cos) = p.turn.sin_cos();
        for (y, z) in points {
            let (y, z) = (y - cy, z - cz);
            let (y, z) = (y * cos + z * sin, z * cos - y * sin);
            for (slot, term) in sums.iter_mut().zip([1.0, z * z, y * y, y * z, 0.0, 0.0]) {
                *slot += term * cell * cell;
            }
        }
        agrees("angle", &[p.area, p.iy, p.iz], &sums[..3], 0.02);
        assert!(sums[3].abs() < 1e-2 * p.iy, "{sums:?}");
        let corner = [0.25 - cy, 0.25 - cz];
        let turned = [corner[0] * cos + corner[1] * sin, corner[1] * cos - corner[0] * sin];
        agrees("corner", &p.shear_centre, &turned, 0.02);
    }

    /// Of slender walls J is Σ b t³/3, and closed forms of the middle lines hold: the shear centre of a channel 3 b² t_f/(h t_w + 6 b t_f)
    /// from its web; of an I in the heavier flange, at its centre for equal ones; of a tee where its walls meet.
    #[test]
    fn slender_walls_are_those_of_the_textbook() {
        let t = 1e-3;
        let c = channel(flanged(2.0 + t, 1.0 + 0.5 * t, t, t, 0.0)).unwrap();
        let centroid = 1.0 / 4.0;
        agrees("channel", &[c.area, c.iy, c.j], &[4.0 * t, t * (8.0 / 12.0 + 2.0), 4.0 * t.powi(3) / 3.0], 2e-3);
        agrees("channel", &[-c.shear_centre[0]], &[centroid + 3.0 / (2.0 + 6.0)], 2e-3);
        let s = ISizes { height: 2.0 + t, top: [1.0, t], bottom: [0.5, t], web: t, fillet: 0.0 };
        let uneven = i_section(s).unwrap();
        let centroid = (2.0 * 1.0 + 1.0 * 2.0) / 3.5;
        agrees("I", &[uneven.shear_centre[1]], &[2.0 / (1.0 + 0.125) - centroid], 5e-3);
        assert!(i(2.0, 1.0, t, t, 0.0).shear_centre.iter().all(|v| v.abs() < 1e-12));
        let p = tee(flanged(1.0 + 0.5 * t, 1.0, t, t, 0.0)).unwrap();
        agrees("tee", &[p.shear_centre[1], p.j], &[0.25, 2.0 * t.powi(3) / 3.0], 4e-3);
        let l = angle(1.0 + 0.5 * t, 1.0 + 0.5 * t, t, 0.0).unwrap();
        // Thin angle: strong axis t a³/3, weak axis t a³/12.
        agrees("angle", &[l.iz, l.iy, l.j], &[t / 3.0, t / 12.0, 2.0 * t.powi(3) / 3.0], 4e-3);
    }

    /// 2 ∫ φ of ∇²φ = -2 inside the walls, φ = 0 on their edges, by differences; at re-entrant corners the error falls with h^(4/3), which
    /// leaves the mean of both grids' limits. In units of cells a tenth as large as the thinnest wall.
    fn torsion(parts: &[[f64; 4]]) -> f64 {
        let of = |h: f64| {
            let inside = |y: f64, z: f64| parts.iter().any(|p| y > p[0] && y < p[1] && z > p[2] && z < p[3]);
            let size = |k: usize| (parts.iter().map(|p| p[k]).fold(0.0, f64::max) / h).round() as usize;
            let (n, w) = (size(1), size(3) + 1);
            let is_free = |i: usize, k: usize| {
                let at = |a: f64, b: f64| inside((i as f64 + a) * h, (k as f64 + b) * h);
                at(0.5, 0.5) && at(-0.5, 0.5) && at(0.5, -0.5) && at(-0.5, -0.5)
            };
            let free: Vec<usize> = (1..n)
                .flat_map(|i| (1..w).map(move |k| (i, k)))
                .filter(|&(i, k)| is_free(i, k))
                .map(|(i, k)| i * w + k)
                .collect();
            let mut phi = vec![0.0; (n + 1) * w];
            for _ in 0..2000 {
                let mut change = 0.0_f64;
                for &c in &free {
                    let step =
                        1.8 * (0.25 * (phi[c - 1] + phi[c + 1] + phi[c - w] + phi[c + w] + 2.0 * h * h) - phi[c]);
                    phi[c] += step;
                    change = change.max(step.abs());
                }
                if change < 1e-8 {
                    break;
                }
            }
            2.0 * h * h * phi.iter().sum::<f64>()
        };
        let (coarse, fine) = (of(0.1), of(0.05));
        fine + (fine - coarse) / (2.0_f64.powf(4.0 / 3.0) - 1.0)
    }

    #[test]
    fn torsion_is_that_of_saint_venant() {
        let s = |height, top, bottom, web| ISizes { height, top, bottom, web, fillet: 0.0 };
        let cases = [
            (
                i_section(s(12.0, [10.0, 1.0], [10.0, 1.0], 1.0)),
                vec![[0.0, 10.0, 0.0, 1.0], [4.5, 5.5, 1.0, 11.0], [0.0, 10.0, 11.0, 12.0]],
            ),
            (
                i_section(s(12.0, [6.0, 1.0], [10.0, 2.0], 1.0)),
                vec![[0.0, 10.0, 0.0, 2.0], [4.5, 5.5, 2.0, 11.0], [2.0, 8.0, 11.0, 12.0]],
            ),
            (
                channel(flanged(12.0, 6.0, 1.0, 1.0, 0.0)),
                vec![[0.0, 1.0, 0.0, 12.0], [1.0, 6.0, 0.0, 1.0], [1.0, 6.0, 11.0, 12.0]],
            ),
            (
                channel(flanged(12.0, 6.0, 1.8, 1.0, 0.0)),
                vec![[0.0, 1.8, 0.0, 12.0], [1.8, 6.0, 0.0, 1.0], [1.8, 6.0, 11.0, 12.0]],
            ),
            (angle(10.0, 6.0, 1.0, 0.0), vec![[0.0, 1.0, 0.0, 6.0], [1.0, 10.0, 0.0, 1.0]]),
            (tee(flanged(10.0, 10.0, 1.0, 2.0, 0.0)), vec![[0.0, 10.0, 8.0, 10.0], [4.5, 5.5, 0.0, 8.0]]),
        ];
        for (k, (profile, parts)) in cases.into_iter().enumerate() {
            let (own, exact) = (profile.unwrap().j, torsion(&parts));
            assert!((own / exact - 1.0).abs() < 0.022, "case {k}: {own} beside {exact}");
        }
    }

    /// A fillet is a square less a quarter of a circle, in whichever corner: moments by summation over a grid.
    #[test]
    fn fillets_are_what_they_are() {
        for out in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let mut m = Moments::default();
            m.fillet([3.0, 2.0], out, 0.5);
            let n = 500;
            let cell = 0.5 / f64::from(n);
            let mut sums = [0.0; 6];
            for a in 0..n {
                for b in 0..n {
                    let (u, v) = ((f64::from(a) + 0.5) * cell, (f64::from(b) + 0.5) * cell);
                    if (u - 0.5).hypot(v - 0.5) > 0.5 {
                        let (y, z) = (3.0 + out[0] * u, 2.0 + out[1] * v);
                        for (slot, term) in sums.iter_mut().zip([1.0, y, z, y * y, z * z, y * z]) {
                            *slot += term * cell * cell;
                        }
                    }
                }
            }
            agrees("fillet", &[m.area, m.y, m.z, m.yy, m.zz, m.yz], &sums, 2e-3);
            // About its own centroid, where a wrong sign of the product would show.
            let own = |yz: f64, y: f64, z: f64, a: f64| yz - y * z / a;
            let (p, q) = (own(m.yz, m.y, m.z, m.area), own(sums[5], sums[1], sums[2], sums[0]));
            assert!((p - q).abs() < 0.05 * q.abs() && q * out[0] * out[1] < 0.0, "{p} {q}");
        }
    }

    #[test]
    fn walls_that_do_not_fit_are_refused() {
        let i = |height, width, web, flange, fillet| {
            i_section(ISizes { height, top: [width, flange], bottom: [width, flange], web, fillet })
        };
        for (refused, what) in [
            (i(2.0, 5.0, 0.5, 1.0, 0.0), "leave no web"),
            (i(20.0, 5.0, 6.0, 4.0, 0.0), "thicker than a flange is wide"),
            (i(20.0, 5.0, 0.5, 1.0, 2.5), "fillets do not fit"),
            (i(20.0, 10.0, 2.0, 1.0, 0.0), "no formula"),
            (channel(flanged(2.0, 5.0, 0.5, 1.0, 0.0)), "leave no web"),
            (channel(flanged(9.0, 0.5, 0.5, 1.0, 0.0)), "leaves no flange"),
            (channel(flanged(9.0, 5.0, 0.5, 1.5, 0.0)), "no formula"),
            (tee(flanged(1.0, 5.0, 0.5, 1.0, 0.0)), "leaves no web"),
            (tee(flanged(5.0, 5.0, 1.0, 1.0, 2.1)), "fillets do not fit"),
            (angle(5.0, 1.0, 1.0, 0.0), "thicker than long"),
            (angle(5.0, 4.0, 1.0, 3.5), "does not fit"),
        ] {
            assert!(refused.as_ref().is_err_and(|e| e.contains(what)), "{what}: {refused:?}");
        }
    }
}
