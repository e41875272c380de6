//! Modes of K and M: frequencies, mass-normalised shapes, rigid-body modes that are exactly zero, and FRF synthesis.
//!
//! Matrices in, modes out: nothing here knows nodes or parameters. Start at [`solve`].

mod craig_bampton;
mod frf;
mod modes;
pub mod reduction;
mod sensitivity;
mod solve;
mod sparse;
mod stability;

pub use craig_bampton::{craig_bampton, craig_bampton_sparse};
pub use frf::{ModalDamping, accelerance, synthesize};
pub use modes::{ModalError, Modes};
pub use sensitivity::{
    MatrixDerivative, ModeDerivative, derivatives_on_basis, eigenvalue_derivative, mode_derivative,
    mode_derivative_of_forces,
};
pub use solve::{SolveOptions, solve, typical_shift};
pub use sparse::{
    Across, Effort, Neighbour, derivatives_across_modes, mode_derivative_sparse, mode_derivatives_sparse, solve_sparse,
};
pub use stability::unstable_directions;
