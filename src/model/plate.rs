//! Plies as a plate: what a unit of area resists and weighs, about the middle of the plies.
//!
//! ```text
//!   [N; M] = [A B; B D] [ε; κ],  [Qx; Qy] = S [γxz; γyz]
//!   A, B, D = Σ ∫ Q̄ (1, z, z²) dz
//!   S⁻¹ = ∫ gᵀ s g dz,  g = diag(fx/Rx, fy/Ry),  fx(z) = ∫ Q̄11 (ζ - zx) dζ,  Rx = ∫ Q̄11 (z - zx)² dz     (y alike, with Q̄22)
//! ```
//!
//! Q̄ is plane stress in the axes of the laminate, s the compliance of transverse shear there, zx the neutral axis of bending about y, g the
//! shear stress of cylindrical bending by a unit force, from equilibrium through the thickness. Of one material this is
//! S = 5/6 G t exactly; of a sandwich nearly the shear of its core.
//!
//! Sources: R. M. Jones, Mechanics of Composite Materials, Taylor & Francis 1999, chapter 4; J. M. Whitney, Shear correction factors for
//! orthotropic laminates under static load, J. Appl. Mech. 40 (1973) 302-304.

use super::laminate::{Ply, sums};
use nalgebra::Matrix2;

/// Names of what a plate has, as properties of a shell, in the order of [`plate`].
pub(super) const PLATE: [&str; 24] = [
    "A11",
    "A12",
    "A16",
    "A22",
    "A26",
    "A66",
    "B11",
    "B12",
    "B16",
    "B22",
    "B26",
    "B66",
    "D11",
    "D12",
    "D16",
    "D22",
    "D26",
    "D66",
    "S55",
    "S45",
    "S44",
    "areal_mass",
    "areal_moment",
    "areal_inertia",
];

/// Rigidities and masses of a unit of area, SI, in the order of [`PLATE`]; NaN where a ply stores no energy.
pub(super) fn plate(plies: &[Ply]) -> [f64; 24] {
    let (abd, [mass, first, second]) = sums(plies);
    let mut out = [0.0; 24];
    for (block, (row, column)) in [(0, 0), (0, 3), (3, 3)].into_iter().enumerate() {
        for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
            out[6 * block + k] = abd[(row + i, column + j)];
        }
    }
    let s = shear(plies, [0, 1].map(|i: usize| abd[(i, 3 + i)] / abd[(i, i)]));
    out[18..].copy_from_slice(&[s[(0, 0)], s[(0, 1)], s[(1, 1)], mass, first, second]);
    out
}

/// S, rows xz and yz.
///
/// * `neutral` - zx and zy, m
fn shear(plies: &[Ply], neutral: [f64; 2]) -> Matrix2<f64> {
    // Of degree four in z within a ply.
    let gauss = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
    let mut low = -0.5 * plies.iter().map(|p| p.thickness).sum::<f64>();
    let (mut so_far, mut rigidity) = ([0.0; 2], [0.0; 2]);
    let mut compliance = Matrix2::<f64>::zeros();
    for ply in plies {
        let q = ply.stiffness();
        let q = [q[(0, 0)], q[(1, 1)]];
        let (s, c) = ply.angle.sin_cos();
        // Compliance turns as stiffness does.
        let [along, across] = [1.0 / ply.g13, 1.0 / ply.g23];
        let mixed = (along - across) * c * s;
        let turned = [[along * c * c + across * s * s, mixed], [mixed, along * s * s + across * c * c]];
        let from = |to: f64| -> [f64; 2] {
            [0, 1].map(|i: usize| so_far[i] + q[i] * ((to - neutral[i]).powi(2) - (low - neutral[i]).powi(2)) / 2.0)
        };
        for (at, weight) in gauss {
            let g = from(low + 0.5 * (1.0 + at) * ply.thickness);
            for i in 0..2 {
                for j in 0..2 {
                    compliance[(i, j)] += weight * ply.thickness * g[i] * turned[i][j] * g[j];
                }
            }
        }
        let high = low + ply.thickness;
        for i in 0..2 {
            rigidity[i] += q[i] * ((high - neutral[i]).powi(3) - (low - neutral[i]).powi(3)) / 3.0;
        }
        so_far = from(high);
        low = high;
    }
    let scaled = Matrix2::from_fn(|i, j| compliance[(i, j)] / (rigidity[i] * rigidity[j]));
    scaled.try_inverse().unwrap_or_else(|| Matrix2::from_element(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ply(angle: f64, thickness: f64) -> Ply {
        let degrees = angle.to_radians();
        Ply { e1: 130e9, e2: 9e9, g12: 5e9, nu12: 0.3, g13: 5e9, g23: 3e9, density: 1600.0, angle: degrees, thickness }
    }

    fn of(plies: &[Ply], name: &str) -> f64 {
        plate(plies)[PLATE.iter().position(|n| *n == name).unwrap()]
    }

    fn near(own: f64, exact: f64, share: f64) {
        assert!((own - exact).abs() <= share * exact.abs(), "{own} beside {exact}");
    }

    /// Cut into layers or not, one material is one plate: D = Q t³/12, and 5/6 of G t in shear, turned with the fibres.
    #[test]
    fn plies_of_one_angle_are_one_plate() {
        for n in [1, 2, 7] {
            let t = 4e-3;
            let plies = vec![ply(30.0, t / f64::from(n)); n as usize];
            let q = plies[0].stiffness();
            near(of(&plies, "A16"), q[(0, 2)] * t, 1e-12);
            near(of(&plies, "D12"), q[(0, 1)] * t.powi(3) / 12.0, 1e-12);
            assert!(of(&plies, "B11").abs() < 1e-12 * of(&plies, "A11") * t);
            let (s, c) = 30.0_f64.to_radians().sin_cos();
            near(of(&plies, "S55"), 5.0 / 6.0 * t * (5e9 * c * c + 3e9 * s * s), 1e-12);
            near(of(&plies, "S44"), 5.0 / 6.0 * t * (5e9 * s * s + 3e9 * c * c), 1e-12);
            near(of(&plies, "S45"), 5.0 / 6.0 * t * (5e9 - 3e9) * s * c, 1e-12);
            near(of(&plies, "areal_mass"), 1600.0 * t, 1e-12);
            near(of(&plies, "areal_inertia"), 1600.0 * t.powi(3) / 12.0, 1e-12);
        }
    }

    /// The published rigidities of [0/90] with E1/E2 = 10 (Jones, section 4.4.3 on antisymmetric cross-ply laminates):
    /// B11 = -B22 = t²/4 (E2/E1 - 1)/2 Q11 for two plies, all other B zero.
    #[test]
    fn two_crossed_plies_couple_bending_and_stretching() {
        let mut plies = [ply(0.0, 1e-3), ply(90.0, 1e-3)];
        for p in &mut plies {
            p.e1 = 10.0 * p.e2;
        }
        let t: f64 = 2e-3;
        let q11 = plies[0].stiffness()[(0, 0)];
        let b11 = q11 * t * t * (0.1 - 1.0) / 8.0;
        near(of(&plies, "B11"), b11, 1e-12);
        near(of(&plies, "B22"), -b11, 1e-12);
        for name in ["B12", "B16", "B26", "B66", "A16", "A26", "D16", "D26"] {
            assert!(of(&plies, name).abs() < 1e-9 * q11 * t.powi(3), "{name}");
        }
    }

    /// A sandwich of thin stiff faces shears in its core: S = G d²/c, d between the middles of the faces (H. G. Allen, Analysis and Design of
    /// Structural Sandwich Panels, Pergamon 1969).
    #[test]
    fn a_sandwich_shears_in_its_core() {
        let face = Ply {
            e1: 70e9,
            e2: 70e9,
            g12: 26e9,
            nu12: 0.3,
            g13: 26e9,
            g23: 26e9,
            density: 2700.0,
            angle: 0.0,
            thickness: 0.2e-3,
        };
        let core = Ply {
            e1: 1e6,
            e2: 1e6,
            g12: 4e5,
            nu12: 0.3,
            g13: 200e6,
            g23: 90e6,
            density: 50.0,
            angle: 0.0,
            thickness: 20e-3,
        };
        let d: f64 = 20.2e-3;
        near(of(&[face, core, face], "S55"), 200e6 * d * d / 20e-3, 1e-3);
        near(of(&[face, core, face], "S44"), 90e6 * d * d / 20e-3, 1e-3);
        // One face heavier: the mass lies off the middle.
        let thick = Ply { thickness: 0.4e-3, ..face };
        assert!(of(&[face, core, thick], "areal_moment") > 0.0);
    }
}
