//! Places of a mesh between those that every search tries: any node, a patch of any size about any element, and any stretch of a support.
//!
//! A mesh of thousands of nodes has some hundred at which effects are looked for, and some dozens of patches; what is wrong with it stands where it
//! stands. About the best of these places the others are looked at, nearer with every round.

use super::listing::sorted;
use super::regions::LN_OF_A_SIDE;
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
/// Size of the patches at which every search looks where places are wider, as a multiple of those of the mesh.
const AREA: usize = 3;
/// Between the name of an element and the number of elements of a patch about it; of a support, of one of its nodes and the number of nodes about that.
pub(super) const ABOUT: char = '~';

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
            let Some(elements) = self.named_between(name) else { continue };
            let image = self.image_of_patch(name, &elements);
            for (name, elements) in std::iter::once((name.clone(), elements)).chain(image) {
                if known.insert(sorted(&elements)) {
                    parts.push(self.part_of_elements(name, elements));
                }
            }
        }
        parts
    }

    /// About the middle of every patch of the mesh, patches of some times its size: what is wrong may reach over several, and none of them alone
    /// shows it.
    pub(super) fn list_areas(&self) -> Vec<Part> {
        let mut known: BTreeSet<Vec<usize>> = self.parts.iter().map(|p| sorted(&p.elements)).collect();
        let mut areas = Vec::new();
        for patch in self.model.patches() {
            let elements = self.model.element_set(patch).unwrap_or_default();
            let Some(middle) = self.middle_of(elements).map(|(e, _)| self.model.elements()[e].name.as_str()) else {
                continue;
            };
            let name = format!("{middle}{ABOUT}{}", AREA * elements.len());
            if let Some(elements) = self.patch_about(&name).filter(|e| known.insert(e.clone())) {
                areas.push(self.part_of_elements(name, elements));
            }
        }
        areas
    }

    /// The element in the middle of some, and how far the others reach from the middle of all.
    fn middle_of(&self, elements: &[usize]) -> Option<(usize, f64)> {
        let share = 1.0 / elements.len() as f64;
        let middle = elements.iter().fold([0.0; 3], |sum, &e| plus(sum, share, self.centre(e)));
        let off = |e: usize| {
            let d = minus(self.centre(e), middle);
            dot(d, d).sqrt()
        };
        let central = elements.iter().copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
        Some((central, elements.iter().map(|&e| off(e)).fold(0.0, f64::max)))
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

    /// Whether a name is that of a patch about an element, or of a stretch about a node.
    pub fn is_patch_name(name: &str) -> bool {
        name.contains(ABOUT)
    }

    /// The elements of a place between those that every search tries, by its name: a patch, a region, or a run of beams.
    pub(super) fn named_between(&self, name: &str) -> Option<Vec<usize>> {
        self.patch_about(name).or_else(|| self.region(name)).or_else(|| self.run_between(name))
    }

    fn part_of_elements(&self, name: String, elements: Vec<usize>) -> Part {
        let is_of_mesh = elements.first().is_some_and(|&e| self.mesh_part_of(e).is_some());
        let kind = if is_of_mesh { PartKind::Group } else { PartKind::Span };
        let mut of: Vec<String> = elements.iter().map(|&e| self.element_of_file(e).to_string()).collect();
        of.dedup();
        Part { name, kind, of, elements, partner: None, is_member: false }
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

    /// Names of places about one of a mesh, or of a long line of beams, that no search has tried yet: nodes about a node, patches of several sizes
    /// about a patch, runs of several lengths about some beams. None about other places, and none where nothing lies between them any more.
    ///
    /// * `round` - how often it has been looked about before: each time a third as far
    pub fn finer(&self, at: &Location, round: u32) -> Vec<String> {
        let Some(name) = at.names.first() else { return Vec::new() };
        let mut found = match at.kind {
            LocationKind::Node => self.model.geometry().node(name).map(|n| self.nodes_about(n, round)),
            LocationKind::Group | LocationKind::Element | LocationKind::Chain => {
                let (sizes, reach) = (sizes_in(round), 1.5 / 3_f64.powi(round as i32));
                let of_surface = self.stretches_about(name, sizes, reach, MIDDLES);
                let of_mesh = of_surface.or_else(|| self.patches_about_one(name, round));
                of_mesh.or_else(|| Some(self.runs_about(name, sizes)))
            }
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

    /// ln of how many places there are between those that every search tries, for each of these: who may choose among more places explains more by
    /// chance, however he came to the one he names.
    pub fn ln_between(&self, at: &Location) -> f64 {
        let Some(name) = at.names.first() else { return 0.0 };
        let share = |all: f64, tried: usize| (all / tried.max(1) as f64).max(1.0).ln();
        // About each of so many, of any size: one and the next nearest.
        let of_any_size = |n: usize| n as f64 * ((n as f64).ln() / NEARER_SIZES[3].ln()).max(1.0);
        if at.kind == LocationKind::Node {
            let of_mesh = self.nodes_of_mesh();
            let sites = self.sites().into_iter().filter(|&n| of_mesh[n]);
            return share(of_mesh.iter().filter(|is| **is).count() as f64, sites.count());
        }
        if let Some((support, _)) = name.split_once(ABOUT).filter(|_| self.stretch(name).is_some()) {
            let tried = self.stretches_of(support).len();
            return share(of_any_size(self.nodes_of_support(support).len()), tried);
        }
        if let Some(run) = self.run_between(name) {
            return self.ln_of_runs(&run, of_any_size);
        }
        let elements = self.elements_of(name);
        let Some(part) = elements.first().and_then(|&e| self.mesh_part_of(e)) else { return 0.0 };
        let of_shape = self.region(name).map_or(0.0, |own| self.sides_of(&own) as f64 * LN_OF_A_SIDE);
        let part = &self.model.mesh_parts()[part];
        let all = self.model.element_set(part).map_or(0, <[usize]>::len);
        let patches = self.model.patches().iter().filter(|p| p.starts_with(&format!("{part}.p")));
        share(of_any_size(all), patches.count()) + of_shape
    }

    /// Nodes of the mesh about one of it, those in the middle of edges among them, no further away than half as far again as the next at which
    /// effects are looked for.
    fn nodes_about(&self, node: usize, round: u32) -> Vec<String> {
        let positions = &self.model.geometry().positions;
        let squared = |n: usize, from: usize| {
            let d = minus(positions[n], positions[from]);
            dot(d, d)
        };
        let of_mesh = self.nodes_of_mesh();
        if !of_mesh[node] {
            return Vec::new();
        }
        // As far apart as the site beside it is from the next.
        let sites: Vec<usize> = self.sites().into_iter().filter(|&n| of_mesh[n]).collect();
        let beside = sites.iter().copied().min_by(|&a, &b| squared(a, node).total_cmp(&squared(b, node)));
        let others = sites.iter().filter_map(|&n| Some(squared(n, beside?))).filter(|d| *d > 0.0);
        let next = others.fold(f64::INFINITY, f64::min);
        let reach = (1.5 / 3_f64.powi(round as i32)).powi(2) * next;
        let is_within = |&n: &usize| of_mesh[n] && n != node && squared(n, node) <= reach;
        let within: Vec<usize> = (0..self.n_nodes()).filter(is_within).collect();
        let names = spread(positions, &within, NODES).into_iter().filter(|&n| !self.model.is_site(n));
        names.map(|n| self.node_name(n).to_string()).collect()
    }

    /// Patches about a patch of the mesh: about elements in and around it, of several sizes.
    fn patches_about_one(&self, name: &str, round: u32) -> Option<Vec<String>> {
        let elements = self.shape(name)?;
        let part = self.mesh_part_of(*elements.first()?)?;
        let (central, far) = self.middle_of(&elements)?;
        // Half as far again as the patch reaches, then a third of that.
        let reach = 1.5 * far / 3_f64.powi(round as i32);
        let around: Vec<usize> =
            self.outwards_from(central, part).take_while(|(_, distance)| *distance <= reach).map(|(e, _)| e).collect();
        let centres: Vec<Vector> = around.iter().map(|&e| self.centre(e)).collect();
        let all: Vec<usize> = (0..around.len()).collect();
        let most = self.model.element_set(&self.model.mesh_parts()[part]).map_or(0, <[usize]>::len);
        let numbers: BTreeSet<usize> =
            sizes_in(round).iter().map(|s| ((s * elements.len() as f64).round() as usize).clamp(1, most)).collect();
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
    pub(super) fn mesh_part_of(&self, element: usize) -> Option<usize> {
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

/// Shares of the number of elements of a patch, or of nodes of a stretch, that are tried in a round.
fn sizes_in(round: u32) -> &'static [f64] {
    if round == 0 { &SIZES } else { &NEARER_SIZES }
}
