//! Ends of beams that lie inside something: a joint with members of other directions, a link, a body, a support.

use super::Structure;
use super::places::arrange;
use crate::effect::location::{Location, LocationKind};
use crate::element::Dof;
use crate::model::dot;
use std::collections::HashMap;

/// Cosine of the angle between two members above which one goes on where the other ends.
const STRAIGHT: f64 = 0.999;

/// An end of a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::effect) struct JointEnd {
    /// The element.
    pub element: usize,
    /// Its end, 1 or 2.
    pub side: usize,
    /// The node.
    pub node: usize,
}

impl Structure<'_> {
    /// Ends of beams that bend, at nodes of the file where they are held, where members of other directions meet, or where they end in a body.
    pub(in crate::effect) fn joint_ends(&self) -> &[JointEnd] {
        self.joint_ends.get_or_find(|| self.list_joint_ends())
    }

    fn list_joint_ends(&self) -> Vec<JointEnd> {
        let elements = self.model.elements();
        let (at, linked) = (self.elements_at_nodes(), self.linked());
        let mut member_of: Vec<Option<usize>> = vec![None; elements.len()];
        for (p, part) in self.parts.iter().enumerate().filter(|(_, p)| p.is_member) {
            part.elements.iter().for_each(|&e| member_of[e] = member_of[e].or(Some(p)));
        }
        let bends = |e: usize| self.is_beam(e) && (self.strains(e, Dof::Ry) || self.strains(e, Dof::Rz));
        let mut ends = Vec::new();
        for (i, e) in elements.iter().enumerate().filter(|(i, _)| bends(*i)) {
            for (k, &node) in e.nodes.iter().enumerate().filter(|(_, n)| **n < self.n_nodes()) {
                let others = || at[node].iter().copied().filter(|&j| j != i);
                let is_same = |j: usize| member_of[i].is_some() && member_of[j] == member_of[i];
                let goes_on = |&j: &usize| {
                    self.is_beam(j) && (is_same(j) || dot(elements[j].axes[0], e.axes[0]).abs() > STRAIGHT)
                };
                let crosses = |&j: &usize| self.is_beam(j) && self.deforms(j) && !goes_on(&j);
                let is_body = |j: usize| !self.is_beam(j) && (self.stiff[j] || self.heavy[j]);
                let turns = |dof: Dof| self.moves[i][6 * k + dof as usize];
                let is_held = !turns(Dof::Ry) && !turns(Dof::Rz);
                let ends_in_body =
                    || !others().any(|j| goes_on(&j)) && (linked.contains(&node) || others().any(is_body));
                if is_held || others().any(|j| crosses(&j)) || ends_in_body() {
                    ends.push(JointEnd { element: i, side: k + 1, node });
                }
            }
        }
        ends
    }

    /// `element:node` of such an end.
    pub(in crate::effect) fn joint_end_name(&self, end: &JointEnd) -> String {
        format!("{}:{}", self.element_of_file(end.element), self.node_name(end.node))
    }

    /// Such ends, symmetric partners together before each alone.
    pub(in crate::effect) fn joint_end_places(&self) -> Vec<Location> {
        if self.is_wider {
            return Vec::new();
        }
        let ends = self.joint_ends();
        let at: HashMap<(usize, usize), usize> =
            ends.iter().enumerate().rev().map(|(i, end)| ((end.element, end.node), i)).collect();
        let partner = |i: usize| {
            let (element, node) = (self.element_partner[ends[i].element]?, self.node_partner[ends[i].node]?);
            at.get(&(element, node)).copied().filter(|&j| j != i)
        };
        let name = |i: usize| self.joint_end_name(&ends[i]);
        let places = arrange(0..ends.len(), partner).into_iter();
        places.map(|at| Location::new(LocationKind::End, at.into_iter().map(name).collect())).collect()
    }
}
