//! The `tet4` element: four nodes, constant strain. Equations, limits and sources: `tet4.md`, the documentation of [`Tet4`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, rules, solid};

/// The fourth node lies on the side from which the first three are seen counterclockwise.
pub(super) const NODES: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// N = 1 - ξ - η - ζ, ξ, η, ζ.
pub(super) fn shape([x, y, z]: [Dual; 3]) -> Vec<Dual> {
    vec![1.0 - x - y - z, x, y, z]
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::tetrahedron(1), rules::tetrahedron(4), Enrichment::None));

solid!(Tet4, "tet4", 4, "A tetrahedron of four nodes with constant strain: stiff in bending.", "tet4.md", 1.0 / 6.0);
