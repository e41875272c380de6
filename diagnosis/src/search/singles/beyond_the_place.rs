//! The leading effect on more than its own place.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::screen::stage::Stage;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::short_fit::the_best_of;
use crate::thresholds::STRONG;
use retune::effect::{Candidate, LocationKind};

pub(super) const STEP: Step = Step { name: "beyond the place of the best", when: is_worth_more, take };

/// Fits the leading effect on neighbouring spans.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let found = beyond_the_best(board.stage, &board.found.hypotheses, board.ln_base);
    board.add(found);
    Ok(())
}

/// What explains the test best on more than its own place: an effect at an element or a member on the elements around it or some of it too,
/// where it explains more there.
///
/// * `base` - ln evidence of the base
fn beyond_the_best(stage: &Stage, done: &[Refit], base: f64) -> Vec<Refit> {
    let Some(best) = done.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) else { return Vec::new() };
    let Tried::Effect(found) = &best.tried else { return Vec::new() };
    let there = &found.location;
    if best.ln_bayes < STRONG || !matches!(there.kind, LocationKind::Element | LocationKind::Chain) {
        return Vec::new();
    }
    let is_like = |c: &Candidate| {
        let at = &c.location;
        c.effect.name() == found.effect.name()
            && (at.direction(), &at.configuration, at.names.len())
                == (there.direction(), &there.configuration, there.names.len())
    };
    let Ok(wider) = stage.on_wider(stage.wider_candidates(Some(&there.names), is_like)) else { return Vec::new() };
    let bases = [best.fit.x.rows(0, stage.fit.x.len()).into_owned()];
    let mut tried = the_best_of(&wider, &bases, base);
    tried.retain(|r| r.ln_bayes > best.ln_bayes);
    tried
}
