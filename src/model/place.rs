//! From the entries of the file to placed elements: nodes, axes, and property values as functions of θ.

use super::geometry::{Geometry, Rotation, axes_along, constant, minus, unit, unknown};
use super::parameter::{Parameter, ParameterSet};
use super::registry::Registry;
use super::spec::{
    MassSpec, MemberSpec, ModelSpec, Named, OverrideSpec, SectionSpec, SectionValue, ShapeSpec, SpringSpec,
};
use super::value::{Affine, Value};
use crate::catalogue::did_you_mean;
use crate::element::{Axes, Dof, Domain, Element};
use crate::units::Scalar;
use crate::units::{Dimension, Unit};
use crate::yaml::{Problem, child};
use std::collections::BTreeMap;

/// An element in its place.
#[derive(Debug, Clone)]
pub struct PlacedElement {
    /// Its name: that of its entry, or `entry.2` for the second of a chain, or `entry.2/1` for a part of it.
    pub name: String,
    /// Its type.
    pub kind: &'static dyn Element,
    /// Indices of its nodes.
    pub nodes: Vec<usize>,
    /// Its axes.
    pub axes: Rotation,
    /// Positions of its nodes in its axes, relative to the first, m.
    pub points: Vec<[f64; 3]>,
    /// Its property values, in the order of the type's properties.
    pub values: Vec<Option<Value>>,
    /// Factor on its stiffness.
    pub stiffness_factor: Option<Value>,
    /// Factor on its mass.
    pub mass_factor: Option<Value>,
    /// Path of its entry in the file.
    pub path: String,
    /// Name of its section, if any.
    pub section: Option<String>,
}

/// What the file describes, before assembly.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) geometry: Geometry,
    pub(super) parameters: ParameterSet,
    pub(super) elements: Vec<PlacedElement>,
    /// Name of an element, chain, mass or group -> indices of elements.
    pub(super) sets: BTreeMap<String, Vec<usize>>,
}

/// Reads parameters; bounds and units are checked.
pub(super) fn parameters(spec: &ModelSpec, problems: &mut Vec<Problem>) -> (ParameterSet, BTreeMap<String, Dimension>) {
    let mut set = Vec::new();
    let mut dimensions = BTreeMap::new();
    for (name, p) in &spec.parameters {
        let path = child("parameters", name);
        if !name.starts_with(|c: char| c.is_alphabetic() || c == '_')
            || !name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '.' | ':' | '@'))
        {
            problems.push(Problem::error(
                &path,
                "a parameter's name starts with a letter and has only letters, digits, `_`, `.`, `:`, `@`",
            ));
        }
        let unit_text = p
            .unit
            .clone()
            .or_else(|| written_unit(&p.value))
            .or_else(|| p.bounds.as_ref().and_then(|b| written_unit(&b[1])));
        let unit = match unit_text.as_deref().map(Unit::parse) {
            None => None,
            Some(Ok(unit)) => Some(unit),
            Some(Err(e)) => {
                problems.push(Problem::error(child(&path, "unit"), e));
                None
            }
        };
        let number = |s: &Scalar, key: &str, problems: &mut Vec<Problem>| -> f64 {
            let path = child(&path, key);
            let dimension = s.terms().first().and_then(|t| t.dimension);
            if let (Some(d), Some(u)) = (dimension, unit) {
                if d != u.dimension {
                    let unit = unit_text.as_deref().unwrap_or("1");
                    problems.push(Problem::error(
                        &path,
                        format_args!("the unit of `{}` does not fit: expected {unit}", s.text()),
                    ));
                }
            } else if dimension.is_none()
                && unit.is_some_and(|u| u.dimension != Dimension::NONE && u.factor != 1.0)
                && p.unit.is_none()
                && s.terms().iter().any(|t| t.factor != 0.0)
            {
                let unit = unit_text.as_deref().unwrap_or("1");
                problems.push(Problem::error(
                    &path,
                    format_args!(
                        "`{}` has no unit while others of this parameter are in {unit}; write `{} {unit}`",
                        s.text(),
                        s.text()
                    ),
                ));
            }
            if s.terms().iter().any(|t| t.parameter.is_some()) {
                problems.push(Problem::error(
                    path,
                    format_args!("`{}` names another parameter; here a number is needed", s.text()),
                ));
                return 0.0;
            }
            s.terms().iter().map(|t| t.factor).sum()
        };
        let before = problems.len();
        let value = number(&p.value, "value", problems);
        let bounds =
            p.bounds.as_ref().map(|b| [number(&b[0], "bounds[0]", problems), number(&b[1], "bounds[1]", problems)]);
        if let Some([lower, upper]) = bounds.filter(|_| problems.len() == before) {
            if lower >= upper {
                problems.push(Problem::error(
                    child(&path, "bounds"),
                    format_args!(
                        "the lower bound `{}` must be below the upper `{}`",
                        p.bounds.as_ref().map_or("", |b| b[0].text()),
                        p.bounds.as_ref().map_or("", |b| b[1].text())
                    ),
                ));
            } else if value < lower || value > upper {
                problems.push(Problem::warning(
                    child(&path, "value"),
                    format_args!(
                        "the estimate {} lies outside its bounds {} .. {}; an update starts from the nearest bound",
                        p.value.text(),
                        p.bounds.as_ref().map_or("", |b| b[0].text()),
                        p.bounds.as_ref().map_or("", |b| b[1].text())
                    ),
                ));
            }
        }
        let prior_sd = p.prior_sd.as_ref().map(|s| number(s, "prior_sd", problems));
        if prior_sd.is_some_and(|sd| sd <= 0.0) {
            problems.push(Problem::error(child(&path, "prior_sd"), "a standard deviation must be above zero"));
        }
        if let Some(u) = unit {
            dimensions.insert(name.clone(), u.dimension);
        }
        set.push(Parameter {
            name: name.clone(),
            unit: unit_text.unwrap_or_default(),
            unit_factor: unit.map_or(1.0, |u| u.factor),
            value,
            bounds,
            prior_sd,
            description: p.description.clone(),
        });
    }
    (ParameterSet::new(set), dimensions)
}

/// The unit as written behind a number: `GPa` of `56 GPa`.
fn written_unit(s: &Scalar) -> Option<String> {
    s.terms().first().and_then(|t| t.dimension)?;
    let text = s.text();
    let end = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | ' ' | 'e' | 'E')))?;
    Some(text[end..].trim().to_string())
}

/// Places everything; all problems are collected.
pub(super) fn place(spec: &ModelSpec, registry: &Registry, problems: &mut Vec<Problem>) -> Placed {
    let geometry = super::geometry::resolve(spec, problems);
    let (parameters, dimensions) = parameters(spec, problems);
    let mut placer = Placer {
        spec,
        registry,
        parameters: &parameters,
        dimensions: &dimensions,
        geometry,
        elements: Vec::new(),
        sets: BTreeMap::new(),
        problems,
    };
    placer.members("beams", &spec.beams, "beam");
    placer.members("bars", &spec.bars, "bar");
    placer.springs("springs", &spec.springs);
    placer.springs("bushings", &spec.bushings);
    placer.masses();
    placer.others();
    placer.groups();
    placer.overrides();
    let (geometry, elements, sets) = (placer.geometry, placer.elements, placer.sets);
    Placed { geometry, parameters, elements, sets }
}

/// A number as people write it: `-7850`, `0.05`, and powers of ten only where they are shorter.
fn plain(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// Far above what a beam model needs; a misspelt `subdivide` is refused before it fills the memory.
const MOST_ELEMENTS: usize = 20_000;

struct Placer<'a> {
    spec: &'a ModelSpec,
    registry: &'a Registry,
    parameters: &'a ParameterSet,
    dimensions: &'a BTreeMap<String, Dimension>,
    geometry: Geometry,
    elements: Vec<PlacedElement>,
    sets: BTreeMap<String, Vec<usize>>,
    problems: &'a mut Vec<Problem>,
}

/// What an entry says of its elements beside their nodes.
struct Entry<'a> {
    path: &'a str,
    kind: &'static dyn Element,
    section: Option<&'a str>,
    values: Vec<Option<Value>>,
    orientation: Option<[f64; 3]>,
    frame: Option<&'a str>,
}

impl Placer<'_> {
    fn error(&mut self, path: impl Into<String>, message: impl std::fmt::Display) {
        self.problems.push(Problem::error(path, message));
    }

    fn node(&mut self, name: &str, path: &str) -> Option<usize> {
        let found = self.geometry.node(name);
        if found.is_none() {
            self.problems.push(unknown(path, "node", name, self.spec.nodes.keys()));
        }
        found
    }

    fn claim(&mut self, name: &str, path: &str) -> bool {
        if self.sets.contains_key(name) {
            self.error(path, format_args!("the name `{name}` is taken by another element, chain or mass"));
            return false;
        }
        self.sets.insert(name.to_string(), Vec::new());
        true
    }

    /// A scalar as a function of θ, in the unit of the property.
    fn affine(&mut self, scalar: &Scalar, unit: &str, path: &str) -> Option<Affine> {
        match scalar.affine_in(unit, &|name| self.dimensions.get(name).copied()) {
            Ok((constant, terms)) => {
                let mut affine = Affine { constant, terms: Vec::new() };
                for (name, factor) in terms {
                    if let Some(i) = self.parameters.index_of(&name) {
                        affine.terms.push((i, factor));
                    } else {
                        let mut problem = unknown(path, "parameter", &name, self.spec.parameters.keys());
                        if Unit::parse(&name).is_ok() {
                            let hint = format!("; a unit stands behind a number, `1 {name}`");
                            problem.message.push_str(&hint);
                        }
                        self.problems.push(problem);
                        return None;
                    }
                }
                Some(affine)
            }
            Err(e) => {
                self.error(path, e);
                None
            }
        }
    }

    /// Property values of a type from sets of them, the later ones first.
    fn values(&mut self, kind: &'static dyn Element, sets: &[(&SectionSpec, String)]) -> Vec<Option<Value>> {
        let properties = kind.properties();
        let mut values: Vec<Option<Value>> = vec![None; properties.len()];
        for (set, path) in sets {
            for (name, value) in *set {
                let path = child(path, name);
                match value {
                    SectionValue::Shape(shape) if name == "shape" => {
                        for (property, v) in self.shape(shape, &path) {
                            if let Some(i) = properties.iter().position(|p| p.name == property) {
                                values[i].get_or_insert(Value::constant(v));
                            }
                        }
                    }
                    SectionValue::Shape(_) => self.error(path, "a cross-section stands under the key `shape`"),
                    SectionValue::Scalar(_) if name == "shape" => {
                        self.error(
                            path,
                            "expected a cross-section such as `{rectangle: {width: 20 mm, height: 5 mm}}`",
                        );
                    }
                    SectionValue::Scalar(scalar) => {
                        let Some(i) = properties.iter().position(|p| p.name == name) else {
                            let suggestion = did_you_mean(name, properties.iter().map(|p| p.name));
                            self.error(
                                path,
                                format_args!(
                                    "a {} has no property `{name}`{suggestion} (see `retune explain {}`)",
                                    kind.name(),
                                    kind.name()
                                ),
                            );
                            continue;
                        };
                        if let Some(affine) = self.affine(scalar, properties[i].unit, &path) {
                            self.domain(&affine, properties[i].domain, properties[i].name, properties[i].unit, &path);
                            values[i].get_or_insert(Value(vec![affine]));
                        }
                    }
                }
            }
        }
        values
    }

    /// Checks a property at the estimates (an error) and over the bounds (a warning).
    fn domain(&mut self, affine: &Affine, domain: Domain, name: &str, unit: &str, path: &str) {
        let parameters = self.parameters;
        let theta = parameters.nominal();
        let fits = |v: f64| match domain {
            Domain::Positive => v > 0.0,
            Domain::NonNegative => v >= 0.0,
            Domain::Fraction => (0.0..=1.0).contains(&v),
            Domain::Any => true,
        };
        let must = match domain {
            Domain::Positive => "above zero",
            Domain::Fraction => "between 0 and 1",
            Domain::NonNegative | Domain::Any => "zero or above",
        };
        let now = affine.at(&theta);
        if !fits(now) {
            self.error(path, format_args!("`{name}` is {} {unit}; it must be {must}", plain(now)));
            return;
        }
        let [low, _] = affine.range(&|i| parameters.get(i).bounds.unwrap_or([theta[i]; 2]));
        if !fits(low) {
            self.problems.push(Problem::warning(
                path,
                format_args!(
                    "within the bounds of its parameters `{name}` can become {} {unit}; it must be {must}",
                    plain(low)
                ),
            ));
        }
    }

    fn shape(&mut self, shape: &ShapeSpec, path: &str) -> Vec<(&'static str, f64)> {
        use std::f64::consts::PI;
        let given = [shape.rectangle.is_some(), shape.hollow.is_some(), shape.circle.is_some(), shape.tube.is_some()];
        if given.iter().filter(|g| **g).count() != 1 {
            self.error(path, "give exactly one of `rectangle`, `box`, `circle`, `tube`");
            return Vec::new();
        }
        let mut length = |s: &Scalar, key: &str| {
            let path = child(path, key);
            let v = constant(s, "m", &path, self.problems);
            if v <= 0.0 {
                self.problems.push(Problem::error(path, format_args!("`{}` must be above zero", s.text())));
            }
            v
        };
        let (area, iy, iz, j) = if let Some(s) = &shape.rectangle {
            let (b, h) = (length(&s.width, "rectangle.width"), length(&s.height, "rectangle.height"));
            // Torsion constant of a rectangle, error below 0.01 %: Roark's Formulas for Stress and Strain, table 10.7.
            let (long, short) = (b.max(h), b.min(h));
            let r = short / long;
            let j = long * short.powi(3) * (1.0 / 3.0 - 0.21 * r * (1.0 - r.powi(4) / 12.0));
            (b * h, b * h.powi(3) / 12.0, h * b.powi(3) / 12.0, j)
        } else if let Some(s) = &shape.hollow {
            let (b, h, t) =
                (length(&s.width, "box.width"), length(&s.height, "box.height"), length(&s.wall, "box.wall"));
            let (bi, hi) = (b - 2.0 * t, h - 2.0 * t);
            if bi < 0.0 || hi < 0.0 {
                self.problems.push(Problem::error(child(path, "box.wall"), "the walls are thicker than the box"));
            }
            let j = 2.0 * t * (b - t).powi(2) * (h - t).powi(2) / (b + h - 2.0 * t);
            (b * h - bi * hi, (b * h.powi(3) - bi * hi.powi(3)) / 12.0, (h * b.powi(3) - hi * bi.powi(3)) / 12.0, j)
        } else if let Some(s) = &shape.circle {
            let d = length(&s.diameter, "circle.diameter");
            let i = PI * d.powi(4) / 64.0;
            (PI * d * d / 4.0, i, i, 2.0 * i)
        } else if let Some(s) = &shape.tube {
            let (d, t) = (length(&s.diameter, "tube.diameter"), length(&s.wall, "tube.wall"));
            let inner = d - 2.0 * t;
            if inner < 0.0 {
                self.problems.push(Problem::error(child(path, "tube.wall"), "the wall is thicker than the tube"));
            }
            let i = PI * (d.powi(4) - inner.powi(4)) / 64.0;
            (PI * (d * d - inner * inner) / 4.0, i, i, 2.0 * i)
        } else {
            return Vec::new();
        };
        vec![("A", area), ("Iy", iy), ("Iz", iz), ("J", j)]
    }

    fn entry<'b>(
        &mut self,
        path: &'b str,
        kind: &'static dyn Element,
        section: Option<&'b str>,
        properties: &SectionSpec,
    ) -> Entry<'b> {
        let mut sets = vec![(properties, child(path, "properties"))];
        if let Some(name) = section {
            match self.spec.sections.get(name) {
                Some(s) => sets.push((s, child("sections", name))),
                None => {
                    self.problems.push(unknown(&child(path, "section"), "section", name, self.spec.sections.keys()));
                }
            }
        }
        let values = self.values(kind, &sets);
        Entry { path, kind, section, values, orientation: None, frame: None }
    }

    /// Adds an element on nodes; `name` is claimed by the caller.
    fn add(&mut self, name: String, entry: &Entry<'_>, nodes: Vec<usize>) -> Option<usize> {
        let positions: Vec<_> = nodes.iter().map(|&i| self.geometry.positions[i]).collect();
        if positions.iter().flatten().any(|v| v.is_nan()) {
            return None; // its node has no place, which is said there
        }
        let axes = match entry.kind.axes() {
            Axes::AlongNodes => {
                let along = minus(positions[1], positions[0]);
                let Some(x) = unit(along) else {
                    let (a, b) = (&self.geometry.names[nodes[0]], &self.geometry.names[nodes[1]]);
                    self.problems.push(Problem::error(
                        entry.path,
                        format_args!("element `{name}` has no length: nodes `{a}` and `{b}` are at the same place"),
                    ));
                    return None;
                };
                let near =
                    entry.orientation.unwrap_or(if x[2].abs() > 0.9999 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] });
                let Some(axes) = axes_along(along, near) else {
                    let path = child(entry.path, "orientation");
                    if !self.problems.iter().any(|p| p.path == path) {
                        let why = match unit(near) {
                            Some(_) => format!(
                                "it must not be parallel to element `{name}`: it is a direction near the element's z axis"
                            ),
                            None => "it must be a direction: three finite numbers, not all zero".to_string(),
                        };
                        self.error(path, why);
                    }
                    return None;
                };
                axes
            }
            Axes::Given => self.frame_axes(entry)?,
        };
        let points = positions
            .iter()
            .map(|p| {
                let d = minus(*p, positions[0]);
                axes.map(|a| super::geometry::dot(a, d))
            })
            .collect();
        let index = self.elements.len();
        self.elements.push(PlacedElement {
            name: name.clone(),
            kind: entry.kind,
            nodes,
            axes,
            points,
            values: entry.values.clone(),
            stiffness_factor: None,
            mass_factor: None,
            path: entry.path.to_string(),
            section: entry.section.map(str::to_string),
        });
        self.sets.entry(name).or_default().push(index);
        Some(index)
    }

    fn frame_axes(&mut self, entry: &Entry<'_>) -> Option<Rotation> {
        let Some(name) = entry.frame else { return Some(super::geometry::GLOBAL) };
        let frame = self.geometry.frames.get(name).map(|f| f.axes);
        if frame.is_none() && !self.spec.frames.contains_key(name) {
            self.problems.push(unknown(&child(entry.path, "frame"), "frame", name, self.spec.frames.keys()));
        }
        frame
    }

    fn members(&mut self, room: &str, members: &Named<MemberSpec>, kind: &str) {
        let Some(kind) = self.registry.find(kind) else { return };
        for (name, member) in members {
            let path = child(room, name);
            if !self.claim(name, &path) {
                continue;
            }
            let mut entry = self.entry(&path, kind, member.section.as_deref(), &member.properties);
            entry.orientation = member.orientation;
            let (pairs, single) = match (&member.nodes, &member.pairs, &member.chain) {
                (Some(nodes), None, None) => {
                    (vec![(nodes.clone(), [child(&path, "nodes[0]"), child(&path, "nodes[1]")])], true)
                }
                (None, Some(pairs), None) => (
                    pairs
                        .iter()
                        .enumerate()
                        .map(|(i, p)| (p.clone(), [0, 1].map(|k| format!("{path}.pairs[{i}][{k}]"))))
                        .collect(),
                    false,
                ),
                (None, None, Some(chain)) => {
                    if chain.len() < 2 {
                        self.error(child(&path, "chain"), "a chain needs at least two nodes");
                    }
                    let at = |i: usize| format!("{path}.chain[{i}]");
                    (
                        chain
                            .windows(2)
                            .enumerate()
                            .map(|(i, w)| {
                                ([w[0].clone(), w[1].clone()], [if i == 0 { at(0) } else { String::new() }, at(i + 1)])
                            })
                            .collect(),
                        false,
                    )
                }
                _ => {
                    self.error(&path, "give exactly one of `nodes`, `pairs`, `chain`");
                    continue;
                }
            };
            let parts = member.subdivide.unwrap_or(1);
            if parts == 0 || parts > 10_000 {
                self.error(child(&path, "subdivide"), "it must be between 1 and 10000");
                continue;
            }
            let most = MOST_ELEMENTS.saturating_sub(self.elements.len());
            if pairs.len().saturating_mul(parts as usize) > most {
                self.error(
                    if parts > 1 { child(&path, "subdivide") } else { path.clone() },
                    format_args!("with this the model has more than {MOST_ELEMENTS} elements"),
                );
                continue;
            }
            for (i, (nodes, paths)) in pairs.iter().enumerate() {
                let found: Vec<Option<usize>> = (0..2)
                    .map(|k| {
                        if paths[k].is_empty() {
                            self.geometry.node(&nodes[k])
                        } else {
                            self.node(&nodes[k], &paths[k])
                        }
                    })
                    .collect();
                let (Some(a), Some(b)) = (found[0], found[1]) else { continue };
                let element = if single { name.clone() } else { format!("{name}.{}", i + 1) };
                if !single && !self.claim(&element, &path) {
                    continue;
                }
                let first = self.elements.len();
                let mut previous = a;
                for part in 1..=parts {
                    let next = if part == parts { b } else { self.interior(&element, part, parts, a, b) };
                    let part_name = if parts == 1 { element.clone() } else { format!("{element}/{part}") };
                    self.add(part_name, &entry, vec![previous, next]);
                    previous = next;
                }
                let made: Vec<usize> = (first..self.elements.len()).collect();
                for set in [&element, name] {
                    let set = self.sets.entry(set.clone()).or_default();
                    // Indices ascend, so those from the last one on are new.
                    let known = set.last().copied();
                    set.extend(made.iter().filter(|e| known.is_none_or(|last| last < **e)));
                }
            }
        }
    }

    /// A node inside a subdivided element.
    fn interior(&mut self, element: &str, part: u32, parts: u32, a: usize, b: usize) -> usize {
        let (pa, pb) = (self.geometry.positions[a], self.geometry.positions[b]);
        let f = f64::from(part) / f64::from(parts);
        self.geometry.names.push(format!("{element}/{part}"));
        self.geometry.positions.push(super::geometry::plus(pa, f, minus(pb, pa)));
        self.geometry.names.len() - 1
    }

    fn springs(&mut self, room: &str, springs: &Named<SpringSpec>) {
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
                values: self.values(kind, &[(&properties, path.clone())]),
                orientation: None,
                frame: spring.frame.as_deref(),
            };
            // Properties are `k_uz` in the catalogue and `k: {uz: ...}` in the file.
            for p in &mut self.problems[before..] {
                for prefix in ["k", "c"] {
                    p.path = p.path.replacen(&format!("{path}.{prefix}_"), &format!("{path}.{prefix}."), 1);
                }
            }
            entry.frame = spring.frame.as_deref();
            let indices: Vec<Option<usize>> = nodes.iter().map(|(n, p)| self.node(n, p)).collect();
            if let Some(indices) = indices.into_iter().collect::<Option<Vec<_>>>() {
                self.add(name.clone(), &entry, indices);
            }
        }
    }

    fn masses(&mut self) {
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
            let entry =
                Entry { path: &path, kind, section: None, values, orientation: None, frame: mass.frame.as_deref() };
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
    fn mass_properties(&mut self, mass: &MassSpec, path: &str) -> Option<SectionSpec> {
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

    fn others(&mut self) {
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

    fn groups(&mut self) {
        for (name, members) in &self.spec.groups {
            let path = child("groups", name);
            if !self.claim(name, &path) {
                continue;
            }
            let mut all = Vec::new();
            for (i, member) in members.iter().enumerate() {
                match self.sets.get(member) {
                    Some(set) if member != name => all.extend(set),
                    _ => {
                        let suggestion = did_you_mean(member, self.sets.keys().map(String::as_str));
                        self.error(
                            format!("{path}[{i}]"),
                            format_args!("`{member}` is no element, chain, mass or earlier group{suggestion}"),
                        );
                    }
                }
            }
            all.sort_unstable();
            all.dedup();
            self.sets.insert(name.clone(), all);
        }
    }

    fn overrides(&mut self) {
        for (name, change) in &self.spec.overrides {
            let path = child("overrides", name);
            let Some(elements) = self.sets.get(name).cloned() else {
                let suggestion = did_you_mean(name, self.sets.keys().map(String::as_str));
                self.error(&path, format_args!("`{name}` is no element, chain, mass or group{suggestion}"));
                continue;
            };
            self.override_elements(change, &path, &elements);
        }
    }

    fn override_elements(&mut self, change: &OverrideSpec, path: &str, elements: &[usize]) {
        for (what, given) in [("set", &change.set), ("scale", &change.scale)] {
            for (property, scalar) in given {
                let path = format!("{path}.{what}.{property}");
                let known: Vec<&str> =
                    elements.iter().flat_map(|&e| self.elements[e].kind.properties()).map(|p| p.name).collect();
                if !known.contains(&property.as_str()) {
                    let suggestion = did_you_mean(property, known);
                    self.error(path, format_args!("these elements have no property `{property}`{suggestion}"));
                    continue;
                }
                for &e in elements {
                    let kind = self.elements[e].kind;
                    let Some(i) = kind.properties().iter().position(|p| p.name == property) else { continue };
                    let unit = if what == "set" { kind.properties()[i].unit } else { "1" };
                    let before = self.problems.len();
                    let Some(affine) = self.affine(scalar, unit, &path) else {
                        self.problems.truncate(before + 1);
                        break;
                    };
                    if what == "set" {
                        self.elements[e].values[i] = Some(Value(vec![affine]));
                    } else if let Some(value) = &mut self.elements[e].values[i] {
                        value.0.push(affine);
                    } else {
                        self.error(
                            &path,
                            format_args!("element `{}` has no `{property}` to scale", self.elements[e].name.clone()),
                        );
                    }
                }
            }
        }
        for (word, factor) in [("stiffness", &change.stiffness), ("mass", &change.mass)] {
            let Some(factor) = factor else { continue };
            let Some(affine) = self.affine(factor, "1", &child(path, word)) else { continue };
            for &e in elements {
                let slot = if word == "stiffness" {
                    &mut self.elements[e].stiffness_factor
                } else {
                    &mut self.elements[e].mass_factor
                };
                slot.get_or_insert(Value(Vec::new())).0.push(affine.clone());
            }
        }
    }
}
