//! The table of dofs that Ansys writes beside `HBMAT` (`.mapping`): equation, node, dof.
//!
//! ```text
//!      Matrix Eqn       Node      DOF
//!               1          2      UX
//! ```
//!
//! Source: Ansys Mechanical APDL Command Reference, HBMAT.

use super::matrix::dof;
use super::text::Lines;
use super::{Contents, DofRow, File, Label, MatrixError, MatrixReader};

/// `.mapping` of Ansys.
#[derive(Debug, Clone, Copy)]
pub struct Mapping;

const FORMAT: &str = "mapping of Ansys";

fn row(line: &str) -> Option<(usize, Label)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let &[equation, node, direction] = words.as_slice() else { return None };
    let (equation, node) = (equation.parse().ok()?, node.parse::<u64>().ok()?);
    Some((equation, Label { node: node.to_string(), dof: Some(dof(direction)?) }))
}

impl MatrixReader for Mapping {
    fn name(&self) -> &'static str {
        "ansys-mapping"
    }

    fn summary(&self) -> &'static str {
        "Table of dofs of Ansys (.mapping of HBMAT): equation, node, dof."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let head = file.head().to_lowercase();
        let first = head.lines().find(|l| !l.trim().is_empty());
        first.is_some_and(|l| l.contains("eqn") && l.contains("node") && l.contains("dof"))
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let mut rows: Vec<(usize, Label)> = Vec::new();
        let mut has_head = false;
        while let Some(line) = lines.next() {
            if line.trim().is_empty() {
                continue;
            }
            if !has_head {
                has_head = true;
                continue;
            }
            let found = row(line).ok_or_else(|| {
                MatrixError::line(FORMAT, lines.number, line, "`equation node dof` with a dof of UX to ROTZ")
            })?;
            rows.push(found);
        }
        rows.sort_by_key(|r| r.0);
        if rows.iter().enumerate().any(|(i, r)| r.0 != i + 1) {
            return Err(MatrixError::broken(
                FORMAT,
                format_args!("its equations are not numbered 1 to {} each once", rows.len()),
            ));
        }
        let dofs = rows.into_iter().map(|(_, label)| DofRow { label, position: None, frame: None }).collect();
        Ok(Contents { dofs, ..Contents::default() })
    }
}
