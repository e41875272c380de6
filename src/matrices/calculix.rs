//! Matrices of CalculiX (`*FREQUENCY, SOLVER=MATRIXSTORAGE`): `.sti` and `.mas` with one triangle, `.dof` with the dof of every row.
//!
//! ```text
//! job.sti: 1 2  -1.4901161193848e-08      row, column, value; row <= column
//! job.dof: 7.1                            node.direction
//! ```
//!
//! Fixed dofs are not rows. Lines of `row column value` of other programs (Abaqus with FORMAT=COORDINATE) are read alike; whether they are
//! one triangle is seen from them.
//!
//! Source: G. Dhondt, CalculiX CrunchiX User's Manual, version 2.20, *FREQUENCY; matrixstorage.c.

use super::matrix::dof;
use super::text::{Lines, number};
use super::{Contents, DofRow, File, Label, Matrix, MatrixError, MatrixReader};

/// Lines of `row column value`.
#[derive(Debug, Clone, Copy)]
pub struct IndexedLines;

/// Lines of `node.direction`.
#[derive(Debug, Clone, Copy)]
pub struct DofLines;

const INDEXED: &str = "lines of `row column value`";
const DOFS: &str = "table of dofs of CalculiX";

fn indexed(line: &str) -> Option<(usize, usize, f64)> {
    let mut words = line.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
    let place = |w: &str| w.parse::<usize>().ok()?.checked_sub(1);
    let (row, column, value) = (place(words.next()?)?, place(words.next()?)?, number(words.next()?)?);
    words.next().is_none().then_some((row, column, value))
}

impl MatrixReader for IndexedLines {
    fn name(&self) -> &'static str {
        "indexed-lines"
    }

    fn summary(&self) -> &'static str {
        "Lines of `row column value`: .sti and .mas of CalculiX (SOLVER=MATRIXSTORAGE), Abaqus with FORMAT=COORDINATE."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let lines = file.first_lines();
        let is_table = matches!(file.extension().as_str(), "csv" | "dof");
        // The last of the lines that are looked at may be cut.
        !is_table && !lines.is_empty() && lines.iter().take(4).all(|l| indexed(l).is_some())
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let mut all = Vec::new();
        let (mut n, mut has_lower, mut has_upper) = (0, false, false);
        while let Some(line) = lines.next() {
            let text = line.trim();
            if text.is_empty() || ["**", "#", "%"].iter().any(|c| text.starts_with(c)) {
                continue;
            }
            let entry = indexed(text).filter(|e| u32::try_from(e.0.max(e.1)).is_ok());
            let Some((row, column, value)) = entry else {
                return Err(MatrixError::line(INDEXED, lines.number, line, "`row column value`, counted from 1,"));
            };
            n = n.max(row + 1).max(column + 1);
            has_lower |= row > column;
            has_upper |= row < column;
            all.push((row, column, value));
        }
        let mut matrix = Matrix {
            name: file.stem().to_string(),
            n_rows: n,
            n_columns: n,
            is_one_triangle: has_lower != has_upper,
            ..Matrix::default()
        };
        matrix.entries.reserve(all.len());
        for (row, column, value) in all {
            matrix.push(row, column, value);
        }
        Ok(Contents::of(matrix))
    }
}

/// `7.1`: node 7, direction 1.
fn numbered(line: &str) -> Option<Label> {
    let (node, direction) = line.trim().split_once('.')?;
    let is_number = !node.is_empty() && node.bytes().all(|b| b.is_ascii_digit());
    let dof = dof(direction).filter(|_| direction.len() == 1)?;
    is_number.then(|| Label { node: node.to_string(), dof: Some(dof) })
}

impl MatrixReader for DofLines {
    fn name(&self) -> &'static str {
        "calculix-dofs"
    }

    fn summary(&self) -> &'static str {
        "Table of dofs of CalculiX (.dof): a line `node.direction` for each row of its .sti and .mas."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let lines = file.first_lines();
        !lines.is_empty() && lines.iter().take(4).all(|l| numbered(l).is_some())
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let mut contents = Contents::default();
        while let Some(line) = lines.next() {
            if line.trim().is_empty() {
                continue;
            }
            let Some(label) = numbered(line) else {
                return Err(MatrixError::line(DOFS, lines.number, line, "`node.direction` with a direction of 1 to 6"));
            };
            contents.dofs.push(DofRow { label, position: None, frame: None });
        }
        Ok(contents)
    }
}
