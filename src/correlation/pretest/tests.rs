use super::*;

/// Bending modes of a clamped-free string of n points: sin((2r-1)π/2 · i/n).
fn modes(n: usize, n_modes: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n_modes, |i, r| {
        ((2 * r + 1) as f64 * std::f64::consts::FRAC_PI_2 * (i + 1) as f64 / n as f64).sin()
    })
}

/// One mode: E_D = φ²/Σφ², so the smallest entry goes first.
#[test]
fn effective_independence_of_one_mode_is_its_share_of_motion() {
    let phi = DMatrix::from_column_slice(3, 1, &[1.0, -3.0, 2.0]);
    let choice = effective_independence(&phi, 1).unwrap();
    assert_eq!(choice.kept, [1]);
    assert_eq!(choice.steps[0].0, 0);
    assert!((choice.steps[0].1 - 1.0 / 14.0).abs() < 1e-15 && (choice.steps[1].1 - 4.0 / 13.0).abs() < 1e-15);
    assert!((choice.ln_det_information - 9f64.ln()).abs() < 1e-14);
}

/// A candidate that repeats another adds nothing once one of the two is gone; a candidate that alone sees a mode stays.
#[test]
fn the_only_sensor_of_a_mode_is_kept() {
    let phi = DMatrix::from_row_slice(4, 2, &[1.0, 0.0, 1.0, 0.0, 0.9, 0.0, 0.0, 0.01]);
    let choice = effective_independence(&phi, 2).unwrap();
    assert!(choice.kept.contains(&3));
    assert!(effective_independence(&phi, 1).is_err());
    assert!(effective_independence(&phi, 5).is_err());
}

/// The greedy determinant is close to the best of all 4-subsets of 10, tried exhaustively.
#[test]
fn effective_independence_comes_close_to_the_best_subset() {
    let phi = modes(10, 3);
    let choice = effective_independence(&phi, 4).unwrap();
    let mut best = f64::NEG_INFINITY;
    for mask in 0u32..1024 {
        if mask.count_ones() == 4 {
            let rows: Vec<usize> = (0..10).filter(|i| mask >> i & 1 == 1).collect();
            best = best.max(SensorChoice::new(&phi, rows, Vec::new()).ln_det_information);
        }
    }
    assert!(choice.ln_det_information > best - 0.3, "{} {best}", choice.ln_det_information);
}

#[test]
fn sensors_by_mac_tell_modes_apart() {
    let phi = modes(20, 4);
    let choice = sensors_by_auto_mac(&phi, &[], 8).unwrap();
    assert_eq!(choice.kept.len(), 8);
    assert!(choice.largest_off_diagonal < 0.05, "{}", choice.largest_off_diagonal);
    let continued = sensors_by_auto_mac(&phi, &[0, 1], 5).unwrap();
    assert!(continued.kept.starts_with(&[0, 1]) && continued.steps.len() == 3);
    assert!(sensors_by_auto_mac(&phi, &[30], 5).is_err());
}

#[test]
fn kinetic_energy_and_effective_mass_add_up() {
    let k = DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]);
    let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 2.0, 3.0]);
    let phi = crate::linalg::lowest_modes(&k, &m, 3, 0.1).unwrap().vectors * 2.5;
    let shares = kinetic_energy_shares(&phi, &(&m * &phi));
    for r in 0..3 {
        assert!((shares.column(r).sum() - 1.0).abs() < 1e-13);
    }
    assert_eq!(
        sensors_by_kinetic_energy(&phi.columns(0, 1).into_owned(), &shares.columns(0, 1).into_owned(), 1).kept,
        [2]
    );
    // All modes together carry the total mass of 6.
    let effective = effective_masses(&phi, &(&m * &phi), &DMatrix::from_element(3, 1, 1.0));
    assert!((effective.sum() - 6.0).abs() < 1e-12);
    assert!(effective[(0, 0)] > 5.0);
}

#[test]
fn an_exciter_must_not_stand_on_a_node_line() {
    let phi = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.7, 0.7, 0.1, 1.0]);
    let points = rank_driving_points(&phi, &[4.0, 0.0]);
    assert_eq!(points.iter().map(|p| p.candidate).collect::<Vec<_>>(), [1, 2, 0]);
    assert!((points[0].optimum - 0.49).abs() < 1e-15 && (points[0].displacement - 0.49 / 4.0).abs() < 1e-15);
    assert_eq!(points[2].smallest, 0.0);
}

/// By hand: no data, priors 1: a reading of x₁ with σ = 1/√3 has det(1 + 3) = 4, half its logarithm is ln 2, and the
/// standard deviation halves.
#[test]
fn the_next_measurement_by_hand() {
    let candidates = [DMatrix::from_row_slice(1, 2, &[0.0, 0.5]), DMatrix::from_row_slice(1, 2, &[3f64.sqrt(), 0.0])];
    let gains = rank_next_measurements(&DMatrix::zeros(0, 2), &[1.0, 1.0], &candidates).unwrap();
    assert_eq!(gains[0].candidate, 1);
    assert!((gains[0].nats - 2f64.ln()).abs() < 1e-15);
    assert!((gains[0].sd_ratio[0] - 0.5).abs() < 1e-15 && gains[0].sd_ratio[1] == 1.0);
    // After it was made, asking again gives less.
    let again = rank_next_measurements(&candidates[1], &[1.0, 1.0], &candidates).unwrap();
    assert!(again.iter().find(|g| g.candidate == 1).unwrap().nats < gains[0].nats);
    assert!(rank_next_measurements(&DMatrix::zeros(0, 3), &[1.0, 1.0], &candidates).is_err());
    assert!(rank_next_measurements(&DMatrix::zeros(0, 2), &[1.0, 0.0], &candidates).is_err());
}
