//! What is wrong, on its way to `retune.RetuneError`.

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use retune::yaml::{Problem, Severity};

/// What is wrong, with the place where it stands if there is one.
#[derive(Debug)]
pub(crate) enum Wrong {
    /// An error of the library.
    Text(String),
    /// Problems of a file or text.
    Problems { file: Option<String>, problems: Vec<Problem> },
    /// Stopped before there was a result.
    Stopped,
}

impl Wrong {
    pub(crate) fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    pub(crate) fn problems(file: Option<&str>, problems: Vec<Problem>) -> Self {
        Self::Problems { file: file.map(str::to_string), problems }
    }
}

impl<E: std::error::Error> From<E> for Wrong {
    fn from(error: E) -> Self {
        let mut text = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            // A transparent variant repeats its cause word for word.
            if !text.ends_with(&cause.to_string()) {
                text += &format!(": {cause}");
            }
            source = cause.source();
        }
        Self::Text(text)
    }
}

impl From<Wrong> for PyErr {
    fn from(wrong: Wrong) -> Self {
        match wrong {
            Wrong::Stopped => PyKeyboardInterrupt::new_err("stopped before there was a result"),
            Wrong::Text(text) => raised(&text, None, &[]),
            Wrong::Problems { file, mut problems } => {
                problems.sort_by_key(|p| (std::cmp::Reverse(p.severity), p.location));
                let name = file.as_deref().unwrap_or("<text>");
                let lines: Vec<String> = problems.iter().map(|p| p.render(name)).collect();
                raised(&lines.join("\n"), file.as_deref(), &problems)
            }
        }
    }
}

/// `retune.RetuneError`, which is written in Python.
fn raised(text: &str, file: Option<&str>, problems: &[Problem]) -> PyErr {
    Python::attach(|py| {
        let make = || {
            let keywords = PyDict::new(py);
            keywords.set_item("path", file)?;
            keywords.set_item("problems", problem_list(py, problems)?)?;
            py.import("retune._errors")?.getattr("RetuneError")?.call((text,), Some(&keywords))
        };
        make().map_or_else(|e| e, PyErr::from_value)
    })
}

/// Problems as (severity, key, line, column, message).
pub(crate) fn problem_list<'py>(py: Python<'py>, problems: &[Problem]) -> PyResult<Bound<'py, PyList>> {
    let one = |p: &Problem| {
        let severity = if p.severity == Severity::Error { "error" } else { "warning" };
        (severity, p.path.clone(), p.location.map(|l| l.line), p.location.map(|l| l.column), p.message.clone())
    };
    PyList::new(py, problems.iter().map(one))
}
