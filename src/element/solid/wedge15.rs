//! The `wedge15` element: fifteen nodes, quadratic. Equations, limits and sources: `wedge15.md`, the documentation of [`Wedge15`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, rules, solid};

/// Corners as of `wedge6`, then the middles of the lower edges 1-2, 2-3, 3-1, of the upper ones 4-5, 5-6, 6-4, and of 1-4, 2-5, 3-6.
const NODES: [[f64; 3]; 15] = [
    [0.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.5, 0.0, -1.0],
    [0.5, 0.5, -1.0],
    [0.0, 0.5, -1.0],
    [0.5, 0.0, 1.0],
    [0.5, 0.5, 1.0],
    [0.0, 0.5, 1.0],
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
];

/// With s = 1 ∓ ζ: corners L (2 L - 1) s/2 - L (1 - ζ²)/2, middles of a triangle's edges 2 L_i L_j s, of the edges between L (1 - ζ²).
fn shape([x, y, z]: [Dual; 3]) -> Vec<Dual> {
    let l = [1.0 - x - y, x, y];
    let bubble = 1.0 - z * z;
    let corners = |s: Dual| l.map(|l| l * ((l * 2.0 - 1.0) * s - bubble) * 0.5);
    let edges = |s: Dual| [[0, 1], [1, 2], [2, 0]].map(|[i, j]: [usize; 2]| l[i] * l[j] * s * 2.0);
    let (lower, upper) = (1.0 - z, z + 1.0);
    [corners(lower), corners(upper), edges(lower), edges(upper), l.map(|l| l * bubble)].concat()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::wedge(7, 3), rules::wedge(7, 3), Enrichment::None));

solid!(Wedge15, "wedge15", 15, "A quadratic wedge of fifteen nodes.", "wedge15.md", 1.0);

#[cfg(test)]
#[test]
fn functions_belong_to_their_nodes() {
    super::tests::functions_belong_to_nodes(shape, &NODES);
    super::tests::functions_belong_to_nodes(super::wedge6::shape, &super::wedge6::NODES);
}
