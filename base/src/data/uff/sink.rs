//! Writes the records of datasets.

use super::UffError;
use super::fields::format_float;
use super::function::{ByteOrder, Precision};
use super::note::{Level, Note, Notes};
use std::fmt::Write as _;

/// The file being written.
#[derive(Debug, Default)]
pub(super) struct Sink {
    bytes: Vec<u8>,
    record: String,
    number: i64,
    rounded: usize,
    worst: f64,
    notes: Notes,
    refused: Option<UffError>,
}

impl Sink {
    pub(super) fn finish(self) -> Result<(Vec<u8>, Vec<Note>), UffError> {
        match self.refused {
            Some(error) => Err(error),
            None => Ok((self.bytes, self.notes.finish())),
        }
    }

    pub(super) fn note(&mut self, level: Level, seen: impl Into<String>, assumed: impl Into<String>) {
        self.notes.push(level, 0, Some(self.number), seen, assumed);
    }

    pub(super) fn begin(&mut self, number: i64) {
        self.number = number;
        self.bytes.extend_from_slice(b"    -1\n");
        let _ = write!(self.record, "{number:>6}");
        self.end_record();
    }

    pub(super) fn begin_binary(&mut self, number: i64, order: ByteOrder, bytes: usize) {
        const IEEE: i32 = 2;
        const TEXT_RECORDS: i32 = 11;
        self.number = number;
        self.bytes.extend_from_slice(b"    -1\n");
        let order = if order == ByteOrder::Little { 1 } else { 2 };
        let _ = write!(
            self.record,
            "{number:>6}b{order:>6}{IEEE:>6}{TEXT_RECORDS:>12}{bytes:>12}{:>6}{:>6}{:>12}{:>12}",
            0, 0, 0, 0
        );
        self.end_record();
    }

    pub(super) fn end_record(&mut self) {
        self.bytes.extend_from_slice(self.record.as_bytes());
        self.bytes.push(b'\n');
        self.record.clear();
    }

    /// Ends the dataset, with one note on the numbers that lost digits in it.
    pub(super) fn end(&mut self) {
        self.bytes.extend_from_slice(b"    -1\n");
        if self.rounded > 0 {
            let seen = format!("{} numbers have more digits than their columns", self.rounded);
            let assumed = format!("they are rounded, the relative error is at most {:.1e}", self.worst);
            self.note(Level::Info, seen, assumed);
        }
        self.rounded = 0;
        self.worst = 0.0;
    }

    /// A line of text as a record of its own.
    pub(super) fn text(&mut self, text: &str) {
        if text.trim() != text || text.contains(['\n', '\r']) {
            self.note(Level::Info, "a line of text with blanks around it or a line end in it", "they were taken out");
        }
        self.record.extend(text.trim().chars().map(|c| if matches!(c, '\n' | '\r') { ' ' } else { c }));
        self.end_record();
    }

    pub(super) fn texts(&mut self, texts: &[String]) {
        for text in texts {
            self.text(text);
        }
    }

    /// A name in a field, with a blank before it.
    pub(super) fn name(&mut self, name: &str, width: usize) {
        let clean = name.trim().replace(['\n', '\r'], " ");
        if clean.chars().nth(width).is_some() {
            self.note(Level::Warning, format!("`{clean}` is longer than {width} characters"), "it was cut");
        }
        let short: String = clean.chars().take(width).collect();
        let _ = write!(self.record, " {short:<width$}");
    }

    /// Text in a field of its own width, left-justified.
    pub(super) fn field(&mut self, text: &str, width: usize) {
        let clean = text.trim().replace(['\n', '\r'], " ");
        if clean.chars().nth(width).is_some() {
            self.note(Level::Warning, format!("`{clean}` is longer than {width} characters"), "it was cut");
        }
        let short: String = clean.chars().take(width).collect();
        let _ = write!(self.record, "{short:<width$}");
    }

    /// Text as it is, but for line ends.
    pub(super) fn raw(&mut self, text: &str) {
        self.record.extend(text.chars().map(|c| if matches!(c, '\n' | '\r') { ' ' } else { c }));
    }

    /// Integers in their columns.
    pub(super) fn ints(&mut self, fields: &[(i64, usize)]) {
        for (value, width) in fields {
            let text = format!("{value:>width$}");
            if text.len() > *width && self.refused.is_none() {
                self.refused = Some(UffError::TooWide { dataset: self.number, value: *value, columns: *width });
            }
            self.record.push_str(&text);
        }
    }

    /// A record of integers of ten columns, eight in a line.
    pub(super) fn int_lines(&mut self, values: &[i64]) {
        for line in values.chunks(8) {
            for value in line {
                self.ints(&[(*value, 10)]);
            }
            self.end_record();
        }
    }

    /// A real number in its columns.
    pub(super) fn float(&mut self, value: f64, width: usize, digits: usize) {
        let (text, is_exact) = format_float(value, width, digits);
        if !is_exact {
            self.rounded += 1;
            let error = text.trim().parse::<f64>().map_or(f64::INFINITY, |v| ((v - value) / value).abs());
            self.worst = self.worst.max(error);
        }
        self.record.push_str(&text);
    }

    /// A real number with a `D` exponent.
    pub(super) fn double(&mut self, value: f64, digits: usize) {
        let (text, _) = format_float(value, 25, digits);
        self.record.push_str(&if value.is_finite() { text.replace('E', "D") } else { text });
    }

    /// Reals in lines of the given columns.
    pub(super) fn float_lines(&mut self, values: &[f64], widths: &[usize]) {
        for line in values.chunks(widths.len()) {
            for (value, width) in line.iter().zip(widths) {
                self.float(*value, *width, if *width == 13 { 5 } else { 12 });
            }
            self.end_record();
        }
    }

    /// Binary values, directly after the last record; the end mark follows them without a line end.
    pub(super) fn payload(&mut self, values: &[f64], order: ByteOrder, precision: Precision) {
        let mut rounded = 0;
        for value in values {
            match precision {
                Precision::Single => {
                    let single = *value as f32;
                    rounded += usize::from(f64::from(single).to_bits() != value.to_bits() && !value.is_nan());
                    let bytes = if order == ByteOrder::Little { single.to_le_bytes() } else { single.to_be_bytes() };
                    self.bytes.extend_from_slice(&bytes);
                }
                Precision::Double => {
                    let bytes = if order == ByteOrder::Little { value.to_le_bytes() } else { value.to_be_bytes() };
                    self.bytes.extend_from_slice(&bytes);
                }
            }
        }
        if rounded > 0 {
            self.note(Level::Info, format!("{rounded} numbers in single precision"), "they are rounded to 24 bits");
        }
    }
}
