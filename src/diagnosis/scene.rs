//! One model against one test: the least-squares problem with its priors, its optimum, and what a screening needs of it.
//!
//! ```text
//! Φ(x) = ½ |w r(x)|² + ½ Σ ((x_j - c_j)/s_j)²,    H = JᵀJ of the same rows,    w = 1/√s2 on measured rows
//! ```
//!
//! Every free parameter of the file has a Gaussian prior: its `prior_sd` where the file gives one, else half its interval
//! around its estimate. A size that an effect has brought has a Cauchy prior around its neutral value with its typical size as
//! scale: a typical size is an order of magnitude, and one that is ten times as large must not be bent towards it. It enters
//! as a row too, ρ with ½ρ² = ln(1 + z²):
//!
//! ```text
//! ρ = sign(z) √(2 ln(1 + z²)),    z = (x - c)/s,    p(x) = 1/(π s (1 + z²)), twice that where the size has one sign
//! ```
//!
//! The priors keep the problem regular where data cannot tell parameters apart, and they are what an evidence needs.

use super::DiagnosisError;
use crate::correlation::{PairBy, PairingOptions};
use crate::data::TestData;
use crate::effect::NewParameter;
use crate::linalg::{DMatrix, DVector, ThinQr, thin_qr};
use crate::model::{Model, ParametricModel};
use crate::objective::residual::{
    Damping, Frequency, FrfLog, MassPropertyResidual, Shape, StaticAngle, StaticDeflection, TargetResidual,
};
use crate::objective::{Comparison, EvalError, LeastSquares, Linearization, Objective, Residual, Scaling};
use crate::optim::{LevenbergMarquardt, Optimizer, Run};
use rayon::prelude::*;

/// Steps of a fit, at most.
pub(super) const STEPS: usize = 60;
/// A prior without a stated standard deviation: this share of the interval.
const WEAK: f64 = 0.5;

/// The prior of a parameter in the unit box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Prior {
    centre: f64,
    /// Standard deviation; scale of a Cauchy distribution.
    scale: f64,
    is_cauchy: bool,
}

impl Prior {
    /// No prior to speak of, for rows that are never read.
    pub(super) const NONE: Self = Self { centre: 0.0, scale: 1.0, is_cauchy: false };

    /// The row and its slope.
    fn row(self, x: f64) -> (f64, f64) {
        let z = (x - self.centre) / self.scale;
        if !self.is_cauchy {
            return (z, 1.0 / self.scale);
        }
        let rho = (2.0 * (z * z).ln_1p()).sqrt().copysign(z);
        // Near zero ρ = √2 z.
        let slope = if z.abs() < 1e-6 { std::f64::consts::SQRT_2 } else { 2.0 * z / ((1.0 + z * z) * rho) };
        (rho, slope / self.scale)
    }
}

/// A model and a test, with the sizes that effects have brought into the model.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) model: Model,
    pub(super) test: TestData,
    pub(super) added: Vec<NewParameter>,
    /// Whether the model as it was given has damping: then ratios are compared, also with effects that bring none.
    pub(super) is_damped: bool,
}

impl Scene {
    /// A model without any effect, and a test.
    pub(super) fn new(model: &Model, test: &TestData) -> Self {
        let start = crate::objective::starting_point(model);
        let is_damped = model.assemble(&start).is_ok_and(|system| system.damping.is_some());
        Self { model: model.clone(), test: test.clone(), added: Vec::new(), is_damped }
    }

    /// Pairing with open gates, by shapes where there are any.
    pub(super) fn pairing(&self) -> PairingOptions {
        let by = if self.test.modes.iter().any(|m| m.shape.is_some()) { PairBy::Mac } else { PairBy::Order };
        PairingOptions { by, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true }
    }

    /// Model and test made comparable.
    pub(super) fn comparison(&self) -> Result<Comparison<'_>, DiagnosisError> {
        Ok(Comparison::new(&self.model, &self.test, self.pairing())?)
    }

    /// The estimates of the model, moved into their bounds, in the unit box.
    pub(super) fn start(&self) -> DVector<f64> {
        Scaling::new(&self.model).x(&crate::objective::starting_point(&self.model))
    }

    /// The prior of each free parameter.
    pub(super) fn priors(&self) -> Vec<Prior> {
        let parameters = self.model.parameters();
        let centre = self.start();
        let free = parameters.free();
        free.iter()
            .enumerate()
            .map(|(k, &i)| {
                let p = parameters.get(i);
                let [lower, upper] = p.bounds.unwrap_or([0.0, 1.0]);
                let width = upper - lower;
                if let Some(new) = self.added.iter().find(|a| a.name == p.name) {
                    let centre = (new.neutral - lower) / width;
                    let typical = (new.typical - new.neutral).abs() / width;
                    return if typical > 0.0 {
                        Prior { centre, scale: typical, is_cauchy: true }
                    } else {
                        Prior { centre, scale: WEAK, is_cauchy: false }
                    };
                }
                match p.prior_sd {
                    Some(sd) => Prior { centre: (p.value - lower) / width, scale: sd / width, is_cauchy: false },
                    None => Prior { centre: centre[k], scale: WEAK, is_cauchy: false },
                }
            })
            .collect()
    }

    /// ln of the normalisers of the priors of sizes that an effect has brought, beside the 1/√2π of every Gaussian, which
    /// Laplace's method takes back.
    pub(super) fn ln_size_priors(&self, sizes: &[NewParameter]) -> f64 {
        let parameters = self.model.parameters();
        let (free, priors) = (parameters.free(), self.priors());
        sizes
            .iter()
            .filter_map(|new| {
                let k = free.iter().position(|&i| parameters.get(i).name == new.name)?;
                let tails = if priors[k].is_cauchy { 0.5 * (2.0 / std::f64::consts::PI).ln() } else { 0.0 };
                let sides = if new.one_sided() { std::f64::consts::LN_2 } else { 0.0 };
                Some(tails + sides - priors[k].scale.ln())
            })
            .sum()
    }
}

/// The rows of the problem.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    pub(super) n_modes: usize,
    pub(super) n_sensors: usize,
    /// Rows of measured data; targets and priors follow.
    pub(super) measured: usize,
    pub(super) targets: usize,
    pub(super) priors: usize,
    pub(super) has_shapes: bool,
}

impl Rows {
    pub(super) fn len(self) -> usize {
        self.measured + self.targets + self.priors
    }

    /// Row of a shape entry.
    pub(super) fn shape(self, mode: usize, sensor: usize) -> usize {
        self.n_modes + mode * self.n_sensors + sensor
    }
}

/// The objective Φ.
#[derive(Debug)]
pub(super) struct Posed<'a> {
    comparison: &'a Comparison<'a>,
    data: LeastSquares<'a>,
    priors: Vec<Prior>,
    weight: f64,
    pub(super) rows: Rows,
}

impl<'a> Posed<'a> {
    /// Frequencies, shapes where the test has them, mass properties, static deflections and angles, amplitudes of frequency
    /// responses where the test says that a fit uses them, and damping ratios if `is_damped`; then targets and priors.
    pub(super) fn new(comparison: &'a Comparison<'a>, priors: Vec<Prior>, weight: f64, is_damped: bool) -> Self {
        let has_shapes = comparison.has_shapes();
        let mut terms: Vec<&dyn Residual> = vec![&Frequency];
        if has_shapes {
            terms.push(&Shape);
        }
        terms.extend([&MassPropertyResidual as &dyn Residual, &StaticDeflection, &StaticAngle, &FrfLog]);
        if is_damped {
            terms.push(&Damping);
        }
        let measured = terms.iter().map(|t| t.len(comparison)).sum();
        terms.push(&TargetResidual);
        let rows = Rows {
            n_modes: comparison.test().modes.len(),
            n_sensors: comparison.test().sensors.len(),
            measured,
            targets: TargetResidual.len(comparison),
            priors: priors.len(),
            has_shapes,
        };
        Self { comparison, data: LeastSquares::with_terms(comparison, terms), priors, weight, rows }
    }

    fn extend(&self, data: &DVector<f64>, x: &DVector<f64>) -> DVector<f64> {
        let n = data.len();
        DVector::from_fn(self.rows.len(), |i, _| {
            if i < self.rows.measured {
                data[i] * self.weight
            } else if i < n {
                data[i]
            } else {
                self.priors[i - n].row(x[i - n]).0
            }
        })
    }

    /// Weighted rows of data and targets at θ, priors zero.
    pub(super) fn data_rows(&self, theta: &[f64]) -> Result<DVector<f64>, EvalError> {
        let prediction = self.comparison.predict(theta)?;
        let mut r = self.data.residuals_of(theta, &prediction).resize_vertically(self.rows.len(), 0.0);
        r.rows_mut(0, self.rows.measured).scale_mut(self.weight);
        if r.iter().all(|v| v.is_finite()) { Ok(r) } else { Err(EvalError::NotFinite { name: "data".into() }) }
    }
}

impl Objective for Posed<'_> {
    fn n_parameters(&self) -> usize {
        self.priors.len()
    }

    fn n_residuals(&self) -> usize {
        self.rows.len()
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        Ok(self.extend(&self.data.residuals(x)?, x))
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        let Linearization { residuals, mut jacobian } = self.data.linearize(x)?;
        jacobian.rows_mut(0, self.rows.measured).scale_mut(self.weight);
        let n = residuals.len();
        let mut jacobian = jacobian.resize_vertically(self.rows.len(), 0.0);
        for (j, prior) in self.priors.iter().enumerate() {
            jacobian[(n + j, j)] = prior.row(x[j]).1;
        }
        Ok(Linearization { residuals: self.extend(&residuals, x), jacobian })
    }
}

/// An optimum and what belongs to it.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) x: DVector<f64>,
    pub(super) theta: Vec<f64>,
    /// Weighted rows r and their Jacobian.
    pub(super) r: DVector<f64>,
    pub(super) j: DMatrix<f64>,
    /// Φ.
    pub(super) phi: f64,
    /// Σ over measured rows of ((model - test)/σ)², with the stated σ.
    pub(super) misfit: f64,
    pub(super) rows: Rows,
    /// Shapes of the partners at the sensors, zero columns without partner, (n_sensor x n_mode).
    pub(super) shapes: DMatrix<f64>,
    /// Mass-normalised shapes of the partners on the dofs, zero without partner, (n_dof x n_mode).
    pub(super) modes_at: DMatrix<f64>,
    /// Real test shapes and 1/σ of every entry, zero where not measured.
    pub(super) test_shapes: DMatrix<f64>,
    pub(super) inverse_sd: DMatrix<f64>,
    /// Frequencies of the partners, NaN without.
    pub(super) frequencies: Vec<f64>,
    /// Measured modes without a partner.
    pub(super) unpaired: Vec<usize>,
}

/// Fits a scene from several starts and keeps the lowest; the first of equal ones.
///
/// Errors: no start can be evaluated.
pub(super) fn fit(scene: &Scene, starts: &[DVector<f64>], weight: f64) -> Result<Fit, DiagnosisError> {
    fit_from(scene, starts, weight, starts.len(), STEPS)
}

/// The same from the first start and those with the lowest objective, `most` in all, with at most `steps` steps each.
pub(super) fn fit_from(
    scene: &Scene,
    starts: &[DVector<f64>],
    weight: f64,
    most: usize,
    steps: usize,
) -> Result<Fit, DiagnosisError> {
    let comparison = scene.comparison()?;
    let posed = Posed::new(&comparison, scene.priors(), weight, scene.is_damped);
    let x = if posed.n_parameters() == 0 {
        DVector::zeros(0)
    } else {
        // A tenth of a unit of ln evidence is far below what any decision rests on; the tolerance is 1e-7 of Φ.
        let method = LevenbergMarquardt { steps, tolerance: 1e-7, ..LevenbergMarquardt::default() };
        let chosen = lowest(&posed, starts, most);
        let found: Vec<_> = chosen
            .par_iter()
            .map(|start| method.minimize(start, &mut Run::new(&posed)).map(|o| (o.cost, o.x)))
            .collect();
        let mut best: Option<(f64, DVector<f64>)> = None;
        let mut failure = None;
        for result in found {
            match result {
                Ok((cost, x)) if best.as_ref().is_none_or(|b| cost < b.0) => best = Some((cost, x)),
                Ok(_) => {}
                Err(e) => failure = Some(e),
            }
        }
        match (best, failure) {
            (Some((_, x)), _) => x,
            (None, Some(e)) => return Err(e.into()),
            (None, None) => return Err(DiagnosisError::NoStart),
        }
    };
    at(&comparison, &posed, x)
}

/// The first of the points, then those with the lowest objective, in that order.
fn lowest(posed: &Posed<'_>, points: &[DVector<f64>], most: usize) -> Vec<DVector<f64>> {
    if points.len() <= most {
        return points.to_vec();
    }
    let mut costs: Vec<(f64, usize)> =
        points.par_iter().enumerate().skip(1).map(|(i, x)| (posed.cost(x).unwrap_or(f64::INFINITY), i)).collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    std::iter::once(0).chain(costs.iter().map(|c| c.1)).take(most).map(|i| points[i].clone()).collect()
}

/// The problem at a point, without a fit.
pub(super) fn evaluate(scene: &Scene, x: DVector<f64>, weight: f64) -> Result<Fit, DiagnosisError> {
    let comparison = scene.comparison()?;
    at(&comparison, &Posed::new(&comparison, scene.priors(), weight, scene.is_damped), x)
}

fn at(comparison: &Comparison<'_>, posed: &Posed<'_>, x: DVector<f64>) -> Result<Fit, DiagnosisError> {
    let Linearization { residuals: r, jacobian: j } = posed.linearize(&x)?;
    let theta = posed.data.scaling().theta(&x);
    let prediction = comparison.predict(&theta)?;
    let rows = posed.rows;
    let (n, m) = (rows.n_sensors, rows.n_modes);
    let mut shapes = DMatrix::zeros(n, m);
    let mut modes_at = DMatrix::zeros(prediction.modes.shapes.nrows(), m);
    let mut frequencies = vec![f64::NAN; m];
    let mut unpaired = Vec::new();
    for (mode, f) in frequencies.iter_mut().enumerate() {
        match prediction.partner(mode) {
            Some(a) => {
                shapes.set_column(mode, &prediction.at_sensors.column(a));
                modes_at.set_column(mode, &prediction.modes.shapes.column(prediction.modes.n_rigid + a));
                *f = prediction.frequencies_hz[a];
            }
            None => unpaired.push(mode),
        }
    }
    let mut test_shapes = comparison.shapes().clone();
    let inverse_sd = DMatrix::from_fn(n, m, |i, k| match &comparison.test().modes[k].shape_sd {
        Some(sd) if !test_shapes[(i, k)].is_nan() => 1.0 / sd[i],
        _ => 0.0,
    });
    test_shapes.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
    let misfit = r.rows(0, rows.measured).norm_squared() / (posed.weight * posed.weight);
    let phi = 0.5 * r.norm_squared();
    Ok(Fit { x, theta, r, j, phi, misfit, rows, shapes, modes_at, test_shapes, inverse_sd, frequencies, unpaired })
}

impl Fit {
    /// An orthonormal basis of what a refit of the parameters and of the scale of every shape can absorb, to first order.
    pub(super) fn basis(&self) -> Result<DMatrix<f64>, DiagnosisError> {
        let mut columns: Vec<DVector<f64>> = self.j.column_iter().map(nalgebra::Matrix::into_owned).collect();
        for mode in 0..self.rows.n_modes {
            if let Some(scale) = self.scale_direction(mode) {
                columns.push(scale);
            }
        }
        if columns.is_empty() {
            return Ok(DMatrix::zeros(self.rows.len(), 0));
        }
        Ok(thin_qr(&DMatrix::from_columns(&columns))?.q)
    }

    /// The direction of the free scale of a shape: φ/σ.
    fn scale_direction(&self, mode: usize) -> Option<DVector<f64>> {
        if !self.rows.has_shapes {
            return None;
        }
        let mut v = DVector::zeros(self.rows.len());
        for s in 0..self.rows.n_sensors {
            v[self.rows.shape(mode, s)] = self.shapes[(s, mode)] * self.inverse_sd[(s, mode)];
        }
        let norm = v.norm();
        (norm > 0.0).then(|| v / norm)
    }

    /// ln det H and the inverse of H.
    pub(super) fn hessian(&self) -> Result<(f64, DMatrix<f64>), DiagnosisError> {
        let n = self.j.ncols();
        if n == 0 {
            return Ok((0.0, DMatrix::zeros(0, 0)));
        }
        let ThinQr { r, .. } = thin_qr(&self.j)?;
        let ln_det = 2.0 * r.diagonal().iter().map(|d| d.abs().ln()).sum::<f64>();
        let inverse = r.solve_upper_triangular(&DMatrix::identity(n, n)).ok_or(DiagnosisError::Singular)?;
        Ok((ln_det, &inverse * inverse.transpose()))
    }

    /// Which rows carry noise: measured entries that exist; a target or prior row is no measurement but a prior row has
    /// the scatter of its prior.
    pub(super) fn noisy_rows(&self) -> Vec<bool> {
        let rows = self.rows;
        (0..rows.len())
            .map(|i| {
                if i < rows.n_modes {
                    true
                } else if rows.has_shapes && i < rows.shape(rows.n_modes, 0) {
                    let k = i - rows.n_modes;
                    self.inverse_sd[(k % rows.n_sensors, k / rows.n_sensors)] > 0.0
                } else {
                    i < rows.measured || i >= rows.measured + rows.targets
                }
            })
            .collect()
    }

    /// Rows of the frequency and the shape of a mode.
    pub(super) fn mode_rows(&self, mode: usize) -> Vec<usize> {
        let mut rows = vec![mode];
        if self.rows.has_shapes {
            let noisy = self.noisy_rows();
            rows.extend((0..self.rows.n_sensors).map(|s| self.rows.shape(mode, s)).filter(|&r| noisy[r]));
        }
        rows
    }
}
