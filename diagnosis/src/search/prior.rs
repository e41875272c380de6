//! Prior odds, and probabilities from evidences.
//!
//! * Half for "nothing is missing"; the other half in equal shares for every kind that could have been seen and for "something
//!   else", and inside a kind in equal shares for its places.
//! * "Something else" is a random vector in the residual, or a change that is [spread](super::spread) over all elements; these ways
//!   of describing it share its odds. It may be there alone or beside a hypothesis; then the odds of both multiply.
//! * A second effect has the same odds again, given the first. Where several are named, each is stated with the probability of all
//!   combinations that have it, beside its own: these add up to more than one.
//! * Noise larger than stated belongs to "nothing is missing", with the odds of its [factor](ln_odds_of_noise); "something else" makes the same
//!   residuals at the stated noise.
//! * Two p-values enter as Bayes factors, see [`most_against`]: "nothing" has at least what the p-value of the alarm leaves it, and what a
//!   hypothesis leaves that does not look like noise speaks for "something else" beside it.
//!
//! So every probability is prior odds times Bayes factor over the sum of all, and every ln B is against the fitted base.

use super::hypothesis::Refit;
use crate::problem::evidence::ln_sum;
use crate::screen::stage::Stage;
use std::collections::BTreeMap;

/// ln of the prior odds of every hypothesis of a kind, and of something else.
pub(crate) struct Odds<'a> {
    places: BTreeMap<&'a str, usize>,
}

/// ln of the prior odds of "nothing is missing".
pub(crate) fn ln_odds_of_none() -> f64 {
    0.5_f64.ln()
}

impl<'a> Odds<'a> {
    /// Places of every kind that could have been seen.
    pub(crate) fn new(base: &'a Stage) -> Self {
        let mut places: BTreeMap<&str, usize> = BTreeMap::new();
        for s in &base.effects {
            *places.entry(base.screened[s.index].candidate.effect.name()).or_default() += 1;
        }
        for f in &base.fault_scores {
            *places.entry(base.faults[f.index].name()).or_default() += 1;
        }
        Self { places }
    }

    /// Of something else: as a kind.
    pub(crate) fn of_something_else(&self) -> f64 {
        0.5_f64.ln() - ((self.places.len() + 1) as f64).ln()
    }

    /// Of a hypothesis.
    pub(crate) fn of(&self, r: &Refit) -> f64 {
        self.of_kind(r.name()) + r.ln_odds
    }

    /// ln of the odds of a hypothesis times its Bayes factor.
    pub(crate) fn weight(&self, r: &Refit) -> f64 {
        self.of(r) + r.ln_bayes
    }

    /// Of a hypothesis of a kind, at a place of the file.
    pub(crate) fn of_kind(&self, name: &str) -> f64 {
        let places = self.places.get(name).copied().unwrap_or(1).max(1);
        self.of_something_else() - (places as f64).ln()
    }

    /// ln of odds times Bayes factors of all that were refitted on top of another; the two may have come in either order.
    pub(crate) fn of_a_second(&self, refits: &[Refit]) -> f64 {
        let each: Vec<f64> = refits.iter().map(|r| self.weight(r)).collect();
        std::f64::consts::LN_2 + ln_sum(&each)
    }
}

/// ln of the odds of noise that is k times as large as stated, against noise as stated: ln k is half-normal with a standard deviation of ln 2.
/// Who states a standard deviation is wrong by a factor of two now and then, and hardly ever by one of eight.
///
/// ```text
/// -½ (ln k/ln 2)²
/// ```
pub(crate) fn ln_odds_of_noise(factor: f64) -> f64 {
    -0.5 * (factor.max(1.0).ln() / std::f64::consts::LN_2).powi(2)
}
