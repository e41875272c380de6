//! What was added to a model, as cards: masses, springs, bushings, and the nodes that they stand on.

use super::Work;
use super::cards::added_card;
use crate::system::Quantity as Q;
use retune::deck::real_in;
use retune::element::Dof;
use retune::model::{GLOBAL, Model, ParametricModel, PlacedElement};
use std::collections::{HashMap, HashSet};

/// Writes cards for elements that the deck has not.
pub(super) fn write(work: &mut Work<'_>, base: &Model, updated: &Model) {
    let known: HashSet<&str> = base.elements().iter().map(|e| e.name.as_str()).collect();
    let theta = updated.parameters().nominal();
    let mut added = Added { work, base, updated, numbers: HashMap::new() };
    for element in updated.elements().iter().filter(|e| !known.contains(e.name.as_str())) {
        added.element(element, &element.values_at(&theta));
    }
}

struct Added<'a, 'b> {
    work: &'a mut Work<'b>,
    base: &'a Model,
    updated: &'a Model,
    /// Numbers of grids that are added.
    numbers: HashMap<usize, u32>,
}

impl Added<'_, '_> {
    fn element(&mut self, element: &PlacedElement, values: &[Option<f64>]) {
        let value = |name: &str| {
            let i = element.kind.properties().iter().position(|p| p.name == name)?;
            values[i].filter(|v| *v != 0.0)
        };
        if element.axes != GLOBAL && element.kind.name() != "spring" {
            self.work.refuse(format!(
                "{}: what is added in axes of its own has no card here; use global axes",
                element.path
            ));
            return;
        }
        if element.stiffness_factor.is_some() || element.mass_factor.is_some() {
            self.work
                .refuse(format!("{}: a factor on what was added has no card; write it into its values", element.path));
            return;
        }
        let is_damped = element
            .kind
            .properties()
            .iter()
            .zip(values)
            .any(|(p, v)| (p.name == "c" || p.name.starts_with("c_")) && v.is_some_and(|v| v != 0.0));
        if is_damped {
            self.work.refuse(format!("{}: dashpots are not written: modes do not know them", element.path));
            return;
        }
        match element.kind.name() {
            "point_mass" => self.mass(element, &value),
            "ground_spring" => self.ground(element, &value),
            "bushing" => self.bushing(element, &value),
            kind => self.work.refuse(format!("{}: an added {kind} has no card here", element.path)),
        }
    }

    fn real(&mut self, value: f64) -> String {
        let text = real_in(value, 16);
        self.work.rounded(value, &text);
        text
    }

    fn mass(&mut self, element: &PlacedElement, value: &dyn Fn(&str) -> Option<f64>) {
        let Some(grid) = self.grid(element.nodes[0], &element.path) else { return };
        let (system, wtmass) = (self.work.system, self.work.origins.wtmass);
        let per = |q: Q| system.factor(q);
        let number = self.work.number();
        let mass = self.real(value("mass").unwrap_or(0.0) / (per(Q::Mass) * wtmass));
        let mut fields = vec![number.to_string(), grid.to_string(), "0".into(), mass];
        for axis in ["x", "y", "z"] {
            let offset = self.real(value(&format!("offset_{axis}")).unwrap_or(0.0) / per(Q::Length));
            fields.push(offset);
        }
        fields.push(String::new());
        for axis in ["xx", "xy", "yy", "xz", "yz", "zz"] {
            let inertia = value(&format!("inertia_{axis}")).map(|v| v / (per(Q::Inertia) * wtmass));
            fields.push(inertia.map_or_else(String::new, |v| self.real(v)));
        }
        self.add(element, "CONM2", number, &fields);
    }

    fn stiffness(&mut self, dof: Dof, k: f64) -> String {
        let q = if dof.is_rotation() { Q::RotationalStiffness } else { Q::Stiffness };
        self.real(k / self.work.system.factor(q))
    }

    fn ground(&mut self, element: &PlacedElement, value: &dyn Fn(&str) -> Option<f64>) {
        let Some(grid) = self.grid(element.nodes[0], &element.path) else { return };
        if self.is_turned(element.nodes[0]) {
            self.work.refuse(format!(
                "{}: displacements of GRID {grid} have axes of their own; a spring along global axes has no card",
                element.path
            ));
            return;
        }
        for dof in Dof::ALL {
            if let Some(k) = value(&format!("k_{dof}")) {
                let (number, k) = (self.work.number(), self.stiffness(dof, k));
                let fields = vec![number.to_string(), k, grid.to_string(), (dof as usize + 1).to_string()];
                self.add(element, "CELAS2", number, &fields);
            }
        }
    }

    fn bushing(&mut self, element: &PlacedElement, value: &dyn Fn(&str) -> Option<f64>) {
        let (Some(a), Some(b)) =
            (self.grid(element.nodes[0], &element.path), self.grid(element.nodes[1], &element.path))
        else {
            return;
        };
        if !element.arms.is_empty() {
            self.work.refuse(format!("{}: an added bushing with offsets has no card here", element.path));
            return;
        }
        let (property, number) = (self.work.number(), self.work.number());
        let mut fields = vec![property.to_string(), "K".to_string()];
        for dof in Dof::ALL {
            let k = value(&format!("k_{dof}")).map_or_else(String::new, |k| self.stiffness(dof, k));
            fields.push(k);
        }
        self.add(element, "PBUSH", property, &fields);
        let mut fields = vec![number.to_string(), property.to_string(), a.to_string(), b.to_string()];
        fields.extend([String::new(), String::new(), String::new(), "0".to_string()]);
        let location = element.kind.properties().iter().position(|p| p.name == "location");
        let stated =
            location.and_then(|i| element.values[i].as_ref()).map(|v| v.at(&self.updated.parameters().nominal()));
        fields.extend(stated.map(|s| self.real(s)));
        self.add(element, "CBUSH", number, &fields);
    }

    fn is_turned(&self, node: usize) -> bool {
        let name = &self.updated.geometry().names[node];
        let imported = self.updated.spec().imported.as_ref();
        imported.is_some_and(|i| i.displacement_frames.values().flatten().any(|n| n == name))
    }

    /// Number of the grid of a node; a GRID is added for a node that the deck has not.
    fn grid(&mut self, node: usize, path: &str) -> Option<u32> {
        let geometry = self.updated.geometry();
        let name = &geometry.names[node];
        if let Some(card) = self.work.origins.grids.get(name) {
            return self.work.deck.card(*card).id_at(2, "ID").ok();
        }
        if let Some(number) = self.numbers.get(&node) {
            return Some(*number);
        }
        if self.base.geometry().node(name).is_some() {
            let text =
                format!("{path}: node `{name}` is in the middle of an element of the deck, which has no grid there");
            self.work.refuse(text);
            return None;
        }
        if name.contains('/') {
            self.work.refuse(format!("{path}: node `{name}` is inside a divided element, which the deck has not"));
            return None;
        }
        let number = self.work.number();
        let metre = self.work.system.factor(Q::Length);
        let position = geometry.positions[node];
        let mut fields = vec![number.to_string(), String::new()];
        for x in position {
            let x = self.real(x / metre);
            fields.push(x);
        }
        self.work.changes.add(added_card("GRID", &fields));
        self.work.told.push(format!("added: GRID {number} for node {name}"));
        self.numbers.insert(node, number);
        Some(number)
    }

    fn add(&mut self, element: &PlacedElement, card: &str, number: u32, fields: &[String]) {
        self.work.changes.add(std::iter::once(format!("$ {}", element.name)).chain(added_card(card, fields)));
        self.work.told.push(format!("added: {card} {number} for {}", element.name));
    }
}
