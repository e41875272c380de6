//! Which mode of a model a measured mode is, or that it is none of them, as inference.
//!
//! A test mode i has a partner a among the modes of the model, each used once, or none: then it is foreign (a suspension, a
//! shaker, a neighbour, a spurious pole). With y the measured shape of unit length at n sensors, u that of the model, P = I - u uᵀ,
//! c = |uᵀy|, as what changes u changes y by that share:
//!
//! ```text
//! z        = [(ln f_i - ln f_a)/s_f ; P y/(k s)],      cov z = I + W Wᵀ
//! W        = [J_f ; c P J_u/(k s)] C^½                  what the parameters may still move, in frequency and shape together;
//!                                                       a shape by 0.3 rad in all
//!          | [τ/s_f ; 0]                                model form in frequency
//!          | [0 ; c P φ_b c_ab/|φ_a|/(k s)]             model form in shape: modes mix, close ones most
//! c_ab     = min(1, 2 ρ τ √(λ_a λ_b)/|λ_a - λ_b|)
//! ln p     = -½ zᵀ cov⁻¹ z - ½ ln det cov - ln(s_f √2π) - (n-1) ln(√2π k s)
//! ln p₀    = -ln(band) + ln[(1 - l) Γ(n/2)/π^(n/2)      foreign: any frequency of the band, any shape,
//!            + l mean_jk N(y without y_j; 0, k s)]      or that of one sensor alone: l = 0.2, k = 1, 2, 4
//! k s √(n-1) ≤ 0.6                                      shapes that are farther apart are not alike
//! L_ia     = ln p - ln p₀ + ln((1 - e)/(e N)) + label   N modes of the model, e = 0.03
//! ```
//!
//! A model errs in all its modes, and in some more than in others: a joint that gives is seen by the modes that bend it. So a pair's
//! model form is that of all or more, at odds: with τ and k on a grid and (τ₀, k₀) that of all,
//!
//! ```text
//! exp L_ia(τ₀, k₀) = Σ_{τ ≥ τ₀, k ≥ k₀} w(steps from τ₀) w(steps from k₀) exp L_ia(τ, k)
//! ```
//!
//! The pairs are the assignment with "none" columns that makes Σ L the largest; their probabilities are the marginals of
//! one-to-one matching, by belief propagation. (τ₀, k₀) are those of largest evidence, not driven to zero: an imperfect model must not
//! make its true modes foreign.
//!
//! # Source
//! One-to-one marginals: J. L. Williams, R. A. Lau, Approximate evaluation of marginal association probabilities with belief
//! propagation, IEEE Transactions on Aerospace and Electronic Systems 50 (2014). Mixtures for outliers: G. E. P. Box, G. C. Tiao, A
//! Bayesian approach to some outlier problems, Biometrika 55 (1968).

mod terms;

use self::terms::{Spread, Terms, ln_of_none, unit};
use super::assignment::assign;
use super::labels::Label;
use crate::linalg::{DMatrix, DVector};

/// Share of measured modes that are not of the structure.
pub(crate) const FOREIGN: f64 = 0.03;
/// Below these standard deviations, relative, a test states more than any model can follow; pairing takes no notice of them.
const LEAST_FREQUENCY_SD: f64 = 2e-4;
const LEAST_SHAPE_SD: f64 = 2e-3;
/// L of a pair that the user has named.
const GIVEN: f64 = 1e6;
/// A pair whose frequencies are farther apart than so many standard deviations with the largest model form would pull a fit as a foreign
/// mode does, however alike the shapes.
const FARTHEST: f64 = 3.0;
/// Mean of |ln f_i/f_a| where a model that has not been updated is far off.
const FAR: f64 = 0.5;
/// L below which a pair takes part in no assignment, and levels at which it is looked at.
const HOPELESS: f64 = -10.0;
const CORNERS: [Level; 6] = [level(0, 0), level(1, 1), level(2, 2), level(3, 3), level(3, 4), level(4, 5)];
/// The grid of model form and of the factor of the noise.
const TAUS: [f64; 5] = [0.0, 0.006, 0.025, 0.1, 0.4];
const FACTORS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// ln of the odds against each step of either: for all pairs together, and once more for a pair beyond them.
const PER_TAU: f64 = 1.5;
const PER_FACTOR: f64 = 1.0;

/// Model form: relative error of a frequency beside what parameters do, and the factor of the noise of shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Form {
    /// τ.
    pub(crate) tau: f64,
    /// k.
    pub(crate) k: f64,
}

/// A place in the grid of model form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Level {
    tau: usize,
    k: usize,
}

/// The i-th τ and the j-th k of the grid.
pub(crate) const fn level(tau: usize, k: usize) -> Level {
    Level { tau, k }
}

impl Level {
    /// None: the model can be right, and the noise is as stated.
    pub(crate) const NONE: Self = level(0, 0);

    fn form(self) -> Form {
        Form { tau: TAUS[self.tau], k: FACTORS[self.k] }
    }

    /// ln of the odds of a pair's own level where that of all is `all`, and against it without a pair.
    fn ln_weight(self, all: Self) -> f64 {
        let step = |n: usize, per: f64| (1.0 - (-per).exp()).ln() - per * n as f64;
        step(self.tau - all.tau, PER_TAU) + step(self.k - all.k, PER_FACTOR)
    }

    /// Whether nothing suggests that the model is wrong or the noise larger than stated.
    pub(crate) fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// A measured mode, as pairing sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measured<'a> {
    /// Hz, with its standard deviation.
    pub(crate) frequency: (f64, f64),
    /// Real shape at the sensors, NaN where not measured; `None` without a shape.
    pub(crate) shape: Option<&'a [f64]>,
    /// Standard deviation of every entry.
    pub(crate) shape_sd: Option<&'a [f64]>,
    /// What its name tells.
    pub(crate) label: Option<&'a Label>,
}

/// A mode of the model.
#[derive(Debug, Clone)]
pub(crate) struct Modelled {
    /// Hz.
    pub(crate) frequency: f64,
    /// Mass-normalised shape at the sensors.
    pub(crate) shape: DVector<f64>,
    /// ∂ ln f/∂x, (n_parameters).
    pub(crate) d_ln_f: DVector<f64>,
    /// ∂(shape at the sensors)/∂x, (n_sensors x n_parameters).
    pub(crate) d_shape: DMatrix<f64>,
    /// What its name tells.
    pub(crate) label: Option<Label>,
}

/// All pairs of one test at one point.
#[derive(Debug, Clone)]
pub(crate) struct Pairings {
    /// Row by row: test mode, mode of the model.
    terms: Vec<Vec<Terms>>,
    none: Vec<f64>,
    ln_band: f64,
    n_parameters: usize,
    /// Pairs that the user's limits and the partners that they have named let be.
    allowed: DMatrix<bool>,
    /// Pairs that the user has given.
    given: Vec<Option<usize>>,
}

impl Pairings {
    /// Of the modes of a test with modes of a model.
    ///
    /// * `is_allowed` - (test mode, mode of the model)
    /// * `given` - partners that the user has named
    /// * `n_parameters` - of the derivatives; a test without modes has as many
    pub(crate) fn new(
        measured: &[Measured<'_>],
        modelled: &[Modelled],
        is_allowed: impl Fn(usize, usize) -> bool,
        given: Vec<Option<usize>>,
        n_parameters: usize,
    ) -> Self {
        let band = measured.iter().map(|m| m.frequency.0);
        let (low, high) = band.fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f), h.max(f)));
        // Half an octave beyond the highest and the lowest, and an octave at least.
        let ln_band = if high > 0.0 { ((high / low).ln() + 2.0_f64.ln()).ln() } else { 0.0 };
        let units: Vec<_> = measured.iter().map(|m| unit(m)).collect();
        let none = units.iter().map(|u| u.as_ref().map_or(0.0, ln_of_none) - ln_band).collect();
        let terms = measured
            .iter()
            .zip(&units)
            .map(|(m, u)| (0..modelled.len()).map(|a| Terms::new(m, u.as_ref(), modelled, a)).collect())
            .collect();
        // A mode that the user has paired takes no other, and no other takes its partner.
        let is_free = |i: usize, a: usize| given[i].is_none() && !given.contains(&Some(a));
        let allowed = DMatrix::from_fn(measured.len(), modelled.len(), |i, a| is_free(i, a) && is_allowed(i, a));
        Self { terms, none, ln_band, n_parameters, allowed, given }
    }

    /// What every pair says with each model form.
    ///
    /// * `spread` - C^½, lower triangular; none where the parameters stand
    /// * `misread` - share of frequencies that tell nothing: then the shape alone tells; none for a fit, which they would pull. Where
    ///   parameters move they are noted wrongly, as any frequency of the band; where they stand the model is far off, by [`FAR`]
    pub(crate) fn seen(&self, spread: Option<&DMatrix<f64>>, misread: f64) -> Seen<'_> {
        let zero = DMatrix::zeros(self.n_parameters, self.n_parameters);
        let stands = spread.is_none();
        let spread = spread.unwrap_or(&zero);
        let (n, m) = self.allowed.shape();
        let prior = ((1.0 - FOREIGN) / (FOREIGN * m.max(1) as f64)).ln();
        let table = (0..n * m)
            .map(|k| {
                let (i, a) = (k / m, k % m);
                let is_given = self.given[i] == Some(a);
                if self.given[i].is_some() && !is_given {
                    return None;
                }
                let t = self.terms[i][a].spread(spread);
                let ln_misread = if stands { t.ln_far(FAR) } else { -self.ln_band };
                let ln_odds =
                    |at: Level| ln_density(&t, at.form(), misread, ln_misread) - self.none[i] + prior + t.label;
                let is_beyond = || misread <= 0.0 && t.is_beyond(FARTHEST, TAUS[TAUS.len() - 1]);
                if !is_given && (is_beyond() || CORNERS.iter().all(|c| ln_odds(*c) < HOPELESS)) {
                    return None;
                }
                Some(Box::new(std::array::from_fn(|tau| std::array::from_fn(|k| ln_odds(level(tau, k))))))
            })
            .collect();
        Seen { pairings: self, table }
    }

    /// JᵀV⁻¹J and JᵀV⁻¹z of the pairs, V with noise and each pair's model form and without the spread of the parameters.
    ///
    /// * `misread` - as of [`Self::seen`]: a frequency that is noted wrongly pulls nothing
    pub(crate) fn normal_equations(
        &self,
        pairs: &[Option<(usize, Form)>],
        misread: f64,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.n_parameters;
        let (mut h, mut g) = (DMatrix::zeros(p, p), DVector::zeros(p));
        for (i, pair) in pairs.iter().enumerate() {
            let Some((a, form)) = pair else { continue };
            let (own_h, own_g) = self.terms[i][*a].normal_equations(*form, misread > 0.0);
            h += own_h;
            g += own_g;
        }
        (h, g)
    }
}

/// ln p of a pair, whose frequency tells nothing in a share of tests and has `ln_misread` then.
fn ln_density(t: &Spread, form: Form, misread: f64, ln_misread: f64) -> f64 {
    let own = t.ln_density(form, true);
    if misread <= 0.0 || !t.has_shape() {
        return own;
    }
    let by_shape = misread.ln() + ln_misread + t.ln_density(form, false);
    let by_both = (1.0 - misread).ln() + own;
    by_shape.max(by_both) + (-(by_shape - by_both).abs()).exp().ln_1p()
}

/// L of a pair with each τ and k of the grid.
type Grid = [[f64; FACTORS.len()]; TAUS.len()];

/// What the pairs of one test say with each model form, at one spread of the parameters.
#[derive(Debug)]
pub(crate) struct Seen<'a> {
    pairings: &'a Pairings,
    /// Row by row as the pairs; none where a pair is forbidden or hopeless with any form.
    table: Vec<Option<Box<Grid>>>,
}

impl Seen<'_> {
    fn grid(&self, i: usize, a: usize) -> Option<&Grid> {
        self.table[i * self.pairings.allowed.ncols() + a].as_deref()
    }

    /// L where the model form of all is `all`, (n_test x n_model); -∞ where a limit or the user forbids a pair.
    pub(crate) fn ln_odds(&self, all: Level) -> DMatrix<f64> {
        let (n, m) = self.pairings.allowed.shape();
        DMatrix::from_fn(n, m, |i, a| match self.pairings.given[i] {
            Some(given) if given == a => GIVEN,
            _ if self.pairings.allowed[(i, a)] => self.ln_odds_of(i, a, all),
            _ => f64::NEG_INFINITY,
        })
    }

    /// L of a pair by what is measured alone, whatever the user's word and limits say of it.
    pub(crate) fn ln_odds_of(&self, i: usize, a: usize, all: Level) -> f64 {
        let Some(grid) = self.grid(i, a) else { return f64::NEG_INFINITY };
        let most = levels(all).map(|own| grid[own.tau][own.k] + own.ln_weight(all)).fold(f64::MIN, f64::max);
        let sum: f64 = levels(all).map(|own| (grid[own.tau][own.k] + own.ln_weight(all) - most).exp()).sum();
        most + sum.ln()
    }

    /// L of the partner that is given, where there is one.
    pub(crate) fn ln_odds_of_given(&self, i: usize, all: Level) -> Option<f64> {
        self.pairings.given[i].map(|a| self.ln_odds_of(i, a, all))
    }

    /// The mode of largest L among those that a limit or a given partner forbids, with its L.
    pub(crate) fn likeliest_forbidden(&self, i: usize, all: Level) -> Option<(usize, f64)> {
        let allowed = &self.pairings.allowed;
        let is_open = self.pairings.given[i].is_none();
        let forbidden = (0..allowed.ncols()).filter(|&a| is_open && !allowed[(i, a)]);
        forbidden.map(|a| (a, self.ln_odds_of(i, a, all))).max_by(|x, y| x.1.total_cmp(&y.1))
    }

    /// The model form of all with the largest evidence of the best assignment, and that.
    pub(crate) fn level(&self) -> (Level, f64) {
        let score = |all: Level| {
            let odds = self.ln_odds(all);
            let against = PER_TAU * all.tau as f64 + PER_FACTOR * all.k as f64;
            (all, score(&odds, &best(&odds)) - against)
        };
        let mut found = (Level::NONE, f64::NEG_INFINITY);
        for tried in levels(Level::NONE).map(score) {
            if tried.1 > found.1 + 1e-9 {
                found = tried;
            }
        }
        found
    }

    /// The pairs with the model form that is the most probable for each, where that of all is `all`.
    pub(crate) fn with_forms(&self, pairs: &[Option<usize>], all: Level) -> Vec<Option<(usize, Form)>> {
        let own = |i: usize, a: usize| {
            let Some(grid) = self.grid(i, a) else { return all.form() };
            let score = |l: &Level| grid[l.tau][l.k] + l.ln_weight(all);
            levels(all).max_by(|x, y| score(x).total_cmp(&score(y))).map_or(all.form(), Level::form)
        };
        pairs.iter().enumerate().map(|(i, a)| a.map(|a| (a, own(i, a)))).collect()
    }
}

/// Levels from one on, in both directions.
fn levels(from: Level) -> impl Iterator<Item = Level> {
    (from.tau..TAUS.len()).flat_map(move |tau| (from.k..FACTORS.len()).map(move |k| level(tau, k)))
}

/// Σ L of the pairs of an assignment.
fn score(odds: &DMatrix<f64>, pairs: &[Option<usize>]) -> f64 {
    pairs.iter().enumerate().filter_map(|(i, a)| a.map(|a| odds[(i, a)])).sum()
}

/// The assignment with "none" columns of the largest Σ L; a pair whose L is below zero is none.
pub(crate) fn best(odds: &DMatrix<f64>) -> Vec<Option<usize>> {
    const FORBIDDEN: f64 = 1e9;
    let (n, m) = odds.shape();
    let cost = DMatrix::from_fn(n, m + n, |i, a| if a < m { -odds[(i, a)].clamp(-FORBIDDEN, FORBIDDEN) } else { 0.0 });
    assign(&cost).into_iter().enumerate().map(|(i, a)| a.filter(|&a| a < m && odds[(i, a)] > 0.0)).collect()
}

/// P of every pair, (n_test x n_model); what a row lacks to one is the probability that the mode is foreign.
///
/// Belief propagation for one-to-one matching with none:
///
/// ```text
/// μ(i→a) = ψ_ia/(1 + Σ_b≠a ψ_ib ν(b→i)),    ν(a→i) = 1/(1 + Σ_j≠i μ(j→a)),    ψ = exp L
/// P_ia   = ψ_ia ν(a→i)/(1 + Σ_b ψ_ib ν(b→i))
/// ```
pub(crate) fn marginals(odds: &DMatrix<f64>) -> DMatrix<f64> {
    const ROUNDS: usize = 200;
    let (n, m) = odds.shape();
    let ln_sum = |values: &mut dyn Iterator<Item = f64>| {
        let all: Vec<f64> = std::iter::once(0.0).chain(values).collect();
        let most = all.iter().copied().fold(0.0, f64::max);
        most + all.iter().map(|v| (v - most).exp()).sum::<f64>().ln()
    };
    let psi = odds.map(|v| v.clamp(-1e6, 1e6));
    let mut ln_nu: DMatrix<f64> = DMatrix::zeros(n, m);
    for _ in 0..ROUNDS {
        let ln_mu = DMatrix::from_fn(n, m, |i, a| {
            psi[(i, a)] - ln_sum(&mut (0..m).filter(|&b| b != a).map(|b| psi[(i, b)] + ln_nu[(i, b)]))
        });
        let next = DMatrix::from_fn(n, m, |i, a| -ln_sum(&mut (0..n).filter(|&j| j != i).map(|j| ln_mu[(j, a)])));
        // Half a step: full ones may swing between two states.
        let moved = (&next - &ln_nu).amax();
        ln_nu = (next + ln_nu) * 0.5;
        if moved < 1e-9 {
            break;
        }
    }
    DMatrix::from_fn(n, m, |i, a| {
        let all = ln_sum(&mut (0..m).map(|b| psi[(i, b)] + ln_nu[(i, b)]));
        (psi[(i, a)] + ln_nu[(i, a)] - all).exp()
    })
}

#[cfg(test)]
mod tests;
