//! Modal damping ratios.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = (ζ_model - ζ_test)/σ for every mode with a measured ratio, where the model has damping.
///
/// ```text
/// ζ = ζ_0 + φᵀ C φ / (2 ω),   ∂ζ = ∂ζ_0 + (2 φᵀ C ∂φ + φᵀ ∂C φ)/(2 ω) - (ζ - ζ_0) ∂λ/(2 λ)
/// ```
///
/// ζ_0 is the ratio that the model gives every mode. Where dashpots couple modes, -Re s/|s| of the coupled mode stands for φᵀCφ/2ω.
///
/// # Source
/// M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995.
#[derive(Debug, Clone, Copy)]
pub struct Damping;

/// Test modes with a measured ratio.
fn measured(comparison: &Comparison<'_>) -> Vec<usize> {
    let modes = &comparison.test().modes;
    (0..modes.len()).filter(|&i| modes[i].damping_ratio.is_some() && comparison.is_damped()).collect()
}

impl Residual for Damping {
    fn name(&self) -> &'static str {
        "damping"
    }

    fn summary(&self) -> &'static str {
        "modal damping ratios of paired modes, each over its standard deviation, where the model has damping"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        measured(comparison).len()
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        format!("damping of mode {}", measured(comparison)[row] + 1)
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        let constant = at.comparison.model().modal_damping().map_or(0.0, |zeta| zeta.at(at.theta));
        for (o, i) in out.iter_mut().zip(measured(at.comparison)) {
            let Some(test) = at.comparison.test().modes[i].damping_ratio else { continue };
            *o = at
                .prediction
                .partner(i)
                .map_or(0.0, |a| (constant + at.prediction.ratio_by_dashpots(a) - test.value) / test.sd);
        }
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let (matrices, constant) = (&at.prediction.matrices, at.comparison.model().modal_damping());
        let Ok(slopes) = matrices.derivatives(at.comparison.model(), at.theta, at.scaling.free()) else { return };
        for (row, i) in measured(at.comparison).into_iter().enumerate() {
            let (Some(a), Some(test)) = (at.prediction.partner(i), at.comparison.test().modes[i].damping_ratio) else {
                continue;
            };
            let k = at.prediction.modes.n_rigid + a;
            let lambda = at.prediction.modes.lambda[k];
            let shape = at.prediction.modes.shapes.columns(k, 1).into_owned();
            let free = at.scaling.free();
            for (j, &parameter) in free.iter().enumerate() {
                out[(row, j)] = constant.map_or(0.0, |zeta| zeta.slope(parameter)) / test.sd;
            }
            let Some(c_shape) = matrices.damping_times(&shape) else { continue };
            let derivative = at.comparison.derivatives_of_modes(at.prediction, &slopes, &[a]);
            let Some(own) = derivative.ok().and_then(|mut list| list.pop().flatten()) else { continue };
            let coupled = at.prediction.damped.as_ref();
            if let Some(all) = coupled.and_then(|d| d.ratio_slopes(a, &d.differentiate(a, &slopes, &own.shape)?)) {
                all.into_iter().enumerate().for_each(|(j, slope)| out[(row, j)] += slope / test.sd);
                continue;
            }
            let zeta = at.prediction.ratio_by_dashpots(a);
            for (j, slope) in slopes.iter().enumerate() {
                let of_matrix = slope.damping_times(&shape).map_or(0.0, |dc| shape.dot(&dc));
                let work = 2.0 * c_shape.column(0).dot(&own.shape.column(j)) + of_matrix;
                out[(row, j)] += (work / (2.0 * lambda.sqrt()) - zeta * own.lambda[j] / (2.0 * lambda)) / test.sd;
            }
        }
    }
}
