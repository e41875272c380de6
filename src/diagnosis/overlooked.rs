//! Modes of a model that a test should have seen: an effect that brings one is believed less.

use super::fit::Fit;
use crate::objective::{Comparison, Prediction};

/// Largest mass-normalised motion at a sensor of a mode that is seen well, as a share of the median of the modes that are paired: a force
/// at such a sensor makes a tenth of their response.
const SEEN: f64 = 0.3;

/// ln of the odds that a test overlooks a mode that its sensors see well, among those that it lists: one of twenty.
const LN_OVERLOOKED: f64 = -3.0;

/// Frequencies of modes, Hz, up to the highest tested one, that the sensors see well and no measured mode is paired with; none where the
/// test has no shapes.
pub(super) fn overlooked(comparison: &Comparison<'_>, p: &Prediction) -> Vec<f64> {
    if !comparison.has_shapes() {
        return Vec::new();
    }
    let highest = comparison.test().modes.iter().map(|m| m.frequency_hz.value).fold(0.0, f64::max);
    let peak = |a: usize| p.at_sensors.column(a).amax();
    let mut known: Vec<f64> = p.pairs.pairs.iter().map(|pair| peak(pair.analytical)).collect();
    known.sort_by(f64::total_cmp);
    let Some(&typical) = known.get(known.len() / 2) else { return Vec::new() };
    let is_overlooked = |&a: &usize| {
        p.frequencies_hz[a] < highest
            && p.pairs.pairs.iter().all(|pair| pair.analytical != a)
            && peak(a) > SEEN * typical
    };
    (0..p.frequencies_hz.len()).filter(is_overlooked).map(|a| p.frequencies_hz[a]).collect()
}

/// How many modes more than the base a fit has that the test should have seen, and ln of the odds of that.
pub(super) fn brought(base: &Fit, fit: &Fit) -> (usize, f64) {
    let all = |fit: &Fit| fit.overlooked.iter().map(Vec::len).sum::<usize>();
    let more = all(fit).saturating_sub(all(base));
    (more, LN_OVERLOOKED * more as f64)
}
