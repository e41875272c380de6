//! Input decks of Nastran: files, executive and case control, cards with their fields, each with its place; and of Abaqus and CalculiX:
//! keywords with their parameters and data lines ([`KeywordDeck`]).
//!
//! This room knows how a deck is written and nothing of what its cards mean: [`Deck::read`] follows INCLUDE, takes lines together to
//! cards, and [`Deck::card`] gives the fields of one in small, large and free format alike. A field knows its file, line and columns,
//! so that [`Changes`] can write a new value in its place and leave every other byte as it is.

mod card;
mod case_control;
mod change;
mod field;
mod keyword_change;
mod keywords;
mod lines;
mod number;
mod source;
#[cfg(test)]
mod tests;

pub use card::{Card, CardId, Cards};
pub use case_control::{CaseControl, Subcase};
pub use change::Changes;
pub use field::{Field, Width};
pub use keyword_change::{KeywordChanges, keyword_real};
pub use keywords::{DataLine, Keyword, KeywordDeck, is_keyword_deck, label};
pub use lines::Comment;
pub use number::{parse_real, real_in};
pub use source::{Include, Source};

use lines::BulkLine;
use std::fmt;
use std::path::Path;

/// A deck: its files and its cards.
#[derive(Debug, Clone, Default)]
pub struct Deck {
    sources: Vec<Source>,
    includes: Vec<Include>,
    /// Files of executive control that are not there.
    not_found: Vec<String>,
    /// Executive control: statements above CEND, in order.
    executive: Vec<String>,
    case_control: CaseControl,
    lines: Vec<BulkLine>,
    cards: Vec<Cards>,
    comments: Vec<Comment>,
    /// Where the bulk data end: file and byte, before ENDDATA.
    end: (u32, usize),
}

/// Why a deck cannot be read, with the place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeckError {
    /// The file.
    pub file: String,
    /// Its line, from 1; 0 for the file as a whole.
    pub line: usize,
    /// The card, if one is meant.
    pub card: String,
    /// The field, from 1 (the name of the card), and its name in the manuals.
    pub field: Option<(usize, &'static str)>,
    /// What is wrong and what was expected.
    pub message: String,
}

impl fmt::Display for DeckError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        f.write_str(": ")?;
        if !self.card.is_empty() {
            write!(f, "{}", self.card)?;
            if let Some((number, name)) = self.field {
                write!(f, ", field {number} ({name})")?;
            }
            f.write_str(": ")?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for DeckError {}

impl Deck {
    /// Reads a deck and everything that it includes.
    ///
    /// * `read` - gives the bytes of a file
    ///
    /// # Errors
    /// A file that cannot be read, an INCLUDE that leads nowhere or round in a circle, a line that belongs to no card.
    pub fn read(path: &Path, read: &mut dyn FnMut(&Path) -> std::io::Result<Vec<u8>>) -> Result<Self, DeckError> {
        let mut deck = Self::default();
        let mut pass = lines::Pass::new(&mut deck);
        pass.file(path, read)?;
        pass.finish()?;
        Ok(deck)
    }

    /// Its files, the one that was named first.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Its INCLUDE statements.
    pub fn includes(&self) -> &[Include] {
        &self.includes
    }

    /// Names of files that executive control includes and that are not there: what alters the solver's own programme.
    pub fn not_found(&self) -> &[String] {
        &self.not_found
    }

    /// Statements of executive control, without comments, in capitals.
    pub fn executive(&self) -> &[String] {
        &self.executive
    }

    /// The solution sequence, `103`, if the deck states one.
    pub fn solution(&self) -> Option<&str> {
        self.executive.iter().find_map(|s| s.strip_prefix("SOL ")).map(|s| s.split([' ', ',']).next().unwrap_or(s))
    }

    /// Case control.
    pub fn case_control(&self) -> &CaseControl {
        &self.case_control
    }

    /// Its cards, in the order of the files.
    pub fn cards(&self) -> impl ExactSizeIterator<Item = CardId> + use<> {
        (0..self.cards.len()).map(CardId)
    }

    /// Name of a card, in capitals and without `*`.
    pub fn name(&self, card: CardId) -> &str {
        self.cards[card.0].name()
    }

    /// A card with its fields.
    pub fn card(&self, card: CardId) -> Card<'_> {
        Card::new(self, card)
    }

    /// Comments of the bulk data, in the order of the files.
    pub fn comments(&self) -> &[Comment] {
        &self.comments
    }

    /// Text of a comment without its `$`.
    pub fn comment(&self, comment: &Comment) -> &str {
        let text = &self.sources[comment.file as usize].text()[comment.start as usize..comment.end as usize];
        text.trim_start_matches('$').trim()
    }

    /// An error at a card.
    pub fn error(&self, card: CardId, field: Option<(usize, &'static str)>, message: impl fmt::Display) -> DeckError {
        self.card(card).error(field, message)
    }

    fn of_line(&self, line: &BulkLine) -> &str {
        &self.sources[line.file as usize].text()[line.start as usize..line.end as usize]
    }

    /// The lines of a card as they stand in its files.
    pub fn text_of(&self, card: CardId) -> String {
        let own = &self.cards[card.0];
        let lines = &self.lines[own.first as usize..(own.first + own.count) as usize];
        lines.iter().fold(String::new(), |text, line| text + self.of_line(line) + "\n")
    }
}
