//! A sensor, alone at its place, that is tilted by an angle towards a global axis.

use super::bench::ALONG;
use super::sensor_axis::{across_its_direction, stated};
use super::sensor_turned::TURN_SD;
use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::{Correction, Sensor, TestData};
use crate::model::{AXES, GLOBAL, dot, plus, unit};

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorTilted;

impl Fault for SensorTilted {
    fn name(&self) -> &'static str {
        "sensor-tilted"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A sensor is tilted towards a global axis, as on a surface that is not square to it.",
            signature: "It reads a part of the motion along that axis; the angle is estimated, N(0, (0.3 rad)²).",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        if bench.positions.is_none() {
            return Vec::new();
        }
        let sensors = bench.sensors();
        // With another sensor at its place in that direction it would be turned.
        let is_alone = |at: &At| {
            let At::Axis(s, axis) = *at else { return false };
            let towards = across(sensors[s].direction, axis);
            let turns_with = |o: usize| dot(sensors[o].direction, towards).abs() > ALONG && bench.share_a_place(s, o);
            !(0..sensors.len()).any(|o| o != s && turns_with(o))
        };
        across_its_direction(bench).filter(is_alone).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let At::Axis(s, axis) = *at else { return String::new() };
        format!("sensor {} is tilted towards {}: correct its direction", tests.sensor(s), AXES[axis])
    }

    fn number(&self) -> Number {
        Number::Angle { sd: TURN_SD }
    }

    fn sensors(&self, at: &At, angle: f64, sensors: &mut [Sensor]) {
        let At::Axis(s, axis) = *at else { return };
        let (sin, cos) = angle.sin_cos();
        let d = sensors[s].direction;
        let e = across(d, axis);
        sensors[s].direction = [0, 1, 2].map(|k| cos * d[k] + sin * e[k]);
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        vec![stated(test, at.sensor())]
    }
}

/// The direction nearest to a global axis that is perpendicular to a direction; itself along that axis, where there is none.
fn across(direction: [f64; 3], axis: usize) -> [f64; 3] {
    unit(plus(GLOBAL[axis], -direction[axis], direction)).unwrap_or(direction)
}
