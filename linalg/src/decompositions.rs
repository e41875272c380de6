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
/// Unlike those of [`super::lowest_modes`] the basis is complete: any displacement is a sum of its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct ShiftedPencil {
    /// θ, descending, (n).
    pub theta: DVector<f64>,
    /// X, (n x n).
    pub vectors: DMatrix<f64>,
    /// a, rad²/s².
    pub shift: f64,
}

impl ShiftedPencil {
    /// Solves the pencil.
    ///
    /// * `k`, `m` - symmetric, positive semidefinite, (n x n); only the lower triangles are read
    /// * `shift` - a > 0, rad²/s², so that K + a M is positive definite
    pub fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, shift: f64) -> Result<Self, LinalgError> {
        let (theta, vectors) = leading_pencil(k, m, shift, k.nrows())?;
        Ok(Self { theta, vectors, shift })
    }

    /// The same basis for another shift b > 0.
    ///
    /// ```text
    /// θ' = 1/(λ + b) = θ/(1 + (b - a) θ),   x' = x/√(1 + (b - a) θ)
    /// ```
    ///
    /// As accurate as [`Self::new`] with b where both shifts are of one order.
    #[must_use]
    pub fn shifted_to(&self, shift: f64) -> Self {
        let growth = self.theta.map(|theta| 1.0 + (shift - self.shift) * theta);
        let mut vectors = self.vectors.clone();
        for (mut column, growth) in vectors.column_iter_mut().zip(growth.iter()) {
            column.unscale_mut(growth.sqrt());
        }
        Self { theta: self.theta.component_div(&growth), vectors, shift }
    }
}

/// The parts of a [`ShiftedPencil`]: all values and the first `n_vectors` vectors.
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
    let Standard { c, norm, scale, energy } = Standard::new(k, m, shift)?;
    let (theta, u) = faer_eigen(&c)?;
    let count = n_vectors.min(n);
    // θ ascends: the wanted ones stand last.
    let mut vectors = faer::Mat::<f64>::from_fn(n, count, |i, j| u[(i, n - 1 - j)]);
    let l = energy.as_ref();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(l.transpose(), vectors.as_mut(), faer::Par::Seq);
    let theta = DVector::from_fn(n, |j, _| theta[n - 1 - j].max(0.0) * norm);
    Ok((theta, DMatrix::from_fn(n, count, |i, j| vectors[(i, j)] * scale[i])))
}

/// θ of a [`ShiftedPencil`] alone.
pub(super) fn pencil_values(k: &DMatrix<f64>, m: &DMatrix<f64>, shift: f64) -> Result<DVector<f64>, LinalgError> {
    let n = k.nrows();
    if n == 0 {
        return Ok(DVector::zeros(0));
    }
    let Standard { c, norm, .. } = Standard::new(k, m, shift)?;
    let theta = faer_values(c)?;
    Ok(DVector::from_fn(n, |j, _| theta[n - 1 - j].max(0.0) * norm))
}

/// The pencil as one symmetric matrix: C = L⁻¹ M L⁻ᵀ with K + a M = L Lᵀ, both scaled.
struct Standard {
    /// C over its norm.
    c: faer::Mat<f64>,
    norm: f64,
    /// Factor of every dof that makes the diagonal of K + a M one.
    scale: Vec<f64>,
    /// L in the lower triangle.
    energy: faer::Mat<f64>,
}

impl Standard {
    fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, shift: f64) -> Result<Self, LinalgError> {
        let n = k.nrows();
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
        Ok(Self { c, norm, scale, energy })
    }
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

/// Eigenvalues alone, ascending, of a symmetric matrix of norm about one; only the lower triangle is read.
fn faer_values(mut a: faer::Mat<f64>) -> Result<Vec<f64>, LinalgError> {
    use faer::linalg::evd::tridiag::{tridiag_in_place, tridiag_in_place_scratch};
    let (n, par) = (a.nrows(), faer::Par::Seq);
    let block = faer::linalg::qr::no_pivoting::factor::recommended_block_size::<f64>(n, n);
    let mut reflectors = faer::Mat::<f64>::zeros(block, n.saturating_sub(1));
    let scratch = tridiag_in_place_scratch::<f64>(n, par, faer::prelude::default());
    let stack = &mut faer::dyn_stack::MemBuffer::new(scratch);
    let stack = faer::dyn_stack::MemStack::new(stack);
    tridiag_in_place(a.as_mut(), reflectors.as_mut(), par, stack, faer::prelude::default());
    let mut diagonal: Vec<f64> = (0..n).map(|i| a[(i, i)]).collect();
    let squares = (1..n).map(|i| a[(i, i - 1)].powi(2)).chain([0.0]).collect();
    if !tridiagonal_values(&mut diagonal, squares) {
        return Err(LinalgError::NoConvergence { size: n });
    }
    diagonal.sort_by(f64::total_cmp);
    Ok(diagonal)
}

/// Eigenvalues of a symmetric tridiagonal matrix of norm about one by QL without square roots in the sweeps, in place of
/// the diagonal; false if they do not come.
///
/// * `e2` - squares of the entries below the diagonal, and one more number, (n)
///
/// # Source
/// K. Pal, W. Walker and W. Kahan's variant: B. N. Parlett, The Symmetric Eigenvalue Problem, SIAM 1998, section 8.15; LAPACK's
/// DSTERF.
fn tridiagonal_values(d: &mut [f64], mut e2: Vec<f64>) -> bool {
    const SWEEPS: usize = 60;
    /// ε² against two neighbours on the diagonal, and against the norm, which is about one.
    const RELATIVE: f64 = f64::EPSILON * f64::EPSILON / 4.0;
    const ABSOLUTE: f64 = RELATIVE * 1e-2;
    let n = d.len();
    for l in 0..n {
        let mut sweeps = 0;
        loop {
            let is_cut = |m: usize| e2[m] <= RELATIVE * (d[m] * d[m + 1]).abs() || e2[m] <= ABSOLUTE;
            let m = (l..n - 1).find(|&m| is_cut(m)).unwrap_or(n - 1);
            if m == l {
                break;
            }
            if sweeps == SWEEPS {
                return false;
            }
            sweeps += 1;
            if m < n - 1 {
                e2[m] = 0.0;
            }
            let root = e2[l].sqrt();
            let half = (d[l + 1] - d[l]) / (2.0 * root);
            let sigma = d[l] - root / (half + half.hypot(1.0).copysign(half));
            let (mut c, mut s, mut gamma) = (1.0, 0.0, d[m] - sigma);
            let mut p = gamma * gamma;
            for i in (l..m).rev() {
                let bb = e2[i];
                let r = p + bb;
                if i != m - 1 {
                    e2[i + 1] = s * r;
                }
                let old_c = c;
                (c, s) = (p / r, bb / r);
                let old_gamma = gamma;
                gamma = c * (d[i] - sigma) - s * old_gamma;
                d[i + 1] = old_gamma + (d[i] - gamma);
                p = if c == 0.0 { old_c * bb } else { gamma * gamma / c };
            }
            e2[l] = s * p;
            d[l] = sigma + gamma;
        }
    }
    true
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

/// Eigenvalues alone of a symmetric matrix (n x n), ascending; only the lower triangle is read.
///
/// As accurate as those of [`symmetric_eigen`]. Small matrices, of which there may be thousands, are solved by Jacobi's
/// rotations, which need no work space.
///
/// # Errors
/// [`LinalgError::NotFinite`]; [`LinalgError::NoConvergence`].
///
/// # Panics
/// If `a` is not square.
///
/// # Source
/// G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 2013, section 8.5.
pub fn symmetric_values(a: &DMatrix<f64>) -> Result<DVector<f64>, LinalgError> {
    /// Beyond this the reduction to tridiagonal form is faster.
    const SMALL: usize = 8;
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "a square matrix");
    if let Some(k) = a.iter().position(|v| !v.is_finite()) {
        return Err(LinalgError::NotFinite { matrix: "decomposed", row: k % n });
    }
    if n < 2 {
        return Ok(DVector::from_fn(n, |i, _| a[(i, i)]));
    }
    let scale = unit_scale(a);
    if n <= SMALL {
        let scaled = DMatrix::from_fn(n, n, |i, j| a[(i.max(j), i.min(j))] / scale);
        if let Some(values) = jacobi_values(scaled) {
            return Ok(values * scale);
        }
    }
    let values = faer_values(faer::Mat::from_fn(n, n, |i, j| a[(i.max(j), i.min(j))] / scale))?;
    Ok(DVector::from_iterator(n, values.into_iter().map(|v| v * scale)))
}

/// Eigenvalues, ascending, by cyclic rotations; `None` should they not end.
fn jacobi_values(mut a: DMatrix<f64>) -> Option<DVector<f64>> {
    /// Sweeps converge quadratically: five or six do.
    const SWEEPS: usize = 40;
    let n = a.nrows();
    let small = 0.1 * f64::EPSILON * a.norm();
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..n {
            for q in p + 1..n {
                let off = a[(p, q)];
                if off.abs() <= small {
                    continue;
                }
                is_diagonal = false;
                let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * off);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                a[(p, p)] -= t * off;
                a[(q, q)] += t * off;
                (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
                for i in (0..n).filter(|&i| i != p && i != q) {
                    let (x, y) = (a[(i, p)], a[(i, q)]);
                    let (x, y) = (c * x - s * y, s * x + c * y);
                    (a[(i, p)], a[(p, i)], a[(i, q)], a[(q, i)]) = (x, x, y, y);
                }
            }
        }
        if is_diagonal {
            let mut values: Vec<f64> = a.diagonal().iter().copied().collect();
            values.sort_by(f64::total_cmp);
            return Some(DVector::from_vec(values));
        }
    }
    None
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
            let alone = symmetric_values(&a).unwrap();
            assert!((alone - &found.values).amax() < 1e-13 * norm, "case {case}: values alone");
        }
    }

    /// Closed forms: no row, one, and [2 1; 1 2] and the path of three masses at any scale.
    #[test]
    fn values_alone_have_their_closed_forms() {
        assert_eq!(symmetric_values(&DMatrix::zeros(0, 0)).unwrap().len(), 0);
        assert_eq!(symmetric_values(&DMatrix::zeros(4, 4)).unwrap(), DVector::zeros(4));
        for scale in [1e-150, -1.0, 1e150] {
            assert_eq!(symmetric_values(&DMatrix::from_element(1, 1, scale)).unwrap()[0], scale);
            let a = DMatrix::from_row_slice(2, 2, &[2.0, 7.0, 1.0, 2.0]) * scale.abs();
            let b = DMatrix::from_row_slice(3, 3, &[2.0, 0.0, 0.0, -1.0, 2.0, 0.0, 0.0, -1.0, 2.0]) * scale.abs();
            for (a, exact) in [(a, vec![1.0, 3.0]), (b, vec![2.0 - 2f64.sqrt(), 2.0, 2.0 + 2f64.sqrt()])] {
                let values = symmetric_values(&a).unwrap();
                assert!(values.iter().zip(&exact).all(|(v, e)| (v / scale.abs() - e).abs() < 2e-15), "{values}");
            }
        }
        assert!(symmetric_values(&DMatrix::from_element(2, 2, f64::NAN)).is_err());
        // Of rank one, and blocks that do not touch: much of the tridiagonal form is zero.
        let v = DVector::from_fn(40, |i, _| (i % 7) as f64);
        let values = symmetric_values(&(&v * v.transpose())).unwrap();
        assert!((values[39] / v.norm_squared() - 1.0).abs() < 1e-14 && values[38].abs() < 1e-14 * values[39]);
        let blocks =
            DMatrix::from_fn(60, 60, |i, j| if i / 2 == j / 2 { 1.0 + f64::from(u8::from(i == j)) } else { 0.0 });
        let values = symmetric_values(&blocks).unwrap();
        assert!((0..60).all(|i| (values[i] - if i < 30 { 1.0 } else { 3.0 }).abs() < 1e-14));
        // The path of n masses: 2 - 2 cos(j π/(n + 1)).
        for n in [9, 40, 127, 128, 300] {
            let path = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
                0 => 2.0,
                1 => -1.0,
                _ => 0.0,
            });
            let values = symmetric_values(&path).unwrap();
            let exact = |j: usize| 2.0 - 2.0 * ((j + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
            assert!((0..n).all(|j| (values[j] - exact(j)).abs() < 1e-14 * (n as f64).sqrt()), "{n}");
        }
    }

    /// Two free masses 1 and 3, spring 3, and a massless dof between: λ = 0 and k_eff (1/1 + 1/3) with k_eff = 1.5.
    #[test]
    fn a_pencil_has_rigid_elastic_and_massless_vectors() {
        let k = DMatrix::from_row_slice(3, 3, &[3.0, -3.0, 0.0, -3.0, 6.0, -3.0, 0.0, -3.0, 3.0]);
        let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 0.0, 3.0]);
        let found = ShiftedPencil::new(&k, &m, 0.5).unwrap();
        let ShiftedPencil { theta, vectors: x, .. } = found.clone();
        for (value, exact) in theta.iter().zip([1.0 / 0.5, 1.0 / (2.0 + 0.5), 0.0]) {
            assert!((value - exact).abs() < 1e-14);
        }
        assert!((x.transpose() * (&k + &m * 0.5) * &x - DMatrix::identity(3, 3)).abs().max() < 1e-14);
        assert!((x.transpose() * &m * &x - DMatrix::from_diagonal(&theta)).abs().max() < 1e-14);
        let (other, exact) = (found.shifted_to(0.8), ShiftedPencil::new(&k, &m, 0.8).unwrap());
        assert!((&other.theta - &exact.theta).amax() < 1e-14);
        assert!((other.vectors.abs() - exact.vectors.abs()).amax() < 1e-14);
        assert!(ShiftedPencil::new(&(&k * 0.0), &m, 0.5).is_err());
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
