//! A reading of a static test that is off by a factor: t -> t/g, σ -> σ/g.

use super::sensor_gain::GAIN_SD;
use super::{AboutFault, At, Bench, Fault, Number, Tests};

/// See [`Fault::about`].
#[derive(Debug)]
pub struct StaticReading;

impl Fault for StaticReading {
    fn name(&self) -> &'static str {
        "static-reading"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A reading of a static test is off by a factor: a dial of another scale, a wrong sign, inches read as millimetres.",
            signature: "One deflection or angle does not follow the loads as the others do; ln of the factor ~ N(0, 0.3²), and it may be negative.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let mut all = Vec::new();
        for test in 0..bench.tests.count() {
            for (of, t) in bench.tests.test(test).static_tests.iter().enumerate() {
                let sensor = |k: usize| bench.tests.sensors_of(test)[t.readings[k].sensor];
                all.extend((0..t.readings.len()).map(|reading| At::StaticReading {
                    sensor: sensor(reading),
                    test,
                    of,
                    reading,
                }));
            }
        }
        all
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("read the static test again at {}", at.words(tests))
    }

    fn number(&self) -> Number {
        Number::Factor { sd: GAIN_SD }
    }

    fn static_factor(&self, at: &At, number: f64, of: usize, reading: usize) -> f64 {
        let is_own = matches!(at, At::StaticReading { of: o, reading: r, .. } if (*o, *r) == (of, reading));
        if is_own { number } else { 1.0 }
    }
}
