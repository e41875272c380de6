//! A scene at a point, as a rule the optimum that a [race](super::race) has found, and what a screening needs of it.

use super::missed::missed_modes;
use super::rows::{Posed, Rows, StaticRow};
use super::scene::Scene;
use crate::error::DiagnosisError;
use crate::thresholds::ON_BOUND;
use retune::linalg::{DMatrix, DVector, ThinQr, thin_qr};
use retune::objective::{Comparison, Linearization, Objective};

/// An optimum and what belongs to it.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) x: DVector<f64>,
    pub(crate) theta: Vec<f64>,
    /// Weighted rows r and their Jacobian.
    pub(crate) r: DVector<f64>,
    pub(crate) j: DMatrix<f64>,
    /// Φ.
    pub(crate) phi: f64,
    /// Σ over measured rows of ((model - test)/σ)², with the stated σ.
    pub(crate) misfit: f64,
    pub(crate) rows: Rows,
    /// Rows of static readings.
    pub(crate) statics: Vec<StaticRow>,
    /// Shapes of the partners at the sensors, zero columns without partner, (n_sensor x n_mode).
    pub(crate) shapes: DMatrix<f64>,
    /// Mass-normalised shape of every mode's partner on the dofs of its model, zero without partner.
    pub(crate) modes_at: Vec<DVector<f64>>,
    /// Real test shapes and 1/σ of every entry, zero where not measured.
    pub(crate) test_shapes: DMatrix<f64>,
    pub(crate) inverse_sd: DMatrix<f64>,
    /// Frequencies of the partners, NaN without.
    pub(crate) frequencies: Vec<f64>,
    /// Measured modes without a partner that should have one.
    pub(crate) unpaired: Vec<usize>,
    /// Whether each measured mode is aside: foreign, or left out.
    pub(crate) aside: Vec<bool>,
    /// Pairs of measured modes whose partners are so close that their shapes are turned to the test: each has a free angle, rad, which is told of
    /// those that the test says are one space.
    pub(crate) turned: Vec<(usize, usize, Option<f64>)>,
    /// Frequencies of modes that each test should have seen, Hz.
    pub(crate) missed: Vec<Vec<f64>>,
}

/// The problem at a point, without a fit.
pub(crate) fn evaluate(scene: &Scene, x: DVector<f64>, weight: f64) -> Result<Fit, DiagnosisError> {
    let comparisons = scene.comparisons()?;
    at(&Posed::new(scene, &comparisons, scene.priors(), weight), x)
}

/// Φ of a scene at a point, without derivatives.
///
/// * `comparisons` - of the scene
pub(crate) fn phi_of(
    scene: &Scene,
    comparisons: &[Comparison<'_>],
    x: &DVector<f64>,
    weight: f64,
) -> Result<f64, DiagnosisError> {
    let posed = Posed::new(scene, comparisons, scene.priors(), weight);
    Ok(0.5 * posed.residuals(x)?.norm_squared())
}

fn at(posed: &Posed<'_>, x: DVector<f64>) -> Result<Fit, DiagnosisError> {
    let Linearization { residuals: r, jacobian: j } = posed.linearize(&x)?;
    let theta = posed.scaling().theta(&x);
    let rows = posed.rows;
    let (n, m) = (rows.n_sensors, rows.n_modes);
    let mut shapes = DMatrix::zeros(n, m);
    let mut test_shapes = DMatrix::zeros(n, m);
    let mut inverse_sd = DMatrix::zeros(n, m);
    let mut modes_at = vec![DVector::zeros(0); m];
    let mut frequencies = vec![f64::NAN; m];
    let mut unpaired = Vec::new();
    let mut aside = vec![false; m];
    let mut turned = Vec::new();
    let mut unseen = Vec::new();
    for part in &posed.parts {
        let prediction = part.comparison.predict(&theta)?;
        unseen.push(missed_modes(part.comparison, &prediction));
        let n_own = part.comparison.test().modes.len();
        for cluster in prediction.clusters.iter().filter(|_| part.comparison.has_shapes()) {
            let is_in = |k: &usize| prediction.partner(*k).is_some_and(|a| cluster.contains(&a));
            let own: Vec<usize> = (0..n_own).filter(is_in).map(|k| part.first_mode + k).collect();
            let pairs = own.iter().enumerate().flat_map(|(i, &a)| own[i + 1..].iter().map(move |&b| (a, b)));
            let angle = |a: usize, b: usize| prediction.mixture(a - part.first_mode, b - part.first_mode);
            turned.extend(pairs.map(|(a, b)| (a, b, angle(a, b))));
        }
        for (k, tested) in part.comparison.test().modes.iter().enumerate() {
            let mode = part.first_mode + k;
            for (i, &s) in part.sensors.iter().enumerate() {
                let reading = part.comparison.shapes()[(i, k)];
                if let Some(sd) = tested.shape_sd.as_ref().filter(|_| !reading.is_nan()) {
                    test_shapes[(s, mode)] = reading;
                    inverse_sd[(s, mode)] = 1.0 / sd[i];
                }
            }
            aside[mode] = part.comparison.is_aside(k);
            let Some(a) = prediction.partner(k) else {
                modes_at[mode] = DVector::zeros(prediction.modes.shapes.nrows());
                if !aside[mode] {
                    unpaired.push(mode);
                }
                continue;
            };
            part.sensors.iter().enumerate().for_each(|(i, &s)| shapes[(s, mode)] = prediction.at_sensors[(i, a)]);
            modes_at[mode] = prediction.modes.shapes.column(prediction.modes.n_rigid + a).into_owned();
            frequencies[mode] = prediction.frequencies_hz[a];
        }
    }
    let misfit = r.rows(0, rows.measured).norm_squared() / (posed.weight * posed.weight);
    let phi = 0.5 * r.norm_squared();
    Ok(Fit {
        x,
        theta,
        r,
        j,
        phi,
        misfit,
        rows,
        statics: posed.statics.clone(),
        shapes,
        modes_at,
        test_shapes,
        inverse_sd,
        frequencies,
        unpaired,
        aside,
        turned,
        missed: unseen,
    })
}

impl Fit {
    /// An orthonormal basis of what a refit of the parameters and of the scale of every shape can absorb, to first order.
    ///
    /// A parameter that the data push against its bound absorbs nothing more, and what it leaves is part of the misfit.
    pub(crate) fn basis(&self) -> Result<DMatrix<f64>, DiagnosisError> {
        let columns = self.j.column_iter().zip(self.x.iter());
        let can_move = |(column, x): &(_, &f64)| {
            let slope = self.r.dot(column);
            !(**x < ON_BOUND && slope > 0.0 || **x > 1.0 - ON_BOUND && slope < 0.0)
        };
        let mut columns: Vec<DVector<f64>> = columns.filter(can_move).map(|(column, _)| column.into_owned()).collect();
        for mode in 0..self.rows.n_modes {
            if let Some(scale) = self.scale_direction(mode) {
                columns.push(scale);
            }
        }
        columns.extend(self.turned.iter().filter_map(|&(a, b, _)| self.angle_direction(a, b)));
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

    /// The direction of the free angle between two shapes.
    fn angle_direction(&self, a: usize, b: usize) -> Option<DVector<f64>> {
        let v = self.angle_slope(a, b);
        let norm = v.norm();
        (norm > 0.0).then(|| v / norm)
    }

    /// The slope of the rows, without their weight, in the angle between two shapes: c_a φ_b/σ in the rows of a, -c_b φ_a/σ in those of b, with
    /// the scales c of the shapes.
    pub(crate) fn angle_slope(&self, a: usize, b: usize) -> DVector<f64> {
        let scale = |m: usize| {
            let (mut cross, mut own) = (0.0, 0.0);
            for s in 0..self.rows.n_sensors {
                let w = self.inverse_sd[(s, m)].powi(2);
                cross += w * self.shapes[(s, m)] * self.test_shapes[(s, m)];
                own += w * self.shapes[(s, m)].powi(2);
            }
            if own > 0.0 { cross / own } else { 0.0 }
        };
        let (ca, cb) = (scale(a), scale(b));
        let mut v = DVector::zeros(self.rows.len());
        for s in 0..self.rows.n_sensors {
            v[self.rows.shape(a, s)] = ca * self.shapes[(s, b)] * self.inverse_sd[(s, a)];
            v[self.rows.shape(b, s)] = -cb * self.shapes[(s, a)] * self.inverse_sd[(s, b)];
        }
        v
    }

    /// ln det H and the inverse of H.
    pub(crate) fn hessian(&self) -> Result<(f64, DMatrix<f64>), DiagnosisError> {
        let n = self.j.ncols();
        if n == 0 {
            return Ok((0.0, DMatrix::zeros(0, 0)));
        }
        let ThinQr { r, .. } = thin_qr(&self.j)?;
        let ln_det = 2.0 * r.diagonal().iter().map(|d| d.abs().ln()).sum::<f64>();
        let inverse = r.solve_upper_triangular(&DMatrix::identity(n, n)).ok_or(DiagnosisError::Singular)?;
        Ok((ln_det, &inverse * inverse.transpose()))
    }

    /// Which rows carry noise: measured entries that exist; a target or prior row is not a measurement but a prior row has
    /// the scatter of its prior.
    pub(crate) fn noisy_rows(&self) -> Vec<bool> {
        let rows = self.rows;
        (0..rows.len())
            .map(|i| {
                if i < rows.n_modes {
                    !self.aside[i]
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
    pub(crate) fn mode_rows(&self, mode: usize) -> Vec<usize> {
        let mut rows = vec![mode];
        if self.rows.has_shapes {
            let noisy = self.noisy_rows();
            rows.extend((0..self.rows.n_sensors).map(|s| self.rows.shape(mode, s)).filter(|&r| noisy[r]));
        }
        rows
    }
}

/// The weighted residual of one mode's shape with its free scale, at its measured sensors.
pub(crate) fn shape_rows(phi: &[f64], test: &[f64], inverse_sd: &[f64]) -> Vec<f64> {
    let (mut cross, mut own) = (0.0, 0.0);
    for k in 0..phi.len() {
        let w = inverse_sd[k] * inverse_sd[k];
        cross += w * phi[k] * test[k];
        own += w * phi[k] * phi[k];
    }
    let c = if own > 0.0 { cross / own } else { 0.0 };
    (0..phi.len()).map(|k| (c * phi[k] - test[k]) * inverse_sd[k]).collect()
}

/// v - Q Qᵀ v.
pub(crate) fn project(q: &DMatrix<f64>, v: &DVector<f64>) -> DVector<f64> {
    v - q * q.tr_mul(v)
}

/// (x·y)²/(x·x y·y)
pub(crate) fn mac(entries: impl Iterator<Item = (f64, f64)>) -> f64 {
    let [cross, xx, yy] = entries.fold([0.0; 3], |[c, xx, yy], (x, y)| [c + x * y, xx + x * x, yy + y * y]);
    if xx * yy > 0.0 { cross * cross / (xx * yy) } else { 0.0 }
}
