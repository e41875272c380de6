//! Frequencies of two neighbouring modes that are exchanged in the list.

use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::TestMode;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct ModeOrder;

impl Fault for ModeOrder {
    fn name(&self) -> &'static str {
        "mode-order"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The frequencies of two neighbouring modes are exchanged in the list, their shapes are not.",
            signature: "Both shapes fit at the frequency of the other.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let of = |test: usize| bench.tests.modes_of(test).skip(1).map(|m| At::Modes(m - 1, m));
        (0..bench.tests.count()).flat_map(of).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let names: Vec<String> = at.modes().into_iter().map(|m| tests.mode(m)).collect();
        format!("exchange the frequencies of {}", names.join(" and "))
    }

    fn modes(&self, at: &At, _: f64, modes: &mut [TestMode]) {
        let At::Modes(a, b) = *at else { return };
        let f = modes[a].frequency_hz;
        modes[a].frequency_hz = modes[b].frequency_hz;
        modes[b].frequency_hz = f;
    }
}
