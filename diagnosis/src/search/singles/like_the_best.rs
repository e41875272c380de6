//! What is like the best effect, in kind or place.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::screen::effects::Score;
use crate::search::board::Board;
use crate::search::hypothesis::Tried;
use crate::search::run::{Job, run};
use crate::search::short_fit::shortest;
use crate::thresholds::STRONG;

pub(super) const STEP: Step = Step { name: "like the best", when: is_worth_more, take };

/// Fits what is like the best effect, in kind or place, from where the best has brought the base, until nothing better comes.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    for _ in 0..stage.effort().rounds {
        let Some(best) = board.best() else { return Ok(()) };
        let (Tried::Effect(found), before) = (&best.tried, best.ln_bayes) else { return Ok(()) };
        if before < STRONG {
            return Ok(());
        }
        let bases = [board.base_of(best)];
        let like = |s: &&Score| {
            let c = &stage.screened[s.index].candidate;
            let is_found = c.id() == found.id();
            !is_found && (c.effect.name() == found.effect.name() || c.location.shares_name(&found.location))
        };
        let near: Vec<&Score> = stage.effects.iter().filter(like).take(stage.effort().near).collect();
        let near = shortest(stage, &near, &bases);
        let jobs: Vec<Job<'_>> = near.into_iter().take(stage.effort().best).map(|s| Job::Effect(s, &bases)).collect();
        let found = run(stage, &jobs, board.ln_base);
        board.add(found);
        if board.best().is_none_or(|best| best.ln_bayes < before + STRONG) {
            return Ok(());
        }
    }
    Ok(())
}
