//! Which nodes hang together.

use super::ParametricModel;
use super::compile::Model;
use crate::element::Dof;
use std::collections::{HashMap, HashSet};

/// Nodes joined by elements, rigid links and constraints, and to the ground by supports and springs.
#[derive(Debug)]
pub(crate) struct Joined {
    /// A node of the same body, by node; the last is the ground.
    body: Vec<usize>,
    held: Vec<bool>,
    /// Whether a support holds some of its dofs.
    supported: Vec<bool>,
}

impl Joined {
    /// * `without` - elements that are left out
    pub(crate) fn new(model: &Model, without: &[usize]) -> Self {
        let n = model.geometry().names.len();
        let mut joined = Self { body: (0..=n).collect(), held: vec![false; n], supported: vec![false; n] };
        let without: HashSet<usize> = without.iter().copied().collect();
        let nominal = model.parameters().nominal();
        let is_stiff = |e: usize| model.element_matrices(e, &nominal).is_ok_and(|m| !m.stiffness.is_zero());
        for (e, element) in model.elements().iter().enumerate().filter(|(e, _)| !without.contains(e)) {
            joined.join(&element.joined());
            // A spring of one node stands on the ground, a mass on nothing.
            if element.nodes.len() == 1 && element.matrices.is_none() && is_stiff(e) {
                joined.join(&[n, element.nodes[0]]);
            }
        }
        let index = |name: &String| model.geometry().node(name);
        for link in model.spec().rigid_links.values() {
            let nodes: Vec<usize> = std::iter::once(&link.master).chain(&link.slaves).filter_map(index).collect();
            joined.join(&nodes);
        }
        for link in model.spec().weighted_links.values() {
            let nodes: Vec<usize> = link.nodes().filter_map(index).collect();
            joined.join(&nodes);
        }
        // Nodes of ties, and the points on the leading side of their springs.
        let springs = model.spec().ties.keys().filter_map(|tie| model.element_set(tie)).flatten();
        let points = springs.flat_map(|&e| model.elements()[e].nodes.iter().copied());
        for node in model.spec().ties.values().flat_map(|t| &t.nodes).filter_map(index).chain(points) {
            joined.join(&[&[node], &model.dof_map().led_by(node)[..]].concat());
        }
        for constraint in model.spec().constraints.values() {
            let nodes: Vec<usize> = constraint.terms.iter().filter_map(|t| index(&t.node)).collect();
            joined.join(&nodes);
        }
        let stands =
            |&n: &usize| [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().all(|d| model.dof_map().express(n, d).is_empty());
        for support in model.spec().supports.values() {
            let holds = support.fixed.as_ref().is_none_or(|all| !all.is_empty());
            for node in support.nodes().filter_map(index) {
                joined.supported[node] |= holds;
                if stands(&node) {
                    joined.join(&[n, node]);
                }
            }
        }
        joined
    }

    fn join(&mut self, nodes: &[usize]) {
        for &node in nodes {
            if let Some(held) = self.held.get_mut(node) {
                *held = true;
            }
            let (a, b) = (self.shortened(nodes[0]), self.shortened(node));
            self.body[b] = a;
        }
    }

    /// The node that stands for the body of a node.
    fn root(&self, mut node: usize) -> usize {
        while self.body[node] != node {
            node = self.body[node];
        }
        node
    }

    /// [`Self::root`], and a shorter way to it for the next time.
    fn shortened(&mut self, mut node: usize) -> usize {
        while self.body[node] != node {
            self.body[node] = self.body[self.body[node]];
            node = self.body[node];
        }
        node
    }

    /// Whether anything holds a node.
    pub(crate) fn is_held(&self, node: usize) -> bool {
        self.held[node]
    }

    /// Whether two nodes belong to one body.
    pub(crate) fn are_joined(&self, a: usize, b: usize) -> bool {
        self.root(a) == self.root(b)
    }

    /// Nodes of every body that hangs on nothing, by body: not on the largest, which is the one on the ground where there is a
    /// ground, and on no support, not even one of some dofs.
    pub(crate) fn apart(&self) -> Vec<Vec<usize>> {
        let ground = self.body.len() - 1;
        let mut bodies: Vec<(usize, Vec<usize>)> = Vec::new();
        let mut place_of: HashMap<usize, usize> = HashMap::new();
        for node in (0..ground).filter(|&n| self.held[n]) {
            let root = self.root(node);
            let place = *place_of.entry(root).or_insert(bodies.len());
            if place == bodies.len() {
                bodies.push((root, Vec::new()));
            }
            bodies[place].1.push(node);
        }
        let main = bodies
            .iter()
            .enumerate()
            .max_by_key(|(k, (root, nodes))| (*root == self.root(ground), nodes.len(), std::cmp::Reverse(*k)));
        if let Some(main) = main.map(|(k, _)| k) {
            bodies.remove(main);
        }
        let is_free = |nodes: &Vec<usize>| !nodes.iter().any(|&n| self.supported[n]);
        bodies.into_iter().map(|(_, nodes)| nodes).filter(is_free).collect()
    }
}
