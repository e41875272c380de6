//! Z(ω) with partial pivoting, line by line: for lines that the factorisation without pivots does not solve.

use super::Entry;
use crate::{Complex, DMatrix, LinalgError};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::prelude::default;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

/// The elimination order, found once.
pub(super) struct Pivoted {
    n: usize,
    columns: Vec<usize>,
    rows: Vec<usize>,
    /// K, C and M of every entry.
    entries: Vec<[f64; 3]>,
    order: SymbolicLu<usize>,
    factors: NumericLu<usize, Complex<f64>>,
    values: Vec<Complex<f64>>,
}

impl Pivoted {
    /// * `lower` - the entries of the lower triangle, (n x n)
    pub(super) fn new(n: usize, lower: &[Entry]) -> Result<Self, LinalgError> {
        let both = lower.iter().flat_map(|e| {
            let mirrored = (e.row != e.column).then_some((e.row, e.column, e.values));
            [Some((e.column, e.row, e.values)), mirrored].into_iter().flatten()
        });
        // By columns, then rows.
        let mut sorted: Vec<(usize, usize, [f64; 3])> = both.collect();
        sorted.sort_by_key(|e| (e.0, e.1));
        let mut columns = vec![0; n + 1];
        for e in &sorted {
            columns[e.0 + 1] += 1;
        }
        for j in 0..n {
            columns[j + 1] += columns[j];
        }
        let rows: Vec<usize> = sorted.iter().map(|e| e.1).collect();
        let entries: Vec<[f64; 3]> = sorted.iter().map(|e| e.2).collect();
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
        let order = factorize_symbolic_lu(pattern, default()).map_err(|_| LinalgError::OutOfMemory)?;
        let values = vec![Complex::default(); entries.len()];
        Ok(Self { n, columns, rows, entries, order, factors: NumericLu::new(), values })
    }

    /// Z⁻¹ B in place of B, (n x any number); false where Z has no inverse.
    pub(super) fn solve(&mut self, omega: f64, loss_factor: f64, b: &mut DMatrix<Complex<f64>>) -> bool {
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
