//! What several verbs take.

use crate::error::Wrong;
use crate::page::Made;
use crate::test::{Test, TestSource};
use crate::tested::Given;
use pyo3::prelude::*;
use retune::units::Scalar;
use std::sync::Arc;

/// Tests, as they are given.
pub(super) type Tests<'py> = Vec<PyRef<'py, Test>>;
/// A progress function.
pub(super) type OneProgress<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

/// What a result is made of.
pub(super) fn made(given: &Given, tests: &[Arc<TestSource>], call: &'static str, seed: Option<u64>) -> Made {
    Made { given: given.clone(), tests: tests.to_vec(), call, seed }
}

/// The tests, free of Python.
pub(super) fn sources(tests: &Tests<'_>) -> Vec<Arc<TestSource>> {
    tests.iter().map(|t| Arc::clone(&t.0)).collect()
}

/// Notes and warnings as (category, text).
pub(super) type Remarks = Vec<(&'static str, String)>;

/// A number as a user writes it: `0.3 %`, `0.003`.
pub(super) fn scalar(name: &str, text: &str, unit: &str) -> Result<f64, Wrong> {
    let value = Scalar::parse(text).map_err(|e| Wrong::text(format!("{name}: {e}")))?;
    value.constant_in(unit).map_err(|e| Wrong::text(format!("{name}: {e}")))
}

/// The same, above zero and without a unit.
pub(super) fn positive(name: &str, text: &str) -> Result<f64, Wrong> {
    let value = scalar(name, text, "1")?;
    if value > 0.0 { Ok(value) } else { Err(Wrong::text(format!("{name} is {text}; it must be above zero"))) }
}
