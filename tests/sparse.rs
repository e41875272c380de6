//! The sparse path through the model file: equal to the dense one where both run, and alone where only it can.

use retune::modal::{SolveOptions, solve};
use retune::model::{MOST_DENSE_DOFS, Model, ModelError, ParametricModel, Registry, load, solve_modes};

/// A free grillage of 4 x 5 crossings, its beams divided into `parts` elements; three dofs a node.
fn grillage(parts: usize) -> Model {
    let mut text = String::from(
        "retune: 1\nname: free grillage\nactive_dofs: [uz, rx, ry]\nparameters:\n  E: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}\n  rho: {value: 2700 kg/m3, bounds: [2000 kg/m3, 3500 kg/m3]}\nsections:\n  bar: {E: E, G: 26 GPa, density: rho, shape: {rectangle: {width: 20 mm, height: 12 mm}}}\nnodes:\n",
    );
    for i in 0..4 {
        for j in 0..5 {
            text += &format!("  n{i}{j}: [{} m, {} m, 0 m]\n", 0.3 * i as f64, 0.25 * j as f64);
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
    assert_eq!((sparse.n_rigid, sparse.n_mechanism, sparse.len()), (3, 0, 23));
    assert_eq!((dense.n_rigid, dense.n_mechanism, dense.len()), (3, 0, 23));
    for i in 3..23 {
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
    for i in 3..7 {
        assert!((modes.frequency_hz(i) / coarse.frequency_hz(i) - 1.0).abs() < 1e-5, "mode {i}");
    }
}
