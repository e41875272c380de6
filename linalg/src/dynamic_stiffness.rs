//! The dynamic stiffness of a damped structure, solved line by line.

use crate::{Complex, DMatrix, LinalgError};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::prelude::default;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

/// Z(ω) = K (1 + i η) + i ω C - ω² M, whose pattern and elimination order are found once.
///
/// Structures have few neighbours: a sparse factorisation with partial pivoting costs a tenth of a dense one at 100 dofs.
pub struct DynamicStiffness {
    n: usize,
    columns: Vec<usize>,
    rows: Vec<usize>,
    /// K, C and M of every entry.
    entries: Vec<[f64; 3]>,
    order: SymbolicLu<usize>,
    factors: NumericLu<usize, Complex<f64>>,
    values: Vec<Complex<f64>>,
}

impl DynamicStiffness {
    /// From K, M and C, (n x n) each.
    ///
    /// # Errors
    /// [`LinalgError::OutOfMemory`].
    ///
    /// # Panics
    /// If sizes differ.
    pub fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, c: Option<&DMatrix<f64>>) -> Result<Self, LinalgError> {
        let n = k.nrows();
        assert!(
            [k.shape(), m.shape()].iter().chain(&c.map(DMatrix::shape)).all(|s| *s == (n, n)),
            "matrices of one size"
        );
        let (mut columns, mut rows, mut entries) = (vec![0], Vec::new(), Vec::new());
        for j in 0..n {
            for i in 0..n {
                let entry = [k[(i, j)], c.map_or(0.0, |c| c[(i, j)]), m[(i, j)]];
                if i == j || entry != [0.0; 3] {
                    rows.push(i);
                    entries.push(entry);
                }
            }
            columns.push(rows.len());
        }
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
        let order = factorize_symbolic_lu(pattern, default()).map_err(|_| LinalgError::OutOfMemory)?;
        let values = vec![Complex::default(); entries.len()];
        Ok(Self { n, columns, rows, entries, order, factors: NumericLu::new(), values })
    }

    /// Z⁻¹ B at ω (rad/s) and the loss factor η of all stiffness, in place of B, (n x any number); false where Z has no inverse.
    ///
    /// # Panics
    /// If `b` has another number of rows.
    pub fn solve(&mut self, omega: f64, loss_factor: f64, b: &mut DMatrix<Complex<f64>>) -> bool {
        assert_eq!(b.nrows(), self.n, "rows of the right-hand sides");
        if self.n == 0 {
            return true;
        }
        for (z, [k, c, m]) in self.values.iter_mut().zip(&self.entries) {
            *z = Complex::new(k - omega * omega * m, loss_factor * k + omega * c);
        }
        // Pivots are not chosen among numbers that are none.
        if !self.values.iter().all(|v| v.re.is_finite() && v.im.is_finite()) {
            return false;
        }
        let pattern = SymbolicSparseColMatRef::new_checked(self.n, self.n, &self.columns, None, &self.rows);
        let z = SparseColMatRef::new(pattern, &self.values);
        let par = Par::Seq;
        let scratch = self.order.factorize_numeric_lu_scratch::<Complex<f64>>(par, default());
        let stack = &mut MemBuffer::new(scratch);
        if self.order.factorize_numeric_lu(&mut self.factors, z, par, MemStack::new(stack), default()).is_err() {
            return false;
        }
        let count = b.ncols();
        let scratch = self.order.solve_in_place_scratch::<Complex<f64>>(count, par);
        let stack = &mut MemBuffer::new(scratch);
        let right = MatMut::from_column_major_slice_mut(b.as_mut_slice(), self.n, count);
        let factors = LuRef::new_unchecked(&self.order, &self.factors);
        factors.solve_in_place_with_conj(Conj::No, right, par, MemStack::new(stack));
        b.iter().all(|v| v.re.is_finite() && v.im.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A chain of masses with a dashpot in it.
    fn chain(n: usize, stiffness: &[f64], dashpot: f64) -> [DMatrix<f64>; 3] {
        let mut k = DMatrix::zeros(n, n);
        for i in 0..n {
            k[(i, i)] += stiffness[i];
            if i > 0 {
                k[(i - 1, i - 1)] += stiffness[i];
                k[(i, i - 1)] = -stiffness[i];
                k[(i - 1, i)] = -stiffness[i];
            }
        }
        let mut c = DMatrix::zeros(n, n);
        c[(n - 1, n - 1)] = dashpot;
        [k, DMatrix::identity(n, n), c]
    }

    proptest! {
        /// Beside the dense factorisation, at frequencies through the spectrum, one structure for all of them.
        #[test]
        fn a_sweep_is_the_dense_solution(
            n in 1_usize..40,
            stiffness in prop::collection::vec(0.5..2.0, 40),
            dashpot in 0.01..1.0,
            loss_factor in 0.0..0.1,
        ) {
            let [k, m, c] = chain(n, &stiffness, dashpot);
            let mut sweep = DynamicStiffness::new(&k, &m, Some(&c)).unwrap();
            for omega in [0.1, 0.7, 1.3, 2.9] {
                let right = DMatrix::from_fn(n, 2, |i, j| Complex::new((i * 7 + j) as f64 % 3.0, j as f64));
                let mut x = right.clone();
                prop_assert!(sweep.solve(omega, loss_factor, &mut x));
                let z = DMatrix::from_fn(n, n, |i, j| {
                    Complex::new(k[(i, j)] - omega * omega * m[(i, j)], loss_factor * k[(i, j)] + omega * c[(i, j)])
                });
                let residual = (&z * &x - &right).camax();
                prop_assert!(residual <= 1e-12 * z.camax() * x.camax().max(1.0), "{residual}");
            }
        }
    }

    #[test]
    fn a_singular_stiffness_has_no_solution() {
        let zero = DMatrix::zeros(3, 3);
        let mut sweep = DynamicStiffness::new(&zero, &zero, None).unwrap();
        assert!(!sweep.solve(1.0, 0.0, &mut DMatrix::from_element(3, 1, Complex::new(1.0, 0.0))));
        let broken = DMatrix::from_element(3, 3, f64::NAN);
        let mut sweep = DynamicStiffness::new(&broken, &zero, None).unwrap();
        assert!(!sweep.solve(1.0, 0.0, &mut DMatrix::from_element(3, 1, Complex::new(1.0, 0.0))));
    }
}
