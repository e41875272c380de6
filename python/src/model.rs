//! A model, as Python sees it.

use crate::arrays;
use crate::error::{Wrong, problem_list};
use crate::own::{Elements, OwnEffect, OwnElement, settled};
use crate::running::on_pool;
use crate::source::{Home, Source, read};
use crate::test::{Frfs, Test, quantity_of, sensors_of};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyList;
use retune::data::Sensor;
use retune::effect::{Context, Effects, Structure, conformance, set_parameter_values, undo};
use retune::linalg::sparse::SparseSym;
use retune::modal::{Modes, SolveOptions};
use retune::model::{self, ParametricModel, solve_modes};
use retune::update::{TwinFrfOptions, TwinOptions, name_modes, node_sensors, twin_frfs};
use retune_diagnosis::sensor_loads;
use retune_report::answer;
use std::path::PathBuf;
use std::sync::Arc;

/// Dofs from which on a solution is worth threads.
const LARGE: usize = 120;

/// A model.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Model(pub(crate) Arc<Source>);

type Triplets<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);
/// Frequencies, shapes, numbers of rigid-body modes and mechanisms.
type Solved<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, usize, usize);
type Parameters = Vec<(String, String, f64, f64, Option<[f64; 2]>, Option<f64>, String)>;
type Mass = (f64, [f64; 3], [[f64; 3]; 3]);

#[pymethods]
impl Model {
    #[staticmethod]
    #[pyo3(signature = (path, configuration=None, elements=Vec::new()))]
    fn from_file(
        py: Python<'_>,
        path: PathBuf,
        configuration: Option<String>,
        elements: Vec<Py<OwnElement>>,
    ) -> PyResult<Self> {
        let elements = Elements::new(elements);
        let load = || {
            let (text, sha256) = read(&path)?;
            Source::new(text, Home::file(path, sha256), configuration, elements)
        };
        Ok(Self(Arc::new(on_pool(py, load)?)))
    }

    #[staticmethod]
    #[pyo3(signature = (text, folder=None, configuration=None, elements=Vec::new()))]
    fn from_text(
        py: Python<'_>,
        text: String,
        folder: Option<PathBuf>,
        configuration: Option<String>,
        elements: Vec<Py<OwnElement>>,
    ) -> PyResult<Self> {
        let elements = Elements::new(elements);
        let home = Home { folder: folder.unwrap_or_default(), ..Home::default() };
        let load = || Source::new(text, home, configuration, elements);
        Ok(Self(Arc::new(on_pool(py, load)?)))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.model.spec().name
    }

    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    #[getter]
    fn path(&self) -> Option<String> {
        self.0.home.name()
    }

    #[getter]
    fn configuration(&self) -> Option<&str> {
        self.0.configuration.as_deref()
    }

    #[getter]
    fn configurations(&self) -> Vec<String> {
        self.0.model.spec().configurations.keys().cloned().collect()
    }

    /// The elements of the user's that its file may name, as they were given.
    fn elements(&self, py: Python<'_>) -> Vec<Py<PyAny>> {
        self.0.elements.python(py)
    }

    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        problem_list(py, &self.0.warnings)
    }

    fn configured(&self, py: Python<'_>, name: &str) -> PyResult<Self> {
        Ok(Self(Arc::new(on_pool(py, || self.0.configured(name))?)))
    }

    /// (name, unit, factor of the unit, value SI, bounds SI, prior sd SI, description)
    fn parameters(&self) -> Parameters {
        let one = |p: &model::Parameter| {
            (p.name.clone(), p.unit.clone(), p.unit_factor, p.value, p.bounds, p.prior_sd, p.description.clone())
        };
        self.0.model.parameters().iter().map(one).collect()
    }

    fn nominal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::vector(py, self.0.model.parameters().nominal())
    }

    /// The text with other values of bounded parameters, as a model.
    fn with_values(&self, py: Python<'_>, theta: PyReadonlyArray1<'_, f64>) -> PyResult<Self> {
        let theta = self.theta(Some(&theta))?;
        let edit = || {
            let parameters = self.0.model.parameters();
            let changed = parameters.iter().zip(&theta).filter(|(p, v)| p.value.to_bits() != v.to_bits());
            let values: Vec<(&str, f64)> = changed.map(|(p, v)| (p.name.as_str(), *v)).collect();
            self.0.edited(set_parameter_values(&self.0.text, &values)?)
        };
        Ok(Self(Arc::new(on_pool(py, edit)?)))
    }

    #[getter]
    fn n_dof(&self) -> usize {
        self.0.model.dof_map().n_dof()
    }

    fn dof_names(&self) -> Vec<String> {
        let dofs = self.0.model.dof_map();
        (0..dofs.n_dof()).map(|row| dofs.row_name(row)).collect()
    }

    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
        let geometry = self.0.model.geometry();
        let positions = retune::linalg::DMatrix::from_fn(geometry.names.len(), 3, |i, j| geometry.positions[i][j]);
        Ok((geometry.names.clone(), arrays::matrix(py, positions)?))
    }

    /// Frequencies, Hz; shapes, (n_dof x n_modes); numbers of rigid-body modes and of mechanisms.
    #[pyo3(signature = (theta, n))]
    fn modes<'py>(&self, py: Python<'py>, theta: Option<PyReadonlyArray1<'_, f64>>, n: usize) -> PyResult<Solved<'py>> {
        let theta = self.theta(theta.as_ref())?;
        let found = self.solve(py, &theta, n)?;
        let frequencies = arrays::vector(py, found.frequencies_hz());
        Ok((frequencies, arrays::matrix(py, found.shapes)?, found.n_rigid, found.n_mechanism))
    }

    /// What the solution alone takes, s, the mean of some calls: a test holds `modes` to it.
    fn seconds_of_modes(&self, py: Python<'_>, n: usize, calls: u32) -> PyResult<f64> {
        let theta = self.theta(None)?;
        let options = SolveOptions { n_elastic: n, shift: None };
        let work = || {
            let begun = std::time::Instant::now();
            for _ in 0..calls {
                std::hint::black_box(solve_modes(&*self.0.model, &theta, options)?);
            }
            Ok::<_, Wrong>(begun.elapsed().as_secs_f64() / f64::from(calls.max(1)))
        };
        Ok(py.detach(work)?)
    }

    /// `retune modes --json`.
    #[pyo3(signature = (theta, n))]
    fn mode_names(&self, py: Python<'_>, theta: Option<PyReadonlyArray1<'_, f64>>, n: usize) -> PyResult<String> {
        let theta = self.theta(theta.as_ref())?;
        let found = self.solve(py, &theta, n)?;
        let named = on_pool(py, || name_modes(&*self.0.model, &theta, &found)).map_err(Wrong::from)?;
        Ok(answer::modes(&named).to_string())
    }

    /// Displacements and rotations of the nodes, (n_nodes x 6), of a vector of the independent dofs; nodes in the order of `dof_nodes`.
    fn expand<'py>(&self, py: Python<'py>, q: PyReadonlyArray1<'_, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let dofs = self.0.model.dof_map();
        let q = arrays::point(&q, dofs.n_dof())?;
        arrays::matrix(py, dofs.expand(&q))
    }

    fn dof_nodes(&self) -> Vec<String> {
        self.0.model.dof_map().node_names().to_vec()
    }

    /// K, M and C as (values, rows, columns), both triangles.
    #[pyo3(signature = (theta=None))]
    fn matrices<'py>(
        &self,
        py: Python<'py>,
        theta: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<(Triplets<'py>, Triplets<'py>, Option<Triplets<'py>>)> {
        let theta = self.theta(theta.as_ref())?;
        let found = on_pool(py, || self.0.model.assemble_sparse(&theta)).map_err(Wrong::from)?;
        let one = |a: &SparseSym| triplets(py, a);
        Ok((one(&found.stiffness), one(&found.mass), found.damping.as_ref().map(one)))
    }

    #[pyo3(signature = (theta=None))]
    fn mass_properties(&self, theta: Option<PyReadonlyArray1<'_, f64>>) -> PyResult<Option<Mass>> {
        let theta = self.theta(theta.as_ref())?;
        let found = self.0.model.mass_properties(&theta).map_err(Wrong::from)?;
        Ok(found.map(|m| (m.mass, m.cg, m.inertia)))
    }

    /// Names of the sensors that stand on the nodes.
    fn node_sensors(&self) -> Vec<String> {
        node_sensors(&*self.0.model).into_iter().map(|s| s.name).collect()
    }

    /// Functions of the model, by superposition of its modes.
    #[pyo3(signature = (theta, lines, responses, references, damping, quantity, sensors=None))]
    #[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
    fn frf(
        &self,
        py: Python<'_>,
        theta: Option<PyReadonlyArray1<'_, f64>>,
        lines: PyReadonlyArray1<'_, f64>,
        responses: Option<Vec<String>>,
        references: Vec<String>,
        damping: f64,
        quantity: &str,
        sensors: Option<PyRef<'_, Test>>,
    ) -> PyResult<Frfs> {
        let theta = self.theta(theta.as_ref())?;
        let lines_hz = arrays::values(&lines);
        let quantity = quantity_of(quantity)?;
        let all = sensors.map_or_else(|| node_sensors(&*self.0.model), |t| t.0.data.sensors.clone());
        let names = responses.unwrap_or_else(|| all.iter().map(|s| s.name.clone()).collect());
        let mut chosen: Vec<Sensor> = sensors_of(&all, &names)?;
        let n = chosen.len();
        for force in sensors_of(&all, &references)? {
            if !names.contains(&force.name) {
                chosen.push(force);
            }
        }
        let work = || {
            let options = TwinOptions { damping: Some(damping), ..TwinOptions::default() };
            let frf = TwinFrfOptions {
                lines_hz,
                exciters: references,
                quantity,
                force_noise: 0.0,
                response_noise: 0.0,
                n_averages: 1,
            };
            twin_frfs(&*self.0.model, &theta, &chosen, &options, &frf)
        };
        let mut set = on_pool(py, work).map_err(Wrong::from)?;
        let width = set.responses.len();
        set.h = set.h.chunks_exact(width.max(1)).flat_map(|row| row[..n].iter().copied()).collect();
        set.responses.truncate(n);
        Ok(Frfs::new(set, true))
    }

    /// The model with an effect at its neutral value, and the id of what was added.
    #[pyo3(signature = (effect, because="", test=None, own=None))]
    fn add(
        &self,
        py: Python<'_>,
        effect: &str,
        because: &str,
        test: Option<PyRef<'_, Test>>,
        own: Option<PyRef<'_, OwnEffect>>,
    ) -> PyResult<Self> {
        let own = own.map(|own| own.0);
        let sensors = test.map(|t| t.0.data.sensors.clone());
        let edit = || -> Result<Source, Wrong> {
            let model = &*self.0.model;
            let mut context = Context::default();
            if let Some(sensors) = &sensors {
                context.sensors = sensor_loads(model, sensors)?;
            }
            let structure = Structure::new(model, &context);
            let effects = own.iter().fold(Effects::builtin(), |all, own| all.with(*own));
            let candidate = effects.candidate(&structure, effect)?;
            self.0.edited(candidate.patch.add_to_text(&self.0.text, &candidate.id(), because)?)
        };
        let edited: PyResult<Source> = on_pool(py, edit).map_err(PyErr::from);
        Ok(Self(Arc::new(settled(edited, own.iter().map(|own| &own.failure))?)))
    }

    /// What an effect of the user's breaks of the contract of effects on this model, a sentence each.
    fn check_effect(&self, py: Python<'_>, own: PyRef<'_, OwnEffect>) -> PyResult<Vec<String>> {
        let own = own.0;
        let effects = Effects::none().with(own);
        let work = || {
            let (structure, context) = (&self.0.model, Context::default());
            conformance::check_on(&effects, structure, &self.0.text, structure.registry(), &context)
        };
        settled(Ok(on_pool(py, work)), [&own.failure])
    }

    /// The model without what was added last.
    fn undo(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self(Arc::new(on_pool(py, || self.0.edited(undo(&self.0.text)?.text))?)))
    }
}

impl Model {
    fn theta(&self, given: Option<&PyReadonlyArray1<'_, f64>>) -> Result<Vec<f64>, Wrong> {
        let n = self.0.model.parameters().len();
        match given.map(arrays::values) {
            None => Ok(self.0.model.parameters().nominal()),
            Some(theta) if theta.len() == n => Ok(theta),
            Some(theta) => Err(Wrong::text(format!("theta has {} entries; the model has {n} parameters", theta.len()))),
        }
    }

    fn solve(&self, py: Python<'_>, theta: &[f64], n: usize) -> Result<Modes, Wrong> {
        let options = SolveOptions { n_elastic: n, shift: None };
        let model = &*self.0.model;
        // A small model is solved before threads have heard of it.
        let found = if model.dof_map().n_dof() < LARGE {
            py.detach(|| solve_modes(model, theta, options))
        } else {
            on_pool(py, || solve_modes(model, theta, options))
        };
        Ok(found?)
    }
}

fn triplets<'py>(py: Python<'py>, a: &SparseSym) -> Triplets<'py> {
    let (mut values, mut rows, mut columns) = (Vec::new(), Vec::new(), Vec::new());
    for (i, j, v) in a.entries() {
        let ends = if i == j { &[(i, j)][..] } else { &[(i, j), (j, i)] };
        for &(i, j) in ends {
            values.push(v);
            rows.push(i as i64);
            columns.push(j as i64);
        }
    }
    (arrays::vector(py, values), arrays::vector(py, rows), arrays::vector(py, columns))
}
