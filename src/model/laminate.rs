//! A strip of plies as a beam: classical lamination theory with free edges.
//!
//! ```text
//!   [N; M] = [A B; B D] [ε; κ]        ε = (εx, εy, γxy) of the middle, κ = (κx, κy, κxy) = (-w,xx, -w,yy, -2 w,xy)
//!   free: Ny = Nxy = My = 0           condensed onto εx, κx, κxy:  R = K_rr - K_rf K_ff⁻¹ K_fr
//!   bending κx = ry',  twist κxy = -2 rx'
//! ```
//!
//! Over the width b this is `EA = b R11`, `EIy = b R22`, `GJ = 4 b R33`, `K = -2 b R23` about the middle; the nodes are at the neutral axis,
//! z_n = R12/R11, where stretching and bending do not couple. In the plane of the strip `EIz = R11 b³/12`.
//!
//! The edges of a strip of finite width add to the compliance of twist what they add to that of a rectangle, `G13 = G12` being assumed:
//! exact for plies along x, otherwise a correction of a correction of the order of thickness/width.
//!
//! Sources: R. M. Jones, Mechanics of Composite Materials, Taylor & Francis 1999, chapter 4; J. M. Whitney, Structural Analysis of Laminated
//! Anisotropic Plates, Technomic 1987, on beams; T. A. Weisshaar, B. L. Foist, J. Aircraft 22 (1985) 141-147, for the signs.

use nalgebra::{Matrix3, Matrix6};

/// A ply: elastic constants in Pa, density in kg/m³, angle from x towards y in rad, thickness in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ply {
    /// Young's modulus along the fibres, Pa.
    pub e1: f64,
    /// Young's modulus across the fibres, Pa.
    pub e2: f64,
    /// Shear modulus in the plane, Pa.
    pub g12: f64,
    /// Poisson's ratio of a pull along the fibres.
    pub nu12: f64,
    /// Transverse shear modulus along the fibres, which a strip does not feel, Pa.
    pub g13: f64,
    /// Transverse shear modulus across the fibres, which a strip does not feel, Pa.
    pub g23: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// From x towards y, rad.
    pub angle: f64,
    /// Thickness, m.
    pub thickness: f64,
}

/// A strip about its neutral axis, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct Strip {
    pub(in crate::model) ea: f64,
    pub(in crate::model) eiy: f64,
    pub(in crate::model) eiz: f64,
    pub(in crate::model) gj: f64,
    /// Between curvature about y and twist rate.
    pub(in crate::model) bend_twist_y: f64,
    pub(in crate::model) mass_per_length: f64,
    /// About the mass axis.
    pub(in crate::model) polar_inertia_per_length: f64,
    /// z of the mass axis from the neutral axis.
    pub(in crate::model) mass_offset_z: f64,
}

/// A coupling of extension and twist above this share of what it couples is one.
const COUPLED: f64 = 1e-6;

/// The strip of plies from small z to large z.
///
/// # Errors
/// Plies that couple extension with twist, which no property of a beam expresses.
pub(in crate::model) fn strip(width: f64, plies: &[Ply]) -> Result<Strip, String> {
    let total: f64 = plies.iter().map(|p| p.thickness).sum();
    if width <= total {
        return Err(
            "it is thicker than wide, and a laminate is a flat strip; give `EA`, `EIy`, `EIz` and `GJ` instead"
                .to_string(),
        );
    }
    let (abd, [mass, first, second]) = sums(plies);
    let mut r = condensed(&abd).ok_or("its stiffness is not positive")?;
    // What the edges of a rectangle of this twisting stiffness give.
    let slenderness = total / width;
    let edges = 1.0 - 0.63 * slenderness * (1.0 - slenderness.powi(4) / 12.0);
    let mut compliance = r.try_inverse().ok_or("its stiffness is not positive")?;
    compliance[(2, 2)] += (1.0 / edges - 1.0) / abd[(5, 5)];
    let plane = r[(0, 0)];
    r = compliance.try_inverse().ok_or("its stiffness is not positive")?;
    if r[(0, 2)].powi(2) > COUPLED * r[(0, 0)] * r[(2, 2)] {
        return Err("its plies couple extension with twist, which a beam cannot express; use a lay-up that is symmetric to its middle".to_string());
    }
    let neutral = r[(0, 1)] / r[(0, 0)];
    let centre = if mass > 0.0 { first / mass } else { neutral };
    let about_centre = if mass > 0.0 { second - first * first / mass } else { 0.0 };
    Ok(Strip {
        ea: width * r[(0, 0)],
        eiy: width * (r[(1, 1)] - r[(0, 1)] * neutral),
        eiz: plane * width.powi(3) / 12.0,
        gj: 4.0 * width * r[(2, 2)],
        bend_twist_y: -2.0 * width * (r[(1, 2)] - r[(0, 2)] * neutral),
        mass_per_length: width * mass,
        polar_inertia_per_length: width * (mass * width * width / 12.0 + about_centre),
        mass_offset_z: centre - neutral,
    })
}

/// [A B; B D] about the middle, and ∫ρ, ∫ρz, ∫ρz² over the thickness.
pub fn sums(plies: &[Ply]) -> (Matrix6<f64>, [f64; 3]) {
    let mut abd = Matrix6::<f64>::zeros();
    let mut mass = [0.0; 3];
    let mut low = -0.5 * plies.iter().map(|p| p.thickness).sum::<f64>();
    for ply in plies {
        let high = low + ply.thickness;
        let q = ply.stiffness();
        let moments = [high - low, (high * high - low * low) / 2.0, (high.powi(3) - low.powi(3)) / 3.0];
        for i in 0..3 {
            for j in 0..3 {
                abd[(i, j)] += q[(i, j)] * moments[0];
                abd[(i, j + 3)] += q[(i, j)] * moments[1];
                abd[(i + 3, j)] += q[(i, j)] * moments[1];
                abd[(i + 3, j + 3)] += q[(i, j)] * moments[2];
            }
        }
        for (sum, moment) in mass.iter_mut().zip(moments) {
            *sum += ply.density * moment;
        }
        low = high;
    }
    (abd, mass)
}

impl Ply {
    /// Reduced stiffness in the axes of the laminate: σ = Q̄ (εx, εy, γxy).
    pub(crate) fn stiffness(&self) -> Matrix3<f64> {
        let one = 1.0 - self.nu12 * self.nu12 * self.e2 / self.e1;
        let (q11, q22, q12, q66) = (self.e1 / one, self.e2 / one, self.nu12 * self.e2 / one, self.g12);
        let (s, c) = self.angle.sin_cos();
        let (s2, c2, sc) = (s * s, c * c, s * c);
        let (a, b) = (q11 - q12 - 2.0 * q66, q22 - q12 - 2.0 * q66);
        let xx = q11 * c2 * c2 + 2.0 * (q12 + 2.0 * q66) * s2 * c2 + q22 * s2 * s2;
        let yy = q11 * s2 * s2 + 2.0 * (q12 + 2.0 * q66) * s2 * c2 + q22 * c2 * c2;
        let xy = (q11 + q22 - 4.0 * q66) * s2 * c2 + q12 * (s2 * s2 + c2 * c2);
        let ss = (q11 + q22 - 2.0 * q12 - 2.0 * q66) * s2 * c2 + q66 * (s2 * s2 + c2 * c2);
        let (xs, ys) = (sc * (a * c2 - b * s2), sc * (a * s2 - b * c2));
        Matrix3::new(xx, xy, xs, xy, yy, ys, xs, ys, ss)
    }
}

/// The stiffness of εx, κx, κxy with no force in the others.
fn condensed(abd: &Matrix6<f64>) -> Option<Matrix3<f64>> {
    const KEPT: [usize; 3] = [0, 3, 5];
    const FREE: [usize; 3] = [1, 2, 4];
    let block = |rows: [usize; 3], columns: [usize; 3]| Matrix3::from_fn(|i, j| abd[(rows[i], columns[j])]);
    let free = block(FREE, FREE).try_inverse()?;
    Some(block(KEPT, KEPT) - block(KEPT, FREE) * free * block(FREE, KEPT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    /// Of carbon and epoxy.
    fn ply(degrees: f64, thickness: f64) -> Ply {
        Ply {
            e1: 129e9,
            e2: 9.4e9,
            g12: 5.16e9,
            nu12: 0.3,
            g13: 5.16e9,
            g23: 5.16e9,
            density: 1550.0,
            angle: degrees.to_radians(),
            thickness,
        }
    }

    fn plies(degrees: &[f64]) -> Vec<Ply> {
        degrees.iter().map(|d| ply(*d, 0.134e-3)).collect()
    }

    #[track_caller]
    fn near(own: f64, exact: f64, share: f64) {
        assert!((own - exact).abs() <= share * exact.abs(), "{own} beside {exact}");
    }

    /// Plies along x are a rectangle of E1 and G12, however many; plies across it one of E2.
    #[test]
    fn plies_along_or_across_are_a_rectangle() {
        let (b, h) = (30e-3_f64, 6.0 * 0.134e-3);
        let r = h / b;
        let j = b * h.powi(3) * (1.0 / 3.0 - 0.21 * r * (1.0 - r.powi(4) / 12.0));
        for (degrees, e) in [(0.0, 129e9), (90.0, 9.4e9)] {
            let s = strip(b, &plies(&[degrees; 6])).unwrap();
            near(s.ea, e * b * h, 1e-12);
            near(s.eiy, e * b * h.powi(3) / 12.0, 1e-12);
            near(s.eiz, e * h * b.powi(3) / 12.0, 1e-12);
            near(s.gj, 5.16e9 * j, 1e-12);
            near(s.mass_per_length, 1550.0 * b * h, 1e-12);
            near(s.polar_inertia_per_length, 1550.0 * b * h * (b * b + h * h) / 12.0, 1e-12);
            assert!(s.bend_twist_y.abs() < 1e-9 * s.gj && s.mass_offset_z.abs() < 1e-12 * h, "{s:?}");
        }
    }

    /// Compliance of a material off its axes, 1/Ex, η = S16/S11 and 1/Gxy (Jones, equations 2.97).
    fn off_axis(theta: f64) -> [f64; 3] {
        let m = ply(0.0, 1.0);
        let (s, c) = theta.sin_cos();
        let (a, b, d, n) = (1.0 / m.e1, 1.0 / m.e2, 1.0 / m.g12, m.nu12 / m.e1);
        let s11 = c.powi(4) * a + (d - 2.0 * n) * s * s * c * c + s.powi(4) * b;
        let s16 = (2.0 * a + 2.0 * n - d) * s * c.powi(3) - (2.0 * b + 2.0 * n - d) * s.powi(3) * c;
        let s66 = 2.0 * (2.0 * a + 2.0 * b + 4.0 * n - d) * s * s * c * c + d * (s.powi(4) + c.powi(4));
        [s11, s16, s66]
    }

    /// Plies all at θ: with free edges εx = S11 σ, so that the extension is by Ex; a bending moment with no torque bends the strip by Ex as well and
    /// twists it by S16: ry' = 12 S11 M/(b h³), rx' = -6 S16 M/(b h³). Without the edges, so of a strip a hundred thousand times as wide as thick.
    #[test]
    fn plies_all_at_an_angle_bend_and_twist_by_their_compliance() {
        for degrees in [15.0, 30.0, 45.0, -60.0] {
            let [s11, s16, s66] = off_axis(f64::to_radians(degrees));
            let (b, h) = (80.4_f64, 6.0 * 0.134e-3);
            let s = strip(b, &plies(&[degrees; 6])).unwrap();
            near(s.ea, b * h / s11, 1e-9);
            near(s.eiz, h * b.powi(3) / 12.0 / s11, 1e-9);
            let (eiy, gj, k) = (s.eiy, s.gj, s.bend_twist_y);
            let determinant = eiy * gj - k * k;
            let i = b * h.powi(3) / 12.0;
            near(gj / determinant, s11 / i, 2e-5);
            near(-k / determinant, -0.5 * s16 / i, 2e-5);
            near(eiy / determinant, 0.25 * s66 / i, 2e-5);
        }
    }

    /// Fibres turned from x towards +y: a strip that is bent up (ry' below zero) turns about -x, its edge at +y stays lower.
    #[test]
    fn the_sign_of_the_coupling_is_that_of_the_fibres() {
        let s = strip(30e-3, &plies(&[30.0; 6])).unwrap();
        assert!(s.bend_twist_y < 0.0);
        near(strip(30e-3, &plies(&[-30.0; 6])).unwrap().bend_twist_y, -s.bend_twist_y, 1e-12);
        // Balanced and symmetric: coupled still by the outer plies, and less than by all.
        let balanced = strip(30e-3, &plies(&[30.0, -30.0, -30.0, 30.0])).unwrap();
        let all = strip(30e-3, &plies(&[30.0; 4])).unwrap();
        let share = |s: &Strip| s.bend_twist_y.powi(2) / (s.eiy * s.gj);
        assert!(share(&balanced) > 0.01 && share(&balanced) < share(&all) && share(&all) < 1.0);
        assert!(balanced.bend_twist_y < 0.0, "the outer plies are at +30 degrees");
    }

    /// The energy of every motion that the strip is free to choose is least: no lateral strain whatever makes it smaller than the rigidities say.
    #[test]
    fn free_edges_give_the_least_energy() {
        let lay_up = plies(&[20.0, -50.0, 70.0, 70.0, -50.0, 20.0]);
        let b = 50.0;
        let s = strip(b, &lay_up).unwrap();
        let (curvature, twist) = (0.7, 0.4);
        let beam = 0.5 * (s.eiy * curvature * curvature + s.gj * twist * twist) + s.bend_twist_y * curvature * twist;
        let energy = |lateral: f64, stretch: f64, shear: f64| {
            let mut z = -3.0 * 0.134e-3;
            let mut sum = 0.0;
            for p in &lay_up {
                let q = p.stiffness();
                // Simpson's rule is exact for squares.
                for (at, weight) in [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)] {
                    let h = z + at * p.thickness;
                    let strain = nalgebra::Vector3::new(h * curvature, stretch + h * lateral, shear - 2.0 * h * twist);
                    sum += 0.5 * b * weight / 6.0 * p.thickness * strain.dot(&(q * strain));
                }
                z += p.thickness;
            }
            sum
        };
        let mut at = [0.0_f64; 3];
        let mut step = 0.5;
        let of = |a: [f64; 3]| energy(a[0], a[1] * 1e-3, a[2] * 1e-3);
        while step > 1e-7 {
            let tries = (0..3).flat_map(|i| [-step, step].map(|d| (i, d)));
            let better = tries
                .map(|(i, d)| {
                    let mut a = at;
                    a[i] += d;
                    a
                })
                .find(|a| of(*a) < of(at));
            match better {
                Some(a) => at = a,
                None => step *= 0.5,
            }
        }
        near(beam, of(at), 2e-5);
    }

    /// Two metals: their composite beam by transformed areas, the neutral axis in the stiffer, the mass axis in the heavier.
    #[test]
    fn two_metals_are_a_composite_beam() {
        let metal = |e: f64, density: f64, thickness: f64| {
            // Poisson's ratio 0, so that beam and plate are one.
            Ply { e1: e, e2: e, g12: e / 2.0, nu12: 0.0, g13: e, g23: e, density, angle: 0.3, thickness }
        };
        let (b, t1, t2) = (40e-3, 2e-3, 1e-3);
        let s = strip(b, &[metal(70e9, 2700.0, t1), metal(210e9, 7850.0, t2)]).unwrap();
        let (a1, a2) = (70e9 * t1, 210e9 * t2);
        let neutral = (a1 * 1e-3 + a2 * 2.5e-3) / (a1 + a2);
        near(s.ea, b * (a1 + a2), 1e-12);
        let about = |a: f64, t: f64, at: f64| a * (t * t / 12.0 + (at - neutral).powi(2));
        near(s.eiy, b * (about(a1, t1, 1e-3) + about(a2, t2, 2.5e-3)), 1e-12);
        let (m1, m2) = (2700.0 * t1, 7850.0 * t2);
        near(s.mass_offset_z, (m1 * 1e-3 + m2 * 2.5e-3) / (m1 + m2) - neutral, 1e-9);
        assert!(s.bend_twist_y.abs() < 1e-9 * s.gj);
    }

    /// What a beam cannot express is refused: extension that twists. What is no strip is refused too.
    #[test]
    fn what_is_no_beam_is_refused() {
        let refused = strip(30e-3, &plies(&[30.0, -30.0])).unwrap_err();
        assert!(refused.contains("extension with twist"), "{refused}");
        assert!(
            strip(30e-3, &plies(&[0.0, 90.0])).is_ok(),
            "bending that stretches is a neutral axis beside the middle"
        );
        assert!(strip(30e-3, &plies(&[30.0, -30.0, -30.0, 30.0])).is_ok());
        assert!(strip(1e-3, &[ply(0.0, 2e-3)]).unwrap_err().contains("thicker than wide"));
    }

    #[test]
    fn a_quarter_turn_exchanges_the_axes_of_a_ply() {
        let (q, turned) = (ply(0.0, 1.0).stiffness(), Ply { angle: FRAC_PI_2, ..ply(0.0, 1.0) }.stiffness());
        near(turned[(0, 0)], q[(1, 1)], 1e-12);
        near(turned[(1, 1)], q[(0, 0)], 1e-12);
        near(turned[(2, 2)], q[(2, 2)], 1e-12);
        let diagonal = Ply { angle: FRAC_PI_4, ..ply(0.0, 1.0) }.stiffness();
        near(diagonal[(0, 0)], diagonal[(1, 1)], 1e-12);
        assert!(diagonal[(0, 2)] > 0.0);
    }
}
