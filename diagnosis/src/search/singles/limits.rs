//! What the best effects become at a limit of their sizes: a point mass where a mass on an arm or on a stiff spring leads.

use super::step::{Step, has_strong};
use crate::error::DiagnosisError;
use crate::screen::effects::Score;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use crate::thresholds::STRONG;
use retune::effect::Candidate;
use retune::linalg::DVector;

pub(super) const STEP: Step = Step { name: "the best at a limit of its sizes", when: has_strong, take };

/// Fits the limits of what is as good as the best, at the same places, from where that has brought the base.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let least = board.best().map_or(f64::INFINITY, |r| r.ln_bayes - STRONG).max(STRONG);
    let is_known = |c: &Candidate| board.found.hypotheses.iter().any(|r| r.id(&stage.scene) == c.id());
    let mut limits: Vec<(Candidate, DVector<f64>)> = Vec::new();
    for r in board.found.hypotheses.iter().filter(|r| r.ln_bayes > least) {
        let Tried::Effect(found) = &r.tried else { continue };
        if found.effect.becomes().is_empty() {
            continue;
        }
        let is_new = |c: &Candidate| !is_known(c) && !limits.iter().any(|(l, _)| l.id() == c.id());
        let new: Vec<Candidate> = stage.limit_candidates(found).into_iter().filter(is_new).collect();
        limits.extend(new.into_iter().map(|c| (c, board.base_of(r))));
    }
    if limits.is_empty() {
        return Ok(());
    }
    let there = stage.on_wider(limits.iter().map(|(c, _)| c.clone()).collect())?;
    let base_of = |s: &Score| limits.iter().find(|(c, _)| c.id() == there.id(s)).map(|(_, x)| [x.clone()]);
    let bases: Vec<_> = there.effects.iter().filter_map(|s| Some((s, base_of(s)?))).collect();
    let jobs: Vec<Job<'_>> = bases.iter().map(|(s, bases)| Job::Effect(s, bases)).collect();
    let found: Vec<Refit> = run(&there, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
