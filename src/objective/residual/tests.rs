//! Every residual of the catalogue: its derivative against differences, and the closed forms of the static ones.

use super::*;
use crate::correlation::{PairBy, PairingOptions};
use crate::data::{
    FrfFit, FrfQuantity, MassProperty, MassQuantity, Measured, Origin, ShapeComponent, TestData, read_test,
};
use crate::model::{Model, ParametricModel, Registry, load, load_configuration};
use crate::objective::{LeastSquares, Loss, Objective, Scaling, difference};

const MODEL: &str = "
retune: 1
name: stepped cantilever with a damper
active_dofs: [uz, rx, ry]
parameters:
  E1: {value: 70 GPa, bounds: [40 GPa, 100 GPa], prior_sd: 10 GPa}
  GJ: {value: 40 Pa, bounds: [20 Pa, 80 Pa]}
  mu: {value: 1 kg/m, bounds: [0.5 kg/m, 1.5 kg/m]}
  tip: {value: 0.3 kg, bounds: [0 kg, 0.8 kg]}
  c: {value: 0.5 N s/m, bounds: [0 N s/m, 3 N s/m]}
  alpha: {value: 0.4 1/s, bounds: [0 1/s, 2 1/s]}
  zeta: {value: 1 %, bounds: [0 %, 5 %]}
modal_damping: zeta
nodes: {a: [0, 0, 0], b: [0.5, 0.1, 0], c: [1, 0, 0]}
beams:
  inner: {nodes: [a, b], properties: {E: E1, Iy: 1.7e-9 m4, G: GJ, J: 1 m4, mass_per_length: mu, polar_inertia_per_length: 0.002 kg m}, subdivide: 2}
  outer: {nodes: [b, c], properties: {E: 50 GPa, Iy: 1.7e-9 m4, G: GJ, J: 1 m4, mass_per_length: mu, polar_inertia_per_length: 0.002 kg m}, subdivide: 2}
overrides: {inner: {mass_damping: alpha}}
springs: {damper: {node: b, c: {uz: c}}}
masses: {tip: {node: c, mass: tip, inertia: {xx: 0.001, yy: 0.002}}}
supports: {wall: {node: a}}
targets: {total_mass: {value: 1.2 kg, tolerance: 0.1 kg}}
";

const TEST: &str = "
retune_test: 1
name: of everything
sources: {made: {kind: synthetic, text: by hand}}
sensors:
  b: {node: b, direction: +z}
  c: {node: c, direction: +z}
  side: {node: c, position: [1 m, 0.1 m, 0 m], direction: +z}
  twist: {node: c, direction: +x, rotation: true}
static_tests:
  both:
    source: made
    loads: [{sensor: side, weight: 1 kg}, {node: c, moment: 1 N m, direction: +x}]
    readings: {c: {value: -20 mm, sd: 1 mm}, twist: {value: 2 deg, sd: 0.2 deg}}
";

fn model() -> Model {
    load(MODEL, &Registry::builtin()).map_err(|p| format!("{p:?}")).unwrap().0
}

/// The test file with modes, functions and mass of the model at other parameters: nothing agrees.
fn test(model: &Model) -> TestData {
    use crate::update::{TwinFrfOptions, TwinOptions, twin_frfs, twin_modes};
    let mut theta = model.parameters().nominal();
    theta.iter_mut().enumerate().for_each(|(i, v)| *v *= 1.1 + 0.02 * i as f64);
    let mut test = read_test(TEST).unwrap().0;
    let options = TwinOptions {
        n_modes: 3,
        frequency_noise: 0.01,
        shape_noise: 0.02,
        damping_noise: 0.1,
        ..TwinOptions::default()
    };
    test.modes = twin_modes(model, &theta, &test.sensors, &options, "by hand").unwrap().modes;
    // Of the first shape with its sign turned, and of the second relative to another sensor.
    let component = |sensor: usize, relative_to: Option<usize>, value: f64| ShapeComponent {
        sensor,
        relative_to,
        measured: Measured { value, sd: 0.05, sd_is_default: false },
    };
    test.modes[0].components = vec![component(1, None, -0.9), component(3, None, 0.4)];
    test.modes[1].components = vec![component(1, Some(0), -1.5), component(2, None, 0.7)];
    let functions = TwinFrfOptions {
        lines_hz: (1..=20).map(|k| 3.1 * f64::from(k)).collect(),
        exciters: vec!["side".to_string()],
        quantity: FrfQuantity::Accelerance,
        force_noise: 0.0,
        response_noise: 0.0,
        n_averages: 1,
    };
    test.frfs = Some(twin_frfs(model, &theta, &test.sensors[..3], &options, &functions).unwrap());
    test.frf_fit =
        Some(FrfFit { bands_hz: vec![[1.0, 60.0]], relative_sd: 0.05, loss_factor: Some(0.02), ..FrfFit::default() });
    let measured = Measured { value: 1.5, sd: 0.01, sd_is_default: false };
    let origin = Origin::Synthetic("by hand".to_string());
    test.mass_properties = vec![MassProperty { quantity: MassQuantity::Mass, measured, origin }];
    test
}

const PAIRING: PairingOptions =
    PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true };

#[test]
fn every_residual_has_exact_derivatives() {
    let model = model();
    check_derivatives(&model, &test(&model), RESIDUALS, &[0.52, 0.41, 0.63, 0.37, 0.22, 0.31, 0.44]);
}

/// The reading of a sensor inside an element with a flexible end depends on the compliance by itself.
#[test]
fn a_sensor_beside_a_flexible_end_has_exact_derivatives() {
    let text = MODEL
        .replace("  alpha: {", "  hinge: {value: 0.02 rad/(N m), bounds: [0 rad/(N m), 0.05 rad/(N m)]}\n  alpha: {")
        .replace("alpha}}", "alpha}, outer: {set: {end1_compliance_ry: hinge}}}");
    let model = load(&text, &Registry::builtin()).map_err(|p| format!("{p:?}")).unwrap().0;
    let mut test = test(&model);
    let beside = "retune_test: 1\nname: one\nsources: {made: {kind: synthetic, text: by hand}}\n\
                  sensors: {beside: {element: outer, fraction: 0.2, direction: +z}, c: {node: c, direction: +z}, b: {node: b, direction: +z}}\n\
                  mass_properties: {mass: {value: 1 kg, sd: 1 kg, source: made}}\n";
    test.sensors = read_test(beside).unwrap().0.sensors;
    (test.frfs, test.frf_fit) = (None, None);
    test.static_tests.clear();
    let mut theta = model.parameters().nominal();
    theta.iter_mut().enumerate().for_each(|(i, v)| *v *= 1.1 + 0.02 * i as f64);
    let options =
        crate::update::TwinOptions { n_modes: 3, frequency_noise: 0.01, shape_noise: 0.02, ..Default::default() };
    test.modes = crate::update::twin_modes(&model, &theta, &test.sensors, &options, "by hand").unwrap().modes;
    let point = |hinge: f64| {
        let mut theta = model.parameters().nominal();
        theta[5] = hinge;
        crate::correlation::observation_matrix_at(&model, &test.sensors, &theta).unwrap()
    };
    assert!((point(0.0) - point(0.05)).amax() > 0.01, "the row depends on the hinge");
    let terms: Vec<&dyn Residual> = vec![&Frequency, &Shape, &Mac];
    check_derivatives(&model, &test, &terms, &[0.52, 0.41, 0.63, 0.37, 0.22, 0.4, 0.31, 0.44]);
}

/// Central differences of step h have an error of h² r'''/6 and ε r/h; with h = 1e-5 of each interval about 1e-7 of the
/// larger of the column and the residual.
fn check_derivatives(model: &Model, test: &TestData, terms: &[&dyn Residual], x: &[f64]) {
    let comparison = Comparison::new(model, test, PAIRING).unwrap();
    let x = crate::linalg::DVector::from_row_slice(x);
    for term in terms {
        for loss in [Loss::Squares, Loss::StudentT(4.0)] {
            let objective = LeastSquares::with_terms(&comparison, vec![*term]).with_loss(loss);
            assert!(objective.n_residuals() > 0, "{} has no rows", term.name());
            let exact = objective.linearize(&x).unwrap();
            let by_difference = difference(objective.n_residuals(), &x, |x| objective.residuals(x)).unwrap();
            assert!(exact.jacobian.amax() > 0.0, "{} does not depend on anything", term.name());
            for j in 0..x.len() {
                let (a, b) = (exact.jacobian.column(j), by_difference.jacobian.column(j));
                let size = a.amax().max(1e-2 * exact.residuals.amax()).max(1e-3);
                let error = (a - b).amax() / size;
                assert!(error < 2e-5, "{} ({loss:?}), parameter {j}: {error:.1e}", term.name());
            }
        }
    }
}

/// The damping of every mode of a structure with C = α M is α/(2 ω), whatever its shapes; beside it stands the ratio of every mode.
#[test]
fn mass_damping_gives_the_textbook_ratio() {
    let text = MODEL
        .replace(
            "overrides: {inner: {mass_damping: alpha}}",
            "overrides: {inner: {mass_damping: alpha}, outer: {mass_damping: alpha}, tip: {mass_damping: alpha}}",
        )
        .replace("c: {uz: c}}", "c: {uz: 0}}");
    let model = load(&text, &Registry::builtin()).map_err(|p| format!("{p:?}")).unwrap().0;
    let test = test(&model);
    let comparison = Comparison::new(&model, &test, PAIRING).unwrap();
    let scaling = Scaling::new(&model);
    let theta = model.parameters().nominal();
    let prediction = comparison.predict(&theta).unwrap();
    let point = Point { comparison: &comparison, scaling: &scaling, theta: &theta, prediction: &prediction };
    let mut r = vec![0.0; Residual::len(&damping::Damping, &comparison)];
    damping::Damping.evaluate(&point, &mut r);
    assert_eq!(r.len(), test.modes.len());
    for (i, r) in r.iter().enumerate() {
        let measured = test.modes[i].damping_ratio.unwrap();
        let omega = std::f64::consts::TAU * prediction.frequencies_hz[prediction.partner(i).unwrap()];
        let zeta = measured.value + r * measured.sd;
        assert!((zeta / (0.01 + 0.4 / (2.0 * omega)) - 1.0).abs() < 1e-9, "mode {i}: {zeta}");
    }
}

/// The static tests of the flagship's wing: W L³/(3 EI) and T L/(GJ) of a cantilever, at EI = 70 and GJ = 40 N m².
#[test]
fn static_readings_of_the_flagship_are_those_of_a_cantilever() {
    let text = include_str!("../../../models/bff.yaml");
    let (model, _, _) = load_configuration(text, Some("bench"), &Registry::builtin()).unwrap();
    let test = read_test(include_str!("../../../models/bff_static.yaml")).unwrap().0;
    let comparison = Comparison::new(&model, &test, PAIRING).unwrap();
    let mut theta = model.parameters().nominal();
    let (iy, j) = (1.743_868_750_000_000_1e-9, 2.414_046_797_5e-7);
    theta[model.parameters().index_of("E_wing").unwrap()] = 70.0 / iy;
    theta[model.parameters().index_of("G_wing").unwrap()] = 40.0 / j;
    let length = (65.65 - 20.40) * 0.0254_f64;
    let readings = crate::objective::static_readings(&comparison, &comparison.predict(&theta).unwrap());
    let expected = [-9.806_65 * length.powi(3) / 210.0, 2.0 * length / 40.0];
    for (value, expected) in readings.iter().zip(expected) {
        assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
    }
    // What the file states, to its digits.
    for (r, expected) in test.static_tests.iter().map(|t| &t.readings[0]).zip(expected) {
        assert!((r.measured.value / expected - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_free_structure_has_no_static_test() {
    let model = load(&MODEL.replace("supports: {wall: {node: a}}\n", ""), &Registry::builtin()).unwrap().0;
    let test = read_test(TEST).unwrap().0;
    let error = Comparison::new(&model, &test, PAIRING).unwrap_err().to_string();
    assert!(error.contains("free to move") && error.contains("`both`"), "{error}");
}

/// Functions of the model itself at other parameters, dashpots and Rayleigh damping among them: FRFs alone bring all of
/// them back, from a start 10 to 20 % off, first by amplitudes, then by real and imaginary parts.
#[test]
fn frequency_responses_alone_recover_stiffness_mass_and_damping() {
    use crate::optim::{LevenbergMarquardt, Optimizer, Run};
    let model = load(&MODEL.replace(", prior_sd: 10 GPa", ""), &Registry::builtin()).unwrap().0;
    let mut test = test(&model);
    let mut truth = model.parameters().nominal();
    truth.iter_mut().enumerate().for_each(|(i, v)| *v *= [1.1, 0.85, 1.1, 0.9, 1.2, 0.8, 1.3][i]);
    let h = {
        let comparison = Comparison::new(&model, &test, PAIRING).unwrap();
        let prediction = comparison.predict(&truth).unwrap();
        comparison.responses().unwrap().evaluate(&model, &truth, &prediction, None).0
    };
    // Values come function by function, lines innermost.
    let set = test.frfs.as_mut().unwrap();
    let n_lines = set.frequencies_hz.iter().filter(|f| (1.0..=60.0).contains(*f)).count();
    assert_eq!(h.len(), n_lines * set.responses.len());
    for (value, h) in h.iter().enumerate() {
        let place = set.index(value % n_lines, 0, value / n_lines);
        set.h[place] = *h;
    }
    let comparison = Comparison::new(&model, &test, PAIRING).unwrap();
    let scaling = Scaling::new(&model);
    let mut x = scaling.x(&model.parameters().nominal());
    for term in ["frf-log", "frf-complex"] {
        let objective = LeastSquares::from_names(&comparison, &[term]).unwrap();
        x = LevenbergMarquardt::default().minimize(&x, &mut Run::new(&objective)).unwrap().x;
    }
    for ((name, found), truth) in model.parameters().names().zip(scaling.theta(&x)).zip(&truth) {
        assert!((found / truth - 1.0).abs() < 1e-5, "{name}: {found} instead of {truth}");
    }
}

/// Without dashpots one decomposition serves all lines; with few lines each has its own factorisation. The model has massless
/// rotations, the loss factor makes K complex.
#[test]
fn both_ways_to_frequency_responses_agree() {
    let text = MODEL
        .replace("overrides: {inner: {mass_damping: alpha}}\n", "")
        .replace("springs: {damper: {node: b, c: {uz: c}}}\n", "")
        .replace("  c: {value: 0.5 N s/m, bounds: [0 N s/m, 3 N s/m]}\n", "")
        .replace("  alpha: {value: 0.4 1/s, bounds: [0 1/s, 2 1/s]}\n", "")
        .replace("  zeta: {value: 1 %, bounds: [0 %, 5 %]}\nmodal_damping: zeta\n", "")
        .replace("polar_inertia_per_length: 0.002 kg m", "polar_inertia_per_length: 0 kg m");
    let model = load(&text, &Registry::builtin()).map_err(|p| format!("{p:?}")).unwrap().0;
    let mut test = test(&model);
    let theta = model.parameters().nominal();
    let scaling = Scaling::new(&model);
    let evaluate = |test: &TestData| {
        let comparison = Comparison::new(&model, test, PAIRING).unwrap();
        let prediction = comparison.predict(&theta).unwrap();
        comparison.responses().unwrap().evaluate(&model, &theta, &prediction, Some(scaling.free()))
    };
    let (together, slopes) = evaluate(&test);
    let n_lines = 19;
    assert_eq!(together.len(), 3 * n_lines);
    for line in 0..n_lines {
        let f = 3.1 * (line + 1) as f64;
        test.frf_fit.as_mut().unwrap().bands_hz = vec![[f - 0.1, f + 0.1]];
        let (alone, alone_slopes) = evaluate(&test);
        for (response, h) in alone.iter().enumerate() {
            let value = response * n_lines + line;
            let largest = together.iter().map(|v| v.norm()).fold(0.0, f64::max);
            assert!((h - together[value]).norm() < 1e-10 * largest, "{f} Hz: {h} and {}", together[value]);
            for j in 0..slopes.ncols() {
                let (a, b) = (alone_slopes[(response, j)], slopes[(value, j)]);
                let size = slopes.column(j).iter().map(|v| v.norm()).fold(0.0, f64::max);
                assert!((a - b).norm() < 1e-9 * size, "{f} Hz, parameter {j}: {a} and {b}");
            }
        }
    }
}
