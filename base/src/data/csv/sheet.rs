//! A table of text cells.

use super::CsvError;
use crate::catalogue::did_you_mean;
use crate::units::ascii_numbers;
use std::borrow::Cow;

/// The text of a table: UTF-8 with or without a byte order mark, or UTF-16 with one.
///
/// # Errors
/// [`CsvError::Encoding`] with the encoding that it seems to be.
pub fn text_of(bytes: &[u8]) -> Result<Cow<'_, str>, CsvError> {
    let wide = match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => {
            return Err(CsvError::Encoding { line: 1, found: "UTF-32".to_owned() });
        }
        [0xff, 0xfe, rest @ ..] => Some((rest, u16::from_le_bytes as fn([u8; 2]) -> u16)),
        [0xfe, 0xff, rest @ ..] => Some((rest, u16::from_be_bytes as fn([u8; 2]) -> u16)),
        _ => None,
    };
    if let Some((rest, unit)) = wide {
        let units = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let mut text = String::with_capacity(rest.len() / 2);
        for c in char::decode_utf16(units) {
            let Ok(c) = c else {
                let line = text.matches('\n').count() + 1;
                return Err(CsvError::Encoding { line, found: "broken UTF-16".to_owned() });
            };
            text.push(c);
        }
        return Ok(Cow::Owned(text));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if let Some(found) = wide_without_mark(bytes) {
        return Err(CsvError::Encoding { line: 1, found: found.to_owned() });
    }
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let at = e.valid_up_to();
        let line = bytes[..at].split(|b| *b == b'\n').count();
        // Of the encodings of one byte a letter, Windows writes this one; 0x80 to 0x9f are letters in it and nowhere else.
        let byte = bytes[at];
        let letter = if byte >= 0xa0 { format!(", where it is `{}`", char::from(byte)) } else { String::new() };
        CsvError::Encoding { line, found: format!("Windows-1252 or Latin-1 (byte 0x{byte:02X}{letter})") }
    })?;
    Ok(Cow::Borrowed(text))
}

/// UTF-16 without a byte order mark: every other byte of the first ones is 0.
pub(in crate::data) fn wide_without_mark(bytes: &[u8]) -> Option<&'static str> {
    const LOOK: usize = 64;
    let head = &bytes[..bytes.len().min(LOOK) & !1];
    let zeros = |phase: usize| head.iter().skip(phase).step_by(2).filter(|b| **b == 0).count();
    let (even, odd) = (zeros(0), zeros(1));
    let most = head.len() / 2;
    if most >= 2 && odd * 10 >= most * 9 && even == 0 {
        Some("UTF-16 (little endian) without a byte order mark")
    } else if most >= 2 && even * 10 >= most * 9 && odd == 0 {
        Some("UTF-16 (big endian) without a byte order mark")
    } else {
        None
    }
}

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
    /// Whether numbers are written with a decimal comma; `None` where no number has a decimal mark, or it may be one of thousands.
    pub decimal_comma: Option<bool>,
    /// Names of the columns.
    pub names: Vec<Cow<'a, str>>,
    /// Rows below the header, all of the header's length.
    pub rows: Vec<Row<'a>>,
}

impl<'a> Sheet<'a> {
    /// Reads a table: a header, and rows of its length. A line `sep=;` before the header, as spreadsheets write it, states the delimiter;
    /// columns without name and content at the end are none.
    ///
    /// # Errors
    /// [`CsvError::Empty`], [`CsvError::Encoding`], [`CsvError::Ragged`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, CsvError> {
        match text_of(bytes)? {
            Cow::Borrowed(text) => Self::of(text),
            Cow::Owned(text) => Sheet::of(&text).map(Sheet::into_owned),
        }
    }

    fn of(text: &'a str) -> Result<Self, CsvError> {
        let Some((delimiter, header, lines)) = header(text) else { return Err(CsvError::Empty) };
        let mut names = cells(header, delimiter);
        let is_blank = |cells: &[Cow<'_, str>]| cells.last().is_some_and(|c| c.is_empty());
        while names.len() > 1 && is_blank(&names) {
            names.pop();
        }
        let mut rows = Vec::new();
        for (line, text) in lines {
            let mut cells = cells(text, delimiter);
            while cells.len() > names.len() && is_blank(&cells) {
                cells.pop();
            }
            if cells.len() != names.len() {
                return Err(CsvError::Ragged { line, found: cells.len(), expected: names.len() });
            }
            rows.push(Row { line, cells });
        }
        let decimal_comma = decimal_comma(names.len(), &rows, delimiter);
        Ok(Self { delimiter, decimal_comma, names, rows })
    }

    fn into_owned(self) -> Sheet<'static> {
        let own = |list: Vec<Cow<'_, str>>| list.into_iter().map(|c| Cow::Owned(c.into_owned())).collect();
        Sheet {
            delimiter: self.delimiter,
            decimal_comma: self.decimal_comma,
            names: own(self.names),
            rows: self.rows.into_iter().map(|r| Row { line: r.line, cells: own(r.cells) }).collect(),
        }
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

    /// A cell as a finite number.
    pub(super) fn finite(&self, row: &Row<'_>, column: usize) -> Result<f64, CsvError> {
        let value = self.number(row, column)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(CsvError::Cell {
            line: row.line,
            column: column + 1,
            name: self.names[column].to_string(),
            text: row.cells[column].to_string(),
            expected: "a finite number",
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

    /// A number, with the decimal mark of the table.
    pub(super) fn parse(&self, text: &str) -> Option<f64> {
        decimal(text, self.decimal_comma)
    }
}

/// A number with a point or, where the table has decimal commas or nothing says otherwise, with a comma; `None` where the mark may be one
/// of thousands.
pub(super) fn decimal(text: &str, comma: Option<bool>) -> Option<f64> {
    let text = &*ascii_numbers(text);
    if text.contains(',') {
        let is_decimal = comma == Some(true) && text.matches(',').count() == 1 && !text.contains('.');
        return if is_decimal { text.replace(',', ".").parse().ok() } else { None };
    }
    if comma == Some(true) && is_of_thousands(text, '.') {
        return None;
    }
    text.parse().ok()
}

/// Whether a mark may separate thousands: one to three digits, not 0, the mark, three digits.
pub(super) fn is_of_thousands(text: &str, mark: char) -> bool {
    let text = text.trim_start_matches(['+', '-']);
    let is_digits = |t: &str| t.bytes().all(|b| b.is_ascii_digit());
    text.split_once(mark).is_some_and(|(whole, part)| {
        (1..=3).contains(&whole.len())
            && is_digits(whole)
            && !whole.starts_with('0')
            && part.len() == 3
            && is_digits(part)
    })
}

/// The decimal mark of a table, from columns with numbers in them.
///
/// A column with commas and no points says comma. A column with both has separators of thousands, whose commas are not decimal marks. With
/// commas as delimiters only quoted cells can have them; where all of these may be thousands, `"1,200"`, nothing is said.
fn decimal_comma(width: usize, rows: &[Row<'_>], delimiter: char) -> Option<bool> {
    let mut commas = vec![0_usize; width];
    let mut points = vec![0_usize; width];
    let mut is_certain = delimiter != ',';
    for row in rows {
        for (column, cell) in row.cells.iter().enumerate() {
            let cell = ascii_numbers(cell);
            let marks = cell.bytes().filter(|b| matches!(b, b',' | b'.')).count();
            let is_number = marks > 0
                && cell.bytes().all(|b| b.is_ascii_digit() || matches!(b, b',' | b'.' | b'-' | b'+' | b'e' | b'E'));
            if !is_number {
                continue;
            }
            let has_comma = cell.contains(',');
            commas[column] += usize::from(has_comma);
            points[column] += usize::from(cell.contains('.'));
            is_certain |= has_comma && marks == 1 && !is_of_thousands(&cell, ',');
        }
    }
    let is_mixed = commas.iter().zip(&points).any(|(c, p)| *c > 0 && *p > 0);
    if is_mixed {
        Some(false)
    } else if commas.iter().any(|c| *c > 0) {
        is_certain.then_some(true)
    } else if points.iter().any(|p| *p > 0) {
        Some(false)
    } else {
        None
    }
}

/// The delimiter of a table, its header, and its rows with their lines.
fn header(text: &str) -> Option<(char, &str, impl Iterator<Item = (usize, &str)>)> {
    const DELIMITERS: [char; 3] = [',', ';', '\t'];
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line))
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (_, mut header) = lines.next()?;
    let stated = header.trim().trim_matches('"').strip_prefix("sep=").and_then(|d| d.chars().next());
    let is_sep = header.trim().trim_matches('"').starts_with("sep=");
    if is_sep {
        header = lines.next()?.1;
    }
    let mut ahead = lines.clone();
    let first = ahead.next().map(|(_, row)| row);
    // The delimiter cuts the header and the first row alike; it is not a decimal comma, where both do.
    let filled = |line: &str, d: char| cells(line, d).iter().rposition(|c| !c.is_empty()).map_or(0, |last| last + 1);
    let fitness = |d: &char| {
        let count = filled(header, *d);
        (count > 1 && first.is_some_and(|row| filled(row, *d) == count), count)
    };
    let delimiter = stated.filter(|d| DELIMITERS.contains(d));
    let delimiter = delimiter.unwrap_or_else(|| DELIMITERS.into_iter().max_by_key(fitness).unwrap_or(','));
    Some((delimiter, header, lines))
}

/// The names of the columns of what may be a table, however it is encoded; none where it is not text.
pub(in crate::data) fn names_of(bytes: &[u8]) -> Vec<String> {
    /// No header is longer.
    const LONGEST: usize = 1 << 22;
    let bytes = &bytes[..bytes.len().min(LONGEST)];
    let text = text_of(bytes).unwrap_or_else(|_| String::from_utf8_lossy(bytes));
    header(&text).map_or_else(Vec::new, |(delimiter, header, _)| {
        cells(header, delimiter).into_iter().map(Cow::into_owned).collect()
    })
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
        let sheet = Sheet::read("\u{feff}sep=;\na;\"b;c\";d\n# comment\n1,5;\"2\";-3e2;\n".as_bytes()).unwrap();
        assert_eq!((sheet.delimiter, sheet.names.len(), sheet.names[1].as_ref()), (';', 3, "b;c"));
        let row = &sheet.rows[0];
        let values: Vec<f64> = (0..3).map(|i| sheet.number(row, i).unwrap()).collect();
        assert_eq!((row.line, values), (4, vec![1.5, 2.0, -300.0]));
    }

    #[test]
    fn the_delimiter_is_not_the_decimal_comma() {
        let two = Sheet::read(b"point;bending 7,9 Hz\n1;0,5\n").unwrap();
        assert_eq!((two.delimiter, two.names.len(), two.decimal_comma), (';', 2, Some(true)));
        let quoted = Sheet::read(b"a,b\n\"0,5\",\"12,25\"\n").unwrap();
        assert_eq!((quoted.delimiter, quoted.number(&quoted.rows[0], 1).unwrap()), (',', 12.25));
        let other = Sheet::read(b"a,b;c\n1.5,2\n").unwrap();
        assert_eq!((other.delimiter, other.decimal_comma), (',', Some(false)));
    }

    #[test]
    fn numbers_in_other_characters_have_their_value() {
        let sheet = Sheet::read("a;b\n−1,5;５\n2,25;7\n".as_bytes()).unwrap();
        let values: Vec<f64> = (0..2).map(|c| sheet.number(&sheet.rows[0], c).unwrap()).collect();
        assert_eq!(values, [-1.5, 5.0]);
    }

    #[test]
    fn separators_of_thousands_are_no_decimal_marks() {
        for text in ["a,b\n\"1,200\",\"12,500\"\n", "a;b\n1,200.5;1\n1,5;2\n", "a;b\n1,5;2\n1.250;3\n"] {
            let sheet = Sheet::read(text.as_bytes()).unwrap();
            let worst = sheet.rows.iter().find_map(|row| sheet.number(row, 0).err());
            assert!(worst.is_some(), "{text}");
        }
        // Three decimals are decimals where the delimiter is none.
        let sheet = Sheet::read(b"a;b\n1,200;0,5\n").unwrap();
        assert_eq!(sheet.number(&sheet.rows[0], 0).unwrap(), 1.2);
        // A name is not a number.
        let sheet = Sheet::read(b"point;x\n1.1;0,5\n1.2;0,7\n").unwrap();
        assert_eq!(sheet.number(&sheet.rows[1], 1).unwrap(), 0.7);
    }

    #[test]
    fn columns_without_name_and_content_at_the_end_are_none() {
        let sheet = Sheet::read(b"a,b,,\n1,2,,\n3,4\n5,6,\n").unwrap();
        assert_eq!((sheet.names.len(), sheet.rows.len()), (2, 3));
        assert!(matches!(Sheet::read(b"a,b,\n1,2,3\n"), Err(CsvError::Ragged { line: 2, .. })));
    }

    #[test]
    fn wide_text_is_read_with_its_mark_and_named_without_it() {
        let text = "point;x\n1;0,5\n";
        let wide = |big: bool| -> Vec<u8> {
            text.encode_utf16().flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() }).collect()
        };
        for (mark, big) in [([0xff, 0xfe], false), ([0xfe, 0xff], true)] {
            let marked = [mark.to_vec(), wide(big)].concat();
            let sheet = Sheet::read(&marked).unwrap();
            assert_eq!(sheet.number(&sheet.rows[0], 1).unwrap(), 0.5);
            assert_eq!(names_of(&marked), ["point", "x"]);
            let error = Sheet::read(&wide(big)).unwrap_err().to_string();
            assert!(error.contains("UTF-16"), "{error}");
        }
        let broken = [0xff, 0xfe, 0x61, 0x00, 0x00, 0xd8];
        assert!(Sheet::read(&broken).unwrap_err().to_string().contains("broken UTF-16"));
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
        let error = Sheet::read(b"a,b\n1,\xe4\n").unwrap_err().to_string();
        assert_eq!(
            error,
            "line 2: the table is not UTF-8 but Windows-1252 or Latin-1 (byte 0xE4, where it is `ä`); save it as UTF-8"
        );
        assert_eq!(Sheet::read(b"\n \n").unwrap_err(), CsvError::Empty);
    }
}
