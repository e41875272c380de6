//! OUTPUT4 as text.

use super::super::text::{Lines, columns, number};
use super::{Contents, FORMAT, Growing, Head, MatrixError};

/// The head of a matrix: `4I8,A8,...`, or `4I16,A8,...` of versions with long integers.
pub(super) fn head(line: &str) -> Option<Head> {
    if !line.is_ascii() {
        return None;
    }
    [8, 16].into_iter().find_map(|wide| {
        let field = |i: usize| columns(line, i * wide, (i + 1) * wide).trim().parse::<i64>().ok();
        let (n_columns, rows, _form, kind) = (field(0)?, field(1)?, field(2)?, field(3)?);
        let rest = columns(line, 4 * wide, line.len());
        let name = columns(rest, 0, 8).trim();
        let format = columns(rest, 8, rest.len());
        // 23 of `1P,3E23.16`.
        let letter = format.rfind(['E', 'D', 'e', 'd'])?;
        let digits: String = format[letter + 1..].chars().take_while(char::is_ascii_digit).collect();
        let width: usize = digits.parse().ok().filter(|w| (4..60).contains(w))?;
        Head::new(n_columns, rows, kind, name, width)
    })
}

fn integers(line: &str) -> Option<Vec<i64>> {
    let by_words: Option<Vec<i64>> = line.split_whitespace().map(|w| w.parse().ok()).collect();
    // Numbers of eight digits touch each other.
    let by_columns = || -> Option<Vec<i64>> {
        (0..line.len().div_ceil(8)).map(|k| columns(line, 8 * k, 8 * (k + 1)).trim().parse().ok()).collect()
    };
    let wide = line.split_whitespace().any(|w| w.len() > 8 && line.len() <= 24);
    if wide { by_columns() } else { by_words }
}

pub(super) fn read(bytes: &[u8], contents: &mut Contents) -> Result<(), MatrixError> {
    let mut lines = Lines::new(bytes);
    while let Some(line) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        let Some(head) = head(line) else {
            return Err(MatrixError::line(
                FORMAT,
                lines.number,
                line,
                "the head of a matrix: columns, rows, form, type, name, format",
            ));
        };
        let mut growing = Growing::new(&head);
        loop {
            let Some(line) = lines.next() else {
                return Err(MatrixError::broken(FORMAT, format_args!("it ends within the matrix `{}`", head.name)));
            };
            let wrong =
                |lines: &Lines<'_>, text: &str| MatrixError::line(FORMAT, lines.number, text, "`column row words`");
            let column = integers(line).filter(|c| c.len() == 3).ok_or_else(|| wrong(&lines, line))?;
            let (Ok(place), Ok(row), Ok(words)) =
                (usize::try_from(column[0] - 1), usize::try_from(column[1]), usize::try_from(column[2]))
            else {
                return Err(wrong(&lines, line));
            };
            if place >= head.n_columns {
                // One number that means nothing ends the matrix.
                lines.next();
                break;
            }
            if row > 0 {
                values(&mut lines, &head, &mut growing, place, row - 1, words)?;
                continue;
            }
            strings(&mut lines, &head, &mut growing, place, words)?;
        }
        growing.finish(contents);
    }
    Ok(())
}

/// The strings of a sparse column.
fn strings(
    lines: &mut Lines<'_>,
    head: &Head,
    growing: &mut Growing,
    column: usize,
    mut words: usize,
) -> Result<(), MatrixError> {
    let per_number = if head.kind.is_double { 2 } else { 1 };
    while words > 0 {
        let line = lines.next().unwrap_or_default();
        let wrong = || MatrixError::line(FORMAT, lines.number, line, "the head of a string of a sparse column");
        let found = integers(line).ok_or_else(wrong)?;
        let (length, row, own) = match (head.is_big, found.as_slice()) {
            (true, &[length, row]) => (length - 1, row, 2),
            (false, &[both]) => (both / 65_536 - 1, both % 65_536, 1),
            _ => return Err(wrong()),
        };
        let length = usize::try_from(length).map_err(|_| wrong())?;
        let row = usize::try_from(row - 1).map_err(|_| wrong())?;
        words = words.checked_sub(own + length).ok_or_else(wrong)?;
        values(lines, head, growing, column, row, length / per_number)?;
    }
    Ok(())
}

/// So many numbers from a row on.
fn values(
    lines: &mut Lines<'_>,
    head: &Head,
    growing: &mut Growing,
    column: usize,
    row: usize,
    count: usize,
) -> Result<(), MatrixError> {
    let mut k = 0;
    while k < count {
        let Some(line) = lines.next() else {
            return Err(MatrixError::broken(FORMAT, format_args!("it ends within the matrix `{}`", head.name)));
        };
        let line = line.trim_end();
        let on_line = line.len().div_ceil(head.width).min(count - k);
        for i in 0..on_line {
            let word = columns(line, i * head.width, (i + 1) * head.width);
            let put = number(word).and_then(|v| growing.put(column, row, k, v));
            put.ok_or_else(|| {
                MatrixError::line(FORMAT, lines.number, word, "a number within the matrix, in the format of its head,")
            })?;
            k += 1;
        }
        if on_line == 0 {
            return Err(MatrixError::line(FORMAT, lines.number, line, "numbers of the matrix"));
        }
    }
    Ok(())
}
