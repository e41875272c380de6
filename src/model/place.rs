//! From the entries of the file to placed elements: nodes, axes, and property values as functions of θ.

mod axes;
mod edges;
mod ends;
mod lumps;
mod mesh;
mod moving;
mod overrides;
mod parameters;
mod plies;
mod section;
mod shape;
mod superelements;
mod supports;
mod ties;

pub(super) use moving::riding;
pub(super) use parameters::parameters;
pub(super) use superelements::left_out_of_effects;

use super::geometry::{Geometry, Rotation, axes_along, minus, plus, turned, unit, unknown, vector};
use super::inside::{counted_name, point_name, stretch, stretch_name};
use super::known::Known;
use super::moving::EndMotion;
use super::parameter::ParameterSet;
use super::placed_element::{Compliance, PlacedElement};
use super::registry::Registry;
use super::spec::{MemberSpec, ModelSpec, Named, SectionSpec};
use super::value::{Affine, Value};
use crate::element::{Axes, Element};
use crate::units::Dimension;
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// What the file describes, before assembly.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) geometry: Geometry,
    pub(super) parameters: ParameterSet,
    pub(super) elements: Vec<PlacedElement>,
    /// Name of an element, chain, mass or group -> indices of elements.
    pub(super) sets: BTreeMap<String, Vec<usize>>,
    /// How much held dofs give.
    pub(super) compliances: Vec<Compliance>,
    /// Sums of dofs of nodes, 6 node + dof, that are zero because superelements and ties say so.
    pub(super) rows: Vec<Vec<(usize, f64)>>,
    /// Nodes at which effects are looked for: those of the file, and some of a mesh and of superelements.
    pub(super) sites: Vec<usize>,
    /// Names of the parts of a mesh: of one that was read, or groups of shells and solids of the file.
    pub(super) mesh_parts: Vec<String>,
    /// Names of the patches of parts of a mesh.
    pub(super) patches: Vec<String>,
    /// Number of nodes that have names: those of the file and of superelements.
    pub(super) n_named: usize,
    /// Damping ratio of every elastic mode.
    pub(super) modal_damping: Option<Affine>,
    /// How nodes move that parameters move, or what carries them.
    pub(super) moved: BTreeMap<usize, EndMotion>,
}

/// Places everything; all problems are collected.
pub(super) fn place(spec: &ModelSpec, registry: &Registry, problems: &mut Vec<Problem>) -> Placed {
    let (parameters, dimensions) = parameters(spec, problems);
    let known = Known { spec, parameters: &parameters, dimensions: &dimensions };
    let geometry = super::geometry::resolve(spec, &known, problems);
    let modal_damping = damping_ratio(&known, problems);
    let mut placer = Placer {
        spec,
        registry,
        parameters: &parameters,
        dimensions: &dimensions,
        geometry,
        elements: Vec::new(),
        sets: BTreeMap::new(),
        stretches: HashMap::new(),
        compliances: Vec::new(),
        rows: Vec::new(),
        sites: Vec::new(),
        mesh_parts: Vec::new(),
        patches: Vec::new(),
        problems,
    };
    placer.mesh();
    placer.superelements();
    let n_named = placer.geometry.names.len();
    placer.members("beams", &spec.beams, "beam");
    placer.members("bars", &spec.bars, "bar");
    placer.springs("springs", &spec.springs);
    placer.springs("bushings", &spec.bushings);
    placer.masses();
    placer.others();
    placer.groups();
    placer.listed_mesh();
    placer.ties();
    placer.overrides();
    placer.supports();
    let Placer { geometry, mut elements, sets, compliances, rows, sites, mesh_parts, patches, .. } = placer;
    let mut sites = sites;
    sites.sort_unstable();
    sites.dedup();
    axes::check(&elements, &parameters, problems);
    edges::straighten(&mut elements);
    let moved = moving::follow(spec, &geometry, &parameters, &mut elements, problems);
    Placed {
        geometry,
        parameters,
        elements,
        sets,
        compliances,
        rows,
        sites,
        mesh_parts,
        patches,
        n_named,
        modal_damping,
        moved,
    }
}

/// The damping ratio of every elastic mode, which is between zero and one for all values of its parameters.
fn damping_ratio(known: &Known<'_>, problems: &mut Vec<Problem>) -> Option<Affine> {
    let ratio = known.affine(known.spec.modal_damping.as_ref()?, "1", "modal_damping", problems)?;
    let [low, high] = ratio.range(&|j| known.parameters.get(j).range());
    if low < 0.0 || high >= 1.0 {
        let text = format_args!("a damping ratio lies between 0 and 1, and this is {low} to {high}");
        problems.push(Problem::error("modal_damping", text));
    }
    Some(ratio)
}

/// A model of 10⁶ dofs has that many; a misspelt `subdivide` is refused before it fills the memory.
const MOST_ELEMENTS: usize = 1_000_000;

struct Placer<'a> {
    spec: &'a ModelSpec,
    registry: &'a Registry,
    parameters: &'a ParameterSet,
    dimensions: &'a BTreeMap<String, Dimension>,
    geometry: Geometry,
    elements: Vec<PlacedElement>,
    sets: BTreeMap<String, Vec<usize>>,
    /// Name of a member, a part or a group -> the stretches of elements that it is made of, each from its first end to its second.
    stretches: HashMap<String, Vec<Vec<usize>>>,
    compliances: Vec<Compliance>,
    rows: Vec<Vec<(usize, f64)>>,
    sites: Vec<usize>,
    mesh_parts: Vec<String>,
    patches: Vec<String>,
    problems: &'a mut Vec<Problem>,
}

/// What an entry says of its elements beside their nodes.
struct Entry<'a> {
    path: &'a str,
    kind: &'static dyn Element,
    section: Option<&'a str>,
    values: Arc<Vec<Option<Value>>>,
    orientation: Option<[f64; 3]>,
    frame: Option<&'a str>,
    /// Rigid arms from its nodes to its ends, global, m; none where it is empty.
    arms: Vec<[f64; 3]>,
    /// From the stated axes to the principal axes of its cross-section, about x, rad.
    turn: f64,
}

impl Placer<'_> {
    fn error(&mut self, path: impl Into<String>, message: impl std::fmt::Display) {
        self.problems.push(Problem::error(path, message));
    }

    fn node(&mut self, name: &str, path: &str) -> Option<usize> {
        let found = self.geometry.node(name);
        if found.is_none() {
            self.problems.push(unknown(path, "node", name, &self.geometry.names));
        }
        found
    }

    /// The elements of a name: of the file, or of a stretch inside one that is subdivided.
    fn set(&self, name: &str) -> Option<Vec<usize>> {
        let stretch = || stretch(&self.sets, &self.elements, name).map(<[usize]>::to_vec);
        self.sets.get(name).cloned().or_else(stretch)
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
        let known = Known { spec: self.spec, parameters: self.parameters, dimensions: self.dimensions };
        known.affine(scalar, unit, path, self.problems)
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
        let is_bare = section.is_none() && properties.is_empty() && self.spec.overrides.is_empty();
        if is_bare && !kind.properties().is_empty() {
            self.error(
                path.to_string(),
                format_args!(
                    "nothing says what this {} is made of: it has neither a `section` nor `properties`",
                    kind.name()
                ),
            );
        }
        let (values, turn) = self.shaped_values(kind, &sets);
        let values = Arc::new(values);
        Entry { path, kind, section, values, orientation: None, frame: None, arms: Vec::new(), turn }
    }

    /// Adds an element on nodes; `name` is claimed by the caller.
    fn add(&mut self, name: String, entry: &Entry<'_>, nodes: Vec<usize>) -> Option<usize> {
        let arm = |k: usize| entry.arms.get(k).copied().unwrap_or_default();
        let positions: Vec<_> =
            nodes.iter().enumerate().map(|(k, &i)| plus(self.geometry.positions[i], 1.0, arm(k))).collect();
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
                let near = entry.orientation.unwrap_or_else(|| axes::default_near_z(x));
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
                turned(axes, entry.turn)
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
            arms: entry.arms.clone(),
            axes,
            orientation: entry.orientation,
            turn: entry.turn,
            points,
            values: Arc::clone(&entry.values),
            stiffness_factor: None,
            mass_factor: None,
            stiffness_damping: None,
            mass_damping: None,
            moving: None,
            path: entry.path.to_string(),
            section: entry.section.map(str::to_string),
            matrices: None,
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
            if let Some(releases) = &member.releases {
                self.release(&mut entry, releases, &child(&path, "releases"));
            }
            let arms = member.offsets.as_ref().map(|both| self.arms(both, &path));
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
            let whole = self.elements.len();
            let is_chain = member.chain.is_some();
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
                    let ends = arms.as_deref().unwrap_or(&[[0.0; 3]; 2]);
                    let next = if part == parts { b } else { self.interior(&element, [part, parts], [a, b], ends) };
                    if arms.is_some() {
                        // Nodes inside lie on the element itself.
                        let at = |is_end: bool, k: usize| if is_end { ends[k] } else { [0.0; 3] };
                        entry.arms = vec![at(part == 1, 0), at(part == parts, 1)];
                    }
                    let part_name =
                        if parts == 1 { element.clone() } else { stretch_name(&element, [part - 1, part], parts) };
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
                if !is_chain && !single {
                    self.stretches.entry(name.clone()).or_default().push(made.clone());
                }
                self.stretches.insert(element, vec![made]);
            }
            if is_chain {
                self.stretches.insert(name.clone(), vec![(whole..self.elements.len()).collect()]);
            }
            self.keep_ends(name);
        }
    }

    /// Rigid arms at both nodes, m.
    fn arms(&mut self, offsets: &[[Scalar; 3]; 2], path: &str) -> Vec<[f64; 3]> {
        let at = |k: usize| format!("{path}.offsets[{k}]");
        offsets.iter().enumerate().map(|(k, v)| vector(v, "m", &at(k), self.problems)).collect()
    }

    /// A node inside a subdivided element, called by its share of the length; where the file has a node of that name, a prime more.
    fn interior(&mut self, element: &str, [part, parts]: [u32; 2], [a, b]: [usize; 2], arms: &[[f64; 3]]) -> usize {
        let positions = &self.geometry.positions;
        let (pa, pb) = (plus(positions[a], 1.0, arms[0]), plus(positions[b], 1.0, arms[1]));
        let f = f64::from(part) / f64::from(parts);
        let mut name = point_name(element, part, parts);
        while self.geometry.node(&name).is_some() {
            name.push('\'');
        }
        let node = self.geometry.add(name, plus(pa, f, minus(pb, pa)));
        self.geometry.keep_between(node, [a, b], f);
        self.geometry.call(counted_name(element, part), node);
        node
    }
}
