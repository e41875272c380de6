//! An element that is a Python object.

use super::forever;
use crate::error::Wrong;
use numpy::{PyReadonlyArray2, ndarray::Array2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use retune::element::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, conformance};
use retune::linalg::SymMatrix;
use retune::model::Registry;
use std::sync::Arc;

/// Matrices come from a function of Python, which takes the GIL for each call.
#[derive(Debug)]
struct PythonElement {
    name: &'static str,
    summary: &'static str,
    theory: &'static str,
    nodes: &'static [&'static [Dof]],
    properties: &'static [Property],
    axes: Axes,
    is_scalar: bool,
    samples: Vec<Sample>,
    /// (which matrix, points, values by name) -> a matrix, or `None` for zero.
    matrix: Py<PyAny>,
}

/// An element of the user's.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct OwnElement {
    element: &'static PythonElement,
    /// The Python object itself.
    python: Py<PyAny>,
}

/// name, unit, domain, description
type PropertyRow = (String, String, String, String);
/// points, values by name, mass, whether a rigid motion costs nothing
type SampleRow = (Vec<[f64; 3]>, Vec<(String, f64)>, f64, bool);

#[pymethods]
impl OwnElement {
    #[new]
    #[pyo3(signature = (python, texts, nodes, properties, axes, is_scalar, samples, matrix))]
    #[expect(clippy::too_many_arguments, reason = "the package gives them in order")]
    fn new(
        python: Py<PyAny>,
        texts: [String; 3],
        nodes: Vec<Vec<String>>,
        properties: Vec<PropertyRow>,
        axes: &str,
        is_scalar: bool,
        samples: Vec<SampleRow>,
        matrix: Py<PyAny>,
    ) -> PyResult<Self> {
        let [name, summary, theory] = texts;
        let wrong = |text: String| Wrong::text(format!("element `{name}`: {text}"));
        let dof = |word: &String| {
            Dof::from_name(word)
                .ok_or_else(|| wrong(format!("`{word}` is not a dof; there are ux, uy, uz, rx, ry, rz")))
        };
        let mut all: Vec<&'static [Dof]> = Vec::with_capacity(nodes.len());
        for dofs in &nodes {
            let dofs = dofs.iter().map(dof).collect::<Result<Vec<_>, _>>()?;
            all.push(Box::leak(dofs.into_boxed_slice()));
        }
        if all.is_empty() {
            return Err(wrong("it has no nodes".to_string()).into());
        }
        let domain = |word: &str| {
            Ok(match word {
                "positive" => Domain::Positive,
                "non-negative" => Domain::NonNegative,
                "fraction" => Domain::Fraction,
                "compliance" => Domain::Compliance,
                "any" => Domain::Any,
                other => {
                    let text =
                        format!("domain is `{other}`; it is positive, non-negative, fraction, compliance or any");
                    return Err(wrong(text));
                }
            })
        };
        let mut declared = Vec::with_capacity(properties.len());
        for (name, unit, word, description) in &properties {
            let text = |t: &String| forever(t.clone());
            declared.push(Property::new(text(name), text(unit), domain(word)?, text(description)));
        }
        let mut given = Vec::with_capacity(samples.len());
        for (points, values, mass, free) in samples {
            let known = |(name, value): (String, f64)| {
                let found = declared.iter().find(|p| p.name == name);
                found
                    .map(|p| (p.name, value))
                    .ok_or_else(|| wrong(format!("a sample gives `{name}`, which is not a property")))
            };
            let values = values.into_iter().map(known).collect::<Result<Vec<_>, _>>()?;
            given.push(Sample { points, given: values, mass, free });
        }
        let axes = match axes {
            "along-nodes" => Axes::AlongNodes,
            "given" => Axes::Given,
            other => return Err(wrong(format!("axes is `{other}`; it is along-nodes or given")).into()),
        };
        let [name, summary, theory]: [&'static str; 3] = [name, summary, theory].map(forever);
        let element = PythonElement {
            name,
            summary,
            theory,
            nodes: Box::leak(all.into_boxed_slice()),
            properties: Box::leak(declared.into_boxed_slice()),
            axes,
            is_scalar,
            samples: given,
            matrix,
        };
        Ok(Self { element: Box::leak(Box::new(element)), python })
    }

    /// Rules of the conformance suite that it breaks, a sentence each.
    fn check(&self, py: Python<'_>) -> Vec<String> {
        let found = py.detach(|| conformance::check(self.element));
        found.err().unwrap_or_default().iter().map(ToString::to_string).collect()
    }
}

/// The elements of the user's that a model may name.
#[derive(Debug, Clone, Default)]
pub(crate) struct Elements(Arc<Vec<Py<OwnElement>>>);

impl Elements {
    pub(crate) fn new(elements: Vec<Py<OwnElement>>) -> Self {
        Self(Arc::new(elements))
    }

    /// The built-in types, and these.
    pub(crate) fn registry(&self) -> Registry {
        self.0.iter().fold(Registry::builtin(), |all, own| all.with(own.get().element))
    }

    /// The Python objects.
    pub(crate) fn python(&self, py: Python<'_>) -> Vec<Py<PyAny>> {
        self.0.iter().map(|own| own.get().python.clone_ref(py)).collect()
    }
}

impl PythonElement {
    fn matrix(&self, which: &str, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        let n = 6 * self.nodes.len();
        let wrong = |text: String| ElementError::External(format!("{which} of `{}`: {text}", self.name));
        Python::attach(|py| {
            let ask = || {
                let values = PyDict::new(py);
                for (property, value) in self.properties.iter().zip(input.values) {
                    if let Some(value) = value {
                        values.set_item(property.name, *value)?;
                    }
                }
                let points = Array2::from_shape_fn((input.points.len(), 3), |(i, j)| input.points[i][j]);
                let points = numpy::IntoPyArray::into_pyarray(points, py);
                let found = self.matrix.call1(py, (which, points, values))?;
                found.bind(py).extract::<Option<PyReadonlyArray2<'_, f64>>>()
            };
            let found = ask().map_err(|e| wrong(e.to_string()))?;
            let Some(found) = found else { return Ok(SymMatrix::zeros(n)) };
            let a = found.as_array();
            if a.dim() != (n, n) {
                return Err(wrong(format!("it is {} x {}, and {} nodes make {n} x {n}", a.nrows(), a.ncols(), n / 6)));
            }
            let size = a.iter().fold(0.0f64, |most, v| most.max(v.abs()));
            let mut out = SymMatrix::zeros(n);
            for i in 0..n {
                for j in 0..=i {
                    if !(a[[i, j]].is_finite() && a[[j, i]].is_finite()) {
                        return Err(wrong(format!("entry ({i}, {j}) is not finite")));
                    }
                    if (a[[i, j]] - a[[j, i]]).abs() > 1e-9 * size {
                        return Err(wrong(format!("it is not symmetric in entry ({i}, {j})")));
                    }
                    out.add(i, j, 0.5 * (a[[i, j]] + a[[j, i]]));
                }
            }
            Ok(out)
        })
    }
}

impl Element for PythonElement {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn theory(&self) -> &'static str {
        self.theory
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        self.nodes
    }

    fn properties(&self) -> &'static [Property] {
        self.properties
    }

    fn axes(&self) -> Axes {
        self.axes
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        self.matrix("stiffness", input)
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        self.matrix("mass", input)
    }

    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        self.matrix("damping", input)
    }

    fn is_scalar(&self) -> bool {
        self.is_scalar
    }

    fn samples(&self) -> Vec<Sample> {
        self.samples.clone()
    }
}
