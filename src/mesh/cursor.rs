//! Numbers one after another, as text or as bytes, with the place of each; and decks that are a mesh by themselves.

use crate::deck::DeckError;
use std::io;
use std::path::Path;

/// Why a file is not a mesh.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", if place.is_empty() { String::new() } else { format!("{place}: ") })]
pub struct MeshError {
    /// `line 12` or, in a binary part, `byte 8041`.
    pub place: String,
    /// What stands there, and what was expected.
    pub message: String,
}

/// Without the name of the file, which the one who reads a mesh knows.
impl From<DeckError> for MeshError {
    fn from(e: DeckError) -> Self {
        let place = if e.line > 0 { format!("line {}", e.line) } else { String::new() };
        let field = e.field.map_or_else(String::new, |(n, name)| format!(", field {n} ({name})"));
        let card = if e.card.is_empty() { String::new() } else { format!("{}{field}: ", e.card) };
        Self { place, message: format!("{card}{}", e.message) }
    }
}

/// What a deck is called that nothing is beside.
pub(super) const ALONE: &str = "mesh";

/// Gives the bytes of the only file of a deck; any other that it includes cannot be read.
pub(super) fn only_file(bytes: &[u8]) -> impl FnMut(&Path) -> io::Result<Vec<u8>> {
    let mut first = Some(bytes.to_vec());
    move |_| first.take().ok_or_else(|| io::Error::other("a mesh is one file; `retune import` follows INCLUDE"))
}

/// A file that is read from the front.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// Whether numbers are bytes, of the smaller end first.
    pub(super) is_binary: bool,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1, is_binary: false }
    }

    /// An error at this place.
    pub(super) fn error(&self, message: impl std::fmt::Display) -> MeshError {
        let place = if self.is_binary { format!("byte {}", self.at) } else { format!("line {}", self.line) };
        MeshError { place, message: message.to_string() }
    }

    /// Refuses a count of things of which the rest of the file cannot hold so many.
    ///
    /// * `least` - bytes that one of them needs, as text or as bytes
    pub(super) fn count(&self, given: u64, least: usize, what: &str) -> Result<usize, MeshError> {
        let left = self.bytes.len() - self.at;
        usize::try_from(given).ok().filter(|n| n.checked_mul(least).is_some_and(|size| size <= left)).ok_or_else(|| {
            self.error(format_args!("{given} {what} do not fit into the {left} bytes that are left of the file"))
        })
    }

    fn skip_space(&mut self) {
        while let Some(c) = self.bytes.get(self.at).filter(|c| c.is_ascii_whitespace()) {
            self.line += usize::from(*c == b'\n');
            self.at += 1;
        }
    }

    /// What stands up to the end of the line.
    pub(super) fn text_line(&mut self) -> String {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|c| *c == b'\n').unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..end]).trim().to_string();
        self.at += (end + 1).min(rest.len());
        self.line += usize::from(end < rest.len());
        text
    }

    /// The next line that holds something; `None` at the end.
    pub(super) fn next_line(&mut self) -> Option<String> {
        self.skip_space();
        (self.at < self.bytes.len()).then(|| self.text_line())
    }

    /// The next word of text.
    pub(super) fn word(&mut self, what: &str) -> Result<&'a str, MeshError> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if end == 0 {
            return Err(self.error(format_args!("the file ends where {what} was expected")));
        }
        self.at += end;
        std::str::from_utf8(&rest[..end]).map_err(|_| self.error(format_args!("{what} was expected, not bytes")))
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], MeshError> {
        let found = self.bytes.get(self.at..self.at + N).and_then(|b| b.try_into().ok());
        let found = found.ok_or_else(|| self.error(format_args!("the file ends where {what} was expected")))?;
        self.at += N;
        Ok(found)
    }

    fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, MeshError> {
        let word = self.word(what)?;
        word.parse().map_err(|_| self.error(format_args!("{what} was expected, not `{word}`")))
    }

    /// A number of four bytes.
    pub(super) fn int(&mut self, what: &str) -> Result<i64, MeshError> {
        if self.is_binary { Ok(i64::from(i32::from_le_bytes(self.take(what)?))) } else { self.parsed(what) }
    }

    /// A number of eight bytes, zero or above.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, MeshError> {
        if self.is_binary { Ok(u64::from_le_bytes(self.take(what)?)) } else { self.parsed(what) }
    }

    /// A finite number.
    pub(super) fn real(&mut self, what: &str) -> Result<f64, MeshError> {
        let value: f64 = if self.is_binary { f64::from_le_bytes(self.take(what)?) } else { self.parsed(what)? };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format_args!("{what} is {value}; a finite number was expected")))
        }
    }

    /// Goes on behind a line of this text.
    pub(super) fn skip_past(&mut self, marker: &str) -> Result<(), MeshError> {
        let rest = &self.bytes[self.at..];
        let found = rest.windows(marker.len()).position(|w| w == marker.as_bytes());
        let found = found.ok_or_else(|| self.error(format_args!("`{marker}` is missing")))?;
        self.line += rest[..found].split(|c| *c == b'\n').count() - 1;
        self.at += found + marker.len();
        Ok(())
    }
}
