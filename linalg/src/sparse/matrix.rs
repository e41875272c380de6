//! Symmetric sparse matrices: the lower triangle, column by column.

use crate::{DMatrix, tall_tr_mul};
use nalgebra::DVectorViewMut;
use rayon::prelude::*;

/// Columns that are multiplied in one pass over a matrix.
const GROUP: usize = 4;
/// Products of an entry of the triangle and a column above which threads are worth their while.
const WORTH_THREADS: usize = 200_000;

/// A symmetric sparse matrix (n x n). Its lower triangle is stored by columns, rows ascending, every diagonal entry present.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseSym {
    /// Where each column starts in `rows`, n + 1 numbers.
    pub(super) columns: Vec<usize>,
    /// Row of each entry, the diagonal first in its column.
    pub(super) rows: Vec<usize>,
    /// Value of each entry.
    pub(super) values: Vec<f64>,
}

impl SparseSym {
    /// From (row, column, value) in any order; entries of one place are summed in the order they come.
    ///
    /// An entry above the diagonal stands for its mirror image: give each pair of off-diagonal entries once.
    ///
    /// # Panics
    /// If an index is not below `n`.
    pub fn from_triplets(n: usize, triplets: impl Iterator<Item = (usize, usize, f64)> + Clone) -> Self {
        // Counting sort by column, then a stable sort of each short column by row.
        let mut starts = vec![0; n + 1];
        for (i, j, _) in triplets.clone() {
            starts[i.min(j) + 1] += 1;
        }
        for j in 0..n {
            starts[j + 1] += starts[j] + 1;
        }
        let mut entries = vec![(0usize, 0.0); starts[n]];
        let mut next: Vec<usize> = starts.clone();
        for j in 0..n {
            entries[next[j]] = (j, 0.0);
            next[j] += 1;
        }
        for (i, j, value) in triplets {
            let (row, column) = (i.max(j), i.min(j));
            assert!(row < n, "an index below the size");
            entries[next[column]] = (row, value);
            next[column] += 1;
        }
        // Summed in place: what is written never overtakes what is read.
        let mut columns = Vec::with_capacity(n + 1);
        columns.push(0);
        let mut end = 0;
        for j in 0..n {
            entries[starts[j]..starts[j + 1]].sort_by_key(|e| e.0);
            let first = end;
            for at in starts[j]..starts[j + 1] {
                let (row, value) = entries[at];
                if end > first && entries[end - 1].0 == row {
                    entries[end - 1].1 += value;
                } else {
                    entries[end] = (row, value);
                    end += 1;
                }
            }
            columns.push(end);
        }
        let entries = &entries[..end];
        let (rows, values) = (entries.iter().map(|e| e.0).collect(), entries.iter().map(|e| e.1).collect());
        Self { columns, rows, values }
    }

    /// From the lower triangle of a dense matrix, without its zeros.
    pub fn from_dense(a: &DMatrix<f64>) -> Self {
        let n = a.nrows();
        let places = (0..n).flat_map(|j| (j..n).map(move |i| (i, j)));
        Self::from_triplets(n, places.filter(|p| a[*p] != 0.0).map(|p| (p.0, p.1, a[p])))
    }

    /// The full matrix.
    pub fn to_dense(&self) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(self.n(), self.n());
        for (i, j, value) in self.entries() {
            a[(i, j)] = value;
            a[(j, i)] = value;
        }
        a
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.columns.len() - 1
    }

    /// Number of entries of the lower triangle, the diagonal included.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether it has no row.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// (row, column, value) of the lower triangle, column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + Clone + '_ {
        (0..self.n())
            .flat_map(move |j| (self.columns[j]..self.columns[j + 1]).map(move |p| (self.rows[p], j, self.values[p])))
    }

    /// Diagonal entry i.
    pub fn diagonal(&self, i: usize) -> f64 {
        self.values[self.columns[i]]
    }

    /// A x for every column of x, (n x k); columns of large matrices a few at a time on several threads, with the same bits on any number.
    ///
    /// # Panics
    /// If `x` has another number of rows.
    #[must_use]
    pub fn mul(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        assert_eq!(x.nrows(), self.n(), "one row a row of the matrix");
        let mut y = DMatrix::zeros(x.nrows(), x.ncols());
        if self.len() * x.ncols() < WORTH_THREADS {
            for (from, to) in x.column_iter().zip(y.column_iter_mut()) {
                self.times(from.as_slice(), to);
            }
            return y;
        }
        let size = GROUP * self.n();
        let groups = y.as_mut_slice().par_chunks_mut(size).zip(x.as_slice().par_chunks(size));
        groups.for_each(|(to, from)| self.times_group(from, to));
        y
    }

    /// A x of one column.
    fn times(&self, from: &[f64], mut to: DVectorViewMut<'_, f64>) {
        for j in 0..self.n() {
            let start = self.columns[j];
            let mut sum = self.values[start] * from[j];
            for p in start + 1..self.columns[j + 1] {
                let i = self.rows[p];
                to[i] += self.values[p] * from[j];
                sum += self.values[p] * from[i];
            }
            to[j] += sum;
        }
    }

    /// The same of a few columns in one pass over the matrix, in the same order of sums.
    fn times_group(&self, from: &[f64], to: &mut [f64]) {
        let n = self.n();
        let width = from.len() / n;
        let row = |i: usize| -> [f64; GROUP] { std::array::from_fn(|l| if l < width { from[l * n + i] } else { 0.0 }) };
        let x: Vec<[f64; GROUP]> = (0..n).map(row).collect();
        let mut y = vec![[0.0; GROUP]; n];
        for j in 0..n {
            let start = self.columns[j];
            let xj = x[j];
            let mut sum = xj.map(|v| self.values[start] * v);
            for p in start + 1..self.columns[j + 1] {
                let (i, value) = (self.rows[p], self.values[p]);
                for l in 0..GROUP {
                    y[i][l] += value * xj[l];
                    sum[l] += value * x[i][l];
                }
            }
            for l in 0..GROUP {
                y[j][l] += sum[l];
            }
        }
        for (l, column) in to.chunks_mut(n).enumerate() {
            column.iter_mut().zip(&y).for_each(|(v, row)| *v = row[l]);
        }
    }

    /// A V, (n x k), of which the first `n_none` columns are set to zero where they are rounding: of motions that A may not resist, rigid ones
    /// of a stiffness.
    ///
    /// # Panics
    /// If `v` has another number of rows.
    #[must_use]
    pub fn forces(&self, v: &DMatrix<f64>, n_none: usize) -> DMatrix<f64> {
        const ROUNDING: f64 = 1e-9;
        let mut av = self.mul(v);
        if n_none > 0 {
            let size = self.abs().mul(&v.columns(0, n_none).abs());
            for j in 0..n_none {
                if av.column(j).amax() <= ROUNDING * size.column(j).amax() {
                    av.column_mut(j).fill(0.0);
                }
            }
        }
        av
    }

    /// Vᵀ A V, (k x k), with [`Self::forces`]: a motion that A does not resist meets no force of the others either.
    ///
    /// # Panics
    /// If `v` has another number of rows.
    #[must_use]
    pub fn on_basis(&self, v: &DMatrix<f64>, n_none: usize) -> DMatrix<f64> {
        on_motions(v, &self.forces(v, n_none), n_none)
    }

    /// |A|, entry by entry.
    #[must_use]
    pub fn abs(&self) -> Self {
        let values = self.values.iter().map(|v| v.abs()).collect();
        Self { columns: self.columns.clone(), rows: self.rows.clone(), values }
    }
}

/// Vᵀ F of motions V and their forces F: of the first `n_none` motions those without a force meet none of the others either.
///
/// # Panics
/// If V and F have different numbers of rows.
#[must_use]
pub fn on_motions(v: &DMatrix<f64>, forces: &DMatrix<f64>, n_none: usize) -> DMatrix<f64> {
    let mut projected = tall_tr_mul(v, forces);
    for j in (0..n_none).filter(|&j| forces.column(j).amax() == 0.0) {
        projected.row_mut(j).fill(0.0);
    }
    projected
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns in groups, on threads, have the bits of columns one by one.
    #[test]
    fn groups_of_columns_have_the_bits_of_single_ones() {
        let n = 3001;
        let entry = |i: usize, j: usize| (((7 * i + 13 * j) % 101) as f64 - 50.0) / 7.0;
        let places = (0..n).flat_map(|j| [j, j + 1, j + 2, j + 17, j + 400].map(|i| (i, j))).filter(|p| p.0 < n);
        let a = SparseSym::from_triplets(n, places.map(|(i, j)| (i, j, entry(i, j))));
        let x = DMatrix::from_fn(n, 23, |i, j| entry(j, i));
        assert!(a.len() * x.ncols() >= WORTH_THREADS);
        let together = a.mul(&x);
        for (j, column) in x.column_iter().enumerate() {
            let alone = a.mul(&DMatrix::from_columns(&[column]));
            assert_eq!(alone.as_slice(), together.column(j).as_slice(), "column {j}");
        }
    }

    #[test]
    fn triplets_of_one_place_add_up_from_either_triangle() {
        let a = SparseSym::from_triplets(3, [(0, 1, 1.0), (2, 0, 4.0), (1, 0, 2.0), (2, 2, 5.0)].into_iter());
        let full = DMatrix::from_row_slice(3, 3, &[0.0, 3.0, 4.0, 3.0, 0.0, 0.0, 4.0, 0.0, 5.0]);
        assert_eq!(a.to_dense(), full);
        assert_eq!(a.len(), 5);
        assert_eq!(SparseSym::from_dense(&full), a);
        let x = DMatrix::from_row_slice(3, 2, &[1.0, 0.5, 2.0, -1.0, 3.0, 0.25]);
        assert_eq!(a.mul(&x), &full * &x);
        assert_eq!((a.diagonal(1), a.diagonal(2), a.n(), a.is_empty()), (0.0, 5.0, 3, false));
    }
}
