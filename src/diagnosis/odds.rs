//! Prior odds, and probabilities from evidences.
//!
//! * Half for "nothing is missing"; the other half in equal shares for every kind that could have been seen and for "something
//!   else", and inside a kind in equal shares for its places.
//! * "Something else" is a random vector in the residual, or a change that is [spread](super::spread) over all elements; these ways
//!   of describing it share its odds.
//! * A second effect has the same odds again, given the first. Where two are named, each has the probability of the pairs that have it,
//!   beside its own: these add up to more than one.
//! * Stated probabilities obey the tests: "nothing" is not less probable than the p-value of the alarm allows, and what a
//!   hypothesis leaves that does not look like noise speaks for "something else", see [`most_against`].

use super::base::Stage;
use super::noise::DRAWS;
use super::refit::Refit;
use std::collections::BTreeMap;

/// ln of the prior odds of every hypothesis of a kind, and of something else.
pub(super) struct Odds<'a> {
    places: BTreeMap<&'a str, usize>,
}

/// Probabilities of "none", of "something else" and of every refitted hypothesis.
pub(super) struct Probabilities {
    pub(super) none: f64,
    pub(super) other: f64,
    pub(super) each: Vec<f64>,
    /// Of two together, where two are named.
    pub(super) pairs: f64,
    /// ln of the sum of all odds times Bayes factors.
    pub(super) ln_sum: f64,
}

impl<'a> Odds<'a> {
    /// Places of every kind that could have been seen.
    pub(super) fn new(base: &'a Stage) -> Self {
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
    pub(super) fn of_something_else(&self) -> f64 {
        0.5_f64.ln() - ((self.places.len() + 1) as f64).ln()
    }

    /// Of a hypothesis.
    pub(super) fn of(&self, r: &Refit) -> f64 {
        self.of_kind(r.name()) + r.ln_odds
    }

    /// Of a hypothesis of a kind, at a place of the file.
    pub(super) fn of_kind(&self, name: &str) -> f64 {
        let places = self.places.get(name).copied().unwrap_or(1).max(1);
        self.of_something_else() - (places as f64).ln()
    }

    /// ln of odds times Bayes factors of all that were refitted on top of another; the two may have come in either order.
    pub(super) fn of_a_second(&self, refits: &[Refit]) -> f64 {
        let each: Vec<f64> = refits.iter().map(|r| self.of(r) + r.ln_bayes).collect();
        std::f64::consts::LN_2 + ln_sum(&each)
    }

    /// * `other` - ln of the Bayes factor of something else
    pub(super) fn probabilities(&self, base: &Stage, refits: &[Refit], other: f64) -> Probabilities {
        let mut ln = vec![0.5_f64.ln(), self.of_something_else() + other];
        ln.extend(refits.iter().map(|r| self.of(r) + r.ln_bayes));
        let top = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = ln.iter().map(|l| (l - top).exp()).collect();
        let rest: f64 = weights[1..].iter().sum();
        // A p-value without a draw beyond the observed one is only a bound of itself.
        let least = if base.p_value > 1.0 / DRAWS as f64 { most_against(base.p_value) } else { 0.0 };
        let none = weights[0].max(least * rest);
        let sum = none + rest;
        Probabilities {
            none: none / sum,
            other: weights[1] / sum,
            each: weights[2..].iter().map(|w| w / sum).collect(),
            pairs: 0.0,
            ln_sum: top + sum.ln(),
        }
    }
}

impl Probabilities {
    /// Brings hypotheses into the order of their probabilities.
    pub(super) fn sort(&mut self, refits: &mut Vec<Refit>) {
        let mut order: Vec<usize> = (0..refits.len()).collect();
        order.sort_by(|&a, &b| self.each[b].total_cmp(&self.each[a]).then(a.cmp(&b)));
        *refits = order.iter().map(|&i| refits[i].clone()).collect();
        self.each = order.iter().map(|&i| self.each[i]).collect();
    }

    /// With pairs among what is compared.
    ///
    /// * `ln_two` - ln of the sum of their odds times Bayes factors
    pub(super) fn with_pairs(&mut self, ln_two: f64) {
        let top = ln_two.max(self.ln_sum);
        let (two, one) = ((ln_two - top).exp(), (self.ln_sum - top).exp());
        for p in self.each.iter_mut().chain([&mut self.none, &mut self.other]) {
            *p *= one / (one + two);
        }
        self.pairs = two / (one + two);
    }

    /// The same for two that are not named: their share goes to the first.
    pub(super) fn with_a_pair(&mut self, first: usize, ln_two: f64) {
        self.with_pairs(ln_two);
        self.each[first] += std::mem::take(&mut self.pairs);
    }

    /// "Nothing is missing" where what the base leaves does not look like noise, with p.
    pub(super) fn deny(&mut self, p: f64) {
        let most = most_against(p) / (1.0 + most_against(p));
        let lost = (self.none - most).max(0.0);
        self.none -= lost;
        self.other += lost;
    }

    /// A hypothesis that leaves more than noise, with p, may be there beside something else, or be its image: even odds.
    pub(super) fn doubt(&mut self, i: usize, p: f64) {
        let lost = 0.5 * self.each[i] * (1.0 - most_against(p));
        self.each[i] -= lost;
        self.other += lost;
    }
}

/// ln Σ exp.
pub(super) fn ln_sum(terms: &[f64]) -> f64 {
    let top = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY { top } else { top + terms.iter().map(|t| (t - top).exp()).sum::<f64>().ln() }
}

/// ln of the mean of exp.
pub(super) fn ln_mean(terms: &[f64]) -> f64 {
    ln_sum(terms) - (terms.len() as f64).ln()
}

/// The smallest Bayes factor, for over against, that a p-value of a hypothesis can mean, whatever the alternative:
///
/// ```text
/// B(p) = -e p ln p   for p < 1/e, else 1
/// ```
///
/// # Source
/// T. Sellke, M. J. Bayarri, J. O. Berger, Calibration of p values for testing precise null hypotheses, The American Statistician
/// 55 (2001) 62-71.
pub(super) fn most_against(p: f64) -> f64 {
    if p < 1.0 / std::f64::consts::E { -std::f64::consts::E * p * p.max(f64::MIN_POSITIVE).ln() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::most_against;

    /// Table 1 of Sellke, Bayarri and Berger (2001).
    #[test]
    fn p_values_speak_as_published() {
        for (p, bayes) in [(0.1, 0.625), (0.05, 0.407), (0.01, 0.125), (0.005, 0.072), (0.001, 0.0188)] {
            assert!((most_against(p) / bayes - 1.0).abs() < 5e-3, "{p}: {}", most_against(p));
        }
        assert_eq!((most_against(0.0), most_against(0.5), most_against(1.0)), (0.0, 1.0, 1.0));
    }
}
