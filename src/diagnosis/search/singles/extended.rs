//! Effects at extended places: what is changed need not end where an element does.

use super::step::{Step, is_poor_and_unexplained};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::diagnosis::search::board::Board;
use crate::diagnosis::search::hypothesis::Refit;
use crate::diagnosis::search::run::{Job, best_and_of_every_kind, run};
use crate::diagnosis::search::short_fit::shortest;
use crate::diagnosis::search::spread::Fitted;
use crate::effect::{Context, Structure};
use crate::linalg::DVector;

pub(super) const STEP: Step = Step { name: "extended places", when: may_explain, take };

/// Fits effects at extended places.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let found = on_wider_places(board.stage, &board.bases, board.most, board.ln_base);
    board.add(found);
    Ok(())
}

fn may_explain(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    let has_places_inside = || {
        let context = Context::default();
        Structure::new(board.stage.scene.model(), &context).has_places_inside()
    };
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

/// Refits the best effects at wider places.
///
/// * `base` - ln evidence of the base
fn on_wider_places(stage: &Stage, bases: &[DVector<f64>], limit: usize, base: f64) -> Vec<Refit> {
    let Ok(wider) = stage.on_wider(stage.wider_candidates(None, |_| true)) else { return Vec::new() };
    let all: Vec<&Score> = wider.effects.iter().take(stage.effort().near).collect();
    let best = best_and_of_every_kind(&wider, shortest(&wider, &all, bases), limit);
    let jobs: Vec<Job<'_>> = best.into_iter().map(|s| Job::Effect(s, bases)).collect();
    run(&wider, &jobs, base)
}
