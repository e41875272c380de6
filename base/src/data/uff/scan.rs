//! Cuts a universal file into datasets, binary ones included.

use super::fields::{column, numeric_record, parse_int};
use super::layout::{Layout, RECORD_7};
use super::note::{Level, Notes, quote};
use crate::catalogue::counted;
use std::borrow::Cow;

/// One dataset as it stands in the file.
#[derive(Debug, Clone)]
pub(super) struct Block<'a> {
    /// Its number.
    pub(super) number: i64,
    /// The line with the number.
    pub(super) id_line: Cow<'a, str>,
    /// Line of the file of the first record.
    pub(super) first_line: usize,
    /// Its text records.
    pub(super) text: &'a [u8],
    /// The bytes after the text of a binary dataset.
    pub(super) payload: Option<&'a [u8]>,
}

/// Bytes as text: UTF-8, else Latin-1, in which every byte is a character.
pub(super) fn decode(bytes: &[u8]) -> (Cow<'_, str>, bool) {
    match std::str::from_utf8(bytes) {
        Ok(text) => (Cow::Borrowed(text), true),
        Err(_) => (Cow::Owned(bytes.iter().map(|b| char::from(*b)).collect()), false),
    }
}

/// Lines of a byte string: LF, CR LF, or CR alone when the text has no LF at all.
#[derive(Debug, Clone)]
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    offset: usize,
    end: u8,
    /// Line of the file of the next line.
    pub(super) number: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8], number: usize) -> Self {
        let end = if !bytes.contains(&b'\n') && bytes.contains(&b'\r') { b'\r' } else { b'\n' };
        Self { bytes, offset: 0, end, number }
    }

    pub(super) fn next_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.offset..).filter(|r| !r.is_empty())?;
        let length = rest.iter().position(|b| *b == self.end);
        self.offset += length.map_or(rest.len(), |l| l + 1);
        self.number += 1;
        let line = &rest[..length.unwrap_or(rest.len())];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// Walks over the datasets of a file.
pub(super) struct Scanner<'a> {
    lines: Lines<'a>,
    /// The delimiter that ended the last dataset also began the next one.
    begun: Option<usize>,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { lines: Lines::new(bytes, 1), begun: None }
    }

    /// The next dataset, if there is one.
    pub(super) fn next_block(&mut self, notes: &mut Notes) -> Option<Block<'a>> {
        loop {
            let indent = match self.begun.take() {
                Some(indent) => indent,
                None => self.find_start(notes)?,
            };
            let id_line_number = self.lines.number;
            let id_line = decode(self.lines.next_line()?).0;
            let Some((number, is_binary)) = dataset_number(&id_line) else {
                if delimiter(id_line.as_bytes()).is_some() {
                    // A stray delimiter: this one begins the dataset.
                    self.begun = Some(indent);
                    notes.push(Level::Info, id_line_number, None, "a delimiter twice", "the second begins a dataset");
                    continue;
                }
                let seen = format!("{} where the number of a dataset should stand", quote(&id_line));
                notes.push(Level::Error, id_line_number, None, seen, "skipped up to the next delimiter");
                self.text_until_end(indent, None, notes);
                continue;
            };
            let first_line = self.lines.number;
            if is_binary {
                let (text, payload) = self.binary(number, &id_line, notes);
                return Some(Block { number, id_line, first_line, text, payload: Some(payload) });
            }
            let text = self.text_until_end(indent, Some(number), notes);
            return Some(Block { number, id_line, first_line, text, payload: None });
        }
    }

    fn find_start(&mut self, notes: &mut Notes) -> Option<usize> {
        let mut stray = 0;
        let first = self.lines.number;
        let found = loop {
            let Some(line) = self.lines.next_line() else { break None };
            if let Some(indent) = delimiter(line) {
                break Some(indent);
            }
            stray += usize::from(!line.iter().all(u8::is_ascii_whitespace));
        };
        if stray > 0 {
            notes.push(Level::Warning, first, None, format!("{} outside datasets", counted(stray, "line")), "ignored");
        }
        found
    }

    /// The records up to the end mark, which stands where the start mark stood.
    fn text_until_end(&mut self, indent: usize, number: Option<i64>, notes: &mut Notes) -> &'a [u8] {
        let start = self.lines.offset;
        loop {
            let end = self.lines.offset;
            let line_number = self.lines.number;
            let Some(line) = self.lines.next_line() else {
                notes.push(Level::Warning, line_number, number, "the file ends inside", "read up to there");
                return &self.lines.bytes[start..];
            };
            if delimiter(line) == Some(indent) {
                self.mend_missing_end(indent, number, notes);
                return &self.lines.bytes[start..end];
            }
        }
    }

    /// If a number follows an end mark, that mark was the start mark of the next dataset and the end mark is missing.
    fn mend_missing_end(&mut self, indent: usize, number: Option<i64>, notes: &mut Notes) {
        let mut ahead = self.lines.clone();
        while let Some(line) = ahead.next_line() {
            if line.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            let text = decode(line).0;
            if dataset_number(&text).is_some() && !continues_with_number(&text) {
                self.begun = Some(indent);
                let at = self.lines.number;
                notes.push(Level::Warning, at, number, "the end mark is missing", "the next start mark ends it");
            }
            return;
        }
    }

    /// Text records and payload of a binary dataset.
    ///
    /// The length of the payload is taken from record 7 or, failing that, from the line with the number, whichever is
    /// followed by an end mark; failing both, the payload ends at the next end mark.
    fn binary(&mut self, number: i64, id_line: &str, notes: &mut Notes) -> (&'a [u8], &'a [u8]) {
        const RECORDS_BEFORE_VALUES: usize = 11;
        let start = self.lines.offset;
        let mut record_7: &[u8] = b"";
        for i in 0..RECORDS_BEFORE_VALUES {
            let (before, line_number) = (self.lines.offset, self.lines.number);
            let line = self.lines.next_line().unwrap_or(b"");
            if delimiter(line).is_some() {
                notes.push(Level::Warning, line_number, Some(number), "no binary values", "the dataset ends here");
                return (&self.lines.bytes[start..before], b"");
            }
            if i == 6 {
                record_7 = line;
            }
        }
        let bytes = self.lines.bytes;
        let from = self.lines.offset;
        let line_number = self.lines.number;
        let stated = binary_fields(id_line)[3].and_then(|n| usize::try_from(n).ok());
        let implied = payload_sizes(&decode(record_7).0);
        let followed_by_end = |size: &usize| from.checked_add(*size).is_some_and(|to| end_mark_at(bytes, to).is_some());
        let size = implied.iter().copied().chain(stated).find(followed_by_end);
        let (to, next) = if let Some(size) = size {
            if stated.is_some_and(|s| s != size) {
                let seen = format!("{} bytes announced, {size} present", stated.unwrap_or(0));
                notes.push(Level::Info, line_number, Some(number), seen, "the bytes present were read");
            }
            let to = from + size;
            (to, end_mark_at(bytes, to).unwrap_or(bytes.len()))
        } else if let Some((to, next)) = search_end_mark(bytes, from) {
            let seen = format!("{} bytes of values, which is not the length announced", to - from);
            notes.push(Level::Warning, line_number, Some(number), seen, "whole values were read");
            (to, next)
        } else {
            let seen = "the end mark is missing after the binary values";
            notes.push(Level::Warning, line_number, Some(number), seen, "whole values were read");
            (bytes.len(), bytes.len())
        };
        self.lines.offset = next;
        self.lines.number += bytes[from..next].split(|b| *b == b'\n').count() - 1;
        (&bytes[start..from], &bytes[from..to])
    }
}

/// The number of blanks before the `-1` of a delimiter line; `None` for other lines.
pub(super) fn delimiter(line: &[u8]) -> Option<usize> {
    const WIDEST: usize = 6;
    let indent = line.iter().take(WIDEST).take_while(|b| **b == b' ').count();
    let rest = line.get(indent..)?.strip_prefix(b"-1")?;
    rest.iter().all(|b| b.is_ascii_whitespace() || *b == 0).then_some(indent)
}

/// Number and binary flag of a line such as `    58`, `    55   %NODAL VALUES` or `    58b     1     2 ...`: its first word; the rest is a
/// comment.
fn dataset_number(line: &str) -> Option<(i64, bool)> {
    let text = line.trim();
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if digits == 0 || digits > 6 || line.len() - line.trim_start().len() > 6 {
        return None;
    }
    let number = text[..digits].parse().ok()?;
    let rest = &text[digits..];
    let ends_word = |c: Option<char>| c.is_none_or(|c| !(c.is_alphanumeric() || matches!(c, '.' | '+' | '-' | '_')));
    let mut after = rest.chars();
    match after.next() {
        Some('b' | 'B') if ends_word(after.next()) => Some((number, number == 58)),
        first if ends_word(first) => Some((number, false)),
        _ => None,
    }
}

/// Whether a number follows the first word: a record of numbers rather than the number of a dataset with a comment.
fn continues_with_number(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let is_binary = words.next().is_some_and(|w| w.ends_with(['b', 'B']));
    !is_binary && words.next().is_some_and(|w| super::fields::parse_float(w).is_some())
}

/// Fields 2 to 5 of the line with the number of a binary dataset: byte order, floating-point format, number of text records, bytes of the
/// values; by columns, else by the blanks between them.
pub(super) fn binary_fields(id_line: &str) -> [Option<i64>; 4] {
    let by_columns =
        [(7, 6), (13, 6), (19, 12), (31, 12)].map(|(start, width)| parse_int(column(id_line, start, width)));
    if by_columns.iter().all(Option::is_some) {
        return by_columns;
    }
    let mut words = id_line.split_whitespace().skip(1).map_while(parse_int);
    std::array::from_fn(|_| words.next())
}

/// Possible lengths of the values of a binary dataset 58, by its record 7.
fn payload_sizes(record_7: &str) -> Vec<usize> {
    let Some(record) = numeric_record(record_7, &RECORD_7) else { return Vec::new() };
    let Some(layout) = Layout::of(record.int(0), record.int(2)) else { return Vec::new() };
    let Ok(points) = usize::try_from(record.int(1)) else { return Vec::new() };
    layout.bytes_per_point().into_iter().filter_map(|b| points.checked_mul(b)).collect()
}

/// If an end mark stands at `to`, possibly after a line end: where the next line begins.
fn end_mark_at(bytes: &[u8], to: usize) -> Option<usize> {
    let rest = bytes.get(to..)?;
    let skipped = [&b"\r\n"[..], b"\n", b""].into_iter().find(|p| rest.starts_with(p))?.len();
    let rest = rest[skipped..].strip_prefix(b"    -1")?;
    // Only blanks may follow; looking no further than the first other byte keeps the search linear.
    let length = rest.iter().position(|b| *b == b'\n' || !b.is_ascii_whitespace());
    match length {
        None => Some(bytes.len()),
        Some(l) if rest[l] == b'\n' => Some(bytes.len() - rest.len() + l + 1),
        Some(_) => None,
    }
}

/// The first end mark from `from` on: where the values before it end and where the next line begins.
fn search_end_mark(bytes: &[u8], from: usize) -> Option<(usize, usize)> {
    const MARK: &[u8] = b"    -1";
    let rest = bytes.get(from..)?;
    for at in 0..rest.len().saturating_sub(MARK.len() - 1) {
        if rest[at..].starts_with(MARK)
            && let Some(next) = end_mark_at(bytes, from + at)
        {
            return Some((from + at, next));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &[u8]) -> (Vec<(i64, usize)>, Vec<super::super::Note>) {
        let mut notes = Notes::default();
        let mut scanner = Scanner::new(text);
        let mut found = Vec::new();
        while let Some(block) = scanner.next_block(&mut notes) {
            found.push((block.number, block.text.len()));
        }
        (found, notes.finish())
    }

    #[test]
    fn line_ends_of_three_systems_are_understood() {
        for text in
            ["    -1\n    15\nab\n    -1\n", "    -1\r\n    15\r\nab\r\n    -1\r\n", "    -1\r    15\rab\r    -1"]
        {
            let (found, notes) = numbers(text.as_bytes());
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].0, 15);
            assert!(notes.is_empty(), "{notes:?}");
        }
    }

    #[test]
    fn a_missing_end_mark_does_not_swallow_the_next_dataset() {
        let (found, notes) = numbers(b"    -1\n    15\nab\n    -1\n    82\ncd\n    -1\n");
        assert_eq!(found, [(15, 3), (82, 3)]);
        assert_eq!(notes.len(), 1);
    }

    #[test]
    fn a_truncated_file_and_stray_text_are_noted() {
        let (found, notes) = numbers(b"hello\n    -1\n    15\nab\n");
        assert_eq!(found, [(15, 3)]);
        assert_eq!(notes.len(), 2);
    }

    #[test]
    fn what_follows_the_number_of_a_dataset_is_a_comment() {
        for line in ["    55   %VALEURS AUX NOEUDS", "    55 12 values", "    55,nodes", "    55\t# 5"] {
            assert_eq!(dataset_number(line), Some((55, false)), "{line}");
        }
        for line in ["    58b     1     2          11          32  % text", "    58B"] {
            assert_eq!(dataset_number(line), Some((58, true)), "{line}");
        }
        for line in ["    5.5", "  1.0E+00  2.0", "    55x", "    58bar", "     1-2", "abc"] {
            assert_eq!(dataset_number(line), None, "{line}");
        }
        assert_eq!(binary_fields("    58b 1 2 11 32 % 5"), [1, 2, 11, 32].map(Some));
        assert_eq!(binary_fields("    58b  % text"), [None; 4]);
        // A record of numbers behind an end mark is not a dataset.
        let (found, _) = numbers(b"    -1\n    15\nab\n    -1\n    82 1 2\ncd\n    -1\n    55 % x\ne\n    -1\n");
        assert_eq!(found, [(15, 3), (55, 2)]);
    }

    #[test]
    fn an_id_line_that_reads_minus_one_elsewhere_is_no_end_mark() {
        let (found, _) = numbers(b"    -1\n   151\n-1\nx\n    -1\n");
        assert_eq!(found, [(151, 5)]);
    }
}
