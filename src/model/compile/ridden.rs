//! Which nodes parameters may move.

use super::Model;
use crate::element::Dof;
use crate::linalg::symmetric_eigen;
use crate::modal::ModalError;
use crate::model::dependence::interior_point;
use crate::model::place::riding;
use crate::model::{ModelError, ParametricModel};
use crate::yaml::{Problem, child};
use std::collections::HashSet;

/// A combination of the six rigid motions that strains less than this part of what the stiffest of them does strains nothing.
const UNSTRAINED: f64 = 1e-10;

impl Model {
    /// Whether the structure moves as a rigid body in some way.
    ///
    /// # Errors
    /// The model has no matrices.
    fn has_rigid_motions(&self) -> Result<bool, ModelError> {
        let mut motions = self.dofs.rigid_motions();
        for mut column in motions.column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
        let k = self.assemble_sparse(&interior_point(&self.parameters))?.stiffness;
        let work = motions.tr_mul(&k.mul(&motions));
        let moving: Vec<usize> = (0..motions.ncols()).filter(|&i| motions.column(i).norm() > 0.0).collect();
        if moving.is_empty() {
            return Ok(false);
        }
        let work = work.select_rows(&moving).select_columns(&moving);
        let largest = (0..k.n()).map(|i| k.diagonal(i)).fold(0.0, f64::max);
        let least =
            symmetric_eigen(&work).map_err(ModalError::from)?.values.iter().copied().fold(f64::INFINITY, f64::min);
        Ok(least < UNSTRAINED * largest)
    }

    /// Nodes whose places must be numbers: of a structure that moves as a rigid body those that are held or constrained where they stand or do not turn.
    pub(crate) fn fixed_places(&self) -> HashSet<usize> {
        if !self.has_rigid_motions().unwrap_or(true) {
            return HashSet::new();
        }
        let riding = riding(&self.spec, &self.geometry, &self.elements);
        riding.into_iter().filter(|&n| self.has_dofs(n)).collect()
    }

    fn has_dofs(&self, node: usize) -> bool {
        Dof::ALL.into_iter().any(|dof| !self.dofs.express(node, dof).is_empty())
    }

    /// What is wrong with a node that a parameter moves and must not.
    pub(super) fn moves_wrongly(&self) -> Result<Option<Problem>, ModelError> {
        let mut riding = self.moved.iter().filter(|(_, m)| m.rides).map(|(n, _)| *n);
        let Some(node) = riding.find(|&n| self.has_dofs(n)) else { return Ok(None) };
        if !self.has_rigid_motions()? {
            return Ok(None);
        }
        let name = &self.geometry.names[node];
        Ok(Some(Problem::error(
            child("nodes", name),
            format_args!(
                "the structure moves as a rigid body, and node `{name}`, which stands where a parameter says, is held, is constrained or does not turn: its \
                 place must be a number"
            ),
        )))
    }
}
