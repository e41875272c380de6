//! The best few from other basins.

use super::step::{Step, is_unexplained};
use crate::error::DiagnosisError;
use crate::problem::scene::box_starts;
use crate::screen::traces::FaultScore;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use retune::linalg::DVector;

pub(super) const STEP: Step = Step { name: "the best from other basins", when: is_unexplained, take };

/// Fits the best few once more from where every other hypothesis has brought the base, and from points of the box: in the wrong basin none would
/// leave noise.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    board.found.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let hypotheses = &board.found.hypotheses;
    let mut bases: Vec<DVector<f64>> = hypotheses.iter().take(stage.effort().best).map(|r| board.base_of(r)).collect();
    bases.extend(box_starts(&stage.scene, stage.effort().best, 0));
    let faults: Vec<FaultScore> = (0..stage.faults.len()).map(FaultScore::unscored).collect();
    let mut kinds: Vec<&str> = Vec::new();
    let mut is_polished = |(k, r): &(usize, &Refit)| {
        let is_new = !kinds.contains(&r.name()) && kinds.len() < stage.effort().polished_kinds;
        if is_new {
            kinds.push(r.name());
        }
        is_new || *k < stage.effort().polished
    };
    let jobs: Vec<Job<'_>> = hypotheses
        .iter()
        .enumerate()
        .filter(|r| is_polished(r))
        .filter_map(|(_, r)| match &r.tried {
            Tried::Effect(c) => {
                let score = stage.effects.iter().find(|s| stage.id(s) == c.id())?;
                Some(Job::Effect(score, &bases))
            }
            Tried::Fault(f) => Some(Job::Fault(&faults[stage.faults.iter().position(|g| g == f)?], &bases)),
        })
        .collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
