//! The connections of members of one kind, which give alike: the bolted ends of all the braces, of all the beams of a floor.

use super::places::arrange;
use super::{End, Joint, PartKind, Structure};
use crate::effect::location::{Location, LocationKind};
use crate::element::Dof;
use std::collections::{BTreeSet, HashSet};

/// Ends from which a group says something that a member, or two mirror images, do not say.
const SEVERAL: usize = 3;

impl<'a> Structure<'a> {
    /// Groups of members whose ends are joined to others, direction by direction; one of several groups with the same ends.
    ///
    /// * `but` - places that are known already, by their ends
    pub(in crate::effect) fn connections(&self, dofs: &[Dof], but: &[Location]) -> Vec<Location> {
        if self.is_wider {
            return Vec::new();
        }
        let ends_of = |at: &Location| at.names.iter().map(|name| self.end_of.get(name).copied()).collect();
        let mut known: HashSet<(Option<BTreeSet<usize>>, &str)> =
            but.iter().map(|at| (ends_of(at), at.direction())).collect();
        let mut locations = Vec::new();
        let groups = (0..self.parts.len()).filter(|&i| self.parts[i].kind == PartKind::Group);
        // Mirror images together before each alone.
        let groups = arrange(groups, |i| self.parts[i].partner);
        for dof in dofs {
            for these in &groups {
                let ends: BTreeSet<usize> =
                    these.iter().flat_map(|&i| self.connections_in(&self.parts[i].elements, *dof)).collect();
                if ends.len() >= SEVERAL && known.insert((Some(ends), dof.name())) {
                    let names = these.iter().map(|&i| self.parts[i].name.clone()).collect();
                    locations.push(Location::new(LocationKind::Group, names).along(dof.name()));
                }
            }
        }
        locations
    }

    /// The ends of the members of a group that are joined to others in a direction.
    pub(in crate::effect) fn connections_of(&self, group: &str, dof: Dof) -> Vec<&End> {
        let part = self.part(group).filter(|part| part.kind == PartKind::Group);
        part.into_iter().flat_map(|part| self.connections_in(&part.elements, dof)).map(|i| &self.ends[i]).collect()
    }

    /// An end where nothing but the same line or chain goes on is none, whatever stands on it.
    fn connections_in<'s>(&'s self, elements: &[usize], dof: Dof) -> impl Iterator<Item = usize> + use<'s, 'a> {
        let inside: HashSet<usize> = elements.iter().copied().collect();
        // The lines and chains that have an element.
        let mut lines: Vec<Vec<usize>> = vec![Vec::new(); self.model.elements().len()];
        for (i, part) in self.parts.iter().enumerate() {
            if matches!(part.kind, PartKind::Line | PartKind::Chain) {
                part.elements.iter().for_each(|&e| lines[e].push(i));
            }
        }
        let goes_on = move |end: &End| {
            let here = self.elements_at_nodes()[end.node].iter();
            let beams: Vec<usize> = here.copied().filter(|&e| self.is_beam(e) && self.deforms(e)).collect();
            matches!(beams[..], [a, b] if lines[a].iter().any(|line| lines[b].contains(line)))
        };
        let is_one = move |end: &End| {
            inside.contains(&end.element) && end.joint[dof as usize] == Some(Joint::Member) && !goes_on(end)
        };
        (0..self.ends.len()).filter(move |&i| is_one(&self.ends[i]))
    }
}
