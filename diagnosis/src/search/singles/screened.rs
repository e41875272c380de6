//! The effects and faults that the screening puts first.

use super::chosen::{chosen_effects, chosen_faults};
use super::step::{Step, always};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::run::{Job, run};

pub(super) const STEP: Step = Step { name: "the best of the screening", when: always, take };

/// Fits the effects and faults that the screening puts first.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let (scores, faults) = (chosen_effects(stage, board.most), chosen_faults(stage));
    let effects = scores.iter().map(|s| Job::Effect(s, &board.bases));
    let jobs: Vec<Job<'_>> = effects.chain(faults.iter().map(|&f| Job::Fault(f, &board.bases))).collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    board.found.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    Ok(())
}
