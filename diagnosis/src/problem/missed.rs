//! Modes of a model that a test should have seen: an effect that brings one is believed less.

use crate::thresholds::SEEN_WELL;
use retune::objective::{Comparison, Prediction};

/// Frequencies of modes, Hz, up to the highest tested one, that the sensors see well and no measured mode is paired with; none where the
/// test has no shapes.
pub(crate) fn missed_modes(comparison: &Comparison<'_>, p: &Prediction) -> Vec<f64> {
    if !comparison.has_shapes() {
        return Vec::new();
    }
    let highest = comparison.test().modes.iter().map(|m| m.frequency_hz.value).fold(0.0, f64::max);
    let peak = |a: usize| p.at_sensors.column(a).amax();
    let mut known: Vec<f64> = p.pairs.pairs.iter().map(|pair| peak(pair.analytical)).collect();
    known.sort_by(f64::total_cmp);
    let Some(&typical) = known.get(known.len() / 2) else { return Vec::new() };
    let is_missed = |&a: &usize| {
        p.frequencies_hz[a] < highest
            && p.pairs.pairs.iter().all(|pair| pair.analytical != a)
            && peak(a) > SEEN_WELL * typical
    };
    (0..p.frequencies_hz.len()).filter(is_missed).map(|a| p.frequencies_hz[a]).collect()
}
