//! The best effects at places between those that every search tries, of a mesh or of a long line of beams.

use super::step::{Step, is_unexplained, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::short_fit::the_best_of;
use crate::thresholds::STRONG;
use retune::effect::{Candidate, Structure};
use retune::linalg::DVector;
use retune::model::PlacedElement;
use std::collections::BTreeMap;

/// Of the evidence of the best, what another kind needs at its best place so far to be looked about.
const SHARE: f64 = 0.5;
/// How often places are looked at nearer by: a ninth as far as at first is a few elements.
const NEAREST: u32 = 2;

pub(super) const STEP: Step = Step { name: "between the places", when: has_places_between, take };

pub(super) fn has_a_mesh(board: &Board<'_>) -> bool {
    let mut models = board.stage.scene.cases.iter().map(|case| &case.model);
    models.any(|m| m.elements().iter().any(PlacedElement::is_of_mesh))
}

fn has_places_between(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    let has_long_lines = || board.stage.structures().iter().any(Structure::has_long_lines);
    Ok(is_worth_more(board)? && has_a_mesh(board) || is_unexplained(board)? && has_long_lines())
}

/// Looks about the best few effects, nearer with every round; of each until a near look finds nothing better.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let structures = stage.structures();
    let mut levels: BTreeMap<&str, Option<u32>> = BTreeMap::new();
    for _ in 0..stage.effort().finer_rounds {
        let mut has_looked = false;
        for (centre, base) in of_each_kind(board, stage.effort().finer_kinds) {
            let effect = centre.effect.name();
            let level = levels.entry(effect).or_insert(Some(0));
            let Some(now) = *level else { continue };
            let placed = stage.finer_candidates(&structures, &centre, now);
            if placed.is_empty() {
                *level = None;
                continue;
            }
            has_looked = true;
            let before = best_of(board, effect);
            let found = the_best_of(&stage.on_wider(placed)?, &[base], board.ln_base);
            board.add(found);
            // At the nearest it goes on from node to node, downhill.
            *level = match (now < NEAREST, best_of(board, effect) > before) {
                (true, _) => Some(now + 1),
                (false, true) => Some(now),
                (false, false) => None,
            };
        }
        if !has_looked {
            break;
        }
    }
    Ok(())
}

/// The largest evidence of an effect anywhere.
fn best_of(board: &Board<'_>, effect: &str) -> f64 {
    let of = |r: &&Refit| matches!(&r.tried, Tried::Effect(c) if c.effect.name() == effect);
    board.found.hypotheses.iter().filter(of).map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max)
}

/// The best place of each of the best few effects that have one, where it explains much, and where it has brought the base.
pub(super) fn of_each_kind(board: &Board<'_>, most: usize) -> Vec<(Candidate, DVector<f64>)> {
    let least = board.best().map_or(STRONG, |r| STRONG.max(SHARE * r.ln_bayes));
    let mut ranked: Vec<_> = board.found.hypotheses.iter().filter(|r| r.ln_bayes > least).collect();
    ranked.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let mut best: Vec<(Candidate, DVector<f64>)> = Vec::new();
    for r in ranked {
        let Tried::Effect(c) = &r.tried else { continue };
        // What is sought elsewhere acts along one axis: all axes of the place that it leads to are tried after it.
        if c.location.has_all_axes() {
            continue;
        }
        let is_known = best.iter().any(|(k, _)| k.effect.name() == c.effect.name());
        if best.len() < most && !is_known {
            best.push((c.clone(), board.base_of(r)));
        }
    }
    best
}
