//! Datasets 18 and 2420: coordinate systems.

use super::cursor::{Cursor, Fault, never};
use super::note::Level;
use super::sink::Sink;

/// A coordinate system of dataset 18.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateSystem {
    /// Its number.
    pub number: i64,
    /// 0 Cartesian, 1 cylindrical, 2 spherical.
    pub kind: i64,
    /// The system in which the points below are given; 0 is the global one.
    pub reference: i64,
    /// Color.
    pub color: i64,
    /// 1: by origin, a point on the +x axis and a point in the +xz plane.
    pub method: i64,
    /// Its name.
    pub name: String,
    /// Origin, point on the +x axis, point in the +xz plane.
    pub points: [[f64; 3]; 3],
}

pub(super) fn read_18(cursor: &mut Cursor<'_, '_>) -> Result<Vec<CoordinateSystem>, Fault> {
    let mut systems = Vec::new();
    while let Some(text) = cursor.filled_record() {
        let head = cursor.split(&text, &[10; 5], "the head of a coordinate system")?;
        let name = cursor.text();
        let mut p = Vec::new();
        cursor.floats(9, &[13; 6], never, &mut p)?;
        let &[a, b, c, d, e, f, g, h, i] = p.as_slice() else {
            let seen = format!("coordinate system {} with {} of 9 numbers", head.int(0), p.len());
            cursor.note(Level::Warning, seen, "it was left out");
            break;
        };
        systems.push(CoordinateSystem {
            number: head.int(0),
            kind: head.int(1),
            reference: head.int(2),
            color: head.int(3),
            method: head.int(4),
            name,
            points: [[a, b, c], [d, e, f], [g, h, i]],
        });
    }
    Ok(systems)
}

pub(super) fn write_18(systems: &[CoordinateSystem], sink: &mut Sink) {
    sink.begin(18);
    for s in systems {
        sink.int_lines(&[s.number, s.kind, s.reference, s.color, s.method]);
        sink.text(&s.name);
        sink.float_lines(s.points.as_flattened(), &[13; 6]);
    }
    sink.end();
}

/// The coordinate systems of a part, dataset 2420.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Number of the part.
    pub uid: i64,
    /// Its name.
    pub name: String,
    /// Its systems.
    pub systems: Vec<PartSystem>,
}

/// A coordinate system of dataset 2420.
#[derive(Debug, Clone, PartialEq)]
pub struct PartSystem {
    /// Its label.
    pub label: i64,
    /// 0 Cartesian, 1 cylindrical, 2 spherical.
    pub kind: i64,
    /// Color.
    pub color: i64,
    /// Its name.
    pub name: String,
    /// Rows 1 to 3: its axes in the part's axes; row 4: its origin.
    pub rows: [[f64; 3]; 4],
}

pub(super) fn read_2420(cursor: &mut Cursor<'_, '_>) -> Result<Part, Fault> {
    let uid = cursor.numbers(&[10; 2], "the number of the part")?.int(0);
    let name = cursor.text();
    let mut systems = Vec::new();
    while let Some(text) = cursor.filled_record() {
        let head = cursor.split(&text, &[10; 4], "the head of a coordinate system")?;
        let name = cursor.text();
        let mut m = Vec::new();
        cursor.floats(12, &[25; 3], never, &mut m)?;
        if m.len() < 12 {
            let seen = format!("coordinate system {} with {} of 12 numbers", head.int(0), m.len());
            cursor.note(Level::Warning, seen, "it was left out");
            break;
        }
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j]));
        systems.push(PartSystem { label: head.int(0), kind: head.int(1), color: head.int(2), name, rows });
    }
    Ok(Part { uid, name, systems })
}

pub(super) fn write_2420(part: &Part, sink: &mut Sink) {
    sink.begin(2420);
    sink.int_lines(&[part.uid]);
    sink.text(&part.name);
    for s in &part.systems {
        sink.int_lines(&[s.label, s.kind, s.color]);
        sink.text(&s.name);
        for row in s.rows {
            for value in row {
                sink.double(value, 16);
            }
            sink.end_record();
        }
    }
    sink.end();
}
