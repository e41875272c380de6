//! Eigenvalues and right eigenvectors of a general real matrix.

use super::{Complex, DMatrix, LinalgError};

/// All eigenpairs A v = λ v of a real square matrix, in no particular order.
#[derive(Debug, Clone)]
pub struct GeneralEigenpairs {
    /// λ, one per row of A; complex ones come in conjugate pairs.
    pub values: Vec<Complex<f64>>,
    /// Right eigenvectors as columns (n x n), each of unit 2-norm.
    pub vectors: DMatrix<Complex<f64>>,
}

/// Eigenvalues and right eigenvectors of a general real matrix `a` (n x n).
///
/// The matrix is scaled to unit largest entry first, because the iteration behind it is not invariant under scaling.
/// A defective matrix gives (nearly) parallel vectors; that is for the caller to judge.
///
/// # Errors
/// [`LinalgError::NotFinite`] for a NaN or infinite entry, [`LinalgError::NoConvergence`] if the QR iteration fails.
///
/// # Panics
/// If `a` is not square.
///
/// # Source
/// G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 2013, section 7.5 (the QR algorithm).
pub fn general_eigenpairs(a: &DMatrix<f64>) -> Result<GeneralEigenpairs, LinalgError> {
    let n = a.nrows();
    assert_eq!(n, a.ncols(), "a square matrix");
    if let Some(row) = (0..n).find(|&i| (0..n).any(|j| !a[(i, j)].is_finite())) {
        return Err(LinalgError::NotFinite { matrix: "companion", row });
    }
    let norm = a.amax();
    if n == 0 || norm == 0.0 {
        let vectors = DMatrix::identity(n, n);
        return Ok(GeneralEigenpairs { values: vec![Complex::new(0.0, 0.0); n], vectors });
    }
    let scaled = faer::Mat::<f64>::from_fn(n, n, |i, j| a[(i, j)] / norm);
    // Sequential on purpose: the bits must not depend on the number of threads, and callers run many of these at once.
    let par = faer::Par::Seq;
    let (mut re, mut im, mut u) =
        (faer::diag::Diag::zeros(n), faer::diag::Diag::zeros(n), faer::Mat::<f64>::zeros(n, n));
    let (no, yes) = (faer::linalg::evd::ComputeEigenvectors::No, faer::linalg::evd::ComputeEigenvectors::Yes);
    let scratch = faer::linalg::evd::evd_scratch::<f64>(n, no, yes, par, faer::prelude::default());
    faer::linalg::evd::evd_real(
        scaled.as_ref(),
        re.as_mut(),
        im.as_mut(),
        None,
        Some(u.as_mut()),
        par,
        faer::dyn_stack::MemStack::new(&mut faer::dyn_stack::MemBuffer::new(scratch)),
        faer::prelude::default(),
    )
    .map_err(|_| LinalgError::NoConvergence { size: n })?;
    let values: Vec<_> = (0..n).map(|j| Complex::new(re[j] * norm, im[j] * norm)).collect();
    // A conjugate pair stands in two columns: the real part of its vector, then the imaginary part.
    let mut vectors = DMatrix::zeros(n, n);
    let mut j = 0;
    while j < n {
        let is_pair = im[j] != 0.0 && j + 1 < n;
        for i in 0..n {
            let x = Complex::new(u[(i, j)], if is_pair { u[(i, j + 1)] } else { 0.0 });
            vectors[(i, j)] = x;
            if is_pair {
                vectors[(i, j + 1)] = x.conj();
            }
        }
        j += if is_pair { 2 } else { 1 };
    }
    for mut column in vectors.column_iter_mut() {
        let length = column.norm();
        if length > 0.0 {
            column /= Complex::new(length, 0.0);
        }
    }
    Ok(GeneralEigenpairs { values, vectors })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The companion matrix of a polynomial has its roots as eigenvalues.
    #[test]
    fn companion_matrix_has_the_roots_at_any_scale() {
        for scale in [1e-8, 1.0, 1e9] {
            let roots = [Complex::new(-0.5, 2.0), Complex::new(-0.5, -2.0), Complex::new(3.0, 0.0)];
            // (x² + x + 4.25)(x - 3) = x³ - 2x² + 1.25x - 12.75
            #[rustfmt::skip]
            let a = DMatrix::from_row_slice(3, 3, &[
                2.0, -1.25, 12.75,
                1.0,  0.0,   0.0,
                0.0,  1.0,   0.0,
            ]) * scale;
            let pairs = general_eigenpairs(&a).unwrap();
            for root in roots {
                let gap = pairs.values.iter().map(|v| (v / scale - root).norm()).fold(f64::MAX, f64::min);
                assert!(gap < 1e-13, "{scale} {root} {gap}");
            }
            let complex = a.map(|x| Complex::new(x, 0.0));
            for j in 0..3 {
                let v = pairs.vectors.column(j);
                assert!((&complex * v - v * pairs.values[j]).norm() < 1e-13 * scale);
            }
        }
    }

    #[test]
    fn a_nan_is_refused() {
        let a = DMatrix::from_element(2, 2, f64::NAN);
        assert!(matches!(general_eigenpairs(&a), Err(LinalgError::NotFinite { .. })));
    }
}
