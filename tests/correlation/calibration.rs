//! The stated probabilities hold: on synthetic tests of right models p-values are uniform and intervals cover.
//!
//! 200 tests a structure. Noise: 0.3 % of frequencies, 2 % of shapes.

use super::*;
use retune::correlation::{Misfit, information};
use retune::linalg::{DVector, thin_svd};
use retune::objective::{Comparison, LeastSquares, Objective, starting_point};
use retune::update::{PlacesOptions, assess, mode_agreement, places, sensor_agreement};

const NOISE: (f64, f64) = (0.003, 0.02);

const N_TESTS: u64 = 200;

/// Kolmogorov-Smirnov distance from the uniform distribution, and what a uniform sample exceeds once in a thousand.
fn kolmogorov_smirnov(mut p: Vec<f64>) -> (f64, f64) {
    p.sort_by(f64::total_cmp);
    let n = p.len() as f64;
    let distance = p
        .iter()
        .enumerate()
        .map(|(k, p)| (p - k as f64 / n).abs().max((p - (k + 1) as f64 / n).abs()))
        .fold(0.0, f64::max);
    // 1.95/√n: the asymptotic quantile at 0.999.
    (distance, 1.95 / n.sqrt())
}

fn assert_uniform(what: &str, p: Vec<f64>) {
    let n = p.len();
    let (distance, limit) = kolmogorov_smirnov(p);
    eprintln!("{what}: KS distance {distance:.3} of {n} p-values, limit {limit:.3}");
    assert!(distance < limit, "{what}: distance {distance}, limit {limit}");
}

/// One number a test for each kind, so that the numbers are independent: mode, sensor and place change with the seed.
fn p_values(file: &str, n_modes: usize) {
    let model = model(file);
    let sensors = sensors(file, &model);
    let theta = starting_point(&model);
    let (mut whole, mut by_mode, mut by_sensor, mut by_place) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut family, mut single, mut single_family) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..N_TESTS {
        let test = twin(&model, &sensors, n_modes, NOISE, 1000 + seed);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        let a = assess(&comparison, &theta).unwrap();
        assert_eq!(a.pairs.len(), n_modes, "{file} seed {seed}");
        let pick = |n: usize| seed as usize % n;
        whole.push(a.misfit.p_value);
        let modes = mode_agreement(&comparison, &a).unwrap();
        by_mode.push(modes[pick(modes.len())].misfit.p_value);
        // A sensor that no mode moves has no residual.
        let sensors = sensor_agreement(&comparison, &a, 0).unwrap().unwrap().sensors;
        let alive: Vec<&Misfit> = sensors.iter().map(|s| &s.misfit).filter(|m| m.n_data > 0).collect();
        by_sensor.push(alive[pick(alive.len())].p_value);
        let found = places(&model, &comparison, &a, PlacesOptions::default()).unwrap();
        let mut ranked = found.by_element.places.clone();
        ranked.sort_by(|a, b| a.name.cmp(&b.name));
        by_place.push(ranked[pick(ranked.len())].p_value);
        family.push(found.by_element.p_family);
        let mut changes = found.changes_by_element.changes.clone();
        changes.sort_by(|a, b| a.name.cmp(&b.name));
        single.push(changes[pick(changes.len())].p_value);
        single_family.push(found.changes_by_element.p_family);
    }
    let false_alarms = family.iter().filter(|p| **p < 0.05).count();
    for (what, p) in [
        ("whole comparison", whole),
        ("one mode", by_mode),
        ("one sensor", by_sensor),
        ("energy in one place", by_place),
        ("energy in the highest place", family),
        ("one single change", single),
        ("largest single change", single_family),
    ] {
        assert_uniform(&format!("{file}, {what}"), p);
    }
    // 5 % of the tests expected, three standard deviations more allowed.
    let n = N_TESTS as f64;
    let limit = 0.05 * n + 3.0 * (0.05 * 0.95 * n).sqrt();
    assert!((false_alarms as f64) < limit, "{file}: {false_alarms} false alarms at 5 %");
}

#[test]
fn p_values_of_right_models_are_uniform() {
    for (file, n_modes) in [("bff.yaml", 6), ("frame.yaml", 5), ("cantilever.yaml", 4)] {
        p_values(file, n_modes);
    }
}

/// Intervals of 90 % around the parameters of one linear step from the truth cover it in 90 % of the tests.
#[test]
fn ninety_per_cent_intervals_cover() {
    let (mut inside, mut count) = (0, 0);
    for (file, n_modes) in [("frame.yaml", 5), ("two_storey_frame.yaml", 5)] {
        let model = model(file);
        let sensors = sensors(file, &model);
        let theta = starting_point(&model);
        let mut first = Vec::new();
        for seed in 0..N_TESTS {
            let test = twin(&model, &sensors, n_modes, NOISE, 5000 + seed);
            let comparison = Comparison::new(&model, &test, OPEN).unwrap();
            let objective = LeastSquares::from_names(&comparison, &["frequency", "shape"]).unwrap();
            let x = objective.scaling().x(&theta);
            let linear = objective.linearize(&x).unwrap();
            let svd = thin_svd(&linear.jacobian).unwrap();
            let step: DVector<f64> = svd.pseudo_inverse(1e-9) * &linear.residuals;
            let known = information(&linear.jacobian, None, 1e-9).unwrap();
            // The 95 % quantile of a normal number: an interval of 90 %.
            let covers: Vec<bool> = known
                .iter()
                .zip(step.iter())
                .filter_map(|(i, s)| i.sd.map(|sd| s.abs() <= 1.6448536269514722 * sd))
                .collect();
            inside += covers.iter().filter(|c| **c).count();
            count += covers.len();
            first.extend(covers.first().copied());
        }
        // One parameter a test: independent trials.
        let n = first.len() as f64;
        let share = first.iter().filter(|c| **c).count() as f64 / n;
        eprintln!("{file}: {:.1} % of the intervals of its first parameter cover", 100.0 * share);
        assert!((share - 0.9).abs() < 3.0 * (0.09 / n).sqrt(), "{file}: {share}");
    }
    eprintln!("all parameters: {inside} of {count} cover");
}
