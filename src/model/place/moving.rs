//! Which elements stand on nodes that parameters move, and what must not.

use super::axes::default_near_z;
use crate::element::Dof;
use crate::model::affine::Affine;
use crate::model::constraint::active;
use crate::model::geometry::{Geometry, Place, still};
use crate::model::moving::{EndMotion, Moving, expressions};
use crate::model::parameter::ParameterSet;
use crate::model::placed_element::PlacedElement;
use crate::model::spec::{DofName, ModelSpec, RigidLinkSpec, SupportSpec};
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// Nodes that move, and the nodes of the rigid bodies that they are of.
struct Moves<'a> {
    geometry: &'a Geometry,
    nominal: Vec<f64>,
    /// Slave -> master, of links in all directions.
    master: BTreeMap<usize, usize>,
    /// Nodes whose dofs ride with them.
    riding: HashSet<usize>,
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

    fn carrier(&self, node: usize) -> usize {
        carrier(&self.master, node)
    }

    fn end(&self, node: usize) -> EndMotion {
        let root = self.carrier(node);
        let rides = self.riding.contains(&root);
        EndMotion { own: expressions(self.step(node)), root: expressions(self.step(root)), rides }
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

/// Slave -> master, of links in all directions.
fn masters(spec: &ModelSpec, geometry: &Geometry) -> BTreeMap<usize, usize> {
    joined(spec, geometry, |link| link.dofs.as_ref().is_none_or(|d| d.len() == 6)).collect()
}

/// Whether a link ties all rotations that there are, so that what it joins turns as one.
fn ties_rotations(link: &RigidLinkSpec, active: [bool; 6]) -> bool {
    let mut all = [DofName::Rx, DofName::Ry, DofName::Rz].into_iter().filter(|r| active[*r as usize]);
    link.dofs.as_ref().is_none_or(|dofs| all.all(|r| dofs.contains(&r)))
}

/// (Slave, master) of some links.
fn joined<'a>(
    spec: &'a ModelSpec,
    geometry: &'a Geometry,
    which: impl Fn(&RigidLinkSpec) -> bool + 'a,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let pairs = |link: &'a RigidLinkSpec| {
        link.slaves.iter().filter_map(|slave| Some((geometry.node(slave)?, geometry.node(&link.master)?)))
    };
    spec.rigid_links.values().filter(move |link| !link.is_compliance_of_others() && which(link)).flat_map(pairs)
}

/// The node that carries another: the last master of its links.
fn carrier(master: &BTreeMap<usize, usize>, mut node: usize) -> usize {
    let mut left = master.len();
    while let Some(&next) = master.get(&node).filter(|_| left > 0) {
        (node, left) = (next, left - 1);
    }
    node
}

/// Nodes whose dofs ride with them, should parameters move them: those that are held or constrained where they stand, and those without rotations, which
/// no rigid arm can leave. What links turn as one rides together: at u + θ x a of the same arm a and the same θ on either side, the equation of such a
/// link is the same, in some directions as in all.
pub(in crate::model) fn riding(spec: &ModelSpec, geometry: &Geometry, elements: &[PlacedElement]) -> HashSet<usize> {
    let active = active(spec);
    let pinned = spec.rigid_links.values().filter(|l| !l.is_compliance_of_others() && !ties_rotations(l, active));
    let linked = pinned.flat_map(|l| std::iter::once(&l.master).chain(&l.slaves));
    let weighted = spec.weighted_links.values();
    let weighted = weighted.flat_map(|l| std::iter::once(&l.node).chain(l.of.iter().flat_map(|set| &set.nodes)));
    let constrained = spec.constraints.values().flat_map(|c| c.terms.iter().map(|t| &t.node));
    let held = spec.supports.values().flat_map(SupportSpec::nodes);
    let names = linked.chain(weighted).chain(constrained).chain(held);
    let bodies: Vec<(usize, usize)> = joined(spec, geometry, |link| ties_rotations(link, active)).collect();
    let riding = with_joined(names.filter_map(|name| geometry.node(name)).collect(), &bodies);
    let mut turning = HashSet::new();
    for element in elements.iter().filter(|e| e.matrices.is_none() && e.nodes.len() > 1) {
        let turns = |dofs: &[Dof]| [Dof::Rx, Dof::Ry, Dof::Rz].iter().all(|d| dofs.contains(d));
        turning.extend(element.nodes.iter().zip(element.kind.nodes()).filter(|(_, dofs)| turns(dofs)).map(|(n, _)| *n));
    }
    let turning = with_joined(turning, &bodies);
    riding.into_iter().chain((0..geometry.names.len()).filter(|n| !turning.contains(n))).collect()
}

/// Nodes, and all that pairs join to them.
fn with_joined(mut nodes: HashSet<usize>, pairs: &[(usize, usize)]) -> HashSet<usize> {
    loop {
        let before = nodes.len();
        for &(a, b) in pairs {
            if nodes.contains(&a) || nodes.contains(&b) {
                nodes.extend([a, b]);
            }
        }
        if nodes.len() == before {
            return nodes;
        }
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
    let riding = riding(spec, geometry, elements);
    let moves = Moves { geometry, nominal: parameters.nominal(), master: masters(spec, geometry), riding };
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
    let on_an_arm = |name: &&String| node(name).is_some_and(|n| moves.has_other_arm(n));
    let why = "hangs on a rigid link whose arm changes with it: hold, link or constrain the master instead";
    for (name, link) in &spec.rigid_links {
        let is_partial = link.dofs.as_ref().is_some_and(|d| d.len() < 6) || !link.compliance.is_empty();
        if let Some(slave) = link.slaves.iter().find(|slave| is_partial && part(&link.master, slave)) {
            let why = "a rigid link in some directions, or one that gives, has a fixed arm: link all six, or let both ends move alike";
            refuse(child("rigid_links", name), slave, why);
        } else if is_partial && on_an_arm(&&link.master) {
            refuse(child("rigid_links", name), &link.master, why);
        }
    }
    for (name, link) in &spec.weighted_links {
        let mut of = link.of.iter().flat_map(|set| &set.nodes);
        if let Some(other) = of.clone().find(|other| part(&link.node, other)) {
            refuse(child("weighted_links", name), other, "a weighted link has fixed arms");
        } else if let Some(other) = of.find(on_an_arm) {
            refuse(child("weighted_links", name), other, why);
        }
    }
    for (name, tie) in &spec.ties {
        if let Some(other) = tie.nodes.iter().find(|n| node(n).is_some_and(|n| moves.moves(n))) {
            refuse(child("ties", name), other, "a tie has fixed arms");
        }
    }
    for (name, constraint) in &spec.constraints {
        if let Some(other) = constraint.terms.iter().map(|t| &t.node).find(on_an_arm) {
            refuse(child("constraints", name), other, why);
        }
    }
    for (name, support) in &spec.supports {
        if let Some(other) = support.nodes().find(on_an_arm) {
            refuse(child("supports", name), other, why);
        }
    }
}
