//! Densities of measured shapes under a model: noise, errors of the stiffness that mix modes, rigid-body motion.

use crate::data::TestMode;
use crate::identify::real_shape;
use crate::linalg::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Stiffness errors of the grid.
pub(super) const ERRORS: [f64; 5] = [0.01, 0.03, 0.1, 0.2, 0.4];
/// Factors on the stated noise.
pub(super) const FACTORS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
/// Rigid-body motion that a suspension leaves in an elastic shape.
pub(super) const SUSPENSION: f64 = 0.01;
/// Rigid-body motion that an error of the masses leaves, for an error of the model of 1: δM moves a = -Φ_rᵀ δM φ, half where it sits on one side.
pub(super) const OF_MASSES: f64 = 0.5;

/// Standard deviation of rigid-body motion in a shape of size 1, at an error of the model.
pub(super) fn rigid_share(error: f64) -> f64 {
    SUSPENSION.hypot(OF_MASSES * error)
}
/// Least noise of an entry, relative to the root mean square of its shape.
pub(super) const LEAST_NOISE: f64 = 1e-3;

/// One shape at one point of the grid.
pub(super) struct Density {
    pub(super) inverse: DMatrix<f64>,
    pub(super) log_det: f64,
}

/// A measured shape with what its density needs.
pub(super) struct Shape {
    pub(super) test_mode: usize,
    pub(super) y: DVector<f64>,
    pub(super) noise: DVector<f64>,
    pub(super) rms: f64,
    /// Amplitude A.
    pub(super) amplitude: f64,
    /// c_j at each error.
    pub(super) shares: Vec<DVector<f64>>,
    /// By error, then factor.
    pub(super) densities: Vec<Density>,
}

/// Noise of an entry that says nothing, in units of the shape's root mean square.
pub(super) const NOTHING: f64 = 1e3;

impl Shape {
    /// Log-density of the entries as noise of their own size, but for n/2 ln 2π.
    pub(super) fn of_none(&self) -> f64 {
        let one = |s: &f64| if *s >= NOTHING * self.rms { 2.0 * s.ln() } else { 1.0 + 2.0 * self.rms.ln() };
        -0.5 * self.noise.iter().map(one).sum::<f64>()
    }
}

/// A test mode as a real shape with its noise; none where too little is measured.
pub(super) fn shape(test_mode: usize, mode: &TestMode, elastic: &DMatrix<f64>, lambda: &[f64]) -> Option<Shape> {
    let measured = mode.shape.as_ref()?;
    let real = real_shape(measured);
    let known: Vec<bool> = real.iter().map(|v| v.is_finite()).collect();
    let n_known = known.iter().filter(|k| **k).count();
    let y = DVector::from_fn(real.len(), |i, _| if known[i] { real[i] } else { 0.0 });
    let rms = (y.norm_squared() / n_known.max(1) as f64).sqrt();
    if n_known < 3 || !(rms > 0.0 && rms.is_finite()) || real.len() != elastic.nrows() {
        return None;
    }
    // Turned to a real shape, the scale stays that of the entries, and so do their deviations.
    let stated = |i: usize| mode.shape_sd.as_ref().map_or(0.05 * rms, |sd| sd[i]);
    // What was not measured may be anything.
    let noise =
        DVector::from_fn(y.len(), |i, _| if known[i] { stated(i).max(LEAST_NOISE * rms) } else { NOTHING * rms });
    let at = (TAU * mode.frequency_hz.value).powi(2);
    let share = |error: f64| {
        DVector::from_fn(lambda.len(), |j, _| {
            let gap = (lambda[j] - at).abs().max(f64::MIN_POSITIVE);
            (2.0 * error * (lambda[j].max(0.0) * at).sqrt() / gap).min(1.0)
        })
    };
    let shares: Vec<DVector<f64>> = ERRORS.iter().map(|e| share(*e)).collect();
    // The size of a unit of the modes that are near.
    let near = share(0.1);
    let (mut size, mut weight) = (0.0, 0.0);
    for j in 0..lambda.len() {
        size += near[j].powi(2) * elastic.column(j).norm_squared();
        weight += near[j].powi(2);
    }
    let amplitude = (y.norm_squared() * weight / size).sqrt();
    amplitude.is_finite().then(|| Shape { test_mode, y, noise, rms, amplitude, shares, densities: Vec::new() })
}

/// V⁻¹ and ln det V over the grid, by Woodbury's identity.
pub(super) fn densities(shape: &Shape, elastic: &DMatrix<f64>, rigid: &DMatrix<f64>) -> Vec<Density> {
    let mut out = Vec::with_capacity(ERRORS.len() * FACTORS.len());
    for (share, error) in shape.shares.iter().zip(ERRORS) {
        let columns = columns(shape, share, elastic, Some((rigid, rigid_share(error))));
        for factor in FACTORS {
            out.push(density(&shape.noise, factor, &columns));
        }
    }
    out
}

/// Columns w of V = D + w wᵀ.
pub(super) fn columns(
    shape: &Shape,
    share: &DVector<f64>,
    elastic: &DMatrix<f64>,
    rigid: Option<(&DMatrix<f64>, f64)>,
) -> DMatrix<f64> {
    let (n, q) = elastic.shape();
    let n_rigid = rigid.map_or(0, |(r, _)| r.ncols());
    DMatrix::from_fn(n, q + n_rigid, |i, j| match rigid {
        Some((rigid, own)) if j >= q => own * shape.amplitude * rigid[(i, j - q)],
        _ => share[j] * shape.amplitude * elastic[(i, j)],
    })
}

pub(super) fn density(noise: &DVector<f64>, factor: f64, columns: &DMatrix<f64>) -> Density {
    let n = noise.len();
    let weight: Vec<f64> = noise.iter().map(|s| 1.0 / (factor * s).powi(2)).collect();
    let weighted = DMatrix::from_fn(n, columns.ncols(), |i, j| weight[i] * columns[(i, j)]);
    let inner = DMatrix::identity(columns.ncols(), columns.ncols()) + columns.tr_mul(&weighted);
    let log_noise: f64 = -weight.iter().map(|w| w.ln()).sum::<f64>();
    // I + wᵀ D⁻¹ w is positive definite; where rounding says otherwise the noise alone is left, which no data like.
    let Some(cholesky) = inner.cholesky() else {
        return Density { inverse: DMatrix::from_diagonal(&DVector::from_vec(weight)), log_det: f64::INFINITY };
    };
    let log_det = log_noise + 2.0 * cholesky.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    let mut inverse = -(&weighted * cholesky.solve(&weighted.transpose()));
    for (i, w) in weight.iter().enumerate() {
        inverse[(i, i)] += w;
    }
    Density { inverse, log_det }
}
