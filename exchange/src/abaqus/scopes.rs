//! Parts, instances and the model: nodes, elements and sets, and how they are found by their names.

use super::kinds::Kind;
use retune::catalogue::did_you_mean;
use retune::linalg::vector3::{cross, dot, plus, unit};
use std::collections::{BTreeMap, HashMap};

pub(super) type Vector = [f64; 3];

/// A node or an element: instance, and place in the body of its part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct At {
    pub instance: u32,
    pub index: u32,
}

/// In a set of a part: of whichever instance asks.
pub(super) const OWN: u32 = u32::MAX;

#[derive(Debug, Clone)]
pub(super) struct RawElement {
    pub id: u32,
    pub kind: &'static Kind,
    /// The first of its nodes in the connectivity of its body.
    pub first: u32,
    /// The keyword that gives it.
    pub keyword: u32,
}

/// A set, and whether a person named it.
#[derive(Debug, Clone, Default)]
pub(super) struct Set {
    pub members: Vec<At>,
    pub is_internal: bool,
}

/// What stands in one scope.
#[derive(Debug, Clone, Default)]
pub(super) struct Body {
    pub nodes: Vec<(u32, Vector)>,
    pub node_at: HashMap<u32, u32>,
    pub elements: Vec<RawElement>,
    pub element_at: HashMap<u32, u32>,
    /// Nodes of elements, one element after the other; in the assembly they may be of instances.
    pub connectivity: Vec<At>,
    pub nsets: BTreeMap<String, Set>,
    pub elsets: BTreeMap<String, Set>,
    /// Keywords of surfaces and of orientations.
    pub surfaces: BTreeMap<String, Vec<usize>>,
    pub orientations: BTreeMap<String, usize>,
    /// Keywords that give sections and properties of elements, and those that tie nodes, in order.
    pub sections: Vec<usize>,
    pub constraints: Vec<usize>,
}

impl Body {
    /// Places of the nodes or elements whose numbers lie in a range, in the order of their numbers.
    pub(super) fn range(&self, what: &str, [from, to, by]: [u32; 3]) -> Vec<u32> {
        let is_node = what == "NSET";
        let (at, all) =
            if is_node { (&self.node_at, self.nodes.len()) } else { (&self.element_at, self.elements.len()) };
        if ((to - from) / by) as usize <= 4 * all {
            return (from..=to).step_by(by as usize).filter_map(|id| at.get(&id).copied()).collect();
        }
        // A range that is much longer than the mesh is searched for, not counted through.
        let id = |i: u32| if is_node { self.nodes[i as usize].0 } else { self.elements[i as usize].id };
        let is_in = |i: &u32| (from..=to).contains(&id(*i)) && (id(*i) - from) % by == 0;
        let mut found: Vec<u32> = (0..all as u32).filter(is_in).collect();
        found.sort_unstable_by_key(|i| id(*i));
        found
    }

    pub(super) fn nodes_of(&self, e: &RawElement) -> &[At] {
        &self.connectivity[e.first as usize..e.first as usize + e.kind.nodes]
    }
}

/// A part in its place.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    /// Empty for the model itself.
    pub name: String,
    pub body: usize,
    /// x' = R x + t, rows of R.
    pub rotation: [Vector; 3],
    pub translation: Vector,
}

impl Instance {
    pub(super) fn place(&self, p: Vector) -> Vector {
        let turned = self.turn(p);
        std::array::from_fn(|i| turned[i] + self.translation[i])
    }

    pub(super) fn turn(&self, v: Vector) -> Vector {
        self.rotation.map(|row| dot(row, v))
    }

    pub(super) fn is_moved(&self) -> bool {
        self.translation != [0.0; 3] || self.is_turned()
    }

    pub(super) fn is_turned(&self) -> bool {
        self.rotation != retune::model::GLOBAL
    }
}

/// What stands outside of bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Gathered {
    pub bodies: Vec<Body>,
    /// The model itself first.
    pub instances: Vec<Instance>,
    pub materials: BTreeMap<String, Vec<usize>>,
    /// Keywords of the behaviors of connectors.
    pub behaviors: BTreeMap<String, Vec<usize>>,
    /// Boundary conditions of the model, and keywords of each step.
    pub boundary: Vec<usize>,
    pub steps: Vec<Vec<usize>>,
    pub heading: Option<usize>,
    /// Keywords that were read, by name: count and what they become.
    pub read: BTreeMap<String, (usize, &'static str)>,
    pub left_out: BTreeMap<String, (usize, &'static str)>,
}

/// A member of a set of a part, of the instance that asks.
pub(super) fn own(at: At, instance: u32) -> At {
    if at.instance == OWN { At { instance, ..at } } else { at }
}

impl Gathered {
    pub(super) fn body(&self, instance: u32) -> &Body {
        &self.bodies[self.instances[instance as usize].body]
    }

    /// An instance and the name in it, of `instance.name`; `assembly.name` is the model's.
    pub(super) fn split<'n>(&self, name: &'n str) -> Option<(u32, &'n str)> {
        /// Names of two scopes and a set are shorter; each dot of a longer one would be a step down.
        const LONGEST: usize = 1024;
        let mut dots = name.match_indices('.').filter(|_| name.len() <= LONGEST);
        dots.find_map(|(i, _)| {
            let (head, rest) = (&name[..i], &name[i + 1..]);
            let at = self.instances.iter().position(|k| k.name == head && !head.is_empty());
            at.or((head == "ASSEMBLY").then_some(0)).map(|at| (at as u32, rest))
        })
    }

    /// Nodes of a set or of a number, seen from an instance.
    ///
    /// # Errors
    /// In words, with the nearest name.
    pub(super) fn nodes(&self, instance: u32, text: &str) -> Result<Vec<At>, String> {
        let body = self.body(instance);
        if let Ok(id) = text.trim().parse::<u32>() {
            let index = body.node_at.get(&id).ok_or_else(|| format!("there is no node {id}"))?;
            return Ok(vec![At { instance, index: *index }]);
        }
        let name = retune::deck::label(text);
        if let Some(set) = body.nsets.get(&name) {
            return Ok(set.members.iter().map(|at| own(*at, instance)).collect());
        }
        match self.split(&name).filter(|_| instance == 0) {
            Some((inner, rest)) => self.nodes(inner, rest),
            None => Err(format!(
                "there is no node set `{name}`{}",
                did_you_mean(&name, body.nsets.keys().map(String::as_str))
            )),
        }
    }

    /// Elements of a set or of a number, seen from an instance.
    ///
    /// # Errors
    /// In words, with the nearest name.
    pub(super) fn elements(&self, instance: u32, text: &str) -> Result<Vec<At>, String> {
        let body = self.body(instance);
        if let Ok(id) = text.trim().parse::<u32>() {
            let index = body.element_at.get(&id).ok_or_else(|| format!("there is no element {id}"))?;
            return Ok(vec![At { instance, index: *index }]);
        }
        let name = retune::deck::label(text);
        if let Some(set) = body.elsets.get(&name) {
            return Ok(set.members.iter().map(|at| own(*at, instance)).collect());
        }
        match self.split(&name).filter(|_| instance == 0) {
            Some((inner, rest)) => self.elements(inner, rest),
            None => Err(format!(
                "there is no element set `{name}`{}",
                did_you_mean(&name, body.elsets.keys().map(String::as_str))
            )),
        }
    }

    /// Keywords of a surface, and the instance that it is seen from.
    ///
    /// # Errors
    /// In words, with the nearest name.
    pub(super) fn surface(&self, instance: u32, text: &str) -> Result<(u32, &[usize]), String> {
        let name = retune::deck::label(text);
        let body = self.body(instance);
        if let Some(found) = body.surfaces.get(&name) {
            return Ok((instance, found));
        }
        match self.split(&name).filter(|_| instance == 0) {
            Some((inner, rest)) => self.surface(inner, rest),
            None => Err(format!(
                "there is no surface `{name}`{}",
                did_you_mean(&name, body.surfaces.keys().map(String::as_str))
            )),
        }
    }
}

/// Axes with x along a direction and another in the x-y plane; nothing where both are along one line.
pub(super) fn axes(x: Vector, xy: Vector) -> Option<[Vector; 3]> {
    let x = unit(x)?;
    let near = unit(xy)?;
    let y = plus(near, -dot(near, x), x);
    let y = unit(y).filter(|_| dot(y, y) > 1e-16)?;
    Some([x, y, cross(x, y)])
}

/// Sine and cosine of an angle in degrees, exact at right angles.
pub(super) fn sin_cos(degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [sin, cos].map(|v| if v.abs() < 1e-15 { 0.0 } else { v })
}
