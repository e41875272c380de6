//! Frequency responses of a sensor that are off by a factor while its shapes are not: H -> H/g.

use super::bench::response_of;
use super::sensor_gain::GAIN_SD;
use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::{Correction, TestData};

/// See [`Fault::about`].
#[derive(Debug)]
pub struct FunctionGain;

impl Fault for FunctionGain {
    fn name(&self) -> &'static str {
        "function-gain"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The frequency responses of a sensor are off by one factor, its shapes are not: another calibration, or another charge amplifier.",
            signature: "All lines of its functions are off by one factor; ln of the factor ~ N(0, 0.3²).",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let of = |test: usize| {
            let own = bench.tests.sensors_of(test).iter().enumerate();
            let measured = move |&(k, _): &(usize, &usize)| {
                let sensors = &bench.tests.test(test).sensors;
                bench.fitted_functions(test).is_some_and(|set| response_of(set, sensors, k).is_some())
            };
            own.filter(measured).map(move |(_, &sensor)| At::Response { sensor, test })
        };
        (0..bench.tests.count()).flat_map(of).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("correct the calibration of the functions of sensor {}", tests.sensor(at.sensor()))
    }

    fn number(&self) -> Number {
        Number::Factor { sd: GAIN_SD }
    }

    fn functions(&self, at: &At, number: f64, test: &TestData) -> Vec<Correction> {
        vec![Correction::factor(&test.sensors[at.sensor()].name, number)]
    }
}
