//! Reads the records of one dataset, with a memory for oddities.

use super::fields::{FloatLine, NumericRecord, column, numeric_record, parse_float, parse_int, push_floats};
use super::note::{Level, Notes, quote};
use super::scan::{Lines, decode};
use std::borrow::Cow;

/// Why a dataset could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) line: usize,
    pub(super) seen: String,
}

/// The records of one dataset.
pub(super) struct Cursor<'a, 'n> {
    lines: Lines<'a>,
    pub(super) number: i64,
    notes: &'n mut Notes,
    noted: Vec<&'static str>,
}

impl<'a, 'n> Cursor<'a, 'n> {
    pub(super) fn new(text: &'a [u8], first_line: usize, number: i64, notes: &'n mut Notes) -> Self {
        Self { lines: Lines::new(text, first_line), number, notes, noted: Vec::new() }
    }

    /// A note about the record just read.
    pub(super) fn note(&mut self, level: Level, seen: impl Into<String>, assumed: impl Into<String>) {
        let line = self.lines.number.saturating_sub(1);
        self.notes.push(level, line, Some(self.number), seen, assumed);
    }

    /// A note that is worth making once in a dataset.
    pub(super) fn note_once(&mut self, level: Level, seen: &'static str, assumed: &'static str) {
        if !self.noted.contains(&seen) {
            self.noted.push(seen);
            self.note(level, seen, assumed);
        }
    }

    pub(super) fn fault(&self, seen: impl Into<String>) -> Fault {
        Fault { line: self.lines.number.saturating_sub(1), seen: seen.into() }
    }

    /// The next record, whatever it is.
    pub(super) fn record(&mut self) -> Option<Cow<'a, str>> {
        let (text, is_utf8) = decode(self.lines.next_line()?);
        if !is_utf8 {
            self.note_once(Level::Info, "bytes that are not UTF-8", "they were read as Latin-1");
        }
        Some(text)
    }

    /// The next record that is not blank.
    pub(super) fn filled_record(&mut self) -> Option<Cow<'a, str>> {
        loop {
            let record = self.record()?;
            if !record.trim().is_empty() {
                return Some(record);
            }
        }
    }

    /// A line of text, without the blanks around it; empty when the dataset has ended.
    pub(super) fn text(&mut self) -> String {
        let text = self.record().unwrap_or_default().trim().to_owned();
        if text.chars().nth(80).is_some() {
            self.note_once(Level::Info, "a line of text longer than 80 characters", "it was kept whole");
        }
        text
    }

    /// Five lines of text.
    pub(super) fn ids(&mut self) -> [String; 5] {
        std::array::from_fn(|_| self.text())
    }

    /// A record of numbers that must be there.
    pub(super) fn numbers(&mut self, widths: &[usize], what: &str) -> Result<Numbers, Fault> {
        match self.record() {
            Some(text) => self.split(&text, widths, what),
            None => Err(self.fault(format!("the dataset ends before {what}"))),
        }
    }

    /// A record of numbers, split. What stands behind the numbers is a comment.
    pub(super) fn split(&mut self, text: &str, widths: &[usize], what: &str) -> Result<Numbers, Fault> {
        let plain = without_comment(text);
        if plain.len() < text.trim_end().len() {
            self.note_once(Level::Info, "text behind the numbers of a record", "it is a comment");
        }
        let Some(record) = numeric_record(plain, widths) else {
            return Err(self.fault(format!("{} where {what} should stand", quote(text))));
        };
        if record.by_blanks {
            self.note_once(Level::Info, "numbers not in their columns", "they were read by the blanks between them");
        }
        Ok(Numbers::of(&record))
    }

    /// Reads reals from whole lines until `count` are there; stops early at the end or where `stop` says so.
    pub(super) fn floats(
        &mut self,
        count: usize,
        widths: &[usize],
        stop: fn(&str) -> bool,
        values: &mut Vec<f64>,
    ) -> Result<(), Fault> {
        let target = values.len().saturating_add(count);
        while values.len() < target {
            let mut ahead = self.lines.clone();
            let Some(bytes) = ahead.next_line() else { break };
            let (text, _) = decode(bytes);
            if stop(&text) {
                break;
            }
            self.lines = ahead;
            match push_floats(&text, widths, values) {
                FloatLine::Clean => {}
                FloatLine::CutApart => {
                    self.note_once(Level::Info, "numbers that run together", "they were cut at the columns or signs");
                }
                FloatLine::NotNumbers => {
                    self.note_once(Level::Warning, "stars or `#` for a number", "it is not a number (NaN)");
                }
                FloatLine::Bad => return Err(self.fault(format!("{} is not a list of numbers", quote(&text)))),
            }
        }
        if values.len() > target {
            self.note_once(Level::Warning, "more values than announced", "the surplus was left out");
            values.truncate(target);
        }
        Ok(())
    }
}

/// The numbers of a record: integers and reals of the same fields.
pub(super) struct Numbers {
    ints: Vec<i64>,
    floats: Vec<f64>,
    filled: usize,
}

impl Numbers {
    fn of(record: &NumericRecord<'_>) -> Self {
        let n = record.fields.len();
        Self {
            ints: (0..n).map(|i| record.int(i)).collect(),
            floats: (0..n).map(|i| record.float(i)).collect(),
            filled: (0..n).rev().find(|i| record.has(*i)).map_or(0, |i| i + 1),
        }
    }

    /// Field `i` as an integer; 0 when blank.
    pub(super) fn int(&self, i: usize) -> i64 {
        self.ints.get(i).copied().unwrap_or(0)
    }

    /// Field `i` as a real; 0 when blank.
    pub(super) fn float(&self, i: usize) -> f64 {
        self.floats.get(i).copied().unwrap_or(0.0)
    }

    /// Number of fields up to the last that is not blank.
    pub(super) fn filled(&self) -> usize {
        self.filled
    }
}

/// A record of numbers without the comment behind them: programs write the name of a node there.
fn without_comment(text: &str) -> &str {
    let (mut before, mut has_digit) = (None, false);
    for (at, c) in text.char_indices() {
        // Several `#` stand for a number without room.
        let is_mark =
            matches!(c, '%' | '!' | '$') || (c == '#' && before != Some('#') && !text[at..].starts_with("##"));
        let is_number = || text[at..].split_whitespace().next().and_then(parse_float).is_some();
        let is_word = c.is_alphabetic() && before.is_none_or(char::is_whitespace) && !is_number();
        if has_digit && (is_mark || is_word) {
            return text[..at].trim_end();
        }
        has_digit |= c.is_ascii_digit();
        before = Some(c);
    }
    text
}

/// Whether a line holds a single integer: the label of the next node.
pub(super) fn is_label(text: &str) -> bool {
    let mut tokens = without_comment(text).split_ascii_whitespace();
    let first = tokens.next().unwrap_or("x");
    tokens.next().is_none() && first.bytes().all(|b| b.is_ascii_digit())
}

/// Never stops early.
pub(super) fn never(_: &str) -> bool {
    false
}

/// Appends the integers of a line of ten-column fields; `None` when it is not a list of integers.
fn push_ints(line: &str, values: &mut Vec<i64>) -> Option<()> {
    const WIDTH: usize = 10;
    let line = line.trim_end();
    let tokens: Vec<&str> = line.split_ascii_whitespace().collect();
    let fixed: Vec<&str> = (0..line.len().div_ceil(WIDTH)).map(|i| column(line, i * WIDTH, WIDTH).trim()).collect();
    let fixed: Vec<&str> = fixed.into_iter().filter(|t| !t.is_empty()).collect();
    let read = |tokens: &[&str]| tokens.iter().map(|t| parse_int(t)).collect::<Option<Vec<i64>>>();
    let found = if fixed.len() > tokens.len() { read(&fixed).or_else(|| read(&tokens)) } else { read(&tokens) };
    values.extend(found?);
    Some(())
}

impl Cursor<'_, '_> {
    /// Reads integers from whole lines until `count` are there or the dataset ends.
    pub(super) fn ints(&mut self, count: usize) -> Result<Vec<i64>, Fault> {
        let mut values = Vec::new();
        while values.len() < count {
            let Some(text) = self.record() else { break };
            if push_ints(without_comment(&text), &mut values).is_none() {
                return Err(self.fault(format!("{} is not a list of integers", quote(&text))));
            }
        }
        Ok(values)
    }
}
