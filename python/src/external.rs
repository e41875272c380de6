//! A model that is a Python object: matrices from any solver, everything else by the library.

use crate::arrays;
use crate::error::Wrong;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use retune::element::Dof;
use retune::linalg::DMatrix;
use retune::model::{DofMap, ModelError, Parameter, ParameterSet, ParametricModel, System, assemble_difference};
use std::sync::Arc;

/// Matrices come from a function of Python, which takes the GIL for each call.
#[derive(Debug)]
pub(crate) struct ExternalModel {
    pub(crate) name: String,
    parameters: ParameterSet,
    dofs: DofMap,
    assemble: Py<PyAny>,
    derivative: Option<Py<PyAny>>,
}

/// A model around a solver of the user's.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct External(pub(crate) Arc<ExternalModel>);

/// name, value, bounds, sd of a prior, all SI; unit and its factor
type ParameterRow = (String, f64, Option<[f64; 2]>, Option<f64>, String, f64);

#[pymethods]
impl External {
    /// * `rows` - node and dof (`ux` ... `rz`) of each row of the matrices
    #[new]
    #[pyo3(signature = (name, parameters, nodes, rows, assemble, derivative))]
    fn new(
        name: String,
        parameters: Vec<ParameterRow>,
        nodes: Vec<(String, [f64; 3])>,
        rows: Vec<(String, String)>,
        assemble: Py<PyAny>,
        derivative: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let one = |(name, value, bounds, prior_sd, unit, unit_factor): ParameterRow| {
            let is_ordered = bounds.is_none_or(|[low, high]| low < high && low.is_finite() && high.is_finite());
            if !(is_ordered && value.is_finite()) {
                let text =
                    format!("parameter `{name}`: a finite value, and ascending bounds, not {value} in {bounds:?}");
                return Err(Wrong::text(text));
            }
            Ok(Parameter { name, unit, unit_factor, value, bounds, prior_sd, description: String::new() })
        };
        let parameters = parameters.into_iter().map(one).collect::<Result<Vec<_>, _>>()?;
        let place = |(node, dof): &(String, String)| {
            let wrong = |what: &str| Wrong::text(format!("row `{node}.{dof}`: there is no {what}"));
            let index = nodes.iter().position(|n| n.0 == *node).ok_or_else(|| wrong("such node"))?;
            let dof = Dof::ALL.iter().copied().find(|d| d.to_string() == *dof).ok_or_else(|| wrong("such dof"))?;
            Ok::<_, Wrong>((index, dof))
        };
        let mut places = rows.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let ordered = places.clone();
        places.sort_unstable();
        if let Some(twice) = places.windows(2).find(|w| w[0] == w[1]) {
            let (node, dof) = (&nodes[twice[0].0].0, twice[0].1);
            return Err(Wrong::text(format!("row `{node}.{dof}` is given twice")).into());
        }
        if places.is_empty() {
            return Err(Wrong::text("the model has no rows").into());
        }
        let dofs = DofMap::from_rows(nodes, ordered);
        let parameters = ParameterSet::new(parameters);
        Ok(Self(Arc::new(ExternalModel { name, parameters, dofs, assemble, derivative })))
    }
}

impl ExternalModel {
    fn system(&self, function: &Py<PyAny>, theta: &[f64], j: Option<usize>) -> Result<System, ModelError> {
        let wrong = |text: String| ModelError::External(format!("{}: {text}", self.name));
        if theta.len() != self.parameters.len() {
            return Err(ModelError::WrongLength { expected: self.parameters.len(), given: theta.len() });
        }
        Python::attach(|py| {
            let theta = arrays::vector(py, theta.to_vec());
            let called = match j {
                None => function.call1(py, (theta,)),
                Some(j) => function.call1(py, (theta, j)),
            };
            let found = called.map_err(|e| wrong(e.to_string()))?;
            type Given<'py> =
                (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, f64>>);
            let (k, m, c): Given<'_> = found.bind(py).extract().map_err(|e: PyErr| wrong(e.to_string()))?;
            let n = self.dofs.n_dof();
            let matrix = |what: &str, a: &PyReadonlyArray2<'_, f64>| {
                let a = a.as_array();
                if a.dim() != (n, n) {
                    return Err(wrong(format!("{what} is {} x {}, and there are {n} rows", a.nrows(), a.ncols())));
                }
                let out = DMatrix::from_fn(n, n, |i, j| a[[i, j]]);
                // The largest of some numbers says nothing of NaN among them.
                if !out.iter().all(|v| v.is_finite()) {
                    return Err(wrong(format!("{what} has entries that are not finite")));
                }
                let size = out.amax();
                let skew = (&out - out.transpose()).amax();
                if skew > 1e-9 * size {
                    return Err(wrong(format!("{what} is not symmetric: entries differ by {skew:e} of {size:e}")));
                }
                Ok(out)
            };
            Ok(System {
                stiffness: matrix("K", &k)?,
                mass: matrix("M", &m)?,
                damping: c.as_ref().map(|c| matrix("C", c)).transpose()?,
            })
        })
    }
}

impl ParametricModel for ExternalModel {
    fn parameters(&self) -> &ParameterSet {
        &self.parameters
    }

    fn dof_map(&self) -> &DofMap {
        &self.dofs
    }

    fn assemble(&self, theta: &[f64]) -> Result<System, ModelError> {
        self.system(&self.assemble, theta, None)
    }

    fn assemble_derivative(&self, theta: &[f64], j: usize) -> Result<System, ModelError> {
        if let Some(derivative) = &self.derivative {
            return self.system(derivative, theta, Some(j));
        }
        assemble_difference(&self.parameters, theta, j, |theta| self.assemble(theta))
    }
}
