//! Two perpendicular sensors at one place that are turned in their plane by an angle.

use super::sensor_axis::stated;
use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::{Correction, Sensor, TestData};
use crate::model::dot;

/// Standard deviation of the angle by which sensors are turned, rad.
pub(super) const TURN_SD: f64 = 0.3;
/// Directions whose cosine is less are perpendicular.
const PERPENDICULAR: f64 = 1e-9;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorTurned;

impl Fault for SensorTurned {
    fn name(&self) -> &'static str {
        "sensor-turned"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "Two perpendicular sensors at one place are turned in their plane, as a triaxial accelerometer that was put on askew.",
            signature: "Each reads a part of what the other should; the angle is estimated, N(0, (0.3 rad)²).",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let sensors = bench.sensors();
        let is_square = |&(a, b): &(usize, usize)| {
            bench.share_a_place(a, b) && dot(sensors[a].direction, sensors[b].direction).abs() < PERPENDICULAR
        };
        bench.pairs().filter(is_square).map(|(a, b)| At::Sensors(a, b)).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let names: Vec<&str> = at.sensors().into_iter().map(|s| tests.sensor(s)).collect();
        format!("sensors {} are turned in their plane: correct their directions", names.join(" and "))
    }

    fn number(&self) -> Number {
        Number::Angle { sd: TURN_SD }
    }

    fn sensors(&self, at: &At, angle: f64, sensors: &mut [Sensor]) {
        let At::Sensors(a, b) = *at else { return };
        let (sin, cos) = angle.sin_cos();
        let (d, e) = (sensors[a].direction, sensors[b].direction);
        sensors[a].direction = [0, 1, 2].map(|k| cos * d[k] + sin * e[k]);
        sensors[b].direction = [0, 1, 2].map(|k| cos * e[k] - sin * d[k]);
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        at.sensors().into_iter().map(|s| stated(test, s)).collect()
    }
}
