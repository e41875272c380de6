//! What `compare` says, held to its own probabilities, to structures with known errors, and to other programs.

mod calibration;
mod localization;
mod peers;
mod workflow;

use retune::correlation::{PairBy, PairingOptions};
use retune::data::{Sensor, TestData, read_test};
use retune::model::{Model, ParametricModel, Registry, load};
use retune::update::{TwinOptions, node_sensors, twin_modes};
use std::path::Path;

/// Every measured mode finds a partner.
const OPEN: PairingOptions =
    PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: false };

fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn model(file: &str) -> Model {
    load(&text(file), &Registry::builtin()).unwrap_or_else(|p| panic!("{file}: {p:?}")).0
}

fn gvt() -> TestData {
    read_test(&text("bff_gvt.yaml")).unwrap_or_else(|p| panic!("{p:?}")).0
}

/// The sensors of the flagship's test for the flagship, a sensor on every node for the others.
fn sensors(file: &str, model: &Model) -> Vec<Sensor> {
    if file.starts_with("bff") { gvt().sensors } else { node_sensors(model) }
}

/// A synthetic test of a model at its estimates, moved into their bounds.
fn twin(truth: &Model, sensors: &[Sensor], n_modes: usize, noise: (f64, f64), seed: u64) -> TestData {
    let options =
        TwinOptions { n_modes, frequency_noise: noise.0, shape_noise: noise.1, seed, ..TwinOptions::default() };
    let theta = retune::objective::starting_point(truth);
    twin_modes(truth, &theta, sensors, &options, "a test of this program").unwrap_or_else(|e| panic!("{e}"))
}

fn slow() -> bool {
    std::env::var("RETUNE_SLOW").as_deref() == Ok("1")
}

/// Number of dofs, to show that a structure is not the one before.
fn n_dof(model: &Model) -> usize {
    model.dof_map().n_dof()
}
