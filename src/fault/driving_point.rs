//! Frequency responses whose force acted at another sensor than the test says.

use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::{Channel, Correction, Sensor, TestData, channel_sensor};

/// See [`Fault::about`].
#[derive(Debug)]
pub struct DrivingPoint;

impl Fault for DrivingPoint {
    fn name(&self) -> &'static str {
        "driving-point"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The force of the frequency responses acted at another sensor than the test says.",
            signature: "The functions fit with the force there; shapes do not change.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let mut out = Vec::new();
        for test in 0..bench.tests.count() {
            let Some(set) = bench.fitted_functions(test) else { continue };
            let sensors = &bench.tests.test(test).sensors;
            for (reference, channel) in set.references.iter().enumerate() {
                let stated = stated(channel, sensors);
                let others = sensors.iter().zip(bench.tests.sensors_of(test));
                let others = others.filter(|(o, _)| o.name != stated && !o.is_rotation);
                out.extend(others.map(|(_, &sensor)| At::Reference { sensor, test, reference }));
            }
        }
        out
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let At::Reference { sensor, test, reference } = *at else { return String::new() };
        let stated = tests.reference(test, reference);
        format!("the force of the frequency responses acted at {}, not at {stated}", tests.sensor(sensor))
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        let At::Reference { sensor, reference, .. } = *at else { return Vec::new() };
        let Some(set) = &test.frfs else { return Vec::new() };
        let sensor_there = test.sensors[sensor].name.clone();
        let sensor = stated(&set.references[reference], &test.sensors);
        vec![Correction { sensor, acted_at: Some(sensor_there), ..Correction::default() }]
    }
}

/// Where the force is stated to act: at a sensor, else at the node that the channel names.
fn stated(channel: &Channel, sensors: &[Sensor]) -> String {
    channel_sensor(channel, sensors).map_or_else(|| channel.name.clone(), |s| s.name)
}
