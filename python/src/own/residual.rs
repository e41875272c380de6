//! A residual term that is a Python object.

use super::{Failure, forever};
use crate::arrays;
use crate::error::Wrong;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use retune::data::TestData;
use retune::linalg::DMatrix;
use retune::objective::{Comparison, Point, PredictionDerivative, Residual};
use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};
use std::sync::{Arc, Mutex, PoisonError};

/// Its rows are functions of Python, which take the GIL for each call.
#[derive(Debug)]
pub(crate) struct PythonResidual {
    name: &'static str,
    summary: &'static str,
    /// (test) -> a name for each row.
    rows: Py<PyAny>,
    /// (test, what the model predicts) -> the rows.
    evaluate: Py<PyAny>,
    /// Names of the rows, by what the test says: a search asks for their number at every point.
    known: Mutex<HashMap<u64, Arc<Vec<String>>>>,
    pub(crate) failure: Failure,
}

/// A residual term of the user's.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct OwnResidual(pub(crate) &'static PythonResidual);

#[pymethods]
impl OwnResidual {
    #[new]
    fn new(name: String, summary: String, rows: Py<PyAny>, evaluate: Py<PyAny>) -> Self {
        let failure = Failure::new(&name);
        let (name, summary) = (forever(name), forever(summary));
        let residual = PythonResidual { name, summary, rows, evaluate, known: Mutex::default(), failure };
        Self(Box::leak(Box::new(residual)))
    }
}

/// What a residual sees of the model at a point, of the modes of the test in their order.
struct Predicted {
    theta: Vec<f64>,
    /// NaN where the model has no partner.
    frequencies: Vec<f64>,
    /// (n_sensors x n_modes); NaN where the model has no partner.
    shapes: DMatrix<f64>,
}

/// What a residual sees of the test.
fn test_of<'py>(py: Python<'py>, comparison: &Comparison<'_>) -> PyResult<Bound<'py, PyDict>> {
    let test = comparison.test();
    let of = |f: &dyn Fn(&retune::data::TestMode) -> f64| arrays::vector(py, test.modes.iter().map(f).collect());
    let out = PyDict::new(py);
    out.set_item("sensors", test.sensors.iter().map(|s| s.name.clone()).collect::<Vec<_>>())?;
    out.set_item("frequencies", of(&|m| m.frequency_hz.value))?;
    out.set_item("frequency_sd", of(&|m| m.frequency_hz.sd))?;
    out.set_item("shapes", arrays::matrix(py, comparison.shapes().clone())?)?;
    let sd = DMatrix::from_fn(test.sensors.len(), test.modes.len(), |i, j| {
        test.modes[j].shape_sd.as_ref().map_or(f64::NAN, |sd| sd[i])
    });
    out.set_item("shape_sd", arrays::matrix(py, sd)?)?;
    let aside: Vec<bool> = (0..test.modes.len()).map(|k| comparison.is_aside(k)).collect();
    out.set_item("is_aside", arrays::vector(py, aside))?;
    out.set_item("parameters", comparison.model().parameters().names().map(str::to_string).collect::<Vec<_>>())?;
    Ok(out)
}

impl Predicted {
    fn of(at: &Point<'_>) -> Self {
        let n_modes = at.comparison.test().modes.len();
        let n_sensors = at.prediction.at_sensors.nrows();
        let mut out = Self {
            theta: at.theta.to_vec(),
            frequencies: vec![f64::NAN; n_modes],
            shapes: DMatrix::from_element(n_sensors, n_modes, f64::NAN),
        };
        for k in 0..n_modes {
            if let Some(a) = at.prediction.partner(k) {
                out.frequencies[k] = at.prediction.frequencies_hz[a];
                if a < at.prediction.at_sensors.ncols() {
                    out.shapes.set_column(k, &at.prediction.at_sensors.column(a));
                }
            }
        }
        out
    }

    /// At a parameter that is moved by a step, to first order.
    ///
    /// * `j` - among the free parameters
    fn moved(&self, at: &Point<'_>, derivative: &PredictionDerivative, j: usize, step: f64) -> Self {
        let mut out =
            Self { theta: self.theta.clone(), frequencies: self.frequencies.clone(), shapes: self.shapes.clone() };
        out.theta[at.scaling.free()[j]] += step;
        for k in 0..out.frequencies.len() {
            let slopes = at.prediction.partner(k).and_then(|a| derivative.modes.get(a)?.as_ref());
            if let Some((df, d_phi)) = slopes {
                out.frequencies[k] += step * df[j];
                let mut column = out.shapes.column_mut(k);
                column.axpy(step, &d_phi.column(j), 1.0);
            }
        }
        out
    }
}

impl PythonResidual {
    fn names(&self, comparison: &Comparison<'_>) -> Arc<Vec<String>> {
        let key = said(comparison.test());
        if let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return Arc::clone(known);
        }
        let found = Python::attach(|py| {
            let ask = || self.rows.call1(py, (test_of(py, comparison)?,))?.extract::<Vec<String>>(py);
            self.failure.caught(py, ask())
        });
        let found = Arc::new(found.unwrap_or_default());
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(key, Arc::clone(&found));
        found
    }

    /// Rows that are not numbers say that there are none here.
    fn ask(&self, comparison: &Comparison<'_>, predicted: Predicted, out: &mut [f64]) {
        let found = Python::attach(|py| {
            let ask = || {
                let Predicted { theta, frequencies, shapes } = predicted;
                let model = (arrays::vector(py, theta), arrays::vector(py, frequencies), arrays::matrix(py, shapes)?);
                let found = self.evaluate.call1(py, (test_of(py, comparison)?, model))?;
                let rows = arrays::values(&found.bind(py).extract::<PyReadonlyArray1<'_, f64>>()?);
                if rows.len() != out.len() {
                    let text = format!("it gives {} rows; it names {}", rows.len(), out.len());
                    return Err(Wrong::text(text).into());
                }
                Ok(rows)
            };
            self.failure.caught(py, ask())
        });
        match found {
            Some(rows) => out.copy_from_slice(&rows),
            None => out.fill(f64::NAN),
        }
    }
}

/// A hash of what the rows of a term may depend on.
fn said(test: &TestData) -> u64 {
    let mut hasher = DefaultHasher::new();
    for mode in &test.modes {
        mode.frequency_hz.value.to_bits().hash(&mut hasher);
        mode.frequency_hz.sd.to_bits().hash(&mut hasher);
        mode.shape.is_some().hash(&mut hasher);
        mode.standing.is_aside().hash(&mut hasher);
    }
    test.sensors.iter().for_each(|s| s.name.hash(&mut hasher));
    hasher.finish()
}

impl Residual for PythonResidual {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        self.names(comparison).len()
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        self.names(comparison).get(row).cloned().unwrap_or_else(|| self.name.to_string())
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        self.ask(at.comparison, Predicted::of(at), out);
    }

    /// The derivatives of frequencies and shapes are those of the model; how the rows follow from these is taken by central differences.
    fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>) {
        let here = Predicted::of(at);
        let parameters = at.comparison.model().parameters();
        let n = out.nrows();
        let (mut above, mut below) = (vec![0.0; n], vec![0.0; n]);
        for (j, &free) in at.scaling.free().iter().enumerate() {
            let step = parameters.difference_step(at.theta, free);
            self.ask(at.comparison, here.moved(at, derivative, j, step), &mut above);
            self.ask(at.comparison, here.moved(at, derivative, j, -step), &mut below);
            for i in 0..n {
                out[(i, j)] = (above[i] - below[i]) / (2.0 * step);
            }
        }
    }
}
