//! Elements: a declaration and textbook matrices each, one file each.
//!
//! An element knows nothing of nodes' names, parameters, files or global axes. It says which dofs it touches and which
//! properties it has, and returns symmetric matrices in its own axes; rotation and scatter exist once, in `model`.
//!
//! To add one: a file here with a unit struct and `impl Element`, a text beside it (`beam.md`: sketch, equations, limits,
//! sources; both its documentation and its [`Element::theory`]), `mod` and a line in [`ELEMENTS`]. [`conformance`]
//! checks definiteness, the rigid-body null space, mass, units and refusals of every member of the list, so a new file
//! needs only a closed-form test of its own. An element of your own crate is checked by the same
//! [`conformance::check`].

mod bar;
mod beam;
mod bushing;
pub mod conformance;
mod direction;
mod ground_spring;
mod input;
mod joint;
mod mass_matrix;
mod meshed;
mod point_mass;
mod scalar_spring;
mod shear_panel;
mod shell;
mod solid;
mod spring;
mod strain_field;
#[cfg(test)]
mod tests;

pub(crate) use input::value;
pub use input::{Domain, ElementInput, Property, Sample, property_index};
pub use strain_field::{StrainField, StrainPoint};

use crate::catalogue::catalogue;
use crate::linalg::SymMatrix;
use std::fmt;

catalogue! {
    /// Every element that a model file can name.
    ELEMENTS: dyn Element;
    bar::Bar,
    beam::Beam,
    bushing::Bushing,
    ground_spring::GroundSpring,
    solid::Hex20,
    solid::Hex20Reduced,
    solid::Hex8,
    solid::Hex8Reduced,
    mass_matrix::MassMatrix,
    point_mass::PointMass,
    solid::Pyramid13,
    solid::Pyramid5,
    scalar_spring::ScalarSpring,
    shear_panel::ShearPanel,
    shell::Shell3,
    shell::Shell4,
    spring::Spring,
    solid::Tet10,
    solid::Tet4,
    solid::Wedge15,
    solid::Wedge6,
}

/// The element of [`ELEMENTS`] with this name.
pub fn by_name(name: &str) -> Option<&'static dyn Element> {
    ELEMENTS.iter().copied().find(|e| e.name() == name)
}

pub use retune_base::dof::Dof;

/// Which axes the matrices of an element are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axes {
    /// x from the first node to the second, z as near as possible to the `orientation` vector of the file (default:
    /// global z, or global y for an element along global z; close to global z there is none), y completing the right-handed
    /// frame.
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

    /// The part of [`Self::mass`] that a balance would weigh, where that is not all of it: the mass of air or water that
    /// moves with the element has inertia and no weight. `None`, the default, stands for all of it.
    fn weighed_mass(&self, input: &ElementInput<'_>) -> Result<Option<SymMatrix>, ElementError> {
        let _ = input;
        Ok(None)
    }

    /// Viscous damping, (6 nodes) x (6 nodes), in element axes, N s/m; none by default.
    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        Ok(SymMatrix::zeros(6 * input.points.len()))
    }

    /// Displacements and rotations at the fraction `xi` (0 at the first node, 1 at the second) of the straight line
    /// between the first two nodes: row i times the element's dofs is `Dof::ALL[i]` there, in element axes.
    ///
    /// (6) = (6 x 12) (12). By default linear between two nodes, and the node itself of an element with one.
    fn interpolate(&self, input: &ElementInput<'_>, xi: f64) -> Result<[[f64; 12]; 6], ElementError> {
        let (expected, given) = (self.nodes().len(), input.points.len());
        if given != expected {
            return Err(ElementError::NodeCount { expected, given });
        }
        let far = if input.points.len() > 1 { xi } else { 0.0 };
        let mut rows = [[0.0; 12]; 6];
        for (d, row) in rows.iter_mut().enumerate() {
            row[d] = 1.0 - far;
            row[6 + d] = far;
        }
        Ok(rows)
    }

    /// The point of a surface or of a volume that is nearest to a place, and how it moves; `None`, the default, for what is neither.
    ///
    /// * `place` - in element axes, relative to the first node, m
    fn nearest(&self, input: &ElementInput<'_>, place: [f64; 3]) -> Result<Option<PointWithin>, ElementError> {
        let _ = (input, place);
        Ok(None)
    }

    /// The stiffness in parts by kind of strain, which sum to [`Self::stiffness`]; `None`, the default, where it is not known.
    fn strain_parts(&self, input: &ElementInput<'_>) -> Result<Option<StrainParts>, ElementError> {
        let _ = input;
        Ok(None)
    }

    /// The strains within it, from which the error of a mesh is estimated; `None`, the default, where none are known.
    fn strain_field(&self, input: &ElementInput<'_>) -> Result<Option<StrainField>, ElementError> {
        let _ = input;
        Ok(None)
    }

    /// The preloads that displacements leave in it, by names of [`Self::preloads`]: forces of a beam, forces by width of a shell, stresses of a solid,
    /// in the mean over the element. None by default.
    ///
    /// * `u` - six a node, in element axes
    fn preload_of(&self, input: &ElementInput<'_>, u: &[f64]) -> Result<Vec<(&'static str, f64)>, ElementError> {
        let _ = (input, u);
        Ok(Vec::new())
    }

    /// The same element where some of its edges are shared with neighbours whose edges stay straight. `None`, the default, for one whose edges
    /// are straight in any case: they do not bend with the rotations of their ends.
    ///
    /// * `straight` - for the edge from each corner to the next
    fn beside(&self, straight: &[bool]) -> Option<&'static dyn Element> {
        let _ = straight;
        None
    }

    /// (y, z) of the line on which the mass lies, from the line between the nodes, m; of an element along its nodes.
    fn mass_axis(&self, input: &ElementInput<'_>) -> [f64; 2] {
        let _ = input;
        [0.0; 2]
    }

    /// Properties that are preloads: the stiffness is K_E + P K_P in each, and too large a one makes it buckle.
    fn preloads(&self) -> &'static [&'static str] {
        &[]
    }

    /// What this input leaves without resistance although the element is there to resist it: the caller, who knows which
    /// dofs are active, refuses those. A beam without `Iz` reports `uy` and `rz`. Nothing by default.
    fn lacks(&self, input: &ElementInput<'_>) -> Vec<Lack> {
        let _ = input;
        Vec::new()
    }

    /// Whether its matrices act along motions that its properties name, and not on a body: [`conformance`] then asks neither that it
    /// resist all but rigid motion nor that its mass be the same in every direction.
    fn is_scalar(&self) -> bool {
        false
    }

    /// Typical inputs, which together give every property: for [`conformance`] and for examples in the documentation.
    fn samples(&self) -> Vec<Sample> {
        Vec::new()
    }
}

/// A point of a surface or of a volume.
#[derive(Debug, Clone, PartialEq)]
pub struct PointWithin {
    /// Where it is, in element axes, relative to the first node, m.
    pub at: [f64; 3],
    /// Row i times the dofs of the element, six a node, is `Dof::ALL[i]` there, in element axes.
    pub rows: [Vec<f64>; 6],
}

/// A stiffness by kinds of strain, each in element axes; springs at the ends count as the strain that they add to.
#[derive(Debug, Clone, PartialEq)]
pub struct StrainParts {
    /// Stretching.
    pub axial: SymMatrix,
    /// Bending, with shear and the axial force in it.
    pub bending: SymMatrix,
    /// Torsion.
    pub torsion: SymMatrix,
}

/// A dof, in element axes, that the element ought to resist and does not, because a property is absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lack {
    /// The dof, in element axes.
    pub dof: Dof,
    /// The property that would supply it.
    pub property: &'static str,
}

/// Why an element has no matrices.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// Two nodes at one place.
    #[error("its nodes are at the same place, so it has no length and no axis; a `bushing` joins such nodes")]
    ZeroLength,
    /// A solid or a shell whose volume or area is not positive somewhere.
    #[error(
        "it is flat or turned inside out at a point of its integration: two of its nodes are at one place, or they are not in the order of \
         the sketch in `retune explain`"
    )]
    Inverted,
    /// Too few or too many nodes.
    #[error("it joins {expected} node(s), not {given}")]
    NodeCount {
        /// Number of nodes that it has.
        expected: usize,
        /// Number of points in the input.
        given: usize,
    },
    /// Too few or too many property values.
    #[error("it has {expected} properties, but {given} values are given (`None` stands for an absent one)")]
    ValueCount {
        /// Number of its properties.
        expected: usize,
        /// Number of values in the input.
        given: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {node} of it has a coordinate that is not finite")]
    PointNotFinite {
        /// Number of the node in the element, from one.
        node: usize,
    },
    /// A name that is not a property of the element.
    #[error("`{name}` is not one of its properties")]
    UnknownProperty {
        /// The name.
        name: &'static str,
    },
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
    /// Why an element of another program, or of a user's own, has none.
    #[error("{0}")]
    External(String),
}
