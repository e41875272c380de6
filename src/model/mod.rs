//! The model file and what it becomes: K(θ), M(θ), C(θ) of a structure.
//!
//! Reading order: [`spec`] is the file; `place` turns its entries into elements with axes and property values;
//! `constraint` eliminates supports, rigid links and multipoint constraints exactly; `assembly` builds the matrices.
//! [`ParametricModel`] is what the rest of the house sees; [`Model`] is its implementation from a file, and a user may
//! write another around any other solver.

mod acting;
mod affine;
mod assembly;
mod buckling;
mod change;
mod character;
mod compile;
mod configuration;
mod connection;
mod constraint;
mod critical_preload;
mod dependence;
mod dof_map;
mod each;
mod elastic_support;
#[cfg(test)]
mod elastic_support_tests;
#[cfg(test)]
mod ends_tests;
mod entry;
mod export;
mod exported;
mod first_mode;
mod geometry;
mod inside;
mod joined;
mod known;
mod laminate;
mod lay_up;
mod lint;
mod load;
mod loaded_mesh;
mod loose;
mod mass_properties;
#[cfg(test)]
mod mesh_check_tests;
mod mesh_error;
mod mesh_file;
#[cfg(test)]
mod mesh_tests;
mod motion_kinds;
mod moving;
#[cfg(test)]
mod moving_tests;
mod open_section;
mod outwards;
#[cfg(test)]
mod override_tests;
mod parameter;
mod place;
mod placed_element;
mod placed_matrices;
mod plate;
mod plied;
#[cfg(test)]
mod plies_tests;
mod polynomial;
mod reduced;
mod registry;
mod rounding;
#[cfg(test)]
mod section_tests;
mod solver;
pub mod spec;
#[cfg(test)]
mod stability_tests;
mod stand_in;
mod static_preload;
#[cfg(test)]
mod static_preload_tests;
mod stiffness_factor;
mod superelement;
mod superelement_stiffness;
mod system;
mod targets;
mod value;
mod weighted_link;
mod within;
#[cfg(test)]
pub(crate) mod written_mesh;

pub use assembly::{AffineMass, AffinePart, Basis};
pub use change::{Additions, Change, ChangeAt};
pub use character::{ModeCharacter, ModeLabel, family, label_modes, symmetry_index};
pub use compile::Model;
pub use connection::Connection;
pub use critical_preload::CriticalPreload;
pub use dependence::Monomial;
pub use dof_map::{DofMap, rigid_motion};
pub use entry::Entry;
pub use export::{ExportError, ExportReduction, MatrixExport, export_matrices};
pub use geometry::{AXES, GLOBAL, Near, Vector, extent, images, spread};
pub use geometry::{Frame, Geometry};
pub(crate) use geometry::{cross, dot, minus, plus, unit};
pub(crate) use inside::stretch_name;
pub(crate) use joined::Joined;
pub use laminate::{Ply, sums};
pub use lay_up::{LayUp, Rigidity};
pub use lint::{FreeEdges, Soundness, doubts, lint};
pub use load::{load, load_configuration, load_in, solver_runs};
pub use mass_properties::MassProperties;
pub use mesh_error::MeshError;
pub(crate) use outwards::Outwards;
pub use parameter::{Parameter, ParameterSet};
pub use placed_element::PlacedElement;
pub use placed_matrices::{PlacedDof, PlacedMatrices};
pub use plied::{Plied, plied};
pub use reduced::{Asked, ReducedModel, ReducedOptions};
pub use registry::Registry;
pub use solver::{Matrices, ModalSolver, solve_modes};
pub use spec::{ModelSpec, schema};
pub use stand_in::StandIn;
pub use stiffness_factor::StiffnessFactor;
pub use superelement::{SOLVER_FOLDER, SolverRun};
pub use system::{SparseSystem, System};
pub use targets::{Target, Targets};
pub use value::{Affine, Value};

use crate::element::ElementError;
use crate::linalg::{DMatrix, SymMatrix};
use crate::modal::ModalError;

/// Most dofs of dense matrices: K, M and the work of an eigen-solution then take about 2 GB.
pub const MOST_DENSE_DOFS: usize = 6_000;

/// A structure whose matrices depend on parameters.
pub trait ParametricModel: std::fmt::Debug + Send + Sync {
    /// The parameters, in the order of θ.
    fn parameters(&self) -> &ParameterSet;

    /// Rows of the matrices; it does not depend on θ.
    fn dof_map(&self) -> &DofMap;

    /// K, M and C at θ, dense.
    ///
    /// # Errors
    /// [`ModelError::TooLarge`] for a model with more than [`MOST_DENSE_DOFS`] dofs.
    fn assemble(&self, theta: &[f64]) -> Result<System, ModelError>;

    /// K, M and C at θ into a system of the right size, overwriting it. By default through [`Self::assemble`].
    fn assemble_into(&self, theta: &[f64], system: &mut System) -> Result<(), ModelError> {
        *system = self.assemble(theta)?;
        Ok(())
    }

    /// K, M and C at θ, sparse. By default through [`Self::assemble`].
    fn assemble_sparse(&self, theta: &[f64]) -> Result<SparseSystem, ModelError> {
        Ok(SparseSystem::from(&self.assemble(theta)?))
    }

    /// [`Self::assemble_derivative`], sparse. By default through it.
    fn assemble_sparse_derivative(&self, theta: &[f64], j: usize) -> Result<SparseSystem, ModelError> {
        Ok(SparseSystem::from(&self.assemble_derivative(theta, j)?))
    }

    /// ∂K/∂θ_j, ∂M/∂θ_j, ∂C/∂θ_j at θ. By default by central differences.
    fn assemble_derivative(&self, theta: &[f64], j: usize) -> Result<System, ModelError> {
        assemble_difference(self.parameters(), theta, j, |theta| self.assemble(theta))
    }

    /// Mass, centre of gravity and inertia at θ, if the model knows them.
    fn mass_properties(&self, theta: &[f64]) -> Result<Option<MassProperties>, ModelError> {
        let _ = theta;
        Ok(None)
    }

    /// [`Self::mass_properties`] with one value of θ exchanged at a time, `None` where there are none. By default through it.
    ///
    /// * `others` - parameters, and the values that they have instead
    fn mass_properties_beside(&self, theta: &[f64], others: &[(usize, f64)]) -> Vec<Option<MassProperties>> {
        let beside = |&(j, value): &(usize, f64)| {
            let mut other = theta.to_vec();
            other[j] = value;
            self.mass_properties(&other).ok().flatten()
        };
        others.iter().map(beside).collect()
    }

    /// How a point of an element moves; `None` if the model has no element of that name.
    fn point(&self, element: &str, fraction: f64) -> Result<Option<PointMotion>, ModelError> {
        let _ = (element, fraction);
        Ok(None)
    }

    /// [`Self::point`] at θ, where the shape functions of the element depend on it, as with a flexible end; `None` where they do
    /// not, or there is no such element.
    fn point_at(&self, element: &str, fraction: f64, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        let _ = (element, fraction, theta);
        Ok(None)
    }

    /// Whether [`Self::point_at`] may depend on parameter `j`; a model that does not tell is asked by differences.
    fn has_point_moved_by(&self, element: &str, fraction: f64, j: usize) -> bool {
        let _ = (element, fraction, j);
        true
    }

    /// How the point of a surface or a volume moves that is nearest to a place, m, global; `None` where the element, part or group of that
    /// name is neither. It does not depend on θ.
    fn point_near(&self, element: &str, place: [f64; 3]) -> Result<Option<PointMotion>, ModelError> {
        let _ = (element, place);
        Ok(None)
    }

    /// How a node moves at θ, where that depends on it, as where a support gives; `None` elsewhere: see [`Self::dof_map`].
    fn node_at(&self, node: usize, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        let _ = (node, theta);
        Ok(None)
    }

    /// Whether [`Self::node_at`] may depend on parameter `j`; a model that does not tell is asked by differences.
    fn has_nodes_moved_by(&self, j: usize) -> bool {
        let _ = j;
        true
    }

    /// Names that [`Self::point`] knows.
    fn element_names(&self) -> Vec<&str> {
        Vec::new()
    }

    /// The damping ratio that every elastic mode has beside what C gives it, as a function of θ; `None`, the default, where there is none.
    fn modal_damping(&self) -> Option<&Affine> {
        None
    }

    /// The preload at which the structure buckles at θ; `None` where it bears any, or has none.
    fn critical_preload(&self, theta: &[f64]) -> Result<Option<CriticalPreload>, ModelError> {
        let _ = theta;
        Ok(None)
    }

    /// Row -> (row of its mirror image, sign), if the model has a plane of symmetry.
    fn mirror(&self) -> Option<&[(usize, f64)]> {
        None
    }

    /// What kind of motion every one of some shapes is, if the model can tell.
    ///
    /// * `shapes` - as columns, the first `n_rigid` of them rigid-body modes, (n_dof x n_shapes)
    fn characters(
        &self,
        theta: &[f64],
        shapes: &DMatrix<f64>,
        n_rigid: usize,
    ) -> Result<Option<Vec<ModeCharacter>>, ModelError> {
        let _ = (theta, shapes, n_rigid);
        Ok(None)
    }

    /// The model of a file that this is, with its members and bodies.
    fn of_file(&self) -> Option<&Model> {
        None
    }

    /// What stands in for a larger model that this is: its dofs are coordinates, which move that model.
    fn stand_in(&self) -> Option<&StandIn> {
        None
    }

    /// Where the nodes of the structure have their dofs: of a stand-in, those of the model that it stands for.
    fn dofs_of_nodes(&self) -> &DofMap {
        self.stand_in().map_or_else(|| self.dof_map(), |s| s.model().dof_map())
    }

    /// Mass properties that an update has to respect.
    fn targets(&self) -> Targets {
        Targets::default()
    }

    /// Rᵀ M R of the six rigid motions about the origin, in the terms of [`Self::affine`], where [`Self::mass_properties`] is
    /// that of R_0 + Σ θ_j R_j + Σ c_k(θ) R_k: the fast path.
    fn affine_mass(&self) -> Option<&AffineMass> {
        None
    }

    /// Whether [`Self::mass_properties`] may depend on parameter `j`; a model that does not tell is asked by differences.
    fn has_mass_of(&self, j: usize) -> bool {
        let _ = j;
        true
    }

    /// K, M, C as K0 + Σ θ_j K_j + Σ c_k(θ) K_k, if they are polynomials of the parameters: the fast path.
    fn affine(&self) -> Option<&AffinePart> {
        None
    }
}

/// ∂K/∂θ_j, ∂M/∂θ_j, ∂C/∂θ_j at θ by central differences.
///
/// * `assemble` - the matrices at a θ
///
/// # Errors
/// Those of `assemble`.
pub fn assemble_difference(
    parameters: &ParameterSet,
    theta: &[f64],
    j: usize,
    assemble: impl Fn(&[f64]) -> Result<System, ModelError>,
) -> Result<System, ModelError> {
    let step = parameters.difference_step(theta, j);
    let shifted = |sign: f64| {
        let mut theta = theta.to_vec();
        theta[j] += sign * step;
        assemble(&theta)
    };
    let (above, below) = (shifted(1.0)?, shifted(-1.0)?);
    let slope = |a: DMatrix<f64>, b: DMatrix<f64>| (a - b) / (2.0 * step);
    Ok(System {
        stiffness: slope(above.stiffness, below.stiffness),
        mass: slope(above.mass, below.mass),
        damping: above.damping.zip(below.damping).map(|(a, b)| slope(a, b)),
    })
}

/// How a point moves: displacements and rotations along global axes as combinations of rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointMotion {
    /// For each of ux ... rz: (row, factor).
    pub rows: [Vec<(usize, f64)>; 6],
    /// Its position, global, m.
    pub position: [f64; 3],
}

/// Stiffness, mass and damping of one element, in its axes.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementMatrices {
    /// Stiffness.
    pub stiffness: SymMatrix,
    /// Mass.
    pub mass: SymMatrix,
    /// The part of it that has weight, where that is not all of it.
    pub weighed_mass: Option<SymMatrix>,
    /// Damping.
    pub damping: SymMatrix,
}

impl ElementMatrices {
    /// Of n dofs, all zero.
    fn zeros(n: usize) -> Self {
        let zero = || SymMatrix::zeros(n);
        Self { stiffness: zero(), mass: zero(), weighed_mass: None, damping: zero() }
    }

    fn combine(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            stiffness: self.stiffness.combine(&other.stiffness, &f),
            mass: self.mass.combine(&other.mass, &f),
            weighed_mass: self.weighed_mass.as_ref().zip(other.weighed_mass.as_ref()).map(|(a, b)| a.combine(b, &f)),
            damping: self.damping.combine(&other.damping, &f),
        }
    }

    /// The mass that a balance sees.
    pub(crate) fn weighed(&self) -> &SymMatrix {
        self.weighed_mass.as_ref().unwrap_or(&self.mass)
    }

    fn is_zero(&self) -> bool {
        [&self.stiffness, &self.mass, self.weighed(), &self.damping].iter().all(|a| a.is_zero())
    }
}

/// Why a model has no matrices.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A reduced model needs terms that can be projected.
    #[error(
        "the matrices are not polynomials of the parameters, as a reduced model needs; a parameter of a compliance (of shear, of a joint) makes them so"
    )]
    NotPolynomial,
    /// An element refuses its input.
    #[error("element `{element}`: {source}")]
    Element {
        /// Its name.
        element: String,
        /// Path of its entry in the file.
        path: String,
        /// Why.
        source: ElementError,
    },
    /// θ has the wrong length.
    #[error("the model has {expected} parameters, not {given}")]
    WrongLength {
        /// Number of parameters.
        expected: usize,
        /// Length of the given θ.
        given: usize,
    },
    /// Its dense matrices would fill the memory.
    #[error(
        "the model has {n_dof} dofs, and this needs dense matrices of at most {most}: subdivide less, or use `active_dofs`"
    )]
    TooLarge {
        /// Its number of independent dofs.
        n_dof: usize,
        /// The largest number.
        most: usize,
    },
    /// The preload is too large.
    #[error("{}", critical_preload::buckled(.0, *.1))]
    Buckled(CriticalPreload, usize),
    /// It has no modes.
    #[error(transparent)]
    Modal(#[from] ModalError),
    /// A model around another solver failed.
    #[error("{0}")]
    External(String),
}
