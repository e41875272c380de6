//! Evidence of a hypothesis, held-out errors, goodness of fit.

use super::fit::Fit;
use crate::error::DiagnosisError;
use crate::thresholds::LN_MISSED;
use retune::linalg::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc;

/// ln ∫ exp(-Φ) dx of the priors and the data, by Laplace's method, with the faces of the box.
///
/// ```text
/// ln Z = -Φ - ½ ln det H + Σ_j ln B_j        (constants common to all hypotheses left out)
/// B = exp(u²/2) [N((1 - μ)/s) - N((0 - μ)/s)],   s² = (H⁻¹)_jj,  μ = x - g s²,  u = g s
/// ```
///
/// B_j is the share of the Gaussian around the optimum that lies inside the interval of parameter j: 1 far inside, ½ where
/// the optimum touches a bound with zero slope g, 1/(u√2π) where the bound presses.
///
/// # Source
/// R. E. Kass, A. E. Raftery, Bayes factors, Journal of the American Statistical Association 90, 1995.
pub(crate) fn ln_evidence(fit: &Fit) -> Result<f64, DiagnosisError> {
    let (ln_det, covariance) = fit.hessian()?;
    let gradient = fit.j.tr_mul(&fit.r);
    let faces: f64 = (0..fit.x.len()).map(|j| ln_inside(fit.x[j], gradient[j], covariance[(j, j)].sqrt())).sum();
    Ok(-fit.phi - 0.5 * ln_det + faces)
}

/// ln B of one parameter.
fn ln_inside(x: f64, gradient: f64, sd: f64) -> f64 {
    let at_bound = x <= 1e-9 || x >= 1.0 - 1e-9;
    // Inside the box the slope is what the tolerance of the fit leaves.
    let u = if at_bound { (gradient * sd).abs() } else { 0.0 };
    let near = x.min(1.0 - x).max(0.0) / sd;
    let far = x.max(1.0 - x) / sd;
    if !at_bound {
        return (upper(-near) - upper(far)).max(f64::MIN_POSITIVE).ln();
    }
    if u > 20.0 {
        return -(u * std::f64::consts::TAU.sqrt()).ln();
    }
    0.5 * u * u + (upper(u) - upper(u + far)).max(f64::MIN_POSITIVE).ln()
}

/// P(N(0, 1) > z).
pub(crate) fn upper(z: f64) -> f64 {
    0.5 * erfc(z / std::f64::consts::SQRT_2)
}

/// Squared error of every mode when it is left out of the fit, in stated standard deviations.
///
/// ```text
/// e_m = (I - H_mm)⁻¹ r_m,    H = J (JᵀJ)⁻¹ Jᵀ        the error of predicting the rows of mode m from all others
/// ```
///
/// Exact for a linear model; no refit is needed. The scale of the shape that is left out stays free.
///
/// # Source
/// R. D. Cook, S. Weisberg, Residuals and Influence in Regression, 1982, section 3.4.
pub(crate) fn held_out(fit: &Fit, weight: f64) -> Result<Vec<f64>, DiagnosisError> {
    let (_, covariance) = fit.hessian()?;
    (0..fit.rows.n_modes).map(|mode| left_out(fit, &covariance, &fit.mode_rows(mode), weight)).collect()
}

/// The same of all modes and of every static reading, added.
pub(crate) fn held_out_in_all(fit: &Fit, weight: f64) -> Result<f64, DiagnosisError> {
    let (_, covariance) = fit.hessian()?;
    let readings = fit.statics.iter().map(|s| left_out(fit, &covariance, &[s.row], weight));
    Ok(held_out(fit, weight)?.iter().sum::<f64>() + readings.sum::<Result<f64, _>>()?)
}

fn left_out(fit: &Fit, covariance: &DMatrix<f64>, rows: &[usize], weight: f64) -> Result<f64, DiagnosisError> {
    let j = fit.j.select_rows(rows);
    let r = DVector::from_iterator(rows.len(), rows.iter().map(|&i| fit.r[i]));
    let a = DMatrix::identity(rows.len(), rows.len()) - &j * covariance * j.transpose();
    let e = a.lu().solve(&r).ok_or(DiagnosisError::Singular)?;
    Ok(e.norm_squared() / (weight * weight))
}

/// Degrees of freedom of the measured rows: entries less scales less what the parameters take.
pub(crate) fn degrees_of_freedom(fit: &Fit, q: &DMatrix<f64>) -> f64 {
    let noisy = fit.noisy_rows();
    (0..fit.rows.measured).filter(|&i| noisy[i]).map(|i| 1.0 - q.row(i).norm_squared()).sum()
}

/// P(χ² <= observed).
pub(crate) fn p_of_less(chi2: f64, dof: f64) -> f64 {
    ChiSquared::new(dof.max(1.0)).map_or(1.0, |noise| noise.cdf(chi2))
}

/// P(χ² >= observed) of the measured rows.
pub(crate) fn goodness_of_fit(fit: &Fit, q: &DMatrix<f64>) -> f64 {
    let dof = degrees_of_freedom(fit, q);
    let Ok(noise) = ChiSquared::new(dof.max(1.0)) else { return 1.0 };
    noise.sf(fit.r.rows(0, fit.rows.measured).norm_squared())
}

/// ln of the Bayes factor of "something else": an unknown effect that adds a random vector to the projected residual.
///
/// ```text
/// v ~ N(0, τ² I), τ at its best:   ln B = ½ (|r'|² - n - n ln(|r'|²/n)) - ½ ln n   where |r'|² > n
/// ```
pub(crate) fn something_else(residual: &DVector<f64>, dof: f64) -> f64 {
    let sum = residual.norm_squared();
    let n = dof.max(1.0);
    if sum > n { 0.5 * (sum - n - n * (sum / n).ln()) - 0.5 * n.ln() } else { -0.5 * n.ln() }
}

/// ln Σ exp.
pub(crate) fn ln_sum(terms: &[f64]) -> f64 {
    let top = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY { top } else { top + terms.iter().map(|t| (t - top).exp()).sum::<f64>().ln() }
}

/// ln of the mean of exp.
pub(crate) fn ln_mean(terms: &[f64]) -> f64 {
    ln_sum(terms) - (terms.len() as f64).ln()
}

/// How many modes more than the base a fit has that the test should have seen, and ln of the odds of that.
pub(crate) fn missed_more(base: &Fit, fit: &Fit) -> (usize, f64) {
    let all = |fit: &Fit| fit.missed.iter().map(Vec::len).sum::<usize>();
    let more = all(fit).saturating_sub(all(base));
    (more, LN_MISSED * more as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_inside_a_box_has_its_limits() {
        assert!(ln_inside(0.5, 0.0, 0.01).abs() < 1e-12, "far inside");
        assert!((ln_inside(0.0, 0.0, 0.01) - 0.5_f64.ln()).abs() < 1e-12, "on a face without slope");
        // ∫ exp(-g d - d²/2s²) dd ~ 1/g for a steep slope; over s √2π.
        let (g, s) = (1e4, 0.01);
        assert!((ln_inside(0.0, g, s) - (1.0 / (g * s * std::f64::consts::TAU.sqrt())).ln()).abs() < 1e-3);
    }
}
