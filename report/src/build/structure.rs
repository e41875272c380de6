//! The structure as the pictures draw it, and places on it by the names of the user's file.

use super::super::data::{
    Element, Node, Place, PointMass, Property, PropertySet, RigidLink, Sensor, Structure, Support,
};
use super::super::text::number;
use retune::correlation::{CorrelationError, sensor_position};
use retune::data::TestData;
use retune::effect::{self, Context};
use retune::element::{Axes, Dof};
use retune::linalg::vector3::{dot, minus, plus};
use retune::model::{Model, ParametricModel, PlacedElement, Vector};
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};

/// Whether an element is drawn as a point mass.
fn is_mass(e: &PlacedElement) -> bool {
    let place = e.kind.properties().iter().position(|p| p.name == "mass");
    e.nodes.len() == 1 && place.is_some_and(|i| e.values[i].is_some())
}

/// The entry of the file that an element comes from.
fn group(e: &PlacedElement) -> &str {
    e.path.split('.').nth(1).unwrap_or_default()
}

/// Index of each element of the model among the drawn elements; `None` for a point mass.
fn drawn(model: &Model) -> Vec<Option<usize>> {
    let mut next = 0..;
    model.elements().iter().map(|e| if is_mass(e) || e.matrices.is_some() { None } else { next.next() }).collect()
}

/// The elements of the model that are drawn as elements, in their order.
pub(super) fn drawn_elements(model: &Model) -> impl Iterator<Item = &PlacedElement> {
    model.elements().iter().filter(|e| !is_mass(e) && e.matrices.is_none())
}

/// Finds places by name.
pub(super) struct Places<'a> {
    model: &'a Model,
    test: &'a TestData,
    drawn: Vec<Option<usize>>,
    /// Places that have no entry in the file, looked for when the first is named.
    structure: OnceCell<effect::Structure<'a>>,
}

impl<'a> Places<'a> {
    pub(super) fn new(model: &'a Model, test: &'a TestData) -> Self {
        Self { model, test, drawn: drawn(model), structure: OnceCell::new() }
    }

    /// A place on the structure as effects write it: `n8+n13.ry`, `left_wing.1:n5`, `whole`.
    pub(super) fn on_structure(&self, text: &str) -> Place {
        let mut place = Place { text: text.into(), ..Place::default() };
        // A configuration stands before a slash.
        let names_one =
            |part: &str| self.model.geometry().node(part).is_some() || self.model.element_set(part).is_some();
        let known = text.split(['+', ':', '.']).any(|part| part.contains('/') && names_one(part));
        let inner = text.split_once('/').filter(|_| !known).map_or(text, |(_, inner)| inner);
        if inner.split('.').next() == Some("whole") {
            place.elements = (0..self.drawn.iter().flatten().count()).collect();
            return place;
        }
        // The direction stands behind the last name only.
        for part in inner.split('+') {
            let name = part.rsplit_once('.').map(|(name, _)| name);
            let Some((elements, nodes)) = self.named(part).or_else(|| self.named(name?)) else { continue };
            if place.on_mesh.is_empty() {
                place.on_mesh = self.on_mesh(&elements, &nodes);
            }
            place.nodes.extend(nodes);
            for e in elements {
                match self.drawn[e] {
                    Some(i) => place.elements.push(i),
                    None => place.nodes.extend(self.model.elements()[e].joined().iter()),
                }
            }
        }
        place
    }

    /// Sensors and the nodes beside them as faults write them: `p3+p4`, `p11.x`, `p11:n5`.
    pub(super) fn on_test(&self, text: &str) -> Place {
        let sensor = |name: &str| self.test.sensors.iter().position(|s| s.name == name);
        let mut place = Place { text: text.into(), ..Place::default() };
        let known = |part: &str| {
            sensor(part)
                .or_else(|| part.rsplit_once(':').and_then(|(name, _)| sensor(name)))
                .or_else(|| part.rsplit_once('.').and_then(|(name, _)| sensor(name)))
        };
        place.sensors = sensor(text).map_or_else(|| text.split('+').filter_map(known).collect(), |i| vec![i]);
        place
    }

    fn structure(&self) -> &effect::Structure<'a> {
        self.structure.get_or_init(|| effect::Structure::new(self.model, Context::nothing()))
    }

    /// Where the first place of a mesh among some is: its middle, and how far it reaches; of beams on a mesh, their ends.
    fn on_mesh(&self, elements: &[usize], nodes: &[usize]) -> String {
        let all = self.model.elements();
        if let Some(ends) = self.ends_on_mesh(elements) {
            return ends;
        }
        let of_mesh: Vec<usize> = elements.iter().copied().filter(|&e| all[e].is_of_mesh()).collect();
        let own: Vec<usize> = match of_mesh.as_slice() {
            [] => nodes.iter().copied().filter(|n| all.iter().any(|e| e.is_of_mesh() && e.nodes.contains(n))).collect(),
            some => some.iter().flat_map(|&e| all[e].nodes.iter().copied()).collect(),
        };
        let at: Vec<Vector> = own.iter().map(|&n| self.model.geometry().positions[n]).collect();
        if at.is_empty() {
            return String::new();
        }
        let share = 1.0 / at.len() as f64;
        let middle = at.iter().fold([0.0; 3], |sum, p| plus(sum, share, *p));
        let off = |p: &Vector| {
            let d = minus(*p, middle);
            dot(d, d).sqrt()
        };
        let far = at.iter().map(off).fold(0.0, f64::max);
        let middle = point(middle, far);
        match of_mesh.len() {
            0 => format!("{middle} m"),
            1 => format!("1 element about {middle} m"),
            n => format!("{n} elements within {} m of {middle} m", number(far)),
        }
    }

    /// The ends of beams that lie end to end, the nodes of which are of a mesh.
    fn ends_on_mesh(&self, elements: &[usize]) -> Option<String> {
        self.model.spec().mesh.as_ref()?;
        let all = self.model.elements();
        let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
        for &e in elements {
            let &[a, b] = all[e].nodes.as_slice() else { return None };
            for n in [a, b] {
                *uses.entry(n).or_default() += 1;
            }
        }
        let is_named = |n: &usize| self.model.spec().nodes.contains_key(&self.model.geometry().names[*n]);
        let ends: Vec<usize> = uses.iter().filter(|u| *u.1 == 1).map(|u| *u.0).collect();
        let &[a, b] = ends.as_slice() else { return None };
        if uses.values().any(|n| *n > 2) || uses.keys().all(is_named) {
            return None;
        }
        let geometry = self.model.geometry();
        let at = |n: usize| point(geometry.positions[n], geometry.size());
        let n = elements.len();
        let word = if n == 1 { "element" } else { "elements" };
        Some(format!("{n} {word} from {} to {} m", at(a), at(b)))
    }

    /// The elements and the nodes of a name; of an end of an element, `element:node`, its node.
    fn named(&self, name: &str) -> Option<(Vec<usize>, Vec<usize>)> {
        if let Some(node) = self.model.geometry().node(name) {
            return Some((Vec::new(), vec![node]));
        }
        if let Some(set) = self.model.element_set(name) {
            return Some((set.to_vec(), Vec::new()));
        }
        if name.contains("..") || name.contains('~') {
            return Some((self.structure().elements_of(name), Vec::new())).filter(|(elements, _)| !elements.is_empty());
        }
        name.rsplit_once(':').and_then(|(_, node)| self.named(node))
    }
}

/// Properties that several elements have alike, once: in a large model they would be most of the page.
fn share(elements: &mut [Element]) -> Vec<PropertySet> {
    let mut users: HashMap<Vec<(String, String)>, Vec<usize>> = HashMap::new();
    let mut order = Vec::new();
    for (i, e) in elements.iter().enumerate().filter(|(_, e)| !e.properties.is_empty()) {
        let key: Vec<_> = e.properties.iter().map(|p| (p.name.clone(), p.value.clone())).collect();
        let list = users.entry(key.clone()).or_default();
        if list.len() == 1 {
            order.push(key);
        }
        list.push(i);
    }
    let mut sets = Vec::new();
    for key in order {
        for &i in &users[&key] {
            elements[i].property_set = Some(sets.len());
            elements[i].properties.clear();
        }
        let properties = key.into_iter().map(|(name, value)| Property::new(name, value)).collect();
        sets.push(PropertySet { name: String::new(), properties });
    }
    sets
}

/// The structure at θ with the sensors of a test.
pub(crate) fn structure(model: &Model, theta: &[f64], test: &TestData) -> Result<Structure, CorrelationError> {
    let geometry = model.geometry();
    let spec = model.spec();
    let names: Vec<&str> = model.parameters().names().collect();
    let mut elements = Vec::new();
    let mut masses = Vec::new();
    // What a superelement is made of is not known.
    for e in model.elements().iter().filter(|e| e.matrices.is_none()) {
        let mut properties = Vec::new();
        let mut parameters: Vec<String> = Vec::new();
        for (p, v) in e.kind.properties().iter().zip(e.values.iter()) {
            let Some(v) = v else { continue };
            // An infinite compliance passes nothing on.
            let value = v.at(theta);
            let shown =
                if value.is_infinite() { "released".to_string() } else { format!("{} {}", number(value), p.unit) };
            properties.push(Property::new(p.name, shown));
            for i in v.parameters() {
                if !parameters.iter().any(|n| n == names[i]) {
                    parameters.push(names[i].to_string());
                }
            }
        }
        let value = |name: &str| {
            let i = e.kind.properties().iter().position(|p| p.name == name)?;
            e.values[i].as_ref().map(|v| v.at(theta))
        };
        if is_mass(e) {
            let offset = ["offset_x", "offset_y", "offset_z"].map(|n| value(n).unwrap_or(0.0));
            masses.push(PointMass {
                name: e.name.clone(),
                node: e.nodes[0],
                mass: value("mass"),
                offset: (offset != [0.0; 3]).then_some(offset),
                parameters,
                properties,
            });
        } else {
            let mut z_axis = None;
            if e.kind.axes() == Axes::AlongNodes && e.kind.nodes().concat().contains(&Dof::Ry) {
                z_axis = Some(e.axes[2].map(|c| (c * 1e4).round() / 1e4));
                let [x, y, z] = e.axes[2].map(|c| format!("{:.3}", if c.abs() < 5e-4 { 0.0 } else { c }));
                let how = if e.orientation.is_some() { "stated" } else { "default" };
                let how = if e.turn == 0.0 { how.to_string() } else { format!("{how}, turned to principal axes") };
                properties.push(Property::new("z axis of the section", format!("{x}, {y}, {z} ({how})")));
            }
            let group = group(e).to_string();
            let kind = if e.kind.axes() == Axes::AlongNodes { "beam".into() } else { e.kind.name().to_string() };
            elements.push(Element {
                name: e.name.clone(),
                kind,
                nodes: e.nodes.clone(),
                group,
                parameters,
                property_set: None,
                properties,
                z_axis,
            });
        }
    }
    let node = |name: &String| geometry.node(name);
    // An entry that holds nothing says how much others give.
    let rigid_links = spec
        .rigid_links
        .iter()
        .filter(|(_, l)| !l.is_compliance_of_others())
        .filter_map(|(name, l)| {
            let slaves = l.slaves.iter().filter_map(node).collect();
            Some(RigidLink { name: name.clone(), master: node(&l.master)?, slaves })
        })
        .collect();
    let mut supports = Vec::new();
    for s in spec.supports.values().filter(|s| s.fixed.as_ref().is_none_or(|all| !all.is_empty())) {
        let dofs = match &s.fixed {
            None => "all".to_string(),
            Some(list) => list.iter().map(|d| Dof::from(*d).name()).collect::<Vec<_>>().join(" "),
        };
        for n in s.nodes().filter_map(node) {
            supports.push(Support { node: n, dofs: dofs.clone() });
        }
    }
    let sensors = test
        .sensors
        .iter()
        .map(|s| {
            let attached_to = match &s.place {
                retune::data::Place::Node { node, .. } => node.clone(),
                retune::data::Place::Element { element, fraction, .. } => format!("{element} at {fraction}"),
            };
            Ok(Sensor {
                name: s.name.clone(),
                position: sensor_position(model, s)?,
                direction: s.direction,
                is_rotation: s.is_rotation,
                attached_to,
            })
        })
        .collect::<Result<Vec<_>, CorrelationError>>()?;
    let property_sets = share(&mut elements);
    Ok(Structure {
        up: Some(2),
        nodes: geometry
            .names
            .iter()
            .zip(&geometry.positions)
            .map(|(name, position)| Node { name: name.clone(), position: *position })
            .collect(),
        elements,
        property_sets,
        rigid_links,
        masses,
        supports,
        sensors,
        ..Structure::default()
    })
}

/// Coordinates; zero where they are rounding of a size.
fn point(at: Vector, size: f64) -> String {
    let [x, y, z] = at.map(|v| number(if v.abs() < 1e-6 * size { 0.0 } else { v }));
    format!("({x}, {y}, {z})")
}
