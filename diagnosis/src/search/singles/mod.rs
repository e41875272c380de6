//! The search for one cause: full fits of the best hypotheses, base parameters and size together, step by step. A step is a file and a line of
//! [`SEARCH`].

mod about_all_axes;
mod beyond_the_place;
mod chosen;
mod every_other;
mod every_part;
mod extended;
mod finer_mesh;
mod grown;
mod like_the_best;
mod limits;
mod looked;
mod other_basins;
mod other_kinds;
mod screened;
mod stand_ins;
mod step;
mod ties;
mod with_more_sizes;

use super::board::{Board, Refits};
use super::hypothesis::Refit;
use super::nested::leave_out_wider;
use super::run::refit_begun;
use crate::error::DiagnosisError;
use crate::screen::stage::Stage;
use step::Step;

/// The search for one cause, step by step.
///
/// First-order scores mislead where an effect is large or the base has been pulled far. So every effect is looked at in several sizes, and where
/// none of the best leaves noise, those that this and the scores put first are fitted with a few steps, and the best of those in full, with the
/// best of every kind. What is like the best, in kind or place, is fitted once more from where the best has brought the base; what leaves nearly
/// its trace is fitted too, so that ties are complete.
const SEARCH: &[Step] = &[
    screened::STEP,
    looked::STEP,
    every_part::STEP,
    every_other::STEP,
    extended::STEP,
    with_more_sizes::STEP,
    like_the_best::STEP,
    beyond_the_place::STEP,
    finer_mesh::STEP,
    other_kinds::STEP,
    grown::STEP,
    about_all_axes::STEP,
    limits::STEP,
    other_basins::STEP,
    ties::STEP,
    stand_ins::STEP,
];

/// Searches a stage; what cannot be fitted is left out.
///
/// * `few` - the best of the screening alone, and fewer of them
pub(crate) fn refit(stage: &Stage, few: bool) -> Result<Refits, DiagnosisError> {
    let mut board = Board::new(stage, if few { stage.effort().best / 2 } else { stage.effort().best }, few)?;
    take_steps(&mut board, SEARCH)?;
    Ok(sorted(board))
}

/// What a search found, fitted from there at another level of noise, and the best of the screening beside it: other noise puts the same hypotheses
/// first.
///
/// * `before` - what was found at the same base
pub(crate) fn weighed_anew(stage: &Stage, before: &Refits) -> Result<Refits, DiagnosisError> {
    let mut board = Board::new(stage, stage.effort().best, false)?;
    let mut known: Vec<&Refit> = before.hypotheses.iter().collect();
    known.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    known.truncate(KNOWN * stage.effort().best);
    let known: Vec<_> = known.into_iter().map(|r| (&r.tried, Some(r.fit.x.clone()))).collect();
    board.add(refit_begun(stage, &known, &[])?);
    take_steps(&mut board, &[screened::STEP, every_part::STEP])?;
    Ok(sorted(board))
}

/// Takes the steps that are worth it.
fn take_steps(board: &mut Board<'_>, steps: &[Step]) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    for step in steps {
        if !stage.settings.until.is_over() && (step.when)(board)? {
            let before = board.work();
            (step.take)(board)?;
            stage.settings.listener.took(&board.told(step.name, before));
        }
    }
    Ok(())
}

/// How many times as many hypotheses as are fitted at first are fitted once more at other noise.
const KNOWN: usize = 4;

/// The hypotheses by evidence, without those that say the same as others with more numbers.
fn sorted(board: Board<'_>) -> Refits {
    let (stage, mut done) = (board.stage, board.found);
    leave_out_wider(stage, &mut done.hypotheses);
    done.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    done
}
