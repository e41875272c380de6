//! The model file: its types, as they stand in YAML.
//!
//! Everything is named, and names are keys of maps, so that a file reads well, an editor can complete it, and a change
//! touches one line. Numbers are [`Scalar`]s: with units, and with parameters where properties are meant.

mod links;
mod mesh;
mod places;
mod preloads;
mod sections;
mod shapes;
mod solver;
mod superelements;

pub use links::{ImportedSpec, TieSpec, WeightedLinkSpec, WeightedNodes};
pub use mesh::{MeshPartSpec, MeshSpec};
pub use places::{FrameSpec, LineSpec, NodeOffsetSpec, NodeRule, NodeSpec, OneOrThree, RotateSpec};
pub use preloads::{ForceSpec, SpinSpec, StaticPreloadSpec};
pub use sections::{SectionSpec, SectionValue};
pub use shapes::{
    AngleSpec, BoxSpec, CircleSpec, ISpec, LaminateSpec, PlyMaterialSpec, PlySpec, RectangleSpec, ShapeSpec, TubeSpec,
    WebAndFlangeSpec,
};
pub use solver::{DependenceSpec, KnownSolver, SolverSpec, WordsSpec, WritesSpec, WrittenSpec};
pub use superelements::{
    CheckSpec, ExportSpec, MatrixSpec, NodeLabel, PreloadSpec, RecoverySpec, SuperelementSpec, TermSpec, UnitsSpec,
};

use crate::element::Dof;
use crate::units::Scalar;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A named map in file order.
pub type Named<T> = IndexMap<String, T>;

/// Version of the format of model files that is read and written.
pub(crate) const FORMAT: u32 = 1;

/// A model file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelSpec {
    /// Version of the format: 1.
    pub retune: u32,
    /// Name of the model.
    pub name: String,
    /// A paragraph for people: what it is, where its numbers come from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// The dofs that exist in this model; all six when absent. A planform grid is `[uz, rx, ry]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub active_dofs: Option<Vec<DofName>>,
    /// The plane that maps the structure onto itself, for `mirror` nodes and for names of modes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub symmetry: Option<SymmetrySpec>,
    /// Parameters: numbers with a name that properties refer to.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub parameters: Named<ParameterSpec>,
    /// Coordinate frames.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub frames: Named<FrameSpec>,
    /// Straight lines to put nodes on.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub lines: Named<LineSpec>,
    /// A mesh in a file of its own, and what stands on its sets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshSpec>,
    /// Nodes; a model of a mesh or of superelements alone may have none.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub nodes: Named<NodeSpec>,
    /// Nodes that stand elsewhere than their entry says: what is added to it.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub node_offsets: Named<NodeOffsetSpec>,
    /// Sets of element properties.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub sections: Named<SectionSpec>,
    /// Beams, singly, in pairs or in chains.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub beams: Named<MemberSpec>,
    /// Bars: axial stiffness only.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub bars: Named<MemberSpec>,
    /// Springs, to ground or between nodes.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub springs: Named<SpringSpec>,
    /// Bushings: springs between nodes that are apart, joined rigidly to them.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub bushings: Named<SpringSpec>,
    /// Point masses with inertia and offset.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub masses: Named<MassSpec>,
    /// Elements of any other type, a user's own among them.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub elements: Named<ElementSpec>,
    /// Parts whose matrices come from files of other solvers.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub superelements: Named<SuperelementSpec>,
    /// Changes of single elements or groups against their sections.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub overrides: Named<OverrideSpec>,
    /// Rigid links: slave nodes that follow a master as one rigid body, exactly.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub rigid_links: Named<RigidLinkSpec>,
    /// Weighted links: a node that follows the mean motion of others, without stiffening them.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub weighted_links: Named<WeightedLinkSpec>,
    /// Surface ties: nodes that follow the nearest point of shells or solids.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub ties: Named<TieSpec>,
    /// Supports: dofs that do not move.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub supports: Named<SupportSpec>,
    /// Static loads whose stresses stiffen or soften the structure: gravity, spin, forces.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub preloads: Named<StaticPreloadSpec>,
    /// Damping ratio of every elastic mode, `1 %`, beside what dashpots and damped parts give; may name parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modal_damping: Option<Scalar>,
    /// Linear multipoint constraints: a sum of dofs that is zero.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub constraints: Named<ConstraintSpec>,
    /// Named sets of elements, chains and masses.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub groups: Named<Vec<String>>,
    /// Mass properties that the structure is known to have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub targets: Option<TargetsSpec>,
    /// Other boundary conditions of the same structure, by name.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub configurations: Named<ConfigurationSpec>,
    /// The deck that the model was imported from: what `export` needs to write changes back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imported: Option<ImportedSpec>,
    /// What `add` did to this file, oldest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub history: Vec<HistoryEntry>,
}

/// JSON Schema of model files.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(ModelSpec).to_value()
}

/// A dof by its name: `ux`, `uy`, `uz`, `rx`, `ry`, `rz`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum DofName {
    Ux,
    Uy,
    Uz,
    Rx,
    Ry,
    Rz,
}

impl From<DofName> for Dof {
    fn from(name: DofName) -> Dof {
        Dof::ALL[name as usize]
    }
}

/// An axis with a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[expect(missing_docs, reason = "the names say it")]
pub enum SignedAxis {
    #[serde(rename = "+x", alias = "x")]
    PlusX,
    #[serde(rename = "+y", alias = "y")]
    PlusY,
    #[serde(rename = "+z", alias = "z")]
    PlusZ,
    #[serde(rename = "-x")]
    MinusX,
    #[serde(rename = "-y")]
    MinusY,
    #[serde(rename = "-z")]
    MinusZ,
}

impl SignedAxis {
    /// The unit vector.
    pub fn vector(self) -> [f64; 3] {
        let mut v = [0.0; 3];
        v[self as usize % 3] = if (self as usize) < 3 { 1.0 } else { -1.0 };
        v
    }
}

/// A mirror plane through a point, normal to a global axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SymmetrySpec {
    /// The axis normal to the plane: `y` for left and right of an aeroplane with x aft.
    pub normal: AxisName,
    /// Coordinate of the plane along that axis; 0 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Scalar>,
}

/// An axis: `x`, `y`, `z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum AxisName {
    X,
    Y,
    Z,
}

/// A parameter. With bounds an update may change it; without, it is a constant with a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterSpec {
    /// Estimate.
    pub value: Scalar,
    /// Lower and upper bound of an update.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[Scalar; 2]>,
    /// Unit that tables print it in; that of `value` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Standard deviation of what is known of it before the test: a Gaussian prior around `value`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior_sd: Option<Scalar>,
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
}

/// Beams or bars: exactly one of `nodes`, `pairs`, `chain`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MemberSpec {
    /// One element between two nodes; it bears the name of the entry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<[String; 2]>,
    /// Several elements, each between two nodes; they are called `name.1`, `name.2`, ...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pairs: Option<Vec<[String; 2]>>,
    /// Elements from node to node along a chain; they are called `name.1`, `name.2`, ...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chain: Option<Vec<String>>,
    /// Section with its properties.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub section: Option<String>,
    /// Properties beside or instead of those of the section. Those of ends (`end1_`, `end2_`) are of the ends of the chain, or of
    /// each of `pairs`; of the parts of `subdivide` the first and the last have them.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub properties: SectionSpec,
    /// A direction near the element's z axis; global z (for an element along z: global y) when absent. Within 3 degrees of global z it
    /// must be stated, unless the section is the same all round.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 3]>,
    /// Rigid arms from both nodes of each element to its ends, global axes: `[[0, 2 mm, 0], [0, 2 mm, 0]]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offsets: Option<[[Scalar; 3]; 2]>,
    /// Forces and moments that the ends do not pass on; of a chain those of its first and last element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub releases: Option<ReleasesSpec>,
    /// Number of elements to make of each (a finer mesh with the same properties). Nodes and stretches inside have names by their share of the
    /// length: `spar/0.4`, `spar/0.4..0.5`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subdivide: Option<u32>,
}

/// Hinges and slides at the ends of a member, along and about the axes of its elements: `{end2: [ry, rz]}` passes no bending moment on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReleasesSpec {
    /// At the first node.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub end1: Vec<DofName>,
    /// At the last node.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub end2: Vec<DofName>,
}

/// A spring or a bushing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// A spring to ground at this node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// A spring between these two nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<[String; 2]>,
    /// Stiffness in each direction: `{uz: 150 N/m, rx: 5 N m/rad}`; for a spring between nodes that are apart, `axial`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub k: Named<Scalar>,
    /// Viscous damping in each direction: `{uz: 3 N s/m}`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub c: Named<Scalar>,
    /// Frame whose axes the directions refer to; global when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Rigid arms from both nodes to the ends of the spring, global axes; a bushing then lies between the ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offsets: Option<[[Scalar; 3]; 2]>,
    /// Of a bushing: where between the nodes its centre is, 0 to 1; 0.5 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub location: Option<Scalar>,
}

/// A rigid body on a node or on each of several nodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassSpec {
    /// The node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Several nodes, each with its own copy of the mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Vec<String>>,
    /// Mass of each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<Scalar>,
    /// Inertia about its own centre of gravity: `xx`, `yy`, `zz`, and the products `xy`, `xz`, `yz` (∫ x y dm, and so on).
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub inertia: Named<Scalar>,
    /// Its centre of gravity relative to the node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<[Scalar; 3]>,
    /// Frame whose axes `inertia` and `offset` refer to; global when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
}

/// An element of any type of the catalogue, or of the user's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElementSpec {
    /// Its type: a word of `retune list elements`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Its nodes.
    pub nodes: Vec<String>,
    /// Section with its properties.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub section: Option<String>,
    /// Properties beside or instead of those of the section.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub properties: SectionSpec,
    /// A direction near the element's z axis, for elements along their nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 3]>,
    /// Frame whose axes its matrices refer to, for elements that have no axis of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
}

/// Changes of elements: of the element, chain, mass or group that the entry is named after, or of those in `of`.
///
/// Several entries may change one element. `set` replaces, in file order; factors (`scale`, `taper`, `stiffness`, `mass`)
/// multiply; what stands under `add` is added after all factors.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OverrideSpec {
    /// Names of elements, chains, masses and groups that it changes; the name of the entry is then free.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// Properties set to these values.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub set: Named<Scalar>,
    /// Properties multiplied by these factors.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub scale: Named<Scalar>,
    /// Added to these properties, to zero where the property is absent.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub add: Named<Scalar>,
    /// Linear variation t along each chain: these properties, or `stiffness` or `mass` as a whole, are multiplied by 1 + t s
    /// at the middle of each element, s going from -1 at the start of the chain to +1 at its end.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub taper: Named<Scalar>,
    /// Factor on the whole stiffness matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Scalar>,
    /// Factor on the whole mass matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<Scalar>,
    /// Viscous damping in proportion to the stiffness, s: C = β K. A loss factor η at ω is β = η/ω.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_damping: Option<Scalar>,
    /// Viscous damping in proportion to the mass, 1/s: C = α M. A damping ratio ζ at ω is α = 2 ζ ω.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_damping: Option<Scalar>,
}

/// Slaves that follow a master.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidLinkSpec {
    /// The node that leads.
    pub master: String,
    /// The nodes that follow.
    pub slaves: Vec<String>,
    /// The dofs of the slaves that follow; all when absent. A pin is `[ux, uy, uz]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dofs: Option<Vec<DofName>>,
    /// How much it gives between each slave and where the master would carry it, along and about global axes at the slave, in each direction in which this or
    /// another link carries it: `{ry: 2e-7 rad/(N m)}`; rigid when absent. With `dofs: []` an entry carries nothing itself and says how much others give.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub compliance: Named<Scalar>,
}

impl RigidLinkSpec {
    /// Whether it carries a dof of its slaves.
    pub fn holds(&self, dof: Dof) -> bool {
        self.dofs.as_ref().is_none_or(|all| all.iter().any(|d| Dof::from(*d) == dof))
    }

    /// Whether it says no more than how much other links give.
    pub fn is_compliance_of_others(&self) -> bool {
        !self.compliance.is_empty() && self.dofs.as_ref().is_some_and(Vec::is_empty)
    }
}

/// Dofs held at zero.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SupportSpec {
    /// The node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Several nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Vec<String>>,
    /// The dofs held; all when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<Vec<DofName>>,
    /// How much it gives, in each direction that it or another support holds: `{uz: 1e-8 m/N, ry: 2e-7 rad/(N m)}`; rigid when
    /// absent. With `fixed: []` an entry holds nothing itself and says how much others give.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub compliance: Named<Scalar>,
}

impl SupportSpec {
    /// Names of its nodes.
    pub fn nodes(&self) -> impl Iterator<Item = &String> {
        self.node.iter().chain(self.nodes.iter().flatten())
    }

    /// Whether it holds a dof of its nodes.
    pub fn holds(&self, dof: Dof) -> bool {
        self.fixed.as_ref().is_none_or(|all| all.iter().any(|d| Dof::from(*d) == dof))
    }
}

/// Σ factor · dof = 0; the first term's dof is eliminated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstraintSpec {
    /// The terms of the sum.
    pub terms: Vec<ConstraintTerm>,
}

/// One term of a constraint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstraintTerm {
    /// The node.
    pub node: String,
    /// The dof.
    pub dof: DofName,
    /// Its factor; 1 when absent.
    #[serde(default = "one")]
    pub factor: f64,
}

fn one() -> f64 {
    1.0
}

/// A number with the half-width of the range that is accepted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// The value.
    pub value: Scalar,
    /// The update keeps the model within value ± tolerance.
    pub tolerance: Scalar,
}

/// Mass properties that an update has to respect.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetsSpec {
    /// Total mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total_mass: Option<TargetSpec>,
    /// Coordinates of the centre of gravity: `x`, `y`, `z`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub cg: Named<TargetSpec>,
    /// Moments of inertia about the centre of gravity: `xx`, `yy`, `zz`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub inertia: Named<TargetSpec>,
}

/// Another set of boundary conditions of the same structure: what is taken away and what is put there.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConfigurationSpec {
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Names of supports, springs, masses, links, constraints, beams, overrides that are not there; what hung on them alone is
    /// not there either.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// Supports that are there in addition.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub supports: Named<SupportSpec>,
    /// Springs that are there in addition.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub springs: Named<SpringSpec>,
    /// Masses that are there in addition.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub masses: Named<MassSpec>,
    /// Changes of elements that are there in addition.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub overrides: Named<OverrideSpec>,
}

/// One change made by `add`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HistoryEntry {
    /// The effect and its place, `mass-offset@outer_wing`.
    pub add: String,
    /// Why, in the words of the diagnosis.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub because: String,
    /// What it inserted, as paths, so that it can be undone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inserted: Vec<String>,
}
