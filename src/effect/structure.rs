//! What an effect may ask of a model: its parts by name, their symmetric partners, what moves and what deforms.

mod bodies;
mod connections;
mod cuts;
mod finer;
mod groups;
mod inside;
mod joint_ends;
mod lines;
mod listing;
mod mirror;
mod own_weight;
mod pairs;
mod places;
mod reach;
mod regions;
mod rigidity;
mod runs;
mod scale;
mod skins;
mod straight;
mod wider;

use super::edit::PatchError;
use super::location::{Location, LocationKind};
use crate::element::Dof;
use crate::model::{Model, ParametricModel, dot, extent};
use crate::once::Once;
use bodies::Bodies;
pub(in crate::effect) use joint_ends::JointEnd;
use mirror::{Mirror, element_partners};
pub use regions::{LN_OF_A_SIDE, Neighbourhood};
pub use rigidity::Rigidity;
use std::collections::{HashMap, HashSet};
pub(in crate::effect) use straight::{ALONG, Frame};

/// What is known beside the model; everything is optional.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Context {
    /// What carries the accelerometers of the test.
    pub sensors: Vec<SensorLoad>,
    /// Natural frequencies of the test, Hz: where stores on springs would show.
    pub frequencies_hz: Vec<f64>,
    /// Names of masses that stand in this configuration and not in the base model.
    pub own_masses: Vec<String>,
    /// Places of a mesh beside those at which effects are always looked for: nodes, and patches `e81~12`, the twelve elements of a part that are
    /// nearest to one of them. Other names are passed over.
    pub further: Vec<String>,
}

impl Context {
    /// With nothing known.
    pub fn nothing() -> &'static Self {
        static NOTHING: Context =
            Context { sensors: Vec::new(), frequencies_hz: Vec::new(), own_masses: Vec::new(), further: Vec::new() };
        &NOTHING
    }

    /// Whether this is a mass of the configuration, or one of several that an entry makes.
    pub fn is_own_mass(&self, name: &str) -> bool {
        let is_of = |entry: &String| {
            name.strip_prefix(entry.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        self.own_masses.iter().any(is_of)
    }
}

/// An accelerometer, or the share of it that a node carries.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorLoad {
    /// The node.
    pub node: String,
    /// Its share, in (0, 1].
    pub share: f64,
    /// From the node to the accelerometer, m.
    pub arm: [f64; 3],
}

impl SensorLoad {
    /// A whole accelerometer on a node.
    pub fn on(node: &str) -> Self {
        Self { node: node.to_string(), share: 1.0, arm: [0.0; 3] }
    }
}

/// What a [`Part`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartKind {
    /// One element of the file.
    Element,
    /// A chain of elements.
    Chain,
    /// Several members of the file that lie end to end.
    Line,
    /// A few successive elements of a chain or of a line, or a stretch inside of one that is subdivided.
    Span,
    /// A run of shells from a free edge inwards, one element wide: a cut, or a crack.
    Cut,
    /// A group of the file, an entry of several elements that are not a chain, or members of one section that the structure shows together.
    Group,
    /// A point mass.
    Mass,
}

/// A named part of the structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name in the file: `left_wing`, `left_wing.1`, `winglets.2`, a group; of a line or a span its ends, `hub..blade3`; of members of one
    /// section `brace.all`, `brace.z1-2`.
    pub name: String,
    /// What it is.
    pub kind: PartKind,
    /// What the file calls it: its name, or those of the members of a line, of the elements of a span.
    pub of: Vec<String>,
    /// Indices of its elements, in order.
    pub elements: Vec<usize>,
    /// Index of its mirror image among the parts, if that is another part.
    pub partner: Option<usize>,
    /// Whether it is a whole member of beams: a chain, a beam that belongs to none, or several of them end to end.
    pub is_member: bool,
}

impl Part {
    /// Whether its elements have one axis: a member, an element, a span.
    pub fn is_straight(&self) -> bool {
        self.is_member || matches!(self.kind, PartKind::Element | PartKind::Span)
    }
}

/// An end of a beam at a node of the file, and the directions in which a joint there would give.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct End {
    /// The element.
    pub element: usize,
    /// Its end, 1 or 2.
    pub side: usize,
    /// The node.
    pub node: usize,
    /// Per dof of the element's axes: what is behind a joint in this direction, if it would give.
    pub joint: [Option<Joint>; 6],
    /// Whether it is the second of two members that meet, whose joint is that of the first.
    pub is_second: bool,
    /// Index of the mirror image among the ends, if that is another.
    pub partner: Option<usize>,
}

/// What an end is joined to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Joint {
    /// A support.
    Root,
    /// A rigid link.
    Link,
    /// Another element, or a mass.
    Member,
}

/// A model as the effects see it.
#[derive(Debug, Clone)]
pub struct Structure<'a> {
    model: &'a Model,
    context: &'a Context,
    theta: Vec<f64>,
    parts: Vec<Part>,
    spans: Vec<Part>,
    /// Parts, and behind them spans, by name.
    part_of: HashMap<String, usize>,
    /// Ends by name.
    end_of: HashMap<String, usize>,
    /// Largest dimension, m.
    extent: f64,
    /// Pairs of near nodes, which several effects list.
    pairs: Once<Vec<Location>>,
    /// Ends of beams that lie inside something, which every patch of a rigid end asks for.
    joint_ends: Once<Vec<JointEnd>>,
    /// Which nodes are of one rigid body.
    bodies: Once<Bodies>,
    /// Per node, the elements that are joined to it.
    at_nodes: Once<Vec<Vec<usize>>>,
    /// Per element, its part of the mesh.
    mesh_part: Once<Vec<Option<usize>>>,
    /// Lines of more beams than a span of every search has, element of the file by element.
    long_lines: Once<Vec<Vec<Vec<usize>>>>,
    /// Axial forces per unit of a body acceleration along each axis, where the structure carries it.
    forces: [Once<Option<own_weight::Forces>>; 3],
    /// Whether places are wider than those of the file.
    is_wider: bool,
    ends: Vec<End>,
    mirror: Option<Mirror>,
    node_partner: Vec<Option<usize>>,
    element_partner: Vec<Option<usize>>,
    /// Per element, per dof in its axes: whether it can move, and whether a motion strains it there.
    moves: Vec<Vec<bool>>,
    strains: Vec<Vec<bool>>,
    stiff: Vec<bool>,
    heavy: Vec<bool>,
    /// Mass of each element, as a balance sees it, kg; zero of a superelement.
    masses: Vec<f64>,
    total_mass: f64,
    omega2: f64,
}

impl<'a> Structure<'a> {
    /// Looks at a model at its estimates.
    pub fn new(model: &'a Model, context: &'a Context) -> Self {
        let theta: Vec<f64> = model
            .parameters()
            .iter()
            .map(|p| p.bounds.map_or(p.value, |[lower, upper]| p.value.clamp(lower, upper)))
            .collect();
        let (mirror, n) = (Mirror::of(model), model.geometry().positions.len());
        let mut s = Self {
            model,
            context,
            parts: Vec::new(),
            spans: Vec::new(),
            part_of: HashMap::new(),
            end_of: HashMap::new(),
            extent: extent(&model.geometry().positions),
            pairs: Once::new(),
            joint_ends: Once::new(),
            bodies: Once::new(),
            at_nodes: Once::new(),
            mesh_part: Once::new(),
            long_lines: Once::new(),
            forces: Default::default(),
            is_wider: false,
            ends: Vec::new(),
            mirror,
            node_partner: mirror.map_or_else(|| vec![None; n], |m| m.node_partners(model.geometry())),
            element_partner: Vec::new(),
            moves: Vec::new(),
            strains: Vec::new(),
            stiff: Vec::new(),
            heavy: Vec::new(),
            masses: Vec::new(),
            total_mass: model.mass_properties(&theta).ok().flatten().map_or(0.0, |p| p.mass),
            omega2: 1.0,
            theta,
        };
        s.element_partner = element_partners(model, &s.node_partner);
        s.look_at_elements();
        s.parts = s.list_parts();
        let further = s.further_patches();
        if !further.is_empty() {
            let mut parts = [std::mem::take(&mut s.parts), further].concat();
            s.pair_up(&mut parts);
            s.parts = parts;
        }
        let mut spans = s.list_spans();
        spans.extend(s.list_cuts());
        s.pair_up(&mut spans);
        s.spans = spans;
        s.ends = s.list_ends();
        // The first of a name is meant.
        for (i, part) in s.parts.iter().chain(&s.spans).enumerate() {
            s.part_of.entry(part.name.clone()).or_insert(i);
        }
        for (i, end) in s.ends.iter().enumerate() {
            s.end_of.entry(s.end_name(end)).or_insert(i);
        }
        s.omega2 = s.characteristic_omega2();
        s
    }

    /// The model.
    pub fn model(&self) -> &'a Model {
        self.model
    }

    /// What is known beside it.
    pub fn context(&self) -> &'a Context {
        self.context
    }

    /// The estimates of its parameters, moved into their bounds.
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Its parts: members with their elements, then springs, masses, other elements, groups, in file order.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// A few successive elements of a chain or of a line, stretches inside of elements, and cuts of a mesh, in file order; where places
    /// are wider, larger patches behind them.
    pub fn spans(&self) -> &[Part] {
        &self.spans
    }

    /// The part, or the span, of a name.
    pub fn part(&self, name: &str) -> Option<&Part> {
        let &i = self.part_of.get(name)?;
        self.parts.get(i).or_else(|| self.spans.get(i - self.parts.len()))
    }

    /// The span of a name.
    fn span(&self, name: &str) -> Option<&Part> {
        match self.part_of.get(name)?.checked_sub(self.parts.len()) {
            Some(i) => self.spans.get(i),
            None => self.spans.iter().find(|s| s.name == name),
        }
    }

    /// The elements of a part, that of an end, or those of any other name of the model: an element of a mesh, or a patch about one.
    pub fn elements_of(&self, name: &str) -> Vec<usize> {
        match (self.part(name), self.end(name)) {
            (Some(part), _) => part.elements.clone(),
            (None, Some(end)) => vec![end.element],
            (None, None) => match self.model.element_set(name) {
                Some(set) => set.to_vec(),
                None => self.named_between(name).unwrap_or_default(),
            },
        }
    }

    /// Whether two locations name parts, or ends, that share an element, or share a node.
    pub fn overlap(&self, a: &Location, b: &Location) -> bool {
        let are_nodes = |at: &Location| matches!(at.kind, LocationKind::Node | LocationKind::Pair);
        if are_nodes(a) && are_nodes(b) {
            return a.shares_name(b);
        }
        let elements = |at: &Location| -> Vec<usize> { at.names.iter().flat_map(|n| self.elements_of(n)).collect() };
        let others: HashSet<usize> = elements(b).into_iter().collect();
        elements(a).iter().any(|e| others.contains(e))
    }

    /// Total mass, kg.
    pub fn total_mass(&self) -> f64 {
        self.total_mass
    }

    /// Mass of some elements, as a balance sees it, kg.
    pub fn mass_of(&self, elements: &[usize]) -> f64 {
        elements.iter().map(|&e| self.masses[e]).sum()
    }

    /// Square of a characteristic angular frequency, rad²/s²: the lowest mode of the model that strains its members, else of the softest
    /// chain as a cantilever, else of the springs under the total mass. An order of magnitude for typical sizes; the test
    /// has no part in it, because its lowest mode may be what an effect has brought.
    pub fn omega2(&self) -> f64 {
        self.omega2
    }

    /// Largest dimension, m.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// Name of a node.
    pub fn node_name(&self, node: usize) -> &str {
        &self.model.geometry().names[node]
    }

    /// Number of nodes of the file and of superelements; those of finer meshes come after them.
    pub fn n_nodes(&self) -> usize {
        self.model.n_named_nodes()
    }

    /// Whether a dof of a node moves; a coordinate is not a point that could.
    pub fn node_moves(&self, node: usize, dof: Dof) -> bool {
        !self.is_coordinate(node) && !self.model.dof_map().express(node, dof).is_empty()
    }

    /// Whether a node is not a point but a coordinate.
    fn is_coordinate(&self, node: usize) -> bool {
        self.model.dof_map().is_coordinate(node)
    }

    /// Whether a support holds a node in a direction in which others move.
    pub fn is_supported(&self, node: usize) -> bool {
        !self.is_coordinate(node)
            && [Dof::Ux, Dof::Uy, Dof::Uz]
                .into_iter()
                .any(|dof| !self.node_moves(node, dof) && self.any_node_moves(dof))
    }

    /// Whether some node moves in a direction.
    pub(in crate::effect) fn any_node_moves(&self, dof: Dof) -> bool {
        (0..self.model.dof_map().n_nodes()).any(|n| self.node_moves(n, dof))
    }

    /// Whether a node stands on springs to ground.
    pub fn is_mounted(&self, node: usize) -> bool {
        let elements = self.model.elements();
        self.elements_at_nodes()[node].iter().any(|&e| elements[e].kind.name() == "ground_spring")
    }

    /// Whether some motion strains some element of a part along or about this axis of its own.
    pub fn part_strains(&self, part: &Part, dof: Dof) -> bool {
        part.elements.iter().any(|&e| self.strains(e, dof))
    }

    /// Whether some element of a part moves along or about this axis of its own.
    pub fn part_moves(&self, part: &Part, dof: Dof) -> bool {
        part.elements.iter().any(|&e| self.moves(e, dof))
    }

    /// Whether all elements of a part have this property.
    pub fn part_has(&self, part: &Part, property: &str) -> bool {
        part.elements.iter().all(|&e| self.property(e, property).is_some())
    }

    fn end_name(&self, end: &End) -> String {
        format!("{}:{}", self.element_of_file(end.element), self.node_name(end.node))
    }

    /// Name of an element as the file has it, however finely it is subdivided.
    pub(super) fn element_of_file(&self, element: usize) -> &str {
        let name = &self.model.elements()[element].name;
        name.rsplit_once('/').map_or(name, |(whole, _)| whole)
    }

    /// The end of a name `element:node`.
    pub(super) fn end(&self, name: &str) -> Option<&End> {
        self.end_of.get(name).map(|&i| &self.ends[i])
    }

    /// The parts that a location names.
    pub fn parts_at(&self, effect: &str, at: &Location) -> Result<Vec<&Part>, PatchError> {
        let unknown = || PatchError::unknown_place(effect, &at.to_string(), &[]);
        if at.names.is_empty() {
            return Err(unknown());
        }
        at.names.iter().map(|n| self.part(n).ok_or_else(unknown)).collect()
    }

    /// Value of a property of an element at the estimates, SI.
    pub fn property(&self, element: usize, name: &str) -> Option<f64> {
        let e = &self.model.elements()[element];
        let i = e.kind.properties().iter().position(|p| p.name == name)?;
        e.values[i].as_ref().map(|v| v.at(&self.theta))
    }

    /// Whether an element is a beam.
    pub fn is_beam(&self, element: usize) -> bool {
        self.model.elements()[element].kind.name() == "beam"
    }

    /// Whether an element has stiffness that some motion of the structure strains.
    pub fn deforms(&self, element: usize) -> bool {
        self.strains[element].iter().any(|s| *s)
    }

    /// Whether some motion of the structure strains an element along or about this axis of its own.
    pub fn strains(&self, element: usize, dof: Dof) -> bool {
        self.strains[element].iter().skip(dof as usize).step_by(6).any(|s| *s)
    }

    /// Whether a dof of an element, in its own axes, can move at some end.
    pub fn moves(&self, element: usize, dof: Dof) -> bool {
        self.moves[element].iter().skip(dof as usize).step_by(6).any(|s| *s)
    }

    /// Whether an element has mass that moves.
    pub fn is_heavy(&self, element: usize) -> bool {
        self.heavy[element]
    }

    /// Whether a part is a superelement or a term of one.
    pub fn is_of_matrices(&self, part: &Part) -> bool {
        part.elements.iter().all(|&e| self.model.elements()[e].matrices.is_some())
    }

    /// Length of an element, m; zero for one on a single node.
    pub fn length(&self, element: usize) -> f64 {
        self.model.elements()[element].points.get(1).map_or(0.0, |p| p[0].hypot(p[1]).hypot(p[2]))
    }

    /// Names of the entries of the file whose elements strain: members, springs, other elements, each once.
    pub(super) fn stiff_entries(&self, with_springs: bool) -> Vec<String> {
        let spec = self.model.spec();
        let of_mesh = spec.mesh.iter().flat_map(|m| m.parts.keys());
        let members = spec.beams.keys().chain(spec.bars.keys()).chain(spec.superelements.keys()).chain(of_mesh);
        let others =
            spec.springs.keys().chain(spec.bushings.keys()).chain(spec.ties.keys()).chain(spec.elements.keys());
        let all: Vec<&String> = if with_springs { members.chain(others).collect() } else { members.collect() };
        all.into_iter()
            .filter(|n| self.model.element_set(n).is_some_and(|s| s.iter().any(|&e| self.deforms(e))))
            .cloned()
            .collect()
    }

    /// The line, or else the chain, or else the part, that an element belongs to: the length over which it bends.
    pub(super) fn member_of(&self, element: usize) -> Option<&Part> {
        let of = |kind| self.parts.iter().find(|p| p.kind == kind && p.elements.contains(&element));
        [PartKind::Line, PartKind::Chain, PartKind::Element].into_iter().find_map(of)
    }

    /// The sign with which an axis of `element` maps onto the same axis of `image` in the symmetry plane, and zero where it
    /// does not. For the dofs of a location's second name against its first.
    pub(super) fn mirror_sign(&self, element: usize, image: usize, axis: usize) -> f64 {
        let Some(Mirror { normal, .. }) = self.mirror else { return 0.0 };
        let (mut a, b) = (self.model.elements()[element].axes[axis], self.model.elements()[image].axes[axis]);
        a[normal] = -a[normal];
        let cosine = dot(a, b);
        // One part in a thousand: nodes are placed by hand.
        if cosine.abs() > 0.999 { cosine.signum() } else { 0.0 }
    }

    /// Whether the plane of symmetry turns a global axis over.
    pub(super) fn mirrors(&self, axis: usize) -> bool {
        self.mirror.is_some_and(|m| m.normal == axis)
    }

    /// The same as [`Self::mirror_sign`] for the first element of a part and its image; one where it has none.
    pub(super) fn image_sign(&self, part: &Part, axis: usize) -> f64 {
        let first = part.elements[0];
        self.image(first).map_or(1.0, |image| if self.mirror_sign(first, image, axis) < 0.0 { -1.0 } else { 1.0 })
    }

    /// The mirror image of an element.
    pub(super) fn image(&self, element: usize) -> Option<usize> {
        self.element_partner[element]
    }

    /// Point masses on these elements' nodes.
    pub(super) fn lumps_on(&self, elements: &[usize]) -> Vec<&Part> {
        let all = self.model.elements();
        let on = |m: usize| elements.iter().any(|&e| all[e].nodes.contains(&all[m].nodes[0]));
        self.parts.iter().filter(|p| p.kind == PartKind::Mass && p.elements.iter().all(|&m| on(m))).collect()
    }

    fn look_at_elements(&mut self) {
        for (i, e) in self.model.elements().iter().enumerate() {
            if let Some(matrices) = &e.matrices {
                let (has_stiffness, has_mass) = (matrices.k.is_some(), matrices.m.is_some());
                self.moves.push(vec![true; 6]);
                self.strains.push(vec![has_stiffness; 6]);
                self.stiff.push(has_stiffness);
                self.heavy.push(has_mass);
                self.masses.push(0.0);
                continue;
            }
            let n = 6 * e.nodes.len();
            let connection = self.model.element_motion(i);
            let Ok(matrices) = self.model.element_matrices(i, &self.theta) else {
                self.moves.push(vec![false; n]);
                self.strains.push(vec![false; n]);
                self.stiff.push(false);
                self.heavy.push(false);
                self.masses.push(0.0);
                continue;
            };
            self.moves.push((0..n).map(|r| connection.terms(r).iter().any(|x| x.1.abs() > 1e-9)).collect());
            self.strains.push(connection.loads(&matrices.stiffness));
            self.stiff.push(!matrices.stiffness.is_zero());
            self.heavy.push(connection.loads(&matrices.mass).contains(&true));
            // Of a motion along its x axis.
            let (mass, along) = (matrices.weighed(), || (0..n).step_by(6));
            self.masses.push(along().flat_map(|i| along().map(move |j| mass.get(i, j))).sum());
        }
    }
}

/// What the file calls these parts, for `of` of an override.
pub(super) fn entries(parts: &[&Part]) -> Vec<String> {
    parts.iter().flat_map(|p| p.of.iter().cloned()).collect()
}
