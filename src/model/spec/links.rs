//! Links by weights, and where a model comes from.

use super::{DofName, Named};
use crate::units::Scalar;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A node that follows the mean motion of others: the rigid motion nearest to theirs by weighted least squares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightedLinkSpec {
    /// The node that follows.
    pub node: String,
    /// Its dofs that follow; all when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dofs: Option<Vec<DofName>>,
    /// The nodes that it follows, in sets of equal weight.
    pub of: Vec<WeightedNodes>,
}

/// Nodes of a weighted link with one weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightedNodes {
    /// The nodes.
    pub nodes: Vec<String>,
    /// The dofs of them that count; `[ux, uy, uz]` when absent. Rotations count with the square of the mean distance of all nodes from the
    /// one that follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dofs: Option<Vec<DofName>>,
    /// Weight of each; 1 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

/// Nodes that follow the point of shells or solids that is nearest to each, rigidly across any gap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TieSpec {
    /// The nodes that follow; sets of a mesh by their names.
    pub nodes: Vec<String>,
    /// What they follow: parts of a mesh, groups or elements, of shells or solids.
    pub to: Vec<String>,
    /// How far from it they may stand; a twentieth of the size of the element when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Scalar>,
    /// Whether rotations of nodes that have some follow too; they do when absent. `false` makes a hinge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotations: Option<bool>,
    /// Springs of each node between it and what it follows, by global direction, `{uz: 1e8 N/m}`; directions without one are rigid.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub k: Named<Scalar>,
}

impl WeightedLinkSpec {
    /// The nodes that it follows.
    pub fn followed(&self) -> impl Iterator<Item = &String> {
        self.of.iter().flat_map(|set| &set.nodes)
    }

    /// All its nodes, the one that follows first.
    pub fn nodes(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.node).chain(self.followed())
    }
}

/// Where a model comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportedSpec {
    /// The file that was read.
    pub from: String,
    /// Its format: `nastran`, `abaqus`, `calculix`.
    pub format: String,
    /// The system of units of its numbers: `si`, `mm-t-s`, `in-lbf-s` or `ft-lbf-s`.
    pub units: String,
    /// The subcase whose constraints and loads hold; the first when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subcase: Option<u32>,
    /// Mass of the deck's unit of mass over that of its system of units, where they differ (WTMASS).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wtmass: Option<f64>,
    /// Nodes whose displacements the solver gives along the axes of a frame, by frame; global elsewhere.
    #[serde(default, skip_serializing_if = "indexmap::IndexMap::is_empty")]
    pub displacement_frames: super::Named<Vec<String>>,
    /// `properties` where every property of the deck was given a parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameters: Option<String>,
}
