//! Effects that have the best one as a limit: a mass on an arm or on a spring where a point mass leads and leaves more than noise.

use super::step::{Step, is_unexplained};
use crate::error::DiagnosisError;
use crate::screen::effects::Score;
use crate::search::board::Board;
use crate::search::hypothesis::Tried;
use crate::search::run::{Job, run};

pub(super) const STEP: Step = Step { name: "what has the best as a limit", when: is_unexplained, take };

/// Fits what becomes the best at a limit of its sizes, at the same place, from where the best has brought the base.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let Some(best) = board.best() else { return Ok(()) };
    let Tried::Effect(found) = &best.tried else { return Ok(()) };
    let bases = [board.base_of(best), stage.fit.x.clone()];
    let has_it_as_a_limit = |s: &&Score| {
        let c = &stage.screened[s.index].candidate;
        let is_there =
            (&c.location.names, &c.location.configuration) == (&found.location.names, &found.location.configuration);
        is_there && c.effect.becomes().contains(&found.effect.name())
    };
    let more: Vec<&Score> = stage.effects.iter().filter(has_it_as_a_limit).collect();
    let jobs: Vec<Job<'_>> = more.into_iter().map(|s| Job::Effect(s, &bases)).collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
