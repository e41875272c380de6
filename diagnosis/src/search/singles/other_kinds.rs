//! Other effects at a place that no search tries at first, where one has been found there: a patch that is thinner may rather be softer.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::hypothesis::Tried;
use crate::search::short_fit::the_best_of;
use crate::thresholds::STRONG;
use retune::effect::Candidate;
use retune::linalg::DVector;

pub(super) const STEP: Step = Step { name: "other effects at the places of the best", when: is_worth_more, take };

/// Fits all other effects at the places of what is as good as the best, from where that has brought the base.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let least = board.best().map_or(f64::INFINITY, |r| r.ln_bayes - STRONG).max(STRONG);
    let is_screened = |c: &Candidate| stage.screened.iter().any(|s| s.candidate.location.names == c.location.names);
    let mut places: Vec<(Candidate, DVector<f64>)> = Vec::new();
    for r in board.found.hypotheses.iter().filter(|r| r.ln_bayes > least) {
        let Tried::Effect(found) = &r.tried else { continue };
        let is_known = places.iter().any(|(c, _)| c.location.names == found.location.names);
        if !is_known && !is_screened(found) {
            places.push((found.clone(), board.base_of(r)));
        }
    }
    for (found, base) in places {
        let there = stage.on_wider(stage.other_candidates(&found))?;
        let found = the_best_of(&there, &[base], board.ln_base);
        board.add(found);
    }
    Ok(())
}
