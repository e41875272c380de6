//! The `shell3` element. Equations, limits and sources: `shell3.md`, the documentation of [`Shell3`].

use super::super::{Element, ElementError, Sample};
use super::kernel::add_energy;
use super::material::Section;
use super::plane::{DOFS, Flat, Local, MOST, Plane, Point, Row};
use super::shell;
use crate::linalg::DMatrix;

fn corner([x, y]: [f64; 2]) -> ([f64; 4], [[f64; 2]; 4]) {
    ([1.0 - x - y, x, y, 0.0], [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
}

/// Edges as vectors, edge k opposite node k, and twice the area.
fn edges(flat: &Flat<'_>) -> ([[f64; 2]; 3], f64) {
    let edge = [(1, 2), (2, 0), (0, 1)].map(|(i, j): (usize, usize)| {
        let (p, q) = (flat.at[i], flat.at[j]);
        [q[0] - p[0], q[1] - p[1]]
    });
    let [[x, y], [p, q], _] = edge;
    (edge, x * q - y * p)
}

/// α of the mean strains: how much of the edges' displacement across them follows from the rotations of their ends.
const ALPHA: f64 = 1.5;

/// Whether an edge, opposite node k, bends with the rotations of its ends.
fn bends(flat: &Flat<'_>, k: usize) -> bool {
    !flat.plane.straight[(k + 1) % 3]
}

/// The mean strains of an edge that is a cubic: ∫ n u ds over the area, with the displacement along an edge linear and that across it by Hermite's
/// functions, α of the rotations; of one that stays straight none of them.
fn membrane(flat: &Flat<'_>, _: [f64; 2], at: &Local) -> [Row; 3] {
    let (edge, twice) = edges(flat);
    let mut rows = [[0.0; MOST]; 3];
    for i in 0..3 {
        let [x, y] = at.d[i];
        (rows[0][DOFS * i], rows[1][DOFS * i + 1]) = (x, y);
        (rows[2][DOFS * i], rows[2][DOFS * i + 1]) = (y, x);
        // Both edges at the node: (i+2)%3 begins there, (i+1)%3 ends there.
        for (k, sign) in [((i + 1) % 3, 1.0), ((i + 2) % 3, -1.0)] {
            let [x, y] = edge[k];
            let third = if bends(flat, k) { sign * ALPHA / (6.0 * twice) } else { 0.0 };
            rows[0][DOFS * i + 5] += third * y * y;
            rows[1][DOFS * i + 5] += third * x * x;
            rows[2][DOFS * i + 5] -= 2.0 * third * x * y;
        }
    }
    rows
}

/// The assumed natural deviatoric strains of the rotations about the normal over that of the membrane, their factors β₁ to β₉ for the best bending in
/// the plane (`shell3.md`).
fn drilling(flat: &Flat<'_>, section: &Section, k: &mut DMatrix<f64>) -> Result<(), ElementError> {
    let (edge, twice) = edges(flat);
    let area = 0.5 * twice;
    // Edges 1-2, 2-3, 3-1.
    let natural = [edge[2], edge[0], edge[1]];
    let length2 = natural.map(|[x, y]| x * x + y * y);
    // Strains of the plane from those along the edges.
    let to_plane: [[f64; 3]; 3] = {
        let by_edge: [[f64; 3]; 3] = std::array::from_fn(|e| {
            let ([px, py], [qx, qy]) = (natural[(e + 1) % 3], natural[(e + 2) % 3]);
            let factor = -length2[e] / (twice * twice);
            [factor * py * qy, factor * px * qx, -factor * (px * qy + qx * py)]
        });
        std::array::from_fn(|i| std::array::from_fn(|e| by_edge[e][i]))
    };
    // Rows edges, columns corners, at each corner.
    const AT: [[[f64; 3]; 3]; 3] = [
        [[1.0, 2.0, 1.0], [0.0, 1.0, -1.0], [-1.0, -1.0, -2.0]],
        [[-2.0, -1.0, -1.0], [1.0, 1.0, 2.0], [-1.0, 0.0, 1.0]],
        [[1.0, -1.0, 0.0], [-1.0, -2.0, -1.0], [2.0, 1.0, 1.0]],
    ];
    let mut turned = [[0.0; MOST]; 3];
    for (i, row) in turned.iter_mut().enumerate() {
        for j in 0..3 {
            row[DOFS * j] = edge[j][0] / (2.0 * twice);
            row[DOFS * j + 1] = edge[j][1] / (2.0 * twice);
        }
        row[DOFS * i + 5] += 1.0;
    }
    let beta = 0.75 * (0.5 * (1.0 - 4.0 * section.poisson2)).max(0.01);
    for corner in 0..3 {
        let next = (corner + 1) % 3;
        let along: [Row; 3] = std::array::from_fn(|e| {
            let factor = 2.0 * area / (3.0 * length2[e]);
            std::array::from_fn(|d| {
                (0..3).map(|j| 0.5 * factor * (AT[corner][e][j] + AT[next][e][j]) * turned[j][d]).sum()
            })
        });
        let strains: [Row; 3] = to_plane.map(|t| std::array::from_fn(|d| (0..3).map(|e| t[e] * along[e][d]).sum()));
        add_energy(k, &strains, &section.membrane, beta * area);
    }
    Ok(())
}

/// The strains of edges that bend with the rotations of their ends, as [`within`] has them: exact where the membrane bends in its plane, whose
/// energy the deviatoric strains weigh otherwise.
fn strains(flat: &Flat<'_>, _: [f64; 2], at: &Local) -> [Row; 3] {
    let (edge, _) = edges(flat);
    let mut rows = [[0.0; MOST]; 3];
    for i in 0..3 {
        let [x, y] = at.d[i];
        (rows[0][DOFS * i], rows[1][DOFS * i + 1]) = (x, y);
        (rows[2][DOFS * i], rows[2][DOFS * i + 1]) = (y, x);
    }
    for (k, [x, y]) in edge.into_iter().enumerate().filter(|(k, _)| bends(flat, *k)) {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let slope = [0, 1].map(|a: usize| 0.5 * (at.n[i] * at.d[j][a] + at.n[j] * at.d[i][a]));
        for (node, sign) in [(i, 1.0), (j, -1.0)] {
            rows[0][DOFS * node + 5] -= sign * slope[0] * y;
            rows[1][DOFS * node + 5] += sign * slope[1] * x;
            rows[2][DOFS * node + 5] += sign * (slope[0] * x - slope[1] * y);
        }
    }
    rows
}

/// Edges bend with the rotations of their ends: in the middle by ⅛ (θ_i - θ_j) × d, d the edge from i to j, and between by 4 N_i N_j of that.
fn within(flat: &Flat<'_>, _: [f64; 2], at: &Local, _: Option<&DMatrix<f64>>) -> Result<[Row; 3], ElementError> {
    let (edge, _) = edges(flat);
    let mut rows = [[0.0; MOST]; 3];
    for (k, [x, y]) in edge.into_iter().enumerate().filter(|(k, _)| bends(flat, *k)) {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let factor = 0.5 * at.n[i] * at.n[j];
        for (node, f) in [(i, factor), (j, -factor)] {
            rows[0][DOFS * node + 5] -= f * y;
            rows[1][DOFS * node + 5] += f * x;
            rows[2][DOFS * node + 3] += f * y;
            rows[2][DOFS * node + 4] -= f * x;
        }
    }
    Ok(rows)
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

/// The element with edges 1-2, 2-3 and 3-1 straight where a bit of a number is set, the lowest for 1-2.
const fn plane(straight: usize) -> Plane {
    Plane {
        corner,
        membrane,
        modes: None,
        strains: Some(strains),
        within,
        drilling,
        straight: [straight & 1 != 0, straight & 2 != 0, straight & 4 != 0],
        shear,
        softening: 0.1,
        rules: [one, three, three],
    }
}

static PLANES: [Plane; 8] = [plane(0), plane(1), plane(2), plane(3), plane(4), plane(5), plane(6), plane(7)];

fn samples() -> Vec<Sample> {
    let flat = [[0.0, 0.0, 0.0], [0.2, 0.02, 0.0], [0.03, 0.15, 0.0]];
    let tilted = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.09, 0.12]];
    super::samples(&flat, 0.5 * (0.2 * 0.15 - 0.02 * 0.03), &tilted, 0.5 * 0.2 * 0.15)
}

/// The element beside neighbours whose edges are straight, and the type of each combination of such edges.
macro_rules! shells {
    ($($straight:literal $vis:vis $type:ident)*) => {
        $(shell!(
            $vis $type,
            "shell3",
            3,
            "A flat shell of three nodes: membrane with drilling, bending that does not lock.",
            "shell3.md",
            PLANES[$straight],
            fn beside(&self, straight: &[bool]) -> Option<&'static dyn Element> {
                Some(with_straight(straight))
            }
        );)*

        fn with_straight(straight: &[bool]) -> &'static dyn Element {
            let number = straight.iter().rev().fold(0, |number, &is| 2 * number + usize::from(is));
            match number {
                $($straight => &$type,)*
                _ => &Shell3,
            }
        }
    };
}

shells! {
    0 pub Shell3
    1 First
    2 Second
    3 FirstAndSecond
    4 Third
    5 FirstAndThird
    6 SecondAndThird
    7 AllThree
}
