//! Rigid bodies: nodes that turn alike and can turn.

use super::Structure;
use crate::element::Dof;
use crate::model::ParametricModel;
use std::collections::HashMap;

/// Which nodes are of one rigid body.
#[derive(Debug, Clone)]
pub(super) struct Bodies {
    /// Per node, the number of its body.
    of: Vec<usize>,
    /// The nodes of each.
    nodes: Vec<Vec<usize>>,
}

impl Structure<'_> {
    /// Whether two nodes are one, or belong to one rigid body: they turn alike and can turn.
    pub fn same_body(&self, a: usize, b: usize) -> bool {
        let of = &self.bodies().of;
        of[a] == of[b]
    }

    /// The nodes of the rigid body of a node, itself among them.
    pub(super) fn body_of(&self, node: usize) -> &[usize] {
        let bodies = self.bodies();
        &bodies.nodes[bodies.of[node]]
    }

    fn bodies(&self) -> &Bodies {
        self.bodies.get_or_find(|| {
            let dofs = self.model.dof_map();
            let mut known: HashMap<[Vec<(usize, u64)>; 3], usize> = HashMap::new();
            let (mut of, mut nodes) = (Vec::new(), Vec::<Vec<usize>>::new());
            for node in 0..self.model.geometry().positions.len() {
                // Zeros of both signs are one.
                let term = |&(row, factor): &(usize, f64)| (row, (factor + 0.0).to_bits());
                let turns = [Dof::Rx, Dof::Ry, Dof::Rz].map(|dof| dofs.express(node, dof).iter().map(term).collect());
                let new = nodes.len();
                let body = if turns.iter().all(Vec::is_empty) { new } else { *known.entry(turns).or_insert(new) };
                if body == new {
                    nodes.push(Vec::new());
                }
                nodes[body].push(node);
                of.push(body);
            }
            Bodies { of, nodes }
        })
    }
}
