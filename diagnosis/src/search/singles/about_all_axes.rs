//! What acts about one axis and explains much about all axes of its place, and about those of the structure; nodes that are moved, without those inside of
//! their members.

use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::screen::effects::Score;
use crate::screen::stage::Stage;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use crate::thresholds::STRONG;
use retune::effect::{Candidate, Location};

pub(super) const STEP: Step = Step { name: "about all axes", when: is_worth_more, take };

/// Fits what acts about one axis and explains much about all of its place.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let found = in_all_axes(board.stage, &board.found.hypotheses, board.ln_base);
    board.add(found);
    Ok(())
}

/// Effects along or about one axis that explain much, in all axes of their node or end and about those of the structure; what could stand with the best. A body that lacks
/// inertia about two axes is no better explained about one of them than by something else.
///
/// * `base` - ln evidence of the base
fn in_all_axes(stage: &Stage, done: &[Refit], base: f64) -> Vec<Refit> {
    let mut best: Vec<(&Refit, &Candidate)> = done
        .iter()
        .filter_map(|r| match &r.tried {
            Tried::Effect(c) => Some((r, c)),
            Tried::Fault(_) => None,
        })
        .collect();
    best.sort_by(|a, b| b.0.ln_bayes.total_cmp(&a.0.ln_bayes));
    let least = done.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max) - STRONG;
    let is_about_others = |wide: &Location, own: &Location| {
        wide.has_more_axes_than(own) || wide.is_skew_to(own) || wide.is_without_those_inside(own)
    };
    let near: Vec<String> = best.iter().flat_map(|(_, c)| c.location.names.clone()).collect();
    // The rank of the best that has one of its axes.
    let rank = |wide: &Candidate| {
        let has = |c: &Candidate| c.effect.name() == wide.effect.name() && is_about_others(&wide.location, &c.location);
        best.iter().position(|(_, c)| has(c))
    };
    let mut wanted = stage.wider_candidates(Some(&near), |c| rank(c).is_some());
    wanted.sort_by_key(rank);
    wanted.truncate(stage.effort().with_all_axes);
    let Ok(wider) = stage.on_wider(wanted) else { return Vec::new() };
    let n = stage.fit.x.len();
    let base_of =
        |s: &Score| rank(&wider.screened[s.index].candidate).map(|k| [best[k].0.fit.x.rows(0, n).into_owned()]);
    let bases: Vec<_> = wider.effects.iter().filter_map(|s| Some((s, base_of(s)?))).collect();
    let jobs: Vec<Job<'_>> = bases.iter().map(|(s, bases)| Job::Effect(s, bases)).collect();
    let mut tried = run(&wider, &jobs, base);
    tried.retain(|r| r.ln_bayes > least);
    tried
}
