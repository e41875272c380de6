use super::*;
use crate::model::{Model, Registry, load};
use std::f64::consts::TAU;

fn model(name: &str) -> Model {
    let path = format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"));
    load(&std::fs::read_to_string(path).unwrap(), &Registry::builtin()).unwrap().0
}

/// A frame of two bays and three storeys with parameters in products, in space and clamped: 200 dofs and more.
const FRAME: &str = "
retune: 1
name: frame
parameters:
  E: {value: 200 GPa, bounds: [150 GPa, 230 GPa]}
  I_column: {value: 4e-9 m4, bounds: [2e-9 m4, 8e-9 m4]}
  I_floor: {value: 6e-9 m4, bounds: [3e-9 m4, 9e-9 m4]}
  m_top: {value: 1 kg, bounds: [0 kg, 4 kg]}
nodes:
  a0: [0, 0, 0]
  b0: [400 mm, 0, 0]
  a1: [0, 0, 300 mm]
  b1: [400 mm, 0, 300 mm]
  a2: [0, 0, 600 mm]
  b2: [400 mm, 0, 600 mm]
sections:
  column: {E: E, G: 79 GPa, A: 2e-4 m2, Iy: I_column, Iz: 5e-9 m4, J: 8e-9 m4, density: 7850 kg/m3}
  floor: {E: E, G: 79 GPa, A: 2e-4 m2, Iy: I_floor, Iz: 5e-9 m4, J: 8e-9 m4, density: 7850 kg/m3}
beams:
  left: {chain: [a0, a1, a2], section: column, subdivide: 5}
  right: {chain: [b0, b1, b2], section: column, subdivide: 5}
  first: {nodes: [a1, b1], section: floor, subdivide: 6}
  second: {nodes: [a2, b2], section: floor, subdivide: 6}
masses:
  top: {node: a2, mass: m_top}
supports:
  feet: {nodes: [a0, b0]}
";

fn frequencies(model: &dyn ParametricModel, theta: &[f64], n: usize) -> Vec<f64> {
    let solver = ModalSolver::new(model, theta, n).unwrap();
    let (_, modes) = solver.solve(model, theta, n).unwrap();
    modes.elastic().map(|i| modes.lambda[i].sqrt() / TAU).take(n).collect()
}

/// True errors at random points beside those that were looked at: within the tolerance, and within the estimate by a factor of
/// 1.5; the estimate is no more than 1000 times too cautious where errors are above rounding.
#[test]
fn errors_are_what_is_estimated() {
    let frame = load(FRAME, &Registry::builtin()).unwrap().0;
    let wing = model("bff.yaml");
    let plane = model("garteur.yaml");
    for (full, n_modes) in [(&frame, 8), (&wing, 8), (&plane, 10)] {
        let options = ReducedOptions { n_modes, ..ReducedOptions::default() };
        let reduced = ReducedModel::new(full, options).unwrap();
        let n = reduced.dof_map().n_dof();
        let start = interior_point(full.parameters());
        let points = candidates(full, &start, ReducedOptions { n_candidates: 20, seed: 77, ..options });
        let (mut worst, mut least, mut most) = (0.0_f64, f64::INFINITY, 0.0_f64);
        for theta in &points {
            let estimates = reduced.frequency_errors(theta).unwrap();
            let (exact, own) = (frequencies(full, theta, n_modes), frequencies(&reduced, theta, n_modes));
            for ((e, o), estimate) in exact.iter().zip(&own).zip(&estimates) {
                let error = (o / e - 1.0).abs();
                worst = worst.max(error);
                if error > 1e-9 {
                    least = least.min(estimate / error);
                    most = most.max(estimate / error);
                }
            }
        }
        println!(
            "{}: {} of {} dofs, {} samples, estimated {:.1e}, true {worst:.1e}; estimate over true error {least:.2} to {most:.0}",
            full.spec().name,
            n,
            full.dof_map().n_dof(),
            reduced.samples().len(),
            reduced.accuracy()
        );
        assert!(reduced.accuracy() <= options.tolerance && n <= options.most);
        assert!(worst <= options.tolerance, "{worst:e}");
        assert!(least > 1.0 / 1.5 && most < 1000.0, "{least} {most}");
    }
}

/// Everything else a model tells: mass, symmetry, rigid-body modes, derivatives, points of elements.
#[test]
fn the_rest_of_a_model_is_kept() {
    let full = model("bff.yaml");
    let reduced = ReducedModel::new(&full, ReducedOptions { n_modes: 6, ..ReducedOptions::default() }).unwrap();
    let theta = full.parameters().nominal();
    assert_eq!(reduced.mass_properties(&theta).unwrap(), full.mass_properties(&theta).unwrap());
    let solver = ModalSolver::new(&reduced, &theta, 6).unwrap();
    let (_, modes) = solver.solve(&reduced, &theta, 6).unwrap();
    let full_solver = ModalSolver::new(&full, &theta, 6).unwrap();
    let (_, of_full) = full_solver.solve(&full, &theta, 6).unwrap();
    assert_eq!((modes.n_rigid, modes.n_mechanism), (of_full.n_rigid, 0));
    let names = |model: &dyn ParametricModel, modes: &Modes| -> Vec<String> {
        let shapes = modes.shapes.columns(0, modes.n_rigid + 6).into_owned();
        let characters = model.characters(&theta, &shapes, modes.n_rigid).unwrap().unwrap();
        crate::model::label_modes(&characters[modes.n_rigid..]).into_iter().map(|l| l.short).collect()
    };
    assert_eq!(names(&reduced, &modes), names(&full, &of_full));
    let element = full.element_names()[0].to_string();
    let (a, b) = (reduced.point(&element, 0.3).unwrap().unwrap(), full.point(&element, 0.3).unwrap().unwrap());
    assert_eq!(a.position, b.position);
    let at = |row: &[(usize, f64)], shape: &DVector<f64>| row.iter().map(|&(i, f)| f * shape[i]).sum::<f64>();
    for mode in modes.elastic() {
        let (y, q) = (modes.shapes.column(mode).into_owned(), of_full.shapes.column(mode).into_owned());
        let sign = (reduced.basis() * &y).dot(&q).signum();
        for d in 0..6 {
            assert!((sign * at(&a.rows[d], &y) - at(&b.rows[d], &q)).abs() < 1e-6 * q.amax());
        }
    }
    for j in full.parameters().free() {
        let slope = reduced.assemble_derivative(&theta, j).unwrap();
        let of_full = full.assemble_derivative(&theta, j).unwrap();
        let expected = reduced.basis().tr_mul(&(&of_full.stiffness * reduced.basis()));
        assert!((&slope.stiffness - &expected).amax() <= 1e-8 * expected.amax().max(1e-300));
    }
}

#[test]
fn what_cannot_be_reduced_says_so() {
    let text = FRAME.replace("J: 8e-9 m4, density", "J: 8e-9 m4, shear_compliance_z: c, density").replacen(
        "parameters:\n",
        "parameters:\n  c: {value: 1e-8 1/N, bounds: [0 1/N, 1e-7 1/N]}\n",
        1,
    );
    let full = load(&text, &Registry::builtin()).unwrap().0;
    assert_eq!(ReducedModel::new(&full, ReducedOptions::default()).unwrap_err(), ModelError::NotPolynomial);
    let few = load(FRAME, &Registry::builtin()).unwrap().0;
    let reduced = ReducedModel::new(&few, ReducedOptions { most: 12, ..ReducedOptions::default() }).unwrap();
    assert!(reduced.dof_map().n_dof() <= 12 && reduced.accuracy() > 1e-4);
}
