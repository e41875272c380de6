//! Datasets 15 and 2411: nodes.

use super::cursor::{Cursor, Fault};
use super::note::Level;
use super::sink::Sink;

/// A node.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Its label.
    pub label: i64,
    /// Coordinate system in which the position is given (15) or was entered (2411); 0 is the global one.
    pub definition_cs: i64,
    /// Coordinate system of its displacements; 0 is the global one.
    pub displacement_cs: i64,
    /// Color.
    pub color: i64,
    /// Position in the units of the file: in the definition system (15) or in that of the part (2411).
    pub position: [f64; 3],
}

const LABELS: [usize; 4] = [10; 4];

/// Dataset 15: everything in one record.
pub(super) fn read_15(cursor: &mut Cursor<'_, '_>) -> Vec<Node> {
    const COLUMNS: [usize; 7] = [10, 10, 10, 10, 13, 13, 13];
    let mut nodes = Vec::new();
    while let Some(text) = cursor.filled_record() {
        match cursor.split(&text, &COLUMNS, "a node") {
            Ok(n) if n.filled() == COLUMNS.len() => nodes.push(Node {
                label: n.int(0),
                definition_cs: n.int(1),
                displacement_cs: n.int(2),
                color: n.int(3),
                position: [n.float(4), n.float(5), n.float(6)],
            }),
            Ok(n) => cursor.note(Level::Warning, format!("{} of 7 fields of a node", n.filled()), "it was left out"),
            Err(fault) => cursor.note(Level::Warning, fault.seen, "the record was left out"),
        }
    }
    nodes
}

/// Dataset 2411: labels and coordinates in turn.
pub(super) fn read_2411(cursor: &mut Cursor<'_, '_>) -> Result<Vec<Node>, Fault> {
    const COLUMNS: [usize; 3] = [25; 3];
    let mut nodes = Vec::new();
    while let Some(text) = cursor.filled_record() {
        let labels = cursor.split(&text, &LABELS, "the label of a node")?;
        let Some(text) = cursor.filled_record() else {
            cursor.note(Level::Warning, format!("node {} has no coordinates", labels.int(0)), "it was left out");
            break;
        };
        let xyz = cursor.split(&text, &COLUMNS, "the coordinates of a node")?;
        if xyz.filled() < 3 {
            cursor.note(Level::Warning, format!("node {} lacks coordinates", labels.int(0)), "it was left out");
            continue;
        }
        nodes.push(Node {
            label: labels.int(0),
            definition_cs: labels.int(1),
            displacement_cs: labels.int(2),
            color: labels.int(3),
            position: [xyz.float(0), xyz.float(1), xyz.float(2)],
        });
    }
    Ok(nodes)
}

fn labels(node: &Node) -> [(i64, usize); 4] {
    [(node.label, 10), (node.definition_cs, 10), (node.displacement_cs, 10), (node.color, 10)]
}

pub(super) fn write_15(nodes: &[Node], sink: &mut Sink) {
    sink.begin(15);
    for node in nodes {
        sink.ints(&labels(node));
        for x in node.position {
            sink.float(x, 13, 5);
        }
        sink.end_record();
    }
    sink.end();
}

pub(super) fn write_2411(nodes: &[Node], sink: &mut Sink) {
    sink.begin(2411);
    for node in nodes {
        sink.ints(&labels(node));
        sink.end_record();
        for x in node.position {
            sink.double(x, 16);
        }
        sink.end_record();
    }
    sink.end();
}
