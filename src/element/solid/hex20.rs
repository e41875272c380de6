//! The `hex20` element: twenty nodes, quadratic. Equations, limits and sources: `hex20.md`, the documentation of [`Hex20`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, hex8, rules, solid};

/// Corners as of `hex8`, then the middles of the lower edges, of the upper edges and of those between.
pub(super) const NODES: [[f64; 3]; 20] = {
    let mut nodes = [[0.0; 3]; 20];
    let mut i = 0;
    while i < 20 {
        nodes[i] = if i < 8 {
            hex8::NODES[i]
        } else {
            let [a, b] = EDGES[i - 8];
            let (p, q) = (hex8::NODES[a], hex8::NODES[b]);
            [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])]
        };
        i += 1;
    }
    nodes
};

const EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Corners: (1+ξξ_i)(1+ηη_i)(1+ζζ_i)(ξξ_i+ηη_i+ζζ_i-2)/8; middles, for ξ_i = 0: (1-ξ²)(1+ηη_i)(1+ζζ_i)/4.
pub(super) fn shape(xi: [Dual; 3]) -> Vec<Dual> {
    let of = |p: &[f64; 3]| {
        let mut n = Dual::from(1.0);
        let mut sum = Dual::from(-2.0);
        for i in 0..3 {
            if p[i] == 0.0 {
                n = n * (1.0 - xi[i] * xi[i]);
            } else {
                n = n * (xi[i] * p[i] + 1.0);
                sum = sum + xi[i] * p[i];
            }
        }
        if p.contains(&0.0) { n * 0.25 } else { n * sum * 0.125 }
    };
    NODES.iter().map(of).collect()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::cube(3), rules::cube(3), Enrichment::None));

solid!(Hex20, "hex20", 20, "A quadratic brick of twenty nodes.", "hex20.md", 8.0);

#[cfg(test)]
#[test]
fn functions_belong_to_their_nodes() {
    super::tests::functions_belong_to_nodes(shape, &NODES);
    super::tests::functions_belong_to_nodes(hex8::shape, &hex8::NODES);
}
