//! What an import did, for the one who asked.

use retune::catalogue::counted;
use std::collections::BTreeMap;
use std::fmt;

/// What was read, left out and approximated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportReport {
    /// What a deck is made of: `card`, `keyword`.
    pub entry: &'static str,
    /// Files of the deck.
    pub files: usize,
    /// Cards or keywords that became part of the model: name, count and what it became.
    pub read: BTreeMap<String, (usize, &'static str)>,
    /// Those that say nothing of the structure: name, count and what they are for.
    pub left_out: BTreeMap<String, (usize, &'static str)>,
    /// What the model has otherwise than the deck, and what that costs; each once with their number.
    pub approximated: BTreeMap<String, usize>,
    /// What was decided where the deck left it open.
    pub notes: Vec<String>,
}

impl ImportReport {
    pub(crate) fn approximate(&mut self, what: impl Into<String>) {
        *self.approximated.entry(what.into()).or_default() += 1;
    }

    pub(crate) fn note(&mut self, what: impl Into<String>) {
        let what = what.into();
        if !self.notes.contains(&what) {
            self.notes.push(what);
        }
    }
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total: usize = self.read.values().map(|r| r.0).sum();
        writeln!(f, "read        {} in {}", counted(total, self.entry), counted(self.files, "file"))?;
        // By what they became.
        let mut kinds: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for (name, (count, becomes)) in &self.read {
            kinds.entry(becomes).or_default().push(format!("{count} {name}"));
        }
        for (becomes, cards) in kinds {
            writeln!(f, "  {becomes:<18} {}", cards.join(", "))?;
        }
        if !self.left_out.is_empty() {
            let total: usize = self.left_out.values().map(|r| r.0).sum();
            writeln!(f, "left out    {} that say nothing of the structure", counted(total, self.entry))?;
            let mut kinds: BTreeMap<&str, Vec<String>> = BTreeMap::new();
            for (name, (count, why)) in &self.left_out {
                kinds.entry(why).or_default().push(format!("{count} {name}"));
            }
            for (why, cards) in kinds {
                writeln!(f, "  {why:<18} {}", cards.join(", "))?;
            }
        }
        for (i, (what, count)) in self.approximated.iter().enumerate() {
            let head = if i == 0 { "approximate" } else { "" };
            // Of keywords it is elements that are counted.
            let times = if self.entry == "card" { counted(*count, self.entry) } else { format!("{count} times") };
            writeln!(f, "{head:<12}{what} ({times})")?;
        }
        for (i, note) in self.notes.iter().enumerate() {
            let head = if i == 0 { "notes" } else { "" };
            writeln!(f, "{head:<12}{note}")?;
        }
        Ok(())
    }
}
