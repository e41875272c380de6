//! The flagship, the Body Freedom Flutter flying wing, against an independent reference.
//!
//! The reference (`bff-reference.json`) was computed by two programs that share no code with this one, one of them in
//! 40-digit arithmetic. It is found through the environment variable `RETUNE_DESIGN`, or in `../shared/design` beside
//! this package; tests that need all of it say so and pass when it is absent. The most telling numbers also stand in
//! [`known`], so that the flagship is checked without it.

mod bench;
mod identifiability;
mod known;
#[path = "../../tools/src/bin/make_bff_gvt.rs"]
#[expect(dead_code, reason = "its main is that of the program")]
mod make_bff_gvt;
mod reproduction;
mod search;

use retune::correlation::{PairBy, PairingOptions, observation_matrix};
use retune::data::{TestData, read_test};
use retune::linalg::DMatrix;
use retune::modal::{Modes, SolveOptions, solve};
use retune::model::{Model, ParametricModel, Registry, load};
use serde_json::Value;
use std::path::Path;

/// Modes paired by their order in frequency, as in the paper.
const BY_ORDER: PairingOptions =
    PairingOptions { by: PairBy::Order, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: false };

/// The k-th symmetric with the k-th symmetric, the k-th antisymmetric with the k-th antisymmetric mode.
const BY_ORDER_IN_FAMILY: PairingOptions = PairingOptions { same_family_only: true, ..BY_ORDER };

/// The text of a file of `models`.
fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A model from its text; problems fail the test with their places.
fn model_of(text: &str) -> Model {
    match load(text, &Registry::builtin()) {
        Ok((model, _, _)) => model,
        Err(problems) => panic!("{}", problems.iter().map(|p| p.render("model")).collect::<String>()),
    }
}

fn model(file: &str) -> Model {
    model_of(&text(file))
}

fn gvt() -> TestData {
    match read_test(&text("bff_gvt.yaml")) {
        Ok((test, warnings)) => {
            assert!(warnings.is_empty(), "{warnings:?}");
            test
        }
        Err(problems) => panic!("{}", problems.iter().map(|p| p.render("bff_gvt.yaml")).collect::<String>()),
    }
}

/// The cases of the reference: name, file, θ.
fn cases() -> [(&'static str, Model, Vec<f64>); 3] {
    let initial = model("bff.yaml");
    let updated = model("bff_updated.yaml");
    let theta = initial.parameters().nominal();
    // Table 4 literally: the gross wing mass, and the inertias with one digit.
    let mut literal = theta.clone();
    literal[index(&initial, "mu_wing")] = 1.08;
    for name in ["Ix4_9", "Ix5_10", "Ix6_11", "Ix7_12", "Ix8_13"] {
        literal[index(&initial, name)] = 0.0008;
    }
    let nominal = updated.parameters().nominal();
    [("initial", initial.clone(), theta), ("table4_literal", initial, literal), ("updated", updated, nominal)]
}

fn index(model: &Model, parameter: &str) -> usize {
    model.parameters().index_of(parameter).unwrap_or_else(|| panic!("no parameter {parameter}"))
}

/// The lowest modes at θ.
fn modes(model: &Model, theta: &[f64], n_elastic: usize) -> Modes {
    let system = model.assemble(theta).unwrap();
    let motions = model.dof_map().rigid_motions();
    solve(&system.stiffness, &system.mass, &motions, SolveOptions { n_elastic, shift: None }).unwrap()
}

/// Shapes at the sensors of the test, (34 x modes).
fn at_sensors(model: &Model, modes: &Modes) -> DMatrix<f64> {
    observation_matrix(model, &gvt().sensors).unwrap() * &modes.shapes
}

/// The reference, or a message.
fn reference() -> Option<Value> {
    let folder = std::env::var("RETUNE_DESIGN")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/design").to_string());
    let path = Path::new(&folder).join("bff-reference.json");
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(serde_json::from_str(&text).expect("the reference is JSON")),
        Err(e) => {
            eprintln!("skipped: {}: {e}; set RETUNE_DESIGN to the folder of bff-reference.json", path.display());
            None
        }
    }
}

/// A value of the reference by its path, `cases/updated/frequencies_hz`.
fn at<'a>(reference: &'a Value, path: &str) -> &'a Value {
    reference.pointer(&format!("/{path}")).unwrap_or_else(|| panic!("the reference has no {path}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn vector(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value} is not a list")).iter().map(number).collect()
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> =
        value.as_array().unwrap_or_else(|| panic!("{value} is not a list")).iter().map(vector).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

/// Fails unless |value - expected| <= tolerance |expected|.
fn assert_relative(value: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (value - expected).abs();
    assert!(error <= tolerance * expected.abs(), "{what}: {value:e}, expected {expected:e} within {tolerance:e} of it");
}

/// Fails unless every entry agrees within `tolerance`.
fn assert_entries(value: &DMatrix<f64>, expected: &DMatrix<f64>, tolerance: f64, what: &str) {
    assert_eq!(value.shape(), expected.shape(), "{what}");
    let error = (value - expected).amax();
    assert!(error <= tolerance, "{what}: largest difference {error:e}, allowed {tolerance:e}");
}
