//! The best effects at places of a mesh between those that every search tries.

use super::step::{Step, is_worth_more};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::diagnosis::search::board::Board;
use crate::diagnosis::search::hypothesis::Tried;
use crate::diagnosis::search::run::{Job, run};
use crate::diagnosis::search::short_fit::shortest;
use crate::diagnosis::thresholds::STRONG;
use crate::effect::Candidate;

pub(super) const STEP: Step = Step { name: "between the places of a mesh", when: is_worth_more, take };

/// Looks about the best few effects at places of a mesh, nearer with every round, until nothing better comes.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let mut looked: Vec<String> = Vec::new();
    for round in 0..stage.effort().rounds {
        let before = board.best().map_or(0.0, |r| r.ln_bayes);
        for centre in of_each_kind(board) {
            let id = format!("{} {round}", centre.id());
            if looked.contains(&id) {
                continue;
            }
            looked.push(id);
            look_about(board, &centre, round as u32)?;
        }
        if round > 0 && board.best().is_none_or(|r| r.ln_bayes <= before) {
            break;
        }
    }
    Ok(())
}

/// The best place of each of the best few effects that have one, where it explains much.
fn of_each_kind(board: &Board<'_>) -> Vec<Candidate> {
    let mut ranked: Vec<_> = board.found.hypotheses.iter().filter(|r| r.ln_bayes > STRONG).collect();
    ranked.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let mut best: Vec<Candidate> = Vec::new();
    for r in ranked {
        let Tried::Effect(c) = &r.tried else { continue };
        let is_known = best.iter().any(|k| k.effect.name() == c.effect.name());
        if best.len() < board.stage.effort().polished && !is_known {
            best.push(c.clone());
        }
    }
    best
}

/// Fits an effect at further places about one.
fn look_about(board: &mut Board<'_>, centre: &Candidate, round: u32) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let placed = stage.finer_candidates(centre, round);
    if placed.is_empty() {
        return Ok(());
    }
    let found = board.found.hypotheses.iter().find(|r| matches!(&r.tried, Tried::Effect(c) if c.id() == centre.id()));
    let bases: Vec<_> = found.map(|r| board.base_of(r)).into_iter().collect();
    let finer: Stage = stage.on_wider(placed)?;
    let near: Vec<&Score> = finer.effects.iter().take(stage.effort().near).collect();
    let near = if near.len() > stage.effort().around { shortest(&finer, &near, &bases) } else { near };
    let jobs: Vec<Job<'_>> = near.into_iter().take(stage.effort().around).map(|s| Job::Effect(s, &bases)).collect();
    let found = run(&finer, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
