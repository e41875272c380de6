//! Superelements in their places: their nodes in the model, the directions of their dofs, their terms as functions of θ.

use super::Placer;
use super::mesh::MOST_SITES;
use crate::catalogue::did_you_mean;
use crate::element::Dof;
use crate::model::exported::{Exported, ExportedDof, ExportedMatrices, ExportedTerm};
use crate::model::geometry::{GLOBAL, Near, Stand, Vector, constant, dot, extent, minus, plus, spread};
use crate::model::placed_element::PlacedElement;
use crate::model::placed_matrices::{PlacedDof, PlacedMatrices};
use crate::model::spec::{ModelSpec, SuperelementSpec};
use crate::model::value::{Affine, Value};
use crate::yaml::child;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// How far a node of the model may stand from the node of a superelement that it is attached to, of the size of the latter.
const OFF: f64 = 1e-4;

/// A dof in its place.
fn placed(stand: &Stand, dof: &ExportedDof, nodes: &[usize]) -> PlacedDof {
    let turned = stand.direction(dof.axis);
    // A rotation is mirrored as an axial vector.
    let is_axial = stand.is_mirrored() && dof.dof.is_some_and(Dof::is_rotation);
    let axis = if is_axial { turned.map(|c| -c) } else { turned };
    PlacedDof { node: nodes[dof.node], dof: dof.dof, axis }
}

impl Placer<'_> {
    pub(super) fn superelements(&mut self) {
        for (name, entry) in &self.spec.superelements {
            let path = child("superelements", name);
            let Some(exported) = entry.loaded.0.clone() else { continue };
            if self.claim(name, &path) {
                self.superelement(name, entry, &exported, &path);
            }
        }
    }

    fn superelement(&mut self, name: &str, entry: &SuperelementSpec, exported: &Exported, path: &str) {
        let Some(stand) = self.stand(entry, path) else { return };
        let n_before = self.geometry.names.len();
        let Some(nodes) = self.nodes_of(name, entry, exported, &stand, path) else { return };
        let dofs: Vec<PlacedDof> = exported.dofs.iter().map(|d| placed(&stand, d, &nodes)).collect();
        for (dof, terms) in &exported.recovered {
            let mut row: Vec<(usize, f64)> = placed(&stand, dof, &nodes).parts().collect();
            row.extend(terms.iter().flat_map(|&(j, f)| dofs[j].parts().map(move |(i, a)| (i, -f * a))));
            self.rows.push(row);
        }
        let recovered: Vec<PlacedDof> = exported.recovered.iter().map(|(d, _)| placed(&stand, d, &nodes)).collect();
        self.hold_what_is_missing(n_before, dofs.iter().chain(&recovered));
        let sites = self.sites(entry, exported, &nodes, n_before, path);
        self.sites.extend(sites);
        let dofs = Arc::new(dofs);
        let base = self.matrices(name.to_string(), path, &dofs, &exported.base, None);
        let mut all = vec![base];
        for term in &exported.terms {
            let path = format!("{path}.terms.{}", term.name);
            let part = format!("{name}.{}", term.name);
            let Some(parameter) = self.parameters.index_of(&term.parameter) else { continue };
            if self.claim(&part, &path) {
                let mut elements = Vec::new();
                for (i, (power, matrices)) in term.parts.iter().enumerate() {
                    let own = if term.parts.len() == 1 { part.clone() } else { format!("{part}.{}", i + 1) };
                    let value = coefficient(parameter, term, *power);
                    elements.push(self.matrices(own, &path, &dofs, matrices, Some(value)));
                }
                all.extend(&elements);
                self.sets.insert(part, elements);
            }
        }
        self.sets.insert(name.to_string(), all);
        if let (Some(k), Some(spec)) = (&exported.preload, &entry.preload) {
            let path = child(path, "preload");
            let factor = spec.factor.as_ref().map(|f| self.affine(f, "1", &child(&path, "factor")));
            let part = format!("{name}.preload");
            if let Some(factor) = factor.unwrap_or(Some(Affine { constant: 1.0, terms: Vec::new() }))
                && self.claim(&part, &path)
            {
                let matrices = ExportedMatrices { k: Some(k.clone()), ..ExportedMatrices::default() };
                let element = self.matrices(part.clone(), &path, &dofs, &matrices, Some(Value::of(factor)));
                if let Some(matrices) = &mut self.elements[element].matrices {
                    matrices.is_preload = true;
                }
                self.sets.insert(part, vec![element]);
            }
        }
    }

    fn stand(&mut self, entry: &SuperelementSpec, path: &str) -> Option<Stand> {
        let stand = Stand::of(entry, &self.geometry.frames);
        if let (None, Some(name)) = (&stand, &entry.frame)
            && !self.spec.frames.contains_key(name)
        {
            let suggestion = did_you_mean(name, self.spec.frames.keys().map(String::as_str));
            self.error(child(path, "frame"), format_args!("frame `{name}` is not defined{suggestion}"));
        }
        stand
    }

    /// The node of the model for each of its nodes: attached, found near, or new.
    fn nodes_of(
        &mut self,
        name: &str,
        entry: &SuperelementSpec,
        exported: &Exported,
        stand: &Stand,
        path: &str,
    ) -> Option<Vec<usize>> {
        let places: Vec<Option<Vector>> = exported.nodes.iter().map(|n| n.position.map(|p| stand.place(p))).collect();
        let known: Vec<Vector> = places.iter().flatten().copied().collect();
        let size = extent(&known);
        let within = match &entry.attach_within {
            Some(distance) => constant(distance, "m", &child(path, "attach_within"), self.problems),
            None => 0.0,
        };
        let index: HashMap<&str, usize> =
            exported.nodes.iter().enumerate().map(|(i, n)| (n.name.as_str(), i)).collect();
        let mut of: Vec<Option<usize>> = vec![None; places.len()];
        let mut is_sound = true;
        for (node, label) in &entry.attach {
            let key = format!("{path}.attach.{node}");
            let found = self.node(node, &key);
            let Some(&own) = index.get(label.0.as_str()) else {
                let suggestion = did_you_mean(&label.0, index.keys().copied());
                self.error(&key, format_args!("the superelement has no node `{}`{suggestion}", label.0));
                is_sound = false;
                continue;
            };
            let (Some(found), Some(place)) = (found, places[own]) else {
                is_sound = false;
                continue;
            };
            let off = minus(self.geometry.positions[found], place);
            let off = dot(off, off).sqrt();
            if off > within.max(OFF * size) {
                self.error(
                    &key,
                    format_args!(
                        "node `{node}` stands {off:.4e} m away from node `{}` of the superelement; join nodes that are apart by `rigid_links`, or allow it by `attach_within`",
                        label.0
                    ),
                );
                is_sound = false;
            }
            of[own] = Some(found);
        }
        if within > 0.0 {
            let positions = self.geometry.positions.clone();
            let near = Near::new(&positions, within);
            for (own, place) in places.iter().enumerate() {
                let Some(place) = place.filter(|_| of[own].is_none()) else { continue };
                let distance = |&i: &usize| dot(minus(positions[i], place), minus(positions[i], place));
                let found = near.within(place, within).into_iter().filter(|i| !self.geometry.is_coordinate(*i));
                of[own] = found.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            }
        }
        if !is_sound {
            return None;
        }
        let middle = known.iter().fold([0.0; 3], |sum, p| plus(sum, 1.0 / known.len() as f64, *p));
        let mut nodes = Vec::with_capacity(places.len());
        for ((node, place), of) in exported.nodes.iter().zip(&places).zip(of) {
            let own = format!("{name}.{}", node.name);
            nodes.push(match (of, place) {
                (Some(node), _) => node,
                (None, Some(place)) => self.geometry.add(own, *place),
                (None, None) => self.geometry.add_coordinate(own, middle),
            });
        }
        Some(nodes)
    }

    /// A node of its own that has some of its displacements, or some of its rotations, does not move along the others: they were held where the
    /// matrices were made, and left free they would be motions without stiffness.
    fn hold_what_is_missing<'d>(&mut self, n_before: usize, dofs: impl Iterator<Item = &'d PlacedDof>) {
        let mut of: BTreeMap<(usize, bool), Vec<Vector>> = BTreeMap::new();
        for dof in dofs.filter(|d| d.node >= n_before) {
            if let Some(d) = dof.dof {
                of.entry((dof.node, d.is_rotation())).or_default().push(dof.axis);
            }
        }
        for ((node, is_rotation), axes) in of {
            if axes.len() >= 3 {
                continue;
            }
            let first = 6 * node + if is_rotation { 3 } else { 0 };
            // What is left of the global axes across those that are there.
            let mut basis = axes;
            for axis in GLOBAL {
                let left = basis.iter().fold(axis, |v, b| plus(v, -dot(axis, *b), *b));
                if let Some(direction) = crate::model::geometry::unit(left).filter(|_| dot(left, left) > 1e-6)
                    && basis.len() < 3
                {
                    self.rows.push((0..3).map(|i| (first + i, direction[i])).filter(|t| t.1.abs() > 1e-12).collect());
                    basis.push(direction);
                }
            }
        }
    }

    /// Nodes at which effects are looked for: those that the entry names, or all, or of many those farthest from each other.
    fn sites(
        &mut self,
        entry: &SuperelementSpec,
        exported: &Exported,
        nodes: &[usize],
        n_before: usize,
        path: &str,
    ) -> Vec<usize> {
        if let Some(named) = &entry.effect_nodes {
            let mut sites = Vec::new();
            for (i, label) in named.iter().enumerate() {
                match exported.nodes.iter().position(|n| n.name == label.0 && n.position.is_some()) {
                    Some(own) => sites.push(nodes[own]),
                    None => {
                        let known = exported.nodes.iter().map(|n| n.name.as_str());
                        let suggestion = did_you_mean(&label.0, known);
                        let message = format!("the superelement has no node `{}`{suggestion}", label.0);
                        self.error(format!("{path}.effect_nodes[{i}]"), message);
                    }
                }
            }
            return sites;
        }
        let own: Vec<usize> =
            nodes.iter().copied().filter(|&n| n >= n_before && !self.geometry.is_coordinate(n)).collect();
        spread(&self.geometry.positions, &own, MOST_SITES)
    }

    fn matrices(
        &mut self,
        name: String,
        path: &str,
        dofs: &Arc<Vec<PlacedDof>>,
        matrices: &ExportedMatrices,
        factor: Option<Value>,
    ) -> usize {
        let ExportedMatrices { k, m, c } = matrices.clone();
        let factors = [factor.clone(), factor.clone()];
        let matrices = PlacedMatrices { dofs: dofs.clone(), k, m, c, damping_factor: factor, is_preload: false };
        self.elements.push(PlacedElement::of_matrices(name, path, factors, matrices));
        self.elements.len() - 1
    }
}

/// (θ/reference)^power, less one where the base includes the part.
fn coefficient(parameter: usize, term: &ExportedTerm, power: u32) -> Value {
    let factor = Affine { constant: 0.0, terms: vec![(parameter, 1.0 / term.reference)] };
    let mut value = Value { factors: vec![factor; power as usize], ..Value::default() };
    if term.is_included {
        value.addends.push(Affine { constant: -1.0, terms: Vec::new() });
    }
    value
}

/// What effects leave out of superelements, a sentence each.
pub(in crate::model) fn left_out_of_effects(spec: &ModelSpec) -> Vec<String> {
    let mut told = Vec::new();
    let names: Vec<String> = spec.superelements.keys().map(|n| format!("`{n}`")).collect();
    if !names.is_empty() {
        let names = names.join(", ");
        told.push(format!(
            "what superelements are made of is not known: effects change the whole of {names} or their `terms`, and act at their nodes; tapers, offsets, shear and the like have no place in them"
        ));
    }
    if let Some(loaded) = spec.mesh.as_ref().and_then(|m| m.loaded.0.as_ref()) {
        let n = loaded.mesh.nodes.len();
        if n > MOST_SITES {
            told.push(format!("effects are looked for on parts, sets and patches of the mesh, and at {MOST_SITES} of its {n} nodes; those that `nodes` names are among them"));
        }
    }
    for (name, entry) in &spec.superelements {
        let Some(exported) = entry.loaded.0.as_ref() else { continue };
        let n = exported.nodes.iter().filter(|n| n.position.is_some()).count();
        let looked = entry.effect_nodes.as_ref().map_or(MOST_SITES, Vec::len);
        if n > looked {
            told.push(format!(
                "effects are looked for at {looked} of the {n} nodes of superelement `{name}`; `effect_nodes: [...]` names which"
            ));
        }
    }
    told
}
