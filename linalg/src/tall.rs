//! Products of tall matrices: many rows, few columns. Columns a few at a time on several threads, with the same bits on any number.

use crate::DMatrix;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns of a task.
const GROUP: usize = 16;

fn of(a: &[f64], rows: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a, rows, a.len() / rows)
}

/// Aᵀ B.
///
/// # Panics
/// If A and B have different numbers of rows.
#[must_use]
pub fn tall_tr_mul(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    assert_eq!(a.nrows(), b.nrows(), "as many rows");
    let (n, m) = a.shape();
    let mut out = DMatrix::zeros(m, b.ncols());
    if n == 0 || m == 0 || b.ncols() == 0 {
        return out;
    }
    let groups = out.as_mut_slice().par_chunks_mut(GROUP * m).zip(b.as_slice().par_chunks(GROUP * n));
    groups.for_each(|(to, b)| {
        let width = b.len() / n;
        let to = MatMut::from_column_major_slice_mut(to, m, width);
        matmul(to, Accum::Replace, of(a.as_slice(), n).transpose(), of(b, n), 1.0, Par::Seq);
    });
    out
}

/// X - A C, in the place of X.
///
/// # Panics
/// If the sizes do not fit.
pub fn tall_take(x: &mut DMatrix<f64>, a: &DMatrix<f64>, c: &DMatrix<f64>) {
    assert_eq!((x.nrows(), x.ncols(), a.ncols()), (a.nrows(), c.ncols(), c.nrows()), "sizes that fit");
    let (n, m) = a.shape();
    if n == 0 || m == 0 || c.ncols() == 0 {
        return;
    }
    let groups = x.as_mut_slice().par_chunks_mut(GROUP * n).zip(c.as_slice().par_chunks(GROUP * m));
    groups.for_each(|(x, c)| {
        let width = c.len() / m;
        let x = MatMut::from_column_major_slice_mut(x, n, width);
        matmul(x, Accum::Add, of(a.as_slice(), n), of(c, m), -1.0, Par::Seq);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_small_matrices() {
        let of = |n: usize, m: usize, seed: usize| {
            DMatrix::from_fn(n, m, |i, j| (((3 * i + 7 * j + seed) % 29) as f64 - 14.0) / 3.0)
        };
        let (a, b, c) = (of(500, 11, 1), of(500, 37, 2), of(11, 37, 3));
        assert!((tall_tr_mul(&a, &b) - a.transpose() * &b).amax() < 1e-9);
        let mut x = b.clone();
        tall_take(&mut x, &a, &c);
        assert!((x - (b - a * c)).amax() < 1e-9);
        assert_eq!(tall_tr_mul(&of(0, 3, 1), &of(0, 2, 1)).shape(), (3, 2));
    }
}
