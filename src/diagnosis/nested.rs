//! Hypotheses that have others as special cases.

use super::base::Stage;
use super::evidence::degrees_of_freedom;
use super::faults::Change;
use super::refit::{Refit, Tried};
use super::verdict::STRONG;

/// Leaves out what another hypothesis says more simply and about as well: a body on a stiff spring that is a point mass, a sensor of large
/// noise that is upside down.
///
/// Where the simpler one leaves c times what noise gives, because something else is missing too, the wider one may be better by
/// 3 (c - 1) in ln B only by taking over some of that.
pub(super) fn leave_out_wider(stage: &Stage, done: &mut Vec<Refit>) {
    let noise = degrees_of_freedom(&stage.fit, &stage.q).max(1.0) / stage.weight.powi(2);
    let room = |r: &Refit| STRONG * (r.misfit / noise - 1.0).max(0.0);
    let all: Vec<(Tried, f64)> = done.iter().map(|r| (r.tried.clone(), r.ln_bayes + room(r))).collect();
    done.retain(|r| !all.iter().any(|(other, as_good)| *as_good > r.ln_bayes && is_wider(&r.tried, other)));
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
            a.change == Change::Noisy && b.change != Change::Noisy && a.only == b.only && b.is_of_sensor(a.sensor)
        }
        _ => false,
    }
}
