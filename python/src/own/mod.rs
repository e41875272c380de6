//! Members of a user's own as Python classes: elements, effects, faults, residual terms, optimisers.
//!
//! Each is a class of the extension module around functions of Python, and an adapter that implements the trait of the library. The lists of
//! the library hold their members for as long as the process runs, so an adapter is leaked once for each Python object, and never for a call.
//!
//! Traits that answer without an error, because those of the library cannot fail, get an empty answer where a function of Python raises;
//! the first exception is kept, and whoever ran the work raises it afterwards ([`settled`]).

mod effect;
mod element;
mod fault;
mod optimizer;
mod residual;

pub(crate) use effect::OwnEffect;
pub(crate) use element::{Elements, OwnElement};
pub(crate) use fault::OwnFault;
pub(crate) use optimizer::{OwnOptimizer, Run};
pub(crate) use residual::OwnResidual;

use crate::error::Wrong;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// What functions of a member have raised.
#[derive(Debug)]
pub(crate) struct Failure {
    name: String,
    first: Mutex<Option<PyErr>>,
}

impl Failure {
    fn new(name: &str) -> Self {
        Self { name: name.to_string(), first: Mutex::new(None) }
    }

    /// What a call gave; nothing where it raised.
    fn caught<T>(&self, py: Python<'_>, called: PyResult<T>) -> Option<T> {
        match called {
            Ok(found) => Some(found),
            Err(e) => {
                let error = raised(py, &self.name, e);
                self.first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                None
            }
        }
    }

    fn taken(&self) -> Option<PyErr> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// `retune.RetuneError` that names the member, with the exception as its cause.
fn raised(py: Python<'_>, name: &str, error: PyErr) -> PyErr {
    let wrong = PyErr::from(Wrong::text(format!("{name}: {error}")));
    wrong.set_cause(py, Some(error));
    wrong
}

/// What came of work, or what a member raised in it.
pub(crate) fn settled<'a, T>(found: PyResult<T>, failures: impl IntoIterator<Item = &'a Failure>) -> PyResult<T> {
    // Of every member, so that none raises in the next call what it did in this one.
    let mut all: Vec<PyErr> = failures.into_iter().filter_map(Failure::taken).collect();
    if all.is_empty() { found } else { Err(all.swap_remove(0)) }
}

/// A text that lives as long as the process.
fn forever(text: String) -> &'static str {
    Box::leak(text.into_boxed_str())
}

/// Texts that live as long as the process.
fn all_forever(texts: Vec<String>) -> &'static [&'static str] {
    Box::leak(texts.into_iter().map(forever).collect())
}
