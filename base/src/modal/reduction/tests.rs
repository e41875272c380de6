use super::*;
use proptest::prelude::*;
use retune_linalg::lowest_modes;

/// Fixed-free chain of three unit masses and springs.
fn chain() -> (DMatrix<f64>, DMatrix<f64>) {
    (DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]), DMatrix::identity(3, 3))
}

/// Five dofs from formulas, so that a peer can be given the same numbers.
fn peer_model() -> (DMatrix<f64>, DMatrix<f64>) {
    let k = DMatrix::from_fn(5, 5, |i, j| match i.abs_diff(j) {
        0 => 1e3 * (2.0 + 0.1 * i as f64),
        1 => -1e3,
        _ => 0.0,
    });
    let m = DMatrix::from_fn(5, 5, |i, j| match i.abs_diff(j) {
        0 => 1.0 + 0.5 * i as f64,
        1 => 0.2,
        _ => 0.0,
    });
    (k, m)
}

fn frequencies(k: &DMatrix<f64>, m: &DMatrix<f64>, n: usize) -> Vec<f64> {
    lowest_modes(k, m, n, 0.1).unwrap().values.iter().copied().collect()
}

/// By hand: middle dof hidden, T_s = [1/2 1/2], K_r = [3/2 -1/2; -1/2 1/2], M_r = [5/4 1/4; 1/4 5/4];
/// IRS adds K_ss⁻¹ M_ss T_s M_r⁻¹ K_r = [1/6 0].
#[test]
fn guyan_and_irs_of_a_chain_by_hand() {
    let (k, m) = chain();
    let s = selection(3, &[0, 2]).unwrap();
    let reduced = guyan(&k, &m, &s).unwrap();
    let t = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.5, 0.5, 0.0, 1.0]);
    assert!((&reduced.transformation - t).abs().max() < 1e-15);
    assert!((reduced.stiffness - DMatrix::from_row_slice(2, 2, &[1.5, -0.5, -0.5, 0.5])).abs().max() < 1e-15);
    assert!((reduced.mass - DMatrix::from_row_slice(2, 2, &[1.25, 0.25, 0.25, 1.25])).abs().max() < 1e-15);
    let improved = irs(&k, &m, &s, 1).unwrap();
    let t = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 2.0 / 3.0, 0.5, 0.0, 1.0]);
    assert!((improved.transformation - t).abs().max() < 1e-15);
}

/// sdynpy 0.23.0, `System.reduce_guyan` and `System.reduce_dynamic` at 3 Hz, dofs 0, 2, 4 kept.
#[test]
fn peer_gives_the_same_static_and_dynamic_reduction() {
    let (k, m) = peer_model();
    let s = selection(5, &[0, 2, 4]).unwrap();
    let reduced = guyan(&k, &m, &s).unwrap();
    #[rustfmt::skip]
    let stiffness = DMatrix::from_row_slice(3, 3, &[
        1523.8095238095239, -476.19047619047615, 0.0,
        -476.19047619047615, 1289.0269151138716, -434.7826086956522,
        0.0, -434.7826086956522, 1965.2173913043478,
    ]);
    #[rustfmt::skip]
    let mass = DMatrix::from_row_slice(3, 3, &[
        1.5306122448979593, 0.5306122448979591, 0.0,
        0.5306122448979591, 3.1771150804367116, 0.6465028355387525,
        0.0, 0.6465028355387525, 3.6465028355387523,
    ]);
    assert!((reduced.stiffness - stiffness).abs().max() < 1e-11);
    assert!((reduced.mass - mass).abs().max() < 1e-14);
    let omega = 3.0 * std::f64::consts::TAU;
    let reduced = dynamic_reduction(&k, &m, &s, omega * omega).unwrap();
    #[rustfmt::skip]
    let stiffness = DMatrix::from_row_slice(3, 3, &[
        1614.0552689523886, -385.9447310476113, 0.0,
        -385.9447310476113, 1620.5704494957058, -193.48481945668289,
        0.0, -193.48481945668289, 2206.515180543317,
    ]);
    assert!((reduced.stiffness - stiffness).abs().max() < 1e-11);
    assert!((reduced.mass[(1, 1)] - 4.716617146685537).abs() < 1e-13);
}

/// Dynamic expansion of (-0.15, ., -0.37) at 0.445 rad/s, the printed example of `mode_expansion_from_model` in the Python
/// package vibrationtesting (J. C. Slater). It prints +0.2886 in the middle: the package has lost the minus sign of its own
/// equation, and the mode beside it (-0.164, -0.2955, -0.3685) shows the right one.
#[test]
fn dynamic_expansion_of_a_published_example() {
    let (k, m) = chain();
    let s = selection(3, &[0, 2]).unwrap();
    let reduced = dynamic_reduction(&(k * 4.0), &(m * 4.0), &s, 0.445 * 0.445).unwrap();
    let expanded = reduced.transformation * nalgebra::dvector![-0.15, -0.37];
    assert!((expanded[1] + 0.2886).abs() < 5e-5, "{expanded}");
}

/// Nine sensors on three dofs, some twice and some between: SEREP keeps the modes; what interpolates says why it cannot.
#[test]
fn serep_takes_more_sensors_than_dofs() {
    let k = DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]);
    let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 2.0, 1.5]);
    let modes = lowest_modes(&k, &m, 2, 0.1).unwrap();
    let s = DMatrix::from_fn(9, 3, |i, j| if i % 3 == j { 1.0 } else { 0.1 * (i / 3) as f64 });
    let reduced = serep(&k, &m, &s, &modes.vectors).unwrap();
    let back = &reduced.transformation * (&s * &modes.vectors);
    assert!((back - &modes.vectors).amax() < 1e-12);
    let observed = &s * &modes.vectors;
    let stiffness = observed.tr_mul(&(&reduced.stiffness * &observed));
    assert!((stiffness - DMatrix::from_diagonal(&modes.values)).amax() < 1e-12);
    let error = guyan(&k, &m, &s).unwrap_err().to_string();
    assert!(error.contains("9 x 3") && error.contains("SEREP takes any number"), "{error}");
}

#[test]
fn serep_has_the_kept_modes_exactly() {
    let (k, m) = peer_model();
    let phi = lowest_modes(&k, &m, 2, 1.0).unwrap();
    for dofs in [vec![1, 3], vec![0, 2, 4]] {
        let s = selection(5, &dofs).unwrap();
        let reduced = serep(&k, &m, &s, &phi.vectors).unwrap();
        let at_sensors = &s * &phi.vectors;
        assert!((&reduced.transformation * &at_sensors - &phi.vectors).abs().max() < 1e-14);
        let modal_mass = at_sensors.transpose() * &reduced.mass * &at_sensors;
        assert!((modal_mass - DMatrix::identity(2, 2)).abs().max() < 1e-13);
        let residual =
            &reduced.stiffness * &at_sensors - &reduced.mass * &at_sensors * DMatrix::from_diagonal(&phi.values);
        assert!(residual.abs().max() < 1e-10); // of entries near 1e3
    }
}

/// Friswell, Garvey, Penny, The convergence of the iterated IRS method, Journal of Sound and Vibration 211 (1998)
/// 123-132: the iteration reproduces the lowest modes of the full model, the lower ones faster.
#[test]
fn iterated_irs_converges_to_the_full_frequencies_from_above_guyan() {
    let (k, m) = peer_model();
    let s = selection(5, &[1, 3]).unwrap();
    let exact = frequencies(&k, &m, 2);
    let error = |r: Reduction, j: usize| (frequencies(&r.stiffness, &r.mass, 2)[j] / exact[j] - 1.0).abs();
    let guyan_error = [0, 1].map(|j| error(guyan(&k, &m, &s).unwrap(), j));
    let irs_error = [0, 1].map(|j| error(irs(&k, &m, &s, 1).unwrap(), j));
    let iterated = [0, 1].map(|j| error(irs(&k, &m, &s, 60).unwrap(), j));
    assert!(irs_error[0] < 0.05 * guyan_error[0] && irs_error[1] < guyan_error[1]);
    assert!(iterated[0] < 1e-12 && iterated[1] < 1e-10, "{iterated:?}");
}

#[test]
fn guyan_is_exact_for_massless_hidden_dofs_and_for_static_loads() {
    let (k, mut m) = peer_model();
    for i in [1, 3] {
        m.row_mut(i).fill(0.0);
        m.column_mut(i).fill(0.0);
    }
    let s = selection(5, &[0, 2, 4]).unwrap();
    let reduced = guyan(&k, &m, &s).unwrap();
    for (a, b) in frequencies(&reduced.stiffness, &reduced.mass, 3).iter().zip(frequencies(&k, &m, 3)) {
        assert!((a / b - 1.0).abs() < 1e-13);
    }
    let load = nalgebra::dvector![1.0, 0.0, -2.0];
    let full = k.clone().lu().solve(&(s.transpose() * &load)).unwrap();
    let from_sensors = &reduced.transformation * reduced.stiffness.lu().solve(&load).unwrap();
    assert!((full - from_sensors).abs().max() < 1e-16);
}

/// A free structure and a sensor between dofs: K is singular, the held structure is not.
#[test]
fn a_sensor_between_dofs_of_a_free_structure() {
    let k = DMatrix::from_row_slice(3, 3, &[1.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]);
    let m = DMatrix::identity(3, 3);
    let s = DMatrix::from_row_slice(2, 3, &[0.5, 0.5, 0.0, 0.0, 0.0, 1.0]);
    let reduced = guyan(&k, &m, &s).unwrap();
    assert!((&s * &reduced.transformation - DMatrix::identity(2, 2)).abs().max() < 1e-14);
    // A rigid-body motion is interpolated as such.
    let rigid = &reduced.transformation * nalgebra::dvector![1.0, 1.0];
    assert!((rigid.add_scalar(-1.0)).abs().max() < 1e-14);
}

#[test]
fn failures_say_what_to_do() {
    let (k, m) = chain();
    assert_eq!(
        selection(3, &[0, 7]).unwrap_err().to_string(),
        "master dof 7 does not exist; the model has 3 dofs, counted from 0"
    );
    let twice = selection(3, &[1, 1]).unwrap();
    assert!(matches!(guyan(&k, &m, &twice), Err(ReductionError::Singular { .. })));
    // Held at dof 1, dofs 0 and 2 are single masses: ω² = 2 and 1.
    let one = selection(3, &[1]).unwrap();
    assert!(matches!(dynamic_reduction(&k, &m, &one, 1.0), Err(ReductionError::Singular { .. })));
    let massless = DMatrix::zeros(3, 3);
    assert_eq!(irs(&k, &massless, &one, 1).unwrap_err(), ReductionError::MasslessSensor);
    let phi = DMatrix::from_row_slice(3, 2, &[1.0, 2.0, 1.0, 2.0, 0.0, 1.0]);
    let error = serep(&k, &m, &selection(3, &[0, 1]).unwrap(), &phi).unwrap_err();
    assert!(matches!(error, ReductionError::DependentModes { rank: 1, .. }));
    assert!(matches!(guyan(&k, &DMatrix::zeros(2, 2), &one), Err(ReductionError::Shape { matrix: "mass", .. })));
    assert!(guyan(&(&k * f64::NAN), &m, &one).is_err());
}

proptest! {
    /// Guyan restricts the motion: frequencies never fall (Rayleigh); all methods interpolate the sensors.
    #[test]
    fn reductions_interpolate_and_guyan_bounds_from_above(
        springs in prop::collection::vec(0.1..10.0f64, 6), masses in prop::collection::vec(0.1..10.0f64, 6),
        first in 0usize..3, second in 3usize..6
    ) {
        let k = DMatrix::from_fn(6, 6, |i, j| match i.abs_diff(j) {
            0 => springs[i] + springs.get(i + 1).copied().unwrap_or(0.0),
            1 => -springs[i.max(j)],
            _ => 0.0,
        });
        let m = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(masses));
        let s = selection(6, &[first, second]).unwrap();
        let exact = frequencies(&k, &m, 2);
        let static_one = guyan(&k, &m, &s).unwrap();
        for (a, b) in frequencies(&static_one.stiffness, &static_one.mass, 2).iter().zip(&exact) {
            prop_assert!(*a >= b * (1.0 - 1e-11));
        }
        for reduced in [static_one, irs(&k, &m, &s, 1).unwrap()] {
            let at_sensors = &s * &reduced.transformation;
            prop_assert!((at_sensors - DMatrix::identity(2, 2)).abs().max() < 1e-11);
        }
    }
}
