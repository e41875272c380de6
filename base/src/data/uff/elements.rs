//! Datasets 2412 and 82: elements and trace lines.

use super::cursor::{Cursor, Fault};
use super::note::Level;
use super::sink::Sink;
use crate::catalogue::counted;

/// An element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Its label.
    pub label: i64,
    /// Kind of element: 11 rod, 21 to 24 beams, 91 and 94 thin shells of three and four nodes, 111 and 115 solids, ...
    pub descriptor: i64,
    /// Table of physical properties.
    pub physical_table: i64,
    /// Table of material properties.
    pub material_table: i64,
    /// Color.
    pub color: i64,
    /// For rods and beams: orientation node, fore-end and aft-end cross section.
    pub beam: Option<[i64; 3]>,
    /// Labels of its nodes.
    pub nodes: Vec<i64>,
}

/// Whether elements of this kind have the extra record of rods and beams.
fn is_beam(descriptor: i64) -> bool {
    matches!(descriptor, 11 | 21..=24)
}

pub(super) fn read_2412(cursor: &mut Cursor<'_, '_>) -> Result<Vec<Element>, Fault> {
    let mut elements = Vec::new();
    while let Some(text) = cursor.filled_record() {
        let head = cursor.split(&text, &[10; 6], "the head of an element")?;
        let descriptor = head.int(1);
        let beam = if is_beam(descriptor) {
            let n = cursor.numbers(&[10; 3], "the beam record of an element")?;
            Some([n.int(0), n.int(1), n.int(2)])
        } else {
            None
        };
        let count = usize::try_from(head.int(5)).unwrap_or(0);
        let mut nodes = cursor.ints(count)?;
        if nodes.len() != count {
            let seen = format!("element {} with {}, {count} announced", head.int(0), counted(nodes.len(), "node"));
            cursor.note(Level::Warning, seen, "at most the announced ones were kept");
            nodes.truncate(count);
        }
        elements.push(Element {
            label: head.int(0),
            descriptor,
            physical_table: head.int(2),
            material_table: head.int(3),
            color: head.int(4),
            beam,
            nodes,
        });
    }
    Ok(elements)
}

pub(super) fn write_2412(elements: &[Element], sink: &mut Sink) {
    sink.begin(2412);
    for e in elements {
        let count = e.nodes.len() as i64;
        sink.int_lines(&[e.label, e.descriptor, e.physical_table, e.material_table, e.color, count]);
        if is_beam(e.descriptor) {
            sink.int_lines(&e.beam.unwrap_or_default());
        }
        sink.int_lines(&e.nodes);
    }
    sink.end();
}

/// A trace line: a polyline through nodes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceLine {
    /// Its number.
    pub number: i64,
    /// Color.
    pub color: i64,
    /// Its name.
    pub name: String,
    /// Labels of nodes; 0 lifts the pen, and a move to the first node is implied.
    pub nodes: Vec<i64>,
}

pub(super) fn read_82(cursor: &mut Cursor<'_, '_>) -> Result<TraceLine, Fault> {
    let head = cursor.numbers(&[10; 3], "the head of the trace line")?;
    let name = cursor.text();
    let announced = usize::try_from(head.int(1)).unwrap_or(0);
    let mut nodes = cursor.ints(usize::MAX)?;
    if nodes.len() < announced {
        let seen = format!("{} announced, {} present", counted(announced, "node"), nodes.len());
        cursor.note(Level::Warning, seen, "the nodes present were read");
    } else if nodes[announced..].iter().all(|n| *n == 0) {
        // Some writers fill the last record with zeros.
        nodes.truncate(announced);
    } else {
        let seen = format!("{} announced, {} present", counted(announced, "node"), nodes.len());
        cursor.note(Level::Warning, seen, "all nodes present were read");
    }
    Ok(TraceLine { number: head.int(0), color: head.int(2), name, nodes })
}

pub(super) fn write_82(line: &TraceLine, sink: &mut Sink) {
    sink.begin(82);
    sink.int_lines(&[line.number, line.nodes.len() as i64, line.color]);
    sink.text(&line.name);
    sink.int_lines(&line.nodes);
    sink.end();
}
