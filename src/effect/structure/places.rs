//! Places for effects: nodes, parts and ends with a property, symmetric partners together before each alone.

use super::{End, Joint, Part, PartKind, Structure};
use crate::effect::location::{ABOUT, ALL_AXES, BENDING, Location, LocationKind};
use crate::element::Dof;
use crate::model::PlacedElement;
use indexmap::IndexMap;
use std::collections::{HashMap, HashSet};

/// Cosine from which an axis of a member is one of the structure: 2.6 degrees, which no test tells apart.
const PARALLEL: f64 = 0.999;

impl Structure<'_> {
    /// Nodes with a property, symmetric partners together before each alone: those of the file, and where places are wider those inside of its
    /// elements.
    pub(in crate::effect) fn nodes(&self, accept: impl Fn(usize) -> bool) -> Vec<Location> {
        if self.is_wider {
            return self.these_nodes(&self.inner_nodes(), accept, |_, _| true);
        }
        self.nodes_of_file(accept)
    }

    /// Nodes of the file with a property, symmetric partners together before each alone, however wide places are.
    pub(in crate::effect) fn nodes_of_file(&self, accept: impl Fn(usize) -> bool) -> Vec<Location> {
        self.these_nodes(&self.sites(), accept, |_, _| true)
    }

    /// Nodes of the file, and those of superelements and of a mesh at which effects are looked for.
    pub(super) fn sites(&self) -> Vec<usize> {
        let further: HashSet<usize> = self.further_nodes().collect();
        (0..self.n_nodes()).filter(|n| self.model.is_site(*n) || further.contains(n)).collect()
    }

    /// Nodes in each direction in which an effect can act on them; where places are wider, those inside of elements, and those of the file with
    /// several directions in all of them at once.
    ///
    /// * `acts` - whether it can act on a node in a direction
    pub(in crate::effect) fn nodes_along(&self, dofs: &[Dof], acts: impl Fn(usize, Dof) -> bool) -> Vec<Location> {
        let axes = |n: usize| -> Vec<Dof> { dofs.iter().copied().filter(|&dof| acts(n, dof)).collect() };
        let along = |&dof: &Dof| self.nodes(|n| acts(n, dof)).into_iter().map(move |at| at.along(dof.name()));
        dofs.iter().flat_map(along).chain(self.nodes_along_all(axes)).collect()
    }

    /// Where places are wider, nodes of the file with several axes, in all of them at once.
    ///
    /// * `axes` - those of a node
    pub(in crate::effect) fn nodes_along_all<A: PartialEq>(&self, axes: impl Fn(usize) -> Vec<A>) -> Vec<Location> {
        if !self.is_wider {
            return Vec::new();
        }
        let all = self.these_nodes(&self.sites(), |n| axes(n).len() > 1, |a, b| axes(a) == axes(b));
        all.into_iter().map(|at| at.along(ALL_AXES)).collect()
    }

    /// The directions of a location of [`Self::nodes_along`].
    pub(in crate::effect) fn axes_at(
        &self,
        at: &Location,
        dofs: &[Dof],
        acts: impl Fn(usize, Dof) -> bool,
    ) -> Vec<Dof> {
        let node = at.names.first().and_then(|name| self.model.geometry().node(name));
        let acts = |&dof: &Dof| at.is_along(dof) && node.is_some_and(|n| acts(n, dof));
        dofs.iter().copied().filter(acts).collect()
    }

    /// Some of these nodes, symmetric partners together before each alone.
    ///
    /// * `alike` - whether what is at a node and at its partner can share parameters
    fn these_nodes(
        &self,
        nodes: &[usize],
        accept: impl Fn(usize) -> bool,
        alike: impl Fn(usize, usize) -> bool,
    ) -> Vec<Location> {
        let listed: HashSet<usize> = nodes.iter().copied().collect();
        let partner = |i: usize| self.node_partner[i].filter(|&j| listed.contains(&j) && accept(j) && alike(i, j));
        arrange(nodes.iter().copied().filter(|&i| accept(i)), partner)
            .into_iter()
            .map(|nodes| {
                let names = nodes.into_iter().map(|n| self.node_name(n).to_string()).collect();
                Location::new(LocationKind::Node, names)
            })
            .collect()
    }

    /// Parts with a property, symmetric partners together before each alone; cuts are none of them.
    pub(in crate::effect) fn places(&self, accept: impl Fn(&Part) -> bool) -> Vec<Location> {
        self.these_parts(|p| p.kind != PartKind::Cut && accept(p))
    }

    /// Where places are wider, cuts through shells that deform, symmetric partners together before each alone.
    pub(in crate::effect) fn cuts(&self) -> Vec<Location> {
        self.these_parts(|p| p.kind == PartKind::Cut && p.elements.iter().any(|&e| self.deforms(e)))
    }

    /// Point masses in each direction in which an effect can act on them; where places are wider, those with several directions in all of them at once.
    ///
    /// * `acts` - whether it can act on a mass in a direction
    pub(in crate::effect) fn masses_along(&self, dofs: &[Dof], acts: impl Fn(&Part, Dof) -> bool) -> Vec<Location> {
        let masses = |accept: &dyn Fn(&Part) -> bool| arranged(&self.parts, |p| p.kind == PartKind::Mass && accept(p));
        if self.is_wider {
            let several = masses(&|p| dofs.iter().filter(|&&dof| acts(p, dof)).nth(1).is_some());
            return several.into_iter().map(|at| at.along(ALL_AXES)).collect();
        }
        let along = |&dof: &Dof| masses(&|p| acts(p, dof)).into_iter().map(move |at| at.along(dof.name()));
        dofs.iter().flat_map(along).collect()
    }

    fn these_parts(&self, accept: impl Fn(&Part) -> bool) -> Vec<Location> {
        arranged(if self.is_wider { &self.spans } else { &self.parts }, accept)
    }

    /// Whole members of beams with a property.
    pub(in crate::effect) fn members(&self, accept: impl Fn(&Part) -> bool) -> Vec<Location> {
        self.places(|p| p.is_member && accept(p))
    }

    /// Held dofs of nodes where a member goes on, or several members meet, direction by direction, and where places are wider in all of them at once;
    /// symmetric partners together before each alone.
    pub(in crate::effect) fn shared_supports(&self) -> Vec<Location> {
        let holds = |n: usize, dof: Dof| self.is_shared_support(n, dof);
        self.nodes_along(&Dof::ALL, holds)
    }

    /// Whether a node is held in a direction where a member goes on, or several members meet.
    pub(in crate::effect) fn is_shared_support(&self, n: usize, dof: Dof) -> bool {
        if self.node_moves(n, dof) || !self.any_node_moves(dof) || self.generalised_stiffness(dof) <= 0.0 {
            return false;
        }
        let (model, spec) = (self.model, self.model.spec());
        let name = &model.geometry().names[n];
        let is_linked = || {
            let by_link = spec.rigid_links.values().any(|l| l.master == *name || l.slaves.contains(name));
            let by_weight = spec.weighted_links.values().any(|l| l.nodes().any(|n| n == name));
            let by_tie = spec.ties.values().any(|t| t.nodes.contains(name));
            by_link || by_weight || by_tie || spec.constraints.values().any(|c| c.terms.iter().any(|t| t.node == *name))
        };
        let is_of_body = || self.on(n).any(|(_, e)| e.matrices.is_some());
        spec.supports.values().any(|s| s.holds(dof) && s.nodes().any(|n| n == name))
            && (is_linked() || (self.has_several(n) || is_of_body()) && self.resists(n, dof))
    }

    /// Nodes that rigid links carry and where a member goes on, or several members meet, direction by direction, symmetric partners together before
    /// each alone: of one end alone the end gives.
    pub(in crate::effect) fn shared_links(&self) -> Vec<Location> {
        if self.is_wider {
            return Vec::new();
        }
        let mut carried: Vec<[bool; 6]> = vec![[false; 6]; self.model.geometry().names.len()];
        for (slave, link) in self.model.spec().rigid_links.values().flat_map(|l| l.slaves.iter().map(move |s| (s, l))) {
            if let Some(node) = self.model.geometry().node(slave) {
                Dof::ALL.into_iter().filter(|dof| link.holds(*dof)).for_each(|dof| carried[node][dof as usize] = true);
            }
        }
        let mut all = Vec::new();
        for dof in Dof::ALL.into_iter().filter(|&d| self.any_node_moves(d) && self.generalised_stiffness(d) > 0.0) {
            let accept = |n: usize| carried[n][dof as usize] && self.has_several(n) && self.resists(n, dof);
            all.extend(self.nodes(accept).into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    /// The node that leads one that a rigid link carries in a direction.
    pub(in crate::effect) fn leader_of(&self, slave: &str, dof: Dof) -> Option<&str> {
        let mut links = self.model.spec().rigid_links.values();
        Some(&links.find(|l| l.holds(dof) && l.slaves.iter().any(|s| s == slave))?.master)
    }

    /// Elements that are joined to a node.
    fn on(&self, node: usize) -> impl Iterator<Item = (usize, &PlacedElement)> {
        let elements = self.model.elements();
        self.elements_at_nodes()[node].iter().map(move |&e| (e, &elements[e]))
    }

    /// Whether several elements that deform meet at a node.
    fn has_several(&self, node: usize) -> bool {
        self.on(node).filter(|(e, _)| self.deforms(*e)).nth(1).is_some()
    }

    /// Whether what is at a node would resist its motion alone.
    fn resists(&self, node: usize, dof: Dof) -> bool {
        self.on(node).any(|(i, e)| {
            if let Some(matrices) = &e.matrices {
                return matrices.has_stiffness(node, dof);
            }
            let Ok(matrices) = self.model.element_matrices(i, &self.theta) else { return false };
            let k = e.nodes.iter().position(|n| *n == node).unwrap_or_default();
            let first = 6 * k + if dof.is_rotation() { 3 } else { 0 };
            let along = |i: usize| e.axes[i][dof.axis()].powi(2) * matrices.stiffness.get(first + i, first + i);
            (0..3).any(|i| along(i) > 0.0)
        })
    }

    /// Ends with a joint of a kind, direction by direction, and where places are wider about both axes of bending, in all directions and about the axes of
    /// the structure that are none of the member; symmetric partners together before each alone.
    pub(in crate::effect) fn end_places(&self, kind: Joint, dofs: &[Dof]) -> Vec<Location> {
        let gives = |i: usize, dof: Dof| {
            let end = &self.ends[i];
            end.joint[dof as usize] == Some(kind) && !(kind == Joint::Member && end.is_second)
        };
        let mut locations = Vec::new();
        let mut list = |direction: &str, accepted: &dyn Fn(usize) -> bool, alike: &dyn Fn(usize, usize) -> bool| {
            let partner = |i: usize| self.ends[i].partner.filter(|&j| accepted(j) && alike(i, j));
            for ends in arrange((0..self.ends.len()).filter(|&i| accepted(i)), partner) {
                locations.push(self.ends_location(&ends, direction));
            }
        };
        if !self.is_wider {
            for &dof in dofs {
                list(dof.name(), &|i| gives(i, dof), &|_, _| true);
            }
            return locations;
        }
        let both = [Dof::Ry, Dof::Rz];
        if both.iter().all(|dof| dofs.contains(dof)) {
            list(BENDING, &|i| both.iter().all(|&dof| gives(i, dof)), &|_, _| true);
        }
        // What holds an end in all directions is a support.
        if kind == Joint::Root {
            let all = |i: usize| dofs.iter().copied().filter(|&dof| gives(i, dof)).collect::<Vec<_>>();
            list(ALL_AXES, &|i| all(i).len() > both.len(), &|i, j| all(i) == all(j));
        }
        let turns = [Dof::Rx, Dof::Ry, Dof::Rz];
        if turns.iter().all(|dof| dofs.contains(dof)) {
            for (axis, direction) in ABOUT.iter().enumerate() {
                list(direction, &|i| turns.iter().all(|&dof| gives(i, dof)) && self.is_skew(i, axis), &|_, _| true);
            }
        }
        locations
    }

    /// Whether an axis of the structure is none of the axes of the member at an end.
    fn is_skew(&self, end: usize, axis: usize) -> bool {
        self.model.elements()[self.ends[end].element].axes.iter().all(|own| own[axis].abs() < PARALLEL)
    }

    /// Both ends of a member where it has a joint of a kind at each, direction by direction, symmetric partners together before each alone.
    pub(in crate::effect) fn both_ends(&self, kind: Joint, dofs: &[Dof]) -> Vec<Location> {
        if self.is_wider {
            return Vec::new();
        }
        let elements = self.model.elements();
        // The two ends of every member; an element is of the first kind that has it.
        let ends_of = |kinds: &[PartKind]| -> Vec<[usize; 2]> {
            let mut member_of: Vec<Option<usize>> = vec![None; elements.len()];
            for of in kinds {
                for (p, part) in self.parts.iter().enumerate().filter(|(_, part)| part.kind == *of) {
                    part.elements.iter().for_each(|&e| member_of[e] = member_of[e].or(Some(p)));
                }
            }
            let mut ends: IndexMap<usize, Vec<usize>> = IndexMap::new();
            for (i, end) in self.ends.iter().enumerate() {
                let Some(member) = member_of[end.element] else { continue };
                let touching = self.parts[member].elements.iter().filter(|&&e| elements[e].nodes.contains(&end.node));
                if touching.count() == 1 {
                    ends.entry(member).or_default().push(i);
                }
            }
            ends.into_values().filter_map(|ends| ends.try_into().ok()).collect()
        };
        // Where two members meet, the end that the joint is listed at.
        let listed_at = |i: usize| {
            let is_there = |other: &End| other.node == self.ends[i].node && !other.is_second;
            if self.ends[i].is_second { self.ends.iter().position(is_there).unwrap_or(i) } else { i }
        };
        // Mirror images of each other are listed as such.
        let are_images = |[a, b]: [usize; 2]| self.ends[listed_at(a)].partner == Some(listed_at(b));
        // A member of several elements may be a line that the file has in pairs.
        let mut members = ends_of(&[PartKind::Chain, PartKind::Element]);
        let of_lines = ends_of(&[PartKind::Line]).into_iter().filter(|ends| !members.contains(ends));
        members.extend(of_lines.collect::<Vec<_>>());
        members.retain(|&ends| !are_images(ends));
        let member_at: HashMap<[usize; 2], usize> = members.iter().enumerate().map(|(m, ends)| (*ends, m)).collect();
        let partner = |m: usize| {
            let [a, b] = members[m].map(|i| self.ends[i].partner);
            let [a, b] = [a?, b?];
            member_at.get(&[a.min(b), a.max(b)]).copied().filter(|&other| other != m)
        };
        let mut locations = Vec::new();
        for &dof in dofs {
            let gives = |m: usize| members[m].iter().all(|&i| self.ends[i].joint[dof as usize] == Some(kind));
            for of in arrange((0..members.len()).filter(|&m| gives(m)), partner) {
                let ends: Vec<usize> = of.into_iter().flat_map(|m| members[m]).collect();
                locations.push(self.ends_location(&ends, dof.name()));
            }
        }
        locations
    }

    fn ends_location(&self, ends: &[usize], direction: &str) -> Location {
        let names = ends.iter().map(|&i| self.end_name(&self.ends[i])).collect();
        Location::new(LocationKind::End, names).along(direction)
    }
}

/// Parts with a property, symmetric partners together before each alone.
fn arranged(parts: &[Part], accept: impl Fn(&Part) -> bool) -> Vec<Location> {
    let accepted = |i: &usize| accept(&parts[*i]);
    let partner = |i: usize| parts[i].partner.filter(|j| accepted(j));
    arrange((0..parts.len()).filter(accepted), partner)
        .into_iter()
        .map(|at| {
            let kind = match parts[at[0]].kind {
                PartKind::Element => LocationKind::Element,
                PartKind::Chain | PartKind::Line | PartKind::Span | PartKind::Cut => LocationKind::Chain,
                PartKind::Group => LocationKind::Group,
                PartKind::Mass => LocationKind::Mass,
            };
            Location::new(kind, at.into_iter().map(|p| parts[p].name.clone()).collect())
        })
        .collect()
}

/// Items with their partners first, then each of them alone; an item without a partner stands alone.
pub(super) fn arrange(items: impl Iterator<Item = usize>, partner: impl Fn(usize) -> Option<usize>) -> Vec<Vec<usize>> {
    let mut out = Vec::new();
    for i in items {
        if let Some(j) = partner(i).filter(|j| *j > i) {
            out.push(vec![i, j]);
        }
        out.push(vec![i]);
    }
    out
}
