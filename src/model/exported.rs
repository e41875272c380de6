//! What the files of a superelement hold: its nodes, dofs and matrices, in SI and in its own axes.

use crate::element::Dof;
use crate::matrices::Symmetric;
use std::sync::Arc;

/// A superelement as its files have it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::model) struct Exported {
    pub(in crate::model) nodes: Vec<ExportedNode>,
    /// The dofs of the rows of its matrices.
    pub(in crate::model) dofs: Vec<ExportedDof>,
    /// What is always there.
    pub(in crate::model) base: ExportedMatrices,
    /// Stiffness of a preload.
    pub(in crate::model) preload: Option<Arc<Symmetric>>,
    /// In the order of the file.
    pub(in crate::model) terms: Vec<ExportedTerm>,
    /// Dofs that follow, each with its terms: (dof of the superelement, factor).
    pub(in crate::model) recovered: Vec<(ExportedDof, Vec<(usize, f64)>)>,
}

/// K, M and C; none where all is zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::model) struct ExportedMatrices {
    pub(in crate::model) k: Option<Arc<Symmetric>>,
    pub(in crate::model) m: Option<Arc<Symmetric>>,
    pub(in crate::model) c: Option<Arc<Symmetric>>,
}

/// A node, or a coordinate that is not a motion of a point.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::model) struct ExportedNode {
    pub(in crate::model) name: String,
    /// In the axes of the superelement, m; `None` of a coordinate.
    pub(in crate::model) position: Option<[f64; 3]>,
}

/// A displacement or a rotation of a node along an axis of the superelement, or a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct ExportedDof {
    pub(in crate::model) node: usize,
    /// `None` of a coordinate.
    pub(in crate::model) dof: Option<Dof>,
    /// Its direction.
    pub(in crate::model) axis: [f64; 3],
}

/// What goes with a parameter: the sum of parts times (θ/reference)^power, less one where the base includes them.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::model) struct ExportedTerm {
    pub(in crate::model) name: String,
    pub(in crate::model) parameter: String,
    pub(in crate::model) reference: f64,
    pub(in crate::model) is_included: bool,
    /// Powers, each with its matrices.
    pub(in crate::model) parts: Vec<(u32, ExportedMatrices)>,
}

/// The superelement of an entry once its files were read; no part of what the entry says, so that all are equal.
#[derive(Debug, Clone, Default)]
pub(in crate::model) struct Loaded(pub(in crate::model) Option<Arc<Exported>>);

impl PartialEq for Loaded {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
