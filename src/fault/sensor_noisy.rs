//! A sensor that scatters more than stated: σ -> κ σ, which costs m ln κ for its m entries.

use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::identify::health::codes;
use crate::linalg::Complex;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorNoisy;

impl Fault for SensorNoisy {
    fn name(&self) -> &'static str {
        codes::SENSOR_NOISY
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A sensor scatters more than the test says.",
            signature: "Its residuals are large without an order; a factor on its standard deviation is estimated.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.channels().map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("check sensor {}: it scatters more than stated", tests.sensor(at.sensor()))
    }

    fn number(&self) -> Number {
        Number::Scatter
    }

    fn shape(&self, at: &At, number: f64, _: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        if let Some(sd) = sd {
            sd[at.sensor()] *= number;
        }
    }
}
