//! Answers to loads on stand-ins: functions and static readings, as those of the model itself, and what changes do to them.

use super::*;
use crate::problem::changed::with_effect;
use crate::problem::fit::evaluate;
use crate::problem::scene::Scene;
use crate::screen::adjoint::{Answers, screen};
use crate::screen::effects::is_small;
use retune::data::{FrfFit, FrfQuantity, StaticReading};
use retune::effect::{Candidate, Context, candidates};
use retune::linalg::DVector;
use retune::objective::{LeastSquares, Objective};
use retune::update::{TwinFrfOptions, node_sensors, twin_frfs};

/// A synthetic test of functions of a dozen sensors under two forces, and of eight modes.
fn of_functions(model: &Model) -> TestData {
    let theta = middle(model);
    let mut sensors = node_sensors(model);
    sensors.retain(|s| !s.is_rotation);
    let step = sensors.len().div_ceil(12);
    sensors = sensors.into_iter().step_by(step).collect();
    let options = TwinOptions { damping: Some(0.01), ..noise(8, 5) };
    let mut test = twin_modes(model, &theta, &sensors, &options, "twin").unwrap();
    let last = test.modes.last().unwrap().frequency_hz.value;
    let functions = TwinFrfOptions {
        lines_hz: (1..=200).map(|k| last * f64::from(k) / 190.0).collect(),
        exciters: vec![sensors[4].name.clone(), sensors[9].name.clone()],
        quantity: FrfQuantity::Accelerance,
        force_noise: 0.0,
        response_noise: 0.0,
        n_averages: 1,
    };
    test.frfs = Some(twin_frfs(model, &theta, &sensors, &options, &functions).unwrap());
    test.frf_fit = Some(FrfFit { relative_sd: 0.02, loss_factor: Some(0.02), ..FrfFit::default() });
    test
}

/// Rows of answers of a scene at a point of the box.
fn rows(scene: &Scene, at: f64) -> DVector<f64> {
    let comparisons = scene.comparisons().unwrap();
    let names = ["static-deflection", "frf-log"];
    let objective = LeastSquares::from_names(&comparisons[0], &names).unwrap();
    let n = objective.n_parameters();
    objective.residuals(&DVector::from_fn(n, |i, _| at + 0.08 * ((i * 7) % 5) as f64)).unwrap()
}

#[test]
fn stand_ins_answer_as_the_model_does() {
    for text in [retune::samples::AEROPLANE, retune::samples::FRAME] {
        let model = model(text);
        let test = of_functions(&model);
        let full = Scene::new(&model, &[&test]).unwrap().large_from(usize::MAX).unwrap();
        let large = full.clone().large_from(0).unwrap();
        for at in [0.1, 0.35, 0.6] {
            let (own, other) = (rows(&large, at), rows(&full, at));
            let difference = &own - &other;
            let rms = difference.norm() / (difference.len() as f64).sqrt();
            assert!(rms < 0.01 && difference.amax() < 0.1, "{rms} {}", difference.amax());
        }
    }
}

/// Adjoint columns beside differences of the same stand-in with the change in it. Where a change releases what was held, or moves what is read, the stand-in
/// without it knows less of it: a quarter at most.
#[test]
fn changes_of_answers_are_those_of_differences() {
    let text = retune::samples::FRAME;
    let model = model(text);
    let mut test = of_functions(&model);
    let place = test.sensors[6].clone();
    let measured = retune::data::Measured { value: 1e-3, sd: 1e-5, sd_is_default: false };
    let mut pull = read_test(PULL).unwrap().0.static_tests.remove(0);
    pull.loads = vec![retune::data::StaticLoad {
        place: place.place.clone(),
        direction: place.direction,
        ..pull.loads[0].clone()
    }];
    pull.readings = [2, 6, 9].map(|sensor| StaticReading { sensor, measured }).to_vec();
    test.static_tests = vec![pull];
    let scene = Scene::new(&model, &[&test]).unwrap().large_from(0).unwrap();
    let fit = evaluate(&scene, scene.start(), 1.0).unwrap();
    let all: Vec<Candidate> = candidates(&model, &Effects::builtin(), &Context::default());
    let settings = Settings::default();
    let found = screen(&scene, &fit, 1.0, all, &settings, &Answers::default()).unwrap();
    let after_shapes = fit.rows.shape(fit.rows.n_modes, 0);
    let (mut compared, mut wrong) = (0, Vec::new());
    for screened in &found {
        for column in screened.columns.iter().filter(|c| is_small(&screened.candidate, &c.values)) {
            let changed = with_effect(&scene, &screened.candidate).unwrap();
            let comparisons = changed.comparisons().unwrap();
            let priors = vec![crate::problem::prior::Prior::NONE; changed.solved().parameters().free().len()];
            let posed = crate::problem::rows::Posed::new(&changed, &comparisons, priors, 1.0);
            let neutral: Vec<f64> = screened.candidate.parameters.iter().map(|p| p.neutral).collect();
            let step = 1e-3;
            let at = |share: f64| {
                let values: Vec<f64> = neutral.iter().zip(&column.values).map(|(n, v)| n + share * (v - n)).collect();
                posed.data_rows(&[fit.theta.clone(), values].concat())
            };
            let (Ok(after), Ok(before)) = (at(step), at(0.0)) else { continue };
            let n = fit.rows.measured - after_shapes;
            let other = (after - before).rows(after_shapes, n) / step;
            let own = column.delta.rows(after_shapes, n);
            if other.norm() < 1e-2 {
                continue;
            }
            compared += 1;
            let error = (own - &other).norm() / other.norm();
            assert!(error < 0.3, "{}: {error}", screened.candidate.id());
            if error > 0.02 {
                wrong.push(format!("{}: {error:.4} of {:.2e}", screened.candidate.id(), other.norm()));
            }
        }
    }
    assert!(compared > 200 && 10 * wrong.len() < compared, "of {compared} {wrong:#?}");
}

const PULL: &str = "
retune_test: 1
name: t
sources: {a: {kind: synthetic, text: by hand}}
sensors: {s: {node: a, direction: +x}}
static_tests: {pull: {source: a, loads: [{sensor: s, force: 100 N}], readings: {s: {value: 1 mm, sd: 0.01 mm}}}}
";
