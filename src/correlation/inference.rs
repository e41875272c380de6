//! Which mode of a model a measured mode is, or that it is none of them, as inference.
//!
//! A test mode i has a partner a among the modes of the model, each used once, or none: then it is foreign (a suspension, a
//! shaker, a neighbour, a spurious pole). With y the measured shape of unit length at n sensors, u that of the model, P = I - u uᵀ:
//!
//! ```text
//! z        = [(ln f_i - ln f_a)/s_f ; P y/(k s)],      cov z = I + W Wᵀ
//! W        = [J_f ; P J_u] C^½                          what the parameters may still move, in frequency and shape together
//!          | [τ/s_f ; 0]                                model form in frequency
//!          | [0 ; P φ_b c_ab/|φ_a|/(k s)]               model form in shape: modes mix, close ones most
//! c_ab     = min(1, 2 ρ τ √(λ_a λ_b)/|λ_a - λ_b|)
//! ln p     = -½ zᵀ cov⁻¹ z - ½ ln det cov - ln(s_f √2π) - (n-1) ln(√2π k s)
//! ln p₀    = -ln(band) + ln Γ(n/2) - n/2 ln π           foreign: any frequency of the band, any shape
//! L_ia     = ln p - ln p₀ + ln((1 - e)/(e N)) + label   N modes of the model, e = 0.03
//! ```
//!
//! The pairs are the assignment with "none" columns that makes Σ L the largest; their probabilities are the marginals of
//! one-to-one matching, by belief propagation. Model form τ and a factor k of the noise of the shapes are those of largest evidence,
//! not driven to zero: an imperfect model must not make its true modes foreign.
//!
//! # Source
//! One-to-one marginals: J. L. Williams, R. A. Lau, Approximate evaluation of marginal association probabilities with belief
//! propagation, IEEE Transactions on Aerospace and Electronic Systems 50 (2014). Mixtures for outliers: G. E. P. Box, G. C. Tiao, A
//! Bayesian approach to some outlier problems, Biometrika 55 (1968).

use super::assignment::assign;
use super::labels::Label;
use crate::linalg::{DMatrix, DVector};
use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, TAU};

/// Share of measured modes that are not of the structure.
pub(crate) const FOREIGN: f64 = 0.03;
/// Coupling of two modes by an error of the model, as a share of the relative error τ of their frequencies.
const COUPLING: f64 = 0.35;
/// Modes of the model that may mix into one, the most coupled ones.
const MIXED: usize = 12;
/// Below these standard deviations, relative, a test states more than any model can follow; pairing takes no notice of them.
const LEAST_FREQUENCY_SD: f64 = 2e-4;
const LEAST_SHAPE_SD: f64 = 2e-3;
/// Standard deviation of a shape that states none, of its largest entry.
const SHAPE_SD: f64 = 0.03;
/// L of a pair that the user has named.
const GIVEN: f64 = 1e6;
/// With the shape of its partner and so many standard deviations off, a frequency counts as noted wrongly.
const MISREAD: f64 = 6.0;
/// L below which a pair takes part in no assignment, and forms at which it is looked at.
const HOPELESS: f64 = -10.0;
const CORNERS: [Form; 5] = [
    Form::NONE,
    Form { tau: 0.006, k: 2.0 },
    Form { tau: 0.025, k: 4.0 },
    Form { tau: 0.1, k: 8.0 },
    Form { tau: 0.1, k: 32.0 },
];
/// The grid of model form and of the factor of the noise.
const FORMS: [f64; 7] = [0.0, 0.003, 0.006, 0.012, 0.025, 0.05, 0.1];
const FACTORS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// ln of the odds against each doubling of either.
const PER_DOUBLING: f64 = 1.0;

/// Model form: relative error of a frequency beside what parameters do, and the factor of the noise of shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Form {
    /// τ.
    pub(crate) tau: f64,
    /// k.
    pub(crate) k: f64,
}

impl Form {
    /// None: the model can be right, and the noise is as stated.
    pub(crate) const NONE: Self = Self { tau: 0.0, k: 1.0 };
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

/// What is known of one pair, before model form and spread.
#[derive(Debug, Clone)]
struct Terms {
    /// (ln f_i - ln f_a)/s_f and ∂ ln f_a/∂x / s_f.
    z: f64,
    slope: DVector<f64>,
    sd: f64,
    /// 2 ρ √(λ_a λ_b)/|λ_a - λ_b| of every mode that may mix into a.
    couplings: Vec<f64>,
    shape: Option<Shape>,
    label: f64,
}

/// Products of the columns [P J_u | P φ_b/|φ_a| | P y], each row over its standard deviation.
#[derive(Debug, Clone)]
struct Shape {
    gram: DMatrix<f64>,
    /// Number of sensors, and Σ ln s over them.
    n: f64,
    ln_sd: f64,
}

/// All pairs of one test at one point.
#[derive(Debug, Clone)]
pub(crate) struct Pairings {
    /// Row by row: test mode, mode of the model.
    terms: Vec<Vec<Terms>>,
    none: Vec<f64>,
    ln_band: f64,
    n_parameters: usize,
    /// Pairs that the user's gates let be.
    allowed: DMatrix<bool>,
    /// Pairs that the user has given.
    given: Vec<Option<usize>>,
}

/// Measured entries of a shape with the rows they stand in, over their length, and their standard deviations.
fn unit(mode: &Measured<'_>, factors: &[f64]) -> Option<(Vec<usize>, DVector<f64>, DVector<f64>)> {
    let shape = mode.shape?;
    let rows: Vec<usize> = (0..shape.len()).filter(|&i| shape[i].is_finite()).collect();
    let y = DVector::from_iterator(rows.len(), rows.iter().map(|&i| shape[i]));
    let (length, largest) = (y.norm(), y.amax());
    if rows.len() < 2 || length <= 0.0 {
        return None;
    }
    let sd = |&i: &usize| {
        let stated = mode.shape_sd.map_or(SHAPE_SD * largest, |sd| sd[i]);
        factors[i] * stated.max(LEAST_SHAPE_SD * largest) / length
    };
    let sd = DVector::from_iterator(rows.len(), rows.iter().map(sd));
    Some((rows, y / length, sd))
}

impl Pairings {
    /// Of the modes of a test with modes of a model.
    ///
    /// * `factors` - of the standard deviations of every sensor's readings
    /// * `is_allowed` - (test mode, mode of the model)
    /// * `given` - partners that the user has named
    /// * `n_parameters` - of the derivatives; a test without modes has as many
    pub(crate) fn new(
        measured: &[Measured<'_>],
        modelled: &[Modelled],
        factors: &[f64],
        is_allowed: impl Fn(usize, usize) -> bool,
        given: Vec<Option<usize>>,
        n_parameters: usize,
    ) -> Self {
        let band = measured.iter().map(|m| m.frequency.0);
        let (low, high) = band.fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f), h.max(f)));
        // Half an octave beyond the highest and the lowest, and an octave at least.
        let ln_band = if high > 0.0 { ((high / low).ln() + 2.0_f64.ln()).ln() } else { 0.0 };
        let units: Vec<_> = measured.iter().map(|m| unit(m, factors)).collect();
        let none = units
            .iter()
            .map(|u| {
                let isotropic = u.as_ref().map_or(0.0, |(rows, ..)| {
                    let n = rows.len() as f64;
                    ln_gamma(0.5 * n) - 0.5 * n * PI.ln()
                });
                isotropic - ln_band
            })
            .collect();
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

    /// The same with columns of the spread of the parameters instead of those of the parameters: for odds, not for normal equations.
    ///
    /// * `spread` - C^½, lower triangular
    pub(crate) fn spread(&self, spread: &DMatrix<f64>) -> Self {
        let mut out = self.clone();
        out.terms.iter_mut().flatten().for_each(|t| t.spread(spread));
        out
    }

    /// L of what [`Self::spread`] gives, (n_test x n_model); -∞ where a gate or the user forbids a pair.
    ///
    /// * `misread` - share of frequencies that are noted wrongly: then the shape alone tells; none for a fit, which they would pull
    pub(crate) fn ln_odds(&self, form: Form, misread: f64) -> DMatrix<f64> {
        let (n, m) = self.allowed.shape();
        let prior = ((1.0 - FOREIGN) / (FOREIGN * m.max(1) as f64)).ln();
        DMatrix::from_fn(n, m, |i, a| {
            if self.given[i] == Some(a) {
                return GIVEN;
            }
            if !self.allowed[(i, a)] {
                return f64::NEG_INFINITY;
            }
            let t = &self.terms[i][a];
            let own = t.ln_density(form, true);
            let ln_p = if misread > 0.0 && t.shape.is_some() {
                let by_shape = misread.ln() - self.ln_band + t.ln_density(form, false);
                let by_both = (1.0 - misread).ln() + own;
                by_shape.max(by_both) + (-(by_shape - by_both).abs()).exp().ln_1p()
            } else {
                own
            };
            ln_p - self.none[i] + prior + t.label
        })
    }

    /// Model form and factor of the noise with the largest evidence of the best assignment, and that; of what [`Self::spread`] gives.
    pub(crate) fn form(&self, misread: f64) -> (Form, f64) {
        // Most pairs are hopeless with any form; what is left is little.
        let mut left = self.clone();
        let corners = CORNERS.map(|form| self.ln_odds(form, misread));
        left.allowed
            .iter_mut()
            .enumerate()
            .for_each(|(k, is)| *is &= corners.iter().any(|c| c.as_slice()[k] > HOPELESS));
        let score = |i: usize, j: usize| {
            let odds = left.ln_odds(Form { tau: FORMS[i], k: FACTORS[j] }, misread);
            score(&odds, &best(&odds)) - PER_DOUBLING * (i + j) as f64
        };
        // Each has one peak in the other, but for a plateau: both coordinates in turn until neither moves, from two corners.
        let mut found = (0, 0, f64::NEG_INFINITY);
        for start in [(0, 0), (FORMS.len() - 2, 2)] {
            let (mut i, mut j) = start;
            let mut value = score(i, j);
            loop {
                let along_tau = (0..FORMS.len()).map(|k| (score(k, j), k)).max_by(|a, b| a.0.total_cmp(&b.0));
                i = along_tau.map_or(i, |b| b.1);
                let along_k = (0..FACTORS.len()).map(|k| (score(i, k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
                let (new, at) = along_k.unwrap_or((value, j));
                j = at;
                if new <= value + 1e-9 {
                    value = value.max(new);
                    break;
                }
                value = new;
            }
            if value > found.2 {
                found = (i, j, value);
            }
        }
        (Form { tau: FORMS[found.0], k: FACTORS[found.1] }, found.2)
    }

    /// JᵀV⁻¹J and JᵀV⁻¹z of the pairs, V with noise and model form and without the spread of the parameters.
    ///
    /// * `misread` - as of [`Self::ln_odds`]: a frequency that is noted wrongly pulls nothing
    pub(crate) fn normal_equations(
        &self,
        pairs: &[Option<usize>],
        form: Form,
        misread: f64,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.n_parameters;
        let (mut h, mut g) = (DMatrix::zeros(p, p), DVector::zeros(p));
        for (i, a) in pairs.iter().enumerate() {
            let Some(a) = a else { continue };
            let (own_h, own_g) = self.terms[i][*a].normal_equations(form, misread > 0.0);
            h += own_h;
            g += own_g;
        }
        (h, g)
    }
}

impl Terms {
    fn new(
        m: &Measured<'_>,
        u: Option<&(Vec<usize>, DVector<f64>, DVector<f64>)>,
        modelled: &[Modelled],
        a: usize,
    ) -> Self {
        let own = &modelled[a];
        let p = own.d_ln_f.len();
        let sd = (m.frequency.1 / m.frequency.0).max(LEAST_FREQUENCY_SD);
        let z = (m.frequency.0 / own.frequency).ln() / sd;
        let coupling = |b: usize| {
            let (la, lb) = (own.frequency.powi(2), modelled[b].frequency.powi(2));
            2.0 * COUPLING * (la * lb).sqrt() / (la - lb).abs().max(f64::MIN_POSITIVE)
        };
        let mut others: Vec<usize> = (0..modelled.len()).filter(|&b| b != a).collect();
        others.sort_by(|&b, &c| coupling(c).total_cmp(&coupling(b)));
        others.truncate(MIXED);
        let label = match (m.label, &own.label) {
            (Some(measured), Some(model)) => measured.ln_odds(model),
            _ => 0.0,
        };
        let mut out = Self { z, slope: &own.d_ln_f / sd, sd, couplings: Vec::new(), shape: None, label };
        let Some((rows, y, s)) = u else { return out };
        let at = |v: &DVector<f64>| DVector::from_iterator(rows.len(), rows.iter().map(|&r| v[r]));
        let phi = at(&own.shape);
        let length = phi.norm();
        out.couplings = others.iter().map(|&b| coupling(b)).collect();
        let unit = if length > 0.0 { &phi / length } else { phi.clone() };
        let sign = if unit.dot(y) < 0.0 { -1.0 } else { 1.0 };
        let n = rows.len();
        let mut columns = DMatrix::zeros(n, p + others.len() + 1);
        let mut put = |k: usize, v: DVector<f64>| {
            let along = unit.dot(&v);
            let tangent = (v - &unit * along).component_div(s);
            columns.set_column(k, &tangent);
        };
        if length > 0.0 {
            for j in 0..p {
                put(j, at(&own.d_shape.column(j).into_owned()) / length);
            }
            for (k, &b) in others.iter().enumerate() {
                put(p + k, at(&modelled[b].shape) / length);
            }
        }
        put(p + others.len(), y * sign);
        let ln_sd = s.iter().map(|v| v.ln()).sum();
        out.shape = Some(Shape { gram: columns.tr_mul(&columns), n: n as f64, ln_sd });
        out
    }

    /// Number of parameters.
    fn p(&self) -> usize {
        self.slope.len()
    }

    /// c_ab.
    fn mixing(&self, form: Form) -> Vec<f64> {
        self.couplings.iter().map(|c| (c * form.tau).min(1.0)).collect()
    }

    /// Columns of C^½ instead of those of the parameters.
    fn spread(&mut self, spread: &DMatrix<f64>) {
        let p = self.p();
        self.slope = spread.tr_mul(&self.slope);
        if let Some(shape) = &mut self.shape {
            let rest = shape.gram.ncols() - p;
            let corner = spread.tr_mul(&shape.gram.view((0, 0), (p, p)).into_owned()) * spread;
            let side = spread.tr_mul(&shape.gram.view((0, p), (p, rest)).into_owned());
            shape.gram.view_mut((0, 0), (p, p)).copy_from(&corner);
            shape.gram.view_mut((0, p), (p, rest)).copy_from(&side);
            shape.gram.view_mut((p, 0), (rest, p)).copy_from(&side.transpose());
        }
    }

    /// ln p of the pair; without its frequency where `of_frequency` is not set.
    fn ln_density(&self, form: Form, of_frequency: bool) -> f64 {
        let p = self.p();
        let mixing = self.mixing(form);
        let q = p + mixing.len() + 1;
        let mut a = DMatrix::identity(q, q);
        let mut b = DVector::zeros(q);
        let (mut square, mut ln_norm) = (0.0, 0.0);
        if of_frequency {
            // Columns: parameters, mixing, model form in frequency.
            let mut of_f = DVector::zeros(q);
            of_f.rows_mut(0, p).copy_from(&self.slope);
            of_f[q - 1] = form.tau / self.sd;
            a += &of_f * of_f.transpose();
            b += &of_f * self.z;
            square += self.z * self.z;
            ln_norm -= (self.sd * TAU.sqrt()).ln();
        }
        if let Some(shape) = &self.shape {
            let over = 1.0 / (form.k * form.k);
            let scale = |i: usize| if i < p { 1.0 } else { mixing[i - p] };
            let last = q - 1;
            for j in 0..last {
                for i in 0..last {
                    a[(i, j)] += scale(i) * scale(j) * shape.gram[(i, j)] * over;
                }
                b[j] += scale(j) * shape.gram[(j, last)] * over;
            }
            square += shape.gram[(last, last)] * over;
            let per_sensor = shape.ln_sd / shape.n + (form.k * TAU.sqrt()).ln();
            ln_norm -= (shape.n - 1.0) * per_sensor;
        }
        let Some(factor) = a.cholesky() else { return f64::NEG_INFINITY };
        let ln_det: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let chi2 = square - b.dot(&factor.solve(&b));
        -0.5 * chi2.max(0.0) - 0.5 * ln_det + ln_norm
    }

    fn normal_equations(&self, form: Form, may_be_misread: bool) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.p();
        // V of the frequency is 1 + (τ/s)².
        let mut over_f = 1.0 / (1.0 + (form.tau / self.sd).powi(2));
        if may_be_misread && self.shape.is_some() && self.z * self.z * over_f > MISREAD * MISREAD {
            over_f = 0.0;
        }
        let mut h = &self.slope * self.slope.transpose() * over_f;
        let mut g = &self.slope * (self.z * over_f);
        let Some(shape) = &self.shape else { return (h, g) };
        let over = 1.0 / (form.k * form.k);
        let mixing = DVector::from_vec(self.mixing(form));
        let m = mixing.len();
        let gram = &shape.gram;
        let jj = gram.view((0, 0), (p, p)).into_owned() * over;
        let jz = gram.view((0, p + m), (p, 1)).column(0).into_owned() * over;
        let scale = DMatrix::from_diagonal(&mixing);
        let jw = gram.view((0, p), (p, m)) * &scale * over;
        let wz = &scale * gram.view((p, p + m), (m, 1)).column(0) * over;
        let ww = DMatrix::identity(m, m) + &scale * gram.view((p, p), (m, m)) * &scale * over;
        let Some(factor) = ww.cholesky() else { return (h, g) };
        h += jj - &jw * factor.solve(&jw.transpose());
        g += jz - &jw * factor.solve(&wz);
        (h, g)
    }
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
