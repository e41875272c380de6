//! The examples that extend retune from outside: they run, and what they say is true.

#[path = "../examples/custom_element.rs"]
mod custom_element;
#[path = "../examples/custom_model.rs"]
mod custom_model;
#[path = "../examples/custom_optimizer.rs"]
mod custom_optimizer;

use retune::data::read_test;
use retune::element::conformance;
use retune::linalg::DVector;
use retune::objective::{EvalError, Objective};
use retune::optim::{Optimizer, Run};
use retune::update::{Controls, Settings, update};

#[test]
fn each_example_is_short() {
    for name in ["custom_element", "custom_model", "custom_optimizer"] {
        let path = format!("{}/examples/{name}.rs", env!("CARGO_MANIFEST_DIR"));
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines < 80, "{name} has {lines} lines");
    }
}

#[test]
fn the_custom_element_is_an_element() {
    assert_eq!(conformance::check(&custom_element::TaperedBar), Ok(()));
    custom_element::main().unwrap();
}

#[test]
fn the_custom_optimizer_finds_a_minimum() {
    struct Bowl;
    impl Objective for Bowl {
        fn n_parameters(&self) -> usize {
            3
        }
        fn n_residuals(&self) -> usize {
            3
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(DVector::from_vec(vec![x[0] - 0.2, 2.0 * (x[1] - 0.7), x[2] - 1.5]))
        }
    }
    custom_optimizer::main().unwrap();
    let compass = custom_optimizer::CompassSearch { first_step: 0.3, last_step: 1e-7 };
    let optimum = compass.minimize(&DVector::from_element(3, 0.5), &mut Run::new(&Bowl)).unwrap();
    for (x, exact) in optimum.x.iter().zip([0.2, 0.7, 1.0]) {
        assert!((x - exact).abs() < 1e-6, "{} against {exact}", optimum.x);
    }
}

/// The frequencies were made with 180, 160 and 120 kN/m and have eight digits.
#[test]
fn the_custom_model_is_updated() {
    custom_model::main().unwrap();
    let path = format!("{}/models/verification/shear_building_test.yaml", env!("CARGO_MANIFEST_DIR"));
    let (test, _) = read_test(&std::fs::read_to_string(path).unwrap()).unwrap();
    let building = custom_model::ShearBuilding::new(vec![1200.0, 1000.0, 800.0], 150e3);
    let result = update(&building, &test, &Settings::default(), Controls::default()).unwrap();
    for (p, exact) in result.parameters.iter().zip([180.0, 160.0, 120.0]) {
        assert!((p.after / exact - 1.0).abs() < 1e-5, "{}: {} against {exact}", p.name, p.after);
    }
}
