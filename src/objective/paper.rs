//! The cost of Gupta, Moreno, Pfifer and Balas, equation (4).

use super::batch::BatchPath;
use super::comparison::Comparison;
use super::prediction::Prediction;
use super::residual::{Point, Residual, TargetResidual, WIDTH, violations};
use super::scaling::Scaling;
use super::{EvalError, Linearization, Objective, PathCounts, Walls};
use crate::linalg::{DMatrix, DVector};

/// The cost of the paper's equation (4), with the divisor that reproduces its reported values.
///
/// ```text
///        Σ_i (1 - MAC_i) + ‖e‖₂
/// J  =  ────────────────────────        e_i = (f_model,i - f_test,i)/f_test,i
///                 2 n
/// ```
///
/// The paper prints the numerator; its reported costs 0.353 and 0.058 are the numerator of its own tables divided by
/// 2n = 12, with the plain (not squared) norm. A measured mode without a partner counts as MAC 0 and e = 1; one that the test
/// file leaves out does not count. Mass-property
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
    batch: BatchPath,
}

impl<'a> PaperCost<'a> {
    /// Equation (4) divided by 2n.
    pub fn new(comparison: &'a Comparison<'a>) -> Self {
        let used = comparison.test().modes.iter().filter(|m| !m.standing.is_left_out()).count();
        let divisor = 2.0 * used.max(1) as f64;
        let scaling = Scaling::new(comparison.model());
        Self { comparison, scaling, mac_weight: 1.0, divisor, batch: BatchPath::default() }
    }

    /// ‖e‖₂ alone: frequencies without shapes.
    pub fn frequencies_only(comparison: &'a Comparison<'a>) -> Self {
        Self { mac_weight: 0.0, divisor: 1.0, ..Self::new(comparison) }
    }

    /// With another map between x and θ, such as that [of a search](Scaling::for_search).
    #[must_use]
    pub fn with_scaling(mut self, scaling: Scaling) -> Self {
        self.scaling = scaling;
        self
    }

    /// The map between x and θ.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// J of a prediction, without the penalty.
    pub fn cost_of(&self, prediction: &Prediction) -> f64 {
        let modes = &self.comparison.test().modes;
        let (mut mac, mut square) = (0.0, 0.0);
        for (i, mode) in modes.iter().enumerate().filter(|(_, m)| !m.standing.is_left_out()) {
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

/// Below this norm of the frequency errors their weight in the residuals stays constant, so that it is finite.
const SMALLEST_NORM: f64 = 1e-9;

impl PaperCost<'_> {
    fn point<'b>(&'b self, theta: &'b [f64], prediction: &'b Prediction) -> Point<'b> {
        Point { comparison: self.comparison, scaling: &self.scaling, theta, prediction }
    }

    /// Relative frequency errors and their norm.
    fn errors(&self, prediction: &Prediction) -> (Vec<f64>, f64) {
        let test = &self.comparison.test().modes;
        let error = |i: usize| {
            let alone = if test[i].standing.is_left_out() { 0.0 } else { 1.0 };
            prediction.partner(i).map_or(alone, |a| prediction.frequencies_hz[a] / test[i].frequency_hz.value - 1.0)
        };
        let errors: Vec<f64> = (0..test.len()).map(error).collect();
        let norm = errors.iter().map(|e| e * e).sum::<f64>().sqrt().max(SMALLEST_NORM);
        (errors, norm)
    }

    /// Sensors that measured a test mode, with the shape scaled to unit length; none where shapes do not count.
    fn unit_shape(&self, mode: usize) -> Vec<(usize, f64)> {
        if self.mac_weight == 0.0 {
            return Vec::new();
        }
        let shapes = self.comparison.shapes();
        let rows = (0..shapes.nrows()).map(|k| (k, shapes[(k, mode)])).filter(|(_, v)| !v.is_nan());
        let norm = rows.clone().map(|(_, v)| v * v).sum::<f64>().sqrt();
        rows.map(|(k, v)| (k, v / norm)).collect()
    }

    fn residuals_of(&self, theta: &[f64], prediction: &Prediction) -> DVector<f64> {
        let n = self.comparison.test().modes.len();
        let n_sensors = self.comparison.shapes().nrows();
        let mut r = DVector::zeros(self.n_residuals());
        let (errors, norm) = self.errors(prediction);
        for (i, e) in errors.iter().enumerate() {
            r[i] = e * (2.0 / (self.divisor * norm)).sqrt();
        }
        let weight = (2.0 * self.mac_weight / self.divisor).sqrt();
        for mode in 0..n {
            let test = self.unit_shape(mode);
            let at = n + mode * n_sensors;
            let partner = prediction.partner(mode).map(|a| prediction.at_sensors.column(a));
            let own = partner.map_or(0.0, |phi| test.iter().map(|&(k, _)| phi[k] * phi[k]).sum::<f64>());
            let cross = partner.map_or(0.0, |phi| test.iter().map(|&(k, t)| phi[k] * t).sum::<f64>());
            for &(k, t) in &test {
                let along = partner.filter(|_| own > 0.0).map_or(0.0, |phi| phi[k] * cross / own);
                r[at + k] = weight * (t - along);
            }
        }
        TargetResidual.evaluate(&self.point(theta, prediction), &mut r.as_mut_slice()[n + n * n_sensors..]);
        r
    }
}

impl Objective for PaperCost<'_> {
    fn n_parameters(&self) -> usize {
        self.scaling.len()
    }

    fn n_residuals(&self) -> usize {
        let n = self.comparison.test().modes.len();
        n + n * self.comparison.shapes().nrows() + TargetResidual.len(self.comparison)
    }

    /// Residuals with ½ rᵀr = J, and the walls of the targets, for gradient methods.
    ///
    /// ```text
    /// r_i = e_i √(2/(D ‖e‖))                   so that ½ Σ r_i² = ‖e‖/D,  D = 2n
    /// r_i = √(2/D) (t - a aᵀt), |a| = |t| = 1   so that ½ |r_i|² = (1 - MAC_i)/D
    /// r   = ln(1 + exp(u/0.01))                 for a target missed by u: see `walls`, which gives the penalty u
    /// ```
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        let theta = self.scaling.theta(x);
        let prediction = self.comparison.predict(&theta)?;
        Ok(self.residuals_of(&theta, &prediction))
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        let theta = self.scaling.theta(x);
        let prediction = self.comparison.predict(&theta)?;
        let derivative = self.comparison.differentiate(&theta, &prediction, self.scaling.free())?;
        let residuals = self.residuals_of(&theta, &prediction);
        let test = &self.comparison.test().modes;
        let (n, n_sensors, n_free) = (test.len(), self.comparison.shapes().nrows(), self.scaling.len());
        let mut jacobian = DMatrix::zeros(residuals.len(), n_free);
        let (errors, norm) = self.errors(&prediction);
        let of = |mode: usize| prediction.partner(mode).and_then(|a| derivative.modes[a].as_ref().map(|d| (a, d)));
        let d_error = |i: usize, j: usize| of(i).map_or(0.0, |(_, (df, _))| df[j] / test[i].frequency_hz.value);
        let factor = (2.0 / (self.divisor * norm)).sqrt();
        for j in 0..n_free {
            let d_norm: f64 = (0..n).map(|i| errors[i] * d_error(i, j)).sum::<f64>() / norm;
            for i in 0..n {
                jacobian[(i, j)] = factor * (d_error(i, j) - 0.5 * errors[i] * d_norm / norm);
            }
        }
        let weight = (2.0 * self.mac_weight / self.divisor).sqrt();
        for mode in 0..n {
            let rows = self.unit_shape(mode);
            let Some((a, (_, d_phi))) = of(mode) else { continue };
            let phi = prediction.at_sensors.column(a);
            let own: f64 = rows.iter().map(|&(k, _)| phi[k] * phi[k]).sum();
            if own == 0.0 {
                continue;
            }
            let cross: f64 = rows.iter().map(|&(k, t)| phi[k] * t).sum();
            for j in 0..n_free {
                let d_own: f64 = rows.iter().map(|&(k, _)| 2.0 * phi[k] * d_phi[(k, j)]).sum();
                let d_cross: f64 = rows.iter().map(|&(k, t)| d_phi[(k, j)] * t).sum();
                for &(k, _) in &rows {
                    let d_along =
                        (d_phi[(k, j)] * cross + phi[k] * d_cross) / own - phi[k] * cross * d_own / (own * own);
                    jacobian[(n + mode * n_sensors + k, j)] = -weight * d_along;
                }
            }
        }
        let mut block = DMatrix::zeros(TargetResidual.len(self.comparison), n_free);
        TargetResidual.differentiate(&self.point(&theta, &prediction), &derivative, &mut block);
        jacobian.rows_mut(n + n * n_sensors, block.nrows()).copy_from(&block);
        for (mut column, slope) in jacobian.column_iter_mut().zip(self.scaling.slopes(&theta)) {
            column *= slope;
        }
        Ok(Linearization { residuals, jacobian })
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        let prediction = self.comparison.predict(&self.scaling.theta(x))?;
        Ok(self.cost_of(&prediction) + self.penalty(&prediction))
    }

    fn walls(&self) -> Walls {
        let start = self.n_residuals() - TargetResidual.len(self.comparison);
        Walls::new(start..self.n_residuals(), Some(WIDTH))
    }

    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        let cost_of = |p: &Prediction, _: &[f64], _: &mut DVector<f64>| self.cost_of(p) + self.penalty(p);
        let reference = |x: &DVector<f64>| self.cost(x).unwrap_or(f64::INFINITY);
        self.batch.costs((self.comparison, &self.scaling), points, out, (false, &cost_of), reference);
    }

    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        self.batch.confirm(cost, || self.cost(x).unwrap_or(f64::INFINITY))
    }

    fn path_counts(&self) -> PathCounts {
        self.batch.counts()
    }
}
