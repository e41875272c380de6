//! The best on stand-ins of their own.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::hypothesis::Refit;
use crate::search::run::on_its_own_stand_ins;
use crate::thresholds::STRONG;

pub(super) const STEP: Step = Step { name: "the best on stand-ins of their own", when: is_on_stand_ins, take };

fn is_on_stand_ins(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(board.stage.scene.is_large() && is_worth_more(board)?)
}

/// Fits the best once more where a stand-in is made for its sizes: the one that it was found on has not all forces that a change of many dofs exerts,
/// and where that is large, an open clamp say, it is stiffer than the model.#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let (stage, ln_base) = (board.stage, board.ln_base);
    let least = board.best().map_or(f64::INFINITY, |r| r.ln_bayes - STRONG).max(STRONG);
    let is_poor = |r: &Refit| {
        let mut stand_ins = r.scene.cases.iter().filter_map(|case| case.stand_in.as_ref());
        stand_ins.any(|stand_in| !stand_in.is_exact_in_statics())
    };
    let mut tied: Vec<_> = board.found.hypotheses.iter_mut().filter(|r| r.ln_bayes > least && is_poor(r)).collect();
    tied.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    // The next to be screened is a stage on top of this one.
    stage.answers.forget();
    // On a large mesh a stand-in takes ten seconds: only that which the remainder is looked at on as well.
    for r in tied.into_iter().take(if stage.scene.is_huge() { 1 } else { stage.effort().checked }) {
        if stage.may_fit()
            && let Ok(found) = on_its_own_stand_ins(stage, r, ln_base)
        {
            *r = found;
        }
    }
    Ok(())
}
