//! A sensor that is upside down: t -> -t.

use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::{Correction, TestData};
use crate::identify::health::codes;
use crate::linalg::Complex;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorSign;

impl Fault for SensorSign {
    fn name(&self) -> &'static str {
        codes::SENSOR_SIGN
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A sensor is upside down, or its polarity is wrong.",
            signature: "Its reading has the wrong sign in every mode.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.channels().map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("turn the sign of sensor {} (it is upside down)", tests.sensor(at.sensor()))
    }

    fn shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>], _: Option<&mut [f64]>) {
        let s = at.sensor();
        shape[s] = -shape[s];
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        vec![Correction::factor(&test.sensors[at.sensor()].name, -1.0)]
    }
}
