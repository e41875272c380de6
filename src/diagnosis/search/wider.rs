//! Places that are wider than those of the file: what is changed need not end where an element does, a joint that gives about one
//! axis of bending may give about the other, and a body that lacks inertia about one axis may lack it about all.
//!
//! They are tried where nothing at the places of the file leaves noise, and around the element or member that explains the test best; their
//! odds are smaller, so what is simpler stands where the data do not ask for more.

use super::hypothesis::{Refit, Tried};
use super::run::{Job, best_and_of_every_kind, run};
use super::short_fit::shortest;
use super::spread::Fitted;
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::diagnosis::thresholds::STRONG;
use crate::effect::{Candidate, LocationKind};
use crate::linalg::DVector;

/// Whether something at a wider place could explain more than the best so far: about what the spreads do, which have every span
/// among them. What needs a mode that the test has missed does not count.
pub(crate) fn may_be_wider(stage: &Stage, spreads: &[Fitted], done: &[Refit]) -> bool {
    let least = spreads.iter().map(|s| s.spread.misfit).fold(f64::INFINITY, f64::min);
    let most = 0.5 * stage.weight * stage.weight * (stage.fit.misfit - least);
    done.iter().filter(|r| r.missed == 0).all(|r| r.ln_bayes < most)
}

/// Refits the best effects at wider places.
///
/// * `base` - ln evidence of the base
pub(crate) fn on_wider_places(stage: &Stage, bases: &[DVector<f64>], limit: usize, base: f64) -> Vec<Refit> {
    let Ok(wider) = stage.on_wider(stage.wider_candidates(None, |_| true)) else { return Vec::new() };
    let all: Vec<&Score> = wider.effects.iter().take(stage.effort().near).collect();
    let best = best_and_of_every_kind(&wider, shortest(&wider, &all, bases), limit);
    let jobs: Vec<Job<'_>> = best.into_iter().map(|s| Job::Effect(s, bases)).collect();
    run(&wider, &jobs, base)
}

/// What explains the test best on more than its own place: an effect at an element or a member on the elements around it or some of it too,
/// where it explains more there.
///
/// * `base` - ln evidence of the base
pub(crate) fn beyond_the_best(stage: &Stage, done: &[Refit], base: f64) -> Vec<Refit> {
    let Some(best) = done.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) else { return Vec::new() };
    let Tried::Effect(found) = &best.tried else { return Vec::new() };
    let there = &found.location;
    if best.ln_bayes < STRONG || !matches!(there.kind, LocationKind::Element | LocationKind::Chain) {
        return Vec::new();
    }
    let is_like = |c: &Candidate| {
        let at = &c.location;
        c.effect.name() == found.effect.name()
            && (at.direction(), &at.configuration, at.names.len())
                == (there.direction(), &there.configuration, there.names.len())
    };
    let Ok(wider) = stage.on_wider(stage.wider_candidates(Some(&there.names), is_like)) else { return Vec::new() };
    let bases = [best.fit.x.rows(0, stage.fit.x.len()).into_owned()];
    let like: Vec<&Score> = wider.effects.iter().take(stage.effort().near).collect();
    let like = if like.len() > stage.effort().around { shortest(&wider, &like, &bases) } else { like };
    let jobs: Vec<Job<'_>> = like.into_iter().take(stage.effort().around).map(|s| Job::Effect(s, &bases)).collect();
    let mut tried = run(&wider, &jobs, base);
    tried.retain(|r| r.ln_bayes > best.ln_bayes);
    tried
}

/// Effects along or about one axis that explain much, in all axes of their node or end; what could stand with the best. A body that lacks
/// inertia about two axes is no better explained about one of them than by something else.
///
/// * `base` - ln evidence of the base
pub(crate) fn in_all_axes(stage: &Stage, done: &[Refit], base: f64) -> Vec<Refit> {
    let mut best: Vec<(&Refit, &Candidate)> = done
        .iter()
        .filter_map(|r| match &r.tried {
            Tried::Effect(c) => Some((r, c)),
            Tried::Fault(_) => None,
        })
        .collect();
    best.sort_by(|a, b| b.0.ln_bayes.total_cmp(&a.0.ln_bayes));
    let least = done.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max) - STRONG;
    let near: Vec<String> = best.iter().flat_map(|(_, c)| c.location.names.clone()).collect();
    // The rank of the best that has one of its axes.
    let rank = |wide: &Candidate| {
        let has =
            |c: &Candidate| c.effect.name() == wide.effect.name() && wide.location.has_more_axes_than(&c.location);
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
