use super::terms::COUPLING;
use super::*;
use std::f64::consts::{PI, TAU};

/// Shapes of a string at n sensors.
fn shape(mode: usize, n: usize) -> DVector<f64> {
    DVector::from_fn(n, |i, _| (PI * mode as f64 * (i + 1) as f64 / (n + 1) as f64).sin())
}

fn modelled(n_modes: usize, n: usize) -> Vec<Modelled> {
    (1..=n_modes)
        .map(|k| Modelled {
            frequency: 10.0 * k as f64,
            shape: shape(k, n),
            d_ln_f: DVector::from_element(1, 0.5),
            d_shape: DMatrix::zeros(n, 1),
            label: None,
        })
        .collect()
}

fn pairings(tests: &[(f64, Option<Vec<f64>>)], model: &[Modelled], given: Vec<Option<usize>>) -> Pairings {
    let n = model[0].shape.len();
    let sd = vec![0.02; n];
    let measured: Vec<Measured<'_>> = tests
        .iter()
        .map(|(f, s)| Measured {
            frequency: (*f, 0.003 * f),
            shape: s.as_deref(),
            shape_sd: s.as_ref().map(|_| sd.as_slice()),
            label: None,
        })
        .collect();
    Pairings::new(&measured, model, |_, _| true, given, 1)
}

/// The spread of the parameter.
fn spread() -> DMatrix<f64> {
    DMatrix::from_element(1, 1, 0.3)
}

fn of(mode: usize, n: usize) -> Option<Vec<f64>> {
    Some(shape(mode, n).iter().enumerate().map(|(i, v)| v + 0.02 * ((7 * i + mode) as f64).sin()).collect())
}

#[test]
fn true_modes_are_paired_and_a_foreign_one_is_not() {
    let model = modelled(6, 12);
    let random: Vec<f64> = (0..12).map(|i| f64::from(37 * i * i + 11).sin()).collect();
    let tests = [(10.6, of(1, 12)), (20.5, of(2, 12)), (24.0, Some(random)), (30.2, of(3, 12)), (41.0, None)];
    let p = pairings(&tests, &model, vec![None; 5]);
    let seen = p.seen(Some(&spread()), 0.0);
    let odds = seen.ln_odds(seen.level().0);
    assert_eq!(best(&odds), [Some(0), Some(1), None, Some(2), Some(3)]);
    let p = marginals(&odds);
    assert!(p[(0, 0)] > 0.99 && p[(3, 2)] > 0.99 && p[(4, 3)] > 0.5, "{p}");
    assert!(p.row(2).sum() < 0.01, "{p}");
}

/// One sensor that moves alone far from where the model has such a mode is what it is glued to; where the model has it, it is that mode.
#[test]
fn a_sensor_that_moves_alone_is_foreign_unless_the_model_says_so() {
    let mut model = modelled(6, 12);
    let local = DVector::from_fn(12, |i, _| if i == 10 { 1.0 } else { 0.0 });
    model.push(Modelled { frequency: 70.0, shape: local.clone(), ..model[0].clone() });
    let noisy = |phase: f64| -> Option<Vec<f64>> {
        Some(local.iter().enumerate().map(|(i, v)| v + 0.02 * (phase + 7.0 * i as f64).sin()).collect())
    };
    let tests = [(10.1, of(1, 12)), (14.0, noisy(0.3)), (20.3, of(2, 12)), (70.6, noisy(1.1))];
    let p = pairings(&tests, &model, vec![None; 4]);
    for misread in [0.0, 0.01] {
        let seen = p.seen(Some(&spread()), misread);
        let odds = seen.ln_odds(seen.level().0);
        assert_eq!(best(&odds), [Some(0), None, Some(1), Some(6)], "{misread}: {odds}");
    }
    // Without the second of them the model's mode is free, and its frequency would have been noted wrongly by a factor of five.
    let p = pairings(&tests[..3], &model, vec![None; 3]);
    let p = marginals(&p.seen(Some(&spread()), 0.01).ln_odds(Level::NONE));
    assert!(p.row(1).sum() < 0.9, "{p}");
}

/// A frequency that was noted wrongly by a third is a foreign mode to a fit, and a slip where that is a hypothesis.
#[test]
fn a_misread_frequency_keeps_its_shape() {
    let model = modelled(6, 12);
    let tests = [(10.0, of(1, 12)), (20.0, of(2, 12)), (3.1, of(3, 12)), (40.0, of(4, 12))];
    let p = pairings(&tests, &model, vec![None; 4]);
    assert_eq!(best(&p.seen(Some(&spread()), 0.01).ln_odds(Level::NONE)), [Some(0), Some(1), Some(2), Some(3)]);
    assert_eq!(best(&p.seen(Some(&spread()), 0.0).ln_odds(Level::NONE)), [Some(0), Some(1), None, Some(3)]);
}

#[test]
fn a_named_partner_is_taken_and_kept_from_others() {
    let model = modelled(4, 12);
    let tests = [(10.0, of(1, 12)), (20.0, of(2, 12))];
    let p = pairings(&tests, &model, vec![Some(1), None]);
    let pairs = best(&p.seen(Some(&spread()), 0.0).ln_odds(Level::NONE));
    assert_eq!(pairs[0], Some(1));
    assert_ne!(pairs[1], Some(1));
}

/// Against all one-to-one matchings, counted: exact where one mode is measured, and near for two by two.
#[test]
fn marginals_are_those_of_all_matchings() {
    let one: DMatrix<f64> = DMatrix::from_row_slice(1, 3, &[1.0, -0.5, 2.0]);
    let sum = 1.0 + one.iter().map(|v| v.exp()).sum::<f64>();
    for a in 0..3 {
        assert!((marginals(&one)[(0, a)] - one[(0, a)].exp() / sum).abs() < 1e-9);
    }
    let two: DMatrix<f64> = DMatrix::from_row_slice(2, 2, &[3.0, 0.0, 2.0, 1.0]);
    let e = |i: usize, a: usize| two[(i, a)].exp();
    let all = 1.0 + e(0, 0) + e(0, 1) + e(1, 0) + e(1, 1) + e(0, 0) * e(1, 1) + e(0, 1) * e(1, 0);
    let exact = (e(0, 0) + e(0, 0) * e(1, 1)) / all;
    assert!((marginals(&two)[(0, 0)] - exact).abs() < 0.05, "{} against {exact}", marginals(&two)[(0, 0)]);
    // Odds of hundreds of nats neither overflow nor tie.
    let sure = DMatrix::from_row_slice(2, 2, &[900.0, 850.0, 880.0, -1e6]);
    let p = marginals(&sure);
    assert!(p[(0, 1)] > 0.999 && p[(1, 0)] > 0.999, "{p}");
}

/// ln p and its normal equations against dense matrices.
#[test]
fn the_density_is_that_of_the_dense_covariance() {
    let n = 5;
    let mut model = modelled(3, n);
    for (k, m) in model.iter_mut().enumerate() {
        m.d_shape = DMatrix::from_fn(n, 1, |i, _| 0.3 * ((i + 2 * k) as f64).cos());
    }
    let y = of(2, n).unwrap();
    let form = Form { tau: 0.02, k: 2.0 };
    let tests = [(20.9, Some(y.clone()))];
    let p = pairings(&tests, &model, vec![None]);
    let found = p.terms[0][1].spread(&spread()).ln_density(form, true);
    // Dense: rows frequency, then sensors.
    let y = DVector::from_vec(y);
    let (length, u) = (y.norm(), model[1].shape.clone().normalize());
    let s = 0.02 / length;
    let y = y / length;
    let c = u.dot(&y).abs();
    let project = |v: DVector<f64>| &v - &u * u.dot(&v);
    let rows = |f: f64, v: DVector<f64>| {
        let mut out = DVector::zeros(n + 1);
        out[0] = f / 0.003;
        out.rows_mut(1, n).copy_from(&(project(v) / (form.k * s)));
        out
    };
    let norm = model[1].shape.norm();
    let z = rows((20.9_f64 / 20.0).ln(), y);
    let mut columns =
        vec![rows(0.15, model[1].d_shape.column(0) * (0.3 * c / norm)), rows(form.tau, DVector::zeros(n))];
    for b in [0, 2] {
        let (la, lb) = (400.0_f64, (10.0 * (b + 1) as f64).powi(2));
        let mixed = (2.0 * COUPLING * form.tau * (la * lb).sqrt() / (la - lb).abs()).min(1.0);
        columns.push(rows(0.0, &model[b].shape * (c * mixed / norm)));
    }
    let w = DMatrix::from_columns(&columns);
    let covariance = DMatrix::identity(n + 1, n + 1) + &w * w.transpose();
    let chi2 = z.dot(&covariance.clone().lu().solve(&z).unwrap());
    let expected = -0.5 * chi2
        - 0.5 * covariance.determinant().ln()
        - (0.003 * TAU.sqrt()).ln()
        - (n as f64 - 1.0) * (form.k * s * TAU.sqrt()).ln();
    assert!((found - expected).abs() < 1e-8 * expected.abs(), "{found} against {expected}");
}
