//! Matrix Market files (`.mtx`): the exchange format of sparse matrices.
//!
//! ```text
//! %%MatrixMarket matrix coordinate real symmetric
//! % a comment
//! 3 3 4
//! 1 1 2.0
//! ```
//!
//! Source: R. F. Boisvert, R. Pozo, K. A. Remington, The Matrix Market Exchange Formats: Initial Design, NISTIR 5935, 1996.

use super::text::{Lines, number};
use super::{Contents, File, Matrix, MatrixError, MatrixReader};
use std::fmt::Write as _;

/// Matrix Market.
#[derive(Debug, Clone, Copy)]
pub struct MatrixMarket;

const FORMAT: &str = "Matrix Market";

impl MatrixReader for MatrixMarket {
    fn name(&self) -> &'static str {
        "matrix-market"
    }

    fn summary(&self) -> &'static str {
        "Matrix Market (.mtx): coordinate or array, real or integer, general, symmetric or skew-symmetric; scipy.io.mmwrite."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        file.bytes.get(..14).is_some_and(|b| b.eq_ignore_ascii_case(b"%%MatrixMarket"))
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let banner = lines.next().unwrap_or_default().to_lowercase();
        let words: Vec<&str> = banner.split_whitespace().collect();
        let wrong = |text: &str| {
            MatrixError::line(
                FORMAT,
                1,
                text,
                "`%%MatrixMarket matrix coordinate|array real|integer general|symmetric|skew-symmetric`",
            )
        };
        let [_, "matrix", layout @ ("coordinate" | "array"), field, symmetry] = words[..] else {
            return Err(wrong(&banner));
        };
        if field == "complex" || symmetry == "hermitian" {
            return Err(MatrixError::broken(
                FORMAT,
                "its numbers are complex, and matrices of a model are real: export K and M without structural damping",
            ));
        }
        if !matches!(field, "real" | "integer" | "double") {
            return Err(wrong(&banner));
        }
        let mirror = match symmetry {
            "general" => None,
            "symmetric" => Some(1.0),
            "skew-symmetric" => Some(-1.0),
            _ => return Err(wrong(&banner)),
        };
        let size = loop {
            let Some(line) = lines.next() else {
                return Err(MatrixError::broken(FORMAT, "it ends before the line with its size"));
            };
            if !line.trim_start().starts_with('%') && !line.trim().is_empty() {
                break line;
            }
        };
        let counts: Option<Vec<usize>> = size.split_whitespace().map(|w| w.parse().ok()).collect();
        let is_coordinate = layout == "coordinate";
        let counts = counts.filter(|c| c.len() == if is_coordinate { 3 } else { 2 });
        let counts = counts.filter(|c| c[..2].iter().all(|n| u32::try_from(*n).is_ok()));
        let Some(counts) = counts else {
            let expected = if is_coordinate { "`rows columns entries`" } else { "`rows columns`" };
            return Err(MatrixError::line(FORMAT, lines.number, size, expected));
        };
        let mut matrix = Matrix {
            name: file.stem().to_string(),
            n_rows: counts[0],
            n_columns: counts[1],
            is_one_triangle: mirror == Some(1.0),
            ..Matrix::default()
        };
        if mirror.is_some() && counts[0] != counts[1] {
            return Err(MatrixError::broken(
                FORMAT,
                format_args!("it is {symmetry} and has {} rows and {} columns", counts[0], counts[1]),
            ));
        }
        if is_coordinate {
            coordinate(&mut matrix, &mut lines, counts[2], mirror)?;
        } else {
            array(&mut matrix, &mut lines, mirror)?;
        }
        Ok(Contents::of(matrix))
    }
}

fn coordinate(
    matrix: &mut Matrix,
    lines: &mut Lines<'_>,
    count: usize,
    mirror: Option<f64>,
) -> Result<(), MatrixError> {
    // The shortest line is `1 1 0`.
    matrix.entries.reserve(count.min(lines.rest().len() / 6 + 1));
    while let Some(line) = lines.next() {
        let mut words = line.split_whitespace();
        let Some(first) = words.next() else { continue };
        let place = |w: Option<&str>| w.and_then(|w| w.parse::<usize>().ok()).and_then(|i| i.checked_sub(1));
        let read = (|| {
            let (row, column) = (place(Some(first))?, place(words.next())?);
            let value = number(words.next()?)?;
            matrix.push(row, column, value)?;
            if mirror == Some(-1.0) && row != column {
                matrix.push(column, row, -value)?;
            }
            words.next().is_none().then_some(())
        })();
        if read.is_none() {
            return Err(MatrixError::line(
                FORMAT,
                lines.number,
                line,
                "`row column value`, within the size of the matrix,",
            ));
        }
    }
    let own = if mirror == Some(-1.0) { matrix.entries.len().div_ceil(2) } else { matrix.entries.len() };
    if own != count {
        return Err(MatrixError::broken(FORMAT, format_args!("it has {own} entries and announces {count}")));
    }
    Ok(())
}

fn array(matrix: &mut Matrix, lines: &mut Lines<'_>, mirror: Option<f64>) -> Result<(), MatrixError> {
    let (mut row, mut column) = (usize::from(mirror == Some(-1.0)), 0);
    while let Some(line) = lines.next() {
        for word in line.split_whitespace() {
            let read = number(word).filter(|_| column < matrix.n_columns).and_then(|value| {
                if value != 0.0 {
                    matrix.push(row, column, value)?;
                    if mirror == Some(-1.0) {
                        matrix.push(column, row, -value)?;
                    }
                }
                Some(())
            });
            if read.is_none() {
                return Err(MatrixError::line(
                    FORMAT,
                    lines.number,
                    word,
                    "one of as many numbers as the size asks for",
                ));
            }
            row += 1;
            if row >= matrix.n_rows {
                column += 1;
                row = match mirror {
                    None => 0,
                    Some(sign) => column + usize::from(sign < 0.0),
                };
                if row >= matrix.n_rows && column < matrix.n_columns {
                    column = matrix.n_columns;
                }
            }
        }
    }
    if column < matrix.n_columns && matrix.n_rows > 0 {
        return Err(MatrixError::broken(
            FORMAT,
            format_args!("its numbers end in column {}, and it has {}", column + 1, matrix.n_columns),
        ));
    }
    Ok(())
}

/// Writes a matrix: coordinate, real, symmetric where it is one triangle, else general. Every number reads back to the same bits.
pub(super) fn write(matrix: &Matrix, comment: &str) -> Vec<u8> {
    let symmetry = if matrix.is_one_triangle { "symmetric" } else { "general" };
    let mut out = format!("%%MatrixMarket matrix coordinate real {symmetry}\n");
    for line in comment.lines() {
        let _ = writeln!(out, "% {line}");
    }
    let _ = writeln!(out, "{} {} {}", matrix.n_rows, matrix.n_columns, matrix.entries.len());
    for e in &matrix.entries {
        let (row, column) =
            if matrix.is_one_triangle { (e.row.max(e.column), e.row.min(e.column)) } else { (e.row, e.column) };
        let _ = writeln!(out, "{} {} {:e}", row + 1, column + 1, e.value);
    }
    out.into_bytes()
}
