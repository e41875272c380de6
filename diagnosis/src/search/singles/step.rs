//! A step of the search, and when one is worth taking.

use crate::error::DiagnosisError;
use crate::search::board::Board;
use crate::thresholds::STRONG;

/// A step of the search for one cause.
pub(crate) struct Step {
    /// What it does, as a trace tells it.
    pub(super) name: &'static str,
    /// Whether it is worth taking with what has been found.
    pub(super) when: fn(&Board<'_>) -> Result<bool, DiagnosisError>,
    /// Finds more.
    pub(super) take: fn(&mut Board<'_>) -> Result<(), DiagnosisError>,
}

#[expect(clippy::unnecessary_wraps, reason = "as the other conditions")]
pub(super) fn always(_: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(true)
}

/// The base leaves more than noise, or something is strong.
#[expect(clippy::unnecessary_wraps, reason = "as the other conditions")]
pub(super) fn is_worth_more(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(!board.few && (board.is_poor() || board.best().is_some_and(|r| r.ln_bayes > STRONG)))
}

/// Something is strong.
#[expect(clippy::unnecessary_wraps, reason = "as the other conditions")]
pub(super) fn has_strong(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(board.best().is_some_and(|r| r.ln_bayes > STRONG))
}

/// The base leaves more than noise.
#[expect(clippy::unnecessary_wraps, reason = "as the other conditions")]
pub(super) fn is_poor(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(!board.few && board.is_poor())
}

pub(super) fn is_unexplained(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(is_worth_more(board)? && !board.leaves_noise()?)
}

pub(super) fn is_poor_and_unexplained(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(board.is_poor() && is_unexplained(board)?)
}
