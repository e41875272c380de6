//! Places of a mesh between those that every search tries: any node, and a patch of any size about any element.
//!
//! A mesh of thousands of nodes has some hundred at which effects are looked for, and some dozens of patches; what is wrong with it stands where it
//! stands. About the best of these places the others are looked at, nearer with every round.

use super::listing::sorted;
use super::{Part, PartKind, Structure};
use crate::effect::location::{Location, LocationKind};
use crate::model::{Outwards, Vector, dot, minus, plus, spread};
use std::collections::BTreeSet;

/// Nodes about a node that are tried in a round.
const NODES: usize = 60;
/// Middles of patches about a patch that are tried in a round.
const MIDDLES: usize = 12;
/// Sizes of patches in the first round, as shares of the number of elements of the patch.
const SIZES: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
/// The same in the rounds after it.
const NEARER_SIZES: [f64; 5] = [0.6, 0.8, 1.0, 1.25, 1.6];
/// Between the name of an element and the number of elements of a patch about it.
const ABOUT: char = '~';

impl Structure<'_> {
    /// Further nodes of the mesh that the context names.
    pub(super) fn further_nodes(&self) -> impl Iterator<Item = usize> {
        let named = self.context.further.iter().filter_map(|name| self.model.geometry().node(name));
        named.filter(|&n| n < self.n_nodes() && !self.model.is_site(n))
    }

    /// Further patches of the mesh that the context names, those at their mirror images behind them.
    pub(super) fn further_patches(&self) -> Vec<Part> {
        let mut known: BTreeSet<Vec<usize>> = self.parts.iter().map(|p| sorted(&p.elements)).collect();
        let mut parts = Vec::new();
        for name in &self.context.further {
            let Some(elements) = self.patch_about(name) else { continue };
            let image = self.image_of_patch(name, &elements);
            for (name, elements) in std::iter::once((name.clone(), elements)).chain(image) {
                if known.insert(elements.clone()) {
                    let of = elements.iter().map(|&e| self.model.elements()[e].name.clone()).collect();
                    parts.push(Part { name, kind: PartKind::Group, of, elements, partner: None, is_member: false });
                }
            }
        }
        parts
    }

    /// The elements of `e81~12`, the twelve of a part of the mesh that are nearest to one of it along elements that touch, in file order; `None`
    /// for any other name.
    pub(super) fn patch_about(&self, name: &str) -> Option<Vec<usize>> {
        let (element, number) = name.rsplit_once(ABOUT)?;
        let (Some(&[element]), Ok(number)) = (self.model.element_set(element), number.parse::<usize>()) else {
            return None;
        };
        let part = self.mesh_part_of(element)?;
        let mut elements: Vec<usize> = self.outwards_from(element, part).take(number.max(1)).map(|(e, _)| e).collect();
        elements.sort_unstable();
        (elements.len() == number).then_some(elements)
    }

    /// The name and the elements of the mirror image of a patch about an element, where that is another.
    fn image_of_patch(&self, name: &str, elements: &[usize]) -> Option<(String, Vec<usize>)> {
        let (element, number) = name.rsplit_once(ABOUT)?;
        let &[element] = self.model.element_set(element)? else { return None };
        let image: Option<Vec<usize>> = elements.iter().map(|&e| self.element_partner[e]).collect();
        let its_name = format!("{}{ABOUT}{number}", self.model.elements()[self.element_partner[element]?].name);
        let its_elements = self.patch_about(&its_name)?;
        (its_name != name && its_elements == sorted(&image?)).then_some((its_name, its_elements))
    }

    /// Names of places about one of a mesh that no search has tried yet: nodes about a node, patches of several sizes about a patch. None about
    /// other places, and none where nothing lies between them any more.
    ///
    /// * `round` - how often it has been looked about before: each time a third as far
    pub fn finer(&self, at: &Location, round: u32) -> Vec<String> {
        let Some(name) = at.names.first() else { return Vec::new() };
        let mut found = match at.kind {
            LocationKind::Node => self.model.geometry().node(name).map(|n| self.nodes_about(n, round)),
            LocationKind::Group | LocationKind::Element => self.patches_about_one(name, round),
            _ => None,
        }
        .unwrap_or_default();
        // On a symmetric mesh those on the other side are tried with these.
        if at.names.len() > 1 && at.kind == LocationKind::Node {
            let image =
                |n: &String| self.node_partner[self.model.geometry().node(n)?].map(|i| self.node_name(i).to_string());
            found.extend(found.iter().filter_map(image).collect::<Vec<_>>());
        }
        found
    }

    /// Nodes of the mesh about one of it, those in the middle of edges among them, no further away than half as far again as the next at which
    /// effects are looked for.
    fn nodes_about(&self, node: usize, round: u32) -> Vec<String> {
        let positions = &self.model.geometry().positions;
        let squared = |n: usize| {
            let d = minus(positions[n], positions[node]);
            dot(d, d)
        };
        let of_mesh = self.nodes_of_mesh();
        if !of_mesh[node] {
            return Vec::new();
        }
        let others = self.sites().into_iter().filter(|&n| of_mesh[n] && squared(n) > 0.0);
        let next = others.map(squared).fold(f64::INFINITY, f64::min);
        let reach = (1.5 / 3_f64.powi(round as i32)).powi(2) * next;
        let is_within = |&n: &usize| of_mesh[n] && n != node && squared(n) <= reach;
        let within: Vec<usize> = (0..self.n_nodes()).filter(is_within).collect();
        let names = spread(positions, &within, NODES).into_iter().filter(|&n| !self.model.is_site(n));
        names.map(|n| self.node_name(n).to_string()).collect()
    }

    /// Patches about a patch of the mesh: about elements in and around it, of several sizes.
    fn patches_about_one(&self, name: &str, round: u32) -> Option<Vec<String>> {
        let elements = self.elements_of(name);
        let is_patch = self.model.patches().iter().any(|p| p == name) || self.patch_about(name).is_some();
        let first = *elements.first()?;
        let part = self.mesh_part_of(first).filter(|_| is_patch)?;
        let positions: Vec<Vector> = elements.iter().map(|&e| self.centre(e)).collect();
        let share = 1.0 / elements.len() as f64;
        let middle = positions.iter().fold([0.0; 3], |sum, p| plus(sum, share, *p));
        let off = |e: usize| {
            let d = minus(self.centre(e), middle);
            dot(d, d).sqrt()
        };
        let central = elements.iter().copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
        // Half as far again as the patch reaches, then a third of that.
        let far = elements.iter().map(|&e| off(e)).fold(0.0, f64::max);
        let reach = 1.5 * far / 3_f64.powi(round as i32);
        let around: Vec<usize> =
            self.outwards_from(central, part).take_while(|(_, distance)| *distance <= reach).map(|(e, _)| e).collect();
        let centres: Vec<Vector> = around.iter().map(|&e| self.centre(e)).collect();
        let all: Vec<usize> = (0..around.len()).collect();
        let sizes = if round == 0 { SIZES } else { NEARER_SIZES };
        let most = self.model.element_set(&self.model.mesh_parts()[part]).map_or(0, <[usize]>::len);
        let numbers: BTreeSet<usize> =
            sizes.iter().map(|s| ((s * elements.len() as f64).round() as usize).clamp(1, most)).collect();
        let about = |&k: &usize| {
            let own = self.model.elements()[around[k]].name.clone();
            numbers.iter().map(move |number| format!("{own}{ABOUT}{number}")).collect::<Vec<_>>()
        };
        Some(spread(&centres, &all, MIDDLES).iter().flat_map(about).filter(|n| n != name).collect())
    }

    /// Elements of a part of the mesh from one of it outwards along elements that touch, with their distance.
    fn outwards_from(&self, element: usize, part: usize) -> impl Iterator<Item = (usize, f64)> {
        let (at, elements) = (self.elements_at_nodes(), self.model.elements());
        let neighbours = move |e: usize| {
            let own = elements[e].nodes.iter().flat_map(|&n| at[n].iter().copied());
            own.filter(|&other| self.mesh_part_of(other) == Some(part)).collect::<Vec<_>>()
        };
        Outwards::new(&[element], |e| self.centre(e), neighbours).map(|r| (r.at, r.distance))
    }

    /// The part of the mesh to which an element belongs, as a place in their list.
    fn mesh_part_of(&self, element: usize) -> Option<usize> {
        let find = || {
            let mut part_of = vec![None; self.model.elements().len()];
            for (k, name) in self.model.mesh_parts().iter().enumerate() {
                for &e in self.model.element_set(name).unwrap_or_default() {
                    part_of[e] = Some(k);
                }
            }
            part_of
        };
        self.mesh_part.get_or_find(find)[element]
    }

    /// Per node, whether it is one of the mesh.
    fn nodes_of_mesh(&self) -> Vec<bool> {
        let mut is_of_mesh = vec![false; self.model.geometry().names.len()];
        for e in self.model.elements().iter().filter(|e| e.is_of_mesh()) {
            e.nodes.iter().for_each(|&n| is_of_mesh[n] = true);
        }
        is_of_mesh
    }
}
