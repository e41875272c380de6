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

    /// [`Self::rigid_mass`] with one value of θ exchanged at a time, `None` where it cannot be had: an element that is no polynomial is asked for its mass
    /// anew only where it depends on that parameter.
    ///
    /// * `others` - parameters, and the values that they have instead
    pub(super) fn rigid_masses_beside(&self, theta: &[f64], others: &[(usize, f64)]) -> Vec<Option<SymMatrix>> {
        let alone = |&e: &usize| {
            let mut own = SymMatrix::zeros(6);
            self.add_rigid_mass_of(e, theta, &mut own).ok().map(|()| own)
        };
        let known: Vec<Option<SymMatrix>> = self.general.iter().map(alone).collect();
        let mut other = theta.to_vec();
        let mut beside = |&(j, value): &(usize, f64)| {
            other[j] = value;
            let mut rigid = self.rigid_mass.at(&self.affine, &other);
            let mut add = |(&e, known): (&usize, &Option<SymMatrix>)| {
                if self.elements[e].depends_on(j) {
                    return self.add_rigid_mass_of(e, &other, &mut rigid).ok();
                }
                rigid.add_scaled(1.0, known.as_ref()?);
                Some(())
            };
            let added = self.general.iter().zip(&known).try_for_each(&mut add);
            other[j] = theta[j];
            added.map(|()| rigid)
        };
        others.iter().map(&mut beside).collect()
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
