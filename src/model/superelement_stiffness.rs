//! The stiffness of one superelement, or of a term of one, on the rows that it touches.

use super::ParametricModel;
use super::compile::Model;
use crate::linalg::DMatrix;

/// Rows of a superelement above which its stiffness is not written out as a dense matrix.
const MOST_ROWS: usize = 2_000;

impl Model {
    /// Rows and stiffness at θ of an element that stands for a superelement or a term; `None` of any other, of one without stiffness, and of
    /// one with more than 2 000 rows.
    pub fn superelement_stiffness(&self, element: usize, theta: &[f64]) -> Option<(Vec<usize>, DMatrix<f64>)> {
        let element = &self.elements()[element];
        let matrices = element.matrices.as_ref()?;
        let factor = element.stiffness_factor.as_ref().map_or(1.0, |f| f.at(theta));
        let entries = matrices.follows(self.dof_map()).reduce(matrices.k.as_deref()?);
        let mut rows: Vec<usize> = entries.iter().flat_map(|e| [e.place().0, e.place().1]).collect();
        rows.sort_unstable();
        rows.dedup();
        if rows.is_empty() || rows.len() > MOST_ROWS || factor == 0.0 {
            return None;
        }
        let place = |row: usize| rows.partition_point(|r| *r < row);
        let mut matrix = DMatrix::zeros(rows.len(), rows.len());
        for e in entries {
            let (i, j) = (place(e.place().0), place(e.place().1));
            matrix[(i, j)] += factor * e.value;
            if i != j {
                matrix[(j, i)] += factor * e.value;
            }
        }
        Some((rows, matrix))
    }
}
