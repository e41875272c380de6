//! Symmetric matrices, eigenproblems and least squares: the only place that names faer.
//!
//! Matrices at the interface are nalgebra's `DMatrix<f64>` and `DVector<f64>`; what a kernel uses inside is its own
//! affair. Start reading at [`lowest_modes`], the generalized eigenproblem every modal analysis goes through.

pub mod batch;
mod decompositions;
mod eigen;
mod eigenvalues;
mod orthogonal;
mod symmetric;

pub use decompositions::{Svd, shifted_pencil, thin_svd};
pub use eigen::{Eigenpairs, lowest_modes};
pub use eigenvalues::{GeneralEigenpairs, general_eigenpairs};
pub use nalgebra::{Complex, DMatrix, DVector};
pub use orthogonal::{ThinQr, thin_qr};
pub use symmetric::SymMatrix;

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
    /// An iteration did not converge.
    #[error("the eigenvalue iteration did not converge on a matrix of {size} rows")]
    NoConvergence {
        /// Size of the matrix.
        size: usize,
    },
}
