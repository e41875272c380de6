//! Singular values and symmetric eigenvalues of dense matrices.

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
    let svd = scaled.thin_svd().map_err(|_| LinalgError::NoConvergence { size: rows.max(columns) })?;
    let values = svd.S().column_vector();
    Ok(Svd {
        left: DMatrix::from_fn(rows, p, |i, j| svd.U()[(i, j)]),
        values: DVector::from_fn(p, |j, _| values[j] * scale),
        right: DMatrix::from_fn(columns, p, |i, j| svd.V()[(i, j)]),
    })
}

/// Eigenvalues, ascending, and orthonormal vectors of a symmetric matrix; only the lower triangle is read.
pub fn symmetric_eigen(a: &DMatrix<f64>) -> Result<(DVector<f64>, DMatrix<f64>), LinalgError> {
    let n = a.nrows();
    if let Some(row) = (0..n).find(|&i| (0..=i).any(|j| !a[(i, j)].is_finite())) {
        return Err(LinalgError::NotFinite { matrix: "decomposed", row });
    }
    let scale = unit_scale(a);
    let scaled = faer::Mat::<f64>::from_fn(n, n, |i, j| a[(i, j)] / scale);
    let eigen = scaled.self_adjoint_eigen(faer::Side::Lower).map_err(|_| LinalgError::NoConvergence { size: n })?;
    let values = eigen.S().column_vector();
    let vectors = DMatrix::from_fn(n, n, |i, j| eigen.U()[(i, j)]);
    Ok((DVector::from_fn(n, |j, _| values[j] * scale), vectors))
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
            let (values, _) = symmetric_eigen(&a).unwrap();
            for (j, exact) in [1.408318927123654, 0.12232706585390585, 0.002687340355773529].into_iter().enumerate() {
                assert!((svd.values[j] / scale - exact).abs() < 2e-15);
                assert!((values[2 - j] / scale - exact).abs() < 2e-15);
            }
        }
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
