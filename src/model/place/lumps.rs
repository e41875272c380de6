//! Springs, bushings, point masses, and elements of any other type.

use super::{Entry, Placer};
use crate::catalogue::did_you_mean;
use crate::element::{Dof, Element};
use crate::model::spec::{MassSpec, Named, SectionSpec, SectionValue, SpringSpec};
use crate::yaml::child;
use std::sync::Arc;

impl Placer<'_> {
    pub(super) fn springs(&mut self, room: &str, springs: &Named<SpringSpec>) {
        for (name, spring) in springs {
            let path = child(room, name);
            if !self.claim(name, &path) {
                continue;
            }
            let (kind, nodes) = match (&spring.node, &spring.nodes) {
                (Some(node), None) if room == "springs" => ("ground_spring", vec![(node, child(&path, "node"))]),
                // Along the line between its nodes: `axial`; in any other direction it is a bushing, with rigid arms.
                (None, Some([a, b])) => (
                    if spring.k.contains_key("axial") || spring.c.contains_key("axial") { "spring" } else { "bushing" },
                    vec![(a, child(&path, "nodes[0]")), (b, child(&path, "nodes[1]"))],
                ),
                _ => {
                    let expected = if room == "springs" {
                        "give `node` for a spring to ground, or `nodes: [a, b]`"
                    } else {
                        "a bushing needs `nodes: [a, b]`"
                    };
                    self.error(&path, expected);
                    continue;
                }
            };
            let Some(kind) = self.registry.find(kind) else { continue };
            let mut properties = SectionSpec::new();
            for (prefix, given) in [("k", &spring.k), ("c", &spring.c)] {
                for (direction, scalar) in given {
                    if Dof::from_name(direction).is_none() && direction != "axial" {
                        let words = Dof::ALL.iter().map(|d| d.name()).chain(["axial"]);
                        let suggestion = did_you_mean(direction, words);
                        self.error(format!("{path}.{prefix}.{direction}"), format_args!("unknown direction `{direction}`, expected `ux`, `uy`, `uz`, `rx`, `ry`, `rz` or `axial`{suggestion}"));
                        continue;
                    }
                    let property =
                        if direction == "axial" { prefix.to_string() } else { format!("{prefix}_{direction}") };
                    properties.insert(property, SectionValue::Scalar(scalar.clone()));
                }
            }
            if let Some(location) = &spring.location {
                properties.insert("location".to_string(), SectionValue::Scalar(location.clone()));
            }
            if spring.k.is_empty() && spring.c.is_empty() {
                self.error(&path, "a spring needs a stiffness, `k: {uz: 150 N/m}`, or damping, `c: {uz: 3 N s/m}`");
            }
            let before = self.problems.len();
            let mut entry = Entry {
                path: &path,
                kind,
                section: None,
                values: Arc::new(self.values(kind, &[(&properties, path.clone())])),
                orientation: None,
                frame: spring.frame.as_deref(),
                arms: Vec::new(),
                turn: 0.0,
            };
            // Properties are `k_uz` in the catalogue and `k: {uz: ...}` in the file.
            for p in &mut self.problems[before..] {
                for prefix in ["k", "c"] {
                    p.path = p.path.replacen(&format!("{path}.{prefix}_"), &format!("{path}.{prefix}."), 1);
                }
            }
            match (&spring.offsets, nodes.len()) {
                (Some(offsets), 2) => entry.arms = self.arms(offsets, &path),
                (Some(_), _) => self.error(child(&path, "offsets"), "`offsets` are of the two `nodes` of a spring"),
                (None, _) => {}
            }
            let indices: Vec<Option<usize>> = nodes.iter().map(|(n, p)| self.node(n, p)).collect();
            if let Some(indices) = indices.into_iter().collect::<Option<Vec<_>>>() {
                self.add(name.clone(), &entry, indices);
            }
        }
    }

    pub(super) fn masses(&mut self) {
        let Some(kind) = self.registry.find("point_mass") else { return };
        for (name, mass) in &self.spec.masses {
            let path = child("masses", name);
            if !self.claim(name, &path) {
                continue;
            }
            let nodes: Vec<(&String, String)> = match (&mass.node, &mass.nodes) {
                (Some(node), None) => vec![(node, child(&path, "node"))],
                (None, Some(nodes)) => {
                    nodes.iter().enumerate().map(|(i, n)| (n, format!("{path}.nodes[{i}]"))).collect()
                }
                _ => {
                    self.error(&path, "give `node` or `nodes`");
                    continue;
                }
            };
            let Some(properties) = self.mass_properties(mass, &path) else { continue };
            let before = self.problems.len();
            let values = self.values(kind, &[(&properties, path.clone())]);
            for p in &mut self.problems[before..] {
                p.path = p.path.replacen(&format!("{path}.inertia_"), &format!("{path}.inertia."), 1).replacen(
                    &format!("{path}.offset_"),
                    &format!("{path}.offset."),
                    1,
                );
            }
            let entry = Entry {
                path: &path,
                kind,
                section: None,
                values: Arc::new(values),
                orientation: None,
                frame: mass.frame.as_deref(),
                arms: Vec::new(),
                turn: 0.0,
            };
            let single = mass.node.is_some();
            for (i, (node, node_path)) in nodes.iter().enumerate() {
                let Some(index) = self.node(node, node_path) else { continue };
                let element = if single { name.clone() } else { format!("{name}.{}", i + 1) };
                if !single && !self.claim(&element, &path) {
                    continue;
                }
                if let Some(e) = self.add(element, &entry, vec![index]) {
                    let set = self.sets.entry(name.clone()).or_default();
                    if !set.contains(&e) {
                        set.push(e);
                    }
                }
            }
        }
    }

    /// `inertia: {yy: ...}` and `offset: [...]` as the catalogue's `inertia_yy` and `offset_x`.
    pub(super) fn mass_properties(&mut self, mass: &MassSpec, path: &str) -> Option<SectionSpec> {
        let mut properties = SectionSpec::new();
        if let Some(m) = &mass.mass {
            properties.insert("mass".to_string(), SectionValue::Scalar(m.clone()));
        }
        for (axis, scalar) in &mass.inertia {
            const AXES: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];
            if !AXES.contains(&axis.as_str()) {
                self.error(
                    format!("{path}.inertia.{axis}"),
                    format_args!("unknown inertia `{axis}`, expected one of `xx`, `yy`, `zz`, `xy`, `xz`, `yz`"),
                );
                return None;
            }
            properties.insert(format!("inertia_{axis}"), SectionValue::Scalar(scalar.clone()));
        }
        if properties.is_empty() {
            self.error(path, "a point mass needs `mass` or `inertia`");
            return None;
        }
        if let Some(offset) = &mass.offset {
            for (axis, scalar) in ["x", "y", "z"].iter().zip(offset) {
                properties.insert(format!("offset_{axis}"), SectionValue::Scalar(scalar.clone()));
            }
        }
        Some(properties)
    }

    pub(super) fn others(&mut self) {
        for (name, spec) in &self.spec.elements {
            let path = child("elements", name);
            if !self.claim(name, &path) {
                continue;
            }
            let Some(kind) = self.registry.find(&spec.kind) else {
                let suggestion = did_you_mean(&spec.kind, self.registry.elements().map(Element::name));
                let known: Vec<String> = self.registry.elements().map(|e| format!("`{}`", e.name())).collect();
                self.error(
                    child(&path, "type"),
                    format_args!(
                        "unknown element type `{}`, expected one of {}{suggestion}",
                        spec.kind,
                        known.join(", ")
                    ),
                );
                continue;
            };
            if spec.nodes.len() != kind.nodes().len() {
                self.error(
                    child(&path, "nodes"),
                    format_args!("a {} has {} nodes, not {}", kind.name(), kind.nodes().len(), spec.nodes.len()),
                );
                continue;
            }
            let mut entry = self.entry(&path, kind, spec.section.as_deref(), &spec.properties);
            entry.orientation = spec.orientation;
            entry.frame = spec.frame.as_deref();
            let indices: Vec<Option<usize>> =
                spec.nodes.iter().enumerate().map(|(i, n)| self.node(n, &format!("{path}.nodes[{i}]"))).collect();
            if let Some(indices) = indices.into_iter().collect::<Option<Vec<_>>>() {
                self.add(name.clone(), &entry, indices);
            }
        }
    }
}
