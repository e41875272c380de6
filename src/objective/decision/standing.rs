//! What comes out for every mode, and why a mode has no partner.

use super::gates::{Told, probability};
use super::{FoundSide, Inference, Side};
use crate::correlation::Label;
use crate::data::Standing;

/// The probability of what has these ln odds.
fn logistic(ln_odds: f64) -> f64 {
    1.0 / (1.0 + (-ln_odds).exp())
}

impl Inference<'_> {
    /// The standing of every mode of a test.
    pub(super) fn standings(&self, side: &Side<'_>, at: &FoundSide, is_fixed: bool) -> Vec<Standing> {
        let c = side.comparison;
        let modes = &c.test().modes;
        let p = &at.look.prediction;
        let mut out: Vec<Standing> = modes.iter().map(|m| m.standing.clone()).collect();
        // What shapes and the user take: a mode without a shape is counted among the rest.
        let by_shape: Vec<usize> = (0..side.open.len())
            .filter(|&row| modes[side.open[row]].shape.is_some() || side.given[row].is_some())
            .filter_map(|row| at.pairs[row].map(|(a, _)| at.look.modes[a]))
            .collect();
        for (row, &i) in side.open.iter().enumerate() {
            let foreign = at.foreign(row);
            let partner = at.pairs[row].map(|(a, _)| a).filter(|_| side.given[row].is_some() || foreign < 0.5);
            out[i] = match partner {
                Some(at_a) => {
                    let a = at.look.modes[at_a];
                    let told = side.labels[row].as_ref().and_then(Label::family);
                    let family = p.families[a].clone().filter(|f| told.is_some_and(|t| t != f));
                    let own = family.as_deref().or(told);
                    let is_like = |b: usize| {
                        !c.pairing().same_family_only
                            || own.is_none()
                            || p.families[b].is_none()
                            || p.families[b].as_deref() == own
                    };
                    let rank = (0..a).filter(|b| !by_shape.contains(b) && is_like(*b)).count();
                    let is_fixed = is_fixed || side.given[row].is_some();
                    let probability = at.of_given[row].map_or_else(|| at.p[(row, at_a)], logistic);
                    Standing::Found { model_mode: a, rank, family, is_fixed, probability, by_user: side.by_user[row] }
                }
                // It may be one of two and is of the structure all the same: the fit pairs it.
                None if foreign < 0.5 => Standing::Open,
                None => {
                    let (foreign, reason) = self.why(side, at, row, foreign);
                    Standing::Aside { foreign, reason }
                }
            };
        }
        out
    }

    /// Why a mode has no partner, and the probability that it is foreign where nothing that the user has said decides.
    fn why(&self, side: &Side<'_>, at: &FoundSide, row: usize, foreign: f64) -> (Option<f64>, String) {
        let c = side.comparison;
        let p = &at.look.prediction;
        let i = side.open[row];
        let mode = &c.test().modes[i];
        let f = mode.frequency_hz.value;
        let n = p.frequencies_hz.len();
        let told = |a: usize| {
            let name = at.look.names.as_ref().map(|names| names[a].long.as_str());
            Told { name, fitted: self.options.moves }
        };
        let taken = |a: usize| {
            at.pairs.iter().position(|q| q.is_some_and(|(q, _)| at.look.modes[q] == a)).filter(|&other| other != row)
        };
        // What only the user's word forbids, where it would be of the structure otherwise.
        if let Some((position, ln_odds)) = at.forbidden[row]
            && 1.0 / (1.0 / foreign + ln_odds.exp()) < 0.5
        {
            let a = at.look.modes[position];
            let gates = self.gates();
            if let Some(gate) = gates.closed(c, p, i, a) {
                return (None, gate.reason(&gates, c, p, i, a, told(a)));
            }
            if let Some(other) = taken(a).filter(|&o| side.by_user[o]) {
                return (None, Self::given_away(side, at, (i, side.open[other]), a, told(a)));
            }
        }
        let by = |of: &dyn Fn(usize) -> f64| (0..n).max_by(|&a, &b| of(a).total_cmp(&of(b)));
        let likeness =
            |a: usize| if mode.shape.is_some() { p.mac[(a, i)] } else { -(p.frequencies_hz[a] / f).ln().abs() };
        let Some(a) = by(&likeness) else { return (None, "the model has no mode to compare with".into()) };
        let called = told(a).called(p, a);
        let taken = taken(a)
            .map_or_else(String::new, |other| format!(", which is the partner of test mode {}", side.open[other] + 1));
        let best = if mode.shape.is_some() {
            format!("its largest MAC is {:.2}, with {called}{taken}", p.mac[(a, i)])
        } else {
            format!("the nearest in frequency is {called}{taken}")
        };
        (Some(foreign), format!("foreign with probability {}: {best}", probability(foreign)))
    }

    /// A mode whose likeliest partner the user has given to another one.
    fn given_away(side: &Side<'_>, at: &FoundSide, (mode, other): (usize, usize), a: usize, told: Told<'_>) -> String {
        let p = &at.look.prediction;
        let modes = &side.comparison.test().modes;
        let mac =
            |i: usize| modes[i].shape.as_ref().map_or_else(String::new, |_| format!("MAC {:.2}, ", p.mac[(a, i)]));
        let off = |i: usize| 100.0 * (p.frequencies_hz[a] / modes[i].frequency_hz.value - 1.0);
        format!(
            "its likeliest partner is {} ({}{:+.1} %), which `pair_with` gives to test mode {} ({}{:+.1} %)",
            told.called(p, a),
            mac(mode),
            off(mode),
            other + 1,
            mac(other),
            off(other)
        )
    }
}
