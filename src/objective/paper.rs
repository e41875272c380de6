//! The cost of Gupta, Moreno, Pfifer and Balas, equation (4).

use super::prediction::{Comparison, Prediction};
use super::residual::{Point, Residual, TargetResidual, UNPAIRED, violations};
use super::scaling::Scaling;
use super::{EvalError, Objective};
use crate::linalg::DVector;

/// The cost of the paper's equation (4), with the divisor that reproduces its reported values.
///
/// ```text
///        Σ_i (1 - MAC_i) + ‖e‖₂
/// J  =  ────────────────────────        e_i = (f_model,i - f_test,i)/f_test,i
///                 2 n
/// ```
///
/// The paper prints the numerator; its reported costs 0.353 and 0.058 are the numerator of its own tables divided by
/// 2n = 12, with the plain (not squared) norm. A measured mode without a partner counts as MAC 0 and e = 1. Mass-property
/// targets enter as the exact penalty Σ max(0, |v - target|/tolerance - 1), zero inside the tolerances: a multiplier
/// of one is far above the slope of J, so the minimum with the penalty is the constrained minimum.
///
/// # Source
/// A. Gupta, C. P. Moreno, H. Pfifer, G. J. Balas, Updating a Finite Element Based Structural Model of a Small Flexible
/// Aircraft, AIAA, 2015.
#[derive(Debug)]
pub struct PaperCost<'a> {
    comparison: &'a Comparison<'a>,
    scaling: Scaling,
    mac_weight: f64,
    divisor: f64,
}

impl<'a> PaperCost<'a> {
    /// Equation (4) divided by 2n.
    pub fn new(comparison: &'a Comparison<'a>) -> Self {
        let divisor = 2.0 * comparison.test().modes.len().max(1) as f64;
        Self { comparison, scaling: Scaling::new(comparison.model()), mac_weight: 1.0, divisor }
    }

    /// ‖e‖₂ alone: frequencies without shapes.
    pub fn frequencies_only(comparison: &'a Comparison<'a>) -> Self {
        Self { mac_weight: 0.0, divisor: 1.0, ..Self::new(comparison) }
    }

    /// The map between x and θ.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// J of a prediction, without the penalty.
    pub fn cost_of(&self, prediction: &Prediction) -> f64 {
        let modes = &self.comparison.test().modes;
        let (mut mac, mut square) = (0.0, 0.0);
        for (i, mode) in modes.iter().enumerate() {
            let partner = prediction.partner(i);
            if mode.shape.is_some() {
                mac += 1.0 - partner.map_or(0.0, |a| prediction.mac[(a, i)]);
            }
            let e = partner.map_or(1.0, |a| prediction.frequencies_hz[a] / mode.frequency_hz.value - 1.0);
            square += e * e;
        }
        (self.mac_weight * mac + square.sqrt()) / self.divisor
    }

    /// The penalty for missed mass-property targets.
    pub fn penalty(&self, prediction: &Prediction) -> f64 {
        let targets = self.comparison.model().targets();
        prediction.mass_properties.as_ref().map_or(0.0, |p| violations(&targets, p).iter().sum())
    }
}

impl Objective for PaperCost<'_> {
    fn n_parameters(&self) -> usize {
        self.scaling.len()
    }

    fn n_residuals(&self) -> usize {
        2 * self.comparison.test().modes.len() + TargetResidual.len(self.comparison)
    }

    /// A smooth stand-in for gradient methods: √(1 - MAC_i) and e_i of every mode, then the targets; its minimum is near
    /// that of J, not at it.
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        let theta = self.scaling.theta(x);
        let prediction = self.comparison.predict(&theta)?;
        let modes = &self.comparison.test().modes;
        let n = modes.len();
        let mut r = DVector::zeros(self.n_residuals());
        for (i, mode) in modes.iter().enumerate() {
            let partner = prediction.partner(i);
            if mode.shape.is_some() {
                let mac = partner.map_or(0.0, |a| prediction.mac[(a, i)]);
                r[i] = (self.mac_weight * (1.0 - mac)).max(0.0).sqrt();
            }
            r[n + i] = partner.map_or(UNPAIRED, |a| prediction.frequencies_hz[a] / mode.frequency_hz.value - 1.0);
        }
        let point =
            Point { comparison: self.comparison, scaling: &self.scaling, theta: &theta, prediction: &prediction };
        TargetResidual.evaluate(&point, &mut r.as_mut_slice()[2 * n..]);
        Ok(r)
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        let prediction = self.comparison.predict(&self.scaling.theta(x))?;
        Ok(self.cost_of(&prediction) + self.penalty(&prediction))
    }
}
