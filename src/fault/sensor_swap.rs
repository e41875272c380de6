//! Two channels that are exchanged: t_i <-> t_j.

use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::{Correction, TestData};
use crate::identify::health::codes;
use crate::linalg::Complex;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorSwap;

impl Fault for SensorSwap {
    fn name(&self) -> &'static str {
        codes::SENSOR_SWAP
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The channels of two sensors are exchanged.",
            signature: "Each reads what the model has at the other, in every mode.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.pairs().map(|(a, b)| At::Sensors(a, b)).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let names: Vec<&str> = at.sensors().into_iter().map(|s| tests.sensor(s)).collect();
        format!("exchange the channels of sensors {}", names.join(" and "))
    }

    fn shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        let At::Sensors(a, b) = *at else { return };
        shape.swap(a, b);
        if let Some(sd) = sd {
            sd.swap(a, b);
        }
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        let At::Sensors(a, b) = *at else { return Vec::new() };
        let [sensor, other] = [a, b].map(|s| test.sensors[s].name.clone());
        vec![Correction { sensor, exchanged_with: Some(other), ..Correction::default() }]
    }
}
