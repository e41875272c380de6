//! Singular values of a dense matrix, and the complete basis of a structural model.

use super::{DMatrix, DVector, LinalgError};

/// A = U Σ Vᵀ with p = min(rows, columns) singular values in descending order.
#[derive(Debug, Clone)]
pub struct Svd {
    /// U, (rows x p).
    pub left: DMatrix<f64>,
    /// σ, descending, (p).
    pub values: DVector<f64>,
    /// V, (columns x p).
    pub right: DMatrix<f64>,
}

impl Svd {
    /// Number of singular values above `threshold` times the largest.
    pub fn rank(&self, threshold: f64) -> usize {
        let limit = threshold * self.values.iter().copied().fold(0.0, f64::max);
        self.values.iter().filter(|&&s| s > limit).count()
    }

    /// The pseudoinverse, (columns x rows), of the part with singular values above `threshold` times the largest.
    pub fn pseudo_inverse(&self, threshold: f64) -> DMatrix<f64> {
        let rank = self.rank(threshold);
        let mut scaled = self.right.columns(0, rank).into_owned();
        for j in 0..rank {
            scaled.column_mut(j).unscale_mut(self.values[j]);
        }
        scaled * self.left.columns(0, rank).transpose()
    }
}

/// The thin singular value decomposition.
///
/// * `a` - any shape, finite
pub fn thin_svd(a: &DMatrix<f64>) -> Result<Svd, LinalgError> {
    let (rows, columns) = a.shape();
    let p = rows.min(columns);
    if let Some(row) = (0..rows).find(|&i| a.row(i).iter().any(|v| !v.is_finite())) {
        return Err(LinalgError::NotFinite { matrix: "decomposed", row });
    }
    let scale = unit_scale(a);
    let scaled = faer::Mat::<f64>::from_fn(rows, columns, |i, j| a[(i, j)] / scale);
    // Sequential, so that bits do not depend on the number of threads.
    let (par, thin) = (faer::Par::Seq, faer::linalg::svd::ComputeSvdVectors::Thin);
    let scratch = faer::linalg::svd::svd_scratch::<f64>(rows, columns, thin, thin, par, faer::prelude::default());
    let mut values = faer::diag::Diag::<f64>::zeros(p);
    let (mut u, mut v) = (faer::Mat::<f64>::zeros(rows, p), faer::Mat::<f64>::zeros(columns, p));
    faer::linalg::svd::svd(
        scaled.as_ref(),
        values.as_mut(),
        Some(u.as_mut()),
        Some(v.as_mut()),
        par,
        faer::dyn_stack::MemStack::new(&mut faer::dyn_stack::MemBuffer::new(scratch)),
        faer::prelude::default(),
    )
    .map_err(|_| LinalgError::NoConvergence { size: rows.max(columns) })?;
    let values = values.column_vector();
    Ok(Svd {
        left: DMatrix::from_fn(rows, p, |i, j| u[(i, j)]),
        values: DVector::from_fn(p, |j, _| values[j] * scale),
        right: DMatrix::from_fn(columns, p, |i, j| v[(i, j)]),
    })
}

/// All vectors of the pencil (M, K + a M), massless dofs and rigid bodies included.
///
/// ```text
/// M x = θ (K + a M) x,   Xᵀ (K + a M) X = I,   Xᵀ M X = diag(θ),   θ = 1/(λ + a) descending, 0 for massless dofs
/// ```
///
/// * `k`, `m` - symmetric, positive semidefinite, (n x n); only the lower triangles are read
/// * `shift` - a > 0, rad²/s², so that K + a M is positive definite
///
/// Returns (θ, X). Unlike [`super::lowest_modes`] the basis is complete: any displacement is a sum of its columns.
pub fn shifted_pencil(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    shift: f64,
) -> Result<(DVector<f64>, DMatrix<f64>), LinalgError> {
    leading_pencil(k, m, shift, k.nrows())
}

/// [`shifted_pencil`] with all values and the first `n_vectors` vectors.
pub(super) fn leading_pencil(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    shift: f64,
    n_vectors: usize,
) -> Result<(DVector<f64>, DMatrix<f64>), LinalgError> {
    let n = k.nrows();
    if n == 0 {
        return Ok((DVector::zeros(0), DMatrix::zeros(0, 0)));
    }
    for (matrix, a) in [("stiffness", k), ("mass", m)] {
        if let Some(row) = (0..n).find(|&i| (0..=i).any(|j| !a[(i, j)].is_finite())) {
            return Err(LinalgError::NotFinite { matrix, row });
        }
    }
    // Jacobi scaling to unit diagonal: equal to a change of units per dof, and it makes the Cholesky pivots comparable.
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / (k[(i, i)] + shift * m[(i, i)]).sqrt()).collect();
    if let Some(row) = scale.iter().position(|s| !s.is_finite()) {
        return Err(LinalgError::NotPositiveDefinite { row, shift });
    }
    let scaled = |entry: &dyn Fn(usize, usize) -> f64| {
        faer::Mat::<f64>::from_fn(n, n, |i, j| entry(i.max(j), i.min(j)) * scale[i] * scale[j])
    };
    let mut energy = scaled(&|i, j| k[(i, j)] + shift * m[(i, j)]);
    cholesky(&mut energy).map_err(|row| LinalgError::NotPositiveDefinite { row, shift })?;
    let (l, par) = (energy.as_ref(), faer::Par::Seq);
    // C = L⁻¹ M L⁻ᵀ, scaled to unit norm.
    let mut c = scaled(&|i, j| m[(i, j)]);
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(l, c.as_mut(), par);
    let mut c = c.transpose().to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(l, c.as_mut(), par);
    let norm = (0..n).map(|i| c[(i, i)].abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    for j in 0..n {
        for i in 0..n {
            c[(i, j)] /= norm;
        }
    }
    let (theta, u) = faer_eigen(&c)?;
    let count = n_vectors.min(n);
    // θ ascends: the wanted ones stand last.
    let mut vectors = faer::Mat::<f64>::from_fn(n, count, |i, j| u[(i, n - 1 - j)]);
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(l.transpose(), vectors.as_mut(), par);
    let theta = DVector::from_fn(n, |j, _| theta[n - 1 - j].max(0.0) * norm);
    Ok((theta, DMatrix::from_fn(n, count, |i, j| vectors[(i, j)] * scale[i])))
}

/// L of a = L Lᵀ over the lower triangle of `a`; the error is the row of the first pivot that is not positive.
///
/// Sequential, like everything here, so that bits do not depend on the number of threads.
fn cholesky(a: &mut faer::Mat<f64>) -> Result<(), usize> {
    use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
    let par = faer::Par::Seq;
    let scratch = cholesky_in_place_scratch::<f64>(a.nrows(), par, faer::prelude::default());
    let stack = &mut faer::dyn_stack::MemBuffer::new(scratch);
    let stack = faer::dyn_stack::MemStack::new(stack);
    match cholesky_in_place(a.as_mut(), faer::prelude::default(), par, stack, faer::prelude::default()) {
        Ok(_) => Ok(()),
        Err(LltError::NonPositivePivot { index }) => Err(index),
    }
}

/// Eigenvalues, ascending, and vectors of a symmetric matrix of norm about one; only the lower triangle is read.
fn faer_eigen(a: &faer::Mat<f64>) -> Result<(Vec<f64>, faer::Mat<f64>), LinalgError> {
    use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
    let (n, par) = (a.nrows(), faer::Par::Seq);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, par, faer::prelude::default());
    let stack = &mut faer::dyn_stack::MemBuffer::new(scratch);
    let stack = faer::dyn_stack::MemStack::new(stack);
    let mut values = faer::diag::Diag::<f64>::zeros(n);
    let mut u = faer::Mat::<f64>::zeros(n, n);
    self_adjoint_evd(a.as_ref(), values.as_mut(), Some(u.as_mut()), par, stack, faer::prelude::default())
        .map_err(|_| LinalgError::NoConvergence { size: n })?;
    let values = values.column_vector();
    Ok(((0..n).map(|i| values[i]).collect(), u))
}

/// Eigenvalues and vectors of a symmetric matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricEigen {
    /// Eigenvalues, ascending (n).
    pub values: DVector<f64>,
    /// Orthonormal eigenvectors as columns (n x n).
    pub vectors: DMatrix<f64>,
}

/// A = V diag(λ) Vᵀ of a symmetric matrix (n x n); only the lower triangle is read.
///
/// Every eigenvalue is right to some n ε ‖A‖, also for a graded or a singular matrix, at any scale.
///
/// # Errors
/// [`LinalgError::NotFinite`]; [`LinalgError::NoConvergence`].
///
/// # Panics
/// If `a` is not square.
pub fn symmetric_eigen(a: &DMatrix<f64>) -> Result<SymmetricEigen, LinalgError> {
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "a square matrix");
    if let Some(k) = a.iter().position(|v| !v.is_finite()) {
        return Err(LinalgError::NotFinite { matrix: "decomposed", row: k % n });
    }
    if n == 0 {
        return Ok(SymmetricEigen { values: DVector::zeros(0), vectors: DMatrix::zeros(0, 0) });
    }
    let scale = unit_scale(a);
    let (values, u) = faer_eigen(&faer::Mat::from_fn(n, n, |i, j| a[(i.max(j), i.min(j))] / scale))?;
    let values = DVector::from_iterator(n, values.into_iter().map(|v| v * scale));
    Ok(SymmetricEigen { values, vectors: DMatrix::from_fn(n, n, |i, j| u[(i, j)]) })
}

/// Eigenvalues, descending, and vectors of a symmetric matrix; only the lower triangle is read.
pub(super) fn symmetric_pairs(a: &DMatrix<f64>) -> Result<(Vec<f64>, DMatrix<f64>), LinalgError> {
    let n = a.nrows();
    let scale = unit_scale(a);
    let (values, u) = faer_eigen(&faer::Mat::from_fn(n, n, |i, j| a[(i, j)] / scale))?;
    let values = values.into_iter().rev().map(|v| v * scale).collect();
    Ok((values, DMatrix::from_fn(n, n, |i, j| u[(i, n - 1 - j)])))
}

/// The largest modulus, or one for a zero matrix: faer's divide and conquer wants a norm near one.
fn unit_scale(a: &DMatrix<f64>) -> f64 {
    let largest = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if largest > 0.0 { largest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hilbert matrix of 3 rows: the roots of λ³ - 23/15 λ² + 127/720 λ - 1/2160, by Newton in 40 digits.
    #[test]
    fn hilbert_matrix_at_any_scale() {
        for scale in [1e-150, 1.0, 1e150] {
            let a = DMatrix::from_fn(3, 3, |i, j| scale / (i + j + 1) as f64);
            let svd = thin_svd(&a).unwrap();
            for (j, exact) in [1.408318927123654, 0.12232706585390585, 0.002687340355773529].into_iter().enumerate() {
                assert!((svd.values[j] / scale - exact).abs() < 2e-15);
            }
        }
    }

    /// A = D H D with random H of norm about one, of full rank or not, and D from 10⁰ to 10⁻¹²: the residual and the
    /// orthogonality of a backward stable method, whatever the grading.
    #[test]
    fn graded_matrices_keep_their_eigenvalues() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(24);
        for case in 0..2_000 {
            let n = 4 + case % 29;
            let decades = (case % 13) as f64;
            let rank = if case % 2 == 0 { n } else { n - n / 3 };
            let g = DMatrix::from_fn(n, rank, |_, _| rng.random::<f64>() - 0.5);
            let h = &g * g.transpose();
            let mut order: Vec<usize> = (0..n).collect();
            for i in (1..n).rev() {
                order.swap(i, rng.random_range(0..=i));
            }
            let d = |i: usize| 10f64.powf(-decades * order[i] as f64 / n as f64);
            let a = DMatrix::from_fn(n, n, |i, j| d(i) * h[(i, j)] * d(j));
            let norm = a.norm();
            let found = symmetric_eigen(&a).unwrap();
            let error = |values: &DVector<f64>, v: &DMatrix<f64>| {
                let residual = (&a * v - v * DMatrix::from_diagonal(values)).norm() / norm;
                residual.max((v.tr_mul(v) - DMatrix::identity(n, n)).norm())
            };
            assert!(error(&found.values, &found.vectors) < 1e-13, "case {case}");
            assert!(found.values.as_slice().is_sorted());
        }
    }

    /// Two free masses 1 and 3, spring 3, and a massless dof between: λ = 0 and k_eff (1/1 + 1/3) with k_eff = 1.5.
    #[test]
    fn a_pencil_has_rigid_elastic_and_massless_vectors() {
        let k = DMatrix::from_row_slice(3, 3, &[3.0, -3.0, 0.0, -3.0, 6.0, -3.0, 0.0, -3.0, 3.0]);
        let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 0.0, 3.0]);
        let (theta, x) = shifted_pencil(&k, &m, 0.5).unwrap();
        for (value, exact) in theta.iter().zip([1.0 / 0.5, 1.0 / (2.0 + 0.5), 0.0]) {
            assert!((value - exact).abs() < 1e-14);
        }
        assert!((x.transpose() * (&k + &m * 0.5) * &x - DMatrix::identity(3, 3)).abs().max() < 1e-14);
        assert!((x.transpose() * &m * &x - DMatrix::from_diagonal(&theta)).abs().max() < 1e-14);
        assert!(shifted_pencil(&(&k * 0.0), &m, 0.5).is_err());
    }

    #[test]
    fn pseudo_inverse_of_a_rank_deficient_matrix() {
        // a = u vᵀ with |u|² = 5, |v|² = 2: the pseudoinverse is v uᵀ / 10.
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 2.0, 2.0]);
        let svd = thin_svd(&a).unwrap();
        assert_eq!(svd.rank(1e-12), 1);
        let expected = DMatrix::from_row_slice(2, 2, &[0.1, 0.2, 0.1, 0.2]);
        assert!((svd.pseudo_inverse(1e-12) - expected).abs().max() < 1e-15);
    }
}
