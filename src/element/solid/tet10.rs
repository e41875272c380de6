//! The `tet10` element: ten nodes, quadratic. Equations, limits and sources: `tet10.md`, the documentation of [`Tet10`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, rules, solid, tet4};

const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Corners as of `tet4`, then the middles of the edges 1-2, 2-3, 3-1, 1-4, 2-4, 3-4.
const NODES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

/// With L the functions of `tet4`: corners L (2 L - 1), middles 4 L_i L_j.
fn shape(xi: [Dual; 3]) -> Vec<Dual> {
    let l = tet4::shape(xi);
    let corners = l.iter().map(|&l| l * (l * 2.0 - 1.0));
    corners.chain(EDGES.iter().map(|&[i, j]| l[i] * l[j] * 4.0)).collect()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::tetrahedron(4), rules::tetrahedron(15), Enrichment::None));

solid!(
    Tet10,
    "tet10",
    10,
    "A quadratic tetrahedron of ten nodes: what automatic meshes are made of.",
    "tet10.md",
    1.0 / 6.0
);

#[cfg(test)]
#[test]
fn functions_belong_to_their_nodes() {
    super::tests::functions_belong_to_nodes(shape, &NODES);
    super::tests::functions_belong_to_nodes(tet4::shape, &tet4::NODES);
}
