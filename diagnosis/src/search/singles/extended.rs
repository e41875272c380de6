//! Effects at extended places: what is changed need not end where an element does.

use super::step::{Step, is_poor, is_poor_and_unexplained};
use crate::error::DiagnosisError;
use crate::screen::effects::Score;
use crate::screen::stage::{Stage, in_turns};
use crate::search::board::Board;
use crate::search::hypothesis::Refit;
use crate::search::look::by_size;
use crate::search::run::{Job, best_and_of_every_kind, run};
use crate::search::short_fit::shortest;
use crate::search::spread::Fitted;
use retune::effect::{Candidate, Context, Structure};

pub(super) const STEP: Step = Step { name: "extended places", when: is_worth_a_look, take };

/// On what stands in for a large model slopes of all places cost little, so that these are looked at whatever has been found; on a model itself each
/// takes evaluations.
fn is_worth_a_look(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(is_poor(board)? && (board.stage.scene.is_large() || may_explain(board)?))
}

/// Fits effects at extended places: those that leave least at one of their sizes, and where nothing leaves noise yet those that a few steps put
/// first.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    // On a mesh of very many dofs, where every change takes solutions of its own, larger patches and all axes of a node are left to the steps that look
    // about the best of their kind; and so are nodes that are moved otherwise.
    let is_huge = stage.scene.is_huge();
    let is_wanted = |c: &Candidate| {
        let is_left =
            || c.location.has_all_axes() || c.location.names.iter().any(|name| Structure::is_patch_name(name));
        !(c.location.leaves_those_inside() || is_huge && is_left())
    };
    let Ok(wider) = stage.on_wider(stage.wider_candidates(None, is_wanted)) else { return Ok(()) };
    let by_size = by_size(&wider);
    // On a model itself it would not have come here else.
    let best: Vec<&Score> = if !stage.scene.is_large() || may_explain(board)? {
        let mut all = in_turns(&wider.effects, by_size);
        all.truncate(stage.effort().near);
        best_and_of_every_kind(&wider, shortest(&wider, &all, &board.bases), board.most)
    } else {
        by_size.into_iter().take(board.most).collect()
    };
    let jobs: Vec<Job<'_>> = best.into_iter().map(|s| Job::Effect(s, &board.bases)).collect();
    let found = run(&wider, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}

/// Whether nothing leaves noise yet and something at a wider place may.
fn may_explain(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    let has_places_inside = || Structure::new(board.stage.scene.model(), Context::nothing()).has_places_inside();
    let may = || may_be_wider(board.stage, &board.found.spreads, &board.found.hypotheses) || has_places_inside();
    Ok(is_poor_and_unexplained(board)? && may())
}

/// Whether something at a wider place could explain more than the best so far: about what the spreads do, which have every span
/// among them, but for what lies inside of an element; without spreads that is not known. What needs a mode that the test has missed does not count.
fn may_be_wider(stage: &Stage, spreads: &[Fitted], done: &[Refit]) -> bool {
    let Some(least) = spreads.iter().map(|s| s.spread.misfit).min_by(f64::total_cmp) else { return true };
    let most = 0.5 * stage.weight * stage.weight * (stage.fit.misfit - least);
    done.iter().filter(|r| r.missed == 0).all(|r| r.ln_bayes < most)
}
