//! Symmetric matrices, eigenproblems and least squares: the only place that names faer.
//!
//! Matrices at the interface are nalgebra's `DMatrix<f64>` and `DVector<f64>`; what a kernel uses inside is its own
//! affair. Start reading at [`lowest_modes`], the generalized eigenproblem every modal analysis goes through.

pub mod batch;
mod decompositions;
mod dynamic_stiffness;
mod eigen;
mod eigenvalues;
mod envelope;
mod orthogonal;
mod pencil_slopes;
pub mod sparse;
mod superposition;
mod symmetric;
mod tall;
pub mod vector3;

pub use decompositions::{ShiftedPencil, Svd, SymmetricEigen, symmetric_eigen, symmetric_values, thin_svd};
pub use dynamic_stiffness::DynamicStiffness;
pub use eigen::{Eigenpairs, lowest_modes, lowest_values};
pub use eigenvalues::{GeneralEigenpairs, general_eigenpairs};
pub use nalgebra::{Complex, DMatrix, DMatrixView, DVector, DVectorView};
pub use orthogonal::{ThinQr, thin_qr};
pub use pencil_slopes::{PencilSlopes, SlopesAt};
pub use superposition::{EntrySlopes, Superposition};
pub use symmetric::SymMatrix;
pub use tall::{tall_take, tall_tr_mul};

/// Why a numerical kernel has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinalgError {
    /// `K + a M` is not positive definite.
    #[error(
        "the matrix K + {shift:.3e} M is not positive definite at row {row}: the dof has neither stiffness nor mass, or a stiffness is negative"
    )]
    NotPositiveDefinite {
        /// Row of the first pivot that fails.
        row: usize,
        /// The shift a, rad²/s².
        shift: f64,
    },
    /// An entry is NaN or infinite.
    #[error("the {matrix} matrix has a value that is not finite in row {row}")]
    NotFinite {
        /// "stiffness", "mass" or "decomposed".
        matrix: &'static str,
        /// Row of the entry.
        row: usize,
    },
    /// The modes counted are more than those found.
    #[error(
        "{counted} modes lie below {:.6} Hz by the inertia of K - σM, but only {found} were found", below.max(0.0).sqrt() / std::f64::consts::TAU
    )]
    MissedModes {
        /// Modes found below σ, those known included.
        found: usize,
        /// Modes counted below σ.
        counted: usize,
        /// σ, rad²/s².
        below: f64,
    },
    /// The factor of a sparse matrix does not fit into the memory.
    #[error("the factor of the sparse matrix does not fit into the memory")]
    OutOfMemory,
    /// An iteration did not converge.
    #[error("the eigenvalue iteration did not converge on a matrix of {size} rows")]
    NoConvergence {
        /// Size of the matrix.
        size: usize,
    },
}
