//! The `pyramid13` element: thirteen nodes, quadratic. Equations, limits and sources: `pyramid13.md`, the documentation of
//! [`Pyramid13`].

use super::dual::Dual;
use super::pyramid5::below_apex;
use super::{Enrichment, Family, Lazy, rules, solid};

/// Corners as of `pyramid5`, then the middles of the base 1-2, 2-3, 3-4, 4-1 and of the edges to the apex.
const NODES: [[f64; 3]; 13] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [-0.5, -0.5, 0.5],
    [0.5, -0.5, 0.5],
    [0.5, 0.5, 0.5],
    [-0.5, 0.5, 0.5],
];

/// With s = 1 - ζ and a = ξ ξ_i, b = η η_i of a corner:
///
/// ```text
/// corners      (a + b - 1)/4 [(1 + a)(1 + b) - ζ + a b ζ/s]
/// apex         ζ (2 ζ - 1)
/// base edges   (s + ξ)(s - ξ)(s + b)/(2 s), and with ξ and η exchanged
/// to the apex  ζ (s + a)(s + b)/s
/// ```
///
/// # Source
/// G. Bedrosian, Shape functions and integration formulas for three-dimensional finite element analysis, Int. J. Numer. Meth.
/// Engng 35 (1992) 95-108.
fn shape([x, y, z]: [Dual; 3]) -> Vec<Dual> {
    let s = below_apex(z);
    let corner = |p: &[f64; 3]| {
        let (a, b) = (x * p[0], y * p[1]);
        (a + b - 1.0) * 0.25 * ((a + 1.0) * (b + 1.0) - z + a * b * z / s)
    };
    let edge = |along: Dual, across: Dual, side: f64| (s + along) * (s - along) * (s + across * side) * 0.5 / s;
    let to_apex = |p: &[f64; 3]| z * (s + x * p[0]) * (s + y * p[1]) / s;
    let base = &NODES[..4];
    let mut n: Vec<Dual> = base.iter().map(corner).collect();
    n.push(z * (z * 2.0 - 1.0));
    n.extend([edge(x, y, -1.0), edge(y, x, 1.0), edge(x, y, 1.0), edge(y, x, -1.0)]);
    n.extend(base.iter().map(to_apex));
    n
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::pyramid(3), rules::pyramid(3), Enrichment::None));

solid!(Pyramid13, "pyramid13", 13, "A quadratic pyramid of thirteen nodes.", "pyramid13.md", 4.0 / 3.0);

#[cfg(test)]
#[test]
fn functions_belong_to_their_nodes() {
    super::tests::functions_belong_to_nodes(shape, &NODES);
    super::tests::functions_belong_to_nodes(super::pyramid5::shape, &super::pyramid5::NODES);
}
