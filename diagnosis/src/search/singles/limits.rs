//! What the best effects become at a limit of their sizes: a point mass where a mass on an arm or on a stiff spring leads.

use super::step::{Step, has_strong};
use crate::error::DiagnosisError;
use crate::screen::effects::Score;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use crate::thresholds::STRONG;
use retune::effect::{Candidate, NewParameter};
use retune::linalg::DVector;

pub(super) const STEP: Step = Step { name: "the best at a limit of its sizes", when: has_strong, take };

/// Fits the limits of what is as good as the best, at the same places, from where that has brought the base.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let least = board.best().map_or(f64::INFINITY, |r| r.ln_bayes - STRONG).max(STRONG);
    // One that has been found but explains less may have ended in another basin.
    let is_known = |c: &Candidate, than: f64| {
        board.found.hypotheses.iter().any(|r| r.ln_bayes > than && r.id(&stage.scene) == c.id())
    };
    let mut limits: Vec<(Candidate, &Refit, DVector<f64>)> = Vec::new();
    for r in board.found.hypotheses.iter().filter(|r| r.ln_bayes > least) {
        let Tried::Effect(found) = &r.tried else { continue };
        if found.effect.becomes().is_empty() {
            continue;
        }
        let is_new = |c: &Candidate| !is_known(c, r.ln_bayes) && !limits.iter().any(|(l, ..)| l.id() == c.id());
        let new: Vec<Candidate> = stage.limit_candidates(found).into_iter().filter(is_new).collect();
        limits.extend(new.into_iter().map(|c| {
            let start = of_the_same_sizes(&board.base_of(r), r, found, &c);
            (c, r, start)
        }));
    }
    if limits.is_empty() {
        return Ok(());
    }
    let there = stage.on_wider(limits.iter().map(|(c, ..)| c.clone()).collect())?;
    let of = |s: &Score| {
        let (_, r, start) = limits.iter().find(|(c, ..)| c.id() == there.id(s))?;
        Some(([board.base_of(r)], start))
    };
    let begun: Vec<_> = there.effects.iter().filter_map(|s| Some((s, of(s)?))).collect();
    let jobs: Vec<Job<'_>> = begun.iter().map(|(s, (bases, start))| Job::Begun(s, bases, start)).collect();
    let found: Vec<Refit> = run(&there, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}

/// Where a limit of an effect begins: at the sizes that have been found of the same quantities, a mass for a mass.
///
/// * `base` - where that has brought the base
fn of_the_same_sizes(base: &DVector<f64>, r: &Refit, found: &Candidate, limit: &Candidate) -> DVector<f64> {
    let quantity = |p: &NewParameter| p.name.rsplit('.').next().map(str::to_string);
    let size = |p: &NewParameter| {
        let sizes = found.parameters.iter().zip(r.fit.x.iter().skip(base.len()));
        let same = sizes.filter(|(q, _)| quantity(q) == quantity(p));
        let mut values = same.map(|(q, x)| q.at(*x));
        let value = values.next().unwrap_or(p.typical).clamp(p.bounds[0], p.bounds[1]);
        p.in_box(value)
    };
    let sizes: Vec<f64> = limit.parameters.iter().map(size).collect();
    DVector::from_iterator(base.len() + sizes.len(), base.iter().copied().chain(sizes))
}
