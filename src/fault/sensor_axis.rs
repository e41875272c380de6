//! A sensor that reads another global axis at its place.

use super::bench::ALONG;
use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::{Correction, Sensor, TestData};
use crate::identify::health::codes;
use crate::model::{AXES, GLOBAL};

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorAxis;

impl Fault for SensorAxis {
    fn name(&self) -> &'static str {
        codes::SENSOR_AXIS
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A sensor reads along another global axis than the test says.",
            signature: "It reads what the model has at its place along that axis.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        across_its_direction(bench).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let At::Axis(s, axis) = *at else { return String::new() };
        format!("sensor {} reads along {}", tests.sensor(s), AXES[axis])
    }

    fn sensors(&self, at: &At, _: f64, sensors: &mut [Sensor]) {
        if let At::Axis(s, axis) = *at {
            sensors[s].direction = GLOBAL[axis];
        }
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        vec![stated(test, at.sensor())]
    }
}

/// Every sensor with every global axis that it is not along.
pub(super) fn across_its_direction<'b>(bench: &'b Bench<'_>) -> impl Iterator<Item = At> + 'b {
    let is_across = |s: usize, axis: usize| bench.sensors()[s].direction[axis].abs() < ALONG;
    bench
        .channels()
        .flat_map(move |s| (0..3).filter(move |&axis| is_across(s, axis)).map(move |axis| At::Axis(s, axis)))
}

/// What functions need of a sensor whose direction is another one than that which the test states.
pub(super) fn stated(test: &TestData, sensor: usize) -> Correction {
    let Sensor { name, direction, .. } = &test.sensors[sensor];
    Correction { sensor: name.clone(), stated: Some(*direction), ..Correction::default() }
}
