//! Errors that rows have in common: taken out as far as they are expected.
//!
//! ```text
//! cov r = I + U Uᵀ,   U = Q Σ Wᵀ,   r' = (I + U Uᵀ)^(-1/2) r = r - Q (1 - 1/√(1 + Σ²)) Qᵀ r
//! ```

use crate::linalg::{DMatrix, thin_svd};

/// Errors below this part of a standard deviation are none.
const NONE: f64 = 1e-3;

/// What whitens rows with errors in common.
#[derive(Debug, Clone)]
pub(super) struct CommonError {
    /// Q, (rows x errors).
    directions: DMatrix<f64>,
    /// 1 - 1/√(1 + σ²).
    taken: Vec<f64>,
}

impl CommonError {
    /// Of errors as columns in units of the standard deviations of the rows; `None` where there are none.
    ///
    /// * `errors` - U, (rows x any number)
    pub(super) fn new(errors: &DMatrix<f64>) -> Option<Self> {
        if errors.is_empty() || errors.nrows() < errors.ncols() {
            return None;
        }
        let parts = thin_svd(errors).ok()?;
        let kept: Vec<usize> = (0..parts.values.len()).filter(|&k| parts.values[k] > NONE).collect();
        let taken = kept.iter().map(|&k| 1.0 - (1.0 + parts.values[k].powi(2)).sqrt().recip()).collect();
        (!kept.is_empty()).then(|| Self { directions: parts.left.select_columns(&kept), taken })
    }

    /// r' in the place of r.
    pub(super) fn whiten(&self, r: &mut [f64]) {
        for (direction, taken) in self.directions.column_iter().zip(&self.taken) {
            // The directions are orthonormal, so that one after the other is all at once.
            let along = taken * direction.iter().zip(r.iter()).map(|(d, r)| d * r).sum::<f64>();
            r.iter_mut().zip(direction.iter()).for_each(|(r, d)| *r -= along * d);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::DVector;

    #[test]
    fn whitened_rows_have_unit_covariance() {
        let u = DMatrix::from_fn(7, 2, |i, j| ((i * 3 + j * 5) % 4) as f64 - 1.0);
        let error = CommonError::new(&u).unwrap();
        let mut root = DMatrix::identity(7, 7);
        root.column_iter_mut().for_each(|mut c| error.whiten(c.as_mut_slice()));
        let covariance = DMatrix::identity(7, 7) + &u * u.transpose();
        assert!((&root * covariance * root.transpose() - DMatrix::<f64>::identity(7, 7)).amax() < 1e-12);
        assert!(CommonError::new(&DMatrix::zeros(5, 0)).is_none() && CommonError::new(&DMatrix::zeros(5, 2)).is_none());
        let mut far = DVector::from_element(7, 0.0);
        error.whiten(far.as_mut_slice());
        assert_eq!(far.amax(), 0.0);
    }
}
