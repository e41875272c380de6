//! The `shell3` element. Equations, limits and sources: `shell3.md`, the documentation of [`Shell3`].

use super::super::Sample;
use super::plane::{Flat, Plane, Point, Row};
use super::shell;

fn corner([x, y]: [f64; 2]) -> ([f64; 4], [[f64; 2]; 4]) {
    ([1.0 - x - y, x, y, 0.0], [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
}

/// Derivatives of 4 L_i L_j, edges 1-2, 2-3, 3-1.
fn edge([x, y]: [f64; 2]) -> [[f64; 2]; 4] {
    let ([a, b, c, _], [da, db, dc, _]) = corner([x, y]);
    let product = |a: f64, da: [f64; 2], b: f64, db: [f64; 2]| [0, 1].map(|i: usize| 4.0 * (da[i] * b + a * db[i]));
    [product(a, da, b, db), product(b, db, c, dc), product(c, dc, a, da), [0.0; 2]]
}

/// MITC3: γξ = γξ(½, 0) + c η, γη = γη(0, ½) - c ξ, with c so that the shear along the third edge is the one in its middle.
fn shear(flat: &Flat<'_>, [x, y]: [f64; 2]) -> [Row; 2] {
    let first = flat.covariant_shear([0.5, 0.0], 0);
    let second = flat.covariant_shear([0.0, 0.5], 1);
    let middle = [0.5, 0.5];
    let (third_xi, third_eta) = (flat.covariant_shear(middle, 0), flat.covariant_shear(middle, 1));
    let c: Row = std::array::from_fn(|k| second[k] - first[k] - (third_eta[k] - third_xi[k]));
    [std::array::from_fn(|k| first[k] + c[k] * y), std::array::from_fn(|k| second[k] - c[k] * x)]
}

fn one() -> Vec<Point> {
    vec![([1.0 / 3.0; 2], 0.5)]
}

fn three() -> Vec<Point> {
    [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]].map(|p| (p, 1.0 / 6.0)).to_vec()
}

static PLANE: Plane = Plane { corner, edge, shear, softening: 0.1, rules: [three, one, three, three] };

fn samples() -> Vec<Sample> {
    let flat = [[0.0, 0.0, 0.0], [0.2, 0.02, 0.0], [0.03, 0.15, 0.0]];
    let tilted = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.09, 0.12]];
    super::samples(&flat, 0.5 * (0.2 * 0.15 - 0.02 * 0.03), &tilted, 0.5 * 0.2 * 0.15)
}

shell!(
    Shell3,
    "shell3",
    3,
    "A flat shell of three nodes: membrane with drilling, bending that does not lock.",
    "shell3.md"
);
