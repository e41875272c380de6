//! A sensor that reads nothing but noise: its cost is ½ Σ (t/σ)².

use super::bench::leaves_most;
use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::{Correction, TestData};
use crate::identify::health::codes;
use crate::linalg::Complex;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorDead;

impl Fault for SensorDead {
    fn name(&self) -> &'static str {
        codes::SENSOR_DEAD
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A sensor reads nothing but noise.",
            signature: "Its reading is zero within its standard deviation in every mode.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let modes = &bench.tests.all().modes;
        let reads = |s: &usize| modes.iter().any(|m| m.shape.as_ref().is_some_and(|v| !v[*s].re.is_nan()));
        let channels = bench.channels();
        if !leaves_most(channels.clone().filter(reads).count(), channels.end) {
            return Vec::new();
        }
        channels.map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("leave out sensor {}: it reads noise only", tests.sensor(at.sensor()))
    }

    fn number(&self) -> Number {
        Number::Silence
    }

    fn shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>], _: Option<&mut [f64]>) {
        shape[at.sensor()] = Complex::new(f64::NAN, f64::NAN);
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        let sensor = test.sensors[at.sensor()].name.clone();
        vec![Correction { sensor, reads_nothing: true, ..Correction::default() }]
    }
}
