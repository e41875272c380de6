//! A load of a static test that was another: all its readings t -> t/g, σ -> σ/g.

use super::sensor_gain::GAIN_SD;
use super::{AboutFault, At, Bench, Fault, Number, Tests};

/// See [`Fault::about`].
#[derive(Debug)]
pub struct StaticLoad;

impl Fault for StaticLoad {
    fn name(&self) -> &'static str {
        "static-load"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The loads of a static test were larger or smaller than the test says: another weight, a load cell of another range, pounds read as newtons.",
            signature: "All readings of that test are off by one factor; ln of the factor ~ N(0, 0.3²), and it may be negative.",
        }
    }

    /// Of one test among several readings of the structure: a factor on the only reading is that reading's own.
    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let of = |test: usize| {
            let own = bench.tests.test(test).static_tests.iter().enumerate();
            own.filter(|(_, t)| t.readings.len() > 1).map(move |(of, _)| At::Load { test, of })
        };
        (0..bench.tests.count()).flat_map(of).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("weigh the loads of the static test {} again", at.words(tests))
    }

    fn number(&self) -> Number {
        Number::Factor { sd: GAIN_SD }
    }

    fn static_factor(&self, at: &At, number: f64, of: usize, _: usize) -> f64 {
        if matches!(at, At::Load { of: own, .. } if *own == of) { number } else { 1.0 }
    }
}
