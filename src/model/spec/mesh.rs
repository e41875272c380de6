//! A mesh that stays in its file, and what stands on it.

use super::super::loaded_mesh::LoadedMesh;
use super::{Named, SectionSpec};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A mesh in a file of its own. Its nodes are called `n12`, its elements `e7`, by their numbers there; its sets are sets of nodes and
/// groups of elements here, by their names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// The file, relative to the model file: MSH of gmsh, version 4.1 or 2.2, or a deck of Abaqus, CalculiX or Nastran in one file.
    pub file: String,
    /// Unit of its coordinates: `m`, `mm`, `in`.
    pub units: String,
    /// SHA-256 of the file; a file that is another is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// What stands before the number of a node in its name, with what is taken off the number: `{a_n: 0, b_n: 1000}` calls node 7 `a_n7` and
    /// node 1007 `b_n7`. `{n: 0}` when absent.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub prefixes: Named<u64>,
    /// What stands on its sets of cells, by their names; `all` is everything that no other part has. Sets that are not named here are
    /// sets of nodes: edges to hold, points to load.
    pub parts: Named<MeshPartSpec>,
    /// Number of patches, neighbouring elements within about equal radii, into which each part is cut for effects; 24 when absent, 0 for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patches: Option<u32>,
    /// What the file holds, once it was read.
    #[serde(skip)]
    #[schemars(skip)]
    pub(in crate::model) loaded: LoadedMesh,
}

/// The elements of a set of cells.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshPartSpec {
    /// Their type, where the usual one of their shape is not meant: `hex8_reduced` or `hex20_reduced` for hexahedra, `bar` for lines, which are beams otherwise.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// What stands before the number of an element in its name, `e` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prefix: Option<String>,
    /// What is taken off the number of an element in its name, 0 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<u64>,
    /// Section with their properties.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub section: Option<String>,
    /// Properties beside or instead of those of the section.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub properties: SectionSpec,
    /// A direction near the z axis of beams and bars.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 3]>,
    /// Frame whose axes shells and solids refer to: the x axis, projected onto a shell, is where its `angle` is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
}
