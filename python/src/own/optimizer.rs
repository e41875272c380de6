//! An optimiser that is a Python object.
//!
//! The run that it searches with is borrowed, and Python can borrow nothing. So the function of Python works on a thread of its own and asks
//! through a channel; the thread that has the run answers until the function is done.

use super::{Failure, forever};
use crate::arrays;
use crate::error::Wrong;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use retune::linalg::DVector;
use retune::objective::{EvalError, Linearization};
use retune::optim::{Draw as _, OptimError, Optimizer, Optimum, Run as Search, Stop, Termination};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};

#[derive(Debug)]
pub(crate) struct PythonOptimizer {
    name: &'static str,
    /// (start, run)
    minimize: Py<PyAny>,
    pub(crate) failure: Failure,
}

/// An optimiser of the user's.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct OwnOptimizer(pub(crate) &'static PythonOptimizer);

#[pymethods]
impl OwnOptimizer {
    #[new]
    fn new(name: String, minimize: Py<PyAny>) -> Self {
        let failure = Failure::new(&name);
        Self(Box::leak(Box::new(PythonOptimizer { name: forever(name), minimize, failure })))
    }
}

/// Seeds are below this, and whole numbers of double precision.
const LARGEST_SEED: f64 = 9_007_199_254_740_992.0;

enum Question {
    Costs(Vec<DVector<f64>>),
    Linearize(DVector<f64>),
    Remaining,
    Seed(u64),
    /// The function of Python is done.
    Over,
}

enum Answer {
    Costs(Vec<f64>),
    Linearization(Result<Linearization, EvalError>),
    Remaining(Option<u64>),
    Seed(u64),
    /// Nothing further is evaluated.
    Ended,
}

/// What a search asks for costs.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Run {
    line: Mutex<(Sender<Question>, Receiver<Answer>)>,
    #[pyo3(get)]
    n_parameters: usize,
    #[pyo3(get)]
    n_residuals: usize,
}

/// Residuals and Jacobian.
type Linearized<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl Run {
    /// Costs of points, (n_points x n_parameters).
    fn costs<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'_, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = points.as_array();
        let rows = points.rows().into_iter().map(|row| self.point(row.iter().copied()));
        match self.ask(py, Question::Costs(rows.collect::<PyResult<_>>()?))? {
            Answer::Costs(costs) => Ok(arrays::vector(py, costs)),
            _ => Err(ended(py)),
        }
    }

    /// Residuals and Jacobian at a point; `None` where the model has none.
    fn linearize<'py>(&self, py: Python<'py>, x: PyReadonlyArray1<'_, f64>) -> PyResult<Option<Linearized<'py>>> {
        match self.ask(py, Question::Linearize(self.point(arrays::values(&x).into_iter())?))? {
            Answer::Linearization(Ok(Linearization { residuals, jacobian })) => {
                Ok(Some((arrays::vector(py, residuals.data.into()), arrays::matrix(py, jacobian)?)))
            }
            Answer::Linearization(Err(_)) => Ok(None),
            _ => Err(ended(py)),
        }
    }

    /// Evaluations that are left, if they are limited.
    fn remaining(&self, py: Python<'_>) -> PyResult<Option<u64>> {
        match self.ask(py, Question::Remaining)? {
            Answer::Remaining(left) => Ok(left),
            _ => Err(ended(py)),
        }
    }

    /// A seed that follows from that of the run.
    fn seed(&self, py: Python<'_>, stream: u64) -> PyResult<u64> {
        match self.ask(py, Question::Seed(stream))? {
            Answer::Seed(seed) => Ok(seed),
            _ => Err(ended(py)),
        }
    }
}

/// `retune.SearchEnded`
fn ended(py: Python<'_>) -> PyErr {
    let raise = || py.import("retune._optimizer")?.getattr("SearchEnded")?.call0();
    raise().map_or_else(|e| e, PyErr::from_value)
}

impl Run {
    fn point(&self, values: impl Iterator<Item = f64>) -> PyResult<DVector<f64>> {
        let x = DVector::from_vec(values.collect());
        if x.len() != self.n_parameters {
            let text = format!("x has {} entries; there are {} free parameters", x.len(), self.n_parameters);
            return Err(Wrong::text(text).into());
        }
        match x.iter().position(|v| !(0.0..=1.0).contains(v)) {
            Some(k) => Err(Wrong::text(format!("x[{k}] is {}; points are of the unit box", x[k])).into()),
            None => Ok(x),
        }
    }

    fn ask(&self, py: Python<'_>, question: Question) -> PyResult<Answer> {
        py.detach(|| {
            let line = self.line.lock().unwrap_or_else(PoisonError::into_inner);
            // Nobody answers once the search is over.
            Ok(line.0.send(question).ok().and_then(|()| line.1.recv().ok()).unwrap_or(Answer::Ended))
        })
    }
}

impl Optimizer for PythonOptimizer {
    fn name(&self) -> &'static str {
        self.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Search<'_>) -> Result<Optimum, OptimError> {
        let x = run.clip(start)?;
        let sizes = (run.n_parameters(), run.n_residuals());
        run.conclude(self.name, |run| {
            let (ask, questions) = channel();
            let (answers, told) = channel();
            let over = ask.clone();
            let work = move || {
                let done = Python::attach(|py| {
                    let (n_parameters, n_residuals) = sizes;
                    let handle = Run { line: Mutex::new((ask, told)), n_parameters, n_residuals };
                    let start = arrays::vector(py, x.as_slice().to_vec());
                    let called = Py::new(py, handle).and_then(|run| self.minimize.call1(py, (start, run)));
                    let ended = called.map(|said| match said.extract::<bool>(py) {
                        Ok(true) => Termination::PointsAgree,
                        _ => Termination::PlanDone,
                    });
                    match ended {
                        Err(e) if is_end(py, &e) => Some(Termination::PlanDone),
                        ended => self.failure.caught(py, ended),
                    }
                });
                let _ = over.send(Question::Over);
                done
            };
            std::thread::scope(|scope| {
                let python = scope.spawn(work);
                let stop = answer(run, &questions, &answers);
                let ended = python.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                match (stop, ended) {
                    (Some(stop), _) => Err(stop),
                    (None, Some(termination)) => Ok(termination),
                    (None, None) => {
                        Err(OptimError::Evaluator { source: format!("{} has raised", self.name).into() }.into())
                    }
                }
            })
        })
    }
}

fn is_end(py: Python<'_>, error: &PyErr) -> bool {
    let class = py.import("retune._optimizer").and_then(|m| m.getattr("SearchEnded"));
    class.is_ok_and(|class| error.matches(py, class).unwrap_or(false))
}

/// Answers until the function of Python is done; why the run evaluates no further, if it does not.
fn answer(run: &mut Search<'_>, questions: &Receiver<Question>, answers: &Sender<Answer>) -> Option<Stop> {
    let mut stop = None;
    for question in questions {
        let found = match question {
            Question::Over => break,
            _ if stop.is_some() => Ok(Answer::Ended),
            Question::Costs(points) => {
                let mut costs = vec![f64::INFINITY; points.len()];
                run.costs(&points, &mut costs).map(|()| Answer::Costs(costs))
            }
            Question::Linearize(x) => run.linearize(&x).map(Answer::Linearization),
            Question::Remaining => Ok(Answer::Remaining(run.remaining())),
            Question::Seed(stream) => Ok(Answer::Seed((run.rng(stream).unit() * LARGEST_SEED) as u64)),
        };
        let told = found.unwrap_or_else(|why| {
            stop = Some(why);
            Answer::Ended
        });
        if answers.send(told).is_err() {
            break;
        }
    }
    stop
}
