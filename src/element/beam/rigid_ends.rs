//! Beams with rigid ends against closed forms and the beam without them.

use super::statics::{close, matrices, refusal, tip, with};
use super::*;
use crate::element::Sample;
use crate::linalg::DVector;

/// Rigid over a and b at its ends, a cantilever bends over l = L - a - b, and its tip moves on an arm b:
/// w = P l³/3EI + 2 P b l²/2EI + P b² l/EI. Tension and torsion act over l.
#[test]
fn rigid_ends_leave_a_shorter_beam_on_arms() {
    let (whole, a, b) = (0.8, 0.1, 0.05);
    let given = with(&[("end1_rigid_length", a), ("end2_rigid_length", b)]);
    let l = whole - a - b;
    let q = tip(whole, &given, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    close(q[2], (l.powi(3) / 3.0 + b * l * l + b * b * l) / 900.0, 1e-12);
    close(-q[4], (l * l / 2.0 + b * l) / 900.0, 1e-12);
    let q = tip(whole, &given, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    close(q[1], (l.powi(3) / 3.0 + b * l * l + b * b * l) / 5000.0, 1e-12);
    let q = tip(whole, &given, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    close(q[0], l / 4e6, 1e-12);
    close(q[3], l / 700.0, 1e-12);
    let why = refusal(&with(&[("end1_rigid_length", 0.7), ("end2_rigid_length", 0.4)]));
    assert!(why.contains("end1_rigid_length") && why.contains("left to deform"), "{why}");
}

/// As a rigid body, a beam with rigid ends has the mass and the inertia of the whole; and a tension P holds its slope by P L.
#[test]
fn rigid_ends_keep_mass_inertia_and_tension() {
    let inertia =
        [("mass_per_length", 2.0), ("polar_inertia_per_length", 0.01), ("mass_offset_z", 0.03), ("axial_force", 70.0)];
    let (l, rigid) = (0.8, [("end1_rigid_length", 0.1), ("end2_rigid_length", 0.05)]);
    let plain = with(&inertia);
    let (k0, m0) = matrices(l, &plain);
    let (k, m) = matrices(l, &[plain, rigid.to_vec()].concat());
    for motion in 0..6 {
        // Translations, then rotations about the first node.
        let at = |x: f64| -> [f64; 6] {
            let mut u = [0.0; 6];
            u[motion] = 1.0;
            match motion {
                4 => u[2] = -x,
                5 => u[1] = x,
                _ => {}
            }
            u
        };
        let u = DVector::from_iterator(12, at(0.0).into_iter().chain(at(l)));
        close(u.dot(&(&m * &u)), u.dot(&(&m0 * &u)), 1e-12);
        let (own, before) = (u.dot(&(&k * &u)), u.dot(&(&k0 * &u)));
        assert!((own - before).abs() < 1e-9, "{own} {before}");
    }
    let mut turned = DVector::zeros(12);
    (turned[5], turned[7], turned[11]) = (1.0, l, 1.0);
    close(turned.dot(&(&k * &turned)), 70.0 * l, 1e-10);
}

/// Points inside a rigid end move with its node; between the ends the shape functions are those of the shorter beam.
#[test]
fn points_of_rigid_ends_move_with_their_nodes() {
    let given = with(&[("end1_rigid_length", 0.2), ("end2_rigid_length", 0.1)]);
    let sample = Sample { points: vec![[0.0; 3], [1.0, 0.0, 0.0]], given, mass: 0.0, free: true };
    let values = sample.values(PROPERTIES).unwrap();
    let input = ElementInput { points: &sample.points, values: &values };
    let at = |xi: f64| Beam.interpolate(&input, xi).unwrap();
    let inside = at(0.1);
    close(inside[1][5], 0.1, 1e-12);
    close(inside[2][4], -0.1, 1e-12);
    assert_eq!((inside[1][1], inside[2][2]), (1.0, 1.0));
    let beyond = at(0.95);
    assert!((beyond[1][11] + 0.05).abs() < 1e-15 && beyond[1][7] == 1.0);
    // Continuous where the rigid end begins.
    for edge in [0.2, 0.9] {
        let (below, above) = (at(edge - 1e-9), at(edge + 1e-9));
        for (x, y) in below.iter().flatten().zip(above.iter().flatten()) {
            assert!((x - y).abs() < 1e-7);
        }
    }
}
