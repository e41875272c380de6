//! A mesh once its file was read.

use crate::mesh::Mesh;
use std::sync::Arc;

/// A mesh in m, with the nodes that the model file has names for.
#[derive(Debug, Clone)]
pub(in crate::model) struct PlacedMesh {
    pub(in crate::model) mesh: Mesh,
    /// Names in the file and indices of the nodes that they mean.
    pub(in crate::model) named: Vec<(String, usize)>,
    /// What stands before the number of a node in its name, and what is taken off the number, ascending.
    pub(in crate::model) prefixes: Vec<(String, u64)>,
}

impl PlacedMesh {
    /// The index of a node by its name here, `n12`.
    pub(in crate::model) fn node(&self, name: &str) -> Option<usize> {
        self.prefixes.iter().find_map(|(prefix, offset)| {
            let number: u64 = name.strip_prefix(prefix.as_str())?.parse().ok()?;
            let found = self.mesh.node(number.checked_add(*offset)?)?;
            // A number that another prefix has begun at is one of that.
            (self.name(found) == name).then_some(found)
        })
    }

    /// The name of a node here.
    pub(in crate::model) fn name(&self, node: usize) -> String {
        let id = self.mesh.nodes[node].id;
        let of = self.prefixes.iter().rev().find(|(_, offset)| *offset <= id);
        of.map_or_else(|| format!("n{id}"), |(prefix, offset)| format!("{prefix}{}", id - offset))
    }

    /// Position of the node that a name of the file means.
    pub(in crate::model) fn position_of(&self, name: &str) -> Option<[f64; 3]> {
        let named = self.named.iter().find(|(n, _)| n == name)?;
        Some(self.mesh.nodes[named.1].at)
    }
}

/// The mesh of an entry once its file was read; no part of what the entry says, so that all are equal.
#[derive(Debug, Clone, Default)]
pub(in crate::model) struct LoadedMesh(pub(in crate::model) Option<Arc<PlacedMesh>>);

impl PartialEq for LoadedMesh {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The part of all cells that no other has.
pub(in crate::model) const ALL: &str = "all";
