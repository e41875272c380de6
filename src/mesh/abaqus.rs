//! Nodes, elements and sets of a deck of Abaqus or CalculiX, as most preprocessors write them.
//!
//! Sections, materials and everything else stay unread: what stands on the mesh is said in the model file. `retune import` reads the whole deck.
//! A set of nodes becomes one of points. One part with one instance that is not moved is a mesh; several are an assembly, which is not.

use super::MeshReader;
use super::cell::{Mesh, MeshNode, MeshSet, Shape};
use super::cursor::{ALONE, MeshError, only_file};
use crate::catalogue::did_you_mean;
use crate::deck::{DataLine, DeckError, Keyword, KeywordDeck, is_keyword_deck, label};
use std::collections::{BTreeMap, BTreeSet};
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
        let deck = KeywordDeck::read(Path::new(ALONE), &mut only_file(bytes))?;
        Ok(Pass::new().run(&deck)?)
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

/// What sets have as members.
#[derive(Default)]
struct Members {
    /// In words.
    what: &'static str,
    /// Index of the node or the cell of a number.
    index: BTreeMap<u32, usize>,
    /// Numbers that are there and are left out of sets: of elements that are not cells.
    others: BTreeSet<u32>,
    sets: BTreeMap<String, Vec<usize>>,
}

impl Members {
    fn join(&mut self, set: String, members: Vec<usize>) {
        self.sets.entry(set).or_default().extend(members);
    }
}

struct Pass {
    mesh: Mesh,
    nodes: Members,
    cells: Members,
    n_members: usize,
}

/// Refuses what makes a deck more than a mesh.
fn refuse(deck: &KeywordDeck) -> Result<(), DeckError> {
    if let Some(second) = deck.keywords().filter(|k| k.name() == "PART").nth(1) {
        return Err(second.error("a deck of several parts is not a mesh; `retune import` reads it"));
    }
    let mut has_instance = false;
    for k in deck.keywords() {
        match k.name() {
            "INSTANCE" if has_instance || k.lines().any(|l| !l.is_empty()) => {
                return Err(
                    k.error("an assembly of several or moved instances is not a mesh; `retune import` reads the deck")
                );
            }
            "INSTANCE" => has_instance = true,
            "SYSTEM" => return Err(k.error("nodes in axes of their own are read by `retune import`")),
            "NGEN" | "NFILL" | "ELGEN" | "NCOPY" | "ELCOPY" => {
                return Err(k.error("nodes and elements that the solver generates are not read; give the deck in full"));
            }
            _ => {}
        }
    }
    Ok(())
}

impl Pass {
    fn new() -> Self {
        let [nodes, cells] = ["node", "element"].map(|what| Members { what, ..Members::default() });
        Self { mesh: Mesh::default(), nodes, cells, n_members: 0 }
    }

    fn run(mut self, deck: &KeywordDeck) -> Result<Mesh, DeckError> {
        refuse(deck)?;
        // Elements may stand above their nodes, and sets above both.
        let of = |name: &'static str| deck.keywords().filter(move |k| k.name() == name);
        of("NODE").try_for_each(|k| self.node(&k))?;
        of("ELEMENT").try_for_each(|k| self.element(&k))?;
        for k in deck.keywords() {
            match k.name() {
                "NSET" => {
                    let members = self.members(&k, &self.nodes)?;
                    self.n_members += members.len();
                    self.nodes.join(k.needs("NSET")?, members);
                }
                "ELSET" => {
                    let members = self.members(&k, &self.cells)?;
                    self.n_members += members.len();
                    self.cells.join(k.needs("ELSET")?, members);
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
            let index = self.mesh.nodes.len();
            set.push(index);
            self.nodes.index.insert(id, index);
            let node = MeshNode { id: u64::from(id), at: line.vector(1, "coordinate")? };
            if !self.mesh.add_node(node) {
                return Err(line.error(Some((0, "number")), format_args!("the node {id} is defined twice")));
            }
        }
        if let Some(name) = k.label("NSET") {
            self.nodes.join(name, set);
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
            let is_new = !self.cells.index.contains_key(&id) && !self.cells.others.contains(&id);
            if !is_new {
                return Err(line.error(Some((0, "number")), format_args!("the element {id} is defined twice")));
            }
            let Some(shape) = shape else {
                self.cells.others.insert(id);
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
            self.cells.index.insert(id, cell);
            set.push(cell);
        }
        if let Some(name) = k.label("ELSET") {
            self.cells.join(name, set);
        }
        Ok(())
    }

    /// Nodes or cells that a set names; elements that are not cells are left out.
    fn members(&self, k: &Keyword<'_>, of: &Members) -> Result<Vec<usize>, DeckError> {
        let mut out = Vec::new();
        for line in k.lines().filter(|l| !l.is_empty()) {
            if k.parameter("GENERATE").is_some() {
                let (from, to) = (line.id(0, "first")?, line.id(1, "last")?);
                let by = if line.text(2).is_empty() { 1 } else { line.id(2, "increment")? };
                if to < from {
                    return Err(line.error(Some((1, "last")), "it must not be below the first"));
                }
                // Of a range those that exist count.
                let inside = of.index.range(from..=to).filter(|(id, _)| (**id - from).is_multiple_of(by));
                out.extend(inside.map(|(_, index)| *index));
            } else {
                for i in (0..line.len()).filter(|i| !line.text(*i).is_empty()) {
                    out.extend(Self::member(&line, i, of)?);
                }
            }
            if self.n_members + out.len() > MOST_MEMBERS {
                return Err(line.error(None, format_args!("sets have more than {MOST_MEMBERS} members")));
            }
        }
        Ok(out)
    }

    fn member(line: &DataLine<'_>, i: usize, of: &Members) -> Result<Vec<usize>, DeckError> {
        let text = line.text(i);
        // In an assembly `instance.5`.
        let own = text.rsplit_once('.').map_or(text, |(_, id)| id);
        if let Ok(id) = own.parse::<u32>() {
            return match of.index.get(&id) {
                Some(found) => Ok(vec![*found]),
                None if of.others.contains(&id) => Ok(Vec::new()),
                None => Err(line.error(Some((i, "member")), format_args!("there is no {} {id}", of.what))),
            };
        }
        of.sets.get(&label(own)).cloned().ok_or_else(|| {
            let near = did_you_mean(own, of.sets.keys().map(String::as_str));
            line.error(Some((i, "member")), format_args!("there is no set `{own}` above{near}"))
        })
    }

    fn finish(mut self) -> Mesh {
        let sorted = |mut members: Vec<usize>| {
            members.sort_unstable();
            members.dedup();
            members
        };
        let taken: BTreeSet<String> = self.cells.sets.keys().cloned().collect();
        for (name, cells) in std::mem::take(&mut self.cells.sets) {
            self.mesh.sets.push(MeshSet { name, cells: sorted(cells) });
        }
        for (name, nodes) in std::mem::take(&mut self.nodes.sets) {
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
