//! Tables of dofs and of positions in CSV: the one that retune writes, and the one to write by hand.
//!
//! ```text
//! node,dof,x,y,z,frame
//! 12,ux,0.1,0,0.02,
//! q1,modal,,,,
//! ```
//!
//! `dof` is `ux` ... `rz` or 1 ... 6, or `modal` for a coordinate that is not a motion of a point. Columns are found by their names; without `dof` the
//! table is one of positions. Rows of `dof` are in the order of the matrices. Commas, semicolons or tabs.

use super::matrix::dof;
use super::text::{Lines, number};
use super::{Contents, DofRow, File, Label, MatrixError, MatrixReader};
use std::fmt::Write as _;

/// CSV.
#[derive(Debug, Clone, Copy)]
pub struct Table;

const FORMAT: &str = "table of dofs";

/// Words of a line, by the separator of the head.
fn words(line: &str, separator: char) -> Vec<&str> {
    line.split(separator).map(|w| w.trim().trim_matches('"').trim()).collect()
}

fn separator(head: &str) -> char {
    [';', '\t'].into_iter().find(|s| head.contains(*s)).unwrap_or(',')
}

impl MatrixReader for Table {
    fn name(&self) -> &'static str {
        "table"
    }

    fn summary(&self) -> &'static str {
        "CSV with a head: `node,dof,x,y,z,frame` for a table of dofs, `node,x,y,z` for positions."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let lines = file.first_lines();
        let Some(head) = lines.first().map(|l| l.trim_start_matches('\u{feff}').to_lowercase()) else { return false };
        words(&head, separator(&head)).contains(&"node")
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let head = loop {
            let line = lines.next().unwrap_or_default().trim_start_matches('\u{feff}');
            if !line.trim().is_empty() && !line.starts_with(['#', '%']) {
                break line.to_lowercase();
            }
            if lines.rest().is_empty() {
                return Err(MatrixError::broken(FORMAT, "it has no head `node,dof,x,y,z`"));
            }
        };
        let separator = separator(&head);
        let names = words(&head, separator);
        if let Some(unknown) = names.iter().find(|n| !["node", "dof", "x", "y", "z", "frame"].contains(n)) {
            return Err(MatrixError::line(
                FORMAT,
                lines.number,
                unknown,
                "a column `node`, `dof`, `x`, `y`, `z` or `frame`",
            ));
        }
        let column = |name: &str| names.iter().position(|n| *n == name);
        let (node, direction, frame) = (column("node"), column("dof"), column("frame"));
        let coordinates = [column("x"), column("y"), column("z")];
        if coordinates.iter().any(Option::is_some) && !coordinates.iter().all(Option::is_some) {
            return Err(MatrixError::line(FORMAT, lines.number, &head, "all of `x`, `y`, `z`, or none of them,"));
        }
        let mut contents = Contents::default();
        while let Some(line) = lines.next() {
            if line.trim().is_empty() || line.starts_with(['#', '%']) {
                continue;
            }
            let words = words(line, separator);
            let word = |column: Option<usize>| column.and_then(|i| words.get(i)).copied().unwrap_or_default();
            let wrong = |expected| MatrixError::line(FORMAT, lines.number, line, expected);
            if words.len() > names.len() {
                return Err(wrong("as many values as the head has columns"));
            }
            let name = word(node);
            if name.is_empty() || name.chars().any(char::is_control) {
                return Err(wrong("a row with a `node`"));
            }
            let position = match coordinates.map(word) {
                ["", "", ""] => None,
                [x, y, z] => match (number(x), number(y), number(z)) {
                    (Some(x), Some(y), Some(z)) => Some([x, y, z]),
                    _ => return Err(wrong("three coordinates in numbers")),
                },
            };
            if direction.is_none() {
                let position = position.ok_or_else(|| wrong("a position"))?;
                contents.positions.push((name.to_string(), position));
                continue;
            }
            let dof = match word(direction).to_lowercase().as_str() {
                "modal" | "q" => None,
                other => Some(dof(other).ok_or_else(|| wrong("a `dof` of `ux` to `rz`, 1 to 6, or `modal`"))?),
            };
            let frame = Some(word(frame)).filter(|f| !f.is_empty()).map(str::to_string);
            contents.dofs.push(DofRow { label: Label { node: name.to_string(), dof }, position, frame });
        }
        Ok(contents)
    }
}

/// Writes a table of dofs; every coordinate reads back to the same bits.
pub(super) fn write(dofs: &[DofRow]) -> String {
    let mut out = String::from("node,dof,x,y,z\n");
    for row in dofs {
        let dof = row.label.dof.map_or("modal", |d| d.name());
        let [x, y, z] = row.position.map_or([const { String::new() }; 3], |p| p.map(|c| format!("{c:?}")));
        let _ = writeln!(out, "{},{dof},{x},{y},{z}", row.label.node);
    }
    out
}
