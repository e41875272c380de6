//! What is missing: physical effects and measurement faults, compared with "nothing" by evidence.
//!
//! ```text
//! fit the base -> screen every placed effect and fault with the base projected out -> alarm, calibrated by simulation
//!   -> refit the best -> evidence, held-out modes, ties -> is what remains noise? -> verdict -> next measurement
//! ```
//!
//! The rooms, each standing on those before it:
//!
//! * `problem` - a structure against its tests: rows, optimum, evidence
//! * `screen` - what every effect and fault would change at a fit, and how large that is by chance
//! * `search` - hypotheses proposed and fitted in full: single ones, larger places, two or more together
//! * `verdict` - probabilities, what is named, in words, and what to measure next
//!
//! `answer` asks them in this order, `foreign` settles which modes are of the structure, `damping` reads ratios that the model has nothing for, [`learn`]
//! repeats it all with what was found in the model.
//! Stated numbers are SI.

mod answer;
pub mod benchmark;
mod damping;
mod effort;
mod error;
mod foreign;
mod learn;
mod listener;
mod problem;
mod result;
mod screen;
mod search;
mod settings;
#[cfg(test)]
mod tests;
mod thresholds;
mod until;
mod verdict;

pub use damping::{DampedMode, DampingLaw, DampingReading, DampingTerm};
pub use effort::Effort;
pub use error::DiagnosisError;
pub use learn::{Attempt, Learned, Step, learn, learn_from_tests};
pub use listener::{Listener, StepTaken};
pub use problem::work::WorkDone;
pub use result::{
    BasePair, BasePairs, Diagnosis, ForeignMode, HypothesisResult, Kind, NextMeasurement, Together, Verdict,
};
pub use screen::stage::sensor_loads;
pub use search::hypothesis::Estimate;
pub use search::spread::{Property, Spread, SpreadFactor};
pub use settings::Settings;
pub use until::Until;

use foreign::investigate;
use problem::scene::Scene;
use retune::data::TestData;
use retune::model::Model;

/// Finds what a model lacks to explain a test.
///
/// Errors: nothing to compare with, a sensor without a place on the model, a model that cannot be solved anywhere.
pub fn diagnose(model: &Model, test: &TestData, settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    diagnose_tests(model, &[test], settings)
}

/// Finds what a model lacks to explain several tests of one structure, each made in a configuration of the model file.
///
/// All tests are fitted with the same parameters. An effect of the structure acts in every configuration, one of a support or of
/// a rig where it is; a fault acts on the tests that have its sensor. Modes are numbered through all tests.
///
/// * `model` - the model of the file, with its configurations
/// * `tests` - each names its configuration, or none for the base model
///
/// # Errors
/// As [`diagnose`]; an unknown configuration.
pub fn diagnose_tests(model: &Model, tests: &[&TestData], settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    Ok(investigate(Scene::new(model, tests)?, &[], None, settings)?.diagnosis)
}
