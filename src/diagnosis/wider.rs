//! Places that are wider than those of the file: what is changed need not end where an element does, a joint that gives about one
//! axis of bending may give about the other, and a body that lacks inertia about one axis may lack it about all.
//!
//! They are tried where nothing at the places of the file leaves noise, and around the element or member that explains the test best; their
//! odds are smaller, so what is simpler stands where the data do not ask for more.

use super::base::Stage;
use super::refit::{Job, NEAR, Refit, Tried, best_and_of_every_kind, run};
use super::screen::Score;
use super::short_fit::shortest;
use super::spread::Fitted;
use super::verdict::STRONG;
use crate::effect::{Location, LocationKind};
use crate::linalg::DVector;

/// Wider places around the best that are refitted in full.
const AROUND: usize = 9;

/// Whether something at a wider place could explain more than the best so far: about what the spreads do, which have every span
/// among them. What needs a mode that the test has overlooked does not count.
pub(super) fn may_be_wider(stage: &Stage, spreads: &[Fitted], done: &[Refit]) -> bool {
    let least = spreads.iter().map(|s| s.spread.misfit).fold(f64::INFINITY, f64::min);
    let most = 0.5 * stage.weight * stage.weight * (stage.fit.misfit - least);
    done.iter().filter(|r| r.overlooked == 0).all(|r| r.ln_bayes < most)
}

/// Refits the best effects at wider places.
///
/// * `base` - ln evidence of the base
pub(super) fn on_wider_places(stage: &Stage, bases: &[DVector<f64>], limit: usize, base: f64) -> Vec<Refit> {
    let wider = stage.on_wider(stage.wider_candidates(None, |_| true));
    let all: Vec<&Score> = wider.effects.iter().take(NEAR).collect();
    let best = best_and_of_every_kind(&wider, shortest(&wider, &all, bases), limit);
    let jobs: Vec<Job<'_>> = best.into_iter().map(|s| Job::Effect(s, bases)).collect();
    run(&wider, &jobs, base)
}

/// What explains the test best on more than its own place, where it explains more there: an effect at an element or a member on the elements
/// around it or some of it too, one along or about an axis, and what is tied with it, in all axes.
///
/// * `base` - ln evidence of the base
pub(super) fn beyond_the_best(stage: &Stage, done: &[Refit], base: f64) -> Vec<Refit> {
    let Some(best) = done.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) else { return Vec::new() };
    if best.ln_bayes < STRONG {
        return Vec::new();
    }
    let mut found = Vec::new();
    for r in done.iter().filter(|r| r.ln_bayes > best.ln_bayes - STRONG) {
        let Tried::Effect(of) = &r.tried else { continue };
        let is_best = of.id() == best.id(&stage.scene);
        let is_wider = |at: &Location| match of.location.kind {
            LocationKind::Element | LocationKind::Chain => is_best && has_the_same_axis(at, &of.location),
            _ => at.has_more_axes_than(&of.location),
        };
        let wider = stage.on_wider(stage.wider_candidates(Some(&of.location.names), |c| {
            c.effect.name() == of.effect.name() && is_wider(&c.location)
        }));
        let bases = [r.fit.x.rows(0, stage.fit.x.len()).into_owned()];
        let like: Vec<&Score> = wider.effects.iter().take(NEAR).collect();
        let like = if like.len() > AROUND { shortest(&wider, &like, &bases) } else { like };
        let jobs: Vec<Job<'_>> = like.into_iter().take(AROUND).map(|s| Job::Effect(s, &bases)).collect();
        found.extend(run(&wider, &jobs, base));
    }
    found.retain(|r| r.ln_bayes > best.ln_bayes);
    found
}

/// Whether two locations have as many names, in one configuration, and one direction.
fn has_the_same_axis(at: &Location, there: &Location) -> bool {
    (at.direction(), &at.configuration, at.names.len())
        == (there.direction(), &there.configuration, there.names.len())
}
