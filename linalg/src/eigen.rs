//! The generalized eigenproblem K φ = λ M φ, dense.
//!
//! Solved as the inverse problem `M φ = θ (K + a M) φ`, λ = 1/θ - a, with a > 0: the low modes are the largest θ, so
//! they come out with full relative accuracy however stiff the top of the spectrum is; a singular K (a free structure)
//! and a singular M (massless dofs, θ = 0) need no special case. faer's symmetric eigensolver is not invariant under
//! scaling (its divide and conquer loses digits at norms far from one), so the matrix is scaled to unit norm first.
//!
//! Source: B. N. Parlett, The Symmetric Eigenvalue Problem, SIAM 1998, section 15.

use super::decompositions::{ShiftedPencil, leading_pencil, pencil_values};
use super::{DMatrix, DVector, LinalgError};

/// Eigenvalues in ascending order and M-orthonormal vectors as columns.
#[derive(Debug, Clone)]
pub struct Eigenpairs {
    /// λ = ω², rad²/s².
    pub values: DVector<f64>,
    /// Φ with Φᵀ M Φ = I, (n x modes).
    pub vectors: DMatrix<f64>,
}

/// The `n_modes` lowest eigenpairs of K φ = λ M φ.
///
/// * `k` - symmetric, positive semidefinite (n x n); only the lower triangle is read
/// * `m` - symmetric, positive semidefinite (n x n); it may be singular, then at most rank(M) modes come out
/// * `shift` - a > 0, rad²/s²: a value below the first elastic λ, and not below it by more than about 10⁸
///
/// Values of rigid-body modes come out as rounding noise around zero, of the order 1e-14 (a + λ_typical); the caller
/// who knows the geometry sets them to zero.
pub fn lowest_modes(k: &DMatrix<f64>, m: &DMatrix<f64>, n_modes: usize, shift: f64) -> Result<Eigenpairs, LinalgError> {
    let (theta, vectors) = leading_pencil(k, m, shift, n_modes)?;
    Ok(Eigenpairs::of(&theta, &vectors, n_modes, shift))
}

impl Eigenpairs {
    /// The `n_modes` lowest ones of a complete basis, as [`lowest_modes`] gives them.
    pub fn lowest_of(pencil: &ShiftedPencil, n_modes: usize) -> Self {
        Self::of(&pencil.theta, &pencil.vectors, n_modes, pencil.shift)
    }

    fn of(theta: &DVector<f64>, vectors: &DMatrix<f64>, n_modes: usize, shift: f64) -> Self {
        let (n, count) = (theta.len(), n_modes.min(rank(theta)));
        let values = DVector::from_fn(count, |j, _| 1.0 / theta[j] - shift);
        // x = L⁻ᵀ y has xᵀ (K + aM) x = 1, so xᵀ M x = θ.
        let vectors = DMatrix::from_fn(n, count, |i, j| vectors[(i, j)] / theta[j].sqrt());
        Self { values, vectors }
    }
}

/// The values of [`lowest_modes`] alone.
pub fn lowest_values(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    n_modes: usize,
    shift: f64,
) -> Result<DVector<f64>, LinalgError> {
    let theta = pencil_values(k, m, shift)?;
    Ok(DVector::from_fn(n_modes.min(rank(&theta)), |j, _| 1.0 / theta[j] - shift))
}

/// How many θ belong to finite frequencies: those at rounding level belong to massless dofs.
fn rank(theta: &DVector<f64>) -> usize {
    let largest = theta.iter().copied().fold(0.0, f64::max);
    theta.iter().filter(|t| **t > 1e-14 * theta.len() as f64 * largest).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(n: usize, k: f64, m: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let stiffness = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => k * if i == 0 || i == n - 1 { 1.0 } else { 2.0 },
            1 => -k,
            _ => 0.0,
        });
        (stiffness, DMatrix::identity(n, n) * m)
    }

    /// What rounding may do to λ: the eigensolver errs by n ε ‖C‖ in θ = 1/(λ + a) with ‖C‖ = 1/a, so by
    /// n ε (λ + a)²/a in λ; the Cholesky factorisation of K + a M by n ε λ_max.
    fn rounding(n: usize, lambda: f64, shift: f64, lambda_max: f64) -> f64 {
        n as f64 * f64::EPSILON * ((lambda + shift).powi(2) / shift + lambda_max)
    }

    /// Free chain of n masses: ω_j² = 4 k/m sin²(j π / 2n). Blevins, Formulas for Natural Frequency, 1979, table 6-2.
    #[test]
    fn free_chain_has_its_closed_form_at_any_scale() {
        for n in [5, 40, 256] {
            for scale in [1e-10, 1.0, 1e12] {
                let (k, m) = chain(n, scale, 1.0);
                let shift = 1e-3 * scale;
                let pairs = lowest_modes(&k, &m, 5, shift).unwrap();
                for j in 0..5 {
                    let exact = 4.0 * scale * (j as f64 * std::f64::consts::PI / (2.0 * n as f64)).sin().powi(2);
                    let tolerance = rounding(n, exact, shift, 4.0 * scale);
                    assert!((pairs.values[j] - exact).abs() < tolerance, "{n} {scale} {j}");
                }
                let gram = pairs.vectors.transpose() * &m * &pairs.vectors;
                assert!((gram - DMatrix::identity(5, 5)).abs().max() < 1e-12);
            }
        }
    }

    /// faer's divide and conquer (from 128 rows on) loses digits when the norm of its matrix is far from one: a random
    /// matrix of 256 rows times 1e10 comes back with a residual of 1e-4 of its norm. A change of units must change nothing.
    #[test]
    fn scaling_by_1e12_loses_no_digit() {
        use rand::{RngExt, SeedableRng};
        let n = 256;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(12);
        let mut gram = |factor: f64| {
            let a = DMatrix::from_fn(n, n, |_, _| rng.random::<f64>() - 0.5);
            &a * a.transpose() * factor + DMatrix::identity(n, n)
        };
        let (k, m) = (gram(10.0), gram(0.1));
        // Both spectra lie between one and the trace.
        let lambda_max = k.trace();
        let shift = 1.0;
        let plain = lowest_modes(&k, &m, 12, shift).unwrap();
        for (stiff, massive) in [(1e12, 1.0), (1e-12, 1.0), (1.0, 1e12), (1e6, 1e-6), (1e12, 1e12)] {
            let (ks, ms, factor) = (&k * stiff, &m * massive, stiff / massive);
            let scaled = lowest_modes(&ks, &ms, 12, shift * factor).unwrap();
            for j in 0..12 {
                let (lambda, exact) = (scaled.values[j] / factor, plain.values[j]);
                let tolerance = rounding(n, exact, shift, lambda_max);
                assert!((lambda - exact).abs() < tolerance, "{stiff} {massive} {j}: {lambda} {exact}");
                let phi = scaled.vectors.column(j);
                let residual = (&ks * phi - &ms * phi * scaled.values[j]).norm();
                assert!(residual < tolerance * stiff * m.norm() * phi.norm(), "{stiff} {massive} {j}: {residual}");
            }
            let gram = scaled.vectors.transpose() * &ms * &scaled.vectors;
            assert!((gram - DMatrix::identity(12, 12)).abs().max() < 1e-12);
        }
    }

    #[test]
    fn massless_dofs_have_no_mode() {
        let (k, mut m) = chain(4, 1.0, 1.0);
        m[(1, 1)] = 0.0;
        let pairs = lowest_modes(&k, &m, 4, 0.01).unwrap();
        assert_eq!(pairs.values.len(), 3);
        let alone = lowest_values(&k, &m, 4, 0.01).unwrap();
        assert!((alone - pairs.values).amax() < rounding(4, 4.0, 0.01, 4.0));
    }

    #[test]
    fn an_empty_dof_is_named() {
        let (mut k, mut m) = chain(3, 1.0, 1.0);
        for i in 0..3 {
            (k[(1, i)], k[(i, 1)], m[(1, i)], m[(i, 1)]) = (0.0, 0.0, 0.0, 0.0);
        }
        assert!(matches!(lowest_modes(&k, &m, 2, 1.0), Err(LinalgError::NotPositiveDefinite { row: 1, .. })));
    }
}
