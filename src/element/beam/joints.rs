//! Joints at the ends of a beam against closed forms and springs of their own.

use super::statics::{close, matrices, with};
use super::*;
use crate::linalg::{DMatrix, DVector};

/// A hinge at the far end: the clamped side feels a propped cantilever, 3EI/L³, and the hinge carries no moment.
#[test]
fn an_infinite_compliance_is_a_hinge() {
    let l = 0.8;
    for released in [1e30, f64::INFINITY] {
        let (k, _) = matrices(l, &with(&[("end2_compliance_rz", released), ("end2_compliance_rx", released)]));
        close(k[(7, 7)], 3.0 * 5000.0 / l.powi(3), 1e-12);
        close(k[(5, 5)], 3.0 * 5000.0 / l, 1e-12);
        close(k[(5, 7)], -3.0 * 5000.0 / (l * l), 1e-12);
        assert!(k.row(11).abs().max() < 1e-20 && k.row(9).abs().max() < 1e-20);
        assert!(k.row(3).abs().max() < 1e-12 * 700.0, "twist is free when one end is");
        close(k[(8, 8)], 12.0 * 900.0 / l.powi(3), 1e-12);
    }
}

/// Hinges and slides wherever they can be, more than the beam has mechanisms: nothing is left, and nothing explodes.
#[test]
fn a_beam_released_everywhere_has_no_stiffness() {
    for compliance in [1e30, f64::INFINITY] {
        let released: Vec<_> = PROPERTIES[END..][..12].iter().map(|p| (p.name, compliance)).collect();
        let (k, m) = matrices(0.8, &[with(&[("mass_per_length", 1.0)]), released].concat());
        assert!(k.abs().max() < 1e-10, "{k}");
        assert!(m.iter().all(|x| x.is_finite()));
    }
}

const END: usize = crate::element::property_index(PROPERTIES, "end1_compliance_ux");

/// Joints at the ends are springs in series: against the element between explicit springs of 1/c, condensed by
/// elimination.
#[test]
fn end_compliances_are_springs_condensed_exactly() {
    let compliances = [1e-7, 2e-5, 3e-5, 2e-4, 5e-4, 3e-4, 2e-7, 1e-5, 4e-5, 1e-4, 2e-4, 6e-4];
    let joints: Vec<_> = PROPERTIES[END..].iter().zip(compliances).map(|(p, c)| (p.name, c)).collect();
    let base = with(&[("mass_per_length", 2.0), ("shear_centre_y", 0.04), ("bend_twist_y", 300.0)]);
    let (k, m) = matrices(0.8, &[base.clone(), joints].concat());
    let (inner_k, inner_m) = matrices(0.8, &base);
    let springs = DMatrix::from_diagonal(&DVector::from_iterator(12, compliances.iter().map(|c| 1.0 / c)));
    let t = (&inner_k + &springs).lu().solve(&springs).unwrap();
    let expected = &springs - &springs * &t;
    assert!((&k - expected).abs().max() < 1e-9 * k.abs().max());
    let expected = t.transpose() * inner_m * t;
    assert!((&m - expected).abs().max() < 1e-9 * m.abs().max());
}

/// A joint about a skew axis is a spring in series that gives about it and hardly about anything else, condensed by elimination; about an axis of the beam
/// it is the joint about that; of no stiffness it bears no moment about its axis.
#[test]
fn a_hinge_about_a_skew_axis_is_a_spring_condensed_exactly() {
    let base = with(&[("mass_per_length", 2.0), ("shear_centre_y", 0.04), ("bend_twist_y", 300.0)]);
    let (c, n) = (3e-4, [0.6, 0.0, 0.8]);
    let hinge = |c: f64| [("end1_hinge_compliance", c), ("end1_hinge_x", 3.0), ("end1_hinge_z", 4.0)];
    let (k, m) = matrices(0.8, &[base.clone(), hinge(c).to_vec()].concat());
    let (inner_k, inner_m) = matrices(0.8, &base);
    let mut gives = DMatrix::identity(12, 12) * 1e-12;
    for i in 0..3 {
        for j in 0..3 {
            gives[(3 + i, 3 + j)] += c * n[i] * n[j];
        }
    }
    let springs = gives.try_inverse().unwrap();
    let t = (&inner_k + &springs).lu().solve(&springs).unwrap();
    let expected = &springs - &springs * &t;
    assert!((&k - expected).abs().max() < 1e-4 * k.abs().max());
    let expected = t.transpose() * inner_m * t;
    assert!((&m - expected).abs().max() < 1e-4 * m.abs().max());
    for (axis, own) in [("end2_hinge_y", "end2_compliance_ry"), ("end2_hinge_x", "end2_compliance_rx")] {
        let about = [base.clone(), vec![("end2_hinge_compliance", c), (axis, -2.0)]].concat();
        let (k, m) = matrices(0.8, &about);
        let (k_own, m_own) = matrices(0.8, &[base.clone(), vec![(own, c)]].concat());
        assert!((&k - &k_own).abs().max() < 1e-12 * k.abs().max() && (&m - &m_own).abs().max() < 1e-12 * m.abs().max());
    }
    let (k, _) = matrices(0.8, &[base, hinge(f64::INFINITY).to_vec()].concat());
    let moment = DVector::from_fn(12, |i, _| if (3..6).contains(&i) { n[i - 3] } else { 0.0 });
    assert!((&k * moment).amax() < 1e-10 * k.abs().max());
}
