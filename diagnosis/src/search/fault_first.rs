//! The most probable fault first, and what is missing on top of it.
//!
//! Where a fault spoils many rows and an effect is missing too, a third thing may explain more alone than either, and what is sought beside
//! that is an image of what it leaves. A fault is no image of an effect: with it taken out of the test, the effect is found as it would be
//! in a sound test.

use super::hypothesis::{Refit, Tried};
use super::joint::WithFirst;
use super::prior::Odds;
use super::run::stage_with;
use super::singles::refit;
use crate::error::DiagnosisError;
use crate::screen::stage::Stage;
use crate::settings::Settings;
use crate::thresholds::STRONG;

/// The most probable fault, and what explains the rest, where the two are more probable than another pair.
///
/// * `refits` - of the base
/// * `other` - the hypothesis that was taken for the first already
/// * `ln_known` - ln of odds times Bayes factor of the other pair
pub(crate) fn fault_first(
    base: &Stage,
    refits: &[Refit],
    other: &Refit,
    odds: &Odds<'_>,
    ln_known: f64,
    settings: &Settings,
) -> Result<Option<WithFirst>, DiagnosisError> {
    let weight = |r: &Refit| odds.weight(r);
    let faults = refits.iter().filter(|r| matches!(r.tried, Tried::Fault(_)) && r.ln_bayes > STRONG);
    let best = faults.max_by(|a, b| weight(a).total_cmp(&weight(b)));
    let Some(fault) = best.filter(|f| f.id(&base.scene) != other.id(&base.scene)) else { return Ok(None) };
    if base.settings.until.is_over() {
        return Ok(None);
    }
    let stage = stage_with(base, fault, settings)?;
    let more = refit(&stage, true)?.hypotheses;
    let ln = weight(fault) + more.iter().map(weight).fold(f64::NEG_INFINITY, f64::max);
    Ok((ln > ln_known).then(|| (fault.clone(), stage, more)))
}
