//! Modes of a structure, and why there are none.

use retune_linalg::{DMatrix, DVector, LinalgError, ShiftedPencil};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Modes of a structure, rigid-body modes first, by ascending frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// ω² of each mode, rad²/s²; exactly zero for rigid-body modes.
    pub lambda: DVector<f64>,
    /// Mass-normalised shapes on the independent dofs, (n_dof x modes).
    pub shapes: DMatrix<f64>,
    /// How many of them are rigid-body modes; they stand first.
    pub n_rigid: usize,
    /// How many modes after them have no stiffness either: mechanisms.
    pub n_mechanism: usize,
    /// The complete basis that they are of; `None` of sparse matrices, for which none is made.
    pub basis: Option<Arc<ShiftedPencil>>,
}

impl Modes {
    /// Number of modes.
    pub fn len(&self) -> usize {
        self.lambda.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.lambda.is_empty()
    }

    /// Natural frequency of a mode, Hz.
    pub fn frequency_hz(&self, mode: usize) -> f64 {
        self.lambda[mode].max(0.0).sqrt() / TAU
    }

    /// Natural frequencies, Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        (0..self.len()).map(|i| self.frequency_hz(i)).collect()
    }

    /// Indices of the elastic modes.
    pub fn elastic(&self) -> std::ops::Range<usize> {
        self.n_rigid..self.len()
    }
}

/// Why there are no modes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModalError {
    /// The numerical kernel refuses.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// Negative stiffness: the structure does not stay where it is.
    #[error(
        "the structure is not stable: its stiffness matrix is negative in {n} independent motion(s); a compression beyond buckling or a negative stiffness makes it so"
    )]
    Unstable {
        /// Number of motions, at least.
        n: usize,
    },
    /// No dof can move.
    #[error("no dof can move: everything is supported or nothing has stiffness or mass")]
    NoDof,
    /// No mass.
    #[error("the structure has no mass on any dof that moves")]
    NoMass,
    /// A mesh so fine that the rounding of K drowns the lowest modes.
    #[error(
        "the mesh is too fine: rounding of the stiffness matrix ({n} dofs) makes the first elastic frequency uncertain by up to {:.1e} of itself; subdivide less",
        uncertainty
    )]
    TooFine {
        /// Number of dofs.
        n: usize,
        /// Estimated relative error of the frequency.
        uncertainty: f64,
    },
}
