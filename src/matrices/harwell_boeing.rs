//! Harwell-Boeing files (`.rsa`, `.rua`, `.hb`; of Ansys by `HBMAT`) and those of Rutherford and Boeing (`.rb`), assembled and real.
//!
//! Four lines of head - title and key; numbers of lines; type and size; Fortran formats - then pointers to columns, rows, values, by columns.
//! Right-hand sides are left out.
//!
//! Source: I. S. Duff, R. G. Grimes, J. G. Lewis, Users' Guide for the Harwell-Boeing Sparse Matrix Collection (Release I), 1992;
//! The Rutherford-Boeing Sparse Matrix Collection, RAL-TR-97-031, 1997.

use super::text::{Lines, columns, number};
use super::{Contents, File, Matrix, MatrixError, MatrixReader};

/// Harwell-Boeing.
#[derive(Debug, Clone, Copy)]
pub struct HarwellBoeing;

const FORMAT: &str = "Harwell-Boeing";

/// The third line: type, rows, columns, entries.
fn kind(line: &str) -> Option<(String, [usize; 3])> {
    let mut words = line.split_whitespace();
    let kind = words.next()?.to_lowercase();
    let sizes: Vec<usize> = words.take(3).map(|w| w.parse().ok()).collect::<Option<_>>()?;
    let letters = kind.as_bytes();
    let is_known = kind.len() == 3
        && b"rcpiq".contains(&letters[0])
        && b"suzhr".contains(&letters[1])
        && b"ae".contains(&letters[2]);
    let sizes: [usize; 3] = sizes.try_into().ok()?;
    (is_known && sizes[..2].iter().all(|n| u32::try_from(*n).is_ok())).then_some((kind, sizes))
}

impl MatrixReader for HarwellBoeing {
    fn name(&self) -> &'static str {
        "harwell-boeing"
    }

    fn summary(&self) -> &'static str {
        "Harwell-Boeing and Rutherford-Boeing (.rsa, .rua, .hb, .rb), assembled and real; HBMAT of Ansys, with the table of dofs in its .mapping."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        file.head().lines().nth(2).is_some_and(|line| kind(line).is_some())
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let mut head = |expected| {
            let line = lines.next().unwrap_or_default();
            (!line.trim().is_empty())
                .then_some(line)
                .ok_or_else(|| MatrixError::line(FORMAT, lines.number, line, expected))
        };
        head("a title")?;
        let counts = head("the numbers of lines")?;
        let typed = head("the type and the size")?;
        let formats = head("the Fortran formats")?;
        let line_counts: Vec<usize> = counts.split_whitespace().map_while(|w| w.parse().ok()).collect();
        let Some(&[_, n_pointer, n_index, n_value]) = line_counts.get(..4) else {
            return Err(MatrixError::line(FORMAT, 2, counts, "four numbers of lines"));
        };
        let Some((kind, [n_rows, n_columns, n_entries])) = kind(typed) else {
            return Err(MatrixError::line(FORMAT, 3, typed, "`RSA rows columns entries`"));
        };
        match kind.as_bytes() {
            [b'r' | b'i', _, b'a'] => {}
            [b'c', ..] => {
                return Err(MatrixError::broken(FORMAT, "its numbers are complex, and matrices of a model are real"));
            }
            [b'p' | b'q', ..] => return Err(MatrixError::broken(FORMAT, "it holds a pattern without numbers")),
            _ => return Err(MatrixError::broken(FORMAT, "it holds element matrices that are not assembled")),
        }
        let widths: Vec<usize> = formats.split('(').skip(1).filter_map(|f| width(f.split(')').next()?)).collect();
        let &[pointer, index, value, ..] = widths.as_slice() else {
            return Err(MatrixError::line(
                FORMAT,
                4,
                formats,
                "three Fortran formats such as `(10I8) (10I8) (4E20.12)`",
            ));
        };
        // A fifth number of the second line announces right-hand sides, and a line about them.
        if line_counts.get(4).is_some_and(|n| *n > 0) && kind.as_bytes()[0] == b'r' && has_line_of_sides(&lines) {
            lines.next();
        }
        let pointers = whole_numbers(&mut lines, pointer, n_pointer, n_columns.saturating_add(1))?;
        let indices = whole_numbers(&mut lines, index, n_index, n_entries)?;
        let mut values = Vec::new();
        fields(&mut lines, value, n_value, n_entries, |word| number(word).map(|v| values.push(v)))?;
        let mut matrix = Matrix {
            name: file.stem().to_string(),
            n_rows,
            n_columns,
            is_one_triangle: kind.as_bytes()[1] == b's',
            ..Matrix::default()
        };
        if kind.as_bytes()[1] == b's' && n_rows != n_columns {
            return Err(MatrixError::broken(FORMAT, "it is symmetric and not square"));
        }
        for (column, ends) in pointers.windows(2).enumerate() {
            let range = ends[0].checked_sub(1).zip(ends[1].checked_sub(1));
            let Some((from, to)) = range.filter(|(a, b)| a <= b && *b <= indices.len()) else {
                return Err(MatrixError::broken(
                    FORMAT,
                    format_args!("the pointers of column {} lie outside its entries", column + 1),
                ));
            };
            for k in from..to {
                let pushed = indices[k].checked_sub(1).and_then(|row| {
                    matrix.push(row, column, values[k])?;
                    if kind.as_bytes()[1] == b'z' && row != column {
                        matrix.push(column, row, -values[k])?;
                    }
                    Some(())
                });
                pushed.ok_or_else(|| {
                    MatrixError::broken(FORMAT, format_args!("column {} has an entry outside the matrix", column + 1))
                })?;
            }
        }
        Ok(Contents::of(matrix))
    }
}

/// Whether the next line is the head of right-hand sides: it begins with `F` or `M`.
fn has_line_of_sides(lines: &Lines<'_>) -> bool {
    lines.rest().first().is_some_and(|b| matches!(b, b'F' | b'M' | b'f' | b'm'))
}

/// The width of a field of a Fortran format: 8 of `10I8`, 20 of `1P,4E20.12`, 26 of `3D26.18`; 0 where numbers are separated by blanks.
fn width(format: &str) -> Option<usize> {
    let last = format.rsplit(',').next()?.trim();
    let letter = last.find(|c: char| "IEDFGiedfg".contains(c))?;
    let digits: String = last[letter + 1..].chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok().filter(|w| *w < 100)
}

/// Reads so many fields of one width from so many lines.
fn fields(
    lines: &mut Lines<'_>,
    width: usize,
    n_lines: usize,
    count: usize,
    mut take: impl FnMut(&str) -> Option<()>,
) -> Result<(), MatrixError> {
    let mut found = 0;
    for _ in 0..n_lines {
        let Some(line) = lines.next() else { break };
        let mut take = |word: &str| {
            if found < count && !word.trim().is_empty() {
                found += 1;
                take(word).ok_or_else(|| {
                    MatrixError::line(FORMAT, lines.number, word, "a number of the format of the head")
                })?;
            }
            Ok(())
        };
        if width == 0 {
            line.split_whitespace().try_for_each(&mut take)?;
        } else {
            (0..line.len().div_ceil(width)).try_for_each(|k| take(columns(line, k * width, (k + 1) * width)))?;
        }
    }
    if found < count {
        return Err(MatrixError::broken(
            FORMAT,
            format_args!("{found} numbers stand where the head announces {count}"),
        ));
    }
    Ok(())
}

fn whole_numbers(lines: &mut Lines<'_>, width: usize, n_lines: usize, count: usize) -> Result<Vec<usize>, MatrixError> {
    let mut all = Vec::new();
    fields(lines, width, n_lines, count, |word| word.trim().parse().ok().map(|v| all.push(v)))?;
    Ok(all)
}
