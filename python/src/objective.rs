//! The objective of a fit, for searches of the user's own; and every search of the library, taken apart into questions and answers.
//!
//! An objective borrows the comparison that it was made of. It lives on a thread of its own, on whose stack all of that stands, and
//! answers questions that come through a channel: no lifetime reaches Python, and nothing is unsafe.

use crate::arrays;
use crate::error::Wrong;
use crate::own::{Failure, settled};
use crate::running::{Stops, run};
use crate::test::Test;
use crate::tested::{Given, Pairing, all_tested, cases};
use crate::verbs::settings::{OwnTerms, failures, settings};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use retune::linalg::{DMatrix, DVector};
use retune::objective::{EvalError, Linearization};
use retune::optim::{Ask, AskTell, Evaluator as _, OptimError, Problem, Threads};
use retune::update::with_objective;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

enum Question {
    Residuals(DVector<f64>),
    Linearize(DVector<f64>),
    Costs(Vec<DVector<f64>>),
    Theta(DVector<f64>),
    Coordinates(Vec<f64>),
}

enum Answer {
    Vector(Result<DVector<f64>, EvalError>),
    Linearization(Result<Linearization, EvalError>),
    Costs(Vec<f64>),
    Theta(Vec<f64>),
}

/// Residuals and Jacobian.
type Linearized<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// What is known of an objective when it stands.
struct Standing {
    names: Vec<String>,
    n_residuals: usize,
    start: DVector<f64>,
}

/// A cost over the unit box of the free parameters.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Objective {
    line: Mutex<(Sender<Question>, Receiver<Answer>)>,
    standing: Standing,
    remarks: Vec<(&'static str, String)>,
    /// What residual terms of the user's may raise.
    failures: Vec<&'static Failure>,
}

#[pymethods]
impl Objective {
    #[new]
    #[pyo3(signature = (model, tests, cost, objective, pairing, configuration, sensor_masses, residuals))]
    #[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
    fn new(
        py: Python<'_>,
        model: Given,
        tests: Vec<PyRef<'_, Test>>,
        cost: &str,
        objective: Option<&str>,
        pairing: Pairing,
        configuration: Option<String>,
        sensor_masses: bool,
        residuals: OwnTerms<'_>,
    ) -> PyResult<Self> {
        let settings = settings(cost, (objective, &residuals), &pairing, None, 0, None)?;
        let failures = failures(&residuals);
        let kept = failures.clone();
        let tests: Vec<_> = tests.iter().map(|t| Arc::clone(&t.0)).collect();
        let made = run(py, None, Stops::Never, move |_| {
            let all = all_tested(&model, &tests, configuration.as_deref(), Some(sensor_masses))?;
            let remarks = all.iter().flat_map(|t| t.remarks.clone()).collect();
            let (ask, questions) = channel();
            let (answers, told) = channel();
            let (stands, is_standing) = channel::<Result<Standing, Wrong>>();
            let at_work = move || {
                let serve = |objective: &dyn retune::objective::Objective,
                             scaling: &retune::objective::Scaling,
                             start: &DVector<f64>| {
                    let parameters = all[0].model.parametric().parameters();
                    let names = scaling.free().iter().map(|&i| parameters.get(i).name.clone()).collect();
                    let n_residuals = objective.n_residuals();
                    let _ = stands.send(Ok(Standing { names, n_residuals, start: start.clone() }));
                    for question in &questions {
                        let answer = match question {
                            Question::Residuals(x) => Answer::Vector(objective.residuals(&x)),
                            Question::Linearize(x) => Answer::Linearization(objective.linearize(&x)),
                            Question::Costs(points) => Answer::Costs(costs(objective, &points)),
                            Question::Theta(x) => Answer::Theta(scaling.theta(&x)),
                            Question::Coordinates(theta) => Answer::Vector(Ok(scaling.x(&theta))),
                        };
                        if answers.send(answer).is_err() {
                            return;
                        }
                    }
                };
                if let Err(e) = with_objective(&cases(&all), &settings, serve) {
                    let _ = stands.send(Err(e.into()));
                }
            };
            std::thread::Builder::new().name("retune-objective".into()).stack_size(8 << 20).spawn(at_work)?;
            let standing = is_standing.recv()??;
            Ok(Self { line: Mutex::new((ask, told)), standing, remarks, failures: kept })
        });
        settled(made, failures)
    }

    fn remarks(&self) -> Vec<(&'static str, String)> {
        self.remarks.clone()
    }

    /// Names of the free parameters, in the order of x.
    fn names(&self) -> Vec<String> {
        self.standing.names.clone()
    }

    #[getter]
    fn n_residuals(&self) -> usize {
        self.standing.n_residuals
    }

    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::vector(py, self.standing.start.as_slice().to_vec())
    }

    fn residuals<'py>(&self, py: Python<'py>, x: PyReadonlyArray1<'_, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        match self.ask(py, Question::Residuals(self.x(&x)?))? {
            Answer::Vector(found) => Ok(arrays::vector(py, found.map_err(Wrong::from)?.data.into())),
            _ => Err(mixed_up().into()),
        }
    }

    /// Residuals and their Jacobian, (n_residuals x n_free).
    fn linearize<'py>(&self, py: Python<'py>, x: PyReadonlyArray1<'_, f64>) -> PyResult<Linearized<'py>> {
        match self.ask(py, Question::Linearize(self.x(&x)?))? {
            Answer::Linearization(found) => {
                let Linearization { residuals, jacobian } = found.map_err(Wrong::from)?;
                Ok((arrays::vector(py, residuals.data.into()), arrays::matrix(py, jacobian)?))
            }
            _ => Err(mixed_up().into()),
        }
    }

    /// Costs of points, (n_points x n_free); infinite where the model has none.
    fn costs<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'_, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points = points.as_array();
        let n = self.standing.names.len();
        if points.ncols() != n {
            let text = format!("points have {} entries; there are {n} free parameters", points.ncols());
            return Err(Wrong::text(text).into());
        }
        let rows = points.rows().into_iter().map(|row| DVector::from_iterator(n, row.iter().copied())).collect();
        match self.ask(py, Question::Costs(rows))? {
            Answer::Costs(costs) => Ok(arrays::vector(py, costs)),
            _ => Err(mixed_up().into()),
        }
    }

    /// All parameters, SI, at a point of the box.
    fn theta<'py>(&self, py: Python<'py>, x: PyReadonlyArray1<'_, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        match self.ask(py, Question::Theta(self.x(&x)?))? {
            Answer::Theta(theta) => Ok(arrays::vector(py, theta)),
            _ => Err(mixed_up().into()),
        }
    }

    /// The point of the box of some parameters, SI.
    fn x_of<'py>(&self, py: Python<'py>, theta: PyReadonlyArray1<'_, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        match self.ask(py, Question::Coordinates(arrays::values(&theta)))? {
            Answer::Vector(x) => Ok(arrays::vector(py, x.map_err(Wrong::from)?.data.into())),
            _ => Err(mixed_up().into()),
        }
    }
}

impl Objective {
    fn x(&self, x: &PyReadonlyArray1<'_, f64>) -> Result<DVector<f64>, Wrong> {
        arrays::point(x, self.standing.names.len())
    }

    fn ask(&self, py: Python<'_>, question: Question) -> PyResult<Answer> {
        let answer = py.detach(|| {
            let line = self.line.lock().unwrap_or_else(PoisonError::into_inner);
            line.0.send(question).map_err(Wrong::from)?;
            Ok::<_, Wrong>(line.1.recv()?)
        });
        settled(answer.map_err(PyErr::from), self.failures.iter().copied())
    }
}

fn mixed_up() -> Wrong {
    Wrong::text("the objective answered another question")
}

fn costs(objective: &dyn retune::objective::Objective, points: &[DVector<f64>]) -> Vec<f64> {
    let mut out = vec![f64::INFINITY; points.len()];
    // Threads evaluate, and evaluation of costs cannot fail.
    if Threads.costs(objective, points, &mut out, &AtomicBool::new(false)).is_err() {
        out.fill(f64::INFINITY);
    }
    out
}

/// A search that asks and is told.
#[pyclass(module = "retune._core")]
pub(crate) struct Search {
    search: Mutex<AskTell>,
}

/// What a search wants: (question, points, optimum), of which the last two may be missing.
type Asked<'py> = (&'static str, Option<Bound<'py, PyArray2<f64>>>, Option<Found<'py>>);
/// x, cost, evaluations, termination.
type Found<'py> = (Bound<'py, PyArray1<f64>>, f64, u64, &'static str);

#[pymethods]
impl Search {
    #[new]
    #[pyo3(signature = (optimizer, start, n_residuals, seed, budget))]
    fn new(
        optimizer: &str,
        start: PyReadonlyArray1<'_, f64>,
        n_residuals: usize,
        seed: u64,
        budget: Option<u64>,
    ) -> PyResult<Self> {
        let spec = retune::yaml::read::<retune::optim::OptimizerSpec>(optimizer);
        let (spec, _) = spec.map_err(|p| Wrong::problems(Some("optimizer"), p))?;
        let start = DVector::from_vec(arrays::values(&start));
        let problem = Problem { n_parameters: start.len(), n_residuals, seed, budget };
        Ok(Self { search: Mutex::new(AskTell::new(Arc::new(spec), start, problem)) })
    }

    fn ask<'py>(&self, py: Python<'py>) -> PyResult<Asked<'py>> {
        enum Owned {
            Points(&'static str, DMatrix<f64>),
            Done(DVector<f64>, f64, u64, &'static str),
        }
        let matrix = |points: &[DVector<f64>]| {
            let n = points.first().map_or(0, DVector::len);
            DMatrix::from_fn(points.len(), n, |i, j| points[i][j])
        };
        let asked = py.detach(|| {
            let mut search = self.search.lock().unwrap_or_else(PoisonError::into_inner);
            Ok::<_, OptimError>(match search.ask()? {
                Ask::Costs(points) => Owned::Points("costs", matrix(points)),
                Ask::Linearizations(points) => Owned::Points("linearizations", matrix(points)),
                Ask::Done(o) => {
                    Owned::Done(o.x.clone(), o.cost, o.evaluations + o.linearizations, o.termination.text())
                }
            })
        });
        match asked.map_err(Wrong::from)? {
            Owned::Points(question, points) => Ok((question, Some(arrays::matrix(py, points)?), None)),
            Owned::Done(x, cost, evaluations, termination) => {
                Ok(("done", None, Some((arrays::vector(py, x.data.into()), cost, evaluations, termination))))
            }
        }
    }

    fn tell_costs(&self, py: Python<'_>, costs: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let costs = arrays::values(&costs);
        let tell = || self.search.lock().unwrap_or_else(PoisonError::into_inner).tell_costs(&costs);
        Ok(py.detach(tell).map_err(Wrong::from)?)
    }

    /// One (residuals, Jacobian) a point; `None` for a point that cannot be evaluated.
    fn tell_linearizations(
        &self,
        py: Python<'_>,
        told: Vec<Option<(PyReadonlyArray1<'_, f64>, PyReadonlyArray2<'_, f64>)>>,
    ) -> PyResult<()> {
        let one = |told: &Option<(PyReadonlyArray1<'_, f64>, PyReadonlyArray2<'_, f64>)>| match told {
            None => Err(EvalError::Unsolvable { reason: "so it was told".to_string() }),
            Some((residuals, jacobian)) => {
                let a = jacobian.as_array();
                let jacobian = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[[i, j]]);
                Ok(Linearization { residuals: DVector::from_vec(arrays::values(residuals)), jacobian })
            }
        };
        let told = told.iter().map(one).collect();
        let tell = || self.search.lock().unwrap_or_else(PoisonError::into_inner).tell_linearizations(told);
        Ok(py.detach(tell).map_err(Wrong::from)?)
    }
}
