//! Input decks of Abaqus and CalculiX: keyword lines with their parameters, and the data lines below them.
//!
//! ```text
//! ** a comment
//! *ELEMENT, TYPE=C3D8, ELSET=deck      keyword and parameters: blanks and letters' case count for nothing; a comma at the end goes on
//! 1, 10, 11, 12, 13,                   data lines up to the next keyword, items between commas
//! 14, 15, 16, 17
//! ```
//!
//! INCLUDE and `INPUT=` of a keyword bring in other files. What keywords mean is not known here.

use super::DeckError;
use super::source::{Source, find};
use std::fmt;
use std::path::{Path, PathBuf};

/// A line of a file.
#[derive(Debug, Clone, Copy)]
struct Line {
    file: u32,
    /// From 1.
    number: u32,
    start: u32,
    end: u32,
}

/// One parameter of a keyword: its name in capitals without blanks, and its value.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Parameter {
    name: String,
    value: Option<String>,
}

#[derive(Debug, Clone)]
struct Entry {
    /// Its name in capitals without blanks.
    name: String,
    parameters: Vec<Parameter>,
    file: u32,
    line: u32,
    /// Its data lines among all.
    first: u32,
    count: u32,
    /// Comments that stand right above it, among all.
    comments: (u32, u32),
}

/// A deck of keywords.
#[derive(Debug, Clone, Default)]
pub struct KeywordDeck {
    sources: Vec<Source>,
    entries: Vec<Entry>,
    lines: Vec<Line>,
    comments: Vec<Line>,
}

/// One keyword of a deck with its parameters and data.
#[derive(Debug, Clone, Copy)]
pub struct Keyword<'a> {
    deck: &'a KeywordDeck,
    index: usize,
}

/// A data line, split at its commas.
#[derive(Debug, Clone)]
pub struct DataLine<'a> {
    keyword: Keyword<'a>,
    line: Line,
    items: Vec<&'a str>,
}

/// INCLUDE within INCLUDE, at most.
const DEEPEST: usize = 32;
/// Bytes of all files, at most.
const LARGEST: usize = 1 << 30;

type Read<'a> = dyn FnMut(&Path) -> std::io::Result<Vec<u8>> + 'a;

/// Whether a text begins as a deck of keywords does: its first line that is not empty is a keyword or a comment of two stars.
pub fn is_keyword_deck(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1 << 16)];
    let first = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).find(|l| !l.is_empty());
    first
        .is_some_and(|l| l.starts_with(b"**") || (l.starts_with(b"*") && l.get(1).is_some_and(u8::is_ascii_alphabetic)))
}

/// A name as decks compare them: in capitals; what stands in quotation marks stays as it is, and keeps them where that matters. The label of
/// a label is itself.
pub fn label(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (i, part) in text.trim().split('"').enumerate() {
        // Every second part stands in quotation marks.
        if i % 2 == 1 && part.to_uppercase() != part {
            out.push('"');
            out.push_str(part);
            out.push('"');
        } else {
            out.push_str(&part.to_uppercase());
        }
    }
    out
}

impl KeywordDeck {
    /// Reads a deck and everything that it includes.
    ///
    /// * `read` - gives the bytes of a file
    ///
    /// # Errors
    /// A file that cannot be read, an INCLUDE that leads nowhere or round in a circle, a line that belongs to no keyword.
    pub fn read(path: &Path, read: &mut Read<'_>) -> Result<Self, DeckError> {
        let mut pass = Pass { deck: Self::default(), open: Vec::new(), bytes: 0, above: 0 };
        pass.file(path, read, false)?;
        if pass.deck.entries.is_empty() {
            return Err(whole(path, "there is no keyword in it: is it a deck of Abaqus or CalculiX?".to_string()));
        }
        Ok(pass.deck)
    }

    /// Its files, the one that was named first.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Its keywords, in the order of the files.
    pub fn keywords(&self) -> impl ExactSizeIterator<Item = Keyword<'_>> {
        (0..self.entries.len()).map(|index| Keyword { deck: self, index })
    }

    /// A keyword by its place in that order.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn keyword(&self, index: usize) -> Keyword<'_> {
        assert!(index < self.entries.len(), "the deck has no keyword {index}");
        Keyword { deck: self, index }
    }

    fn text(&self, line: &Line) -> &str {
        &self.sources[line.file as usize].text()[line.start as usize..line.end as usize]
    }
}

fn whole(path: &Path, message: String) -> DeckError {
    DeckError { file: path.display().to_string(), line: 0, card: String::new(), field: None, message }
}

fn shown(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(32).collect()
}

struct Pass {
    deck: KeywordDeck,
    open: Vec<PathBuf>,
    bytes: usize,
    /// The first comment that no keyword stands below yet.
    above: usize,
}

impl Pass {
    fn file(&mut self, path: &Path, read: &mut Read<'_>, is_data: bool) -> Result<(), DeckError> {
        let bytes = read(path).map_err(|e| whole(path, format!("it cannot be read: {e}")))?;
        self.bytes += bytes.len();
        if self.bytes > LARGEST {
            return Err(whole(path, format!("the files of the deck are larger than {LARGEST} bytes together")));
        }
        if bytes.iter().take(4096).any(|b| *b == 0) {
            return Err(whole(path, "it is not text: there are zero bytes in it".to_string()));
        }
        let source = Source::new(path, bytes);
        let file = self.deck.sources.len() as u32;
        let text = source.text().to_string();
        self.deck.sources.push(source);
        self.open.push(path.to_path_buf());
        let mut at = 0;
        // A keyword line that goes on, with the place of its first line.
        let mut begun: Option<(String, u32)> = None;
        let mut is_below = is_data;
        let mut empty: Vec<Line> = Vec::new();
        let mut number = 0;
        for full in text.split_inclusive('\n') {
            number += 1;
            let start = at;
            at += full.len();
            let line = full.trim_end_matches(['\n', '\r']);
            let trimmed = line.trim();
            let place = Line { file, number, start: start as u32, end: (start + line.len()) as u32 };
            // A star alone is one of CalculiX.
            if trimmed.starts_with("**") || trimmed == "*" {
                self.deck.comments.push(place);
                continue;
            }
            if let Some((mut head, first)) = begun.take() {
                // A comma at the end behind which no parameter comes (it begins with a letter) means nothing.
                let is_over = !trimmed.starts_with(|c: char| c.is_alphabetic());
                if !is_over {
                    head.push_str(trimmed);
                }
                if !is_over && trimmed.ends_with(',') {
                    begun = Some((head, first));
                } else {
                    self.keyword((file, first), &head, read)?;
                }
                if !is_over {
                    continue;
                }
            }
            if trimmed.is_empty() {
                // An empty line before another data line is one itself: springs along their own line have it in place of their dofs.
                if is_below {
                    empty.push(place);
                }
            } else if trimmed.starts_with('*') {
                is_below = true;
                empty.clear();
                if is_data {
                    return Err(self.error(file, number, trimmed, "a file of data (INPUT=) must not hold keywords"));
                }
                if trimmed.ends_with(',') {
                    begun = Some((trimmed.to_string(), number));
                } else {
                    self.keyword((file, number), trimmed, read)?;
                }
            } else if self.deck.entries.is_empty() {
                let text = format!("`{}` belongs to no keyword; a line beginning with `*` is expected", shown(trimmed));
                return Err(self.error(file, number, "", &text));
            } else {
                for line in empty.drain(..) {
                    self.data(line);
                }
                self.data(place);
            }
        }
        if let Some((head, first)) = begun {
            // A comma at the end of the last line: nothing follows, and nothing is missing.
            self.keyword((file, first), head.trim_end_matches(','), read)?;
        }
        self.open.pop();
        Ok(())
    }

    fn data(&mut self, line: Line) {
        self.above = self.deck.comments.len();
        if let Some(entry) = self.deck.entries.last_mut() {
            entry.count += 1;
            self.deck.lines.push(line);
        }
    }

    fn error(&self, file: u32, line: u32, head: &str, message: &str) -> DeckError {
        let name = head.split(',').next().unwrap_or_default();
        DeckError {
            file: self.deck.sources[file as usize].name().to_string(),
            line: line as usize,
            card: shown(name.trim()).to_uppercase(),
            field: None,
            message: message.to_string(),
        }
    }

    fn keyword(&mut self, (file, line): (u32, u32), head: &str, read: &mut Read<'_>) -> Result<(), DeckError> {
        let mut parts = split(head).into_iter();
        let name: String = parts
            .next()
            .unwrap_or_default()
            .trim_start_matches('*')
            .chars()
            .filter(|c| !c.is_whitespace())
            .collect::<String>()
            .to_uppercase();
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.len() <= 64
            && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_/".contains(&b));
        if !is_name {
            return Err(self.error(file, line, "", &format!("`{}` is not the name of a keyword", shown(head))));
        }
        let mut parameters: Vec<Parameter> = Vec::new();
        for part in parts {
            let part = part.trim();
            if part.is_empty() {
                continue;
            }
            let (key, value) = match part.split_once('=') {
                Some((key, value)) => (key, Some(value.trim().to_string())),
                None => (part, None),
            };
            let key: String = key.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_uppercase();
            if parameters.iter().any(|p| p.name == key) {
                return Err(self.error(file, line, head, &format!("the parameter `{}` is defined twice", shown(&key))));
            }
            parameters.push(Parameter { name: key, value });
        }
        let input = parameters.iter().find(|p| p.name == "INPUT").map(|p| p.value.clone().unwrap_or_default());
        let count = self.deck.comments.len();
        let comments = (self.above as u32, count as u32);
        self.above = count;
        if name != "INCLUDE" {
            let first = self.deck.lines.len() as u32;
            self.deck.entries.push(Entry { name, parameters, file, line, first, count: 0, comments });
            return match input {
                Some(target) => self.include((file, line), head, &target, read, true),
                None => Ok(()),
            };
        }
        let Some(target) = input.filter(|t| !t.is_empty()) else {
            return Err(self.error(file, line, head, "the name of a file is missing: `*INCLUDE, INPUT=file`"));
        };
        self.include((file, line), head, &target, read, false)
    }

    fn include(
        &mut self,
        (file, line): (u32, u32),
        head: &str,
        target: &str,
        read: &mut Read<'_>,
        is_data: bool,
    ) -> Result<(), DeckError> {
        let name = target.trim().trim_matches(['\'', '"']).trim();
        let beside = self.deck.sources[file as usize].path().to_path_buf();
        let first = self.deck.sources[0].path().to_path_buf();
        let Some(path) = find(name, &beside, &first) else {
            let shown: String = name.chars().filter(|c| !c.is_control()).take(200).collect();
            return Err(self.error(file, line, head, &format!("there is no file `{shown}` beside the deck")));
        };
        let same = |p: &PathBuf| p.canonicalize().ok() == path.canonicalize().ok();
        if self.open.iter().any(same) {
            return Err(self.error(file, line, head, &format!("`{}` includes itself", path.display())));
        }
        if self.open.len() > DEEPEST {
            let text = format!("files include each other more than {DEEPEST} deep");
            return Err(self.error(file, line, head, &text));
        }
        self.file(&path, read, is_data)
    }
}

/// Parts between commas; a comma between quotation marks is part of a name.
fn split(text: &str) -> Vec<&str> {
    let mut parts = Vec::with_capacity(8);
    let (mut start, mut quoted) = (0, false);
    for (i, b) in text.bytes().enumerate() {
        match b {
            b'"' => quoted = !quoted,
            b',' if !quoted => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

impl<'a> Keyword<'a> {
    fn entry(&self) -> &'a Entry {
        &self.deck.entries[self.index]
    }

    /// Its place among the keywords of the deck.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Its name in capitals, without blanks: `SOLIDSECTION`.
    pub fn name(&self) -> &'a str {
        &self.entry().name
    }

    /// Value of a parameter, its name in capitals without blanks; empty for one without a value.
    pub fn parameter(&self, name: &str) -> Option<&'a str> {
        let found = self.entry().parameters.iter().find(|p| p.name == name);
        found.map(|p| p.value.as_deref().unwrap_or_default())
    }

    /// Names of its parameters.
    pub fn parameters(&self) -> impl Iterator<Item = &'a str> {
        self.entry().parameters.iter().map(|p| p.name.as_str())
    }

    /// A parameter that is a name, as decks compare them.
    pub fn label(&self, name: &str) -> Option<String> {
        self.parameter(name).filter(|v| !v.is_empty()).map(label)
    }

    /// A parameter that must be there and is a name.
    ///
    /// # Errors
    /// It is missing.
    pub fn needs(&self, name: &str) -> Result<String, DeckError> {
        self.label(name).ok_or_else(|| self.error(format_args!("the parameter {name} is missing: `{name}=...`")))
    }

    /// Number of its data lines.
    pub fn n_lines(&self) -> usize {
        self.entry().count as usize
    }

    /// A data line.
    pub fn line(&self, i: usize) -> Option<DataLine<'a>> {
        (i < self.n_lines()).then(|| {
            let line = self.deck.lines[self.entry().first as usize + i];
            DataLine { keyword: *self, line, items: split(self.deck.text(&line)) }
        })
    }

    /// A data line that must be there.
    ///
    /// # Errors
    /// It is missing.
    pub fn needs_line(&self, i: usize, holds: &str) -> Result<DataLine<'a>, DeckError> {
        self.line(i).ok_or_else(|| self.error(format_args!("its data line {} is missing: {holds}", i + 1)))
    }

    /// Its data lines.
    pub fn lines(&self) -> impl Iterator<Item = DataLine<'a>> + use<'a> {
        let own = *self;
        (0..self.n_lines()).filter_map(move |i| own.line(i))
    }

    /// Comments that stand right above it, without their stars.
    pub fn comments(&self) -> impl Iterator<Item = &'a str> {
        let (from, to) = self.entry().comments;
        let deck = self.deck;
        deck.comments[from as usize..to as usize].iter().map(|l| deck.text(l).trim().trim_start_matches('*').trim())
    }

    /// File and line at which it begins.
    pub fn place(&self) -> (&'a str, usize) {
        let entry = self.entry();
        (self.deck.sources[entry.file as usize].name(), entry.line as usize)
    }

    /// Its file, and the bytes from its name to the end of its last data line in that file.
    pub(super) fn span(&self) -> (u32, usize, usize) {
        let entry = self.entry();
        let text = self.deck.sources[entry.file as usize].text();
        let starts = |line: u32| text.split_inclusive('\n').take(line as usize - 1).map(str::len).sum::<usize>();
        let start = starts(entry.line);
        let own = &self.deck.lines[entry.first as usize..(entry.first + entry.count) as usize];
        let last = own.iter().rev().find(|l| l.file == entry.file).map(|l| l.end as usize);
        // Of a keyword without data: the lines that end with a comma, and the one behind them.
        let mut head = start;
        for line in text[start..].split_inclusive('\n') {
            head += line.len();
            if !line.trim_end().ends_with(',') {
                break;
            }
        }
        (entry.file, start, last.unwrap_or(head).min(text.len()))
    }

    /// Its lines as they stand in its file, data of other files not among them.
    pub fn text(&self) -> &'a str {
        let (file, start, end) = self.span();
        self.deck.sources[file as usize].text()[start..end].trim_end_matches(['\n', '\r'])
    }

    /// An error at it.
    pub fn error(&self, message: impl fmt::Display) -> DeckError {
        let (file, line) = self.place();
        let card = format!("*{}", self.name());
        DeckError { file: file.to_string(), line, card, field: None, message: message.to_string() }
    }
}

impl<'a> DataLine<'a> {
    /// Number of its items; what stands behind a last comma is none.
    pub fn len(&self) -> usize {
        self.items.iter().rposition(|t| !t.trim().is_empty()).map_or(0, |i| i + 1)
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The whole line.
    pub fn whole(&self) -> &'a str {
        self.keyword.deck.text(&self.line)
    }

    /// Whether it ends with a comma, and so goes on.
    pub fn goes_on(&self) -> bool {
        self.items.len() > 1 && self.items.last().is_some_and(|t| t.trim().is_empty())
    }

    /// An item, from 0; empty where there is none.
    pub fn text(&self, i: usize) -> &'a str {
        self.items.get(i).map_or("", |t| t.trim())
    }

    /// File and bytes of an item without the blanks around it; `None` where there is none.
    pub(super) fn span(&self, i: usize) -> Option<(u32, usize, usize)> {
        let item = self.items.get(i).filter(|t| !t.trim().is_empty())?;
        let before: usize = self.items[..i].iter().map(|t| t.len() + 1).sum();
        let start = self.line.start as usize + before + (item.len() - item.trim_start().len());
        Some((self.line.file, start, start + item.trim().len()))
    }

    /// An error at an item.
    pub fn error(&self, item: Option<(usize, &'static str)>, message: impl fmt::Display) -> DeckError {
        let mut error = self.keyword.error(message);
        error.file = self.keyword.deck.sources[self.line.file as usize].name().to_string();
        error.line = self.line.number as usize;
        error.field = item.map(|(i, name)| (i + 1, name));
        error
    }

    fn wrong(&self, i: usize, name: &'static str, expected: &str) -> DeckError {
        match self.text(i) {
            "" => self.error(Some((i, name)), format_args!("{expected} is missing")),
            text => self.error(Some((i, name)), format_args!("`{}` where {expected} is expected", shown(text))),
        }
    }

    /// An integer above zero.
    ///
    /// # Errors
    /// Anything else, nothing included.
    pub fn id(&self, i: usize, name: &'static str) -> Result<u32, DeckError> {
        match self.text(i).parse::<u32>() {
            Ok(id) if id > 0 => Ok(id),
            _ => Err(self.wrong(i, name, "an integer above zero")),
        }
    }

    /// A real number; `None` where there is none.
    ///
    /// # Errors
    /// Anything else than a finite number.
    pub fn optional_real(&self, i: usize, name: &'static str) -> Result<Option<f64>, DeckError> {
        let text = self.text(i);
        if text.is_empty() {
            return Ok(None);
        }
        // Fortran's exponents: 2.1D11.
        let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let value = match text.parse::<f64>() {
            Ok(value) => Some(value),
            Err(_) => text.replace(['d', 'D'], "e").parse().ok(),
        };
        value.filter(|v| begins && v.is_finite()).map(Some).ok_or_else(|| self.wrong(i, name, "a number"))
    }

    /// A real number.
    ///
    /// # Errors
    /// Anything else, nothing included.
    pub fn real(&self, i: usize, name: &'static str) -> Result<f64, DeckError> {
        self.optional_real(i, name)?.ok_or_else(|| self.wrong(i, name, "a number"))
    }

    /// A real number; `default` where there is none.
    ///
    /// # Errors
    /// Anything else than a finite number.
    pub fn real_or(&self, i: usize, name: &'static str, default: f64) -> Result<f64, DeckError> {
        Ok(self.optional_real(i, name)?.unwrap_or(default))
    }

    /// Three real numbers from an item on, zero where there is none.
    ///
    /// # Errors
    /// Anything else than finite numbers.
    pub fn vector(&self, i: usize, name: &'static str) -> Result<[f64; 3], DeckError> {
        Ok([self.real_or(i, name, 0.0)?, self.real_or(i + 1, name, 0.0)?, self.real_or(i + 2, name, 0.0)?])
    }
}
