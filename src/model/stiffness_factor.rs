//! K of a structure that is held, factored: displacements under static loads.

use super::{Matrices, ModalSolver, ModelError, ParametricModel};
use crate::linalg::sparse::PencilFactor;
use crate::linalg::{DMatrix, LinalgError};
use crate::modal::ModalError;
use nalgebra::{Cholesky, Dyn};

/// A factor of K, dense or sparse as its matrices are.
#[derive(Debug)]
pub enum StiffnessFactor {
    /// Dense.
    Dense(Cholesky<f64, Dyn>),
    /// Sparse.
    Sparse(PencilFactor),
}

impl StiffnessFactor {
    /// K⁻¹ F.
    ///
    /// * `forces` - F, (n x any number)
    ///
    /// # Panics
    /// If F has another number of rows.
    pub fn solve(&self, forces: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Dense(factor) => factor.solve(forces),
            Self::Sparse(factor) => factor.solve(forces),
        }
    }
}

impl ModalSolver {
    /// K factored.
    ///
    /// * `matrices` - of `model` at one θ
    ///
    /// # Errors
    /// K is not positive definite: the structure is free to move, or unstable.
    pub fn factor(&self, model: &dyn ParametricModel, matrices: &Matrices) -> Result<StiffnessFactor, ModelError> {
        match matrices {
            Matrices::Dense(system) => {
                let factor = system.stiffness.clone().cholesky().map(StiffnessFactor::Dense);
                factor.ok_or_else(|| ModalError::from(LinalgError::NotPositiveDefinite { row: 0, shift: 0.0 }).into())
            }
            Matrices::Sparse(system) => {
                let plan = self.plan_for(model, system)?;
                let factor = PencilFactor::new(plan, &system.stiffness, &system.mass, 0.0).map_err(ModalError::from)?;
                Ok(StiffnessFactor::Sparse(factor))
            }
        }
    }
}
