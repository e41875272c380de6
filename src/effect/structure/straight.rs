//! Nodes that define the shape of a frame, and what moves with them: straight members stay straight.

use super::Structure;
use crate::effect::location::ALONE;
use crate::element::Axes;
use crate::model::spec::NodeSpec;
use crate::model::{AXES, Vector, dot, minus, plus, unit};
use std::collections::{BTreeMap, HashSet};

/// Cosine of the angle up to which a member goes straight on.
const STRAIGHT: f64 = 0.999;
/// The direction of a node inside of a straight member.
pub(in crate::effect) const ALONG: &str = "along";
/// Where more nodes than this have members in several directions, the frame is a grid: its joints are where they were drawn, and only tips and what
/// is held or heavy is looked at.
const MOST_JOINTS: usize = 200;
/// A structure is flat across an axis along which it extends by less than this part of its size.
const FLAT: f64 = 1e-6;

/// Nodes that may stand elsewhere than the file says.
pub(in crate::effect) struct Frame<'a> {
    structure: &'a Structure<'a>,
    /// Nodes that something with fixed arms holds, or a shell, a solid or a superelement.
    bound: HashSet<usize>,
    is_grid: bool,
}

impl<'a> Frame<'a> {
    pub(in crate::effect) fn of(structure: &'a Structure<'a>) -> Self {
        let (spec, geometry) = (structure.model.spec(), structure.model.geometry());
        let weighted = spec.weighted_links.values();
        let weighted = weighted.flat_map(|l| std::iter::once(&l.node).chain(l.of.iter().flat_map(|set| &set.nodes)));
        let constrained = spec.constraints.values().flat_map(|c| c.terms.iter().map(|t| &t.node));
        let tied = spec.ties.values().flat_map(|t| &t.nodes);
        let names = weighted.chain(constrained).chain(tied);
        let mut bound = structure.linked();
        bound.extend(names.filter_map(|name| geometry.node(name)));
        for element in structure.model.elements() {
            if element.matrices.is_some() || element.nodes.len() > 2 {
                bound.extend(element.joined().iter().copied());
            }
        }
        let mut frame = Self { structure, bound, is_grid: false };
        let n = spec.nodes.len();
        frame.is_grid = (0..n).filter(|&node| frame.is_joint(node)).nth(MOST_JOINTS).is_some();
        frame
    }

    /// Elements from a node to another, by what they join: the other node and the direction to it.
    fn lines(&self, node: usize) -> Vec<(usize, Vector)> {
        let all = self.structure.model.elements();
        let at = &self.structure.model.geometry().positions;
        let of = |&e: &usize| {
            let nodes = &all[e].nodes;
            let is_line = nodes.len() == 2 && all[e].kind.axes() == Axes::AlongNodes && self.structure.deforms(e);
            let other = *nodes.iter().find(|n| **n != node).filter(|_| is_line)?;
            Some((other, unit(minus(at[other], at[node]))?))
        };
        self.structure.elements_at_nodes()[node].iter().filter_map(of).collect()
    }

    /// Whether members of several directions meet at a node.
    fn is_joint(&self, node: usize) -> bool {
        let lines = self.lines(node);
        lines.iter().enumerate().any(|(i, a)| lines[..i].iter().any(|b| dot(a.1, b.1).abs() < STRAIGHT))
    }

    /// Whether something but members stands on a node or holds it, or the members on its sides differ.
    fn carries(&self, node: usize) -> bool {
        let s = self.structure;
        let all = s.model.elements();
        let here = &s.elements_at_nodes()[node];
        let lines: Vec<usize> = here.iter().copied().filter(|&e| all[e].nodes.len() == 2 && s.deforms(e)).collect();
        let differ = lines.windows(2).any(|pair| all[pair[0]].values != all[pair[1]].values);
        let more = here.iter().any(|e| !lines.contains(e) && (s.heavy[*e] || s.stiff[*e]));
        more || differ || s.is_supported(node)
    }

    /// The next node straight on from one that was reached in a direction, where that is no joint and carries no support.
    fn straight_on(&self, node: usize, from: usize, along: Vector) -> Option<usize> {
        if self.bound.contains(&node) || self.structure.is_supported(node) {
            return None;
        }
        let lines = self.lines(node);
        let ahead = lines.iter().find(|(other, _)| *other != from).filter(|_| lines.len() == 2)?;
        (dot(ahead.1, along) > STRAIGHT).then_some(ahead.0)
    }

    /// How far nodes of the file go with one that goes a step: itself, and what lies inside of its members, by the distance from their other ends; alone
    /// means across these members only, which stay straight so. And the length of the shortest of these members, m, or what is left of one.
    fn carried(&self, node: usize, step: Vector, is_alone: bool) -> (BTreeMap<usize, Vector>, f64) {
        let at = &self.structure.model.geometry().positions;
        let n_file = self.structure.model.spec().nodes.len();
        let (mut moves, mut shortest) = (BTreeMap::from([(node, step)]), f64::INFINITY);
        for (mut next, along) in self.lines(node) {
            let (mut from, mut inside) = (node, Vec::new());
            while let Some(ahead) = self.straight_on(next, from, along).filter(|a| *a != node) {
                inside.push(next);
                (from, next) = (next, ahead);
            }
            let distance = |n: usize| dot(minus(at[n], at[node]), along);
            let length = distance(next);
            shortest = shortest.min(length);
            let own = if is_alone { plus(step, -dot(step, along), along) } else { step };
            for inner in inside.into_iter().filter(|&n| n < n_file) {
                if is_alone {
                    shortest = shortest.min(distance(inner));
                }
                let moved = moves.entry(inner).or_default();
                *moved = plus(*moved, 1.0 - distance(inner) / length, own);
            }
        }
        (moves, shortest)
    }

    /// What moves where a node is moved in a direction: nodes of the file with how far each goes, global, for a size of one; and how large that may be,
    /// m. `None` where the place of the node in that direction defines nothing.
    ///
    /// * `direction` - an axis; one of [`ALONE`]; or [`ALONG`], for a node inside of a straight member on which something stands
    pub(in crate::effect) fn moved(&self, node: usize, direction: &str) -> Option<(BTreeMap<usize, Vector>, f64)> {
        let s = self.structure;
        let at = &s.model.geometry().positions;
        let is_of_file = matches!(s.model.spec().nodes.get_index(node), Some((_, entry)) if can_shift(entry));
        if !is_of_file || self.bound.contains(&node) {
            return None;
        }
        let lines = self.lines(node);
        let first = lines.first()?;
        let is_inside = lines.len() > 1 && lines.iter().all(|l| dot(l.1, first.1).abs() > STRAIGHT);
        if is_inside != (direction == ALONG) {
            return None;
        }
        if is_inside {
            // Past its neighbours, where that changes anything.
            let distance = |l: &(usize, Vector)| dot(minus(at[l.0], at[node]), l.1);
            let room = lines.iter().map(distance).fold(f64::INFINITY, f64::min);
            // Towards the end of the axis that the member leads along most.
            let most = (0..3).fold(0, |m, i| if first.1[i].abs() > first.1[m].abs() + FLAT { i } else { m });
            let along = first.1.map(|v| v * first.1[most].signum());
            return self.carries(node).then(|| (BTreeMap::from([(node, along)]), room));
        }
        let alone = ALONE.iter().position(|a| *a == direction);
        let axis = AXES.iter().position(|a| *a == direction).or(alone)?;
        let over = |f: fn(f64, f64) -> f64, start: f64| at.iter().map(|p| p[axis]).fold(start, f);
        let width = over(f64::max, f64::NEG_INFINITY) - over(f64::min, f64::INFINITY);
        if width < FLAT * s.extent || self.is_grid && lines.len() > 1 && !self.carries(node) {
            return None;
        }
        let step = [0, 1, 2].map(|i| if i == axis { 1.0 } else { 0.0 });
        let with_those_inside = self.carried(node, step, false);
        if alone.is_none() {
            return Some(with_those_inside);
        }
        // Where it is another move.
        let own = self.carried(node, step, true);
        let differs = |(n, step): (&usize, &Vector)| {
            let left = minus(*step, with_those_inside.0[n]);
            dot(left, left) > FLAT * FLAT
        };
        own.0.iter().any(differs).then_some(own)
    }

    /// Moves of the mirror images of nodes.
    pub(in crate::effect) fn mirrored(&self, moves: &BTreeMap<usize, Vector>) -> Option<BTreeMap<usize, Vector>> {
        let s = self.structure;
        let image = |v: &Vector| [0, 1, 2].map(|i| if s.mirrors(i) { -v[i] } else { v[i] });
        moves.iter().map(|(&n, v)| Some((s.node_partner[n]?, image(v)))).collect()
    }

    /// Whether the rule of a node places it by one of these, or by what is so placed.
    pub(in crate::effect) fn follows(&self, node: usize, of: &BTreeMap<usize, Vector>) -> bool {
        let (spec, geometry) = (self.structure.model.spec(), self.structure.model.geometry());
        let (mut open, mut known) = (vec![node], HashSet::from([node]));
        while let Some(n) = open.pop() {
            let Some((_, NodeSpec::Rule(rule))) = spec.nodes.get_index(n) else { continue };
            let named = rule.mirror.iter().chain(&rule.from).chain(rule.between.iter().flatten());
            for leader in named.filter_map(|name| geometry.node(name)) {
                if of.contains_key(&leader) {
                    return true;
                }
                if known.insert(leader) {
                    open.push(leader);
                }
            }
        }
        false
    }

    /// Whether nodes can be moved without what their rules carry along breaking anything or being moved unasked: what follows is no mirror image
    /// but of this set, and nothing with fixed arms.
    pub(in crate::effect) fn stands_alone(&self, moved: &BTreeMap<usize, Vector>, own: &HashSet<usize>) -> bool {
        let spec = self.structure.model.spec();
        (0..spec.nodes.len()).filter(|n| !moved.contains_key(n) && self.follows(*n, moved)).all(|n| {
            let is_image = matches!(spec.nodes.get_index(n), Some((_, NodeSpec::Rule(r))) if r.mirror.is_some());
            !self.bound.contains(&n) && (!is_image || own.contains(&n))
        })
    }
}

/// Whether the place of a node is stated by the file.
fn can_shift(entry: &NodeSpec) -> bool {
    match entry {
        NodeSpec::At(_) => true,
        NodeSpec::Rule(r) => r.coordinate.is_none() && r.mesh.is_none() && r.nearest.is_none(),
    }
}
