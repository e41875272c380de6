//! The forces that a change can exert: what its static shapes answer to.

use super::StandIn;
use crate::linalg::{DMatrix, symmetric_eigen, tall_tr_mul};
use crate::model::ParametricModel;
use crate::model::change::ChangeAt;

/// Most static shapes of a change: three for each of a dozen modes, as what couples two kinds of motion needs, bending and stretching, and what answers to
/// their forces.
const MOST_SHAPES: usize = 40;
/// Up to this many touched dofs a change has the shapes of all forces that it can exert.
pub(super) const FEW_ROWS: usize = 36;
/// Forces, and energies of static shapes, below this part of the largest are rounding, or of no account.
pub(super) const NEGLIGIBLE: f64 = 1e-7;

impl StandIn {
    /// Forces of a change on the rows, (n x few), and the scales of its new coordinates.
    pub(super) fn forces(&self, change: &ChangeAt<'_>) -> (DMatrix<f64>, Vec<f64>) {
        let (touched, old) = (change.rows(), change.old_rows().len());
        let mut scales = vec![1.0; touched.len() - old];
        let forces = if touched.len() <= FEW_ROWS {
            // All that it can exert: the columns of its matrices.
            let [k, m] = change.times(&DMatrix::identity(touched.len(), touched.len()));
            let at = |a: &Option<DMatrix<f64>>, i: usize| a.as_ref().map_or(0.0, |a| a[(i, i)]);
            for (c, scale) in scales.iter_mut().enumerate() {
                let x = at(&k, old + c) + self.common.shift * at(&m, old + c);
                if x > 0.0 {
                    *scale = x.sqrt().recip();
                }
            }
            self.by_both([k, m], old)
        } else {
            // What it exerts on the vectors of the basis, of which the modes are combinations where it is small, and on what answers to that: what is
            // nearly cut moves as neither of them does alone.
            let on = |v: &DMatrix<f64>| {
                let motion = |i: usize, c: usize| if i < old { v[(touched[i], c)] } else { 0.0 };
                self.by_both(change.times(&DMatrix::from_fn(touched.len(), v.ncols(), motion)), old)
            };
            let on_basis = on(&self.common.basis);
            let first = self.leading(&on_basis, change.old_rows());
            let mut answers = self.common.factor.solve(&first);
            for (mut answer, force) in answers.column_iter_mut().zip(first.column_iter()) {
                let energy = answer.dot(&force);
                if energy > 0.0 {
                    answer /= energy.sqrt();
                }
            }
            beside(on_basis, &on(&answers))
        };
        (self.leading(&forces, change.old_rows()), scales)
    }

    /// Forces by K and by M, these at the shift, on the rows of the model.
    fn by_both(&self, forces: [Option<DMatrix<f64>>; 2], old: usize) -> DMatrix<f64> {
        let [k, m] = forces.map(|a| a.map_or_else(|| DMatrix::zeros(old, 0), |a| a.rows(0, old).into_owned()));
        beside(k, &(m * self.common.shift))
    }

    /// The leading directions of some forces, of unit length, on all rows.
    fn leading(&self, columns: &DMatrix<f64>, rows: &[usize]) -> DMatrix<f64> {
        let n = self.common.model.dof_map().n_dof();
        // Forces and moments are as large as their stiffness makes them: each row by its own.
        let weight: Vec<f64> = (0..columns.nrows()).map(|i| columns.row(i).norm()).collect();
        let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| {
            if weight[i] > 0.0 { columns[(i, j)] / weight[i].sqrt() } else { 0.0 }
        });
        // The smaller of the two Gram matrices: both have the same eigenvalues but for zeros.
        let is_tall = scaled.nrows() > scaled.ncols();
        let gram = if is_tall { tall_tr_mul(&scaled, &scaled) } else { &scaled * scaled.transpose() };
        let Ok(eigen) = symmetric_eigen(&gram) else { return DMatrix::zeros(n, 0) };
        let mut order: Vec<usize> = (0..eigen.values.len()).filter(|&k| eigen.values[k] > 0.0).collect();
        order.sort_by(|&a, &b| eigen.values[b].total_cmp(&eigen.values[a]));
        let largest = order.first().map_or(0.0, |&k| eigen.values[k]);
        let is_felt = |&k: &usize| eigen.values[k] > NEGLIGIBLE * NEGLIGIBLE * largest;
        let kept: Vec<usize> = order.into_iter().take(MOST_SHAPES).filter(is_felt).collect();
        let mut forces = eigen.vectors.select_columns(&kept);
        if is_tall {
            forces = scaled * forces;
        }
        for (i, mut row) in forces.row_iter_mut().enumerate() {
            row *= weight[i].sqrt();
        }
        let mut out = DMatrix::zeros(n, kept.len());
        for (c, force) in forces.column_iter().enumerate() {
            let norm = force.norm();
            rows.iter().zip(force.iter()).for_each(|(&row, f)| out[(row, c)] = f / norm);
        }
        out
    }
}

/// The columns of one matrix, and behind them those of another.
fn beside(a: DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let first = a.ncols();
    let mut both = a.resize_horizontally(first + b.ncols(), 0.0);
    both.columns_mut(first, b.ncols()).copy_from(b);
    both
}
