//! The `shell4` element. Equations, limits and sources: `shell4.md`, the documentation of [`Shell4`].

use super::super::Sample;
use super::plane::{Flat, Plane, Point, Row, blend};
use super::shell;

/// Signs of the natural coordinates of the corners.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

fn corner([x, y]: [f64; 2]) -> ([f64; 4], [[f64; 2]; 4]) {
    let n = CORNERS.map(|[a, b]| 0.25 * (1.0 + a * x) * (1.0 + b * y));
    let d = CORNERS.map(|[a, b]| [0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)]);
    (n, d)
}

/// Derivatives of (1 - ξ²)(1 ∓ η)/2 and (1 - η²)(1 ± ξ)/2, edges 1-2, 2-3, 3-4, 4-1.
fn edge([x, y]: [f64; 2]) -> [[f64; 2]; 4] {
    let along_x = |side: f64| [-x * (1.0 + side * y), 0.5 * side * (1.0 - x * x)];
    let along_y = |side: f64| [0.5 * side * (1.0 - y * y), -y * (1.0 + side * x)];
    [along_x(-1.0), along_y(1.0), along_x(1.0), along_y(-1.0)]
}

/// γξ linear in η between the middles of the edges along ξ, γη linear in ξ between those along η: MITC4.
fn shear(flat: &Flat<'_>, [x, y]: [f64; 2]) -> [Row; 2] {
    let along = |first: [f64; 2], second: [f64; 2], direction: usize, s: f64| {
        let ends = [flat.covariant_shear(first, direction), flat.covariant_shear(second, direction)];
        blend(&ends, [0.5 * (1.0 - s), 0.5 * (1.0 + s)])
    };
    [along([0.0, -1.0], [0.0, 1.0], 0, y), along([-1.0, 0.0], [1.0, 0.0], 1, x)]
}

fn gauss(line: &[(f64, f64)]) -> Vec<Point> {
    line.iter().flat_map(|&(x, a)| line.iter().map(move |&(y, b)| ([x, y], a * b))).collect()
}

fn two() -> Vec<Point> {
    let x = 1.0 / 3.0_f64.sqrt();
    gauss(&[(-x, 1.0), (x, 1.0)])
}

fn three() -> Vec<Point> {
    let x = 0.6_f64.sqrt();
    gauss(&[(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)])
}

static PLANE: Plane = Plane { corner, edge, shear, softening: 0.0, rules: [three, two, two, two] };

fn samples() -> Vec<Sample> {
    let flat = [[0.0, 0.0, 0.0], [0.2, 0.02, 0.0], [0.23, 0.17, 0.0], [0.03, 0.15, 0.0]];
    // The diagonals cross at a right angle to z: the corners stand 4 mm above and below the mean plane in turn.
    let warped = [[0.0, 0.0, 0.0], [0.2, 0.0, -8e-3], [0.2, 0.15, 0.0], [0.0, 0.15, -8e-3]];
    super::samples(&flat, 0.2 * 0.15 - 0.02 * 0.03, &warped, 0.2 * 0.15)
}

shell!(
    Shell4,
    "shell4",
    4,
    "A flat shell of four nodes: membrane with drilling, bending that does not lock; warped nodes are carried to its plane.",
    "shell4.md"
);
