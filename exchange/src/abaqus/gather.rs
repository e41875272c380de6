//! From keywords to parts and instances: who stands in whose scope.
//!
//! A flat deck is one body. A deck of parts has a body for each, and one for the assembly and the model together; an instance places the
//! body of a part by a rotation and a translation.

use super::keywords::{KeywordUse, is_of_steps, rule};
use super::kinds::{self, Family, Kind};
use super::scopes::{At, Body, Gathered, Instance, OWN, RawElement, Vector, axes, own, sin_cos};
use retune::catalogue::did_you_mean;
use retune::deck::{DataLine, DeckError, Keyword, KeywordDeck};
use retune::linalg::vector3::{cross, dot, minus, plus, unit};
use std::collections::BTreeMap;

/// What stands right below a section and belongs to it.
const SUB_OPTIONS: &[&str] = &["TRANSVERSESHEARSTIFFNESS", "TRANSVERSESHEAR", "CENTROID", "SHEARCENTER"];

/// Where the pass stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scope {
    Model,
    Part(usize),
    Instance(u32),
}

/// Members of all sets together, at most: what `GENERATE` writes in a line must fit the memory.
const MOST_MEMBERS: usize = 20_000_000;

struct Gather {
    out: Gathered,
    scope: Scope,
    parts: BTreeMap<String, usize>,
    is_assembly: bool,
    step: Option<usize>,
    material: Option<String>,
    behavior: Option<String>,
    /// Axes in which coordinates of nodes stand (SYSTEM).
    system: Option<(Vector, [Vector; 3])>,
    /// Name of the keyword before, to which sub-options belong.
    previous: String,
    n_members: usize,
}

/// Reads every keyword into its scope.
///
/// # Errors
/// Twenty at most, each with its place.
pub(super) fn gather(deck: &KeywordDeck, most: usize) -> Result<Gathered, Vec<DeckError>> {
    let model = Instance { name: String::new(), body: 0, rotation: retune::model::GLOBAL, translation: [0.0; 3] };
    let out = Gathered { bodies: vec![Body::default()], instances: vec![model], ..Gathered::default() };
    let mut pass = Gather {
        out,
        scope: Scope::Model,
        parts: BTreeMap::new(),
        is_assembly: false,
        step: None,
        material: None,
        behavior: None,
        system: None,
        previous: String::new(),
        n_members: 0,
    };
    let mut errors = Vec::new();
    let mut unknown: BTreeMap<&str, (Keyword<'_>, usize)> = BTreeMap::new();
    for keyword in deck.keywords() {
        let name = keyword.name();
        let Some(rule) = rule(name) else {
            unknown.entry(name).or_insert((keyword, 0)).1 += 1;
            continue;
        };
        let result = match rule.use_of {
            KeywordUse::Read(becomes) => {
                pass.out.read.entry(rule.shown.to_string()).or_insert((0, becomes)).0 += 1;
                match super::keywords::unknown_parameter(&keyword) {
                    None => pass.keyword(&keyword),
                    Some((name, suggestion)) => {
                        Err(keyword.error(format_args!("its parameter `{name}` is not known{suggestion}")))
                    }
                }
            }
            KeywordUse::LeftOut(why) => {
                pass.out.left_out.entry(rule.shown.to_string()).or_insert((0, why)).0 += 1;
                Ok(())
            }
            KeywordUse::Refused(why) => Err(keyword.error(why)),
        };
        errors.extend(result.err());
        pass.previous = name.to_string();
        if errors.len() >= most {
            return Err(errors);
        }
    }
    for (name, (first, count)) in unknown {
        let known = super::keywords::KEYWORDS.iter().map(|r| r.name);
        let suggestion = did_you_mean(name, known);
        let more = if count > 1 { format!(" ({count} of them)") } else { String::new() };
        errors.push(first.error(format_args!("no keyword of this name is known{more}{suggestion}")));
    }
    if pass.scope != Scope::Model && errors.is_empty() {
        let last = deck.keyword(deck.keywords().len() - 1);
        errors.push(last.error("the deck ends within a part or an instance: *END PART or *END INSTANCE is missing"));
    }
    if errors.is_empty() { Ok(pass.out) } else { Err(errors) }
}

impl Gather {
    fn keyword(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let index = k.index();
        if let Some(step) = self.step {
            match k.name() {
                "ENDSTEP" => self.step = None,
                "STEP" => return Err(k.error("a step stands within a step: *END STEP is missing")),
                "NSET" | "ELSET" | "SURFACE" => return self.model(k),
                _ if is_of_steps(k.name()) => self.out.steps[step].push(index),
                _ => return Err(k.error("it belongs to the model, above the first *STEP")),
            }
            return Ok(());
        }
        self.model(k)
    }

    fn model(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let index = k.index();
        match k.name() {
            "HEADING" => self.out.heading = Some(index),
            "PART" => self.part(k)?,
            "ENDPART" | "ENDINSTANCE" => self.scope = Scope::Model,
            "ASSEMBLY" => self.is_assembly = true,
            "ENDASSEMBLY" => self.is_assembly = false,
            "INSTANCE" => self.instance(k)?,
            "NODE" => self.nodes(k)?,
            "ELEMENT" => self.elements(k)?,
            "NSET" => self.set(k, "NSET")?,
            "ELSET" => self.set(k, "ELSET")?,
            "SYSTEM" => self.system = system(k)?,
            "SURFACE" => {
                let name = k.needs("NAME")?;
                self.body_mut().surfaces.entry(name).or_default().push(index);
            }
            "ORIENTATION" => {
                let name = k.needs("NAME")?;
                self.body_mut().orientations.insert(name, index);
            }
            "MATERIAL" => {
                let name = k.needs("NAME")?;
                if self.out.materials.insert(name.clone(), vec![index]).is_some() {
                    return Err(k.error(format_args!("the material `{name}` is defined twice")));
                }
                self.material = Some(name);
            }
            "CONNECTORBEHAVIOR" => {
                let name = k.needs("NAME")?;
                if self.out.behaviors.insert(name.clone(), Vec::new()).is_some() {
                    return Err(k.error(format_args!("the connector behavior `{name}` is defined twice")));
                }
                self.behavior = Some(name);
            }
            "CONNECTORELASTICITY" => {
                let found = self.behavior.as_ref().and_then(|b| self.out.behaviors.get_mut(b));
                found.ok_or_else(|| k.error("it belongs below a *CONNECTOR BEHAVIOR"))?.push(index);
            }
            "ELASTIC" | "DENSITY" => {
                let found = self.material.as_ref().and_then(|m| self.out.materials.get_mut(m));
                found.ok_or_else(|| k.error("it belongs below a *MATERIAL"))?.push(index);
            }
            "BOUNDARY" => self.out.boundary.push(index),
            "STEP" => {
                self.step = Some(self.out.steps.len());
                self.out.steps.push(vec![index]);
            }
            "ENDSTEP" => return Err(k.error("no *STEP stands before it")),
            name if SUB_OPTIONS.contains(&name) => {
                if !(self.previous.ends_with("SECTION") || SUB_OPTIONS.contains(&self.previous.as_str())) {
                    return Err(
                        k.error("it belongs right below a *BEAM SECTION, *BEAM GENERAL SECTION or *SHELL SECTION")
                    );
                }
            }
            "KINEMATIC" | "DISTRIBUTING" => {
                if !matches!(self.previous.as_str(), "COUPLING" | "KINEMATIC" | "DISTRIBUTING") {
                    return Err(k.error("it belongs right below a *COUPLING"));
                }
            }
            "TIE"
            | "COUPLING"
            | "MPC"
            | "RIGIDBODY"
            | "EQUATION"
            | "TRANSFORM"
            | "DISTRIBUTINGCOUPLING"
            | "KINEMATICCOUPLING" => self.body_mut().constraints.push(index),
            "FREQUENCY" => return Err(k.error("it belongs into a *STEP")),
            _ => self.body_mut().sections.push(index),
        }
        Ok(())
    }

    fn body_index(&self) -> usize {
        match self.scope {
            Scope::Model => 0,
            Scope::Part(body) => body,
            Scope::Instance(instance) => self.out.instances[instance as usize].body,
        }
    }

    /// The body of this scope; an instance that says more than its part gets a body of its own.
    fn body_mut(&mut self) -> &mut Body {
        if let Scope::Instance(instance) = self.scope {
            let shared = self.out.instances[instance as usize].body;
            if self.parts.values().any(|p| *p == shared) {
                let copy = self.out.bodies[shared].clone();
                self.out.instances[instance as usize].body = self.out.bodies.len();
                self.out.bodies.push(copy);
            }
        }
        let body = self.body_index();
        &mut self.out.bodies[body]
    }

    fn part(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let name = k.needs("NAME")?;
        if self.scope != Scope::Model {
            return Err(k.error("a part stands within a part or an instance: *END PART is missing"));
        }
        let body = self.out.bodies.len();
        if self.parts.insert(name.clone(), body).is_some() {
            return Err(k.error(format_args!("the part `{name}` is defined twice")));
        }
        self.out.bodies.push(Body::default());
        self.scope = Scope::Part(body);
        Ok(())
    }

    fn instance(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        if self.scope != Scope::Model {
            return Err(k.error("an instance stands within a part or an instance: *END INSTANCE is missing"));
        }
        if !self.is_assembly {
            return Err(k.error("an instance belongs into an *ASSEMBLY"));
        }
        let name = k.needs("NAME")?;
        if self.out.instances.iter().any(|i| i.name == name) {
            return Err(k.error(format_args!("the instance `{name}` is defined twice")));
        }
        let part = k.needs("PART")?;
        let Some(&body) = self.parts.get(&part) else {
            let suggestion = did_you_mean(&part, self.parts.keys().map(String::as_str));
            return Err(k.error(format_args!("there is no part `{part}`{suggestion}")));
        };
        let (mut rotation, mut translation) = (retune::model::GLOBAL, [0.0; 3]);
        let mut lines = k.lines();
        if let Some(line) = lines.next() {
            translation = line.vector(0, "translation")?;
        }
        if let Some(line) = lines.next() {
            let (a, b, angle) = (line.vector(0, "a")?, line.vector(3, "b")?, line.real_or(6, "angle", 0.0)?);
            let axis = unit(minus(b, a));
            let axis = axis.ok_or_else(|| line.error(Some((3, "b")), "the points a and b of the axis are one"))?;
            let [sin, cos] = sin_cos(angle);
            // Rodrigues' formula.
            let turn =
                |v: Vector| plus(plus(v.map(|x| x * cos), sin, cross(axis, v)), (1.0 - cos) * dot(axis, v), axis);
            let columns = retune::model::GLOBAL.map(turn);
            rotation = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
            // First the translation, then the rotation about a: R (x + t - a) + a.
            translation = plus(a, 1.0, turn(minus(translation, a)));
        }
        self.out.instances.push(Instance { name, body, rotation, translation });
        self.scope = Scope::Instance(self.out.instances.len() as u32 - 1);
        Ok(())
    }

    fn nodes(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let kind = k.label("SYSTEM").unwrap_or_else(|| "R".to_string());
        if !matches!(kind.as_str(), "R" | "C") {
            return Err(k.error("spherical coordinates (SYSTEM=S) are not read; give R or C"));
        }
        let system = self.system;
        let mut set = Vec::new();
        let body = self.body_mut();
        for line in k.lines().filter(|l| !l.is_empty()) {
            let id = line.id(0, "node")?;
            let mut p = line.vector(1, "coordinate")?;
            if kind == "C" {
                let [sin, cos] = sin_cos(p[1]);
                p = [p[0] * cos, p[0] * sin, p[2]];
            }
            if let Some((origin, axes)) = system {
                p = (0..3).fold(origin, |sum, i| plus(sum, p[i], axes[i]));
            }
            let next = body.nodes.len() as u32;
            let index = *body.node_at.entry(id).or_insert(next);
            if index == next {
                body.nodes.push((id, p));
            } else if body.nodes[index as usize].1 != p {
                return Err(
                    line.error(Some((0, "node")), format_args!("the node {id} is defined twice, at two places"))
                );
            }
            set.push(At { instance: OWN, index });
        }
        if let Some(name) = k.label("NSET") {
            self.add(k, "NSET", name, set, false)?;
        }
        Ok(())
    }

    fn elements(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let kind = kinds::find(&k.needs("TYPE")?).map_err(|text| k.error(text))?;
        let mut set = Vec::new();
        let mut lines = k.lines().filter(|l| !l.is_empty());
        self.body_mut();
        let own = self.body_index();
        while let Some(line) = lines.next() {
            let id = line.id(0, "element")?;
            let body = &mut self.out.bodies[own];
            let (index, first) = (body.elements.len() as u32, body.connectivity.len() as u32);
            if body.element_at.insert(id, index).is_some() {
                return Err(line.error(Some((0, "element")), format_args!("the element {id} is defined twice")));
            }
            let (mut of, mut item) = (line, 1);
            for n in 0..kind.nodes {
                while item >= of.len() {
                    // A comma at its end goes on; CalculiX goes on without one where nodes of edges are missing.
                    let goes_on = of.goes_on() || n >= 8;
                    let Some(next) = lines.next().filter(|_| goes_on) else {
                        let text = format!("the element {id} has {n} nodes, and a {} has {}", kind.name, kind.nodes);
                        return Err(of.error(None, text));
                    };
                    (of, item) = (next, 0);
                }
                let node = self.node_of(own, kind, &of, item)?;
                self.out.bodies[own].connectivity.push(node);
                item += 1;
            }
            if item < of.len() {
                let text = format!("the element {id} has more nodes than the {} of a {}", kind.nodes, kind.name);
                return Err(of.error(Some((item, "node")), text));
            }
            self.out.bodies[own].elements.push(RawElement { id, kind, first, keyword: k.index() as u32 });
            set.push(At { instance: OWN, index });
        }
        if let Some(name) = k.label("ELSET") {
            self.add(k, "ELSET", name, set, false)?;
        }
        Ok(())
    }

    /// A node of an element: a number; in the assembly `instance.number`, too.
    fn node_of(&self, body: usize, kind: &Kind, line: &DataLine<'_>, item: usize) -> Result<At, DeckError> {
        let text = line.text(item);
        let missing = |node: u32| line.error(Some((item, "node")), format_args!("there is no node {node}"));
        if text.is_empty() && kind.family == Family::Connector {
            let text = "connectors to the ground are not read; give a node that BOUNDARY holds";
            return Err(line.error(Some((item, "node")), text));
        }
        if body == 0
            && let Some((instance, rest)) = self.out.split(&retune::deck::label(text))
            && let Ok(node) = rest.trim().parse::<u32>()
        {
            let index = self.out.body(instance).node_at.get(&node).ok_or_else(|| missing(node))?;
            return Ok(At { instance, index: *index });
        }
        let node = line.id(item, "node")?;
        let index = self.out.bodies[body].node_at.get(&node).ok_or_else(|| missing(node))?;
        Ok(At { instance: OWN, index: *index })
    }

    fn add(
        &mut self,
        k: &Keyword<'_>,
        what: &str,
        name: String,
        members: Vec<At>,
        is_internal: bool,
    ) -> Result<(), DeckError> {
        self.n_members += members.len();
        if self.n_members > MOST_MEMBERS {
            return Err(k.error(format_args!("the sets of the deck have more than {MOST_MEMBERS} members")));
        }
        let body = self.body_mut();
        let sets = if what == "NSET" { &mut body.nsets } else { &mut body.elsets };
        let set = sets.entry(name).or_default();
        set.members.extend(members);
        set.is_internal = is_internal;
        Ok(())
    }

    fn set(&mut self, k: &Keyword<'_>, what: &'static str) -> Result<(), DeckError> {
        let name = k.needs(what)?;
        // In the assembly a set may be of an instance.
        let instance = match k.label("INSTANCE") {
            None => None,
            Some(name) => {
                let found = self.out.instances.iter().position(|i| i.name == name && !name.is_empty());
                let known = self.out.instances.iter().map(|i| i.name.as_str());
                let suggestion = did_you_mean(&name, known);
                let error = || k.error(format_args!("there is no instance `{name}`{suggestion}"));
                Some(found.ok_or_else(error)? as u32)
            }
        };
        let here = match (instance, self.scope) {
            (Some(i), _) => i,
            (None, Scope::Model) => 0,
            (None, _) => OWN,
        };
        let body = match instance {
            Some(i) => self.out.instances[i as usize].body,
            None => self.body_index(),
        };
        let mut members = Vec::new();
        if let Some(elset) = k.label("ELSET").filter(|_| what == "NSET") {
            let own = &self.out.bodies[self.body_index()];
            let set =
                own.elsets.get(&elset).ok_or_else(|| k.error(format_args!("there is no element set `{elset}`")))?;
            for at in &set.members {
                let body = self.body_of(*at);
                let e = &body.elements[at.index as usize];
                members.extend(body.nodes_of(e).iter().map(|n| super::scopes::own(*n, at.instance)));
            }
            members.sort_unstable();
            members.dedup();
        }
        let generate = k.parameter("GENERATE").is_some();
        for line in k.lines().filter(|l| !l.is_empty()) {
            if generate {
                let (from, to) = (line.id(0, "first")?, line.id(1, "last")?);
                let by = if line.text(2).is_empty() { 1 } else { line.id(2, "increment")? };
                if to < from {
                    return Err(line.error(Some((1, "last")), "it must not be below the first"));
                }
                // Of a range those that exist count.
                let body = &self.out.bodies[body];
                let before = members.len();
                members.extend(body.range(what, [from, to, by]).into_iter().map(|index| At { instance: here, index }));
                if members.len() == before {
                    return Err(line.error(Some((0, "first")), "nothing that exists lies in this range"));
                }
                continue;
            }
            for i in 0..line.len() {
                let text = line.text(i);
                if text.is_empty() {
                    continue;
                }
                let found = self.member(body, here, what, text);
                members.extend(found.map_err(|m| line.error(Some((i, "member")), m))?);
                if members.len() > MOST_MEMBERS {
                    return Err(line.error(None, format_args!("more than {MOST_MEMBERS} members in one set")));
                }
            }
        }
        let is_internal = k.parameter("INTERNAL").is_some();
        self.add(k, what, name, members, is_internal)
    }

    /// A number, a set, or `instance.number` or `instance.set`.
    fn member(&self, body: usize, here: u32, what: &str, text: &str) -> Result<Vec<At>, String> {
        let of = &self.out.bodies[body];
        let (numbers, sets) = if what == "NSET" { (&of.node_at, &of.nsets) } else { (&of.element_at, &of.elsets) };
        if let Ok(id) = text.parse::<u32>() {
            let thing = if what == "NSET" { "node" } else { "element" };
            let index = numbers.get(&id).ok_or_else(|| format!("there is no {thing} {id}"))?;
            return Ok(vec![At { instance: here, index: *index }]);
        }
        let name = retune::deck::label(text);
        if let Some(set) = sets.get(&name) {
            return Ok(set.members.clone());
        }
        if body == 0
            && let Some((instance, rest)) = self.out.split(&name)
        {
            let inner = self.out.instances[instance as usize].body;
            let found = self.member(inner, instance, what, rest)?;
            return Ok(found.into_iter().map(|at| own(at, instance)).collect());
        }
        Err(format!("there is no set `{name}`{}", did_you_mean(&name, sets.keys().map(String::as_str))))
    }

    fn body_of(&self, at: At) -> &Body {
        let body = if at.instance == OWN { self.body_index() } else { self.out.instances[at.instance as usize].body };
        &self.out.bodies[body]
    }
}

/// Axes of coordinates by SYSTEM; nothing for the global ones.
fn system(k: &Keyword<'_>) -> Result<Option<(Vector, [Vector; 3])>, DeckError> {
    let Some(line) = k.line(0) else { return Ok(None) };
    let (a, b) = (line.vector(0, "a")?, line.vector(3, "b")?);
    let c = match k.line(1) {
        Some(line) => line.vector(0, "c")?,
        // Without a third point the z axis stays.
        None => plus(a, 1.0, cross([0.0, 0.0, 1.0], minus(b, a))),
    };
    let axes = axes(minus(b, a), minus(c, a));
    Ok(Some((a, axes.ok_or_else(|| line.error(Some((3, "b")), "its points give no axes: they lie on one line"))?)))
}
