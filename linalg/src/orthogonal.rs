//! Orthogonal-triangular factorisation of tall real matrices: the kernel of every linear least-squares fit.

use super::{DMatrix, DVector, LinalgError};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::{householder, qr::no_pivoting::factor};

/// A = Q R with orthonormal columns of Q (m x n) and an upper triangle R (n x n), m >= n.
#[derive(Debug, Clone)]
pub struct ThinQr {
    /// Q, QᵀQ = I.
    pub q: DMatrix<f64>,
    /// R.
    pub r: DMatrix<f64>,
}

/// Factors a tall matrix by Householder reflections.
///
/// # Errors
/// [`LinalgError::NotFinite`] when an entry is NaN or infinite.
///
/// # Panics
/// If `a` has more columns than rows.
///
/// # Source
/// G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 2013, section 5.2.
pub fn thin_qr(a: &DMatrix<f64>) -> Result<ThinQr, LinalgError> {
    let (m, n) = a.shape();
    assert!(m >= n, "a tall matrix");
    if let Some(at) = a.as_slice().iter().position(|x| !x.is_finite()) {
        return Err(LinalgError::NotFinite { matrix: "least-squares", row: at % m });
    }
    // Sequential on purpose: the bits must not depend on the number of threads.
    let par = faer::Par::Seq;
    let mut factored = faer::MatRef::from_column_major_slice(a.as_slice(), m, n).to_owned();
    let block = factor::recommended_block_size::<f64>(m, n);
    let mut coefficients = faer::Mat::<f64>::zeros(block, n);
    let scratch = factor::qr_in_place_scratch::<f64>(m, n, block, par, faer::prelude::default());
    factor::qr_in_place(
        factored.as_mut(),
        coefficients.as_mut(),
        par,
        MemStack::new(&mut MemBuffer::new(scratch)),
        faer::prelude::default(),
    );
    let r = DMatrix::from_fn(n, n, |i, j| if i <= j { factored[(i, j)] } else { 0.0 });
    let mut q = DMatrix::<f64>::identity(m, n);
    let scratch =
        householder::apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(m, coefficients.nrows(), n);
    householder::apply_block_householder_sequence_on_the_left_in_place_with_conj(
        factored.as_ref(),
        coefficients.as_ref(),
        faer::Conj::No,
        faer::MatMut::from_column_major_slice_mut(q.as_mut_slice(), m, n),
        par,
        MemStack::new(&mut MemBuffer::new(scratch)),
    );
    Ok(ThinQr { q, r })
}

impl ThinQr {
    /// Smallest over largest modulus on the diagonal of R: a cheap lower-quality estimate of 1/cond(A).
    pub fn diagonal_ratio(&self) -> f64 {
        let d = self.r.diagonal().abs();
        if d.is_empty() || d.max() == 0.0 { 0.0 } else { d.min() / d.max() }
    }

    /// x of least |A x - b|, or nothing when R is singular.
    pub fn solve(&self, b: &DVector<f64>) -> Option<DVector<f64>> {
        self.r.solve_upper_triangular(&self.q.tr_mul(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_points_has_its_textbook_coefficients() {
        let x: [f64; 4] = [0.0, 1.0, 2.0, 3.0];
        let a = DMatrix::from_fn(4, 2, |i, j| x[i].powi(j as i32));
        let b = DVector::from_vec(vec![1.0, 3.0, 4.0, 4.0]);
        let qr = thin_qr(&a).unwrap();
        // Normal equations by hand: slope 1, intercept 1.5.
        let c = qr.solve(&b).unwrap();
        assert!((c[0] - 1.5).abs() < 1e-14 && (c[1] - 1.0).abs() < 1e-14);
        assert!((qr.q.tr_mul(&qr.q) - DMatrix::identity(2, 2)).amax() < 1e-15);
        assert!((&qr.q * &qr.r - a).amax() < 1e-14);
    }

    #[test]
    fn an_infinite_entry_is_refused_with_its_row() {
        let mut a = DMatrix::zeros(5, 2);
        a[(3, 1)] = f64::INFINITY;
        assert!(matches!(thin_qr(&a), Err(LinalgError::NotFinite { row: 3, .. })));
    }
}
