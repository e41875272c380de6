//! K, M and C at one θ.

use crate::linalg::DMatrix;
use crate::linalg::sparse::SparseSym;

/// The matrices of a model at one θ, on the independent dofs.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// Stiffness K (n x n), symmetric.
    pub stiffness: DMatrix<f64>,
    /// Mass M (n x n), symmetric.
    pub mass: DMatrix<f64>,
    /// Viscous damping C (n x n), symmetric, when any element has a dashpot.
    pub damping: Option<DMatrix<f64>>,
}

impl System {
    /// Zero matrices.
    pub fn zeros(n: usize, damped: bool) -> Self {
        Self {
            stiffness: DMatrix::zeros(n, n),
            mass: DMatrix::zeros(n, n),
            damping: damped.then(|| DMatrix::zeros(n, n)),
        }
    }

    /// Sets all entries to zero.
    pub fn clear(&mut self) {
        self.stiffness.fill(0.0);
        self.mass.fill(0.0);
        if let Some(c) = &mut self.damping {
            c.fill(0.0);
        }
    }
}

/// The matrices of a large model at one θ, on the independent dofs.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseSystem {
    /// Stiffness K (n x n).
    pub stiffness: SparseSym,
    /// Mass M (n x n).
    pub mass: SparseSym,
    /// Viscous damping C (n x n), when any element has a dashpot.
    pub damping: Option<SparseSym>,
}

impl From<&System> for SparseSystem {
    fn from(system: &System) -> Self {
        Self {
            stiffness: SparseSym::from_dense(&system.stiffness),
            mass: SparseSym::from_dense(&system.mass),
            damping: system.damping.as_ref().map(SparseSym::from_dense),
        }
    }
}
