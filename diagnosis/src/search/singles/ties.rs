//! What the data can hardly tell from the best.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use crate::thresholds::STRONG;
use std::collections::BTreeSet;

pub(super) const STEP: Step = Step { name: "what is tied with the best", when: is_worth_more, take };

/// Fits what leaves nearly the trace of the best hypotheses and was not chosen: a tie that is not shown is a wrong answer.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let Some(best) = board.best() else { return Ok(()) };
    let bases = [board.base_of(best), stage.fit.x.clone()];
    let score_of = |r: &Refit| match &r.tried {
        Tried::Effect(c) => stage.effects.iter().find(|s| stage.id(s) == c.id()),
        Tried::Fault(_) => None,
    };
    let hypotheses = &board.found.hypotheses;
    let tied: Vec<(usize, usize)> = hypotheses
        .iter()
        .filter(|r| r.ln_bayes > best.ln_bayes - STRONG)
        .filter_map(score_of)
        .map(|s| (s.index, s.column))
        .collect();
    let known: BTreeSet<usize> = hypotheses.iter().filter_map(score_of).map(|s| s.index).collect();
    let alike = stage.directions.alike(&tied).into_iter().filter(|i| !known.contains(i));
    let jobs: Vec<Job<'_>> = alike
        .filter_map(|index| stage.effects.iter().find(|s| s.index == index))
        .take(stage.effort().near)
        .map(|s| Job::Effect(s, &bases))
        .collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
