//! Densities of measured shapes under a model: noise, errors of the stiffness that mix modes, rigid-body motion.

use crate::data::TestMode;
use crate::identify::real_shape;
use crate::linalg::{DMatrix, DVector, DVectorView};
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

/// One shape at one point of the grid: V⁻¹ = diag(1/σ²) - Bᵀ B, with as many rows of B as modes take part, and ln det V.
pub(super) struct Density {
    weight: DVector<f64>,
    /// B, (mode x sensor).
    taken: DMatrix<f64>,
    /// Norms of the columns of B.
    norms: DVector<f64>,
    pub(super) log_det: f64,
}

impl Density {
    fn new(weight: Vec<f64>, taken: DMatrix<f64>, log_det: f64) -> Self {
        let norms = DVector::from_iterator(taken.ncols(), taken.column_iter().map(|c| c.norm()));
        Self { weight: weight.into(), taken, norms, log_det }
    }

    /// V⁻¹ a, one column after the other.
    pub(super) fn times(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = a.column_iter().map(|c| self.times_vector(&c.into_owned())).collect();
        if columns.is_empty() { a.clone() } else { DMatrix::from_columns(&columns) }
    }

    /// V⁻¹ y.
    pub(super) fn times_vector(&self, y: &DVector<f64>) -> DVector<f64> {
        y.component_mul(&self.weight) - self.taken.tr_mul(&(&self.taken * y))
    }

    /// hᵀ V⁻¹ h of every column h.
    pub(super) fn forms(&self, columns: &DMatrix<f64>) -> Vec<f64> {
        let taken = &self.taken * columns;
        let of = |(h, t): (DVectorView<'_, f64>, DVectorView<'_, f64>)| {
            h.iter().zip(self.weight.iter()).map(|(v, w)| w * v * v).sum::<f64>() - t.norm_squared()
        };
        columns.column_iter().zip(taken.column_iter()).map(of).collect()
    }

    /// An entry of V⁻¹.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        if i == j { self.own(i) } else { -self.taken.column(i).dot(&self.taken.column(j)) }
    }

    /// One of its diagonal.
    pub(super) fn own(&self, i: usize) -> f64 {
        self.weight[i] - self.norms[i].powi(2)
    }

    /// yᵀ V⁻¹ y of some entries of y alone.
    pub(super) fn form_of(&self, y: &DVector<f64>, of: &[usize]) -> f64 {
        let mut taken = DVector::zeros(self.taken.nrows());
        for &i in of {
            taken.axpy(y[i], &self.taken.column(i), 1.0);
        }
        of.iter().map(|&i| self.weight[i] * y[i] * y[i]).sum::<f64>() - taken.norm_squared()
    }

    /// No more than (V⁻¹)ᵢᵢ + (V⁻¹)ⱼⱼ - 2 (V⁻¹)ᵢⱼ, from norms alone.
    pub(super) fn least_between(&self, i: usize, j: usize) -> f64 {
        (self.weight[i] + self.weight[j] - (self.norms[i] + self.norms[j]).powi(2)).max(0.0)
    }
}

/// Motions of the model at the sensors.
pub(super) struct Motions {
    /// (sensor x rigid-body mode).
    pub(super) rigid: DMatrix<f64>,
    /// (sensor x elastic mode).
    pub(super) elastic: DMatrix<f64>,
    /// Eigenvalues of the elastic modes, (rad/s)².
    pub(super) lambda: Vec<f64>,
}

/// A measured shape with what its density needs.
pub(super) struct Shape {
    pub(super) test_mode: usize,
    pub(super) y: DVector<f64>,
    pub(super) noise: DVector<f64>,
    pub(super) rms: f64,
    /// Amplitude A.
    pub(super) amplitude: f64,
    /// ω² of its frequency.
    square: f64,
    /// Sensors where the structure differs from the model.
    pub(super) forces: Vec<usize>,
    /// c_j at each error.
    pub(super) shares: Vec<DVector<f64>>,
    /// By error, then factor.
    pub(super) densities: Vec<Density>,
}

/// Standard deviation of an entry that may be anything, in units of the shape's root mean square.
pub(super) const WIDE: f64 = 3.0;
/// Noise of an entry that says nothing, in units of the shape's root mean square.
pub(super) const NOTHING: f64 = 1e3;

impl Shape {
    /// Log-density of the entries as noise of their own size, but for n/2 ln 2π.
    pub(super) fn of_none(&self) -> f64 {
        let one = |s: &f64| if *s >= NOTHING * self.rms { 2.0 * s.ln() } else { 1.0 + 2.0 * self.rms.ln() };
        -0.5 * self.noise.iter().map(one).sum::<f64>()
    }

    /// g h: what a force at a sensor's point, of the size that is allowed for, adds to the shape beyond what an error of the stiffness mixes; a
    /// column for each of some sensors.
    pub(super) fn forces(&self, sensors: &[usize], error: usize, motions: &Motions) -> DMatrix<f64> {
        let mut own = motions.elastic.select_rows(sensors);
        for (j, mut column) in own.column_iter_mut().enumerate() {
            let share = self.shares[error][j];
            column *= if share < 1.0 { (1.0 - share.powi(2)) / (motions.lambda[j] - self.square) } else { 0.0 };
        }
        let mut h = &motions.elastic * own.transpose();
        h -= &motions.rigid * motions.rigid.select_rows(sensors).transpose() / self.square;
        for mut column in h.column_iter_mut() {
            let largest = column.amax();
            column *= if largest > 0.0 && largest.is_finite() { WIDE * self.rms / largest } else { 0.0 };
        }
        h
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
    amplitude.is_finite().then(|| Shape {
        test_mode,
        y,
        noise,
        rms,
        amplitude,
        square: at,
        forces: Vec::new(),
        shares,
        densities: Vec::new(),
    })
}

/// Over the grid, by Woodbury's identity.
pub(super) fn densities(shape: &Shape, motions: &Motions) -> Vec<Density> {
    let mut out = Vec::with_capacity(ERRORS.len() * FACTORS.len());
    for (e, (share, error)) in shape.shares.iter().zip(ERRORS).enumerate() {
        let mut columns = columns(shape, share, &motions.elastic, Some((&motions.rigid, rigid_share(error))));
        if !shape.forces.is_empty() {
            let (n, forces) = (columns.ncols(), shape.forces(&shape.forces, e, motions));
            columns = columns.resize_horizontally(n + forces.ncols(), 0.0);
            columns.columns_mut(n, forces.ncols()).copy_from(&forces);
        }
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
        return Density::new(weight, DMatrix::zeros(0, n), f64::INFINITY);
    };
    let log_det = log_noise + 2.0 * cholesky.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    // The lower triangle is regular where the factorisation exists.
    let taken = cholesky.l_dirty().solve_lower_triangular(&weighted.transpose());
    Density::new(weight, taken.unwrap_or_else(|| DMatrix::zeros(0, n)), log_det)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// V⁻¹ in parts is the inverse of V = D + w wᵀ, and the bound from norms holds.
    #[test]
    fn an_inverse_in_parts_is_the_inverse() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let (n, q) = (9, 4);
        let noise = DVector::from_fn(n, |_, _| rng.random_range(0.05..0.2));
        let columns = DMatrix::from_fn(n, q, |_, _| rng.random_range(-1.0..1.0));
        let y = DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
        let density = density(&noise, 2.0, &columns);
        let v = DMatrix::from_diagonal(&noise.map(|s| 4.0 * s * s)) + &columns * columns.transpose();
        let inverse = v.clone().try_inverse().unwrap();
        let size = inverse.amax();
        assert!((density.times(&DMatrix::identity(n, n)) - &inverse).amax() < 1e-11 * size);
        assert!((density.times_vector(&y) - &inverse * &y).amax() < 1e-11 * size);
        assert!((density.log_det - v.determinant().ln()).abs() < 1e-10);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            assert!((density.at(i, j) - inverse[(i, j)]).abs() < 1e-11 * size);
            let between = inverse[(i, i)] + inverse[(j, j)] - 2.0 * inverse[(i, j)];
            assert!(i == j || density.least_between(i, j) <= between + 1e-11 * size, "{i} {j}");
        }
        let some = [1, 4, 7];
        let part = DVector::from_fn(n, |i, _| if some.contains(&i) { y[i] } else { 0.0 });
        assert!((density.form_of(&y, &some) - part.dot(&(&inverse * &part))).abs() < 1e-11 * size);
        for (form, column) in density.forms(&columns).into_iter().zip(columns.column_iter()) {
            assert!((form - column.dot(&(&inverse * column))).abs() < 1e-11 * size);
        }
    }
}
