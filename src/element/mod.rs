//! Elements: a declaration and textbook matrices each, one file each.
//!
//! An element knows nothing of nodes' names, parameters, files or global axes. It says which dofs it touches and which
//! properties it has, and returns symmetric matrices in its own axes; rotation and scatter exist once, in `model`.
//!
//! To add one: a file here with a unit struct and `impl Element`, `mod` and a line in [`ELEMENTS`]. The conformance suite
//! (`tests/conformance`) checks symmetry, definiteness, the rigid-body null space, frame invariance and scaling
//! for every member of the list, so a new file needs only a closed-form test of its own.

use crate::linalg::SymMatrix;
use std::fmt;

/// One degree of freedom of a node: a displacement or a rotation (right-handed) along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Dof {
    Ux,
    Uy,
    Uz,
    Rx,
    Ry,
    Rz,
}

impl Dof {
    /// All six, in the order of every element matrix.
    pub const ALL: [Dof; 6] = [Dof::Ux, Dof::Uy, Dof::Uz, Dof::Rx, Dof::Ry, Dof::Rz];

    /// The name in YAML: `ux` ... `rz`.
    pub fn name(self) -> &'static str {
        ["ux", "uy", "uz", "rx", "ry", "rz"][self as usize]
    }

    /// From its name in YAML.
    pub fn from_name(name: &str) -> Option<Dof> {
        Self::ALL.into_iter().find(|d| d.name() == name)
    }

    /// Whether it is a rotation.
    pub fn is_rotation(self) -> bool {
        self as usize >= 3
    }

    /// Axis of the displacement or rotation: 0, 1, 2.
    pub fn axis(self) -> usize {
        self as usize % 3
    }
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The values a property may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Domain {
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
    /// Any finite number.
    Any,
}

/// One property of an element: a word in YAML, its unit and what it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Property {
    /// The word in YAML.
    pub name: &'static str,
    /// Its SI unit as text, `"Pa"`, `"kg m2"`, `"1"`.
    pub unit: &'static str,
    /// Admissible values.
    pub domain: Domain,
    /// One line for people.
    pub description: &'static str,
}

/// What an element is built from: geometry in element axes and its property values.
#[derive(Debug, Clone, Copy)]
pub struct ElementInput<'a> {
    /// Position of each node in element axes, relative to the first node, m.
    pub points: &'a [[f64; 3]],
    /// Value of each property of [`Element::properties`], in that order and in SI; `None` where the file says nothing.
    pub values: &'a [Option<f64>],
}

impl ElementInput<'_> {
    /// Length between the first and the second node, m.
    pub fn length(&self) -> f64 {
        let p = self.points[1];
        (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt()
    }
}

/// Which axes the matrices of an element are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axes {
    /// x from the first node to the second, z as near as possible to the `orientation` vector of the file (default:
    /// global z, or global y for an element along global z), y completing the right-handed frame.
    AlongNodes,
    /// Global axes, or the element's own `axes` where the file gives them.
    Given,
}

/// A finite element: stateless, three-dimensional, six dofs a node.
pub trait Element: fmt::Debug + Send + Sync {
    /// The word in YAML and in lists, `snake_case`.
    fn name(&self) -> &'static str;

    /// One sentence: what it is for.
    fn summary(&self) -> &'static str;

    /// Equations, axes, limits and sources, as the reference page prints them.
    fn theory(&self) -> &'static str;

    /// The dofs it touches at each of its nodes, in element axes; their count is the number of nodes.
    fn nodes(&self) -> &'static [&'static [Dof]];

    /// Its properties, in the order of [`ElementInput::values`].
    fn properties(&self) -> &'static [Property];

    /// The axes its matrices are written in.
    fn axes(&self) -> Axes;

    /// Stiffness, (6 nodes) x (6 nodes), in element axes, N/m, N, N m.
    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError>;

    /// Mass, (6 nodes) x (6 nodes), in element axes, kg, kg m, kg m².
    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError>;

    /// Viscous damping, (6 nodes) x (6 nodes), in element axes, N s/m; none by default.
    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        Ok(SymMatrix::zeros(6 * input.points.len()))
    }

    /// Displacements and rotations at the fraction `xi` (0 at the first node, 1 at the second) as combinations of the
    /// element's dofs: 6 x (6 nodes), row-major, in element axes. By default linear between two nodes.
    fn interpolate(&self, input: &ElementInput<'_>, xi: f64) -> Vec<[f64; 12]> {
        let _ = input;
        (0..6)
            .map(|d| {
                let mut row = [0.0; 12];
                row[d] = 1.0 - xi;
                row[6 + d] = xi;
                row
            })
            .collect()
    }
}

/// Why an element has no matrices.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// Two nodes at one place.
    #[error("its nodes are at the same place, so it has no length and no axis")]
    ZeroLength,
    /// A property is needed and not given.
    #[error("property `{name}` is missing: {why}")]
    Missing {
        /// The property.
        name: &'static str,
        /// What it is needed for.
        why: &'static str,
    },
    /// Two ways to say the same thing.
    #[error("`{first}` and `{second}` say the same thing twice; give one of them")]
    Redundant {
        /// The one.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A value outside its domain.
    #[error("property `{name}` is {value}; it must be {expected}")]
    OutOfDomain {
        /// The property.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// What it must be, with unit.
        expected: &'static str,
    },
}
