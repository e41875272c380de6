//! What a place reaches: its nodes, and whether it touches others.

use super::Structure;
use crate::effect::Location;
use std::collections::HashSet;

impl Structure<'_> {
    /// Whether a location is at one of these nodes or elements, or has one of them.
    ///
    /// * `names` - of nodes, pairs of nodes, elements, members, chains, groups, spans or ends
    pub fn touches(&self, at: &Location, names: &[String]) -> bool {
        let reach = |names: &[String]| -> (Vec<usize>, Vec<usize>) {
            let elements: Vec<usize> = names.iter().flat_map(|n| self.elements_of(n)).collect();
            (elements, names.iter().flat_map(|n| self.nodes_named(n)).collect())
        };
        let ((own_elements, own_nodes), (elements, nodes)) = (reach(&at.names), reach(names));
        let ends = |of: &[usize]| -> Vec<usize> {
            of.iter().flat_map(|&e| self.model.elements()[e].nodes.iter().copied()).collect()
        };
        let share = |a: &[usize], b: &[usize]| {
            let b: HashSet<&usize> = b.iter().collect();
            a.iter().any(|x| b.contains(x))
        };
        let at_ends = at.names.iter().filter_map(|n| self.end(n)).map(|end| end.node).collect::<Vec<_>>();
        at.names.iter().any(|n| names.contains(n))
            || share(&own_elements, &elements)
            || share(&own_nodes, &nodes)
            || share(&own_nodes, &ends(&elements))
            || if at_ends.is_empty() { share(&ends(&own_elements), &nodes) } else { share(&at_ends, &nodes) }
    }

    /// The nodes that a location has, those of its elements among them; all where it names nothing.
    pub fn nodes_of(&self, at: &Location) -> Vec<usize> {
        let all = 0..self.model.geometry().names.len();
        let of_elements =
            at.names.iter().flat_map(|n| self.elements_of(n)).flat_map(|e| &self.model.elements()[e].nodes);
        let named = at.names.iter().flat_map(|n| self.nodes_named(n));
        let held = at.names.iter().flat_map(|n| self.nodes_of_support(n));
        let mut out: Vec<usize> = of_elements.copied().chain(named).chain(held).collect();
        out.sort_unstable();
        out.dedup();
        if out.is_empty() { all.collect() } else { out }
    }

    /// The node of a name, or the two of a pair.
    fn nodes_named(&self, name: &str) -> Vec<usize> {
        let node = |name: &str| self.model.geometry().node(name);
        match node(name) {
            Some(n) => vec![n],
            None => self.pair(name).into_iter().flatten().filter_map(node).collect(),
        }
    }

    /// Whether effects can be at something of this name.
    pub fn has_place(&self, name: &str) -> bool {
        !self.elements_of(name).is_empty()
            || !self.nodes_named(name).is_empty()
            || !self.nodes_of_support(name).is_empty()
    }

    /// The names of parts and of the nodes of the file.
    pub fn place_names(&self) -> impl Iterator<Item = &str> {
        let nodes = self.model.geometry().names.iter().take(self.n_nodes());
        self.parts.iter().map(|p| p.name.as_str()).chain(nodes.map(String::as_str))
    }
}
