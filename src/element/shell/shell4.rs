//! The `shell4` element. Equations, limits and sources: `shell4.md`, the documentation of [`Shell4`].

use super::super::ElementError;
use super::super::Sample;
use super::kernel::add_energy;
use super::material::Section;
use super::plane::{DOFS, Flat, Local, MOST, Modes, Plane, Point, Row, blend};
use super::shell;
use crate::linalg::DMatrix;

/// Signs of the natural coordinates of the corners.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

fn corner([x, y]: [f64; 2]) -> ([f64; 4], [[f64; 2]; 4]) {
    let n = CORNERS.map(|[a, b]| 0.25 * (1.0 + a * x) * (1.0 + b * y));
    let d = CORNERS.map(|[a, b]| [0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)]);
    (n, d)
}

/// Vectors of the bilinear surface, x = x₀ + ξ r + η s + ξη d, and the dofs of its displacement, which has the same form.
struct Surface {
    r: [f64; 3],
    s: [f64; 3],
    /// d = a r + b s in the mean plane, with the warp across it.
    d: [f64; 3],
    a: f64,
    b: f64,
}

impl Surface {
    fn new(flat: &Flat<'_>) -> Self {
        let sum = |sign: &dyn Fn([f64; 2]) -> f64| -> [f64; 3] {
            let mut out = [0.0; 3];
            for (i, corner) in CORNERS.into_iter().enumerate() {
                let f = 0.25 * sign(corner);
                out[0] += f * flat.at[i][0];
                out[1] += f * flat.at[i][1];
                out[2] += f * flat.height[i];
            }
            out
        };
        let (r, s, d) = (sum(&|c| c[0]), sum(&|c| c[1]), sum(&|c| c[0] * c[1]));
        let det = r[0] * s[1] - r[1] * s[0];
        Self { r, s, d, a: (d[0] * s[1] - d[1] * s[0]) / det, b: (r[0] * d[1] - r[1] * d[0]) / det }
    }

    /// v · ∂u, ∂u the part of the displacement whose sign at the corners is given.
    fn strain(v: [f64; 3], sign: impl Fn([f64; 2]) -> f64, row: &mut Row, factor: f64) {
        for (i, corner) in CORNERS.into_iter().enumerate() {
            let f = 0.25 * factor * sign(corner);
            for (c, v) in v.into_iter().enumerate() {
                row[DOFS * i + c] += f * v;
            }
        }
    }

    /// Covariant strains ξξ, ηη, and twice ξη: those along the edges as they are, and linear between them but for what a distorted element that is flat
    /// has. `shell4.md` has the equations.
    fn covariant(&self, [x, y]: [f64; 2]) -> [Row; 3] {
        let Self { r, s, d, a, b } = *self;
        let (xi, eta, both) = (|c: [f64; 2]| c[0], |c: [f64; 2]| c[1], |c: [f64; 2]| c[0] * c[1]);
        let mut rows = [[0.0; MOST]; 3];
        let terms = [
            ([1.0, 0.0, 0.0, y, 0.0, 1.0], y * y - 1.0),
            ([0.0, 1.0, 0.0, 0.0, x, 1.0], x * x - 1.0),
            ([0.0, 0.0, 1.0, x, y, 0.0], 2.0 * x * y),
        ];
        for (row, (linear, share)) in rows.iter_mut().zip(terms) {
            // What a flat element would have for d·u_d, in strains that are there.
            let flat = [-a * a, -b * b, -a * b, a, b, 0.0];
            let [rr, ss, rs, rd, sd, dd] = std::array::from_fn(|i| linear[i] + share * flat[i]);
            Self::strain(r, xi, row, rr);
            Self::strain(s, eta, row, ss);
            Self::strain(r, eta, row, rs);
            Self::strain(s, xi, row, rs);
            Self::strain(r, both, row, rd);
            Self::strain(d, xi, row, rd);
            Self::strain(s, both, row, sd);
            Self::strain(d, eta, row, sd);
            Self::strain(d, both, row, dd);
        }
        rows
    }
}

/// Strains xx, yy, xy of the plane from covariant ones.
fn to_plane([x, y]: [[f64; 2]; 2]) -> [[f64; 3]; 3] {
    [
        [x[0] * x[0], x[1] * x[1], x[0] * x[1]],
        [y[0] * y[0], y[1] * y[1], y[0] * y[1]],
        [2.0 * x[0] * y[0], 2.0 * x[1] * y[1], x[0] * y[1] + x[1] * y[0]],
    ]
}

fn membrane(flat: &Flat<'_>, xi: [f64; 2], at: &Local) -> [Row; 3] {
    let covariant = Surface::new(flat).covariant(xi);
    to_plane(at.inverse).map(|t| std::array::from_fn(|k| (0..3).map(|j| t[j] * covariant[j][k]).sum()))
}

/// ξ and η of the strains along them, ξ and η of the shear, in the axes of the middle; their mean over the element is none.
fn modes(flat: &Flat<'_>, [x, y]: [f64; 2], at: &Local) -> Result<Modes, ElementError> {
    let middle = flat.local([0.0; 2])?;
    let scale = middle.det / at.det;
    Ok(to_plane(middle.inverse).map(|t| [t[0] * x, t[1] * y, t[2] * x, t[2] * y].map(|v| scale * v)))
}

/// What bends with the rotations and with the strains that the membrane adds: a field of constant second derivative a is ½ a ξ², and less what is
/// linear between the corners, -½ a (1 - ξ²).
///
/// ```text
/// w = -½ (1 - ξ²) ∂²w/∂ξ² - ½ (1 - η²) ∂²w/∂η²        ∂w/∂ξ = ∂y/∂ξ θx - ∂x/∂ξ θy
/// u·g_ξ = -½ (1 - ξ²) α₁ - ½ (1 - η²) α₄              u·g_η = -½ (1 - η²) α₂ - ½ (1 - ξ²) α₃
/// ```
fn within(
    flat: &Flat<'_>,
    [x, y]: [f64; 2],
    _: &Local,
    added: Option<&DMatrix<f64>>,
) -> Result<[Row; 3], ElementError> {
    let (_, d) = corner([x, y]);
    let tangents = flat.tangents([x, y]);
    let bulge = [x, y].map(|s| -0.5 * (1.0 - s * s));
    let mut rows = [[0.0; MOST]; 3];
    for (i, d) in d.iter().enumerate() {
        for k in 0..2 {
            rows[2][DOFS * i + 3] += bulge[k] * d[k] * tangents[k][1];
            rows[2][DOFS * i + 4] -= bulge[k] * d[k] * tangents[k][0];
        }
    }
    if let Some(added) = added {
        let to_plane = flat.local([0.0; 2])?.inverse;
        for j in 0..MOST {
            let along = [
                bulge[0] * added[(0, j)] + bulge[1] * added[(3, j)],
                bulge[1] * added[(1, j)] + bulge[0] * added[(2, j)],
            ];
            for k in 0..2 {
                rows[k][j] = to_plane[k][0] * along[0] + to_plane[k][1] * along[1];
            }
        }
    }
    Ok(rows)
}

/// Share of the twisting stiffness of the plate that ties the rotations about the normal, over their mean, to those of the membrane.
const TIE: f64 = 0.24;

/// The mean of the rotations about the normal is tied to that of the membrane by its shear stiffness (Hughes and Brezzi in one point), the rest by a
/// share of the plate's, so that a curved surface that bends without stretching is not held by them.
fn drilling(flat: &Flat<'_>, section: &Section, k: &mut DMatrix<f64>) -> Result<(), ElementError> {
    let middle = flat.local([0.0; 2])?;
    let mean = flat.drill(&middle);
    add_energy(k, &[mean], &[[section.drilling]], 4.0 * middle.det);
    let tie = TIE * section.twisting / flat.longest_edge().powi(2);
    for (xi, weight) in two() {
        let at = flat.local(xi)?;
        let row = flat.drill(&at);
        add_energy(k, &[std::array::from_fn(|i| row[i] - mean[i])], &[[tie]], weight * at.det);
    }
    Ok(())
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

static PLANE: Plane = Plane {
    corner,
    membrane,
    modes: Some(modes),
    strains: None,
    within,
    drilling,
    straight: [false; 3],
    shear,
    softening: 0.0,
    rules: [two; 3],
};

fn samples() -> Vec<Sample> {
    let flat = [[0.0, 0.0, 0.0], [0.2, 0.02, 0.0], [0.23, 0.17, 0.0], [0.03, 0.15, 0.0]];
    // The diagonals cross at a right angle to z: the corners stand 4 mm above and below the mean plane in turn.
    let warped = [[0.0, 0.0, 0.0], [0.2, 0.0, -8e-3], [0.2, 0.15, 0.0], [0.0, 0.15, -8e-3]];
    super::samples(&flat, 0.2 * 0.15 - 0.02 * 0.03, &warped, 0.2 * 0.15)
}

shell!(
    pub Shell4,
    "shell4",
    4,
    "A shell of four nodes, flat or warped: membrane with drilling, and bending, that do not lock.",
    "shell4.md",
    PLANE
);
