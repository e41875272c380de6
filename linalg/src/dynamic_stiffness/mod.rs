//! The dynamic stiffness of a structure, solved at many frequencies.
//!
//! ```text
//! once           order with a small envelope -> places of the entries of K, C, M in it
//! eight lines    Z(ω) = K (1 + i η) + i ω C - ω² M -> Z = L D Lᵀ -> X = Z⁻¹ B, with a column whose residual is known
//! a line whose residual is too large     sparse factors with partial pivoting
//! ```
//!
//! Z is symmetric, not Hermitian. Without pivots its factors can grow where ω comes near a frequency of a leading part of the
//! structure; the residual says so, and only that line is solved again.

mod lanes;
mod pivoted;

use crate::envelope::{Envelope, reverse_cuthill_mckee};
use crate::{Complex, DMatrix, LinalgError};
use lanes::{LINES, Lines};
use pivoted::Pivoted;
use std::collections::BTreeSet;

/// Largest residual of a row over the sum of its terms with which a line is taken: rounding leaves some 1e-15.
const RESIDUAL: f64 = 1e-11;

/// An entry of the lower triangle: K, C and M there.
#[derive(Debug, Clone, Copy)]
struct Entry {
    row: usize,
    column: usize,
    values: [f64; 3],
}

/// Z(ω) = K (1 + i η) + i ω C - ω² M, whose pattern and elimination order are found once.
pub struct DynamicStiffness {
    n: usize,
    /// In the order of the elimination.
    entries: Vec<Entry>,
    envelope: Envelope,
    /// `order[new] = old`.
    order: Vec<usize>,
    pivoted: Option<Pivoted>,
}

impl DynamicStiffness {
    /// From K, M and C, (n x n) each; the lower triangles are read.
    ///
    /// # Panics
    /// If sizes differ.
    pub fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, c: Option<&DMatrix<f64>>) -> Self {
        let n = k.nrows();
        assert!(
            [k.shape(), m.shape()].iter().chain(&c.map(DMatrix::shape)).all(|s| *s == (n, n)),
            "matrices of one size"
        );
        let mut list = Vec::new();
        let mut neighbours = vec![BTreeSet::new(); n];
        for j in 0..n {
            for i in j..n {
                let values = [k[(i, j)], c.map_or(0.0, |c| c[(i, j)]), m[(i, j)]];
                if i == j || values != [0.0; 3] {
                    list.push((i, j, values));
                }
                if i != j && values != [0.0; 3] {
                    neighbours[i].insert(j);
                    neighbours[j].insert(i);
                }
            }
        }
        let order = reverse_cuthill_mckee(&neighbours);
        let mut new = vec![0; n];
        order.iter().enumerate().for_each(|(at, &old)| new[old] = at);
        let mut first: Vec<usize> = (0..n).collect();
        let place = |(i, j, values): (usize, usize, [f64; 3])| {
            let (row, column) = (new[i].max(new[j]), new[i].min(new[j]));
            first[row] = first[row].min(column);
            Entry { row, column, values }
        };
        let entries = list.into_iter().map(place).collect();
        Self { n, entries, envelope: Envelope::new(first), order, pivoted: None }
    }

    /// Multiplications of real numbers that a sweep takes, about.
    ///
    /// * `columns` - right-hand sides
    pub fn multiplications(&self, lines: usize, columns: usize) -> f64 {
        let widths = (0..self.n).map(|i| (i - self.envelope.first[i] + 1) as f64);
        let of_line: f64 = widths.map(|w| 0.5 * w * w + 2.0 * w * columns as f64).sum();
        4.0 * lines as f64 * of_line
    }

    /// Z⁻¹ B at every ω (rad/s) with the loss factor η of all stiffness; `None` where Z has no inverse.
    ///
    /// * `b` - right-hand sides, (n x any number)
    /// * `each` - is told the number of the line and its solution, in order
    ///
    /// # Errors
    /// [`LinalgError::OutOfMemory`].
    ///
    /// # Panics
    /// If `b` has another number of rows.
    pub fn sweep(
        &mut self,
        omegas: &[f64],
        loss_factor: f64,
        b: &DMatrix<f64>,
        mut each: impl FnMut(usize, Option<&DMatrix<Complex<f64>>>),
    ) -> Result<(), LinalgError> {
        assert_eq!(b.nrows(), self.n, "rows of the right-hand sides");
        let right = DMatrix::from_fn(self.n, b.ncols(), |i, j| b[(self.order[i], j)]);
        let mut lines = Lines::new(&self.envelope, &right);
        let mut x = DMatrix::zeros(self.n, b.ncols());
        for (k, chunk) in omegas.chunks(LINES).enumerate() {
            let residual = lines.solve(&self.envelope, &self.entries, (chunk, loss_factor), &right);
            for (lane, &omega) in chunk.iter().enumerate() {
                let mut solved = residual[lane] < RESIDUAL;
                if solved {
                    lines.unload(lane, &self.order, &mut x);
                } else {
                    let pivoted = match &mut self.pivoted {
                        Some(pivoted) => pivoted,
                        none => none.insert(Pivoted::new(self.n, &self.entries)?),
                    };
                    let mut own = right.map(|v| Complex::new(v, 0.0));
                    solved = pivoted.solve(omega, loss_factor, &mut own);
                    for (row, &old) in self.order.iter().enumerate() {
                        x.row_mut(old).copy_from(&own.row(row));
                    }
                }
                each(k * LINES + lane, solved.then_some(&x));
            }
        }
        Ok(())
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
            let mut sweep = DynamicStiffness::new(&k, &m, Some(&c));
            let omegas = [0.1, 0.3, 0.7, 0.9, 1.0, 1.1, 1.2, 1.3, 1.9, 2.9];
            let right = DMatrix::from_fn(n, 2, |i, j| (i * 7 + j) as f64 % 3.0);
            let mut seen = 0;
            sweep.sweep(&omegas, loss_factor, &right, |line, x| {
                assert_eq!(line, seen);
                seen += 1;
                let (x, omega) = (x.expect("damped"), omegas[line]);
                let z = DMatrix::from_fn(n, n, |i, j| {
                    Complex::new(k[(i, j)] - omega * omega * m[(i, j)], loss_factor * k[(i, j)] + omega * c[(i, j)])
                });
                let residual = (&z * x - right.map(|v| Complex::new(v, 0.0))).camax();
                assert!(residual <= 1e-11 * z.camax() * x.camax().max(1.0), "{residual}");
            }).unwrap();
            prop_assert_eq!(seen, omegas.len());
        }
    }

    /// Two masses on springs of which the first alone rests at ω = 1: its pivot vanishes, Z is regular.
    #[test]
    fn a_line_without_pivots_is_solved_with_them() {
        let k = DMatrix::from_row_slice(3, 3, &[1.0, 0.5, 0.0, 0.5, 1.0, 0.5, 0.0, 0.5, 1.0]);
        let m = DMatrix::identity(3, 3);
        let b = DMatrix::from_row_slice(3, 1, &[1.0, 2.0, 0.5]);
        let mut found = Vec::new();
        let mut sweep = DynamicStiffness::new(&k, &m, None);
        sweep.sweep(&[0.5, 1.0, 1.0 + 1e-14], 0.0, &b, |_, x| found.push(x.map(|x| x.map(|v| v.re)))).unwrap();
        // (K - M) x = b has no inverse: rows one and three are the same.
        assert!(found[0].is_some() && found[1].is_none());
        let k = DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.5, 1.0]);
        let mut sweep = DynamicStiffness::new(&k, &DMatrix::identity(2, 2), None);
        let b = DMatrix::from_row_slice(2, 1, &[1.0, 2.0]);
        let mut lines = 0;
        sweep
            .sweep(&[1.0], 0.0, &b, |_, x| {
                lines += 1;
                // Both pivots are zero; x = (4, 2).
                let x = x.expect("regular");
                assert!((x[(0, 0)].re - 4.0).abs() < 1e-14 && (x[(1, 0)].re - 2.0).abs() < 1e-14);
            })
            .unwrap();
        assert_eq!(lines, 1);
    }

    #[test]
    fn a_singular_stiffness_has_no_solution() {
        let zero = DMatrix::zeros(3, 3);
        for broken in [zero.clone(), DMatrix::from_element(3, 3, f64::NAN)] {
            let mut sweep = DynamicStiffness::new(&broken, &zero, None);
            let b = DMatrix::from_element(3, 1, 1.0);
            sweep.sweep(&[1.0, 2.0], 0.0, &b, |_, x| assert!(x.is_none())).unwrap();
        }
    }
}
