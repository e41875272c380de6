//! Nodes, elements and sets of a deck of Abaqus or CalculiX, as most preprocessors write them.
//!
//! Sections, materials and everything else stay unread: what stands on the mesh is said in the model file. `retune import` reads the whole deck.
//! A set of nodes becomes one of points. One part with one instance that is not moved is a mesh; several are an assembly, which is not.

use super::MeshReader;
use super::cell::{Mesh, MeshNode, MeshSet, Shape};
use super::cursor::MeshError;
use crate::catalogue::did_you_mean;
use crate::deck::{DataLine, DeckError, Keyword, KeywordDeck, is_keyword_deck, label};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

#[doc = "Decks of Abaqus and CalculiX."]
#[derive(Debug, Clone, Copy)]
pub struct Abaqus;

/// Members of all sets together, at most.
const MOST_MEMBERS: usize = 20_000_000;

impl MeshReader for Abaqus {
    fn name(&self) -> &'static str {
        "abaqus"
    }

    fn summary(&self) -> &'static str {
        "Decks of Abaqus and CalculiX (.inp): NODE, ELEMENT, NSET and ELSET, with sets of both kinds; gmsh, Salome and others write them too."
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        is_keyword_deck(bytes)
    }

    fn read(&self, bytes: &[u8]) -> Result<Mesh, MeshError> {
        let mut first = Some(bytes.to_vec());
        let mut read = |_: &Path| {
            first.take().ok_or_else(|| std::io::Error::other("a mesh is one file; `retune import` follows INCLUDE"))
        };
        let deck = KeywordDeck::read(Path::new("mesh"), &mut read)?;
        Ok(Pass::default().run(&deck)?)
    }
}

/// Without the name of the file, which the one who reads a mesh knows.
impl From<DeckError> for MeshError {
    fn from(e: DeckError) -> Self {
        let place = if e.line > 0 { format!("line {}", e.line) } else { String::new() };
        let field = e.field.map_or_else(String::new, |(n, name)| format!(", field {n} ({name})"));
        let card = if e.card.is_empty() { String::new() } else { format!("{}{field}: ", e.card) };
        Self { place, message: format!("{card}{}", e.message) }
    }
}

/// What an element is as a cell; nothing where it is none, as a mass or a spring.
fn shape(name: &str) -> Result<Option<Shape>, String> {
    let digits = |prefix: &str| -> Option<usize> {
        let rest = name.strip_prefix(prefix)?;
        let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        rest[..end].parse().ok()
    };
    if let Some(n) = digits("C3D").or_else(|| digits("DC3D")) {
        let found = match n {
            4 => Shape::Tetrahedron4,
            5 => Shape::Pyramid5,
            6 => Shape::Wedge6,
            8 => Shape::Hexahedron8,
            10 => Shape::Tetrahedron10,
            15 => Shape::Wedge15,
            20 => Shape::Hexahedron20,
            _ => return Err(format!("elements of the type `{name}` are not read as a mesh")),
        };
        return Ok(Some(found));
    }
    let flat = ["SC", "STRI", "S", "M3D", "CPS", "CPE", "R3D", "SFM3D"].into_iter().find_map(digits);
    if let Some(n) = flat {
        let found = match n {
            3 => Shape::Triangle3,
            4 => Shape::Quadrilateral4,
            6 if name.starts_with("SC") => Shape::Wedge6,
            8 if name.starts_with("SC") => Shape::Hexahedron8,
            6 | 65 => Shape::Triangle6,
            8 => Shape::Quadrilateral8,
            9 => Shape::Quadrilateral9,
            _ => return Err(format!("elements of the type `{name}` are not read as a mesh")),
        };
        return Ok(Some(found));
    }
    let begins = |list: &[&str]| list.iter().any(|p| name.starts_with(p));
    Ok(Some(if begins(&["B32", "T3D3", "PIPE32"]) {
        Shape::Line3
    } else if begins(&["B31", "B33", "T3D2", "PIPE31", "RB3D2"]) {
        Shape::Line2
    } else if begins(&["MASS", "ROTARYI", "SPRING", "DASHPOT", "CONN3D2"]) {
        return Ok(None);
    } else {
        const KNOWN: [&str; 14] = [
            "C3D4", "C3D6", "C3D8", "C3D8R", "C3D8I", "C3D10", "C3D15", "C3D20", "C3D20R", "S3", "S4", "S4R", "B31",
            "T3D2",
        ];
        return Err(format!("no element of the type `{name}` is known{}", did_you_mean(name, KNOWN)));
    }))
}

#[derive(Default)]
struct Pass {
    mesh: Mesh,
    /// Index of the cell of a number.
    cells: HashMap<u32, usize>,
    /// Elements that are no cells.
    others: BTreeSet<u32>,
    elements: BTreeMap<String, Vec<usize>>,
    nodes: BTreeMap<String, Vec<usize>>,
    n_instances: usize,
    n_members: usize,
}

impl Pass {
    fn run(mut self, deck: &KeywordDeck) -> Result<Mesh, DeckError> {
        if let Some(second) = deck.keywords().filter(|k| k.name() == "PART").nth(1) {
            return Err(second.error("a deck of several parts is no mesh; `retune import` reads it"));
        }
        // Sets name what stands below them.
        for k in deck.keywords().filter(|k| k.name() == "NODE") {
            self.node(&k)?;
        }
        for k in deck.keywords() {
            match k.name() {
                "ELEMENT" => self.element(&k)?,
                "INSTANCE" => {
                    self.n_instances += 1;
                    if self.n_instances > 1 || k.lines().any(|l| !l.is_empty()) {
                        return Err(k.error(
                            "an assembly of several or moved instances is no mesh; `retune import` reads the deck",
                        ));
                    }
                }
                "SYSTEM" => return Err(k.error("nodes in axes of their own are read by `retune import`")),
                "NGEN" | "NFILL" | "ELGEN" | "NCOPY" | "ELCOPY" => {
                    return Err(
                        k.error("nodes and elements that the solver generates are not read; give the deck in full")
                    );
                }
                _ => {}
            }
        }
        for k in deck.keywords() {
            match k.name() {
                "NSET" => {
                    let name = k.needs("NSET")?;
                    let members = self.members(&k, true)?;
                    self.nodes.entry(name).or_default().extend(members);
                }
                "ELSET" => {
                    let name = k.needs("ELSET")?;
                    let members = self.members(&k, false)?;
                    self.elements.entry(name).or_default().extend(members);
                }
                _ => {}
            }
        }
        Ok(self.finish())
    }

    fn node(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let mut set = Vec::new();
        for line in k.lines().filter(|l| !l.is_empty()) {
            let id = line.id(0, "number")?;
            set.push(self.mesh.nodes.len());
            let node = MeshNode { id: u64::from(id), at: line.vector(1, "coordinate")? };
            if !self.mesh.add_node(node) {
                return Err(line.error(Some((0, "number")), format_args!("the node {id} stands twice")));
            }
        }
        if let Some(name) = k.label("NSET") {
            self.nodes.entry(name).or_default().extend(set);
        }
        Ok(())
    }

    fn element(&mut self, k: &Keyword<'_>) -> Result<(), DeckError> {
        let kind = k.needs("TYPE")?;
        let shape = shape(&kind).map_err(|why| k.error(why))?;
        let mut set = Vec::new();
        let mut lines = k.lines().filter(|l| !l.is_empty());
        while let Some(line) = lines.next() {
            let id = line.id(0, "number")?;
            let is_new = !self.cells.contains_key(&id) && !self.others.contains(&id);
            if !is_new {
                return Err(line.error(Some((0, "number")), format_args!("the element {id} stands twice")));
            }
            let Some(shape) = shape else {
                self.others.insert(id);
                continue;
            };
            let mut nodes = Vec::with_capacity(shape.n_nodes());
            let (mut of, mut item) = (line, 1);
            while nodes.len() < shape.n_nodes() {
                while item >= of.len() {
                    let next = lines.next().filter(|_| of.goes_on() || nodes.len() >= 8).ok_or_else(|| {
                        let text =
                            format!("the element {id} has {} nodes, and a {kind} has {}", nodes.len(), shape.n_nodes());
                        of.error(None, text)
                    })?;
                    (of, item) = (next, 0);
                }
                let node = of.id(item, "node")?;
                let found = self.mesh.node(u64::from(node));
                nodes.push(
                    found.ok_or_else(|| of.error(Some((item, "node")), format_args!("there is no node {node}")))?,
                );
                item += 1;
            }
            if item < of.len() {
                let text = format!("the element {id} has more nodes than the {} of a {kind}", shape.n_nodes());
                return Err(of.error(Some((item, "node")), text));
            }
            let cell = self.mesh.cells.len();
            self.mesh.add_cell(u64::from(id), shape, nodes);
            self.cells.insert(id, cell);
            set.push(cell);
        }
        if let Some(name) = k.label("ELSET") {
            self.elements.entry(name).or_default().extend(set);
        }
        Ok(())
    }

    /// Nodes or cells that a set names; elements that are no cells are left out.
    fn members(&mut self, k: &Keyword<'_>, of_nodes: bool) -> Result<Vec<usize>, DeckError> {
        let mut out = Vec::new();
        for line in k.lines().filter(|l| !l.is_empty()) {
            if k.parameter("GENERATE").is_some() {
                let (from, to) = (line.id(0, "first")?, line.id(1, "last")?);
                let by = if line.text(2).is_empty() { 1 } else { line.id(2, "increment")? };
                if to < from {
                    return Err(line.error(Some((1, "last")), "it must not be below the first"));
                }
                // Of a range those that exist count.
                let most = self.mesh.nodes.len().max(self.cells.len());
                if ((to - from) / by) as usize <= 4 * most {
                    out.extend((from..=to).step_by(by as usize).filter_map(|id| self.known(id, of_nodes)));
                } else {
                    let all: BTreeSet<u32> = if of_nodes {
                        self.mesh.nodes.iter().filter_map(|n| u32::try_from(n.id).ok()).collect()
                    } else {
                        self.cells.keys().copied().collect()
                    };
                    let inside = all.range(from..=to).filter(|id| (**id - from).is_multiple_of(by));
                    out.extend(inside.filter_map(|id| self.known(*id, of_nodes)));
                }
                continue;
            }
            for i in (0..line.len()).filter(|i| !line.text(*i).is_empty()) {
                out.extend(self.member(&line, i, of_nodes)?);
            }
            if self.n_members + out.len() > MOST_MEMBERS {
                return Err(line.error(None, format_args!("sets have more than {MOST_MEMBERS} members")));
            }
        }
        self.n_members += out.len();
        Ok(out)
    }

    fn known(&self, id: u32, of_nodes: bool) -> Option<usize> {
        if of_nodes { self.mesh.node(u64::from(id)) } else { self.cells.get(&id).copied() }
    }

    fn member(&self, line: &DataLine<'_>, i: usize, of_nodes: bool) -> Result<Vec<usize>, DeckError> {
        let what = if of_nodes { "node" } else { "element" };
        let text = line.text(i);
        // In an assembly `instance.5`.
        let own = text.rsplit_once('.').map_or(text, |(_, id)| id);
        if let Ok(id) = own.parse::<u32>() {
            return match self.known(id, of_nodes) {
                Some(found) => Ok(vec![found]),
                None if !of_nodes && self.others.contains(&id) => Ok(Vec::new()),
                None => Err(line.error(Some((i, "member")), format_args!("there is no {what} {id}"))),
            };
        }
        let sets = if of_nodes { &self.nodes } else { &self.elements };
        sets.get(&label(own)).cloned().ok_or_else(|| {
            let near = did_you_mean(own, sets.keys().map(String::as_str));
            line.error(Some((i, "member")), format_args!("there is no set `{own}` above{near}"))
        })
    }

    fn finish(mut self) -> Mesh {
        let sorted = |mut members: Vec<usize>| {
            members.sort_unstable();
            members.dedup();
            members
        };
        let taken: BTreeSet<String> = self.elements.keys().cloned().collect();
        for (name, cells) in std::mem::take(&mut self.elements) {
            self.mesh.sets.push(MeshSet { name, cells: sorted(cells) });
        }
        for (name, nodes) in std::mem::take(&mut self.nodes) {
            let name = if taken.contains(&name) { format!("{name}_NODES") } else { name };
            let mut cells = Vec::new();
            for node in sorted(nodes) {
                cells.push(self.mesh.cells.len());
                let id = self.mesh.nodes[node].id;
                self.mesh.add_cell(id, Shape::Point, [node]);
            }
            self.mesh.sets.push(MeshSet { name, cells });
        }
        self.mesh
    }
}
