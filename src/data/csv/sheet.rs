//! A table of text cells.

use super::CsvError;
use crate::catalogue::did_you_mean;
use std::borrow::Cow;

/// A row and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row<'a> {
    /// Line of the file.
    pub line: usize,
    /// Cells, without quotes and blanks around them.
    pub cells: Vec<Cow<'a, str>>,
}

/// A table with a header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sheet<'a> {
    /// What separates cells.
    pub delimiter: char,
    /// Names of the columns.
    pub names: Vec<Cow<'a, str>>,
    /// Rows below the header, all of the header's length.
    pub rows: Vec<Row<'a>>,
}

impl<'a> Sheet<'a> {
    /// Reads a table.
    ///
    /// # Errors
    /// [`CsvError::Empty`], [`CsvError::NotUtf8`], [`CsvError::Ragged`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, CsvError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].split(|b| *b == b'\n').count();
            CsvError::NotUtf8 { line }
        })?;
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line))
            .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let (_, header) = lines.next().ok_or(CsvError::Empty)?;
        let count = |c: char| header.matches(c).count();
        // The first of several with the same count.
        let delimiter = [',', ';', '\t'].into_iter().rev().max_by_key(|c| count(*c)).unwrap_or(',');
        let names = cells(header, delimiter);
        let mut rows = Vec::new();
        for (line, text) in lines {
            let mut cells = cells(text, delimiter);
            // A delimiter at the end of a row adds no cell.
            if cells.len() == names.len() + 1 && cells.last().is_some_and(|c| c.is_empty()) {
                cells.pop();
            }
            if cells.len() != names.len() {
                return Err(CsvError::Ragged { line, found: cells.len(), expected: names.len() });
            }
            rows.push(Row { line, cells });
        }
        Ok(Self { delimiter, names, rows })
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Result<usize, CsvError> {
        self.names.iter().position(|n| n == name).ok_or_else(|| CsvError::NoColumn {
            name: name.to_owned(),
            hint: did_you_mean(name, self.names.iter().map(AsRef::as_ref)),
            present: self.names.join(", "),
        })
    }

    /// A cell as a number.
    pub fn number(&self, row: &Row<'_>, column: usize) -> Result<f64, CsvError> {
        self.parse(&row.cells[column]).ok_or_else(|| CsvError::Cell {
            line: row.line,
            column: column + 1,
            name: self.names[column].to_string(),
            text: row.cells[column].to_string(),
            expected: "a number",
        })
    }

    /// A cell as an integer, also when written as `3.0`.
    pub fn integer(&self, row: &Row<'_>, column: usize) -> Result<i64, CsvError> {
        let value = self.number(row, column)?;
        // Integers up to 2^53 are exact.
        if value.fract() == 0.0 && value.abs() < 9.0e15 {
            return Ok(value as i64);
        }
        Err(CsvError::Cell {
            line: row.line,
            column: column + 1,
            name: self.names[column].to_string(),
            text: row.cells[column].to_string(),
            expected: "an integer",
        })
    }

    /// A number, with a decimal comma where the comma separates nothing.
    pub(super) fn parse(&self, text: &str) -> Option<f64> {
        text.parse().ok().or_else(|| {
            let is_decimal = self.delimiter != ',' && text.matches(',').count() == 1 && !text.contains('.');
            if is_decimal { text.replace(',', ".").parse().ok() } else { None }
        })
    }
}

fn cells(line: &str, delimiter: char) -> Vec<Cow<'_, str>> {
    if !line.contains('"') {
        return line.split(delimiter).map(|c| Cow::Borrowed(c.trim())).collect();
    }
    let mut found = Vec::new();
    let mut cell = String::new();
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                cell.push('"');
            }
            '"' => quoted = !quoted,
            c if c == delimiter && !quoted => found.push(Cow::Owned(std::mem::take(&mut cell).trim().to_owned())),
            c => cell.push(c),
        }
    }
    found.push(Cow::Owned(cell.trim().to_owned()));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delimiters_quotes_and_decimal_commas_are_understood() {
        let sheet = Sheet::read("\u{feff}a;\"b;c\";d\n# comment\n1,5;\"2\";-3e2;\n".as_bytes()).unwrap();
        assert_eq!((sheet.delimiter, sheet.names.len(), sheet.names[1].as_ref()), (';', 3, "b;c"));
        let row = &sheet.rows[0];
        let values: Vec<f64> = (0..3).map(|i| sheet.number(row, i).unwrap()).collect();
        assert_eq!((row.line, values), (3, vec![1.5, 2.0, -300.0]));
    }

    #[test]
    fn errors_name_line_and_column() {
        let sheet = Sheet::read(b"frq,amp\n1,2\n3,x\n").unwrap();
        let error = sheet.number(&sheet.rows[1], 1).unwrap_err();
        assert_eq!(error.to_string(), "line 3, column 2 (`amp`): `x` where a number should stand");
        assert_eq!(
            sheet.column("freq").unwrap_err().to_string(),
            "no column `freq`; did you mean `frq`?; there are: frq, amp"
        );
        assert_eq!(Sheet::read(b"a,b\n1\n").unwrap_err().to_string(), "line 2: 1 cells, the first line has 2");
        assert_eq!(Sheet::read(b"a,b\n1,\xff\n").unwrap_err(), CsvError::NotUtf8 { line: 2 });
        assert_eq!(Sheet::read(b"\n \n").unwrap_err(), CsvError::Empty);
    }
}
