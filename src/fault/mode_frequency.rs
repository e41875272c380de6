//! A frequency that is misread or mistyped: f -> f/g.

use super::bench::leaves_most;
use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::TestMode;

/// Standard deviation of ln of the factor on a frequency.
const FREQUENCY_SD: f64 = 0.2;
/// ln of the odds against those of a kind: one number can be off in every test, and most that is missing shows in one mode more than in others.
const LN_SLIP: f64 = -3.0;
/// Frequencies of a test from which one may be told wrong.
const FEWEST: usize = 3;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct ModeFrequency;

impl Fault for ModeFrequency {
    fn name(&self) -> &'static str {
        "mode-frequency"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The frequency of one mode is misread or mistyped.",
            signature: "It alone is off, its shape and all other modes fit; ln of the factor ~ N(0, 0.2²), and one of twenty such tests has it.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        // One that is known worse than a slip would make it says nothing.
        let is_known = |m: &usize| {
            let f = bench.tests.all().modes[*m].frequency_hz;
            f.sd < FREQUENCY_SD * f.value
        };
        let of = |test: usize| {
            let modes = bench.tests.modes_of(test);
            let known: Vec<usize> = modes.clone().filter(is_known).collect();
            let are_enough = known.len() >= FEWEST && leaves_most(known.len(), modes.len());
            known.into_iter().filter(move |_| are_enough).map(At::Mode)
        };
        (0..bench.tests.count()).flat_map(of).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let stated = |m: usize| {
            let hz = tests.all().modes[m].frequency_hz.value;
            format!("{}, which the test gives as {hz:.4} Hz", tests.mode(m))
        };
        let modes: Vec<String> = at.modes().into_iter().map(stated).collect();
        format!("look up the frequency of {}", modes.join("; "))
    }

    fn number(&self) -> Number {
        Number::Frequency { sd: FREQUENCY_SD }
    }

    fn ln_odds(&self) -> f64 {
        LN_SLIP
    }

    fn modes(&self, at: &At, number: f64, modes: &mut [TestMode]) {
        let At::Mode(m) = *at else { return };
        modes[m].frequency_hz.value /= number;
    }
}
