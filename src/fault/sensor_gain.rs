//! A sensor of wrong sensitivity: t -> t/g, σ -> σ/g, its functions too.

use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::{Correction, TestData};
use crate::identify::health::codes;
use crate::linalg::Complex;

/// Standard deviation of ln of a gain: a factor of 1.35 either way is a usual slip of a calibration.
pub(super) const GAIN_SD: f64 = 0.3;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorGain;

impl Fault for SensorGain {
    fn name(&self) -> &'static str {
        codes::SENSOR_GAIN
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The sensitivity of a sensor is wrong.",
            signature: "Its reading is off by one factor in every mode; ln of the factor ~ N(0, 0.3²), and it may be negative.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.channels().map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("correct the sensitivity of sensor {}", tests.sensor(at.sensor()))
    }

    fn number(&self) -> Number {
        Number::Factor { sd: GAIN_SD }
    }

    fn shape(&self, at: &At, number: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        let s = at.sensor();
        shape[s] /= number;
        if let Some(sd) = sd {
            sd[s] /= number.abs();
        }
    }

    fn functions(&self, at: &At, number: f64, test: &TestData) -> Vec<Correction> {
        vec![Correction::factor(&test.sensors[at.sensor()].name, number)]
    }
}
