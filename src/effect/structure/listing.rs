//! The lists of a structure: mirror images, named parts, ends of members.

use super::{End, Joint, Part, PartKind, Structure};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

impl Structure<'_> {
    pub(super) fn list_parts(&self) -> Vec<Part> {
        let spec = self.model.spec();
        let mut parts: Vec<Part> = Vec::new();
        let mut push = |name: &str, kind: PartKind, is_whole: bool| {
            if let Some(elements) = self.model.element_set(name) {
                let beams = elements.iter().all(|&e| self.is_beam(e));
                let is_member = beams
                    && match kind {
                        PartKind::Chain => true,
                        PartKind::Element => is_whole,
                        PartKind::Group => self.path(elements).is_some(),
                        PartKind::Line | PartKind::Span | PartKind::Cut | PartKind::Mass => false,
                    };
                let (name, elements) = (name.to_string(), elements.to_vec());
                parts.push(Part { of: vec![name.clone()], name, kind, elements, partner: None, is_member });
            }
        };
        for (name, member) in spec.beams.iter().chain(&spec.bars) {
            let (count, kind) = match (&member.chain, &member.pairs) {
                (Some(chain), _) => (chain.len().saturating_sub(1), PartKind::Chain),
                (_, Some(pairs)) => (pairs.len(), PartKind::Group),
                _ => (0, PartKind::Element),
            };
            if count != 1 {
                push(name, kind, true);
            }
            (1..=count).for_each(|i| push(&format!("{name}.{i}"), PartKind::Element, count == 1));
        }
        for name in spec.springs.keys().chain(spec.bushings.keys()).chain(spec.elements.keys()) {
            push(name, PartKind::Element, false);
        }
        // Elements of a tie are its springs, where it has some.
        spec.ties.keys().for_each(|name| push(name, PartKind::Group, false));
        for (name, mass) in &spec.masses {
            match &mass.nodes {
                Some(nodes) => (1..=nodes.len()).for_each(|i| push(&format!("{name}.{i}"), PartKind::Mass, false)),
                None => push(name, PartKind::Mass, false),
            }
        }
        for (name, superelement) in &spec.superelements {
            let terms = superelement.term_names();
            push(name, if terms.is_empty() { PartKind::Element } else { PartKind::Group }, false);
            for term in terms {
                push(&format!("{name}.{term}"), PartKind::Element, false);
            }
        }
        let of_mesh = self.model.mesh_parts().iter().chain(self.model.mesh_sets()).chain(self.model.patches());
        of_mesh.for_each(|name| push(name, PartKind::Group, false));
        spec.groups.keys().for_each(|name| push(name, PartKind::Group, true));
        // A group of the same elements as a part before it is the same place; so is a line that has a name.
        parts.extend(self.list_lines());
        parts.extend(self.list_groups());
        let mut seen = BTreeSet::new();
        let has_others = |p: &Part| matches!(p.kind, PartKind::Group | PartKind::Line);
        parts.retain(|p| !p.elements.is_empty() && (seen.insert(sorted(&p.elements)) || !has_others(p)));
        self.pair_up(&mut parts);
        // So is a group, or a line, of two partners.
        let pairs: Vec<Vec<usize>> = parts
            .iter()
            .filter_map(|p| p.partner.map(|j| sorted(&[&p.elements[..], &parts[j].elements[..]].concat())))
            .collect();
        let is_pair = |p: &Part| has_others(p) && p.partner.is_none() && pairs.contains(&sorted(&p.elements));
        let kept: Vec<bool> = parts.iter().map(|p| !is_pair(p)).collect();
        let moved: Vec<usize> = kept
            .iter()
            .scan(0, |n, k| {
                let i = *n;
                *n += usize::from(*k);
                Some(i)
            })
            .collect();
        let mut keep = kept.iter();
        parts.retain(|_| keep.next() == Some(&true));
        for p in &mut parts {
            p.partner = p.partner.map(|j| moved[j]);
        }
        parts
    }

    /// Finds the mirror image of every part among the others.
    pub(super) fn pair_up(&self, parts: &mut [Part]) {
        let of: BTreeMap<Vec<usize>, usize> =
            parts.iter().enumerate().rev().map(|(i, p)| (sorted(&p.elements), i)).collect();
        for i in 0..parts.len() {
            let image: Option<Vec<usize>> = parts[i].elements.iter().map(|&e| self.element_partner[e]).collect();
            let partner = image.and_then(|image| of.get(&sorted(&image)).copied());
            parts[i].partner =
                partner.filter(|&j| j != i && parts[j].kind == parts[i].kind && apart(&parts[i], &parts[j]));
        }
    }

    pub(super) fn list_ends(&self) -> Vec<End> {
        let elements = self.model.elements();
        let at = self.elements_at_nodes();
        let linked = self.linked();
        let mut ends = Vec::new();
        for (i, e) in elements.iter().enumerate().filter(|(i, _)| self.is_beam(*i) && self.deforms(*i)) {
            for (k, &node) in e.nodes.iter().enumerate().filter(|(_, n)| self.model.can_be_a_joint(**n)) {
                let members = || at[node].iter().copied().filter(|&j| self.is_beam(j) && self.deforms(j));
                let meets = members().count() > 1;
                // Of two members that meet, one joint says it all.
                let is_second = members().count() == 2 && members().next() != Some(i);
                let carries = members().count() == 1
                    && at[node].iter().any(|&j| j != i && !self.is_beam(j) && (self.heavy[j] || self.stiff[j]));
                let is_linked = linked.contains(&node);
                let joint = std::array::from_fn(|d| {
                    if !self.strains[i][6 * k + d] {
                        None
                    } else if !self.moves[i][6 * k + d] {
                        Some(Joint::Root)
                    } else if is_linked {
                        Some(Joint::Link)
                    } else {
                        (meets || carries).then_some(Joint::Member)
                    }
                });
                if joint.iter().any(Option::is_some) {
                    ends.push(End { element: i, side: k + 1, node, joint, is_second, partner: None });
                }
            }
        }
        let at: HashMap<(usize, usize), usize> =
            ends.iter().enumerate().rev().map(|(i, end)| ((end.element, end.node), i)).collect();
        let partners: Vec<Option<usize>> = ends
            .iter()
            .enumerate()
            .map(|(i, end)| {
                let (element, node) = (self.element_partner[end.element]?, self.node_partner[end.node]?);
                let same_axes = (0..3).all(|a| self.mirror_sign(end.element, element, a) != 0.0);
                let &j = at.get(&(element, node))?;
                (j != i && same_axes).then_some(j)
            })
            .collect();
        ends.iter_mut().zip(partners).for_each(|(end, partner)| end.partner = partner);
        ends
    }

    /// The nodes in rigid links.
    pub(super) fn linked(&self) -> HashSet<usize> {
        let links = self.model.spec().rigid_links.values();
        let nodes = links.flat_map(|l| std::iter::once(&l.master).chain(&l.slaves));
        nodes.filter_map(|name| self.model.geometry().node(name)).collect()
    }

    /// Per node, the elements that are joined to it.
    pub(super) fn elements_at_nodes(&self) -> &[Vec<usize>] {
        self.at_nodes.get_or_find(|| {
            let mut at: Vec<Vec<usize>> = vec![Vec::new(); self.model.geometry().names.len()];
            for (i, e) in self.model.elements().iter().enumerate() {
                e.joined().iter().for_each(|&n| at[n].push(i));
            }
            at
        })
    }
}

/// Indices in ascending order: the same for the same elements.
pub(super) fn sorted(elements: &[usize]) -> Vec<usize> {
    let mut sorted = elements.to_vec();
    sorted.sort_unstable();
    sorted
}

/// Whether two parts share no element.
fn apart(a: &Part, b: &Part) -> bool {
    let others: HashSet<usize> = b.elements.iter().copied().collect();
    a.elements.iter().all(|e| !others.contains(e))
}
