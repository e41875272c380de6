use super::*;
use crate::linalg::Complex;

/// scipy 1.17.1, `stats.chi2.sf`, `ppf` and `cdf`.
#[test]
fn tails_keep_their_digits() {
    for (x, n, expected) in [
        (412.0, 190, 1.836480771196422e-18),
        (1000.0, 190, 4.0715662853781855e-110),
        (1300.0, 30, 1.440146461904134e-254),
        (3.0, 2, (-1.5f64).exp()),
    ] {
        let misfit = Misfit::new(x, n).unwrap();
        assert!((misfit.p_value / expected - 1.0).abs() < 1e-10, "{x} {n} {}", misfit.p_value);
    }
    let misfit = Misfit::new(190.0, 190).unwrap();
    assert!(
        (misfit.expected.0 - 153.72134613).abs() < 1e-6 && (misfit.expected.1 - 230.06438746).abs() < 1e-6,
        "{misfit:?}"
    );
}

#[test]
fn misfits_speak() {
    assert_eq!(
        Misfit::new(412.0, 190).unwrap().to_string(),
        "chi-squared 412 for 190 data: noise alone gives this in 1 of 10^17"
    );
    assert_eq!(
        Misfit::new(3.0, 2).unwrap().to_string(),
        "chi-squared 3.00 for 2 data: noise alone gives this in 22 of 100"
    );
    assert!(Misfit::new(100.0, 190).unwrap().to_string().contains("the standard deviations may be too large"));
    assert_eq!(odds(1.0 / 350.0), "1 of 350");
    assert_eq!(odds(0.0), "less than 1 of 10^300");
    assert_eq!(Misfit::new(0.0, 0).unwrap().p_value, 1.0);
    assert!(Misfit::new(f64::NAN, 3).is_err());
}

/// By hand: a = (1, 1)/1, b = (1, 3): scale 2, residuals (1, -1), χ² = 2 for one datum.
#[test]
fn the_free_scale_is_taken_out() {
    let residual = shape_residual(&[1.0, 1.0], &[1.0, 3.0], &[1.0, 1.0]).unwrap();
    assert_eq!(residual.scale, 2.0);
    assert_eq!(residual.residuals.as_slice(), [1.0, -1.0]);
    assert_eq!((residual.misfit.chi_squared, residual.misfit.n_data), (2.0, 1));
    let sensors = sensor_misfits(&[residual]).unwrap();
    assert!((sensors[0].chi_squared - 2.0).abs() < 1e-15 && sensors[0].n_data == 1);
    let one = shape_residual(&[1.0, f64::NAN], &[4.0, 1.0], &[1.0, 1.0]).unwrap();
    assert_eq!((one.misfit.n_data, one.misfit.chi_squared), (0, 0.0));
    assert!(shape_residual(&[1.0], &[1.0], &[0.0]).is_err());
    assert!(shape_residual(&[1.0], &[1.0, 2.0], &[1.0]).is_err());
}

/// Kolmogorov-Smirnov distance of sorted numbers from the uniform distribution.
fn distance_from_uniform(mut p: Vec<f64>) -> f64 {
    p.sort_by(f64::total_cmp);
    let n = p.len() as f64;
    p.iter().enumerate().map(|(k, p)| (p - k as f64 / n).abs().max((p - (k + 1) as f64 / n).abs())).fold(0.0, f64::max)
}

/// 1.63/√n: the distance that a uniform sample exceeds once in a hundred.
fn critical_distance(n: usize) -> f64 {
    1.63 / (n as f64).sqrt()
}

/// 400 noisy tests of a right model: p-values of modes and sensors are uniform.
#[test]
fn p_values_of_a_true_model_are_uniform() {
    let mut gaussian = Gaussian::new(7);
    let n = 400;
    let (mut by_mode, mut by_sensor) = (Vec::new(), Vec::new());
    let a: Vec<Complex<f64>> =
        (0..9).map(|i| Complex::new((0.7 * f64::from(i)).sin() + 0.2, 0.1 * f64::from(i))).collect();
    let sd: Vec<f64> = (0..9).map(|i| 0.01 * (1.0 + f64::from(i))).collect();
    for _ in 0..n {
        let modes: Vec<_> = (0..3)
            .map(|_| {
                let x: Vec<_> = a
                    .iter()
                    .zip(&sd)
                    .map(|(a, s)| a * Complex::new(0.4, -1.2) + Complex::new(gaussian.next(), gaussian.next()) * *s)
                    .collect();
                shape_residual(&a, &x, &sd).unwrap()
            })
            .collect();
        by_mode.push(modes[0].misfit.p_value);
        by_sensor.push(sensor_misfits(&modes).unwrap()[8].p_value);
    }
    assert!(distance_from_uniform(by_mode) < critical_distance(n));
    assert!(distance_from_uniform(by_sensor) < critical_distance(n));
}

/// Bands and sums add chi-squared and data; fitted parameters are taken off.
#[test]
fn misfits_add_up() {
    let parts = [Misfit::new(3.0, 4).unwrap(), Misfit::new(5.0, 2).unwrap(), Misfit::new(1.0, 1).unwrap()];
    let bands = band_misfits(&parts, &[5.0, 10.0, 20.0], &[0.0, 10.0, 25.0]).unwrap();
    assert_eq!((bands[0].chi_squared, bands[1].chi_squared, bands[1].n_data), (3.0, 6.0, 3));
    assert_eq!(Misfit::combine(&parts, 2).unwrap().n_data, 5);
    assert_eq!(Misfit::of_residuals(&[1.0, f64::NAN, 2.0]).unwrap().chi_squared, 5.0);
}

/// By hand: f_x = 10 ± 0.2, f_a = 10.5, t = 0.05: passing needs f_x in [10, 11.0526], so Φ(5.26) - Φ(0) = 0.5.
#[test]
fn probability_of_a_frequency() {
    assert!((probability_of_frequency((10.5, 0.0), (10.0, 0.2), 0.05) - 0.5).abs() < 1e-6);
    assert_eq!(probability_of_frequency((10.5, 0.0), (10.0, 0.0), 0.05), 1.0);
    assert_eq!(probability_of_frequency((10.51, 0.0), (10.0, 0.0), 0.05), 0.0);
}

/// 300 noisy tests of a shape whose true MAC is 0.9: the confidence is uniform.
#[test]
fn confidence_in_a_mac_is_calibrated() {
    let a: Vec<f64> = (0..20).map(|i| (0.3 * f64::from(i)).sin()).collect();
    let other: Vec<f64> = (0..20).map(|i| (0.7 * f64::from(i)).cos()).collect();
    let dot = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
    let across: Vec<f64> = other.iter().zip(&a).map(|(o, v)| o - v * dot(&other, &a) / dot(&a, &a)).collect();
    let (na, nc) = (dot(&a, &a).sqrt(), dot(&across, &across).sqrt());
    let truth: Vec<f64> = a.iter().zip(&across).map(|(v, c)| 0.9f64.sqrt() * v / na + 0.1f64.sqrt() * c / nc).collect();
    let sd = vec![0.02; 20];
    let mut gaussian = Gaussian::new(3);
    let p: Vec<f64> = (0..300)
        .map(|k| {
            let x: Vec<f64> = truth.iter().map(|t| t + 0.02 * gaussian.next()).collect();
            probability_of_mac(&a, &x, &sd, 0.9, 400, k)
        })
        .collect();
    assert!(distance_from_uniform(p) < critical_distance(300));
    assert_eq!(probability_of_mac(&a, &truth, &[0.0; 20], 0.89, 100, 1), 1.0);
    assert_eq!(probability_of_mac(&a, &truth, &[0.0; 20], 0.91, 100, 1), 0.0);
}

/// 300 noisy tests of a shape whose true cross-orthogonality is 0.95, in a mass that couples sensors: the confidence is
/// uniform; with the unit mass it is that of the MAC.
#[test]
fn confidence_in_a_cross_orthogonality_is_calibrated() {
    let mass = DMatrix::from_fn(20, 20, |i, j| match i.abs_diff(j) {
        0 => 2.0 + (i as f64).sin(),
        1 => 0.4,
        _ => 0.0,
    });
    let a = DVector::from_fn(20, |i, _| (0.3 * i as f64).sin());
    let other = DVector::from_fn(20, |i, _| (0.7 * i as f64).cos());
    let dot = |u: &DVector<f64>, v: &DVector<f64>| u.dot(&(&mass * v));
    let across = &other - &a * (dot(&other, &a) / dot(&a, &a));
    let truth = &a * (0.95 / dot(&a, &a).sqrt()) + &across * ((1.0 - 0.95_f64.powi(2)) / dot(&across, &across)).sqrt();
    let sd = vec![0.01; 20];
    let mut gaussian = Gaussian::new(5);
    let p: Vec<f64> = (0..300)
        .map(|k| {
            let x = truth.map(|t| t + 0.01 * gaussian.next());
            probability_of_cross_orthogonality(a.as_slice(), x.as_slice(), &sd, &mass, 0.95, 400, k)
        })
        .collect();
    assert!(distance_from_uniform(p) < critical_distance(300));
    let (x, unit) = (truth.map(|t| t + 0.01), DMatrix::identity(20, 20));
    let by_mass = probability_of_cross_orthogonality(a.as_slice(), x.as_slice(), &sd, &unit, 0.9, 400, 1);
    assert_eq!(by_mass, probability_of_mac(a.as_slice(), x.as_slice(), &sd, 0.9 * 0.9, 400, 1));
}

#[test]
fn normal_numbers_have_their_moments() {
    let mut gaussian = Gaussian::new(1);
    let n = 100_000;
    let values: Vec<f64> = (0..n).map(|_| gaussian.next()).collect();
    let moment = |p: i32| values.iter().map(|v| v.powi(p)).sum::<f64>() / f64::from(n);
    // Standard errors 1/√n, √2/√n, √96/√n; four of them.
    let se = 4.0 / f64::from(n).sqrt();
    assert!(moment(1).abs() < se && (moment(2) - 1.0).abs() < 1.42 * se && (moment(4) - 3.0).abs() < 9.8 * se);
}
