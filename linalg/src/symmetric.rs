//! Small symmetric matrices, symmetric by construction.

use super::DMatrix;

/// A symmetric matrix that stores its lower triangle only, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct SymMatrix {
    n: usize,
    lower: Vec<f64>,
}

impl SymMatrix {
    /// The zero matrix, `n` x `n`.
    pub fn zeros(n: usize) -> Self {
        Self { n, lower: vec![0.0; n * (n + 1) / 2] }
    }

    /// From the rows of the lower triangle: 1 + 2 + ... + n numbers.
    ///
    /// # Panics
    /// If the count of numbers is not n(n+1)/2.
    pub fn from_lower(n: usize, lower: &[f64]) -> Self {
        assert_eq!(lower.len(), n * (n + 1) / 2, "a lower triangle of {n} rows");
        Self { n, lower: lower.to_vec() }
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Entry (i, j), either triangle.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.lower[index(i, j)]
    }

    /// Adds to entry (i, j) and so to (j, i).
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.lower[index(i, j)] += value;
    }

    /// Adds `factor v vᵀ`.
    pub fn add_outer(&mut self, factor: f64, v: &[f64]) {
        for i in 0..self.n {
            if v[i] != 0.0 {
                for j in 0..=i {
                    self.lower[i * (i + 1) / 2 + j] += factor * v[i] * v[j];
                }
            }
        }
    }

    /// Multiplies every entry.
    pub fn scale(&mut self, factor: f64) {
        self.lower.iter_mut().for_each(|v| *v *= factor);
    }

    /// Adds `factor` times another matrix.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn add_scaled(&mut self, factor: f64, other: &SymMatrix) {
        assert_eq!(self.n, other.n, "matrices of one size");
        self.lower.iter_mut().zip(&other.lower).for_each(|(a, b)| *a += factor * b);
    }

    /// Takes over the entries of another matrix.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn copy_from(&mut self, other: &SymMatrix) {
        self.lower.copy_from_slice(&other.lower);
    }

    /// out = self v.
    ///
    /// # Panics
    /// If a length is not the number of rows.
    pub fn multiply(&self, v: &[f64], out: &mut [f64]) {
        assert!(v.len() == self.n && out.len() == self.n, "vectors of {} rows", self.n);
        out.fill(0.0);
        let mut rest = self.lower.as_slice();
        for i in 0..self.n {
            let (row, below) = rest.split_at(i + 1);
            rest = below;
            let mut sum = row[i] * v[i];
            for j in 0..i {
                sum += row[j] * v[j];
                out[j] += row[j] * v[i];
            }
            out[i] += sum;
        }
    }

    /// Whether every entry is zero.
    pub fn is_zero(&self) -> bool {
        self.lower.iter().all(|v| *v == 0.0)
    }

    /// The entries of the lower triangle, row by row.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// The same, to be overwritten.
    pub fn lower_mut(&mut self) -> &mut [f64] {
        &mut self.lower
    }

    /// Entry by entry, `f(self, other)`.
    ///
    /// # Panics
    /// If the sizes differ.
    #[must_use]
    pub fn combine(&self, other: &SymMatrix, f: impl Fn(f64, f64) -> f64) -> SymMatrix {
        assert_eq!(self.n, other.n, "matrices of one size");
        let lower = self.lower.iter().zip(&other.lower).map(|(a, b)| f(*a, *b)).collect();
        SymMatrix { n: self.n, lower }
    }

    /// The full matrix.
    pub fn to_dense(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.n, self.n, |i, j| self.get(i, j))
    }

    /// The symmetric part of a full matrix, (a + aᵀ)/2.
    pub fn from_dense(a: &DMatrix<f64>) -> Self {
        let n = a.nrows();
        let mut s = Self::zeros(n);
        for i in 0..n {
            for j in 0..=i {
                s.lower[i * (i + 1) / 2 + j] = 0.5 * (a[(i, j)] + a[(j, i)]);
            }
        }
        s
    }
}

fn index(i: usize, j: usize) -> usize {
    let (i, j) = if i >= j { (i, j) } else { (j, i) };
    i * (i + 1) / 2 + j
}
