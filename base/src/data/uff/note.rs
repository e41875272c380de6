//! What a reader or writer noticed and assumed.

use std::fmt;

/// How much a note matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// A deviation from the standard without consequence.
    Info,
    /// Something was assumed or lost.
    Warning,
    /// A dataset could not be read; the rest was.
    Error,
}

/// One oddity: where it is, what was seen, what was assumed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// How much it matters.
    pub level: Level,
    /// Line of the file, from 1; 0 when writing.
    pub line: usize,
    /// Number of the dataset (58, 2411, ...), when inside one.
    pub dataset: Option<i64>,
    /// What was seen.
    pub seen: String,
    /// What was assumed or done about it.
    pub assumed: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(f, "line {}, ", self.line)?;
        }
        if let Some(number) = self.dataset {
            write!(f, "dataset {number}: ")?;
        }
        write!(f, "{}; {}", self.seen, self.assumed)
    }
}

/// At most this many notes are kept, so that a hostile file cannot fill the memory with them.
const MOST_NOTES: usize = 1000;

/// Collects notes up to a limit.
#[derive(Debug, Default)]
pub(super) struct Notes {
    list: Vec<Note>,
    dropped: usize,
}

impl Notes {
    pub(super) fn push(
        &mut self,
        level: Level,
        line: usize,
        dataset: Option<i64>,
        seen: impl Into<String>,
        assumed: impl Into<String>,
    ) {
        let note = Note { level, line, dataset, seen: seen.into(), assumed: assumed.into() };
        if self.list.len() < MOST_NOTES {
            self.list.push(note);
        } else {
            self.dropped += 1;
        }
    }

    pub(super) fn finish(mut self) -> Vec<Note> {
        if self.dropped > 0 {
            self.list.push(Note {
                level: Level::Warning,
                line: 0,
                dataset: None,
                seen: format!("{} further notes", self.dropped),
                assumed: "they are not listed".to_owned(),
            });
        }
        self.list
    }
}

/// The start of a text for a message, with quotes.
pub(super) fn quote(text: &str) -> String {
    let text = text.trim();
    let short: String = text.chars().take(60).filter(|c| !c.is_control()).collect();
    let dots = if text.chars().nth(60).is_some() { "..." } else { "" };
    format!("`{short}{dots}`")
}
