//! Cards: lines that belong together, and typed access to their fields.

use super::field::{Field, split};
use super::number::{number, parse_real};
use super::{Deck, DeckError};
use std::fmt;

/// Which card of a deck.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CardId(pub(super) usize);

/// Name and lines of a card, as a deck keeps them.
#[derive(Debug, Clone, Copy)]
pub struct Cards {
    pub(super) name: [u8; 8],
    /// Its lines among those of the bulk data.
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Cards {
    pub(super) fn name(&self) -> &str {
        let end = self.name.iter().position(|b| *b == 0).unwrap_or(8);
        std::str::from_utf8(&self.name[..end]).unwrap_or_default()
    }
}

/// A card with its fields.
#[derive(Debug, Clone)]
pub struct Card<'a> {
    deck: &'a Deck,
    id: CardId,
    /// The name, then the data fields of all lines, eight (or four) of each; what stands in the name field of a continuation is left out.
    fields: Vec<Field<'a>>,
    is_overfull: bool,
}

impl<'a> Card<'a> {
    pub(super) fn new(deck: &'a Deck, id: CardId) -> Self {
        let card = &deck.cards[id.0];
        let mut fields = Vec::with_capacity(9);
        let mut is_overfull = false;
        for i in card.first..card.first + card.count {
            let line = &deck.lines[i as usize];
            let before = fields.len();
            is_overfull |= split(deck.of_line(line), (line.file, line.number, line.start as usize), &mut fields);
            if i > card.first {
                fields.remove(before);
            }
        }
        Self { deck, id, fields, is_overfull }
    }

    /// Whether a line of it between commas has more than its fields and the name of a continuation: what stands there is read by nobody.
    pub fn is_overfull(&self) -> bool {
        self.is_overfull
    }

    /// Which card it is.
    pub fn id(&self) -> CardId {
        self.id
    }

    /// Its name.
    pub fn name(&self) -> &'a str {
        self.deck.cards[self.id.0].name()
    }

    /// Number of its fields with the name, up to the last that is not empty.
    pub fn len(&self) -> usize {
        self.fields.iter().rposition(|f| !f.text.is_empty()).map_or(0, |i| i + 1)
    }

    /// Whether nothing stands behind its name.
    pub fn is_empty(&self) -> bool {
        self.len() <= 1
    }

    /// A field, numbered as in the manuals if these numbered on through continuations: 1 is the name, 2 to 9 the first line, 10 to 17 the
    /// second.
    pub fn field(&self, n: usize) -> Option<&Field<'a>> {
        self.fields.get(n.wrapping_sub(1))
    }

    /// Text of a field; empty where there is none.
    pub fn text(&self, n: usize) -> &'a str {
        self.field(n).map_or("", |f| f.text)
    }

    /// Whether a field is empty.
    pub fn is_blank(&self, n: usize) -> bool {
        self.text(n).is_empty()
    }

    /// File and line at which it begins.
    pub fn place(&self) -> (&'a str, usize) {
        let line = &self.deck.lines[self.deck.cards[self.id.0].first as usize];
        (self.deck.sources[line.file as usize].name(), line.number as usize)
    }

    /// An error at it.
    pub fn error(&self, field: Option<(usize, &'static str)>, message: impl fmt::Display) -> DeckError {
        let (file, first) = self.place();
        let line = field.and_then(|(n, _)| self.field(n)).map_or(first, |f| f.line as usize);
        let id = self.text(2);
        let card =
            if id.is_empty() || id.len() > 8 { self.name().to_string() } else { format!("{} {id}", self.name()) };
        DeckError { file: file.to_string(), line, card, field, message: message.to_string() }
    }

    fn wrong(&self, n: usize, name: &'static str, expected: &str) -> DeckError {
        let text = self.text(n);
        if text.is_empty() {
            self.error(Some((n, name)), format_args!("{expected} is missing"))
        } else {
            let text: String = text.chars().filter(|c| !c.is_control()).take(24).collect();
            self.error(Some((n, name)), format_args!("`{text}` where {expected} is expected"))
        }
    }

    /// An integer above zero.
    pub fn id_at(&self, n: usize, name: &'static str) -> Result<u32, DeckError> {
        self.optional_id(n, name)?.ok_or_else(|| self.wrong(n, name, "an integer above zero"))
    }

    /// An integer above zero, or nothing.
    pub fn optional_id(&self, n: usize, name: &'static str) -> Result<Option<u32>, DeckError> {
        if self.is_blank(n) {
            return Ok(None);
        }
        match self.text(n).parse::<u32>() {
            Ok(id) if id > 0 => Ok(Some(id)),
            _ => Err(self.wrong(n, name, "an integer above zero")),
        }
    }

    /// An integer; `default` where the field is empty.
    pub fn integer_or(&self, n: usize, name: &'static str, default: i64) -> Result<i64, DeckError> {
        if self.is_blank(n) {
            return Ok(default);
        }
        self.text(n).parse().map_err(|_| self.wrong(n, name, "an integer"))
    }

    /// A real number.
    pub fn real(&self, n: usize, name: &'static str) -> Result<f64, DeckError> {
        self.optional_real(n, name)?.ok_or_else(|| self.wrong(n, name, "a real number"))
    }

    /// A real number, or nothing. A zero without its point is forgiven, as solvers do.
    pub fn optional_real(&self, n: usize, name: &'static str) -> Result<Option<f64>, DeckError> {
        if self.is_blank(n) {
            return Ok(None);
        }
        let text = self.text(n);
        let value =
            parse_real(text).or_else(|| number(text).filter(|v| *v == 0.0 || text.contains(['e', 'E', 'd', 'D'])));
        value.map(Some).ok_or_else(|| self.wrong(n, name, "a real number with a decimal point"))
    }

    /// A real number; `default` where the field is empty.
    pub fn real_or(&self, n: usize, name: &'static str, default: f64) -> Result<f64, DeckError> {
        Ok(self.optional_real(n, name)?.unwrap_or(default))
    }

    /// Three real numbers, zero where empty.
    pub fn vector(&self, n: usize, name: &'static str) -> Result<[f64; 3], DeckError> {
        Ok([self.real_or(n, name, 0.0)?, self.real_or(n + 1, name, 0.0)?, self.real_or(n + 2, name, 0.0)?])
    }

    /// Components 1 to 6, each once at most, as flags; none where the field is empty or zero. Blanks between them are passed over.
    pub fn components(&self, n: usize, name: &'static str) -> Result<[bool; 6], DeckError> {
        let mut flags = [false; 6];
        if matches!(self.text(n), "" | "0") {
            return Ok(flags);
        }
        for c in self.text(n).chars().filter(|c| !c.is_whitespace()) {
            match c.to_digit(10).filter(|d| (1..=6).contains(d)) {
                Some(d) if !flags[d as usize - 1] => flags[d as usize - 1] = true,
                _ => return Err(self.wrong(n, name, "components, digits of 1 to 6 once each,")),
            }
        }
        Ok(flags)
    }

    /// Identification numbers from field `n` on, with `THRU` and `BY`, blanks skipped.
    pub fn ids_from(&self, n: usize, name: &'static str) -> Result<Vec<u32>, DeckError> {
        /// A list that a person wrote is shorter; one that is not would fill the memory.
        const MOST: usize = 20_000_000;
        let mut ids: Vec<u32> = Vec::new();
        let mut at = n;
        while at <= self.len() {
            let text = self.text(at);
            if text.eq_ignore_ascii_case("THRU") {
                let from = ids.last().copied().ok_or_else(|| self.wrong(at, name, "a number before THRU"))?;
                let to = self.id_at(at + 1, name)?;
                let by = if self.text(at + 2).eq_ignore_ascii_case("BY") { self.id_at(at + 3, name)? } else { 1 };
                if to < from {
                    return Err(self.wrong(at + 1, name, "a number not below the one before THRU"));
                }
                if ids.len() + ((to - from) / by) as usize > MOST {
                    return Err(self.error(Some((at + 1, name)), format_args!("more than {MOST} numbers in one list")));
                }
                let mut next = from;
                while let Some(id) = next.checked_add(by).filter(|id| *id <= to) {
                    ids.push(id);
                    next = id;
                }
                at += if by == 1 && !self.text(at + 2).eq_ignore_ascii_case("BY") { 2 } else { 4 };
            } else {
                ids.extend(self.optional_id(at, name)?);
                at += 1;
            }
        }
        Ok(ids)
    }
}
