//! Matrices that Abaqus assembles (`*MATRIX GENERATE`, `*MATRIX OUTPUT`, format MATRIX INPUT): lines of row node, row dof, column node, column
//! dof, value.
//!
//! ```text
//! ** comment
//!  1,1, 1,1,  3.365384615384615e+05
//! ```
//!
//! Of a symmetric matrix one triangle is given. Nodes of elements' own (Lagrange multipliers, hybrid pressures) have negative numbers.
//!
//! Source: Dassault Systèmes, Abaqus Analysis User's Guide, "Generating structural matrices".

use super::matrix::{Numbered, dof};
use super::text::{Lines, number};
use super::{Contents, File, Label, Matrix, MatrixError, MatrixReader};
use std::collections::HashSet;

/// MATRIX INPUT of Abaqus.
#[derive(Debug, Clone, Copy)]
pub struct LabelledLines;

const FORMAT: &str = "matrix of Abaqus";

fn entry(line: &str) -> Option<(Label, Label, f64)> {
    let words: Vec<&str> = line.split(',').map(str::trim).filter(|w| !w.is_empty()).collect();
    let &[row, row_dof, column, column_dof, value] = words.as_slice() else { return None };
    let label = |node: &str, direction: &str| {
        let number: i64 = node.parse().ok()?;
        // Dofs that are not motions (temperatures, multipliers) have numbers above 6, or belong to nodes below zero.
        let direction: u32 = direction.parse().ok()?;
        let dof = dof(&direction.to_string()).filter(|_| number > 0);
        let node = if dof.is_some() { number.to_string() } else { format!("{number}.{direction}") };
        Some(Label { node, dof })
    };
    Some((label(row, row_dof)?, label(column, column_dof)?, number(value)?))
}

impl MatrixReader for LabelledLines {
    fn name(&self) -> &'static str {
        "abaqus-matrix"
    }

    fn summary(&self) -> &'static str {
        "Matrices that Abaqus assembles (.mtx of *MATRIX GENERATE, format MATRIX INPUT): row node, row dof, column node, column dof, value."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let lines = file.first_lines();
        let mut lines = lines.iter().filter(|l| !l.starts_with('*')).take(4).peekable();
        lines.peek().is_some() && lines.all(|l| entry(l).is_some())
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let mut labels = Numbered::default();
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        while let Some(line) = lines.next() {
            if line.trim().is_empty() || line.trim_start().starts_with('*') {
                continue;
            }
            let Some((row, column, value)) = entry(line) else {
                return Err(MatrixError::line(
                    FORMAT,
                    lines.number,
                    line,
                    "`row node, row dof, column node, column dof, value`",
                ));
            };
            entries.push((labels.index(row), labels.index(column), value));
        }
        // In the order of nodes and dofs.
        let labels = labels.labels;
        let mut order: Vec<usize> = (0..labels.len()).collect();
        let rank =
            |i: usize| (labels[i].node.parse::<u64>().unwrap_or(u64::MAX), labels[i].dof, labels[i].node.clone());
        order.sort_by_cached_key(|&i| rank(i));
        let mut place = vec![0; labels.len()];
        order.iter().enumerate().for_each(|(to, &from)| place[from] = to);
        let beside: HashSet<(usize, usize)> = entries.iter().filter(|e| e.0 != e.1).map(|e| (e.0, e.1)).collect();
        let is_one_triangle = !beside.iter().any(|(r, c)| beside.contains(&(*c, *r)));
        let mut matrix = Matrix {
            name: file.stem().to_string(),
            n_rows: labels.len(),
            n_columns: labels.len(),
            is_one_triangle,
            rows: order.iter().map(|&i| labels[i].clone()).collect(),
            ..Matrix::default()
        };
        for (row, column, value) in entries {
            matrix.push(place[row], place[column], value);
        }
        Ok(Contents::of(matrix))
    }
}
