//! A fault of the measurement that is a Python object.

use super::{Failure, forever};
use crate::arrays;
use crate::error::Wrong;
use numpy::{Complex64, PyArray1, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use retune::data::{Correction, TestData, TestMode};
use retune::fault::{AboutFault, At, Bench, Fault, Number, Tests};
use retune::linalg::Complex;

/// Its places and its inverse are functions of Python, which take the GIL for each call.
#[derive(Debug)]
pub(crate) struct PythonFault {
    name: &'static str,
    about: AboutFault,
    number: Number,
    ln_odds: f64,
    /// (bench) -> sensors, as numbers, or modes of each place.
    places: Py<PyAny>,
    /// (place in words) -> what to do.
    remedy: Py<PyAny>,
    /// (sensors, modes, number, shape, sd or `None`), in place.
    shape: Py<PyAny>,
    /// The inverse, in place; `None` where the number has one.
    put: Option<Py<PyAny>>,
    /// (sensors, modes, number, frequencies), in place.
    frequencies: Option<Py<PyAny>>,
    /// (sensors, modes, number) -> (sensor, factor) of what its functions are multiplied by.
    functions: Option<Py<PyAny>>,
    pub(crate) failure: Failure,
}

/// A fault of the user's.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct OwnFault(pub(crate) &'static PythonFault);

#[pymethods]
impl OwnFault {
    /// * `texts` - name, summary, signature
    /// * `number` - its kind, and the standard deviation of what is thought of it beforehand
    /// * `calls` - places, remedy, shape, and where they are there: the inverse, frequencies, functions
    #[new]
    #[pyo3(signature = (texts, number, ln_odds, calls))]
    #[expect(clippy::type_complexity, reason = "the package gives them in order")]
    fn new(
        texts: [String; 3],
        number: Option<(String, f64)>,
        ln_odds: f64,
        calls: (Py<PyAny>, Py<PyAny>, Py<PyAny>, Option<Py<PyAny>>, Option<Py<PyAny>>, Option<Py<PyAny>>),
    ) -> PyResult<Self> {
        let number = match number {
            None => Number::None,
            Some((kind, sd)) => {
                if !(sd.is_finite() && sd > 0.0) {
                    let text = format!("fault `{}`: the standard deviation of its number is {sd}", texts[0]);
                    return Err(Wrong::text(text).into());
                }
                match kind.as_str() {
                    "factor" => Number::Factor { sd },
                    "angle" => Number::Angle { sd },
                    "frequency" => Number::Frequency { sd },
                    other => {
                        let text = format!(
                            "fault `{}`: its number is a `{other}`; it is a factor, an angle or a frequency",
                            texts[0]
                        );
                        return Err(Wrong::text(text).into());
                    }
                }
            }
        };
        let failure = Failure::new(&texts[0]);
        let [name, summary, signature] = texts.map(forever);
        let (places, remedy, shape, put, frequencies, functions) = calls;
        let about = AboutFault { summary, signature };
        let fault =
            PythonFault { name, about, number, ln_odds, places, remedy, shape, put, frequencies, functions, failure };
        Ok(Self(Box::leak(Box::new(fault))))
    }
}

/// A place as Python says it.
#[derive(FromPyObject)]
enum Said {
    /// A sensor by its number.
    Sensor(usize),
    /// (kind, first number, second number)
    Several(String, usize, Option<usize>),
}

/// What Python sees of the tests.
fn seen<'py>(py: Python<'py>, bench: &Bench<'_>) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let sensor = |s: &retune::data::Sensor| (s.name.clone(), s.direction, s.is_rotation);
    out.set_item("sensors", bench.sensors().iter().map(sensor).collect::<Vec<_>>())?;
    out.set_item("positions", bench.positions.clone())?;
    out.set_item("n_channels", bench.channels().len())?;
    let mode = |m: &TestMode| (m.frequency_hz.value, m.shape.is_some());
    out.set_item("modes", bench.tests.all().modes.iter().map(mode).collect::<Vec<_>>())?;
    Ok(out)
}

impl PythonFault {
    fn change(&self, call: &Py<PyAny>, at: &At, number: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        Python::attach(|py| {
            let ask = || -> PyResult<()> {
                let array: Bound<'_, PyArray1<Complex64>> = arrays::vector(py, shape.to_vec());
                let deviations = sd.as_ref().map(|sd| arrays::vector(py, sd.to_vec()));
                call.call1(py, (at.sensors(), at.modes(), number, &array, deviations.as_ref()))?;
                shape.copy_from_slice(&array.to_vec().map_err(Wrong::from)?);
                if let (Some(sd), Some(array)) = (sd, deviations) {
                    sd.copy_from_slice(&array.to_vec().map_err(Wrong::from)?);
                }
                Ok(())
            };
            self.failure.caught(py, ask());
        });
    }
}

impl Fault for PythonFault {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> AboutFault {
        self.about
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let (n_sensors, n_modes) = (bench.sensors().len(), bench.tests.all().modes.len());
        let found = Python::attach(|py| {
            let ask = || {
                let said: Vec<Said> = self.places.call1(py, (seen(py, bench)?,))?.extract(py)?;
                let within = |k: usize, n: usize, what: &str| {
                    if k < n {
                        Ok(k)
                    } else {
                        Err(Wrong::text(format!("there is no {what} {k}; there are {n}, from 0")))
                    }
                };
                let one = |said: Said| {
                    Ok(match said {
                        Said::Sensor(s) => At::Sensor(within(s, n_sensors, "sensor")?),
                        Said::Several(kind, a, b) => match (kind.as_str(), b) {
                            ("sensors", Some(b)) => {
                                At::Sensors(within(a, n_sensors, "sensor")?, within(b, n_sensors, "sensor")?)
                            }
                            ("mode", None) => At::Mode(within(a, n_modes, "mode")?),
                            ("modes", Some(b)) => At::Modes(within(a, n_modes, "mode")?, within(b, n_modes, "mode")?),
                            _ => {
                                return Err(Wrong::text("a place is a sensor, two sensors, a mode or two modes").into());
                            }
                        },
                    })
                };
                said.into_iter().map(one).collect::<PyResult<Vec<_>>>()
            };
            self.failure.caught(py, ask())
        });
        found.unwrap_or_default()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let words = at.words(tests);
        Python::attach(|py| {
            let ask = || self.remedy.call1(py, (words,))?.extract::<String>(py);
            self.failure.caught(py, ask()).unwrap_or_default()
        })
    }

    fn number(&self) -> Number {
        self.number
    }

    fn ln_odds(&self) -> f64 {
        self.ln_odds
    }

    fn shape(&self, at: &At, number: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        self.change(&self.shape, at, number, shape, sd);
    }

    fn put_into_shape(&self, at: &At, number: f64, shape: &mut [Complex<f64>]) {
        match &self.put {
            Some(put) => self.change(put, at, number, shape, None),
            None => self.shape(at, self.number.inverse(number), shape, None),
        }
    }

    fn modes(&self, at: &At, number: f64, modes: &mut [TestMode]) {
        let Some(call) = &self.frequencies else { return };
        Python::attach(|py| {
            let mut ask = || -> PyResult<()> {
                let array = arrays::vector(py, modes.iter().map(|m| m.frequency_hz.value).collect());
                call.call1(py, (at.sensors(), at.modes(), number, &array))?;
                let values: Vec<f64> = array.to_vec().map_err(Wrong::from)?;
                if values.len() != modes.len() || values.iter().any(|f| !(f.is_finite() && *f > 0.0)) {
                    return Err(Wrong::text("frequencies must stay as many, and above zero").into());
                }
                modes.iter_mut().zip(values).for_each(|(mode, f)| mode.frequency_hz.value = f);
                Ok(())
            };
            self.failure.caught(py, ask());
        });
    }

    fn functions(&self, at: &At, number: f64, test: &TestData) -> Vec<Correction> {
        let Some(call) = &self.functions else { return Vec::new() };
        let factors = Python::attach(|py| {
            let ask = || call.call1(py, (at.sensors(), at.modes(), number))?.extract::<Vec<(usize, f64)>>(py);
            self.failure.caught(py, ask())
        });
        let one = |(sensor, factor): (usize, f64)| Some(Correction::factor(&test.sensors.get(sensor)?.name, factor));
        factors.unwrap_or_default().into_iter().filter_map(one).collect()
    }
}
