//! A fitted modal model: what a fit finds and what the covariances of its modes need.

use super::poles::{Poles, ResidualTerms};
use retune_linalg::{Complex, DMatrix};

/// A fitted modal model with what its covariances need.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) poles: Poles,
    pub(super) terms: ResidualTerms,
    /// ψ (outputs x modes) of receptance, m/(N s).
    pub(super) shapes: DMatrix<Complex<f64>>,
    /// Real coefficients c of each output, of (iω/ω_ref)^k, `[input * n_terms + term]`, receptance.
    pub(super) residuals: DMatrix<f64>,
    /// Frequency that scales the residual terms, rad/s.
    pub(super) omega_ref: f64,
    /// Covariance of (Re, Im) of every unknown of `poles.unknowns()`: rad/s for poles, 1 for participation.
    pub(super) covariance: DMatrix<f64>,
    /// Per mode and output: covariance of (Re ψ, Im ψ) at fixed poles, [rr, ri, ii].
    pub(super) local: Vec<Vec<[f64; 3]>>,
    /// Per mode: (2 outputs x unknowns) derivative of (Re ψ, Im ψ) to the unknowns.
    pub(super) slope: Vec<DMatrix<f64>>,
    /// Residual noise sd per real component and output (relative to the line weights when there are any).
    pub(super) sigma: Vec<f64>,
    /// Factor of every sd of each mode for misfit and correlation near its resonance, >= 1.
    pub(super) inflation: Vec<f64>,
    /// Local variance near each resonance over that of the whole band, correlation counted; may be below 1.
    pub(super) level: Vec<f64>,
    /// -2 ln L + (number of fitted quantities) ln (number of data of an output): the Bayesian information criterion.
    pub(super) bic: f64,
    pub(super) is_converged: bool,
    pub(super) left: Left,
    /// What the channels of a reference have in common in their noise, once asked for; `covariance` and `inflation` then contain it.
    pub(super) common: Option<Common>,
}

/// What a fit leaves over, per line, in units of its noise.
#[derive(Debug, Clone)]
pub(super) struct Left {
    /// Σ |e|²/σ² over outputs and inputs.
    pub(super) power: Vec<f64>,
    /// Σ Re(e_l* e_(l+1))/σ² over the same.
    pub(super) product: Vec<f64>,
}

/// What the common noise adds.
#[derive(Debug, Clone)]
pub(super) struct Common {
    /// Covariance of the unknowns from the independent noise alone, units of `Fit::covariance`.
    pub(super) white: DMatrix<f64>,
    /// The same of the shapes at fixed poles, as `Fit::local`.
    pub(super) local: Vec<Vec<[f64; 3]>>,
    /// Per mode: the unknowns' part of each line's common noise of sd 1, (unknowns x columns).
    pub(super) theta: Vec<DMatrix<f64>>,
    /// Per mode: the same of (Re ψ, Im ψ), (2 outputs x columns).
    pub(super) shapes: Vec<DMatrix<f64>>,
    /// Mean square of what is left at each line near a resonance over what this noise makes expect, and the number of independent
    /// values behind it; both for the inflation.
    pub(super) expected: Vec<f64>,
    /// Variance of Σ_o |r_o|² per line under the model.
    pub(super) spread: Vec<f64>,
}

/// The function of an output and an input by a fitted model at s, 1/s: `order` derivatives of the receptance.
pub(super) fn model(
    fit: &Fit,
    order: i32,
    n_inputs: usize,
    output: usize,
    input: usize,
    s: Complex<f64>,
) -> Complex<f64> {
    let mut sum = Complex::new(0.0, 0.0);
    for r in 0..fit.poles.len() {
        let residue = fit.shapes[(output, r)] * fit.poles.participation[r][input];
        let lambda = fit.poles.values[r];
        sum += residue / (s - lambda) + residue.conj() / (s - lambda.conj());
    }
    let ResidualTerms { lower, upper } = fit.terms;
    let n_terms = fit.residuals.nrows() / n_inputs;
    let front = s.powi(order);
    let mut value = front * sum;
    for t in 0..n_terms {
        let k = if t < lower { -2 - t as i32 } else { (t - lower).min(upper) as i32 };
        // Together, so that the mass line of accelerance is finite at 0 Hz.
        value += (s / fit.omega_ref).powi(order + k)
            * fit.omega_ref.powi(order)
            * fit.residuals[(input * n_terms + t, output)];
    }
    value
}
