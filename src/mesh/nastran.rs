//! Grids and elements of Nastran bulk data.
//!
//! Elements of one property are a set, `p12` by its number. Sections, materials and everything else stay unread: what stands on the mesh is said in
//! the model file. `retune import` reads the whole deck.

use super::MeshReader;
use super::cell::{Mesh, MeshNode, MeshSet, Shape};
use super::cursor::{ALONE, MeshError, only_file};
use crate::deck::{Card, Deck, DeckError};
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

#[doc = "Bulk data of Nastran."]
#[derive(Debug, Clone, Copy)]
pub struct Nastran;

impl MeshReader for Nastran {
    fn name(&self) -> &'static str {
        "nastran"
    }

    fn summary(&self) -> &'static str {
        "Bulk data of Nastran (.bdf, .dat, .nas): GRID and the elements, those of one property as the set `p12`."
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        // What stands on almost every deck, at the beginning of a line.
        let head = &bytes[..bytes.len().min(1 << 20)];
        let is = |line: &[u8], word: &[u8]| {
            let rest = line.get(word.len()..).unwrap_or_default();
            line.get(..word.len()).is_some_and(|w| w.eq_ignore_ascii_case(word))
                && rest.first().is_none_or(|c| b" *,\t\r".contains(c))
        };
        let begins = |line: &[u8]| [&b"GRID"[..], b"CEND", b"BEGIN BULK", b"SOL"].iter().any(|word| is(line, word));
        head.split(|c| *c == b'\n').any(begins)
    }

    fn read(&self, bytes: &[u8]) -> Result<Mesh, MeshError> {
        let deck = Deck::read(Path::new(ALONE), &mut only_file(bytes))?;
        Ok(mesh(&deck)?)
    }
}

/// For each of our nodes its place among the grids of a card, where the middles of its edges stand in another order: those of the edges between both
/// ends come before those of the far end.
///
/// * `corners` - of the near end: four of a hexahedron, three of a wedge
pub fn order_of_edges(corners: usize) -> Vec<usize> {
    let near = 3 * corners;
    (0..near).chain(near + corners..near + 2 * corners).chain(near..near + corners).collect()
}

/// The shape of an element with so many grids; nothing where it is not a cell.
fn shape(name: &str, grids: usize) -> Option<(Shape, Option<Vec<usize>>)> {
    let plain = |shape| Some((shape, None));
    match (name, grids) {
        ("CQUAD4" | "CQUADR" | "CSHEAR" | "CQUAD8", 4) => plain(Shape::Quadrilateral4),
        ("CTRIA3" | "CTRIAR" | "CTRIA6", 3) => plain(Shape::Triangle3),
        ("CQUAD8", 8) => plain(Shape::Quadrilateral8),
        ("CTRIA6", 6) => plain(Shape::Triangle6),
        ("CTETRA", 4) => plain(Shape::Tetrahedron4),
        ("CTETRA", 10) => plain(Shape::Tetrahedron10),
        ("CPYRAM", 5) => plain(Shape::Pyramid5),
        ("CPYRAM", 13) => plain(Shape::Pyramid13),
        ("CPENTA", 6) => plain(Shape::Wedge6),
        ("CPENTA", 15) => Some((Shape::Wedge15, Some(order_of_edges(3)))),
        ("CHEXA", 8) => plain(Shape::Hexahedron8),
        ("CHEXA", 20) => Some((Shape::Hexahedron20, Some(order_of_edges(4)))),
        ("CBAR" | "CBEAM" | "CROD" | "CTUBE", _) => plain(Shape::Line2),
        _ => None,
    }
}

/// Fields of an element's grids, at most.
fn fields(name: &str) -> Option<usize> {
    Some(match name {
        "CBAR" | "CBEAM" | "CROD" | "CTUBE" => 2,
        "CTRIA3" | "CTRIAR" => 3,
        "CQUAD4" | "CQUADR" | "CSHEAR" => 4,
        "CTRIA6" => 6,
        "CQUAD8" => 8,
        "CTETRA" => 10,
        "CPYRAM" => 13,
        "CPENTA" => 15,
        "CHEXA" => 20,
        _ => return None,
    })
}

fn mesh(deck: &Deck) -> Result<Mesh, DeckError> {
    let mut mesh = Mesh::default();
    for card in deck.cards().filter(|c| deck.name(*c) == "GRID").map(|c| deck.card(c)) {
        if !matches!(card.text(3), "" | "0") {
            return Err(card.error(Some((3, "CP")), "grids in axes of their own are read by `retune import`"));
        }
        let id = card.id_at(2, "ID")?;
        if !mesh.add_node(MeshNode { id: u64::from(id), at: card.vector(4, "X1")? }) {
            return Err(card.error(Some((2, "ID")), format_args!("the grid {id} is defined twice")));
        }
    }
    if mesh.nodes.is_empty() {
        let file = deck.sources()[0].name().to_string();
        let message = "the deck has no GRID".to_string();
        return Err(DeckError { file, line: 0, card: String::new(), field: None, message });
    }
    let mut sets: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut seen = HashSet::new();
    for id in deck.cards() {
        let Some(most) = fields(deck.name(id)) else { continue };
        let card = deck.card(id);
        let eid = card.id_at(2, "EID")?;
        if !seen.insert(eid) {
            return Err(card.error(Some((2, "EID")), format_args!("the element {eid} is defined twice")));
        }
        let pid = card.optional_id(3, "PID")?.unwrap_or(eid);
        let grids = grids(&card, &mesh, most)?;
        let Some((shape, order)) = shape(card.name(), grids.len()) else {
            let text = format!(
                "{} grids are given; all of the corners, or all with those of every edge, are expected",
                grids.len()
            );
            return Err(card.error(Some((4, "G1")), text));
        };
        sets.entry(pid).or_default().push(mesh.cells.len());
        match order {
            Some(order) => mesh.add_cell(u64::from(eid), shape, order.into_iter().map(|i| grids[i])),
            None => mesh.add_cell(u64::from(eid), shape, grids),
        }
    }
    mesh.sets = sets.into_iter().map(|(pid, cells)| MeshSet { name: format!("p{pid}"), cells }).collect();
    Ok(mesh)
}

fn grids(card: &Card<'_>, mesh: &Mesh, most: usize) -> Result<Vec<usize>, DeckError> {
    let mut out = Vec::with_capacity(most);
    for field in (4..4 + most).filter(|n| !matches!(card.text(*n), "" | "0")) {
        let id = card.id_at(field, "G")?;
        let found = mesh.node(u64::from(id));
        out.push(found.ok_or_else(|| card.error(Some((field, "G")), format_args!("there is no GRID {id}")))?);
    }
    Ok(out)
}
