//! Which elements stand on nodes that parameters move, and what must not.

use super::axes::default_near_z;
use crate::model::affine::Affine;
use crate::model::geometry::{Geometry, Place, still};
use crate::model::moving::{EndMotion, Moving, expressions};
use crate::model::parameter::ParameterSet;
use crate::model::placed_element::PlacedElement;
use crate::model::spec::ModelSpec;
use crate::yaml::{Problem, child};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Nodes that move, and the nodes of the rigid bodies that they are of.
struct Moves<'a> {
    geometry: &'a Geometry,
    nominal: Vec<f64>,
    /// Slave -> master, of links in all directions.
    master: BTreeMap<usize, usize>,
}

impl Moves<'_> {
    /// How far a node moves from where it stands at the estimates.
    fn step(&self, node: usize) -> Place {
        match self.geometry.moving(node) {
            Some(place) => place.clone().map(|c| {
                let there = c.at(&self.nominal);
                c.plus(-1.0, &Affine::constant(there))
            }),
            None => still([0.0; 3]),
        }
    }

    /// The node that carries it: the last master of its links.
    fn carrier(&self, mut node: usize) -> usize {
        let mut left = self.master.len();
        while let Some(&master) = self.master.get(&node).filter(|_| left > 0) {
            (node, left) = (master, left - 1);
        }
        node
    }

    fn end(&self, node: usize) -> EndMotion {
        let carried = self.step(self.carrier(node));
        let own = self.step(node);
        let beside = [0, 1, 2].map(|i| own[i].plus(-1.0, &carried[i]));
        EndMotion { carried: expressions(carried), beside: expressions(beside) }
    }

    /// Whether a node moves, or what carries it.
    fn moves(&self, node: usize) -> bool {
        self.geometry.moving(node).is_some() || self.geometry.moving(self.carrier(node)).is_some()
    }

    /// Whether a node moves against what carries it.
    fn has_other_arm(&self, node: usize) -> bool {
        self.apart(node, self.carrier(node))
    }

    /// Whether two nodes move differently.
    fn apart(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.step(a), self.step(b));
        a.iter().zip(&b).any(|(a, b)| !a.plus(-1.0, b).terms.is_empty())
    }
}

/// Lets elements follow nodes that parameters move; how these move.
///
/// Errors: what a node that moves is not allowed to carry.
pub(super) fn follow(
    spec: &ModelSpec,
    geometry: &Geometry,
    parameters: &ParameterSet,
    elements: &mut [PlacedElement],
    problems: &mut Vec<Problem>,
) -> BTreeMap<usize, EndMotion> {
    if geometry.moving_nodes().next().is_none() {
        return BTreeMap::new();
    }
    let mut master = BTreeMap::new();
    for link in spec.rigid_links.values().filter(|l| l.dofs.as_ref().is_none_or(|d| d.len() == 6)) {
        let of = |slave: &String| Some((geometry.node(slave)?, geometry.node(&link.master)?));
        master.extend(link.slaves.iter().filter_map(of));
    }
    let moves = Moves { geometry, nominal: parameters.nominal(), master };
    refuse(spec, &moves, problems);
    for element in elements {
        if !element.joined().iter().any(|&n| moves.moves(n)) {
            continue;
        }
        if element.matrices.is_some() || element.nodes.len() > 2 {
            let what = if element.matrices.is_some() { "matrices of another solver" } else { "a shell or a solid" };
            let node = element.joined().iter().copied().find(|&n| moves.moves(n)).unwrap_or_default();
            let name = &geometry.names[node];
            let text = format!("node `{name}` stands where a parameter says, and carries {what}: these stay");
            if !problems.iter().any(|p| p.path == element.path) {
                problems.push(Problem::error(&element.path, text));
            }
            continue;
        }
        let ends = element.nodes.iter().map(|&n| moves.end(n)).collect();
        let near = element.orientation.unwrap_or_else(|| default_near_z(element.axes[0]));
        element.moving = Some(Arc::new(Moving::new(ends, near)));
    }
    (0..geometry.names.len()).filter(|&n| moves.moves(n)).map(|n| (n, moves.end(n))).collect()
}

/// Refuses links, constraints and supports whose arms at the estimates stand in their equations.
fn refuse(spec: &ModelSpec, moves: &Moves<'_>, problems: &mut Vec<Problem>) {
    let node = |name: &String| moves.geometry.node(name);
    let mut refuse = |path: String, name: &str, why: &str| {
        problems.push(Problem::error(
            path,
            format_args!("node `{name}` has a coordinate that a parameter moves, and {why}"),
        ));
    };
    let part = |a: &String, b: &String| node(a).zip(node(b)).is_some_and(|(a, b)| moves.apart(a, b));
    for (name, link) in &spec.rigid_links {
        let is_partial = link.dofs.as_ref().is_some_and(|d| d.len() < 6);
        if let Some(slave) = link.slaves.iter().find(|slave| is_partial && part(&link.master, slave)) {
            let why = "a rigid link in some directions has a fixed arm: link all six, or let both ends move alike";
            refuse(child("rigid_links", name), slave, why);
        }
    }
    for (name, link) in &spec.weighted_links {
        if let Some(other) = link.of.iter().flat_map(|set| &set.nodes).find(|other| part(&link.node, other)) {
            refuse(child("weighted_links", name), other, "a weighted link has fixed arms");
        }
    }
    for (name, tie) in &spec.ties {
        if let Some(other) = tie.nodes.iter().find(|n| node(n).is_some_and(|n| moves.moves(n))) {
            refuse(child("ties", name), other, "a tie has fixed arms");
        }
    }
    let on_an_arm = |name: &&String| node(name).is_some_and(|n| moves.has_other_arm(n));
    let why = "hangs on a rigid link whose arm changes with it: hold or constrain the master instead";
    for (name, constraint) in &spec.constraints {
        if let Some(other) = constraint.terms.iter().map(|t| &t.node).find(on_an_arm) {
            refuse(child("constraints", name), other, why);
        }
    }
    for (name, support) in &spec.supports {
        if let Some(other) = support.node.iter().chain(support.nodes.iter().flatten()).find(on_an_arm) {
            refuse(child("supports", name), other, why);
        }
    }
}
