//! Modes of the model that a fit finds again at every point.
//!
//! Where few sensors see modes alike, or a test has no shapes, a MAC at the sensors does not tell which mode is which, and its frequency does
//! not either while parameters move. The whole shape does: with M φ of the partner where the pairs were decided, and φ' of unit modal mass,
//!
//! ```text
//! t = (φ'ᵀ M φ)²          one for the mode that continues φ, zero for all others while M and the modes stay
//! likeness = (MAC + t)/2  of a measured shape;  t alone of a mode without one, or that the user has named
//! ```
//!
//! # Source
//! M. S. Eldred, V. B. Venkayya, W. J. Anderson, Mode tracking issues in structural optimization, AIAA Journal 33 (1995) 1926-1933
//! (cross-orthogonality check).

use crate::data::{Reference, Standing, TestData};
use crate::linalg::DMatrix;
use crate::modal::Modes;
use crate::model::ParametricModel;
use std::collections::HashMap;

/// The rows of what is followed.
#[derive(Debug, Clone, Default)]
pub(super) struct Followed {
    /// (M φ)ᵀ of each on the rows of the model, (n_followed x n_dof).
    rows: DMatrix<f64>,
    /// The test mode of each, and whether nothing but its row tells.
    modes: Vec<(usize, bool)>,
}

impl Followed {
    /// Of the modes of a test that are followed, on the rows of a model; a dof that this model does not have has no part.
    pub(super) fn new(model: &dyn ParametricModel, test: &TestData) -> Self {
        let of = |standing: &Standing| match standing {
            Standing::Found { reference, .. } => reference.clone(),
            _ => None,
        };
        let all: Vec<(usize, std::sync::Arc<Reference>)> =
            test.modes.iter().enumerate().filter_map(|(i, m)| Some((i, of(&m.standing)?))).collect();
        if all.is_empty() {
            return Self::default();
        }
        // Rows of a model that another stands in for move with the coordinates of that.
        let map = model.dofs_of_nodes();
        let nodes: HashMap<&str, usize> = map.node_names().iter().enumerate().map(|(i, n)| (n.as_str(), i)).collect();
        let row_of = |(_, reference): &(usize, std::sync::Arc<Reference>)| -> Vec<(usize, f64)> {
            let all = reference.dofs.iter().zip(&reference.momentum);
            let known = all
                .filter_map(|((node, dof), momentum)| Some((map.express(*nodes.get(node.as_str())?, *dof), momentum)));
            known
                .flat_map(|(terms, momentum)| terms.iter().map(move |&(row, factor)| (row, factor * momentum)))
                .collect()
        };
        let given: Vec<Vec<(usize, f64)>> = all.iter().map(row_of).collect();
        let rows = match model.stand_in() {
            Some(stand_in) => stand_in.observed(&given),
            None => {
                let mut rows = DMatrix::zeros(all.len(), map.n_dof());
                for (k, terms) in given.iter().enumerate() {
                    for &(row, value) in terms {
                        rows[(k, row)] += value;
                    }
                }
                rows
            }
        };
        Self { rows, modes: all.iter().map(|(i, r)| (*i, r.alone)).collect() }
    }

    /// Rows of it, (n_followed x n_dof).
    pub(super) fn rows(&self) -> &DMatrix<f64> {
        &self.rows
    }

    /// Of each: the test mode, whether nothing but its row tells, and its row.
    pub(super) fn list(&self) -> Vec<(usize, bool, Vec<f64>)> {
        let row = |k: usize| self.rows.row(k).iter().copied().collect();
        self.modes.iter().enumerate().map(|(k, &(mode, alone))| (mode, alone, row(k))).collect()
    }

    /// Number of modes that are followed.
    pub(super) fn len(&self) -> usize {
        self.modes.len()
    }

    /// Likeness of every mode of the model with every test mode; `None` where none is followed.
    ///
    /// * `mac` - (n_model x n_test)
    /// * `modes` - of the model
    pub(super) fn likeness(&self, mac: &DMatrix<f64>, modes: &Modes) -> Option<DMatrix<f64>> {
        if self.modes.is_empty() {
            return None;
        }
        let elastic = modes.elastic();
        let products = &self.rows * modes.shapes.columns(elastic.start, elastic.len());
        let mut out = mac.clone();
        for k in 0..self.modes.len() {
            for i in 0..mac.nrows() {
                self.mix(k, i, products[(k, i)], &mut out);
            }
        }
        Some(out)
    }

    /// Mixes what one row says of one mode of the model into a matrix of MAC.
    ///
    /// * `product` - of row `k` with the shape of mode `i`
    pub(super) fn mix(&self, k: usize, i: usize, product: f64, likeness: &mut DMatrix<f64>) {
        let (mode, alone) = self.modes[k];
        let same = (product * product).min(1.0);
        let value = &mut likeness[(i, mode)];
        *value = if alone { same } else { 0.5 * (*value + same) };
    }
}
