//! A node that a TIE leads.

use super::scopes::At;

/// A node that follows a face.
#[derive(Debug, Clone)]
pub(super) struct Tied {
    pub slave: At,
    /// Nodes of the face with their shares.
    pub masters: Vec<(At, f64)>,
    /// Whether the rotations of the masters carry the node, and whether they turn it.
    pub arm: Option<[f64; 3]>,
    pub turns: bool,
    /// The solid of first order on whose face it lies: there a tie of retune is this one, and what a node follows need not be written out.
    pub on: Option<At>,
    pub name: String,
}
