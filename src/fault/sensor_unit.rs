//! A channel in g among channels in m/s²: t -> 9.80665 t, its functions too.

use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::{Correction, TestData};
use crate::linalg::Complex;
use crate::units::GRAVITY as G;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorUnit;

impl Fault for SensorUnit {
    fn name(&self) -> &'static str {
        "sensor-unit"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A channel is in g among channels in m/s²: the unit of its sensitivity was taken for another.",
            signature: "Its reading is 9.8 times too small in every mode; there is no number to fit.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.channels().map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("read sensor {} in g, or look at the unit of its sensitivity", tests.sensor(at.sensor()))
    }

    fn shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        let s = at.sensor();
        shape[s] *= G;
        if let Some(sd) = sd {
            sd[s] *= G;
        }
    }

    fn put_into_shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>]) {
        shape[at.sensor()] /= G;
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        vec![Correction::factor(&test.sensors[at.sensor()].name, 1.0 / G)]
    }
}
