//! Several things that are wrong at once, one found on top of the other.
//!
//! Where no hypothesis suffices, and no two, the search goes on from the best: what explains most of the rest is added, until the rest looks
//! like noise. All that was added has to be more probable than a change of many parts, which explains much as well:
//!
//! ```text
//! ln odds B = Σ_k (ln odds_k + ln B(k | all before it))  >  ln odds B (something else) + 3
//! ```

use super::hypothesis::{Refit, Tried};
use super::prior::Odds;
use super::remainder::remains;
use super::singles::refit;
use crate::error::DiagnosisError;
use crate::screen::stage::Stage;
use crate::settings::Settings;
use crate::thresholds::STRONG;

/// Hypotheses of a chain that has a fault of the measurement, at most: where many things are wrong and data have to be explained away on top, it is as
/// often one thing that the catalogue lacks.
const MOST_WITH_FAULTS: usize = 3;

/// Hypotheses, each fitted on top of those before it, that leave noise together.
pub(crate) struct Chain {
    /// Each with the stage that it was fitted on.
    pub(crate) members: Vec<(Stage, Refit)>,
    /// ln of odds times Bayes factors of all together.
    pub(crate) ln_all: f64,
    /// The member that explains most alone.
    first: usize,
}

impl Chain {
    /// The ids: that of the member that explains most alone, then the others in the order in which they were found.
    pub(crate) fn ids(&self) -> Vec<String> {
        let mut ids: Vec<String> = self.members.iter().map(|(stage, r)| r.id(&stage.scene)).collect();
        ids[..=self.first].rotate_right(1);
        ids
    }

    /// The member that explains most alone, as it was fitted in the chain.
    pub(crate) fn first(&self) -> &Refit {
        &self.members[self.first].1
    }

    /// The last one, with all in it.
    pub(crate) fn last(&self) -> &Refit {
        &self.members[self.members.len() - 1].1
    }
}

/// A chain that begins with some hypotheses and leaves noise, if there is one.
///
/// * `members` - each with the stage that it was fitted on, which has those before it
/// * `alone` - hypotheses that were fitted alone
/// * `ln_else` - ln of odds times Bayes factor of something outside the catalogue
pub(crate) fn chain(
    mut members: Vec<(Stage, Refit)>,
    alone: &[Refit],
    odds: &Odds<'_>,
    ln_else: f64,
    settings: &Settings,
) -> Result<Option<Chain>, DiagnosisError> {
    let weight = |r: &Refit| odds.weight(r);
    while let Some((stage, last)) = members.last() {
        let (left, with_all) = remains(stage, last, settings)?;
        if left.needs_nothing_more() {
            let ln_all = members.iter().map(|(_, r)| weight(r)).sum();
            let of_alone = |(k, (stage, r)): (usize, &(Stage, Refit))| {
                let id = r.id(&stage.scene);
                let known = alone.iter().find(|a| a.id(&stage.scene) == id);
                known.map(|a| a.ln_bayes).or((k == 0).then_some(r.ln_bayes))
            };
            let brings: Vec<f64> =
                members.iter().enumerate().map(|m| of_alone(m).unwrap_or(f64::NEG_INFINITY)).collect();
            let first = (0..brings.len()).rev().max_by(|&a, &b| brings[a].total_cmp(&brings[b])).unwrap_or(0);
            let explains_away = members.iter().any(|(_, r)| matches!(r.tried, Tried::Fault(_)));
            let is_believed = members.len() <= MOST_WITH_FAULTS || !explains_away;
            return Ok((is_believed && ln_all > ln_else + STRONG).then_some(Chain { members, ln_all, first }));
        }
        if members.len() == settings.effort.chain
            || stage.settings.until.is_over()
            || with_all.p_value >= settings.alarm_level
        {
            return Ok(None);
        }
        let known: Vec<String> = members.iter().map(|(stage, r)| r.id(&stage.scene)).collect();
        let more = refit(&with_all, true)?.hypotheses.into_iter();
        let is_new = |r: &Refit| r.ln_bayes > STRONG && !known.contains(&r.id(&with_all.scene));
        let next = more.filter(is_new).max_by(|a, b| weight(a).total_cmp(&weight(b)));
        let Some(next) = next else { return Ok(None) };
        members.push((with_all, next));
    }
    Ok(None)
}
