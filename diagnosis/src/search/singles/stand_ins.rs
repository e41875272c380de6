//! The best on stand-ins of their own.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::run::on_its_own_stand_ins;
use crate::thresholds::STRONG;

pub(super) const STEP: Step = Step { name: "the best on stand-ins of their own", when: is_on_stand_ins, take };

fn is_on_stand_ins(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(board.stage.scene.is_large() && is_worth_more(board)?)
}

/// Fits the best once more where a stand-in is made for its sizes: the one that it was found on is made for all that may be wrong, and a large change
/// of many dofs moves as few of its coordinates do. What is told of them is as near to the model as it can be.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let (stage, ln_base) = (board.stage, board.ln_base);
    let least = board.best().map_or(f64::INFINITY, |r| r.ln_bayes - STRONG).max(STRONG);
    let mut tied: Vec<_> = board.found.hypotheses.iter_mut().filter(|r| r.ln_bayes > least).collect();
    tied.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    for r in tied.into_iter().take(stage.effort().checked) {
        if stage.may_fit()
            && let Ok(found) = on_its_own_stand_ins(stage, r, ln_base)
        {
            *r = found;
        }
    }
    Ok(())
}
