//! Hypotheses that have others as special cases.

use super::hypothesis::{Refit, Tried};
use crate::problem::evidence::degrees_of_freedom;
use crate::screen::stage::Stage;
use crate::thresholds::STRONG;
use retune::fault::{Number, PlacedFault};

/// Leaves out what another hypothesis says more simply and about as well: a body on a stiff spring that is a point mass, a sensor of large
/// noise that is upside down. The simpler one keeps the id of what explains the test nearly as well.
///
/// Where the simpler one leaves c times what noise gives, because something else is missing too, the wider one may be better by
/// 3 (c - 1) in ln B only by taking over some of that.
pub(crate) fn leave_out_wider(stage: &Stage, done: &mut Vec<Refit>) {
    let noise = degrees_of_freedom(&stage.fit, &stage.q).max(1.0) / stage.weight.powi(2);
    let room = |r: &Refit| STRONG * (r.misfit / noise - 1.0).max(0.0);
    let says_the_same = |wide: &Refit, simple: &Refit| {
        // Of two ways to say one thing the more probable one stands.
        if are_two_ways(&wide.tried, &simple.tried) {
            return (simple.ln_bayes, wide.id(&stage.scene)) > (wide.ln_bayes, simple.id(&stage.scene));
        }
        let is_plainer = says_plainly(wide, simple);
        let room = room(simple) + if is_plainer { STRONG } else { 0.0 };
        simple.ln_bayes + room > wide.ln_bayes && (is_plainer || is_wider(&wide.tried, &simple.tried))
    };
    let (wide, mut simple): (Vec<Refit>, Vec<Refit>) = {
        let is_wide: Vec<bool> = done.iter().map(|r| done.iter().any(|other| says_the_same(r, other))).collect();
        let mut is_wide = is_wide.into_iter();
        done.drain(..).partition(|_| is_wide.next().unwrap_or(false))
    };
    for r in &mut simple {
        let as_good = wide.iter().filter(|w| w.ln_bayes > r.ln_bayes - STRONG && says_the_same(w, r));
        r.limit_of = as_good.map(|w| w.id(&stage.scene)).collect();
    }
    *done = simple;
}

/// Whether another hypothesis is what one is at its sizes, in plainer words: a member of which half is lost is softer, and not absent.
fn says_plainly(one: &Refit, other: &Refit) -> bool {
    let (Tried::Effect(a), Tried::Effect(b)) = (&one.tried, &other.tried) else { return false };
    let intervals: Vec<[f64; 2]> = one.estimates.iter().map(|e| e.interval).collect();
    (&a.location.names, &a.location.configuration) == (&b.location.names, &b.location.configuration)
        && a.effect.plainly(&intervals) == Some(b.effect.name())
}

/// Whether each of two has the other as a special case: a density and a mass per length, which differ in the rotary inertia of sections.
fn are_two_ways(one: &Tried, other: &Tried) -> bool {
    is_wider(one, other) && is_wider(other, one)
}

/// Whether a hypothesis has another as a special case.
fn is_wider(tried: &Tried, other: &Tried) -> bool {
    match (tried, other) {
        (Tried::Effect(a), Tried::Effect(b)) => {
            let same_place =
                (&a.location.names, &a.location.configuration) == (&b.location.names, &b.location.configuration);
            let is_same_kind = a.effect.name() == b.effect.name();
            a.effect.becomes().contains(&b.effect.name()) && same_place
                || is_same_kind && a.location.has_more_axes_than(&b.location)
        }
        (Tried::Fault(a), Tried::Fault(b)) => {
            let is_noise = |f: &PlacedFault| f.number() == Number::Scatter;
            is_noise(a) && !is_noise(b) && a.only == b.only && b.is_of_channel(a.at.sensor())
        }
        _ => false,
    }
}
