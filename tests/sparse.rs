//! The sparse path through the model file: equal to the dense one where both run, and alone where only it can.

use retune::correlation::PairingOptions;
use retune::data::{TestData, read_test};
use retune::linalg::DVector;
use retune::modal::{SolveOptions, solve};
use retune::model::{
    MOST_DENSE_DOFS, Model, ModelError, ParametricModel, Registry, load, load_configuration, solve_modes,
};
use retune::objective::{Comparison, LeastSquares, Objective, starting_point};
use retune::update::{Controls, Cost, Settings, update};

/// A free grillage of 4 x 5 crossings, its beams divided into `parts` elements; three dofs a node. Two opposite corners
/// move alike, so that one rigid-body mode is gone.
fn grillage(parts: usize) -> Model {
    grillage_with(
        parts,
        "constraints:\n  level: {terms: [{node: n00, dof: uz, factor: 1}, {node: n34, dof: uz, factor: -1}]}\n",
    )
}

/// * `held` - supports or constraints
fn grillage_with(parts: usize, held: &str) -> Model {
    let mut text = String::from(
        "retune: 1\nname: free grillage\nactive_dofs: [uz, rx, ry]\nparameters:\n  E: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}\n  rho: {value: 2700 kg/m3, bounds: [2000 kg/m3, 3500 kg/m3]}\nsections:\n  bar: {E: E, G: 26 GPa, density: rho, shape: {rectangle: {width: 20 mm, height: 12 mm}}}\nnodes:\n",
    );
    for i in 0..4 {
        for j in 0..5 {
            text += &format!("  n{i}{j}: [{} m, {} m, 0 m]\n", 0.3 * f64::from(i), 0.25 * f64::from(j));
        }
    }
    text += "beams:\n";
    for i in 0..4 {
        let names: Vec<String> = (0..5).map(|j| format!("n{i}{j}")).collect();
        text += &format!("  y{i}: {{chain: [{}], section: bar, subdivide: {parts}}}\n", names.join(", "));
    }
    for j in 0..5 {
        let names: Vec<String> = (0..4).map(|i| format!("n{i}{j}")).collect();
        text += &format!("  x{j}: {{chain: [{}], section: bar, subdivide: {parts}}}\n", names.join(", "));
    }
    text += held;
    let (model, warnings, _) = load(&text, &Registry::builtin()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    model
}

#[test]
fn frequencies_are_those_of_the_dense_path() {
    let model = grillage(12);
    let n = model.dof_map().n_dof();
    assert!((800..MOST_DENSE_DOFS).contains(&n), "{n} dofs: both paths run");
    let theta = model.parameters().nominal();
    let options = SolveOptions { n_elastic: 20, shift: None };
    let sparse = solve_modes(&model, &theta, options).unwrap();
    let system = model.assemble(&theta).unwrap();
    let dense = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
    assert_eq!((sparse.n_rigid, sparse.n_mechanism, sparse.len()), (2, 0, 22));
    assert_eq!((dense.n_rigid, dense.n_mechanism, dense.len()), (2, 0, 22));
    for i in 2..22 {
        let (a, b) = (sparse.frequency_hz(i), dense.frequency_hz(i));
        assert!((a / b - 1.0).abs() < 1e-8, "mode {i}: {a} against {b}");
    }
}

#[test]
fn matrices_and_derivatives_are_those_of_the_dense_assembly() {
    let model = grillage(3);
    let theta = model.parameters().nominal();
    let (dense, sparse) = (model.assemble(&theta).unwrap(), model.assemble_sparse(&theta).unwrap());
    assert_eq!(sparse.stiffness.to_dense(), dense.stiffness);
    assert_eq!(sparse.mass.to_dense(), dense.mass);
    for j in 0..2 {
        let dense = model.assemble_derivative(&theta, j).unwrap();
        let sparse = model.assemble_sparse_derivative(&theta, j).unwrap();
        assert_eq!(sparse.stiffness.to_dense(), dense.stiffness);
        assert_eq!(sparse.mass.to_dense(), dense.mass);
    }
}

/// Cubic elements: the first frequencies of twelve elements a bay and of a hundred agree closely.
#[test]
fn a_model_too_large_for_dense_matrices_has_modes() {
    let model = grillage(100);
    assert!(model.dof_map().n_dof() > MOST_DENSE_DOFS);
    let theta = model.parameters().nominal();
    assert!(matches!(model.assemble(&theta), Err(ModelError::TooLarge { .. })));
    let options = SolveOptions { n_elastic: 4, shift: None };
    let modes = solve_modes(&model, &theta, options).unwrap();
    let coarse = solve_modes(&grillage(12), &theta, options).unwrap();
    for i in 2..6 {
        assert!((modes.frequency_hz(i) / coarse.frequency_hz(i) - 1.0).abs() < 1e-5, "mode {i}");
    }
}

/// Synthetic: the frequencies and shapes of the model itself at another E and density, exact.
fn test_of(model: &Model, theta: &[f64], n_modes: usize, more: &str) -> TestData {
    let places = [(0, 0), (0, 2), (0, 4), (1, 1), (1, 3), (2, 0), (2, 4), (3, 0), (3, 2)];
    let modes = solve_modes(model, theta, SolveOptions { n_elastic: n_modes, shift: None }).unwrap();
    let mut text = String::from(
        "retune_test: 1\nname: synthetic\nsources: {made: {kind: synthetic, text: modes of the model itself}}\ndefaults: {frequency_sd: 0.1 %, shape_sd: 1 %}\nsensors:\n",
    );
    for (i, j) in places {
        text += &format!("  s{i}{j}: {{node: n{i}{j}, direction: +z}}\n");
    }
    text += more;
    text += "modes:\n";
    for k in modes.elastic() {
        text += &format!("  - {{frequency: {:?} Hz, source: made, shape: {{real: [", modes.frequency_hz(k));
        let value = |&(i, j): &(usize, usize)| {
            let dofs = model.dof_map();
            let node = dofs.node(&format!("n{i}{j}")).unwrap();
            let z =
                dofs.express(node, retune::element::Dof::Uz).iter().map(|t| t.1 * modes.shapes[(t.0, k)]).sum::<f64>();
            format!("{z:?}")
        };
        text += &places.iter().map(value).collect::<Vec<_>>().join(", ");
        text += "]}}\n";
    }
    read_test(&text).map_err(|p| format!("{p:?}\n{text}")).unwrap().0
}

/// Nelson's derivatives on the sparse path against central differences of its residuals, and against the cost of the
/// same structure with few elements, which goes by the dense path.
#[test]
fn sensitivities_are_those_of_differences_and_of_the_dense_path() {
    let mut jacobians = Vec::new();
    for parts in [4, 12] {
        let model = grillage(parts);
        assert_eq!(model.dof_map().n_dof() < 800, parts == 4, "one dense, one sparse");
        let mut truth = starting_point(&model);
        truth.iter_mut().zip([1.1, 0.95]).for_each(|(t, f)| *t *= f);
        let test = test_of(&model, &truth, 5, "");
        let comparison = Comparison::new(&model, &test, PairingOptions::default()).unwrap();
        let cost = LeastSquares::new(&comparison);
        let x = cost.scaling().x(&starting_point(&model));
        let exact = cost.linearize(&x).unwrap();
        assert!((&exact.residuals - cost.residuals(&x).unwrap()).amax() < 1e-9 * exact.residuals.amax());
        for j in 0..2 {
            let step = 1e-4;
            let at = |s: f64| {
                let mut x = x.clone();
                x[j] += s * step;
                cost.residuals(&x).unwrap()
            };
            let difference: DVector<f64> = (at(1.0) - at(-1.0)) / (2.0 * step);
            let column = exact.jacobian.column(j);
            // The third derivative of r in the box is some of r' itself: a step of 1e-4 leaves 1e-8.
            let error = (&difference - column).amax() / column.amax();
            assert!(error < 1e-6, "{parts} parts, parameter {j}: {error:e}");
        }
        // A shape of the test may have either sign.
        jacobians.push(exact.jacobian.abs());
    }
    // Hermite beams: a third of the size changes the first frequencies by 1e-6.
    let error = (&jacobians[0] - &jacobians[1]).amax() / jacobians[0].amax();
    assert!(error < 1e-3, "{error:e}");
}

/// A fit finds the E and density that the synthetic test was made with, on a model that has no dense matrices.
#[test]
fn an_update_of_a_large_model_finds_the_truth() {
    let model = grillage(80);
    assert!(model.dof_map().n_dof() > MOST_DENSE_DOFS);
    let mut truth = starting_point(&model);
    truth.iter_mut().zip([1.12, 0.93]).for_each(|(t, f)| *t *= f);
    // Frequencies see E/ρ alone: the mass fixes ρ.
    let mass = model.mass_properties(&truth).unwrap().unwrap().mass;
    let test = test_of(
        &model,
        &truth,
        4,
        &format!("mass_properties:\n  mass: {{value: {mass:?} kg, sd: 0.01 kg, source: made}}\n"),
    );
    let optimizer = retune::optim::OptimizerSpec::by_name("levenberg-marquardt");
    let settings = Settings { cost: Cost::LeastSquares, optimizer, ..Settings::default() };
    let found = update(&model, &test, &settings, Controls::default()).unwrap();
    for (value, exact) in found.after.theta.iter().zip(&truth) {
        assert!((value / exact - 1.0).abs() < 1e-6, "{value} against {exact}");
    }
}

/// Between its ends a beam is exact under loads at its ends: readings are those of the coarsest mesh, and their derivatives those by differences.
#[test]
fn static_readings_of_a_large_model_are_those_of_a_coarse_one() {
    let held = "supports:\n  corners: {nodes: [n00, n04, n30, n34], fixed: [uz]}\n";
    let pull = "static_tests:\n  pull:\n    source: made\n    loads: [{sensor: s11, weight: 1 kg}, {sensor: s24, force: 3 N}]\n    readings: {s13: {value: -1 mm, sd: 2 %}, s20: {value: 1 mm, sd: 0.1 mm}}\n";
    let found: Vec<(usize, Vec<f64>)> = [1, 20, 80]
        .map(|parts| {
            let model = grillage_with(parts, held);
            let theta = model.parameters().nominal();
            let test = test_of(&model, &theta, 2, pull);
            let comparison = Comparison::new(&model, &test, PairingOptions::default()).unwrap();
            if parts == 20 {
                let objective = LeastSquares::new(&comparison);
                let x = objective.scaling().x(&theta);
                let exact = objective.linearize(&x).unwrap().jacobian;
                for j in 0..x.len() {
                    let at = |step: f64| {
                        let mut x = x.clone();
                        x[j] += step;
                        objective.residuals(&x).unwrap()
                    };
                    let slope = (at(1e-3) - at(-1e-3)) / 2e-3;
                    assert!((&slope - exact.column(j)).amax() < 1e-5 * exact.amax(), "{slope}{}", exact.column(j));
                }
            }
            let prediction = comparison.predict(&theta).unwrap();
            (model.dof_map().n_dof(), retune::objective::static_readings(&comparison, &prediction))
        })
        .to_vec();
    assert!(found[2].0 > MOST_DENSE_DOFS, "{} dofs", found[2].0);
    for (_, readings) in &found[1..] {
        for (fine, coarse) in readings.iter().zip(&found[0].1) {
            assert!((fine / coarse - 1.0).abs() < 1e-6, "{found:?}");
        }
    }
}

/// A search on a reduced model, refined on the full one, ends where the full one has its optimum, and evaluates it only a
/// few times; a posterior of the reduced model is that of the full one.
#[test]
fn a_search_on_a_reduced_model_ends_where_the_full_one_does() {
    let model = grillage(20);
    let n_dof = model.dof_map().n_dof();
    assert!(n_dof > 1_800);
    let mut truth = starting_point(&model);
    truth.iter_mut().zip([1.12, 0.93]).for_each(|(t, f)| *t *= f);
    let mass = model.mass_properties(&truth).unwrap().unwrap().mass;
    let weighed = |n_modes: usize| {
        let more = format!("mass_properties:\n  mass: {{value: {mass:?} kg, sd: 1 %, source: made}}\n");
        test_of(&model, &truth, n_modes, &more)
    };
    let test = weighed(4);
    let optimizer = retune::optim::OptimizerSpec::by_name("differential-evolution");
    let settings = Settings { optimizer, reduced: Some(1e-5), seed: 3, ..Settings::default() };
    let found = update(&model, &test, &settings, Controls::default()).unwrap();
    for (value, exact) in found.after.theta.iter().zip(&truth) {
        assert!((value / exact - 1.0).abs() < 1e-5, "{value} against {exact}");
    }
    let reduced = found.reduced.unwrap();
    assert!(reduced.dofs == [(n_dof, reduced.dofs[0].1)] && reduced.dofs[0].1 <= 110 && reduced.accuracy <= 1e-5);
    assert!(reduced.evaluations > 500, "{reduced:?}");
    let on_full = found.optimum.evaluations + found.optimum.linearizations;
    assert!(on_full < 50, "{on_full}");
    assert!((reduced.costs[0] - reduced.costs[1]).abs() < 1e-2, "{reduced:?}");
    assert!(found.optimum.cost <= reduced.costs[1]);

    let sampler = retune::optim::Tmcmc { n_samples: 300, seed: 5, ..retune::optim::Tmcmc::default() };
    let retune::update::Sampled { posterior, reduced, .. } = retune::update::sample_posterior(
        &[retune::update::TestCase { model: &model, test: &test }],
        &Settings { reduced: Some(1e-5), ..Settings::default() },
        &sampler,
    )
    .unwrap();
    let [own, full] = reduced.unwrap().costs;
    assert!((own - full).abs() < 1e-2 * full.max(1.0), "{own} {full}");
    // The box is ±28 % of E wide; data fix E/ρ to about 0.1 %, the mass ρ to 1 %.
    let sd = posterior.covariance().diagonal().map(f64::sqrt);
    assert!(sd[0] > 0.005 && sd[0] < 0.04, "{sd}");
}

/// Static readings need more than modes.
#[test]
fn a_reduced_model_refuses_what_it_cannot_predict() {
    let read = |name: &str| std::fs::read_to_string(format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let test = read_test(&read("bff_static.yaml")).unwrap().0;
    let (model, ..) =
        load_configuration(&read("bff.yaml"), test.configuration.as_deref(), &Registry::builtin()).unwrap();
    let settings = Settings { reduced: Some(1e-4), ..Settings::default() };
    let error = update(&model, &test, &settings, Controls::default()).unwrap_err().to_string();
    assert!(error.contains("static readings or frequency responses, which need more than the modes"), "{error}");
}

/// A cantilever in elements so small that the rounding of K, which grows with their number to the fourth, drowns its first
/// mode: f₁ is that of the closed form, 1.8751² √(EI/mL⁴) / 2π, or an error says that the mesh is too fine. It is never
/// taken for a free structure.
#[test]
fn a_mesh_that_is_too_fine_is_refused_or_right() {
    let mut outcomes = Vec::new();
    for parts in [50, 500, 1_000, 2_000, 4_000, 10_000] {
        let text = format!(
            "retune: 1\nname: fine cantilever\nactive_dofs: [uz, ry]\nnodes: {{root: [0 m, 0 m, 0 m], tip: [2 m, 0 m, 0 m]}}\nbeams: {{bar: {{chain: [root, tip], properties: {{EIy: 30 N m2, mass_per_length: 0.5 kg/m}}, subdivide: {parts}}}}}\nsupports: {{clamp: {{node: root}}}}\n"
        );
        let (model, ..) = load(&text, &Registry::builtin()).unwrap();
        match solve_modes(&model, &[], SolveOptions { n_elastic: 3, shift: None }) {
            Ok(modes) => {
                let exact =
                    1.875_104_068_711_961_2_f64.powi(2) * (30.0_f64 / 0.5 / 16.0).sqrt() / std::f64::consts::TAU;
                assert_eq!((modes.n_rigid, modes.n_mechanism), (0, 0), "{parts}");
                let error = modes.frequency_hz(0) / exact - 1.0;
                assert!(error.abs() < 2e-3, "{parts} parts: {error:e}");
                outcomes.push("right");
            }
            Err(e) => {
                assert!(e.to_string().contains("the mesh is too fine"), "{parts} parts: {e}");
                outcomes.push("refused");
            }
        }
    }
    assert_eq!(outcomes[..3], ["right"; 3]);
    assert_eq!(outcomes.last(), Some(&"refused"));
}
