//! A model that is a polynomial of its parameters everywhere, in the place of one that is not.

use super::Model;
use crate::linalg::SymMatrix;
use crate::model::ModelError;
use crate::model::assembly::Basis;
use crate::model::dependence::Monomial;

impl Model {
    /// The same with everything that is not a polynomial of θ as it is at one point: a term without powers, the last of the products.
    ///
    /// # Errors
    /// An element has no matrices there.
    pub(in crate::model) fn frozen_at(&self, theta: &[f64]) -> Result<Self, ModelError> {
        let mut basis = Basis::default();
        for part in self.general_matrices(theta) {
            let (connection, matrices) = part?;
            basis.add(connection, &matrices);
        }
        let mut rigid = SymMatrix::zeros(6);
        self.general.iter().try_for_each(|&e| self.add_rigid_mass_of(e, theta, &mut rigid))?;
        let mut frozen = self.clone();
        frozen.affine.products.push((Monomial::default(), basis));
        frozen.rigid_mass.products.push(rigid);
        frozen.general.clear();
        frozen.elastic_supports = None;
        Ok(frozen)
    }
}
