//! Is the base in the basin where it belongs?
//!
//! A fit may end in a wrong basin, and what is added to it then seems to explain what only takes it out of there. So the base is fitted once
//! more from where hypotheses and changes of every element have brought its parameters.

use super::board::{Refits, merge};
use super::hypothesis::Refit;
use super::singles::refit;
use crate::error::DiagnosisError;
use crate::problem::evidence::{goodness_of_fit, ln_evidence};
use crate::problem::race::{fit_by, in_full};
use crate::problem::scene::box_starts;
use crate::screen::stage::{Stage, stage};
use crate::settings::Settings;
use crate::thresholds::{LOWER, LOWER_SHARE, REMAINDER};
use retune::linalg::DVector;

/// The base and its refits, from where the base is lowest.
pub(crate) fn in_the_lowest_basin(
    mut base: Stage,
    mut refits: Refits,
    settings: &Settings,
) -> Result<(Stage, Refits), DiagnosisError> {
    for _ in 0..settings.effort.moves {
        if base.settings.until.is_over() {
            break;
        }
        let Some(lower) = lower_basin(&base, &refits, settings)? else { break };
        (base, refits) = from_there(base, refits, lower, settings)?;
    }
    Ok((base, refits))
}

/// Where the base fits better than its fit does, if what a hypothesis or a change of every element has made of its parameters leads there.
pub(crate) fn lower_basin(
    base: &Stage,
    refits: &Refits,
    settings: &Settings,
) -> Result<Option<DVector<f64>>, DiagnosisError> {
    if goodness_of_fit(&base.fit, &base.q) >= REMAINDER {
        return Ok(None);
    }
    let n = base.fit.x.len();
    let mut best: Vec<&Refit> = refits.hypotheses.iter().collect();
    best.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let mut ways = vec![base.fit.x.clone()];
    ways.extend(refits.spreads.iter().map(|s| s.base.clone()));
    ways.extend(best.into_iter().take(settings.effort.ways).map(|r| r.fit.x.rows(0, n).into_owned()));
    ways.extend(box_starts(&base.scene, settings.effort.ways / 2, settings.seed.wrapping_add(1)));
    let ways: Vec<Vec<DVector<f64>>> = ways.into_iter().map(|x| vec![x]).collect();
    let rounds = in_full(ways.len(), 1, &settings.effort);
    let found = fit_by(&base.scene, &ways, rounds, base.weight)?;
    let least = refits.hypotheses.iter().map(|r| r.fit.phi).fold(base.fit.phi, f64::min);
    let enough = LOWER.max(LOWER_SHARE * (base.fit.phi - least));
    Ok((found.phi < base.fit.phi - enough).then_some(found.x))
}

/// The base and its refits where it is lower, with what was found where it was.
fn from_there(
    before: Stage,
    found: Refits,
    lower: DVector<f64>,
    settings: &Settings,
) -> Result<(Stage, Refits), DiagnosisError> {
    let ln_before = ln_evidence(&before.fit)?;
    let base = stage(before.scene, &[lower], before.weight, settings)?;
    let ln_base = ln_evidence(&base.fit)?;
    let mut refits = refit(&base, false)?;
    let against = |r: Refit| Refit { ln_bayes: r.ln_bayes + ln_before - ln_base, ..r };
    merge(&base, &mut refits.hypotheses, found.hypotheses.into_iter().map(against).collect());
    Ok((base, refits))
}
