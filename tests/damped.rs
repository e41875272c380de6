//! Modes that dashpots couple, against the complex eigenvalues of the first-order form and against differences.

use retune::correlation::PairingOptions;
use retune::data::{Sensor, TestData};
use retune::linalg::{Complex, DMatrix, DVector, general_eigenpairs};
use retune::model::{Model, ParametricModel, Registry, load};
use retune::objective::{Comparison, LeastSquares, Objective};
use retune::update::{TwinOptions, node_sensors, twin_modes};
use std::f64::consts::TAU;

/// A tower of four storeys with a damper across the second one and one to the ground.
const TOWER: &str = "retune: 1
name: tower with dampers
active_dofs: [ux]
parameters:
  k: {value: 90 kN/m, bounds: [60 kN/m, 120 kN/m]}
  m: {value: 20 kg, bounds: [10 kg, 30 kg]}
  c: {value: 300 N s/m, bounds: [0 N s/m, 900 N s/m]}
  zeta: {value: 0.5 %, bounds: [0 %, 2 %]}
modal_damping: zeta
nodes: {n1: [0, 0, 1], n2: [0, 0, 2], n3: [0, 0, 3], n4: [0, 0, 4]}
springs:
  s0: {node: n1, k: {ux: k}}
  s1: {nodes: [n1, n2], k: {ux: 80 kN/m}, c: {ux: c}}
  s2: {nodes: [n2, n3], k: {ux: k}}
  s3: {nodes: [n3, n4], k: {ux: 70 kN/m}}
  d4: {node: n4, c: {ux: 0.4*c}}
masses: {m1: {node: n1, mass: m}, m2: {node: n2, mass: 25 kg}, m3: {node: n3, mass: 20 kg}, m4: {node: n4, mass: m}}
";

fn model() -> Model {
    load(TOWER, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}")).0
}

/// Poles in the upper half plane by their modulus, with their shapes: eigenpairs of [0 I; -M⁻¹K -M⁻¹C].
fn poles(model: &Model, theta: &[f64]) -> Vec<(Complex<f64>, DVector<Complex<f64>>)> {
    let system = model.assemble(theta).unwrap();
    let n = system.mass.nrows();
    let over_mass = system.mass.clone().try_inverse().unwrap();
    let mut first_order = DMatrix::zeros(2 * n, 2 * n);
    first_order.view_mut((0, n), (n, n)).copy_from(&DMatrix::identity(n, n));
    first_order.view_mut((n, 0), (n, n)).copy_from(&-(&over_mass * &system.stiffness));
    first_order.view_mut((n, n), (n, n)).copy_from(&-(&over_mass * system.damping.as_ref().unwrap()));
    let pairs = general_eigenpairs(&first_order).unwrap();
    let mut all: Vec<_> = (0..2 * n)
        .filter(|&k| pairs.values[k].im > 0.0)
        .map(|k| (pairs.values[k], pairs.vectors.column(k).rows(0, n).into_owned()))
        .collect();
    all.sort_by(|a, b| a.0.norm().total_cmp(&b.0.norm()));
    all
}

fn test(model: &Model, sensors: &[Sensor], theta: &[f64]) -> TestData {
    let options = TwinOptions {
        n_modes: 4,
        frequency_noise: 0.004,
        shape_noise: 0.02,
        damping_noise: 0.05,
        seed: 3,
        ..TwinOptions::default()
    };
    twin_modes(model, theta, sensors, &options, "twin").unwrap()
}

/// Frequencies, ratios and real shapes are those of the poles, in a prediction as in a twin; without dashpots the frequencies are others by per cent.
#[test]
fn coupled_modes_are_those_of_the_poles() {
    let model = model();
    let (theta, sensors) = (model.parameters().nominal(), node_sensors(&model));
    let exact = poles(&model, &theta);
    let made = test(&model, &sensors, &theta);
    let comparison = Comparison::new(&model, &made, PairingOptions::default()).unwrap();
    let predicted = comparison.predict(&theta).unwrap();
    let mut moved = 0.0_f64;
    for (k, (s, shape)) in exact.iter().enumerate() {
        assert!((predicted.frequencies_hz[k] * TAU / s.norm() - 1.0).abs() < 1e-9, "mode {k}");
        moved = moved.max((predicted.modes.frequency_hz(k) * TAU / s.norm() - 1.0).abs());
        let read = DVector::from_fn(sensors.len(), |i, _| shape[i]);
        let square: Complex<f64> = read.iter().map(|v| v * v).sum();
        let turn = Complex::from_polar(1.0, -0.5 * square.arg());
        let real = read.map(|v| (v * turn).re);
        let own = predicted.at_sensors.column(k);
        let mac = real.dot(&own).powi(2) / (real.norm_squared() * own.norm_squared());
        assert!((mac - 1.0).abs() < 1e-9, "mode {k}: {mac}");
        let told = made.modes[k].damping_ratio.unwrap();
        let ratio = 0.005 - s.re / s.norm();
        assert!((told.value - ratio).abs() < 4.0 * told.sd && (told.sd / (0.05 * ratio) - 1.0).abs() < 1e-6);
    }
    assert!(moved > 0.01, "the dampers hardly couple: {moved}");
}

/// Derivatives of all rows are those of differences, and the null of a strongly damped structure leaves noise.
#[test]
fn coupled_modes_have_exact_derivatives() {
    let model = model();
    let theta = model.parameters().nominal();
    let made = test(&model, &node_sensors(&model), &theta);
    let comparison = Comparison::new(&model, &made, PairingOptions::default()).unwrap();
    let objective = LeastSquares::new(&comparison);
    let at_truth = DVector::from_iterator(4, [0.5, 0.5, 1.0 / 3.0, 0.25]);
    let misfit = objective.residuals(&at_truth).unwrap().norm_squared();
    assert!(misfit < 60.0, "{misfit} of 24 data");
    let x = DVector::from_iterator(4, [0.42, 0.61, 0.55, 0.3]);
    let exact = objective.linearize(&x).unwrap().jacobian;
    let step = 1e-5;
    for j in 0..4 {
        let at = |sign: f64| {
            let mut moved = x.clone();
            moved[j] += sign * step;
            objective.residuals(&moved).unwrap()
        };
        let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
        for i in 0..slope.len() {
            let size = exact.column(j).amax();
            assert!(
                (slope[i] - exact[(i, j)]).abs() < 1e-4 * size,
                "row {i}, parameter {j}: {} {}",
                slope[i],
                exact[(i, j)]
            );
        }
    }
}
