//! Statics of the beam element against closed forms.

use super::*;
use crate::element::Sample;
use crate::linalg::{DMatrix, DVector};

/// K and M of a beam of length `l` with these properties.
pub(super) fn matrices(l: f64, given: &[(&'static str, f64)]) -> (DMatrix<f64>, DMatrix<f64>) {
    let sample = Sample { points: vec![[0.0; 3], [l, 0.0, 0.0]], given: given.to_vec(), mass: 0.0, free: true };
    let values = sample.values(PROPERTIES).unwrap();
    let input = ElementInput { points: &sample.points, values: &values };
    (Beam.stiffness(&input).unwrap().to_dense(), Beam.mass(&input).unwrap().to_dense())
}

/// The message with which these properties are refused.
pub(super) fn refusal(given: &[(&'static str, f64)]) -> String {
    let sample = Sample { points: vec![[0.0; 3], [1.0, 0.0, 0.0]], given: given.to_vec(), mass: 0.0, free: true };
    let values = sample.values(PROPERTIES).unwrap();
    Beam.stiffness(&ElementInput { points: &sample.points, values: &values }).unwrap_err().to_string()
}

/// K and M of a straight chain of elements of these lengths, with the properties of each: (6 nodes) x (6 nodes).
pub(super) fn chain(
    lengths: &[f64],
    given: impl Fn(usize) -> Vec<(&'static str, f64)>,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = 6 * (lengths.len() + 1);
    let (mut k, mut m) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for (e, l) in lengths.iter().enumerate() {
        let (ke, me) = matrices(*l, &given(e));
        for i in 0..12 {
            for j in 0..12 {
                k[(6 * e + i, 6 * e + j)] += ke[(i, j)];
                m[(6 * e + i, 6 * e + j)] += me[(i, j)];
            }
        }
    }
    (k, m)
}

/// Rows and columns `keep` of a matrix.
pub(super) fn part(a: &DMatrix<f64>, keep: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(keep.len(), keep.len(), |i, j| a[(keep[i], keep[j])])
}

/// Displacement of the free end of a cantilever, one element clamped at node 1, under the six loads at node 2.
pub(super) fn tip(l: f64, given: &[(&'static str, f64)], load: [f64; 6]) -> DVector<f64> {
    let k = part(&matrices(l, given).0, &[6, 7, 8, 9, 10, 11]);
    k.lu().solve(&DVector::from_row_slice(&load)).unwrap()
}

pub(super) fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} is not {b}");
}

pub(super) const SPAR: [(&str, f64); 4] = [("EA", 4e6), ("EIy", 900.0), ("EIz", 5000.0), ("GJ", 700.0)];

pub(super) fn with(more: &[(&'static str, f64)]) -> Vec<(&'static str, f64)> {
    [&SPAR[..], more].concat()
}

/// Element 4-5 of the updated Body Freedom Flutter aircraft: A. Gupta, C. P. Moreno, H. Pfifer, G. J. Balas, Updating a
/// finite element based structural model of a small flexible aircraft, AIAA SciTech 2015, equations (5) and (6) with
/// the sign of entry (2,5) corrected; E 56 GPa, G 234 MPa, 0.62 kg/m, section 76.2 mm x 6.5 mm, numbers computed
/// independently in double precision. Its dofs are w, th = dw/dx = -ry, ph = +rx.
/// The parts by kind of strain sum to the stiffness, with every coupling, preload and flexible ends; a part does no work on the motion of
/// another kind.
#[test]
fn the_strain_parts_sum_to_the_stiffness() {
    for sample in Beam.samples() {
        for flexible in [false, true] {
            let mut sample = sample.clone();
            if flexible {
                let is_hinged = sample.given.iter().any(|g| g.0 == "end1_hinge_compliance");
                let joints = [("end1_compliance_ry", 1e-3), ("end2_compliance_rx", 2e-3)];
                sample.given.extend(joints.into_iter().filter(|_| !is_hinged));
                sample.given.push(("axial_force", -40.0));
            }
            let mut seen = Vec::new();
            sample.given.retain(|g| {
                !seen.contains(&g.0) && {
                    seen.push(g.0);
                    true
                }
            });
            let values = sample.values(Beam.properties()).unwrap();
            let input = ElementInput { points: &sample.points, values: &values };
            let (k, parts) = (Beam.stiffness(&input).unwrap(), Beam.strain_parts(&input).unwrap().unwrap());
            let size = k.lower().iter().fold(0.0_f64, |s, v| s.max(v.abs()));
            for i in 0..12 {
                for j in 0..=i {
                    let sum: f64 = [&parts.axial, &parts.bending, &parts.torsion].iter().map(|p| p.get(i, j)).sum();
                    assert!((sum - k.get(i, j)).abs() < 1e-12 * size, "{i} {j}");
                }
            }
        }
    }
}

#[test]
fn gupta_2015_wing_element() {
    let (length, mu) = (0.12064999999999998, 0.62);
    let (b, h) = (0.0762, 0.0065);
    let (k, m) = matrices(
        length,
        &[
            ("E", 56e9),
            ("G", 234e6),
            ("Iy", 1.7438687500000001e-9),
            ("J", 2.4140467975e-7),
            ("mass_per_length", mu),
            ("polar_inertia_per_length", mu * (b * b + h * h) / 12.0),
        ],
    );
    #[rustfmt::skip]
    let expected_k = [
        667269.2161538285,   40253.0154644797,   0.0,               -667269.2161538285,  40253.0154644797,   0.0,
        40253.0154644797,    3237.6842105263167, 0.0,               -40253.0154644797,   1618.8421052631584, 0.0,
        0.0,                 0.0,                468.2030257894737,  0.0,                0.0,               -468.2030257894737,
       -667269.2161538285,  -40253.0154644797,   0.0,                667269.2161538285, -40253.0154644797,   0.0,
        40253.0154644797,    1618.8421052631584, 0.0,               -40253.0154644797,   3237.6842105263167, 0.0,
        0.0,                 0.0,               -468.2030257894737,  0.0,                0.0,                468.2030257894737,
    ];
    #[rustfmt::skip]
    let expected_m = [
        0.027783971428571422,   0.0004727371497619046, 0.0,                     0.00961752857142857,   -0.0002793446794047618, 0.0,
        0.0004727371497619046,  1.0370134021595233e-5, 0.0,                     0.0002793446794047618, -7.777600516196423e-6,  0.0,
        0.0,                    0.0,                   1.2152765501944443e-5,   0.0,                    0.0,                   6.076382750972221e-6,
        0.00961752857142857,    0.0002793446794047618, 0.0,                     0.027783971428571422,  -0.0004727371497619046, 0.0,
       -0.0002793446794047618, -7.777600516196423e-6,  0.0,                    -0.0004727371497619046,  1.0370134021595233e-5, 0.0,
        0.0,                    0.0,                   6.076382750972221e-6,    0.0,                    0.0,                   1.2152765501944443e-5,
    ];
    let dofs = [(2, 1.0), (4, -1.0), (3, 1.0), (8, 1.0), (10, -1.0), (9, 1.0)];
    for (name, a, expected) in [("K", k, expected_k), ("M", m, expected_m)] {
        let largest = expected.iter().fold(0.0_f64, |m, x| m.max(f64::abs(*x)));
        for (i, (row, s)) in dofs.iter().enumerate() {
            for (j, (column, t)) in dofs.iter().enumerate() {
                let error = a[(*row, *column)] * s * t - expected[6 * i + j];
                assert!(error.abs() < 1e-12 * largest, "{name}({i},{j}) is off by {error:e}");
            }
        }
    }
}

/// P L³/3EI + P L/(kappa G A), P L²/2EI, M L²/2EI, M L/EI: S. P. Timoshenko, Strength of Materials, part I, 1955.
/// One element is exact.
#[test]
fn timoshenko_cantilever_under_tip_loads_in_both_planes() {
    let (l, c) = (0.8, 3e-6);
    let spar = with(&[("shear_compliance_y", c), ("shear_compliance_z", 2.0 * c)]);
    let q = tip(l, &spar, [1.0, 2.0, 3.0, 4.0, 0.0, 0.0]);
    close(q[0], l / 4e6, 1e-12);
    close(q[1], 2.0 * (l.powi(3) / 15000.0 + l * c), 1e-12);
    close(q[5], 2.0 * l * l / 10000.0, 1e-12);
    close(q[2], 3.0 * (l.powi(3) / 2700.0 + 2.0 * l * c), 1e-12);
    close(q[4], -3.0 * l * l / 1800.0, 1e-12);
    close(q[3], 4.0 * l / 700.0, 1e-12);
    let q = tip(l, &spar, [0.0, 0.0, 0.0, 0.0, 5.0, 6.0]);
    close(q[2], -5.0 * l * l / 1800.0, 1e-12);
    close(q[4], 5.0 * l / 900.0, 1e-12);
    close(q[1], 6.0 * l * l / 10000.0, 1e-12);
    close(q[5], 6.0 * l / 5000.0, 1e-12);
}

#[test]
fn rigidities_are_their_factors_and_kappa_is_its_compliance() {
    let (e, g, a, iy, iz, j) = (70e9, 27e9, 3e-4, 4e-8, 9e-8, 7e-8);
    let factors = [("E", e), ("G", g), ("A", a), ("Iy", iy), ("Iz", iz), ("J", j), ("density", 2700.0)];
    let factors = [&factors[..], &[("kappa_y", 0.5), ("kappa_z", 0.6)]].concat();
    let direct = [
        ("EA", e * a),
        ("EIy", e * iy),
        ("EIz", e * iz),
        ("GJ", g * j),
        ("mass_per_length", 2700.0 * a),
        ("polar_inertia_per_length", 2700.0 * (iy + iz)),
        ("shear_compliance_y", 1.0 / (0.5 * g * a)),
        ("shear_compliance_z", 1.0 / (0.6 * g * a)),
    ];
    assert_eq!(matrices(0.3, &factors), matrices(0.3, &direct));
}

/// Neutral values change no bit.
#[test]
fn zeros_are_the_absent_value() {
    let zero: Vec<_> = PROPERTIES[13..].iter().filter(|p| p.name != "density").map(|p| (p.name, 0.0)).collect();
    let massive = with(&[("mass_per_length", 2.0), ("polar_inertia_per_length", 0.1)]);
    let zeros = [
        massive.clone(),
        zero.into_iter().filter(|(n, _)| *n != "mass_per_length" && *n != "polar_inertia_per_length").collect(),
    ]
    .concat();
    assert_eq!(zeros.len(), 6 + PROPERTIES.len() - 13 - 3);
    assert_eq!(matrices(0.7, &massive), matrices(0.7, &zeros));
}

/// The constant strains of bending (both planes), stretching and twist, and the linear curvature of a tip force, pass
/// through elements of unequal length: the inner nodes lie on the closed form.
#[test]
fn patch_test_of_unequal_elements() {
    let lengths = [0.05, 0.4, 0.13, 0.22];
    let l: f64 = lengths.iter().sum();
    let (k, _) = chain(&lengths, |_| SPAR.to_vec());
    let keep: Vec<usize> = (6..30).collect();
    let mut load = DVector::zeros(24);
    for (d, f) in [(0, 1e3), (2, 5.0), (3, 7.0), (5, 11.0)] {
        load[18 + d] = f;
    }
    let q = part(&k, &keep).lu().solve(&load).unwrap();
    let mut x = 0.0;
    for (node, part) in lengths.iter().enumerate() {
        x += part;
        let q = |d: usize| q[6 * node + d];
        close(q(0), 1e3 * x / 4e6, 1e-10);
        close(q(3), 7.0 * x / 700.0, 1e-10);
        close(q(1), 11.0 * x * x / 10000.0, 1e-10);
        close(q(5), 11.0 * x / 5000.0, 1e-10);
        close(q(2), 5.0 * x * x * (3.0 * l - x) / (6.0 * 900.0), 1e-10);
        close(q(4), -5.0 * x * (2.0 * l - x) / (2.0 * 900.0), 1e-10);
    }
}

/// An element is the chain of its parts with the inner nodes statically condensed, in stiffness and, since its shape
/// functions are the static deflections, also in mass: offsets, shear, rotary inertia, flexible ends and all.
#[test]
fn an_element_is_the_condensed_chain_of_its_parts() {
    let lengths = [0.21, 0.34, 0.25];
    let uniform = with(&[
        ("shear_compliance_y", 2e-5),
        ("shear_compliance_z", 3e-5),
        ("mass_per_length", 0.7),
        ("polar_inertia_per_length", 4e-4),
        ("rotary_inertia_y", 1e-3),
        ("rotary_inertia_z", 2e-3),
        ("mass_offset_y", 0.02),
        ("mass_offset_z", -0.05),
        ("shear_centre_y", -0.03),
        ("shear_centre_z", 0.01),
    ]);
    let near = [("end1_compliance_ry", 1e-3), ("end1_compliance_uy", 2e-5)];
    let far = [("end2_compliance_rz", 2e-4), ("end2_compliance_rx", 3e-3), ("end2_compliance_ux", 1e-7)];
    let (k, m) = chain(&lengths, |e| match e {
        0 => [&uniform[..], &near].concat(),
        2 => [&uniform[..], &far].concat(),
        _ => uniform.clone(),
    });
    let inner: Vec<usize> = (6..18).collect();
    let outer: Vec<usize> = (0..6).chain(18..24).collect();
    let coupling = DMatrix::from_fn(12, 12, |i, j| -k[(inner[i], outer[j])]);
    let follow = part(&k, &inner).lu().solve(&coupling).unwrap();
    let mut t = DMatrix::zeros(24, 12);
    for j in 0..12 {
        t[(outer[j], j)] = 1.0;
        (0..12).for_each(|i| t[(inner[i], j)] = follow[(i, j)]);
    }
    let (k_whole, m_whole) = matrices(lengths.iter().sum(), &[&uniform[..], &near, &far].concat());
    for (condensed, whole) in [(t.transpose() * k * &t, k_whole), (t.transpose() * m * &t, m_whole)] {
        for i in 0..12 {
            for j in 0..12 {
                let size = (whole[(i, i)] * whole[(j, j)]).sqrt();
                let error = (condensed[(i, j)] - whole[(i, j)]).abs();
                assert!(error < 1e-10 * size, "({i},{j}): {} {}", condensed[(i, j)], whole[(i, j)]);
            }
        }
    }
}

/// Turning the section by a right angle about x exchanges the planes: (y, z) -> (z, -y), with every property.
#[test]
fn a_quarter_turn_exchanges_the_planes() {
    let common = [("EA", 4e6), ("GJ", 700.0), ("mass_per_length", 2.0), ("polar_inertia_per_length", 0.1)];
    let original = [
        ("EIy", 900.0),
        ("EIz", 5000.0),
        ("shear_compliance_y", 2e-6),
        ("shear_compliance_z", 3e-6),
        ("mass_offset_y", 0.02),
        ("mass_offset_z", 0.05),
        ("shear_centre_y", -0.01),
        ("shear_centre_z", 0.03),
        ("rotary_inertia_y", 0.01),
        ("rotary_inertia_z", 0.02),
        ("bend_twist_y", 200.0),
        ("bend_twist_z", -100.0),
        ("end2_compliance_uy", 1e-5),
        ("end2_compliance_rz", 1e-3),
    ];
    // The same beam seen in axes y' = z, z' = -y.
    let turned = [
        ("EIz", 900.0),
        ("EIy", 5000.0),
        ("shear_compliance_z", 2e-6),
        ("shear_compliance_y", 3e-6),
        ("mass_offset_z", -0.02),
        ("mass_offset_y", 0.05),
        ("shear_centre_z", 0.01),
        ("shear_centre_y", 0.03),
        ("rotary_inertia_z", 0.01),
        ("rotary_inertia_y", 0.02),
        ("bend_twist_z", -200.0),
        ("bend_twist_y", -100.0),
        ("end2_compliance_uz", 1e-5),
        ("end2_compliance_ry", 1e-3),
    ];
    let mut t = DMatrix::zeros(12, 12);
    for block in [0, 3, 6, 9] {
        t[(block, block)] = 1.0;
        t[(block + 1, block + 2)] = 1.0;
        t[(block + 2, block + 1)] = -1.0;
    }
    let (k, m) = matrices(0.9, &[&common[..], &original].concat());
    let (k_turned, m_turned) = matrices(0.9, &[&common[..], &turned].concat());
    assert!((t.transpose() * &k_turned * &t - &k).abs().max() < 1e-12 * k.abs().max());
    assert!((t.transpose() * &m_turned * &t - &m).abs().max() < 1e-12 * m.abs().max());
}

/// Bend-twist coupling under tip moment and torque: [EIy K; K GJ] (curvature, twist rate) = (M, T), one element exact.
/// Under a tip force: w = F L³/(3 EIy (1 - K²/(EIy GJ))), rx = -K/GJ ry, with the error falling as the square of the
/// element length. T. A. Weisshaar, Aeroelastic tailoring of forward swept composite wings, J. Aircraft 18 (1981).
#[test]
fn weisshaar_bend_twist_cantilever() {
    let (l, ei, gj, k) = (0.8, 900.0, 700.0, 350.0);
    let spar = with(&[("bend_twist_y", k)]);
    let (moment, torque) = (3.0, 5.0);
    let q = tip(l, &spar, [0.0, 0.0, 0.0, torque, moment, 0.0]);
    let determinant = ei * gj - k * k;
    close(q[4], l * (gj * moment - k * torque) / determinant, 1e-12);
    close(q[3], l * (ei * torque - k * moment) / determinant, 1e-12);
    let w = l.powi(3) / (3.0 * ei * (1.0 - k * k / (ei * gj)));
    let errors: Vec<f64> = [4, 8, 16]
        .iter()
        .map(|&n| {
            let (stiffness, _) = chain(&vec![l / n as f64; n], |_| spar.clone());
            let keep: Vec<usize> = (6..6 * (n + 1)).collect();
            let mut load = DVector::zeros(6 * n);
            load[6 * n - 4] = 1.0;
            let q = part(&stiffness, &keep).lu().solve(&load).unwrap();
            close(q[6 * n - 3], -k / gj * q[6 * n - 2], 1e-10);
            (q[6 * n - 4] - w).abs() / w
        })
        .collect();
    for pair in errors.windows(2) {
        let rate = (pair[0] / pair[1]).log2();
        assert!((rate - 2.0).abs() < 0.02, "rate {rate}, errors {errors:?}");
    }
}

/// Offset elastic axis: a force at the node line is a force and a torque on the elastic axis.
#[test]
fn shear_centre_offset_is_a_rigid_arm() {
    let (l, e) = (0.8, 0.05);
    let q = tip(l, &with(&[("shear_centre_y", e)]), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    // The force stands at y = 0, the axis at y = e: torque -e, twist -e l/GJ, and the node moves by -e * twist more.
    close(q[3], -e * l / 700.0, 1e-12);
    close(q[2], l.powi(3) / 2700.0 + e * e * l / 700.0, 1e-12);
}

/// Lowest P at which K + K_P(-P) of a chain is singular, by bisection on the sign of the lowest eigenvalue.
fn buckling_load(elements: usize, l: f64, given: &[(&'static str, f64)], upper: f64) -> f64 {
    let keep: Vec<usize> = (6..6 * (elements + 1)).collect();
    let stable = |p: f64| {
        let (k, _) = chain(&vec![l / elements as f64; elements], |_| [given, &[("axial_force", -p)]].concat());
        part(&k, &keep).cholesky().is_some()
    };
    let (mut low, mut high) = (0.0, upper);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}

/// Cantilever column: π² EI/4L² (Euler); with shear P_E/(1 + P_E c) (Engesser). S. P. Timoshenko, J. M. Gere, Theory of
/// Elastic Stability, 1961, sections 2.1 and 2.17. The Hermite element is above by (kh)⁴/720, h the element length; with
/// much shear (12 EI c/h² from 144 here) by the square of h.
#[test]
fn timoshenko_gere_cantilever_column() {
    let l = 1.2;
    let euler = std::f64::consts::PI.powi(2) * 900.0 / (4.0 * l * l);
    for n in [1_u32, 2, 4] {
        let p = buckling_load(n as usize, l, &SPAR, 2.0 * euler);
        let bound = (std::f64::consts::FRAC_PI_2 / f64::from(n)).powi(4) / 720.0;
        assert!(p > euler && p < euler * (1.0 + 1.1 * bound), "{n}: {p} against {euler}");
    }
    let c = 3e-4;
    let engesser = euler / (1.0 + euler * c);
    let soft = with(&[("shear_compliance_y", c), ("shear_compliance_z", c)]);
    let errors = [8, 16, 32].map(|n| buckling_load(n, l, &soft, 2.0 * euler) / engesser - 1.0);
    for pair in errors.windows(2) {
        let rate = (pair[0] / pair[1]).log2();
        assert!((rate - 2.0).abs() < 0.02 && pair[1] > 0.0, "rate {rate}, errors {errors:?}");
    }
    assert!((4.0 * errors[2] - errors[1]).abs() / 3.0 < 1e-6, "{errors:?}");
}

/// A mass-only beam is complete; one with some stiffness says what the rest of its dofs need.
#[test]
fn what_a_section_lacks_is_named() {
    let lacks = |given: &[(&'static str, f64)]| {
        let sample = Sample { points: vec![[0.0; 3], [1.0, 0.0, 0.0]], given: given.to_vec(), mass: 0.0, free: true };
        let values = sample.values(PROPERTIES).unwrap();
        let lacks = Beam.lacks(&ElementInput { points: &sample.points, values: &values });
        lacks.iter().map(|l| format!("{}:{}", l.dof, l.property)).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(lacks(&[("mass_per_length", 1.0), ("A", 1.0)]), "");
    assert_eq!(lacks(&SPAR), "");
    assert_eq!(lacks(&[("E", 1.0), ("Iy", 1.0), ("G", 1.0), ("J", 1.0)]), "ux:A uy:Iz rz:Iz");
    assert_eq!(lacks(&[("EIy", 1.0), ("J", 1.0)]), "ux:EA rx:G uy:EIz rz:EIz");
    assert_eq!(lacks(&[("density", 1.0), ("A", 1.0)]), "rx:polar_inertia_per_length");
    let (k, _) = matrices(1.0, &[("E", 1.0), ("Iy", 1.0)]);
    assert!(k.row(1).abs().max() == 0.0 && k.row(3).abs().max() == 0.0 && k[(2, 2)] == 12.0);
}

#[test]
fn contradictions_are_refused_with_the_remedy() {
    assert_eq!(
        refusal(&[("E", 1.0), ("Iy", 1.0), ("EIy", 1.0)]),
        "`Iy` and `EIy` say the same thing twice; give one of them"
    );
    assert_eq!(
        refusal(&[("mass_per_length", 1.0), ("density", 1.0)]),
        "`mass_per_length` and `density` say the same thing twice; give one of them"
    );
    assert_eq!(
        refusal(&[("density", 1.0)]),
        "property `A` is missing: `density` becomes mass per length by the cross-section area; or give `mass_per_length`"
    );
    assert_eq!(
        refusal(&[("kappa_y", 0.8), ("A", 1.0)]),
        "property `G` is missing: the shear rigidity is kappa G A; or give `shear_compliance_y`, `shear_compliance_z`"
    );
    assert_eq!(
        refusal(&with(&[("bend_twist_y", 800.0)])),
        "property `bend_twist_y` is 800; it must be so small that bend_twist_y²/(EIy GJ) + bend_twist_z²/(EIz GJ) is \
         below 1"
    );
    assert_eq!(
        refusal(&[("EIy", 1.0), ("bend_twist_y", 0.1)]),
        "property `GJ` is missing: the bend-twist coupling needs bending and torsional rigidity"
    );
    assert_eq!(refusal(&[("EA", -7.0)]), "property `EA` is -7; it must be a finite number, zero or above");
}

/// K is linear in every rigidity, coupling and the preload; M in every mass property.
#[test]
fn matrices_are_affine() {
    let base = with(&[
        ("bend_twist_y", 100.0),
        ("axial_force", 50.0),
        ("mass_per_length", 2.0),
        ("polar_inertia_per_length", 0.1),
        ("rotary_inertia_y", 0.01),
        ("rotary_inertia_z", 0.02),
        ("shear_centre_y", 0.02),
        ("mass_offset_y", 0.03),
    ]);
    for (i, (name, value)) in base.iter().enumerate().filter(|(_, (n, _))| !n.ends_with("_y") || n.starts_with('r')) {
        let at = |v: f64| {
            let mut given = base.clone();
            given[i].1 = v;
            matrices(0.7, &given)
        };
        let ((k0, m0), (k1, m1), (k3, m3)) = (at(*value), at(2.0 * value), at(4.0 * value));
        for (a0, a1, a3) in [(k0, k1, k3), (m0, m1, m3)] {
            let departure = &a3 - &a0 - (&a1 - &a0) * 3.0;
            assert!(departure.abs().max() < 1e-14 * a3.abs().max(), "{name}");
        }
    }
}

/// Under a tip force the deflection inside a single element is the closed form, by the shape functions.
#[test]
fn interpolation_is_the_deflection_curve() {
    let (l, c) = (0.8, 3e-5);
    let given = with(&[("shear_compliance_z", c), ("shear_centre_y", 0.0)]);
    let q = tip(l, &given, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let sample = Sample { points: vec![[0.0; 3], [l, 0.0, 0.0]], given, mass: 0.0, free: true };
    let values = sample.values(PROPERTIES).unwrap();
    let input = ElementInput { points: &sample.points, values: &values };
    for xi in [0.1, 0.5, 0.9] {
        let rows = Beam.interpolate(&input, xi).unwrap();
        let at = |d: usize| (0..6).map(|j| rows[d][6 + j] * q[j]).sum::<f64>();
        let x = xi * l;
        close(at(2), x * x * (3.0 * l - x) / 5400.0 + c * x, 1e-12);
        close(at(4), -x * (2.0 * l - x) / 1800.0, 1e-12);
    }
}

/// An isotropic material: G = E/(2 (1 + ν)), also in the shear rigidity κ G A; ν beside G or alone is refused.
#[test]
fn poissons_ratio_gives_the_shear_modulus() {
    let rest =
        [("E", 70e9), ("A", 3e-4), ("Iy", 4e-8), ("Iz", 9e-8), ("J", 7e-8), ("kappa_z", 0.6), ("density", 2700.0)];
    let given = |more: &[(&'static str, f64)]| [&rest[..], more].concat();
    let (by_ratio, by_modulus) = (matrices(0.6, &given(&[("nu", 0.25)])), matrices(0.6, &given(&[("G", 28e9)])));
    assert!((by_ratio.0 - by_modulus.0).amax() < 1e-12 * 70e9);
    assert!(refusal(&given(&[("nu", 0.3), ("G", 27e9)])).contains("nu"));
    assert!(refusal(&given(&[("nu", 0.6)])).contains("at most 0.5"));
    assert!(refusal(&[("nu", 0.3), ("J", 7e-8), ("mass_per_length", 1.0)]).contains('E'));
}

/// Tension P at the shear centre of a cantilever whose neutral axis lies at (y, z): it bends by P z and P y about its axes,
/// rotations -P z L/EIy and P y L/EIz at the tip, and the load point moves by P L (1/EA + z²/EIy + y²/EIz).
#[test]
fn tension_beside_the_neutral_axis_bends() {
    let (l, p, y, z) = (0.8, 500.0, 0.03, -0.02);
    let u = tip(l, &with(&[("neutral_axis_y", y), ("neutral_axis_z", z)]), [p, 0.0, 0.0, 0.0, 0.0, 0.0]);
    close(u[0], p * l * (1.0 / 4e6 + z * z / 900.0 + y * y / 5000.0), 1e-11);
    close(u[4], -p * z * l / 900.0, 1e-11);
    close(u[5], p * y * l / 5000.0, 1e-11);
    // Where the elastic axis is, it is that of before.
    let apart = with(&[("shear_centre_y", y), ("neutral_axis_y", y), ("mass_per_length", 0.5)]);
    let alone = with(&[("shear_centre_y", y), ("mass_per_length", 0.5)]);
    assert_eq!(matrices(l, &apart), matrices(l, &alone));
}

/// Lumped mass: half of everything at either node, on the mass axis, whatever the ends do; in between a mean.
#[test]
fn lumped_mass_stands_at_the_nodes() {
    let given = |s: f64| {
        let more =
            [("mass_per_length", 3.0), ("polar_inertia_per_length", 0.2), ("mass_offset_y", 0.1), ("lumping", s)];
        with(&[&more[..], &[("end1_compliance_ry", 1.0)]].concat())
    };
    let (l, m) = (0.8, 0.5 * 0.8 * 3.0);
    let lumped = matrices(l, &given(1.0)).1;
    for first in [0, 6] {
        for d in 0..3 {
            close(lumped[(first + d, first + d)], m, 1e-14);
        }
        close(lumped[(first + 3, first + 3)], 0.5 * 0.8 * 0.2 + m * 0.01, 1e-14);
        close(lumped[(first + 2, first + 3)], m * 0.1, 1e-14);
        close(lumped[(first, first + 5)], -m * 0.1, 1e-14);
        assert_eq!(lumped[(first + 1, first + 5)], 0.0);
    }
    assert_eq!(lumped.view((0, 6), (6, 6)).abs().max(), 0.0);
    let mean = 0.5 * (matrices(l, &given(0.0)).1 + &lumped);
    assert!((matrices(l, &given(0.5)).1 - mean).abs().max() < 1e-14);
}
