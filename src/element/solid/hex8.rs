//! The `hex8` element: eight nodes, with incompatible modes. Equations, limits and sources: `hex8.md`, the documentation of [`Hex8`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, rules, solid};

/// Corners of a hexahedron: round the lower face, then round the upper one.
pub(super) const NODES: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// N = (1 + ξ ξ_i)(1 + η η_i)(1 + ζ ζ_i)/8.
pub(super) fn shape(xi: [Dual; 3]) -> Vec<Dual> {
    let of = |p: &[f64; 3]| (0..3).fold(Dual::from(0.125), |n, i| n * (xi[i] * p[i] + 1.0));
    NODES.iter().map(of).collect()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::cube(2), rules::cube(2), Enrichment::IncompatibleModes));

solid!(Hex8, "hex8", 8, "A brick of eight nodes with incompatible modes: bends without locking.", "hex8.md", 8.0);
