//! Every other effect with a few steps, and the faults that were left.

use super::chosen::{chosen_faults, further_faults};
use super::step::{Step, is_poor_and_unexplained};
use crate::error::DiagnosisError;
use crate::screen::stage::in_turns;
use crate::search::board::Board;
use crate::search::run::{Job, best_and_of_every_kind, run};
use crate::search::short_fit::shortest;
use crate::search::spread;

pub(super) const STEP: Step = Step { name: "every other effect and fault", when: is_poor_and_unexplained, take };

/// Fits every other effect with a few steps, the best of these and of every kind in full; and the faults that were left.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    board.bases.extend(spread::best(&board.found.spreads).map(|s| s.base.clone()));
    let mut all = in_turns(&stage.effects, board.by_size().iter().copied());
    all.truncate(stage.effort().short_fits);
    let near = best_and_of_every_kind(stage, shortest(stage, &all, &board.bases), board.most);
    let further = further_faults(stage, &chosen_faults(stage));
    let effects = near.into_iter().map(|s| Job::Effect(s, &board.bases));
    let jobs: Vec<Job<'_>> = effects.chain(further.iter().map(|f| Job::Fault(f, &board.bases))).collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
