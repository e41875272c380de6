//! A test: sensors, modes, functions.

use crate::arrays;
use crate::error::{Wrong, problem_list};
use crate::source::{Home, read};
use numpy::ndarray::Array3;
use numpy::{Complex64, IntoPyArray as _, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyList;
use retune::catalogue::{Choice as _, did_you_mean};
use retune::data::{
    Channel, FrfQuantity, FrfSet, Geometry, Place, Point, Sensor, TestData, corrected_functions, read_measurements,
    read_test, write_test,
};
use retune::linalg::Complex;
use retune::yaml::{Problem, SourceMap};
use std::path::PathBuf;
use std::sync::Arc;

/// A test and where it came from.
#[derive(Debug)]
pub(crate) struct TestSource {
    pub(crate) data: TestData,
    /// The text of its file; written anew where there is none.
    pub(crate) text: String,
    pub(crate) home: Home,
    pub(crate) warnings: Vec<Problem>,
}

impl TestSource {
    pub(crate) fn new(text: String, home: Home) -> Result<Self, Wrong> {
        let file = home.name();
        let (mut data, warnings) = read_test(&text).map_err(|problems| Wrong::problems(file.as_deref(), problems))?;
        if let Some(fit) = &data.frf_fit {
            let files: Vec<PathBuf> = fit.files.iter().map(|f| home.folder.join(f)).collect();
            let refused = |why: &dyn std::fmt::Display| {
                let place = Problem::error("frfs.files", why);
                Wrong::problems(file.as_deref(), SourceMap::of(&text).place(vec![place]))
            };
            let mut found = read_measurements(&files, None, &fit.reading).map_err(|e| refused(&e))?;
            retune::identify::forward_in_time(&mut found);
            data.frfs = found.frfs.map(|set| corrected_functions(set, &data.sensors, &data.corrections));
            if data.frfs.is_none() {
                return Err(refused(&"these files hold no frequency response functions"));
            }
        }
        Ok(Self { data, text, home, warnings })
    }

    /// Of a test that was made here. Its text is read again, so that it is what a file would be.
    pub(crate) fn written(data: &TestData) -> Result<Self, Wrong> {
        Self::new(write_test(data), Home::default())
    }
}

/// A test.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Test(pub(crate) Arc<TestSource>);

/// name, node or element, fraction, position, direction, whether it turns
type SensorRow = (String, String, Option<f64>, Option<[f64; 3]>, [f64; 3], bool);
/// Frequency and its sd, damping and its sd, label, whether synthetic, source
type ModeRow = (f64, f64, Option<f64>, Option<f64>, Option<String>, bool, String);

#[pymethods]
impl Test {
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let load = || {
            let (text, sha256) = read(&path)?;
            TestSource::new(text, Home::file(path, sha256))
        };
        Ok(Self(Arc::new(py.detach(load)?)))
    }

    #[staticmethod]
    #[pyo3(signature = (text, folder=None))]
    fn from_text(py: Python<'_>, text: String, folder: Option<PathBuf>) -> PyResult<Self> {
        let home = Home { folder: folder.unwrap_or_default(), ..Home::default() };
        Ok(Self(Arc::new(py.detach(|| TestSource::new(text, home))?)))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.data.name
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
    fn date(&self) -> Option<String> {
        self.0.data.date.map(|d| d.to_string())
    }

    #[getter]
    fn configuration(&self) -> Option<&str> {
        self.0.data.configuration.as_deref()
    }

    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        problem_list(py, &self.0.warnings)
    }

    fn sensors(&self) -> Vec<SensorRow> {
        let one = |s: &retune::data::Sensor| {
            let (at, fraction, position) = match &s.place {
                Place::Node { node, position } => (node.clone(), None, *position),
                Place::Element { element, fraction, position } => (element.clone(), Some(*fraction), *position),
            };
            (s.name.clone(), at, fraction, position, s.direction, s.is_rotation)
        };
        self.0.data.sensors.iter().map(one).collect()
    }

    fn modes(&self) -> Vec<ModeRow> {
        let one = |m: &retune::data::TestMode| {
            let (is_synthetic, source) = match &m.origin {
                retune::data::Origin::Synthetic(text) => (true, text.clone()),
                retune::data::Origin::Measured(text) => (false, text.clone()),
            };
            let damping = m.damping_ratio;
            (
                m.frequency_hz.value,
                m.frequency_hz.sd,
                damping.map(|z| z.value),
                damping.map(|z| z.sd),
                m.label.clone(),
                is_synthetic,
                source,
            )
        };
        self.0.data.modes.iter().map(one).collect()
    }

    /// (n_sensors x n_modes); NaN where an entry, or a shape, was not measured.
    fn shapes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<Complex64>> {
        let (n, modes) = (self.0.data.sensors.len(), &self.0.data.modes);
        let entry = |i: usize, j: usize| modes[j].shape.as_ref().map_or(Complex::new(f64::NAN, f64::NAN), |s| s[i]);
        numpy::ndarray::Array2::from_shape_fn((n, modes.len()), |(i, j)| entry(i, j)).into_pyarray(py)
    }

    /// (n_sensors x n_modes); NaN where there is no shape.
    fn shape_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let (n, modes) = (self.0.data.sensors.len(), &self.0.data.modes);
        let entry = |i: usize, j: usize| modes[j].shape_sd.as_ref().map_or(f64::NAN, |s| s[i]);
        numpy::ndarray::Array2::from_shape_fn((n, modes.len()), |(i, j)| entry(i, j)).into_pyarray(py)
    }

    fn frfs(&self) -> Option<Frfs> {
        self.0.data.frfs.clone().map(|set| Frfs::new(set, false))
    }
}

/// Frequency response functions.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct Frfs {
    pub(crate) set: Arc<FrfSet>,
    pub(crate) geometry: Option<Geometry>,
    pub(crate) is_synthetic: bool,
}

impl Frfs {
    pub(crate) fn new(set: FrfSet, is_synthetic: bool) -> Self {
        Self { set: Arc::new(set), geometry: None, is_synthetic }
    }
}

type Ends = Vec<(String, Option<[f64; 3]>)>;

#[pymethods]
impl Frfs {
    /// * `h` - (lines, responses, references)
    #[new]
    #[pyo3(signature = (lines, h, responses, references, quantity, coherence, averages, positions, is_synthetic))]
    #[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
    fn py_new(
        lines: PyReadonlyArray1<'_, f64>,
        h: PyReadonlyArray3<'_, Complex64>,
        responses: Ends,
        references: Ends,
        quantity: &str,
        coherence: Option<PyReadonlyArray3<'_, f64>>,
        averages: Option<usize>,
        positions: Vec<(String, [f64; 3])>,
        is_synthetic: bool,
    ) -> PyResult<Self> {
        let lines = arrays::values(&lines);
        let shape = (lines.len(), responses.len(), references.len());
        let fits = |what: &str, dim: (usize, usize, usize)| {
            if dim == shape {
                return Ok(());
            }
            let text = format!(
                "{what} is {} x {} x {}; {} lines, {} responses and {} references make {} x {} x {}",
                dim.0, dim.1, dim.2, shape.0, shape.1, shape.2, shape.0, shape.1, shape.2
            );
            Err(Wrong::text(text))
        };
        fits("h", h.as_array().dim())?;
        if let Some(c) = &coherence {
            fits("coherence", c.as_array().dim())?;
        }
        let channel = |(name, direction): (String, Option<[f64; 3]>)| Channel { name, direction };
        // One copy, in the order of the library: lines, references, responses.
        let set = FrfSet {
            quantity: quantity_of(quantity)?,
            frequencies_hz: lines,
            references: references.into_iter().map(channel).collect(),
            responses: responses.into_iter().map(channel).collect(),
            h: h.as_array().permuted_axes([0, 2, 1]).iter().copied().collect(),
            coherence: coherence.map(|c| c.as_array().permuted_axes([0, 2, 1]).iter().copied().collect()),
            n_averages: averages,
        };
        let point = |(name, position_m): (String, [f64; 3])| Point { name, position_m, axes: Point::GLOBAL };
        let points: Vec<Point> = positions.into_iter().map(point).collect();
        let geometry = (!points.is_empty()).then(|| Geometry { points, ..Geometry::default() });
        Ok(Self { set: Arc::new(set), geometry, is_synthetic })
    }

    #[getter]
    fn quantity(&self) -> &'static str {
        match self.set.quantity {
            FrfQuantity::Receptance => "receptance",
            FrfQuantity::Mobility => "mobility",
            FrfQuantity::Accelerance => "accelerance",
        }
    }

    #[getter]
    fn is_synthetic(&self) -> bool {
        self.is_synthetic
    }

    fn frequencies<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::vector(py, self.set.frequencies_hz.clone())
    }

    fn responses(&self) -> Ends {
        self.set.responses.iter().map(|c| (c.name.clone(), c.direction)).collect()
    }

    fn references(&self) -> Ends {
        self.set.references.iter().map(|c| (c.name.clone(), c.direction)).collect()
    }

    /// (lines, responses, references)
    fn h<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<Complex64>>> {
        cube(py, &self.set, &self.set.h)
    }

    fn coherence<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f64>>>> {
        self.set.coherence.as_ref().map(|c| cube(py, &self.set, c)).transpose()
    }
}

/// Values in the order of the library as (lines, responses, references), copied once.
fn cube<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    set: &FrfSet,
    values: &[T],
) -> PyResult<Bound<'py, PyArray3<T>>> {
    let shape = (set.n_lines(), set.references.len(), set.responses.len());
    let array = Array3::from_shape_vec(shape, values.to_vec()).map_err(Wrong::from)?;
    Ok(array.permuted_axes([0, 2, 1]).into_pyarray(py))
}

/// Sensors by their names.
pub(crate) fn sensors_of(all: &[Sensor], names: &[String]) -> Result<Vec<Sensor>, Wrong> {
    let one = |name: &String| {
        all.iter().find(|s| s.name == *name).cloned().ok_or_else(|| {
            let suggestion = did_you_mean(name, all.iter().map(|s| s.name.as_str()));
            Wrong::text(format!("there is no sensor `{name}`{suggestion}"))
        })
    };
    names.iter().map(one).collect()
}

/// A quantity by its word.
pub(crate) fn quantity_of(word: &str) -> Result<FrfQuantity, Wrong> {
    FrfQuantity::parse(word).map_err(|e| Wrong::text(format!("quantity: {e}")))
}
