//! The flagship with a page that computes, and what this library computes at the same points: `tests/browser/live.test.mjs` holds one against the other.

use rand::{RngExt, SeedableRng};
use retune::correlation::{observation_matrix, sensor_position};
use retune::data::{TestData, read_test};
use retune::effect::{Context, Effects, Structure, candidates};
use retune::fault::{Bench, Faults, Number, PlacedFault, SingleTest};
use retune::modal::{ModalDamping, SolveOptions, synthesize};
use retune::model::{Model, ParametricModel, Registry, load, load_configuration, solve_modes};
use retune::objective::Comparison;
use retune::update::{
    Controls, HowToPair, Settings, TwinOptions, assess, compared, freed, node_sensors, paired_test, twin_modes, update,
};
use retune_diagnosis::{Estimate, HypothesisResult, Kind, sensor_loads};
use retune_report::data::{LiveParameter, ReportData};
use retune_report::{Case, add_live, add_tests, assess_paired, html, live, of_comparison};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Faults whose first place has a switch: without a number, with a factor, an angle, noise, silence, a frequency.
const FAULTS: [&str; 6] =
    ["sensor-swap", "sensor-gain", "sensor-tilted", "sensor-noisy", "sensor-dead", "mode-frequency"];

/// Random points of the parameters, and of each hypothesis.
const POINTS: usize = 20;
const POINTS_OF_A_HYPOTHESIS: usize = 3;
/// Points with a frequency response.
const FUNCTIONS: usize = 5;

/// What `learn` finds first on the flagship: the bodies of the wings sit behind the spar.
const OFFSET: &str = "mass-offset@left_wing+right_wing.y_lumps";
/// Σ ((model - test)/σ)² that `retune learn models/bff.yaml models/bff_gvt.yaml` prints of the model as it was, fitted, and with the offset.
const LEARNT: [f64; 2] = [6818.0, 334.7];

fn file(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)).unwrap()
}

/// A hypothesis that nobody has fitted.
fn hypothesis(id: &str) -> HypothesisResult {
    HypothesisResult {
        id: id.into(),
        kind: Kind::Effect,
        name: id.split('@').next().unwrap().into(),
        location: String::new(),
        probability: 0.1,
        ln_odds: 0.0,
        ln_bayes: 0.0,
        misfit_before: 0.0,
        misfit_after: 0.0,
        estimate: None,
        interval: None,
        unit: None,
        estimates: Vec::new(),
        held_out_before: 0.0,
        held_out_after: 0.0,
        tied_with: Vec::new(),
        limit_of: Vec::new(),
        patch: String::new(),
    }
}

/// The optimum of the library, all parameters SI in the order of the model.
fn optimum(model: &Model, test: &TestData) -> Vec<f64> {
    let found = update(model, test, &Settings::default(), Controls::default()).unwrap();
    found.parameters.iter().map(|p| p.after_si).collect()
}

fn chi_squared(told: &Value) -> f64 {
    told["misfit_per_mode"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).sum()
}

/// What a comparison gives at θ.
fn truth(comparison: &Comparison<'_>, theta: &[f64], switched: Option<usize>, sizes: &[f64]) -> Option<Value> {
    let a = assess(comparison, theta).ok()?;
    let n_test = comparison.test().modes.len();
    let partner: Vec<i64> =
        (0..n_test).map(|j| a.pairs.iter().find(|p| p.test_mode == j).map_or(-1, |p| p.model_mode as i64)).collect();
    Some(json!({
        "theta": &theta[..theta.len() - sizes.len()],
        "hypothesis": switched,
        "sizes": sizes,
        "hz": a.prediction.frequencies_hz,
        "mac": a.mac.row_iter().map(|r| r.iter().copied().collect::<Vec<f64>>()).collect::<Vec<_>>(),
        "partner": partner,
        "misfit_per_mode": a.misfit_per_mode,
    }))
}

/// The accelerance between two sensors by all modes of the model: measured damping of paired modes, `other` for all others.
fn response(model: &Model, comparison: &Comparison<'_>, theta: &[f64], other: f64) -> Value {
    let (k, s) = (1, 4);
    let options = SolveOptions { n_elastic: model.dof_map().n_dof(), shift: None };
    let modes = solve_modes(model, theta, options).unwrap();
    let mut damping = ModalDamping::uniform(modes.len(), other);
    for pair in assess(comparison, theta).unwrap().pairs {
        if let Some(zeta) = &comparison.test().modes[pair.test_mode].damping_ratio {
            damping.ratios[modes.n_rigid + pair.model_mode] = zeta.value;
        }
    }
    let rows = observation_matrix(model, &comparison.test().sensors).unwrap();
    let lines: Vec<f64> = (1..=60).map(|l| 0.6 * f64::from(l)).collect();
    let h = synthesize(&modes, &damping, &rows.rows(k, 1).into_owned(), &rows.rows(s, 1).into_owned(), &lines, 2);
    json!({"response": k, "reference": s, "hz": lines, "amplitude": h.iter().map(|v| v.norm()).collect::<Vec<_>>()})
}

/// The page's data and the truth at random points.
fn report() -> (ReportData, Value) {
    let model: Model = load(&file("bff.yaml"), &Registry::builtin()).unwrap().0;
    let test = read_test(&file("bff_gvt.yaml")).unwrap().0;
    let how = HowToPair::default();
    let assessment = assess_paired(&model, &model.parameters().nominal(), &test, &how).unwrap();
    let case = Case { model: &model, test: &test, assessment: &assessment };
    let mut data = of_comparison(case).unwrap();

    // The offset that `learn` finds first, then the first place of every other effect.
    let context = Context { sensors: sensor_loads(&model, &test.sensors).unwrap(), ..Context::default() };
    let mut ids = vec![OFFSET.to_string()];
    let all = candidates(&model, &Effects::builtin(), &context);
    assert!(all.iter().any(|c| c.id() == OFFSET));
    let with_offset = all.iter().find(|c| c.id() == OFFSET).unwrap().build(&model, &Registry::builtin()).unwrap().model;
    let fitted = optimum(&with_offset, &test);
    for c in &all {
        if !ids.iter().any(|id| id.split('@').next() == Some(c.effect.name())) {
            ids.push(c.id());
        }
    }
    ids.truncate(10);
    let mut hypotheses: Vec<HypothesisResult> = ids.iter().map(|id| hypothesis(id)).collect();
    let (theta, sizes) = fitted.split_at(model.parameters().len());
    let named = with_offset.parameters().names().skip(theta.len());
    hypotheses[0].estimates = named
        .zip(sizes)
        .map(|(name, v)| Estimate { parameter: name.into(), value: *v, unit: "m".into(), interval: [*v; 2] })
        .collect();
    // The first place of some faults of the test, of every way in which one has a number.
    let paired = freed(&paired_test(&model, Some(&assessment.theta), &test, &how).unwrap().test);
    let tests = SingleTest::new(&paired);
    let positions = paired.sensors.iter().map(|s| sensor_position(&model, s).unwrap()).collect();
    let bench = Bench { tests: &tests, positions: Some(positions), nodes: Vec::new() };
    let placed = Faults::builtin().placed(&bench);
    let faults: Vec<PlacedFault> =
        FAULTS.iter().filter_map(|n| placed.iter().find(|p| p.name() == *n).cloned()).collect();
    for fault in &faults {
        let (value, unit) = match fault.number() {
            Number::Angle { .. } => (20.0, "deg"),
            Number::Frequency { .. } => (0.9 * paired.modes[fault.at.modes()[0]].frequency_hz.value, "Hz"),
            _ => (1.5, "1"),
        };
        let estimate = Estimate { parameter: String::new(), value, unit: unit.into(), interval: [value; 2] };
        let estimates =
            if matches!(fault.number(), Number::None | Number::Silence) { Vec::new() } else { vec![estimate] };
        hypotheses.push(HypothesisResult { kind: Kind::Fault, estimates, ..hypothesis(&fault.id(&tests)) });
    }
    // One is improbable, and folded away.
    hypotheses.last_mut().unwrap().probability = 0.001;
    let found = live(case, &how, None, &hypotheses).unwrap();
    assert_eq!(found.hypotheses.len() + found.left_out.len(), ids.len() + faults.len());
    assert_eq!(found.hypotheses.iter().filter(|h| h.test.is_some()).count(), FAULTS.len(), "{:?}", found.left_out);
    assert!(found.accuracy.points == 24 && found.n >= model.dof_map().n_dof());
    // The basis is complete: rounding of λ is about ε (λ + a)²/a, below 1e-6 of λ for the modes of a test.
    for h in [&found.accuracy].into_iter().chain(found.hypotheses.iter().map(|h| &h.accuracy)) {
        for mode in 0..test.modes.len() + 2 {
            assert!(h.frequency[mode] < 1e-7 && h.mac[mode] < 1e-6, "mode {mode}: {h:?}");
        }
    }

    let comparison = compared(&model, &paired, &how).unwrap();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut draw = |p: &LiveParameter| p.range[0] + (p.range[1] - p.range[0]) * rng.random::<f64>();
    let own = model.parameters().len();
    let mut points: Vec<Value> = (0..POINTS)
        .filter_map(|_| {
            let theta: Vec<f64> = found.parameters[..own].iter().map(&mut draw).collect();
            truth(&comparison, &theta, None, &[])
        })
        .collect();
    points.extend(truth(&comparison, &assessment.theta, None, &[]));
    let structure = Structure::new(&model, &context);
    for (k, h) in found.hypotheses.iter().enumerate() {
        if let Some(fault) = faults.iter().find(|f| f.id(&tests) == h.id) {
            for _ in 0..POINTS_OF_A_HYPOTHESIS {
                let theta: Vec<f64> = found.parameters[..own].iter().map(&mut draw).collect();
                let sizes: Vec<f64> = h.sizes.iter().map(|&p| draw(&found.parameters[p])).collect();
                let without = fault.taken_out_of(&paired, sizes.first().copied().unwrap_or(1.0));
                let comparison = compared(&model, &without, &how).unwrap();
                let told = truth(&comparison, &theta, Some(k), &[]);
                points.extend(told.map(|mut t| {
                    t["sizes"] = json!(sizes);
                    t
                }));
            }
            continue;
        }
        let candidate = Effects::builtin().candidate(&structure, &h.id).unwrap();
        let patched = candidate.build(&model, &Registry::builtin()).unwrap().model;
        let comparison = compared(&patched, &paired, &how).unwrap();
        for _ in 0..POINTS_OF_A_HYPOTHESIS {
            let theta: Vec<f64> = found.parameters[..own].iter().map(&mut draw).collect();
            let sizes: Vec<f64> = h.sizes.iter().map(|&p| draw(&found.parameters[p])).collect();
            points.extend(truth(&comparison, &[theta, sizes.clone()].concat(), Some(k), &sizes));
        }
    }
    // A frequency response at each of the first points.
    for point in points.iter_mut().take(FUNCTIONS) {
        let theta: Vec<f64> = serde_json::from_value(point["theta"].clone()).unwrap();
        point["response"] = response(&model, &comparison, &theta, found.damping);
    }
    assert!(points.len() > POINTS + found.hypotheses.len(), "{}", points.len());
    // The optimum with the offset and the one without, and what `learn` says of both.
    assert!(with_offset.parameters().names().take(own).eq(model.parameters().names()));
    let told = truth(&compared(&with_offset, &paired, &how).unwrap(), &fitted, Some(0), sizes).unwrap();
    let without = truth(&comparison, &optimum(&model, &test), None, &[]).unwrap();
    let misfit = [chi_squared(&without), chi_squared(&told)];
    for (found, learnt) in misfit.iter().zip(LEARNT) {
        assert!((found / learnt - 1.0).abs() < 1e-2, "{misfit:?}, and `learn` has {LEARNT:?}");
    }
    let fitted = json!({"id": OFFSET, "theta": theta, "sizes": sizes, "misfit": misfit, "learnt": LEARNT});
    points.push(told);
    data.live = vec![found];
    (data, json!({"points": points, "fitted": fitted}))
}

/// The flagship in flight and its wing on the bench, with the offset of the masses as a hypothesis; and what the library computes at random
/// points of the bench test.
fn two_tests() -> (ReportData, Value) {
    let gvt = read_test(&file("bff_gvt.yaml")).unwrap().0;
    let bench = read_test(&file("bff_bench.yaml")).unwrap().0;
    let configured = |name| load_configuration(&file("bff.yaml"), name, &Registry::builtin()).unwrap().0;
    let (flying, clamped) = (configured(None), configured(bench.configuration.as_deref()));
    let how = HowToPair::default();
    let assessment = assess_paired(&flying, &flying.parameters().nominal(), &gvt, &how).unwrap();
    let case = Case { model: &flying, test: &gvt, assessment: &assessment };
    let mut data = of_comparison(case).unwrap();
    add_tests(&mut data, &[&gvt, &bench]);
    let hypotheses = [hypothesis(OFFSET)];
    add_live(&mut data, case, &[(&clamped, &bench)], &how, None, &hypotheses);
    assert_eq!(data.live.len(), 2);
    assert!(data.live.iter().all(|l| l.hypotheses.len() == 1), "{:?}", data.live[1].left_out);
    assert_eq!(data.live[1].configuration, bench.configuration);
    let theta = clamped.parameters().nominal();
    let paired = freed(&paired_test(&clamped, Some(&theta), &bench, &how).unwrap().test);
    let comparison = compared(&clamped, &paired, &how).unwrap();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
    let own = clamped.parameters().len();
    let mut draw = |p: &LiveParameter| p.range[0] + (p.range[1] - p.range[0]) * rng.random::<f64>();
    let points = (0..POINTS).filter_map(|_| {
        let theta: Vec<f64> = data.live[1].parameters[..own].iter().map(&mut draw).collect();
        truth(&comparison, &theta, None, &[])
    });
    let points = points.collect();
    (data, points)
}

/// A page that does not compute says why, and how to get one that does.
#[test]
fn the_page_of_a_larger_model_says_why_it_does_not_compute() {
    let text = "retune: 1\nname: mast\nnodes: {a: [0, 0, 0], b: [0, 0, 2], c: [0, 0, 4], d: [0, 0, 6]}\n\
        sections: {tube: {E: 70 GPa, nu: 0.33, density: 2700 kg/m3, shape: {tube: {diameter: 0.1 m, wall: 3 mm}}}}\n\
        beams: {mast: {chain: [a, b, c, d], section: tube, subdivide: 24}}\nsupports: {foot: {node: a}}\n";
    let (model, ..) = load(text, &Registry::builtin()).unwrap();
    let n_dof = model.dof_map().n_dof();
    assert!(n_dof > 400, "{n_dof}");
    let theta = model.parameters().nominal();
    let sensors = node_sensors(&model);
    let noise = TwinOptions { n_modes: 4, frequency_noise: 0.001, shape_noise: 0.01, ..TwinOptions::default() };
    let test = twin_modes(&model, &theta, &sensors, &noise, "twin of the mast").unwrap();
    let how = HowToPair::default();
    let assessment = assess_paired(&model, &theta, &test, &how).unwrap();
    let case = Case { model: &model, test: &test, assessment: &assessment };
    let mut data = of_comparison(case).unwrap();
    add_live(&mut data, case, &[], &how, None, &[]);
    assert!(data.live.is_empty());
    let why = data.meta.not_live.as_deref().unwrap();
    assert!(why.contains(&format!("{n_dof} dofs")) && why.contains("`retune report --live`"), "{why}");
    assert!(html(&data).unwrap().contains("dofs, and a page computes unasked"));
}

/// Where the pages of the tests in a browser are.
fn folder() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("target"), PathBuf::from);
    target.join("report_fixture")
}

#[test]
fn the_coordinates_of_the_flagships_page_are_right_and_the_page_is_written() {
    let (data, truth) = report();
    let page = html(&data).unwrap();
    let live = serde_json::to_string(&data.live).unwrap();
    assert!(live.len() < 1_000_000, "{} bytes", live.len());
    std::fs::create_dir_all(folder()).unwrap();
    std::fs::write(folder().join("flagship.html"), page).unwrap();
    std::fs::write(folder().join("flagship_truth.json"), truth.to_string()).unwrap();
}

#[test]
fn the_page_of_two_tests_in_two_configurations_is_written() {
    let (data, truth) = two_tests();
    std::fs::create_dir_all(folder()).unwrap();
    std::fs::write(folder().join("two_tests.html"), html(&data).unwrap()).unwrap();
    std::fs::write(folder().join("two_tests_truth.json"), truth.to_string()).unwrap();
}
