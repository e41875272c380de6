use super::compiled::Compiled;
use super::*;
use crate::correlation::{PairBy, PairingOptions};
use crate::data::read_test;
use crate::model::{ParametricModel, Registry, load};
use crate::objective::{LeastSquares, Objective, PaperCost};
use crate::optim::{Evaluator, Threads};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn open_gates(by: PairBy) -> PairingOptions {
    PairingOptions { by, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true }
}

fn points(n_parameters: usize, count: usize, seed: u64) -> Vec<DVector<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Some values lie on the faces, where masses and springs vanish.
    let mut value = || (1.2 * rng.random::<f64>() - 0.1).clamp(0.0, 1.0);
    (0..count).map(|_| DVector::from_fn(n_parameters, |_, _| value())).collect()
}

/// Costs by batches against costs by the reference path.
fn compare(objective: &dyn Objective, count: usize, least_batched: usize) {
    let points = points(objective.n_parameters(), count, 5);
    let mut costs = vec![0.0; count];
    objective.costs(&points, &mut costs);
    let counts = objective.path_counts();
    assert_eq!(counts.batch + counts.reference, count as u64);
    assert!(counts.batch >= least_batched as u64, "{counts:?}");
    for (x, cost) in points.iter().zip(&costs) {
        let reference = objective.cost(x).unwrap();
        assert!((cost - reference).abs() <= 1e-9 * reference.abs(), "{cost} against {reference}");
        assert_eq!(objective.confirm(x, *cost).to_bits(), cost.to_bits());
        assert_eq!(objective.confirm(x, 0.9 * *cost).to_bits(), reference.to_bits());
    }
}

#[test]
fn batches_give_the_costs_of_the_reference_path() {
    let (test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    let lopsided = text("bff.yaml").replace("body_flaps: {nodes: [n4, n9]", "body_flaps: {nodes: [n4, n11]");
    for (model, by) in
        [(text("bff.yaml"), PairBy::Mac), (text("bff.yaml"), PairBy::Order), (lopsided.clone(), PairBy::Mac)]
    {
        let (model, ..) = load(&model, &Registry::builtin()).unwrap();
        let comparison = Comparison::new(&model, &test, open_gates(by)).unwrap();
        compare(&PaperCost::new(&comparison), 150, 140);
        compare(&PaperCost::frequencies_only(&comparison), 150, 140);
        compare(&LeastSquares::new(&comparison), 150, 140);
        compare(&LeastSquares::from_names(&comparison, &["frequency", "mac", "targets"]).unwrap(), 150, 140);
    }
    let (model, ..) = load(&lopsided, &Registry::builtin()).unwrap();
    let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
    let scaling = Scaling::new(&model);
    assert!(
        Compiled::new(&comparison, &scaling, true, false).unwrap().has_dofs,
        "no mirror, so families come from the shapes"
    );
}

/// A missing sensor, an unlabelled test and a supported structure.
#[test]
fn partial_shapes_and_supports_are_no_special_case() {
    let (mut test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    for (k, mode) in test.modes.iter_mut().enumerate() {
        mode.label = None;
        if let Some(shape) = &mut mode.shape {
            shape[3 * k + 1] = missing();
        }
    }
    test.modes[2].shape = None;
    let (model, ..) = load(&text("bff.yaml"), &Registry::builtin()).unwrap();
    let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
    compare(&PaperCost::new(&comparison), 100, 90);
    compare(&LeastSquares::new(&comparison), 100, 90);
}

fn missing() -> crate::linalg::Complex<f64> {
    crate::linalg::Complex::new(f64::NAN, f64::NAN)
}

/// The same bits alone, in any company, in any order, on one thread and on two.
#[test]
fn a_cost_does_not_depend_on_its_company() {
    let (test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    let (model, ..) = load(&text("bff.yaml"), &Registry::builtin()).unwrap();
    let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
    for objective in [&PaperCost::new(&comparison) as &dyn Objective, &LeastSquares::new(&comparison) as &dyn Objective]
    {
        let points = points(objective.n_parameters(), 100, 9);
        let evaluate = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut costs = vec![0.0; points.len()];
            pool.install(|| Threads.costs(objective, &points, &mut costs, &false.into())).unwrap();
            costs
        };
        let costs = evaluate(1);
        assert_eq!(costs, evaluate(2));
        for (x, cost) in points.iter().zip(&costs) {
            let mut alone = [0.0];
            objective.costs(std::slice::from_ref(x), &mut alone);
            assert_eq!(alone[0].to_bits(), cost.to_bits());
        }
        let reversed: Vec<DVector<f64>> = points.iter().rev().cloned().collect();
        let mut backwards = vec![0.0; points.len()];
        objective.costs(&reversed, &mut backwards);
        backwards.reverse();
        assert_eq!(backwards, costs);
    }
}

/// Products of parameters are factors of the kernel like the parameters themselves: E I, and a mass off its axis.
#[test]
fn products_of_parameters_go_by_batches() {
    let (test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    let bent = text("bff.yaml")
        .replace("parameters:\n", "parameters:\n  I_wing: {value: 1.7e-9 m4, bounds: [1.5e-9 m4, 2e-9 m4]}\n")
        .replace("Iy: 1.7438687500000001e-9 m4", "Iy: I_wing");
    let behind = text("bff.yaml")
        .replace("parameters:\n", "parameters:\n  aft: {value: 0 m, bounds: [-5 cm, 5 cm]}\n")
        .replace("    mass_per_length: mu_wing\n", "    mass_per_length: mu_wing\n    mass_offset_y: aft\n");
    for text in [bent, behind] {
        let (model, ..) = load(&text, &Registry::builtin()).unwrap();
        assert!(!model.affine().unwrap().products.is_empty());
        let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
        compare(&PaperCost::new(&comparison), 100, 90);
        compare(&LeastSquares::new(&comparison), 100, 90);
    }
}

/// Shear flexibility makes a rational function: such a model goes by the reference path.
#[test]
fn what_the_kernel_does_not_take_is_evaluated_all_the_same() {
    let (test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    let sheared = text("bff.yaml")
        .replace("parameters:\n", "parameters:\n  compliance: {value: 1e-6 1/N, bounds: [0 1/N, 1e-5 1/N]}\n")
        .replace(
            "    mass_per_length: mu_wing\n",
            "    mass_per_length: mu_wing\n    shear_compliance_z: compliance\n",
        );
    let (model, ..) = load(&sheared, &Registry::builtin()).unwrap();
    assert!(model.affine().is_none());
    let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
    let cost = PaperCost::new(&comparison);
    let points = points(cost.n_parameters(), 10, 5);
    let mut costs = [0.0; 10];
    cost.costs(&points, &mut costs);
    assert_eq!(cost.path_counts(), PathCounts { batch: 0, reference: 10 });
    for (x, c) in points.iter().zip(costs) {
        assert_eq!(cost.cost(x).unwrap_or(f64::INFINITY).to_bits(), c.to_bits());
    }
}

/// Residuals and Jacobian through the kernel, beside those of the reference path; products of parameters and partial shapes included.
#[test]
fn linearizations_are_those_of_the_reference_path() {
    let (mut test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    let behind = text("bff.yaml")
        .replace("parameters:\n", "parameters:\n  aft: {value: 0 m, bounds: [-5 cm, 5 cm]}\n")
        .replace("    mass_per_length: mu_wing\n", "    mass_per_length: mu_wing\n    mass_offset_y: aft\n");
    test.modes[1].shape.as_mut().unwrap()[4] = missing();
    for text in [text("bff.yaml"), behind] {
        let (model, ..) = load(&text, &Registry::builtin()).unwrap();
        let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
        let objective = || LeastSquares::new(&comparison).with_weights(|name| (name == "shape").then_some(0.25));
        let (reference, kernel) = (objective(), Arc::new(BatchPath::with_derivatives()));
        let fast = objective().through(kernel.clone());
        let points = points(reference.n_parameters(), 40, 3);
        for x in &points {
            let (a, b) = (reference.linearize(x).unwrap(), fast.linearize(x).unwrap());
            let cost = reference.cost(x).unwrap();
            assert!((fast.cost(x).unwrap() - cost).abs() <= 1e-9 * cost);
            // The sign of a shape is the solver's choice, and its scale is free: rows do not show it.
            assert!((&a.residuals - &b.residuals).amax() <= 1e-9 * a.residuals.amax());
            for (a, b) in a.jacobian.column_iter().zip(b.jacobian.column_iter()) {
                assert!((a - b).amax() <= 1e-7 * a.amax(), "{} of {}", (a - b).amax(), a.amax());
            }
        }
        let counts = fast.path_counts();
        assert!(counts.batch >= 70 && counts.batch + counts.reference == 80, "{counts:?}");
        kernel.rest();
        assert_eq!(fast.cost(&points[0]).unwrap().to_bits(), fast.cost(&points[0]).unwrap().to_bits());
    }
}

/// A free structure that is symmetric, with rigid motions of both families mixed, goes through the kernel in halves.
#[test]
fn mixed_rigid_motions_are_no_obstacle() {
    let (model, ..) = load(&text("garteur.yaml"), &Registry::builtin()).unwrap();
    let sensors = crate::update::node_sensors(&model);
    let options = crate::update::TwinOptions { n_modes: 6, ..Default::default() };
    let test = crate::update::twin_modes(&model, &model.parameters().nominal(), &sensors, &options, "made up").unwrap();
    let comparison = Comparison::new(&model, &test, open_gates(PairBy::Mac)).unwrap();
    assert!(Compiled::new(&comparison, &Scaling::new(&model), true, false).is_some());
}
