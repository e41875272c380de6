//! Strains of a plane element from the dofs of its nodes in the plane's axes.
//!
//! Dofs of a node: u, v, w, θx, θy, θz. Signs: γxz = ∂w/∂x + θy, γyz = ∂w/∂y - θx, κxx = ∂θy/∂x, κyy = -∂θx/∂y, κxy = ∂θy/∂y - ∂θx/∂x.

use super::super::ElementError;
use super::material::Section;
use crate::linalg::DMatrix;

/// Dofs of a node.
pub(super) const DOFS: usize = 6;
/// Dofs of the larger element.
pub(super) const MOST: usize = 4 * DOFS;

/// A strain as a combination of the dofs of the nodes.
pub(super) type Row = [f64; MOST];

/// A point of a rule: natural coordinates and weight.
pub(super) type Point = ([f64; 2], f64);

/// Functions of the corners and their natural derivatives, at a point.
pub(super) type Functions = ([f64; 4], [[f64; 2]; 4]);

/// Coefficients of the enhanced strains of an element, strains xx yy xy by mode.
pub(super) type Modes = [[f64; 4]; 3];

/// The enhanced strains at a point.
pub(super) type ModesAt = fn(&Flat<'_>, [f64; 2], &Local) -> Result<Modes, ElementError>;

/// εxx, εyy, γxy of a membrane at a point.
pub(super) type Membrane = fn(&Flat<'_>, [f64; 2], &Local) -> [Row; 3];

/// Displacements u, v, w within an element beside those that the functions of its corners give, at a point.
///
/// Its last argument: amplitudes of the enhanced strains by the dofs.
pub(super) type Within = fn(&Flat<'_>, [f64; 2], &Local, Option<&DMatrix<f64>>) -> Result<[Row; 3], ElementError>;

/// What makes a plane element: its functions and the points at which it is integrated.
pub(super) struct Plane {
    /// Functions of the corners and their natural derivatives.
    pub(super) corner: fn([f64; 2]) -> Functions,
    /// εxx, εyy, γxy of the membrane.
    pub(super) membrane: Membrane,
    /// Strains that the membrane may add of itself, for the least energy.
    pub(super) modes: Option<ModesAt>,
    /// The strains of the membrane where those of the stiffness are means that hold for its energy alone.
    pub(super) strains: Option<Membrane>,
    /// The displacements that go with its strains.
    pub(super) within: Within,
    /// What resists the rotations about the normal beside the strains of the membrane.
    pub(super) drilling: fn(&Flat<'_>, &Section, &mut DMatrix<f64>) -> Result<(), ElementError>,
    /// Edges 1-2, 2-3, 3-1 of a triangle that stay straight although the others bend with the rotations of their ends.
    pub(super) straight: [bool; 3],
    /// Covariant transverse shears along ξ and η, assumed from tying points.
    pub(super) shear: fn(&Flat<'_>, [f64; 2]) -> [Row; 2],
    /// α of the transverse shear stiffness times t²/(t² + α h²), h the longest edge.
    pub(super) softening: f64,
    /// Points for membrane and bending, transverse shear, mass.
    pub(super) rules: [fn() -> Vec<Point>; 3],
}

/// An element in its mean plane.
pub(super) struct Flat<'a> {
    pub(super) plane: &'a Plane,
    /// Corners in the plane, m.
    pub(super) at: &'a [[f64; 2]],
    /// Height of the corners over it, m.
    pub(super) height: &'a [f64],
}

/// Gradients at a point.
pub(super) struct Local {
    /// N of the corners.
    pub(super) n: [f64; 4],
    /// ∂N/∂x, ∂N/∂y of the corners.
    pub(super) d: [[f64; 2]; 4],
    /// J⁻¹, rows x and y.
    pub(super) inverse: [[f64; 2]; 2],
    /// Element of area over the weight.
    pub(super) det: f64,
}

impl Flat<'_> {
    pub(super) fn n_nodes(&self) -> usize {
        self.at.len()
    }

    /// ∂x/∂ξ, ∂y/∂ξ; ∂x/∂η, ∂y/∂η.
    pub(super) fn tangents(&self, xi: [f64; 2]) -> [[f64; 2]; 2] {
        let (_, d) = (self.plane.corner)(xi);
        let mut j = [[0.0; 2]; 2];
        for (d, p) in d.iter().zip(self.at) {
            for a in 0..2 {
                for b in 0..2 {
                    j[a][b] += d[a] * p[b];
                }
            }
        }
        j
    }

    /// Errors: the element is flat or folded over there.
    pub(super) fn local(&self, xi: [f64; 2]) -> Result<Local, ElementError> {
        let j = self.tangents(xi);
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        let size = j[0][0].hypot(j[0][1]) * j[1][0].hypot(j[1][1]);
        if !(det > 1e-9 * size && det.is_finite()) {
            return Err(ElementError::Inverted);
        }
        let inverse = [[j[1][1] / det, -j[0][1] / det], [-j[1][0] / det, j[0][0] / det]];
        let (n, d) = (self.plane.corner)(xi);
        let d = d.map(|d| [0, 1].map(|i: usize| inverse[i][0] * d[0] + inverse[i][1] * d[1]));
        Ok(Local { n, d, inverse, det })
    }

    /// The rotation about the normal of the surface over that of its displacements, z its height over the mean plane:
    ///
    /// ```text
    /// Σ N_i (θz - ∂z/∂x θx - ∂z/∂y θy)_i - ½ (∂v/∂x - ∂u/∂y - ∂z/∂x ∂w/∂y + ∂z/∂y ∂w/∂x)
    /// ```
    pub(super) fn drill(&self, at: &Local) -> Row {
        let slope = [0, 1].map(|k: usize| self.height.iter().zip(&at.d).map(|(z, d)| z * d[k]).sum::<f64>());
        let mut row = [0.0; MOST];
        for i in 0..self.n_nodes() {
            let [x, y] = at.d[i];
            row[DOFS * i] = 0.5 * y;
            row[DOFS * i + 1] = -0.5 * x;
            row[DOFS * i + 2] = 0.5 * (slope[0] * y - slope[1] * x);
            row[DOFS * i + 3] = -slope[0] * at.n[i];
            row[DOFS * i + 4] = -slope[1] * at.n[i];
            row[DOFS * i + 5] = at.n[i];
        }
        row
    }

    /// κxx, κyy, κxy.
    pub(super) fn bending(&self, at: &Local) -> [Row; 3] {
        let mut rows = [[0.0; MOST]; 3];
        for i in 0..self.n_nodes() {
            let [x, y] = at.d[i];
            rows[0][DOFS * i + 4] = x;
            rows[1][DOFS * i + 3] = -y;
            rows[2][DOFS * i + 4] = y;
            rows[2][DOFS * i + 3] = -x;
        }
        rows
    }

    /// Length of the longest edge, m.
    pub(super) fn longest_edge(&self) -> f64 {
        let n = self.n_nodes();
        let edge = |i: usize| {
            let (a, b) = (self.at[i], self.at[(i + 1) % n]);
            (b[0] - a[0]).hypot(b[1] - a[1])
        };
        (0..n).map(edge).fold(0.0, f64::max)
    }

    /// The covariant transverse shear along a natural direction, as the functions of the corners say it:
    /// ∂w/∂ξ + ∂x/∂ξ θy - ∂y/∂ξ θx.
    pub(super) fn covariant_shear(&self, xi: [f64; 2], along: usize) -> Row {
        let (n, d) = (self.plane.corner)(xi);
        let [x, y] = self.tangents(xi)[along];
        let mut row = [0.0; MOST];
        for i in 0..self.n_nodes() {
            row[DOFS * i + 2] = d[i][along];
            row[DOFS * i + 3] = -y * n[i];
            row[DOFS * i + 4] = x * n[i];
        }
        row
    }

    /// γxz, γyz from the assumed covariant shears.
    pub(super) fn shear(&self, xi: [f64; 2], at: &Local) -> [Row; 2] {
        let natural = (self.plane.shear)(self, xi);
        [0, 1].map(|i: usize| blend(&natural, at.inverse[i]))
    }
}

/// a₀ row₀ + a₁ row₁.
pub(super) fn blend(rows: &[Row; 2], a: [f64; 2]) -> Row {
    std::array::from_fn(|k| a[0] * rows[0][k] + a[1] * rows[1][k])
}
