//! What sensors see of a stand-in.

use super::StandIn;
use crate::linalg::{DMatrix, tall_tr_mul};
use crate::model::{ModelError, PointMotion, plus};

impl StandIn {
    /// Rows of the model on the coordinates: an observation matrix S becomes S \[V W 0\].
    ///
    /// * `rows` - (row, factor) of each
    pub fn observed(&self, rows: &[Vec<(usize, f64)>]) -> DMatrix<f64> {
        let (m, n) = (self.common.basis.ncols(), self.common.basis.nrows());
        if rows.iter().map(Vec::len).sum::<usize>() > n {
            // As good as full.
            let mut full = DMatrix::zeros(n, rows.len());
            for (mut column, terms) in full.column_iter_mut().zip(rows) {
                for &(row, factor) in terms {
                    column[row] += factor;
                }
            }
            let mut out = DMatrix::zeros(rows.len(), self.dofs.n_dof());
            out.columns_mut(0, m).copy_from(&tall_tr_mul(&full, &self.common.basis));
            out.columns_mut(m, self.extra.ncols()).copy_from(&tall_tr_mul(&full, &self.extra));
            return out;
        }
        DMatrix::from_fn(rows.len(), self.dofs.n_dof(), |i, c| {
            rows[i].iter().map(|&(row, factor)| factor * self.entry(row, c)).sum()
        })
    }

    /// How a node moves at θ, by the rows of the model, where that depends on θ: with the model, or with a change that moves it.
    pub(super) fn node_on_rows(&self, node: usize, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        let (own, sizes) = self.of_model(theta);
        let mut further = None;
        for placed in &self.changes {
            let sizes = &sizes[placed.first_size..placed.first_size + placed.change.n_sizes()];
            if let Some(by) = placed.change.displacement(node, own, sizes) {
                let sum = further.get_or_insert([[0.0; 3]; 2]);
                *sum = [0, 1].map(|k| plus(sum[k], 1.0, by[k]));
            }
        }
        self.common.model.node_moved(node, own, further)
    }
}
