//! A change of every part.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::search::spread::spreads;
use retune::linalg::DVector;

pub(super) const STEP: Step = Step { name: "every part a little", when: is_worth_more, take };

/// Fits a change of every part. It can follow most changes of a structure, and brings the base near its truth.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let best: Vec<DVector<f64>> =
        board.found.hypotheses.iter().take(board.stage.effort().spread_from).map(|r| board.base_of(r)).collect();
    board.found.spreads = spreads(board.stage, &[board.bases.clone(), best].concat())?;
    Ok(())
}
