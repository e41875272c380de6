//! From evidences and [prior odds](crate::search::prior) to probabilities.
//!
//! Every probability is prior odds times Bayes factor over the sum of all, and every ln B is against the fitted base. Two p-values enter as Bayes
//! factors, see [`most_against`]: "nothing" has at least what the p-value of the alarm leaves it, and what a hypothesis leaves that does not look
//! like noise speaks for "something else" beside it.

use crate::problem::evidence::ln_sum;
use crate::screen::stage::Stage;
use crate::search::hypothesis::Refit;
use crate::search::prior::{Odds, ln_odds_of_noise, ln_odds_of_none};
use crate::thresholds::DRAWS;

/// ln of prior odds times Bayes factor, against the base, of all that is compared. Every probability that is stated is one of these over
/// their sum, and every ln B one of these less the ln of its odds.
pub(crate) struct Probabilities {
    ln_none: f64,
    ln_other: f64,
    ln_each: Vec<f64>,
    /// Of each hypothesis beside something outside the catalogue.
    ln_beside: Vec<f64>,
    /// What the noise beyond the stated one says for something outside the catalogue beside a hypothesis.
    ln_beside_noise: f64,
    /// Of several hypotheses of the catalogue together.
    ln_several: f64,
    ln_odds_of_something_else: f64,
}

impl Probabilities {
    /// * `other` - ln of the Bayes factor of something else
    pub(crate) fn new(odds: &Odds<'_>, base: &Stage, refits: &[Refit], other: f64) -> Self {
        let ln_other = odds.of_something_else() + other;
        let ln_each: Vec<f64> = refits.iter().map(|r| odds.weight(r)).collect();
        // A p-value without a draw beyond the observed one is only a bound of itself.
        let least = if base.p_value > 1.0 / DRAWS as f64 { most_against(base.p_value) } else { 0.0 };
        let rest = ln_sum(&[ln_each.as_slice(), &[ln_other]].concat());
        let ln_beside_noise = ln_beside_noise(odds, base.noise_factor());
        Self {
            ln_none: ln_odds_of_none().max(least.ln() + rest),
            ln_other,
            ln_beside: ln_each.iter().map(|ln| ln + ln_beside_noise).collect(),
            ln_each,
            ln_beside_noise,
            ln_several: f64::NEG_INFINITY,
            ln_odds_of_something_else: odds.of_something_else(),
        }
    }

    /// Of something outside the catalogue, alone or beside a hypothesis: ln of odds times Bayes factors.
    fn ln_all_other(&self) -> f64 {
        ln_sum(&[self.ln_beside.as_slice(), &[self.ln_other]].concat())
    }

    fn of(&self, ln: f64) -> f64 {
        // Each against the largest, and then their sum: evidences of 10⁸ have no digits left for a sum of logarithms.
        let rest = [self.ln_none, self.ln_other, self.ln_several];
        let all = || rest.iter().chain(&self.ln_beside).chain(&self.ln_each);
        let top = all().copied().fold(f64::NEG_INFINITY, f64::max);
        (ln - top).exp() / all().map(|l| (l - top).exp()).sum::<f64>()
    }

    /// That nothing is missing.
    pub(crate) fn none(&self) -> f64 {
        self.of(self.ln_none)
    }

    /// Of something outside the catalogue, alone or beside a hypothesis.
    pub(crate) fn other(&self) -> f64 {
        self.of(self.ln_all_other())
    }

    /// That all that is wrong is outside the catalogue.
    pub(crate) fn only_other(&self) -> f64 {
        self.of(self.ln_other)
    }

    /// Of a hypothesis alone.
    pub(crate) fn each(&self, i: usize) -> f64 {
        self.of(self.ln_each[i])
    }

    /// Of several hypotheses of the catalogue together.
    pub(crate) fn several(&self) -> f64 {
        self.of(self.ln_several)
    }

    /// ln of odds times Bayes factors of several hypotheses of the catalogue together.
    pub(crate) fn ln_several(&self) -> f64 {
        self.ln_several
    }

    /// ln of the Bayes factor of "nothing is missing" against the base with its odds: more than zero where the p-value of the alarm leaves it
    /// more than its odds do.
    pub(crate) fn ln_bayes_of_none(&self) -> f64 {
        self.ln_none - ln_odds_of_none()
    }

    /// ln of the Bayes factor of something outside the catalogue, alone or beside a hypothesis.
    pub(crate) fn ln_bayes_of_other(&self) -> f64 {
        self.ln_all_other() - self.ln_odds_of_something_else
    }

    /// Brings hypotheses into the order of their probabilities.
    pub(crate) fn sort(&mut self, refits: &mut Vec<Refit>) {
        let mut order: Vec<usize> = (0..refits.len()).collect();
        order.sort_by(|&a, &b| self.ln_each[b].total_cmp(&self.ln_each[a]).then(a.cmp(&b)));
        *refits = order.iter().map(|&i| refits[i].clone()).collect();
        self.ln_each = order.iter().map(|&i| self.ln_each[i]).collect();
        self.ln_beside = order.iter().map(|&i| self.ln_beside[i]).collect();
    }

    /// The hypothesis of this rank goes first.
    pub(crate) fn put_first(&mut self, chosen: usize) {
        self.ln_each[..=chosen].rotate_right(1);
        self.ln_beside[..=chosen].rotate_right(1);
    }

    /// A hypothesis more.
    ///
    /// * `ln` - of its odds times its Bayes factor
    pub(crate) fn push(&mut self, ln: f64) {
        self.ln_each.push(ln);
        self.ln_beside.push(ln + self.ln_beside_noise);
    }

    /// With several hypotheses together among what is compared.
    ///
    /// * `ln` - of the sum of their odds times Bayes factors
    pub(crate) fn with_several(&mut self, ln: f64) {
        self.ln_several = self.ln_several.max(ln);
    }

    /// "Nothing is missing" where what the base leaves does not look like noise, with p.
    pub(crate) fn deny(&mut self, p: f64) {
        self.ln_other = self.ln_other.max(self.ln_none + ln_against(p));
    }

    /// A hypothesis that leaves more than noise, with p, may be there beside something else.
    ///
    /// * `ln_bayes` - ln of the Bayes factor of something else in what it leaves
    pub(crate) fn doubt(&mut self, i: usize, p: f64, ln_bayes: f64) {
        let speaks = ln_bayes.max(ln_against(p));
        self.ln_beside[i] = self.ln_each[i] + (self.ln_odds_of_something_else + speaks).max(self.ln_beside_noise);
    }
}

/// ln of the odds of something outside the catalogue at the stated noise beside a hypothesis, against that hypothesis with larger noise: both leave
/// the same residuals, so that the odds of either decide.
///
/// ```text
/// ln odds(something else) - ln odds(noise k times as large)
/// ```
fn ln_beside_noise(odds: &Odds<'_>, factor: f64) -> f64 {
    if factor > 1.0 { odds.of_something_else() - ln_odds_of_noise(factor) } else { f64::NEG_INFINITY }
}

/// ln of the Bayes factor for something else that a p-value of a hypothesis may mean, see [`most_against`].
fn ln_against(p: f64) -> f64 {
    /// Draws show no smaller p-value, and a mode without a partner has none.
    const LEAST: f64 = 1e-6;
    -most_against(p.max(LEAST)).ln()
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
pub(crate) fn most_against(p: f64) -> f64 {
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
