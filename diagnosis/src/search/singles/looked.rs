//! The effects that a look at several sizes puts first.

use super::step::{Step, is_poor};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::hypothesis::Tried;
use crate::search::run::{Job, run};

pub(super) const STEP: Step = Step { name: "the best of a look at several sizes", when: is_poor, take };

/// Fits the effects that leave least at one of their sizes and have not been fitted yet, as many as the screening has put first.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let is_known = |id: &str| {
        let mut known = board.found.hypotheses.iter();
        known.any(|r| matches!(&r.tried, Tried::Effect(c) if c.id() == id))
    };
    let new = board.by_size().iter().take(board.most).filter(|s| !is_known(&stage.id(s)));
    let jobs: Vec<Job<'_>> = new.map(|s| Job::Effect(s, &board.bases)).collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
