//! Nodes that follow others: COUPLING, MPC, RIGID BODY, EQUATION.

use super::importer::{Importer, word};
use super::kinds::Family;
use super::scopes::At;
use super::surfaces::Surface;
use crate::motions::{self, Placed, Term};
use crate::system::Quantity as Q;
use crate::text::{computed, list};
use crate::writer::Block;
use retune::deck::{DataLine, DeckError, Keyword};
use retune::element::Dof;
use retune::linalg::vector3::{minus, unit};
use std::collections::BTreeMap;

const ALL: [bool; 6] = [true; 6];
/// Types of multi-point constraints that are read.
const MPCS: [&str; 5] = ["BEAM", "PIN", "TIE", "LINK", "LINEAR"];
const TRANSLATIONS: [bool; 6] = [true, true, true, false, false, false];

/// Ranges of dofs, one a line: `first, last`; all where there are none.
fn dofs_of(k: &Keyword<'_>, skip: usize) -> Result<[bool; 6], DeckError> {
    let mut flags = [false; 6];
    for line in k.lines().skip(skip).filter(|l| !l.is_empty()) {
        add_dofs(&line, 0, &mut flags)?;
    }
    Ok(if flags == [false; 6] { ALL } else { flags })
}

fn add_dofs(line: &DataLine<'_>, i: usize, flags: &mut [bool; 6]) -> Result<(), DeckError> {
    let first = line.id(i, "first dof")? as usize;
    let last = if line.text(i + 1).is_empty() { first } else { line.id(i + 1, "last dof")? as usize };
    if !(first <= last && last <= 6) {
        return Err(line.error(Some((i, "first dof")), "dofs from 1 to 6 are expected, the first not above the last"));
    }
    flags[first - 1..last].fill(true);
    Ok(())
}

impl Importer<'_> {
    fn one_node(&self, k: &Keyword<'_>, instance: u32, text: &str) -> Result<At, DeckError> {
        let found = self.all.nodes(instance, text).map_err(|m| k.error(m))?;
        match found[..] {
            [node] => Ok(node),
            _ => Err(k.error(format_args!("`{text}` has {} nodes, and one is expected", found.len()))),
        }
    }

    /// Writes Σ factor · dof = 0.
    pub(super) fn constraint(&mut self, name: &str, terms: Vec<Term>) {
        let metre = self.options.system.factor(Q::Length);
        let name = self.link_names.unique(name);
        self.entry(Block::Constraints, &name, &motions::constraint(terms, metre));
    }

    /// Nodes that follow another in some of their components, along global axes or others.
    pub(super) fn link(
        &mut self,
        name: &str,
        master: At,
        slaves: &[At],
        flags: [bool; 6],
        axes: Option<[[f64; 3]; 3]>,
    ) {
        let slaves: Vec<At> = slaves.iter().copied().filter(|s| *s != master).collect();
        if slaves.is_empty() {
            return;
        }
        if motions::is_whole(flags) || axes.is_none() {
            let names: Vec<String> = slaves.iter().map(|s| self.node_name(*s)).collect();
            let dofs = if flags == ALL { String::new() } else { format!(", dofs: {}", motions::dofs(flags)) };
            let name = self.link_names.unique(name);
            let value = format!("{{master: {}, slaves: {}{dofs}}}", self.node_name(master), list(&names));
            self.entry(Block::RigidLinks, &name, &value);
            return;
        }
        let axes = axes.unwrap_or(retune::model::GLOBAL);
        let lead = (self.node_name(master), self.position(master));
        for slave in slaves {
            let (own, placed) = (self.node_name(slave), Placed { position: self.position(slave), axes });
            for component in (0..6).filter(|c| flags[*c]) {
                let terms = motions::follows((&own, &placed), (&lead.0, lead.1), component);
                self.constraint(&format!("{name}_{own}_{}", component + 1), terms);
            }
        }
    }

    fn follow_weighted(&mut self, name: &str, node: At, of: &[(At, f64)], flags: [bool; 6]) {
        // Nodes of one weight stand together.
        let mut sets: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let largest = of.iter().map(|o| o.1).fold(0.0, f64::max);
        for (other, weight) in of.iter().filter(|o| o.0 != node && o.1 > 1e-12 * largest) {
            sets.entry(computed(weight / largest)).or_default().push(self.node_name(*other));
        }
        let sets: Vec<String> = sets
            .into_iter()
            .map(|(weight, nodes)| {
                let weight = if weight == "1" { String::new() } else { format!(", weight: {weight}") };
                format!("{{nodes: {}{weight}}}", list(&nodes))
            })
            .collect();
        let dofs = if flags == ALL { String::new() } else { format!(", dofs: {}", motions::dofs(flags)) };
        let name = self.link_names.unique(name);
        let value = format!("{{node: {}{dofs}, of: {}}}", self.node_name(node), list(&sets));
        self.entry(Block::WeightedLinks, &name, &value);
    }
}

/// COUPLING with what stands below it: KINEMATIC or DISTRIBUTING.
pub(super) fn coupling(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    let master = importer.one_node(k, instance, &k.needs("REFNODE")?)?;
    let surface = importer.surface(instance, &k.needs("SURFACE")?).map_err(|m| k.error(m))?;
    let name = k.label("CONSTRAINTNAME").unwrap_or_default();
    let name = word(&name, "coupling");
    let mut shares = importer.shares(&surface);
    if let Some(text) = k.parameter("INFLUENCERADIUS") {
        let radius: f64 = match text.parse() {
            Ok(r) if r > 0.0 => r,
            _ => return Err(k.error("INFLUENCE RADIUS must be a number above zero")),
        };
        let centre = importer.position(master);
        shares.retain(|(n, _)| {
            let d = minus(importer.position(*n), centre);
            retune::linalg::vector3::dot(d, d) <= radius * radius
        });
        if shares.is_empty() {
            return Err(k.error("no node of its surface lies within the INFLUENCE RADIUS"));
        }
    }
    let axes = match k.label("ORIENTATION") {
        Some(o) => {
            let o = importer.orientation(k, instance, &o)?;
            Some(o.turned_at(importer.position(master)))
        }
        None => None,
    };
    let count = importer.deck.keywords().len();
    let mut is_any = false;
    for index in k.index() + 1..count {
        let sub = importer.deck.keyword(index);
        match sub.name() {
            "KINEMATIC" => {
                let nodes: Vec<At> = shares.iter().map(|s| s.0).collect();
                importer.link(&name, master, &nodes, dofs_of(&sub, 0)?, axes);
            }
            "DISTRIBUTING" => {
                let method = sub.label("WEIGHTINGMETHOD").unwrap_or_else(|| "UNIFORM".to_string());
                if method != "UNIFORM" {
                    return Err(sub.error(format_args!("the weighting method {method} is not read; UNIFORM is")));
                }
                if sub.label("COUPLING").is_some_and(|c| c != "CONTINUUM") {
                    importer.report.note("DISTRIBUTING couplings of structures are read as those of continua: rotations of nodes do not count");
                }
                let flags = dofs_of(&sub, 0)?;
                if axes.is_some() && !motions::is_whole(flags) {
                    return Err(sub.error("some dofs along axes of an ORIENTATION are not read; give 1 to 3 or 1 to 6"));
                }
                importer.follow_weighted(&name, master, &shares, flags);
            }
            _ => break,
        }
        is_any = true;
    }
    if !is_any {
        return Err(k.error("*KINEMATIC or *DISTRIBUTING is expected right below it"));
    }
    Ok(())
}

/// KINEMATIC COUPLING: nodes and dofs in data lines.
pub(super) fn kinematic(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    let master = importer.one_node(k, instance, &k.needs("REFNODE")?)?;
    let axes = match k.label("ORIENTATION") {
        Some(o) => {
            let o = importer.orientation(k, instance, &o)?;
            Some(o.turned_at(importer.position(master)))
        }
        None => None,
    };
    let mut all = Vec::new();
    for line in k.lines().filter(|l| !l.is_empty()) {
        let nodes = importer.all.nodes(instance, line.text(0)).map_err(|m| line.error(Some((0, "nodes")), m))?;
        let mut flags = if line.text(1).is_empty() { ALL } else { [false; 6] };
        if !line.text(1).is_empty() {
            add_dofs(&line, 1, &mut flags)?;
        }
        all.push((nodes, flags));
    }
    for (nodes, flags) in all {
        importer.link("kinematic_coupling", master, &nodes, flags, axes);
    }
    Ok(())
}

/// DISTRIBUTING COUPLING: an element's node follows nodes with weights in data lines.
pub(super) fn distributing(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    let elements = importer.all.elements(instance, &k.needs("ELSET")?).map_err(|m| k.error(m))?;
    let [element] = elements[..] else {
        return Err(k.error("its element set must have one element, that of the node which follows"));
    };
    let node = importer.nodes_of(element)[0];
    let mut of = Vec::new();
    for line in k.lines().filter(|l| !l.is_empty()) {
        let nodes = importer.all.nodes(instance, line.text(0)).map_err(|m| line.error(Some((0, "nodes")), m))?;
        let weight = line.real_or(1, "weight", 1.0)?;
        if weight < 0.0 {
            return Err(line.error(Some((1, "weight")), "it must not be negative"));
        }
        of.extend(nodes.into_iter().map(|n| (n, weight)));
    }
    if of.is_empty() {
        return Err(k.error("it follows no nodes"));
    }
    importer.follow_weighted("distributing_coupling", node, &of, ALL);
    Ok(())
}

/// MPC: a type and its nodes in every line.
pub(super) fn mpc(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    if k.parameter("USER").is_some() {
        return Err(k.error("multi-point constraints of the user have no equations in the deck; give EQUATION"));
    }
    for line in k.lines().filter(|l| !l.is_empty()) {
        let kind = retune::deck::label(line.text(0));
        let mut nodes: Vec<Vec<At>> = Vec::new();
        for i in 1..line.len() {
            if !line.text(i).is_empty() {
                nodes.push(importer.all.nodes(instance, line.text(i)).map_err(|m| line.error(Some((i, "nodes")), m))?);
            }
        }
        if !MPCS.contains(&kind.as_str()) {
            let text =
                format!("multi-point constraints of the type {kind} are not read; known are {}", MPCS.join(", "));
            return Err(line.error(Some((0, "type")), text));
        }
        let wanted = if kind == "LINEAR" { 3 } else { 2 };
        if nodes.len() != wanted {
            return Err(
                line.error(Some((1, "nodes")), format_args!("{wanted} nodes are expected, and {} given", nodes.len()))
            );
        }
        // Of sets the first of one follows the first of the other; one node leads them all.
        let count = nodes[0].len();
        if nodes[1..].iter().any(|n| n.len() != 1 && n.len() != count) {
            return Err(line.error(Some((2, "nodes")), "its sets have different numbers of nodes"));
        }
        for i in 0..count {
            let of = |n: usize| nodes[n][if nodes[n].len() == 1 { 0 } else { i }];
            let (slave, master) = (of(0), of(1));
            if slave == master {
                continue;
            }
            let name = format!("mpc_{}_{}", kind.to_lowercase(), importer.node_name(slave));
            match kind.as_str() {
                "BEAM" => importer.link(&name, master, &[slave], ALL, None),
                "PIN" => same(importer, &name, slave, master, 3),
                "TIE" => same(importer, &name, slave, master, 6),
                "LINK" => {
                    let d = unit(minus(importer.position(slave), importer.position(master)));
                    let d = d.ok_or_else(|| {
                        line.error(Some((1, "nodes")), "its nodes are at one place: they have no distance")
                    })?;
                    let terms = [(slave, 1.0), (master, -1.0)]
                        .into_iter()
                        .flat_map(|(n, sign)| (0..3).map(move |c| (n, c, sign)))
                        .filter(|t| d[t.1].abs() > 1e-12)
                        .map(|(n, c, sign)| (importer.node_name(n), Dof::ALL[c], sign * d[c]))
                        .collect();
                    importer.constraint(&name, terms);
                }
                // LINEAR.
                _ => {
                    // On the line between the others, by the fraction at which it stands.
                    let other = of(2);
                    let (a, b) = (importer.position(master), importer.position(other));
                    let along = minus(b, a);
                    let length2 = retune::linalg::vector3::dot(along, along);
                    if length2 == 0.0 {
                        return Err(
                            line.error(Some((2, "nodes")), "its nodes are at one place: there is no line between them")
                        );
                    }
                    let f = retune::linalg::vector3::dot(minus(importer.position(slave), a), along) / length2;
                    for c in 0..3 {
                        let terms = [(slave, 1.0), (master, f - 1.0), (other, -f)]
                            .into_iter()
                            .map(|(n, factor)| (importer.node_name(n), Dof::ALL[c], factor))
                            .collect();
                        importer.constraint(&format!("{name}_{}", c + 1), terms);
                    }
                }
            }
        }
    }
    Ok(())
}

/// A node whose first `n` dofs are those of another.
fn same(importer: &mut Importer<'_>, name: &str, slave: At, master: At, n: usize) {
    let (a, b) = (importer.placed(slave), importer.placed(master));
    let (own, other) = (importer.node_name(slave), importer.node_name(master));
    for c in 0..n {
        let mut terms: Vec<Term> = a.component(c).into_iter().map(|(d, f)| (own.clone(), d, f)).collect();
        terms.extend(b.component(c).into_iter().map(|(d, f)| (other.clone(), d, -f)));
        importer.constraint(&format!("{name}_{}", c + 1), terms);
    }
}

/// RIGID BODY: elements, and nodes that are tied or pinned to it.
pub(super) fn rigid_body(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    let master = importer.one_node(k, instance, &k.needs("REFNODE")?)?;
    if k.parameter("ANALYTICALSURFACE").is_some() {
        return Err(k.error("analytical surfaces are of contact, which is not linear; leave them out"));
    }
    if k.label("POSITION").is_some_and(|p| p == "CENTEROFMASS") {
        return Err(k.error("POSITION=CENTER OF MASS moves the reference node; give it the place and leave this out"));
    }
    let mut tied: Vec<At> = Vec::new();
    let mut pinned: Vec<At> = Vec::new();
    if let Some(set) = k.label("ELSET") {
        for at in importer.all.elements(instance, &set).map_err(|m| k.error(m))? {
            let list = if importer.kind(at).family == Family::Solid { &mut pinned } else { &mut tied };
            list.extend(importer.nodes_of(at));
        }
    }
    for name in ["NSET", "TIENSET", "PINNSET"] {
        if let Some(set) = k.label(name) {
            let list = if name == "PINNSET" { &mut pinned } else { &mut tied };
            list.extend(importer.all.nodes(instance, &set).map_err(|m| k.error(m))?);
        }
    }
    tied.sort_unstable();
    tied.dedup();
    pinned.sort_unstable();
    pinned.dedup();
    pinned.retain(|n| tied.binary_search(n).is_err());
    if tied.is_empty() && pinned.is_empty() {
        return Err(k.error("it has no nodes: ELSET, NSET, TIE NSET or PIN NSET is expected"));
    }
    importer.link("rigid_body", master, &tied, ALL, None);
    importer.link("rigid_body_pins", master, &pinned, TRANSLATIONS, None);
    if let Some(text) = k.label("ROTNODE") {
        // The displacements of this node are the rotations of the body, in numbers.
        let rotation = importer.one_node(k, instance, &text)?;
        let (own, lead) = (importer.node_name(rotation), importer.node_name(master));
        for c in 0..3 {
            let terms = vec![(own.clone(), Dof::ALL[c], 1.0), (lead.clone(), Dof::ALL[3 + c], -1.0)];
            importer.constraint(&format!("rotation_{own}_{}", c + 1), terms);
        }
    }
    Ok(())
}

/// EQUATION: the number of terms, then node, dof and factor of each.
pub(super) fn equation(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    let mut lines = k.lines().filter(|l| !l.is_empty());
    while let Some(head) = lines.next() {
        let n = head.id(0, "number of terms")? as usize;
        let mut terms: Vec<(Vec<At>, usize, f64)> = Vec::new();
        while terms.len() < n {
            let Some(line) = lines.next() else {
                return Err(head.error(
                    Some((0, "number of terms")),
                    format_args!("{n} terms are expected, and {} given", terms.len()),
                ));
            };
            let before = terms.len();
            for i in (0..line.len()).step_by(3) {
                if terms.len() == n {
                    break;
                }
                let nodes = importer.all.nodes(instance, line.text(i)).map_err(|m| line.error(Some((i, "node")), m))?;
                let dof = line.id(i + 1, "dof")? as usize;
                if dof > 6 {
                    return Err(line.error(Some((i + 1, "dof")), "a dof from 1 to 6 is expected"));
                }
                terms.push((nodes, dof - 1, line.real(i + 2, "factor")?));
            }
            if terms.len() == before {
                return Err(line.error(None, "a node, a dof and a factor are expected"));
            }
        }
        if terms[0].2 == 0.0 {
            return Err(head.error(None, "its first term has the factor zero, so it eliminates nothing"));
        }
        let count = terms.iter().map(|t| t.0.len()).max().unwrap_or(0);
        if terms.iter().any(|t| t.0.len() != 1 && t.0.len() != count) {
            return Err(head.error(None, "its sets have different numbers of nodes"));
        }
        for i in 0..count {
            let of = |nodes: &[At]| nodes[if nodes.len() == 1 { 0 } else { i }];
            let first = importer.node_name(of(&terms[0].0));
            let written: Vec<Term> = terms
                .iter()
                .flat_map(|(nodes, dof, factor)| {
                    let node = of(nodes);
                    let name = importer.node_name(node);
                    let parts = importer.placed(node).component(*dof);
                    parts.into_iter().map(move |(d, f)| (name.clone(), d, f * factor)).collect::<Vec<_>>()
                })
                .collect();
            importer.constraint(&format!("equation_{first}_{}", terms[0].1 + 1), written);
        }
    }
    Ok(())
}

impl Surface {
    /// Its nodes, each once.
    pub(super) fn nodes(&self) -> Vec<At> {
        let mut all: Vec<At> = match self {
            Surface::Nodes(nodes) => nodes.iter().map(|n| n.0).collect(),
            Surface::Faces(faces) => faces.iter().flat_map(|f| f.nodes.iter().copied()).collect(),
        };
        all.sort_unstable();
        all.dedup();
        all
    }
}
