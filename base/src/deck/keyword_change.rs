//! Changes of items of a deck of keywords in their places, everything else to the byte.

use super::{DataLine, DeckError, Keyword, KeywordDeck};
use std::collections::BTreeMap;

/// New texts of items and parameters, and lines to add.
#[derive(Debug, Clone, Default)]
pub struct KeywordChanges {
    /// By file and first byte, what is added before what is changed there: last byte and text.
    edits: BTreeMap<(u32, usize, usize), (usize, String)>,
    n_added: usize,
}

/// A number as both solvers read it, from which the same bits are read back.
pub fn keyword_real(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-4..1e15).contains(&size) {
        let text = format!("{value}");
        // A point makes it a real number for every reader.
        if text.contains('.') { text } else { format!("{text}.") }
    } else {
        format!("{value:e}").to_uppercase()
    }
}

impl KeywordChanges {
    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.edits.is_empty()
    }

    /// Writes a number in place of an item of a data line.
    ///
    /// # Errors
    /// There is no such item.
    pub fn real(&mut self, line: &DataLine<'_>, (i, name): (usize, &'static str), value: f64) -> Result<(), DeckError> {
        self.item(line, (i, name), keyword_real(value))
    }

    /// Writes a text in place of an item of a data line.
    ///
    /// # Errors
    /// There is no such item.
    pub fn item(
        &mut self,
        line: &DataLine<'_>,
        (i, name): (usize, &'static str),
        text: String,
    ) -> Result<(), DeckError> {
        let Some((file, start, end)) = line.span(i) else {
            return Err(line.error(Some((i, name)), "the line has no such item; write it, so that it can be changed"));
        };
        self.edits.insert((file, start, usize::MAX), (end, text));
        Ok(())
    }

    /// Writes another value of a parameter.
    ///
    /// * `name` - of the parameter, in capitals
    ///
    /// # Errors
    /// The keyword has no such parameter with a value.
    pub fn parameter(&mut self, deck: &KeywordDeck, k: &Keyword<'_>, name: &str, value: &str) -> Result<(), DeckError> {
        let (file, start, end) = k.span();
        let text = &deck.sources()[file as usize].text()[start..end];
        let upper = text.to_ascii_uppercase();
        let mut at = 0;
        while let Some(found) = upper[at..].find(name) {
            let (from, behind) = (at + found, at + found + name.len());
            let is_begin = upper[..from].trim_end().ends_with(',');
            let rest = &text[behind..];
            let equals = rest.trim_start();
            if is_begin && equals.starts_with('=') {
                let value_from = behind + (rest.len() - equals.len()) + 1;
                let open = &text[value_from..];
                let length = open.find([',', '\n', '\r']).unwrap_or(open.len());
                let own = &open[..length];
                let first = value_from + (own.len() - own.trim_start().len());
                let last = first + own.trim().len();
                self.edits.insert((file, start + first, usize::MAX), (start + last, value.to_string()));
                return Ok(());
            }
            at = behind;
        }
        Err(k.error(format_args!("its parameter {name} is not found on its line")))
    }

    /// Adds lines above a keyword; those that are added first stand first.
    pub fn add_above(&mut self, k: &Keyword<'_>, lines: &[String]) {
        let (file, start, _) = k.span();
        self.add_at((file, start), lines);
    }

    /// Adds lines at the end of the first file.
    pub fn add_last(&mut self, deck: &KeywordDeck, lines: &[String]) {
        self.add_at((0, deck.sources()[0].text().len()), lines);
    }

    fn add_at(&mut self, (file, at): (u32, usize), lines: &[String]) {
        let text = lines.iter().fold(String::new(), |text, line| text + line + "\n");
        self.edits.insert((file, at, self.n_added), (at, text));
        self.n_added += 1;
    }

    /// The text of every file of the deck with the changes in it.
    pub fn apply(&self, deck: &KeywordDeck) -> Vec<String> {
        let mut texts = Vec::with_capacity(deck.sources().len());
        for (file, source) in deck.sources().iter().enumerate() {
            let text = source.text();
            let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
            let (mut out, mut at) = (String::with_capacity(text.len() + 256), 0);
            for ((_, start, order), (end, new)) in self.edits.range((file as u32, 0, 0)..(file as u32 + 1, 0, 0)) {
                out.push_str(&text[at..*start]);
                let is_added = *order != usize::MAX;
                if is_added && !out.is_empty() && !out.ends_with('\n') {
                    out.push_str(newline);
                }
                out.push_str(&if is_added { new.replace('\n', newline) } else { new.clone() });
                at = *end;
            }
            out.push_str(&text[at..]);
            texts.push(out);
        }
        texts
    }
}
