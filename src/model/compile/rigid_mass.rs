//! Rᵀ M R of the six rigid motions of a model: its mass, centre of gravity and inertia.

use super::Model;
use crate::linalg::SymMatrix;
use crate::model::ModelError;
use crate::model::assembly::AffineMass;
use crate::model::dependence::weighed_mass;
use crate::model::mass_properties::add_rigid_mass;

impl Model {
    /// Rᵀ M R of the six rigid motions in the terms of [`Self::affine_part`].
    pub(in crate::model) fn affine_mass_part(&self) -> &AffineMass {
        &self.rigid_mass
    }

    /// Rᵀ M R of the six rigid motions about the origin at θ, (6 x 6).
    pub fn rigid_mass(&self, theta: &[f64]) -> Result<SymMatrix, ModelError> {
        let mut rigid = self.rigid_mass.at(&self.affine, theta);
        self.general.iter().try_for_each(|&e| self.add_rigid_mass_of(e, theta, &mut rigid))?;
        Ok(rigid)
    }

    /// Adds what one element has of it.
    pub(super) fn add_rigid_mass_of(
        &self,
        element: usize,
        theta: &[f64],
        rigid: &mut SymMatrix,
    ) -> Result<(), ModelError> {
        let element = &self.elements[element];
        if !element.nodes.iter().any(|n| self.geometry.is_coordinate(*n)) {
            let at = element.ends_at(&self.geometry.positions, theta);
            add_rigid_mass(rigid, 1.0, &weighed_mass(element, theta)?, &element.axes, &at);
        }
        Ok(())
    }
}
