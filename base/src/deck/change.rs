//! Changes of fields in their places, everything else to the byte.

use super::field::{Field, Width};
use super::number::real_in;
use super::{CardId, Deck, DeckError};
use std::collections::BTreeMap;

/// One new text.
#[derive(Debug, Clone)]
struct Edit {
    end: usize,
    is_free: bool,
    text: String,
}

/// New texts of fields, and cards to add at the end of the bulk data.
#[derive(Debug, Clone, Default)]
pub struct Changes {
    /// By file, first byte and gap of the field.
    edits: BTreeMap<(u32, usize, usize), Edit>,
    added: Vec<String>,
}

impl Changes {
    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.edits.is_empty() && self.added.is_empty()
    }

    /// Number of fields that change.
    pub fn n_fields(&self) -> usize {
        self.edits.len()
    }

    /// Lines that are added.
    pub fn added(&self) -> &[String] {
        &self.added
    }

    /// Adds lines in front of ENDDATA.
    pub fn add(&mut self, lines: impl IntoIterator<Item = String>) {
        self.added.extend(lines);
    }

    /// Writes a real number into a field, with as many digits as it holds.
    ///
    /// # Errors
    /// A field that stands behind tabs, or is not there because the card has no such line.
    pub fn real(
        &mut self,
        deck: &Deck,
        (card, n, name): (CardId, usize, &'static str),
        value: f64,
    ) -> Result<String, DeckError> {
        let field = writable(deck, (card, n, name))?;
        let text = real_in(value, field.width.characters());
        self.put(deck, &field, &text);
        Ok(text)
    }

    /// Writes an integer into a field.
    ///
    /// # Errors
    /// As [`Self::real`]; a number that has no room.
    pub fn integer(
        &mut self,
        deck: &Deck,
        (card, n, name): (CardId, usize, &'static str),
        value: u32,
    ) -> Result<(), DeckError> {
        let field = writable(deck, (card, n, name))?;
        let text = value.to_string();
        if text.len() > field.width.characters() {
            return Err(deck.error(card, Some((n, name)), format_args!("{value} has no room in the field")));
        }
        self.put(deck, &field, &text);
        Ok(())
    }

    fn put(&mut self, deck: &Deck, field: &Field<'_>, text: &str) {
        let old = &deck.sources()[field.file as usize].text()[field.start..field.end];
        let width = old.len();
        let text = match field.width {
            Width::Free(_) => text.to_string(),
            // On the side of its columns on which the old text stood.
            _ if old.starts_with(' ') && !old.ends_with(' ') => format!("{text:>width$}"),
            _ => format!("{text:<width$}"),
        };
        let is_free = matches!(field.width, Width::Free(_));
        self.edits.insert((field.file, field.start, field.gap), Edit { end: field.end, is_free, text });
    }

    /// The text of every file of the deck with the changes in it.
    ///
    /// * `heading` - a comment above the lines that are added
    pub fn apply(&self, deck: &Deck, heading: &str) -> Vec<String> {
        let mut texts: Vec<String> = Vec::with_capacity(deck.sources().len());
        for (file, source) in deck.sources().iter().enumerate() {
            let text = source.text();
            let mut out = String::with_capacity(text.len() + 256);
            let mut at = 0;
            // Of fields behind the end of a line: where it ends, and the columns or commas that stand there already.
            let mut filled = (usize::MAX, 0);
            for ((_, start, gap), edit) in self.edits.range((file as u32, 0, 0)..(file as u32 + 1, 0, 0)) {
                out.push_str(&text[at.min(*start)..*start]);
                let before = if filled.0 == *start { filled.1 } else { 0 };
                let filler = if edit.is_free { "," } else { " " };
                out.push_str(&filler.repeat(gap.saturating_sub(before)));
                out.push_str(&edit.text);
                // A last field that was shorter than its columns may have grown into them.
                let grown = edit.text.len().saturating_sub(edit.end - start);
                filled = (edit.end, if edit.is_free { *gap } else { gap + grown });
                at = edit.end;
            }
            if deck.end.0 as usize == file && !self.added.is_empty() {
                let end = deck.end.1.max(at);
                out.push_str(&text[at..end]);
                let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
                if !out.is_empty() && !out.ends_with('\n') {
                    out.push_str(newline);
                }
                for line in std::iter::once(heading).chain(self.added.iter().map(String::as_str)) {
                    out.push_str(line);
                    out.push_str(newline);
                }
                at = end;
            }
            out.push_str(&text[at..]);
            texts.push(out);
        }
        texts
    }
}

/// A field that can be written.
fn writable<'a>(deck: &'a Deck, (card, n, name): (CardId, usize, &'static str)) -> Result<Field<'a>, DeckError> {
    let read = deck.card(card);
    let Some(field) = read.field(n) else {
        return Err(read.error(Some((n, name)), "the card has no such field; add a continuation for it"));
    };
    if field.tabbed {
        return Err(read.error(
            Some((n, name)),
            "a tab stands on the line, so that a field cannot be replaced in its columns; write blanks",
        ));
    }
    Ok(*field)
}
