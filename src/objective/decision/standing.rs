//! What comes out for every mode, and why a mode has no partner.

use super::gates::{Told, probability};
use super::{FoundSide, Inference, Side};
use crate::correlation::Label;
use crate::data::{Reference, Standing};
use crate::element::Dof;
use std::sync::Arc;

/// Whether a mode is known by its name: the user has paired it, or it has no shape and a label.
fn is_named(side: &Side<'_>, row: usize) -> bool {
    let has_shape = side.comparison.test().modes[side.open[row]].shape.is_some();
    side.given[row].is_some() || (!has_shape && side.labels[row].is_some())
}

/// Modes of the model with a larger MAC at the sensors are alike there: what noise and parameters change may pair either.
const ALIKE: f64 = 0.5;

/// Another mode whose MAC with the measured one is above that of the partner less this may take its place.
const NEARLY: f64 = 0.2;

/// A partner whose MAC with the measured mode is below this has another shape: what will have the right one is another mode of the model, or this one
/// changed beyond recognition, and to follow it leads astray.
const OF_THE_SHAPE: f64 = 0.8;

/// Whether another mode of the model is like the partner of a mode at the sensors that measured it, or like the measured mode itself.
fn is_alike(side: &Side<'_>, at: &FoundSide, row: usize, partner: usize) -> bool {
    let read = side.comparison.shapes().column(side.open[row]).into_owned();
    let shapes = &at.look.prediction.at_sensors;
    let seen: Vec<usize> = (0..read.len()).filter(|&s| read[s].is_finite()).collect();
    let product = |a: usize, b: usize| seen.iter().map(|&s| shapes[(s, a)] * shapes[(s, b)]).sum::<f64>();
    let own = product(partner, partner);
    let mac = |other: usize| product(partner, other).powi(2) / (own * product(other, other));
    let measured = at.look.prediction.mac.column(side.open[row]);
    let is_rival = |other: usize| mac(other) > ALIKE || measured[other] > measured[partner] - NEARLY;
    at.look.modes.iter().any(|&other| other != partner && is_rival(other))
}

/// MAC within this of the largest are as large.
const AS_LIKE: f64 = 0.02;
/// Shapes with a larger MAC are the same, and a mode farther off than this, as |ln f/f|, is told to be out of the reach of the parameters.
const SAME: f64 = 0.9;
const REACHED: f64 = 0.15;

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
            .filter(|&row| modes[side.open[row]].shape.is_some() || is_named(side, row))
            .filter_map(|row| at.pairs[row].map(|(a, _)| at.look.modes[a]))
            .collect();
        let mut dofs = None;
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
                    let reference = self.reference(side, at, row, a, &mut dofs);
                    let by_user = side.by_user[row];
                    Standing::Found { model_mode: a, rank, family, is_fixed, probability, by_user, reference }
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

    /// What a fit follows the partner of a mode by; none where the shapes at the sensors tell it from the other modes of the model, where they deny it,
    /// or a mode without a shape and a name is counted.
    fn reference(
        &self,
        side: &Side<'_>,
        at: &FoundSide,
        row: usize,
        partner: usize,
        dofs: &mut Option<Arc<Vec<(String, Dof)>>>,
    ) -> Option<Arc<Reference>> {
        let is_named = is_named(side, row);
        let c = side.comparison;
        let p = &at.look.prediction;
        let is_denied = || p.mac[(partner, side.open[row])] < OF_THE_SHAPE;
        if !self.options.moves || !(is_named || (!is_denied() && is_alike(side, at, row, partner))) {
            return None;
        }
        let stand_in = c.model().stand_in();
        let map = c.model().dofs_of_nodes();
        let dofs = dofs.get_or_insert_with(|| {
            let names = map.node_names();
            Arc::new(map.rows().iter().map(|&(node, dof)| (names[node].clone(), dof)).collect())
        });
        let shape = p.modes.shapes.columns(p.modes.n_rigid + partner, 1).into_owned();
        let momentum = stand_in.map_or_else(|| p.matrices.mass_times(&shape), |s| s.mass_times(&shape));
        let momentum = momentum.as_slice().to_vec();
        Some(Arc::new(Reference { dofs: dofs.clone(), momentum, alone: is_named }))
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
        let mac = |a: usize| if mode.shape.is_some() { p.mac[(a, i)] } else { 1.0 };
        let largest = (0..n).map(mac).fold(0.0, f64::max);
        // Of those that are as like the nearest in frequency.
        let distance = |a: usize| (p.frequencies_hz[a] / f).ln().abs();
        let as_like = (0..n).filter(|&a| mac(a) >= largest - AS_LIKE);
        let Some(a) = as_like.min_by(|&a, &b| distance(a).total_cmp(&distance(b))) else {
            return (None, "the model has no mode to compare with".into());
        };
        let called = told(a).called(p, a);
        let taken = taken(a)
            .map_or_else(String::new, |other| format!(", which is the partner of test mode {}", side.open[other] + 1));
        let is_far = self.options.moves && distance(a) > REACHED && taken.is_empty() && self.gates().is_open();
        if mode.shape.is_some() && mac(a) > SAME && is_far {
            let off = 100.0 * (p.frequencies_hz[a] / f - 1.0);
            let text = format!(
                "foreign with probability {}, or the model lacks something: it has the shape of {called} (MAC {:.2}, {off:+.0} %), which no value of the \
                 parameters brings there",
                probability(foreign),
                mac(a)
            );
            return (Some(foreign), text);
        }
        let best = if mode.shape.is_some() {
            format!("its largest MAC is {:.2}, with {called}{taken}", mac(a))
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
