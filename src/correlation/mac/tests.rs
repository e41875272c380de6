use super::*;
use proptest::prelude::*;

/// Small shapes from formulas, so that a peer can be given the same numbers: entry (i, j), i the sensor.
pub(in crate::correlation) fn peer_shapes() -> (DMatrix<f64>, DMatrix<f64>) {
    let a = DMatrix::from_fn(6, 3, |i, j| (0.37 * (i + 1) as f64 * (j + 1) as f64).sin() + 0.1 * j as f64);
    let x = DMatrix::from_fn(6, 2, |i, j| (0.41 * (i + 1) as f64 * (j + 1) as f64).sin() - 0.2 * (i * j) as f64 / 5.0);
    (a, x)
}

fn peer_complex_shapes() -> (DMatrix<Complex<f64>>, DMatrix<Complex<f64>>) {
    let (a, x) = peer_shapes();
    let a = DMatrix::from_fn(6, 3, |i, j| Complex::new(a[(i, j)], (0.9 * (i + 1) as f64 + j as f64).cos()));
    let x = DMatrix::from_fn(6, 2, |i, j| Complex::new(x[(i, j)], (0.8 * (i + 1) as f64 - j as f64).cos()));
    (a, x)
}

/// Two vectors at 60 degrees: the MAC is cos² = 1/4, by hand.
#[test]
fn mac_is_the_squared_cosine() {
    let a = DMatrix::from_column_slice(2, 1, &[2.0, 0.0]);
    let x = DMatrix::from_column_slice(2, 1, &[0.5, 3.0f64.sqrt() / 2.0]);
    assert!((mac_matrix(&a, &x)[(0, 0)] - 0.25).abs() < 1e-15);
}

#[test]
fn mac_of_a_zero_column_is_zero() {
    let a = DMatrix::from_column_slice(2, 2, &[0.0, 0.0, 1.0, 1.0]);
    assert_eq!(auto_mac(&a), DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, auto_mac(&a)[(1, 1)]]));
}

/// A common phase of 0.7 rad leaves a Hermitian MAC at one; with plain transposes it would be 0.13 - 0.99i.
#[test]
fn a_common_phase_changes_nothing() {
    let (a, _) = peer_complex_shapes();
    let turned = a.map(|v| v * Complex::from_polar(3.0, 0.7));
    for j in 0..3 {
        assert!((mac_matrix(&a, &turned)[(j, j)] - 1.0).abs() < 1e-15);
    }
}

/// sdynpy 0.23.0 (`sdynpy_correlation.mac`, `msf`) and sdypy-EMA 0.31.0 (`MAC`, `MSF`) on the same numbers.
#[test]
fn peers_give_the_same_mac_and_scale_factors() {
    let (a, x) = peer_shapes();
    #[rustfmt::skip]
    let expected = DMatrix::from_row_slice(3, 2, &[
        0.9901606659114967, 0.0327727783103646,
        0.1262091696509222, 0.801746154176662,
        0.010238204631743,  0.221195685024395,
    ]);
    assert!((mac_matrix(&a, &x) - expected).abs().max() < 1e-14);
    for (j, expected) in [0.9724833356610992, 0.9615867104927521].into_iter().enumerate() {
        let factor = modal_scale_factor(a.column(j).as_slice(), x.column(j).as_slice());
        assert!((factor - expected).abs() < 1e-14);
    }
    let (a, x) = peer_complex_shapes();
    #[rustfmt::skip]
    let expected = DMatrix::from_row_slice(3, 2, &[
        0.9119911244788205, 0.006738354674061,
        0.052501635192808,  0.7352034715375255,
        0.0865897389334857, 0.6385625092916261,
    ]);
    assert!((mac_matrix(&a, &x) - expected).abs().max() < 1e-14);
    let expected =
        [Complex::new(0.9347925484758577, -0.0820564406887294), Complex::new(0.1192893144001842, 0.9081713113990596)];
    for (j, expected) in expected.into_iter().enumerate() {
        let factor = modal_scale_factor(a.column(j).as_slice(), x.column(j).as_slice());
        assert!((factor - expected).norm() < 1e-14);
    }
}

#[test]
fn a_missing_entry_leaves_the_sensor_out_of_that_pair_only() {
    let (a, mut x) = peer_shapes();
    let full = mac_matrix(&a, &x);
    x[(2, 0)] = f64::NAN;
    let masked = mac_matrix(&a, &x);
    let without = mac_matrix(&a.clone().remove_row(2), &x.clone().remove_row(2));
    assert!((masked.column(0) - without.column(0)).abs().max() < 1e-15);
    assert!((masked.column(1) - full.column(1)).abs().max() < 1e-15);
    let identity = DMatrix::identity(6, 6);
    assert!((weighted_mac_matrix(&a, &x, &identity) - &masked).abs().max() < 1e-14);
    x.column_mut(0).fill(f64::NAN);
    assert_eq!(mac_matrix(&a, &x).column(0).max(), 0.0);
}

/// φᵀMφ by hand: M = diag(1, 3), φ = (1, 1), (3, -1) are M-orthogonal though not orthogonal.
#[test]
fn modes_of_one_model_are_orthogonal_in_the_mass_only() {
    let phi = DMatrix::from_column_slice(2, 2, &[1.0, 1.0, 3.0, -1.0]);
    let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 3.0]);
    assert!((weighted_mac_matrix(&phi, &phi, &m) - DMatrix::identity(2, 2)).abs().max() < 1e-15);
    assert!((auto_mac(&phi)[(0, 1)] - 4.0 / 20.0).abs() < 1e-15);
}

proptest! {
    #[test]
    fn mac_lies_between_zero_and_one_and_ignores_scale_and_phase(
        parts in prop::collection::vec(-1.0..1.0f64, 24), size in -80.0..80.0f64, phase in 0.0..6.3f64
    ) {
        let a = DMatrix::from_fn(6, 1, |i, _| Complex::new(parts[2 * i], parts[2 * i + 1]));
        let x = DMatrix::from_fn(6, 1, |i, _| Complex::new(parts[12 + 2 * i], parts[13 + 2 * i]));
        let mac = mac_matrix(&a, &x)[(0, 0)];
        prop_assert!((0.0..=1.0).contains(&mac));
        let factor = Complex::from_polar(10f64.powf(size), phase);
        prop_assert!((mac_matrix(&a.map(|v| v * factor), &x)[(0, 0)] - mac).abs() < 1e-13);
        let there = modal_scale_factor(a.as_slice(), x.as_slice());
        let back = modal_scale_factor(x.as_slice(), a.as_slice());
        prop_assert!(((there * back).norm() - mac).abs() < 1e-13);
    }
}
