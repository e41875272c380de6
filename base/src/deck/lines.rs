//! From files to lines, and from lines to cards.

use super::card::Cards;
use super::field::Kind;
use super::source::{Include, Source, find};
use super::{CaseControl, Deck, DeckError};
use std::path::{Path, PathBuf};

/// A line of bulk data that is neither empty nor a comment.
#[derive(Debug, Clone, Copy)]
pub(super) struct BulkLine {
    pub file: u32,
    /// From 1.
    pub number: u32,
    pub start: u32,
    pub end: u32,
}

/// A comment of the bulk data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Comment {
    /// Index of the file.
    pub file: u32,
    /// Line of the file, from 1.
    pub line: u32,
    pub(super) start: u32,
    pub(super) end: u32,
    /// Number of cards that stand before it.
    pub before: u32,
}

/// INCLUDE within INCLUDE, at most.
const DEEPEST: usize = 32;
/// Bytes of all files, at most: a deck of ten million grids.
const LARGEST: usize = 1 << 30;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    Executive,
    Case,
    Bulk,
    Ended,
}

/// One pass through all files.
pub(super) struct Pass<'a> {
    deck: &'a mut Deck,
    section: Section,
    case: Vec<(u32, u32, String)>,
    open: Vec<PathBuf>,
    bytes: usize,
    /// Whether a card stands before, to which a continuation belongs.
    may_continue: bool,
}

impl<'a> Pass<'a> {
    pub(super) fn new(deck: &'a mut Deck) -> Self {
        Self { deck, section: Section::Executive, case: Vec::new(), open: Vec::new(), bytes: 0, may_continue: false }
    }

    pub(super) fn file(
        &mut self,
        path: &Path,
        read: &mut dyn FnMut(&Path) -> std::io::Result<Vec<u8>>,
    ) -> Result<(), DeckError> {
        let whole = |message: String| DeckError {
            file: path.display().to_string(),
            line: 0,
            card: String::new(),
            field: None,
            message,
        };
        let bytes = read(path).map_err(|e| whole(format!("it cannot be read: {e}")))?;
        self.bytes += bytes.len();
        if self.bytes > LARGEST {
            return Err(whole(format!("the files of the deck are larger than {LARGEST} bytes together")));
        }
        if bytes.iter().take(4096).any(|b| *b == 0) {
            return Err(whole("it is not text: there are zero bytes in it".to_string()));
        }
        let source = Source::new(path, bytes);
        let file = self.deck.sources.len() as u32;
        if file == 0 {
            let begins = |word: &str| source.text().lines().any(|l| starts(l, word));
            if !begins("CEND") && !begins("BEGIN") {
                self.section = Section::Bulk;
            }
        }
        let text = source.text().to_string();
        self.deck.sources.push(source);
        self.open.push(path.to_path_buf());
        let mut at = 0;
        let mut number = 0;
        let mut lines = text.split_inclusive('\n');
        while let Some(full) = lines.next() {
            number += 1;
            let start = at;
            at += full.len();
            if self.section == Section::Ended {
                break;
            }
            let line = full.trim_end_matches(['\n', '\r']);
            if starts(line, "INCLUDE") {
                let mut statement = line.trim_start()[7..].to_string();
                // A quoted name may go on.
                while statement.matches('\'').count() == 1 || statement.matches('"').count() == 1 {
                    let Some(more) = lines.next() else { break };
                    number += 1;
                    at += more.len();
                    statement.push_str(more.trim());
                }
                self.include((file, number), &statement, read)?;
                continue;
            }
            self.line((file, number), (start, line))?;
        }
        if file == 0 && self.section != Section::Ended {
            self.deck.end = (0, text.len());
        }
        self.open.pop();
        Ok(())
    }

    fn include(
        &mut self,
        (file, line): (u32, u32),
        statement: &str,
        read: &mut dyn FnMut(&Path) -> std::io::Result<Vec<u8>>,
    ) -> Result<(), DeckError> {
        let name = statement.split('$').next().unwrap_or_default().trim().trim_matches(['\'', '"']).trim();
        let fail = |deck: &Deck, message: String| DeckError {
            file: deck.sources[file as usize].name().to_string(),
            line: line as usize,
            card: "INCLUDE".to_string(),
            field: None,
            message,
        };
        if name.is_empty() {
            return Err(fail(self.deck, "the name of a file is missing".to_string()));
        }
        let beside = self.deck.sources[file as usize].path().to_path_buf();
        let first = self.deck.sources[0].path().to_path_buf();
        let Some(path) = find(name, &beside, &first) else {
            // Alterations of the solver's own programme say nothing of the structure.
            if self.section == Section::Executive {
                self.deck.not_found.push(name.to_string());
                return Ok(());
            }
            let shown: String = name.chars().filter(|c| !c.is_control()).take(200).collect();
            return Err(fail(self.deck, format!("there is no file `{shown}` beside the deck")));
        };
        let same = |p: &PathBuf| p.canonicalize().ok() == path.canonicalize().ok();
        if self.open.iter().any(same) {
            return Err(fail(self.deck, format!("`{}` includes itself", path.display())));
        }
        if self.open.len() > DEEPEST {
            return Err(fail(self.deck, format!("files include each other more than {DEEPEST} deep")));
        }
        self.deck.includes.push(Include { file, line, target: self.deck.sources.len() as u32 });
        self.may_continue = false;
        self.file(&path, read)
    }

    fn line(&mut self, (file, number): (u32, u32), (start, line): (usize, &str)) -> Result<(), DeckError> {
        let data = line.split('$').next().unwrap_or_default();
        let fail = |deck: &Deck, card: &str, message: String| DeckError {
            file: deck.sources[file as usize].name().to_string(),
            line: number as usize,
            card: card.to_string(),
            field: None,
            message,
        };
        if data.trim().is_empty() {
            if self.section == Section::Bulk && line.trim_start().starts_with('$') {
                let (start, end) = (start as u32, (start + line.len()) as u32);
                let before = self.deck.cards.len() as u32;
                self.deck.comments.push(Comment { file, line: number, start, end, before });
            }
            return Ok(());
        }
        match self.section {
            Section::Executive | Section::Case => {
                let statement = data.trim().to_uppercase();
                if let Some(rest) = statement.strip_prefix("BEGIN") {
                    if rest.contains("SUPER") || rest.contains("AUXMODEL") || rest.contains("ARBMODEL") {
                        let text = "superelements are not read: give the deck of one structure";
                        return Err(fail(self.deck, "BEGIN", text.to_string()));
                    }
                    self.section = Section::Bulk;
                } else if statement == "CEND" {
                    self.section = Section::Case;
                } else if self.section == Section::Executive {
                    let words: Vec<&str> = statement.split_whitespace().collect();
                    self.deck.executive.push(words.join(" "));
                } else {
                    self.case.push((file, number, data.trim().to_string()));
                }
            }
            Section::Bulk => {
                if starts(data, "ENDDATA") {
                    self.section = Section::Ended;
                    self.deck.end = (file, start);
                    return Ok(());
                }
                if starts(data, "BEGIN") {
                    let text = "superelements are not read: give the deck of one structure";
                    return Err(fail(self.deck, "BEGIN", text.to_string()));
                }
                let entry = BulkLine { file, number, start: start as u32, end: (start + line.len()) as u32 };
                let head = match Kind::of(line) {
                    Kind::Free { .. } => data.split(',').next().unwrap_or_default(),
                    _ => data.get(..8).unwrap_or(data).split('\t').next().unwrap_or_default(),
                };
                let name = head.trim();
                if name.is_empty() || name.starts_with(['+', '*']) {
                    let Some(card) = self.deck.cards.last_mut().filter(|_| self.may_continue) else {
                        let text =
                            "it continues a card, and none stands before it; continuations must follow their card";
                        return Err(fail(self.deck, "", text.to_string()));
                    };
                    card.count += 1;
                    self.deck.lines.push(entry);
                    return Ok(());
                }
                let name = name.trim_end_matches('*').trim().to_uppercase();
                let is_name = name.len() <= 8
                    && name.starts_with(|c: char| c.is_ascii_alphabetic())
                    && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
                if !is_name {
                    let shown: String = head.trim().chars().filter(|c| !c.is_control()).take(24).collect();
                    if shown.starts_with('=') {
                        let text = "`=` replicates the card above it, which is not read: write the cards out, as the solver's sorted echo has them";
                        return Err(fail(self.deck, "", text.to_string()));
                    }
                    let hint = if shown == "-1" {
                        ": this looks like a universal file, which `retune identify` reads"
                    } else {
                        ""
                    };
                    return Err(fail(self.deck, "", format!("`{shown}` is not the name of a card{hint}")));
                }
                let mut bytes = [0; 8];
                bytes[..name.len()].copy_from_slice(name.as_bytes());
                self.deck.cards.push(Cards { name: bytes, first: self.deck.lines.len() as u32, count: 1 });
                self.deck.lines.push(entry);
                self.may_continue = true;
            }
            Section::Ended => {}
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Result<(), DeckError> {
        self.deck.case_control = CaseControl::parse(&self.case);
        if self.deck.cards.is_empty() {
            let file = self.deck.sources.first().map_or_else(String::new, |s| s.name().to_string());
            let message = "there are no bulk data in it: is it a Nastran deck?".to_string();
            return Err(DeckError { file, line: 0, card: String::new(), field: None, message });
        }
        Ok(())
    }
}

/// Whether a line begins with a word, in any case, and the word ends there.
fn starts(line: &str, word: &str) -> bool {
    let line = line.trim_start();
    let begins = line.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    begins && !line[word.len()..].starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_')
}
