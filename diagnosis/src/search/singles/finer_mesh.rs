//! The best effects at places of a mesh between those that every search tries.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::hypothesis::Tried;
use crate::search::short_fit::the_best_of;
use crate::thresholds::STRONG;
use retune::effect::Candidate;
use retune::linalg::DVector;
use retune::model::PlacedElement;

pub(super) const STEP: Step = Step { name: "between the places of a mesh", when: has_a_mesh, take };

fn has_a_mesh(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    let mut models = board.stage.scene.cases.iter().map(|case| &case.model);
    Ok(models.any(|m| m.elements().iter().any(PlacedElement::is_of_mesh)) && is_worth_more(board)?)
}

/// Looks about the best few effects at places of a mesh, nearer with every round, until nothing better comes.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let structures = stage.structures();
    for round in 0..stage.effort().rounds {
        let before = board.best().map_or(0.0, |r| r.ln_bayes);
        for (centre, base) in of_each_kind(board) {
            let placed = stage.finer_candidates(&structures, &centre, round as u32);
            if !placed.is_empty() {
                let found = the_best_of(&stage.on_wider(placed)?, &[base], board.ln_base);
                board.add(found);
            }
        }
        if round > 0 && board.best().is_none_or(|r| r.ln_bayes <= before) {
            break;
        }
    }
    Ok(())
}

/// The best place of each of the best few effects that have one, where it explains much, and where it has brought the base.
fn of_each_kind(board: &Board<'_>) -> Vec<(Candidate, DVector<f64>)> {
    let mut ranked: Vec<_> = board.found.hypotheses.iter().filter(|r| r.ln_bayes > STRONG).collect();
    ranked.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let mut best: Vec<(Candidate, DVector<f64>)> = Vec::new();
    for r in ranked {
        let Tried::Effect(c) = &r.tried else { continue };
        // What is sought elsewhere acts along one axis: all axes of the place that it leads to are tried after it.
        if c.location.has_all_axes() {
            continue;
        }
        let is_known = best.iter().any(|(k, _)| k.effect.name() == c.effect.name());
        if best.len() < board.stage.effort().polished && !is_known {
            best.push((c.clone(), board.base_of(r)));
        }
    }
    best
}
