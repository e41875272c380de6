//! The matrix pencil K(θ), M(θ), affine in the parameters, as sparse lists.

use super::BatchError;
use crate::DMatrix;

/// One term of the lower triangle: `matrix[row][col] += coefficient * (θ[parameter] or 1)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AffineEntry {
    /// Row, at least `col`.
    pub row: usize,
    /// Column.
    pub col: usize,
    /// Which parameter multiplies the coefficient; `None` is the constant part.
    pub parameter: Option<usize>,
    /// The coefficient, in the unit of the matrix over that of the parameter.
    pub coefficient: f64,
}

/// K(θ) = K₀ + Σ θ_j K_j and M(θ) = M₀ + Σ θ_j M_j, both symmetric (n x n).
///
/// Terms of the same entry and parameter add up.
#[derive(Debug, Clone, PartialEq)]
pub struct AffinePencil {
    /// Number of dofs.
    pub n: usize,
    /// Length of θ.
    pub n_parameters: usize,
    /// The terms of K, N/m and so on.
    pub stiffness: Vec<AffineEntry>,
    /// The terms of M, kg and so on.
    pub mass: Vec<AffineEntry>,
}

impl AffinePencil {
    /// K(θ) and M(θ) as full matrices (n x n each).
    ///
    /// # Panics
    /// If `theta` does not have `n_parameters` values or an entry lies outside the matrices.
    pub fn assemble(&self, theta: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        assert_eq!(theta.len(), self.n_parameters, "one value per parameter");
        let full = |entries: &[AffineEntry]| {
            let mut a = DMatrix::zeros(self.n, self.n);
            for e in entries {
                let value = e.coefficient * e.parameter.map_or(1.0, |p| theta[p]);
                a[(e.row, e.col)] += value;
                if e.row != e.col {
                    a[(e.col, e.row)] += value;
                }
            }
            a
        };
        (full(&self.stiffness), full(&self.mass))
    }

    /// Refuses entries outside the lower triangle, unknown parameters and numbers that are not finite.
    pub(super) fn check(&self) -> Result<(), BatchError> {
        for (matrix, entries) in [("stiffness", &self.stiffness), ("mass", &self.mass)] {
            for e in entries {
                if e.row >= self.n || e.col > e.row {
                    return Err(BatchError::EntryOutside { matrix, row: e.row, col: e.col, n: self.n });
                }
                if let Some(parameter) = e.parameter.filter(|&p| p >= self.n_parameters) {
                    return Err(BatchError::UnknownParameter { matrix, parameter, n_parameters: self.n_parameters });
                }
                if !e.coefficient.is_finite() {
                    return Err(BatchError::NotFinite { matrix, row: e.row, col: e.col });
                }
            }
        }
        Ok(())
    }

    /// K_j R for every parameter and the constant part must vanish: the largest relative violation and its dof.
    pub(super) fn rigid_violation(&self, rigid: &DMatrix<f64>) -> (f64, usize) {
        let mut worst = (0.0, 0);
        for column in rigid.column_iter() {
            // One slot per matrix: the constant part first.
            let mut force = vec![0.0; (self.n_parameters + 1) * self.n];
            let mut size = vec![0.0; (self.n_parameters + 1) * self.n];
            for e in &self.stiffness {
                let at = e.parameter.map_or(0, |p| p + 1) * self.n;
                let mut add = |i: usize, j: usize| {
                    force[at + i] += e.coefficient * column[j];
                    size[at + i] += (e.coefficient * column[j]).abs();
                };
                add(e.row, e.col);
                if e.row != e.col {
                    add(e.col, e.row);
                }
            }
            for (slot, (f, s)) in force.iter().zip(&size).enumerate() {
                if *s > 0.0 && f.abs() / s > worst.0 {
                    worst = (f.abs() / s, slot % self.n);
                }
            }
        }
        worst
    }
}
