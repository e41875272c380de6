//! Reading YAML files: typed values by serde, and for every value the line and column where it stands.
//!
//! Shape errors (an unknown key, a wrong type) come from serde, one at a time, with their location. What only the
//! meaning of the file can show is reported by the rooms that know it as [`Problem`]s with a path such as
//! `beams.left_wing.chain[3]`; a [`SourceMap`] turns paths into lines and columns. This is the only place that names
//! the YAML crates. Merge keys, `<<: *anchor`, are understood.

mod merge;

use crate::catalogue::did_you_mean;
use saphyr_parser::{Event, Parser, ScalarStyle, ScanError, Span};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt;

/// How bad a problem is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The file can be used; an engineer wants to know.
    Warning,
    /// The file cannot be used.
    Error,
}

/// A place in a file, counted from one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// Something wrong or doubtful in a file, with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// How bad.
    pub severity: Severity,
    /// The path in the file, `beams.left_wing.chain[3]`; empty for the whole file.
    pub path: String,
    /// Where the path stands, when known.
    pub location: Option<Location>,
    /// What is wrong, what was expected, the nearest right word.
    pub message: String,
}

impl Problem {
    /// An error at a path.
    pub fn error(path: impl Into<String>, message: impl fmt::Display) -> Self {
        Self { severity: Severity::Error, path: path.into(), location: None, message: message.to_string() }
    }

    /// A warning at a path.
    pub fn warning(path: impl Into<String>, message: impl fmt::Display) -> Self {
        Self { severity: Severity::Warning, ..Self::error(path, message) }
    }

    /// `line:column: path: message`, without what is unknown.
    pub fn render(&self, file: &str) -> String {
        let mut text = file.to_string();
        if let Some(at) = self.location {
            text += &format!(":{}:{}", at.line, at.column);
        }
        text += match self.severity {
            Severity::Error => ": error: ",
            Severity::Warning => ": warning: ",
        };
        if !self.path.is_empty() {
            text += &self.path;
            text += ": ";
        }
        text + &self.message
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render("input"))
    }
}

/// Where every value and key of a YAML text stands.
#[derive(Debug, Clone, Default)]
pub struct SourceMap {
    places: BTreeMap<String, Entry>,
    /// Path of a mapping or sequence -> paths of its entries, in file order.
    children: BTreeMap<String, Vec<String>>,
    /// What stands in the text elsewhere than its path says: behind a merge key or an alias.
    elsewhere: BTreeMap<String, Location>,
    has_merges: bool,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    key: Location,
    /// Byte where the key stands, or the value where there is no key.
    key_start: usize,
    /// Byte range of the value in the text.
    start: usize,
    end: usize,
}

impl SourceMap {
    /// The places in a YAML text; empty where it is not well formed.
    pub fn of(text: &str) -> Self {
        source_map(text).unwrap_or_default()
    }

    /// The place of a path, or of its nearest ancestor that stands in the file.
    pub fn locate(&self, path: &str) -> Option<Location> {
        let mut path = path;
        loop {
            if let Some(at) = self.places.get(path).map(|e| e.key).or_else(|| self.elsewhere.get(path).copied()) {
                return Some(at);
            }
            path = &path[..path.rfind(['.', '['])?];
        }
    }

    /// Byte range of the value at a path.
    pub fn range(&self, path: &str) -> Option<std::ops::Range<usize>> {
        self.places.get(path).map(|e| e.start..e.end)
    }

    /// Byte where the key of a path starts; for an entry of a sequence, where the value starts.
    pub fn key_start(&self, path: &str) -> Option<usize> {
        self.places.get(path).map(|e| e.key_start)
    }

    /// Paths of the entries of a mapping or sequence, in file order; empty for anything else.
    pub fn children(&self, path: &str) -> &[String] {
        self.children.get(path).map_or(&[], Vec::as_slice)
    }

    /// Byte where the content of a value ends: after its last scalar or closing bracket, before what follows in the file.
    pub fn content_end(&self, path: &str, text: &str) -> Option<usize> {
        let entry = self.places.get(path)?;
        // The parser ends a collection at the next token, after comments: count from the end of its last entry instead.
        let last = self.children(path).last().map(|last| self.content_end(last, text));
        match (text[entry.start..].chars().next(), last) {
            (Some('{' | '['), last) => closing_bracket(text, last.flatten().unwrap_or(entry.start + 1)),
            (Some(quote @ ('"' | '\'')), None) => Some(closing_quote(text, entry.start, quote)),
            (_, None) => Some(entry.start + text[entry.start..entry.end].trim_end().len()),
            (_, Some(last)) => last,
        }
    }

    /// Fills in the places of problems.
    #[must_use]
    pub fn place(&self, mut problems: Vec<Problem>) -> Vec<Problem> {
        for p in &mut problems {
            p.location = p.location.or_else(|| self.locate(&p.path));
        }
        problems
    }
}

/// Where the bracket ends that closes a collection after its last entry; comments may stand between.
fn closing_bracket(text: &str, from: usize) -> Option<usize> {
    let mut comment = false;
    text.bytes().enumerate().skip(from).find_map(|(i, b)| {
        comment = match b {
            b'#' => true,
            b'\n' => false,
            _ => comment,
        };
        (!comment && matches!(b, b'}' | b']')).then_some(i + 1)
    })
}

/// Where a quoted scalar ends; `""` has escapes, and in `''` a doubled quote is one.
fn closing_quote(text: &str, start: usize, quote: char) -> usize {
    let mut escaped = false;
    let mut bytes = text.bytes().enumerate().skip(start + 1).peekable();
    while let Some((i, b)) = bytes.next() {
        if escaped {
            escaped = false;
        } else if b == b'\\' && quote == '"' {
            escaped = true;
        } else if char::from(b) == quote {
            if quote == '\'' && bytes.peek().is_some_and(|(_, b)| *b == b'\'') {
                escaped = true;
            } else {
                return i + 1;
            }
        }
    }
    text.len()
}

/// The path of a key below a path.
pub fn child(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}

/// The text of a file that a person wrote: UTF-8, without the mark that editors of Windows put before it.
///
/// # Errors
/// What the bytes are instead.
pub fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    let text = String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let line = std::str::from_utf8(&e.as_bytes()[..at]).unwrap_or_default().matches('\n').count() + 1;
        match wide(e.as_bytes()) {
            Some(found) => format!("it is {found}, not UTF-8; save it as UTF-8"),
            None if e.as_bytes().contains(&0) => "it is a binary file, not text".to_string(),
            None => format!(
                "it is not UTF-8 text (byte {at}, line {line}) but perhaps Windows-1252 or Latin-1; save it as UTF-8"
            ),
        }
    })?;
    if let Some(found) = wide(text.as_bytes()) {
        return Err(format!("it is {found}, not UTF-8; save it as UTF-8"));
    }
    if let Some(at) = text.find('\0') {
        return Err(format!("it is not text: byte {at} is zero"));
    }
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// The encoding of text with two or four bytes a letter, which Windows calls Unicode: by its mark, or by every other byte being zero.
fn wide(bytes: &[u8]) -> Option<&'static str> {
    let zeros = |phase: usize| bytes.iter().take(64).skip(phase).step_by(2).filter(|b| **b == 0).count();
    let most = bytes.len().min(64) / 2;
    match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] => Some("UTF-16 (little endian)"),
        [0xfe, 0xff, ..] => Some("UTF-16 (big endian)"),
        _ if most >= 2 && zeros(1) * 10 >= most * 9 && zeros(0) == 0 => {
            Some("UTF-16 (little endian) without a byte order mark")
        }
        _ if most >= 2 && zeros(0) * 10 >= most * 9 && zeros(1) == 0 => {
            Some("UTF-16 (big endian) without a byte order mark")
        }
        _ => None,
    }
}

/// Reads a YAML text as a value of type `T`, with the places of everything in it.
///
/// Errors: the YAML is not well formed, a key is defined twice, the shape does not fit `T`.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<(T, SourceMap), Vec<Problem>> {
    let mut map = source_map(text).map_err(|p| vec![p])?;
    if !map.has_merges {
        let value = serde_yaml::from_str::<T>(text).map_err(|e| vec![shape_error(&e, &map, None)])?;
        return Ok((value, map));
    }
    let written = merge::expanded(text).map_err(|p| vec![p])?;
    map.elsewhere = written.places;
    let value =
        serde_yaml::from_str::<T>(&written.text).map_err(|e| vec![shape_error(&e, &map, Some(&written.lines))])?;
    Ok((value, map))
}

/// The problems of a file, or instead of them `message` where the key at its top tells that it is of another kind.
pub fn mistaken(text: &str, problems: Vec<Problem>, key: &str, message: &str) -> Vec<Problem> {
    match SourceMap::of(text).places.get(key) {
        Some(entry) => vec![Problem { location: Some(entry.key), ..Problem::error(key, message) }],
        None => problems,
    }
}

/// Why a file of this version of its format is not read; nothing where it is the one that is known.
///
/// * `key` - the key at the top of the file that states the version
pub fn version_problem(key: &str, found: u64, known: u32) -> Option<Problem> {
    let message = match found {
        _ if found == u64::from(known) => return None,
        0 => format!("formats begin with version 1, and this program reads version {known}"),
        _ => format!(
            "the file is written in version {found} of the format, and this program reads version {known}; a newer retune reads it"
        ),
    };
    Some(Problem::error(key, message))
}

/// The problems of a file, or instead of them that it is of another version: then its other keys may mean what they like.
pub fn outdated(text: &str, problems: Vec<Problem>, key: &str, known: u32) -> Vec<Problem> {
    // The line alone is looked at: what stands beside it may be of any depth.
    let version =
        |line: &str| line.strip_prefix(key)?.trim_start().strip_prefix(':')?.split('#').next()?.trim().parse().ok();
    let found: Option<u64> = text.lines().find_map(version);
    match found.and_then(|found| version_problem(key, found, known)) {
        Some(problem) => SourceMap::of(text).place(vec![problem]),
        None => problems,
    }
}

/// Writes a value as YAML.
///
/// # Panics
/// If a key of a map is not a string or a number: the types of this crate have none.
pub fn write<T: serde::Serialize>(value: &T) -> String {
    serde_yaml::to_string(value).unwrap_or_else(|e| panic!("a type that YAML cannot hold: {e}"))
}

/// serde's message, with its path split off and the nearest word added; `lines` is where the lines of a text that was written out
/// stand in the file.
fn shape_error(error: &serde_yaml::Error, map: &SourceMap, lines: Option<&[Location]>) -> Problem {
    let text = error.to_string();
    let text = text.rfind(" at line ").map_or(text.as_str(), |i| &text[..i]);
    let (path, message) = match text.split_once(": ") {
        Some((path, rest)) if !path.contains([' ', '`']) => (path.to_string(), rest.to_string()),
        _ => (String::new(), text.to_string()),
    };
    let mut quoted = message.split('`').skip(1).step_by(2);
    let mut path = path;
    let mut suggestion = String::new();
    if message.starts_with("unknown field") || message.starts_with("unknown variant") {
        let word = quoted.next().unwrap_or_default().to_string();
        suggestion = did_you_mean(&word, quoted);
        if message.starts_with("unknown field") {
            path = child(&path, &word);
        }
    }
    let location = error.location().and_then(|l| match lines {
        Some(lines) => lines.get(l.line().saturating_sub(1)).copied(),
        None => Some(Location { line: l.line(), column: l.column() }),
    });
    let at_path = map.places.get(&path).map(|e| e.key).or_else(|| map.elsewhere.get(&path).copied());
    Problem {
        severity: Severity::Error,
        location: at_path.or(location).or_else(|| map.locate(&path)),
        path,
        message: in_words(&message) + &suggestion,
    }
}

/// serde's words for types as those of people who write YAML.
fn in_words(message: &str) -> String {
    for (theirs, ours) in
        [("unknown field", "unknown key"), ("unknown variant", "unknown word"), ("missing field", "missing key")]
    {
        if let Some(rest) = message.strip_prefix(theirs) {
            return format!("{ours}{rest}");
        }
    }
    let Some((kind, expected)) = message.split_once(", expected ") else { return message.to_string() };
    let found =
        if let Some(found) = kind.strip_prefix("invalid type: ").or_else(|| kind.strip_prefix("invalid value: ")) {
            match found.split_once(' ').unwrap_or((found, "")) {
                ("sequence", _) => "a list".to_string(),
                ("map", _) => "a map `{key: value}`".to_string(),
                ("unit", _) => "nothing".to_string(),
                ("string", text) => format!("the text `{}`", text.trim_matches('"')),
                ("integer", number) => format!("the number {number}"),
                ("floating", number) => format!("the number {}", number.trim_start_matches("point ")),
                ("boolean", word) => format!("the word {word}"),
                _ => found.to_string(),
            }
        } else if let Some(count) = kind.strip_prefix("invalid length ") {
            format!("{count} value{}", if count == "1" { "" } else { "s" })
        } else {
            return message.to_string();
        };
    let length = expected
        .strip_prefix("an array of length ")
        .or_else(|| expected.strip_prefix("a tuple of size "))
        .or_else(|| expected.strip_prefix("sequence of ").and_then(|e| e.strip_suffix(" elements")));
    let expected = match (expected, length) {
        (_, Some(length)) => format!("a list of {length}"),
        ("f64", _) => "a number".to_string(),
        ("u32" | "u64" | "usize", _) => "a whole number, zero or above".to_string(),
        ("a string", _) => "a text".to_string(),
        ("a sequence", _) => "a list `[...]`".to_string(),
        ("a map", _) => "a map `{name: ...}`".to_string(),
        (e, _) if e.starts_with("struct ") => "a map `{key: value, ...}`".to_string(),
        (e, _) => e.to_string(),
    };
    let hint = if found == "the text `NaN`" || found == "the text `nan`" { "; a missing value is `.nan`" } else { "" };
    format!("found {found}, expected {expected}{hint}")
}

/// Nesting beyond this is not a file that a person wrote; paths would grow with its square.
const DEEPEST: usize = 64;

/// An alias inside what it names, if this is one.
fn cycle(event: &Event<'_>, anchors: &[usize], place: Location, text: &str) -> Result<(), Problem> {
    let Event::Alias(anchor) = event else { return Ok(()) };
    if !anchors.contains(anchor) {
        return Ok(());
    }
    let message = format!("the alias `{text}` stands inside what it names, which would never end");
    Err(Problem { location: Some(place), ..Problem::error("", message) })
}

/// A decimal comma, `A: 28,48 cm2` between braces: what stands behind the comma is a key without a value there.
///
/// * `key` - byte where it begins; `end` - where it ends
/// * `before` - the entry before it, by its path
fn decimal_comma(text: &str, (key, end): (usize, usize), before: Option<(&String, &Entry)>) -> Option<Problem> {
    let (path, entry) = before?;
    let rest = text.get(key..end)?.trim_end();
    let whole = text.get(entry.start..key)?.strip_suffix(',')?;
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    if !(is_digit(rest.chars().next()) && is_digit(whole.chars().next_back())) {
        return None;
    }
    let message =
        format_args!("`{whole},{rest}`: a comma begins a new entry; write decimals with a point, `{whole}.{rest}`");
    Some(Problem { location: Some(entry.key), ..Problem::error(path.clone(), message) })
}

/// What the builder of a [`SourceMap`] is inside of.
enum Frame {
    Sequence { path: String, index: usize },
    Mapping { path: String, key: Option<(String, Location, usize)> },
}

fn location(span: &Span) -> Location {
    Location { line: span.start.line(), column: span.start.col() + 1 }
}

/// For a key without its colon, which the parser sees only at the line that follows.
fn key_without_colon(text: &str, e: &ScanError) -> Option<Problem> {
    if !e.info().starts_with("simple key expect") {
        return None;
    }
    let is_content = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let before = text.lines().enumerate().take(e.marker().line().saturating_sub(1));
    let (number, line) = before.filter(|(_, line)| is_content(line)).last()?;
    let word = line.split_whitespace().next()?;
    let what = "expected `key: value`; a `:` and a blank end the key";
    let mut p = Problem::error("", format_args!("this is not YAML: no `: ` follows `{word}`, {what}"));
    p.location = Some(Location { line: number + 1, column: line.len() - line.trim_start().len() + 1 });
    Some(p)
}

/// Where everything in a text stands, whatever type it is.
///
/// Errors: the YAML is not well formed, a key is defined twice.
pub fn source_map(text: &str) -> Result<SourceMap, Problem> {
    let mut map = SourceMap::default();
    let mut stack: Vec<Frame> = Vec::new();
    // Byte offset of each character: the parser counts characters.
    let mut offsets: Vec<usize> = text.char_indices().map(|(i, _)| i).collect();
    offsets.push(text.len());
    let byte = |index: usize| offsets[index.min(offsets.len() - 1)];
    let mut open: Vec<(String, Entry)> = Vec::new();
    // Of the collections that are open: their anchors.
    let mut anchors: Vec<usize> = Vec::new();
    let mut n_documents = 0;
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|e| {
            let mark = e.marker();
            if let Some(p) = key_without_colon(text, &e) {
                return p;
            }
            // The innermost `[` or `{` that is still open is a likely culprit.
            let unclosed = open.iter().rev().find(|o| matches!(text.as_bytes().get(o.1.start), Some(b'[' | b'{')));
            let hint = unclosed.map_or_else(String::new, |(_, Entry { start, .. })| {
                let before = &text[..*start];
                let (line, column) =
                    (before.matches('\n').count() + 1, before.chars().rev().take_while(|c| *c != '\n').count() + 1);
                format!("; the `{}` at {line}:{column} is not closed", &text[*start..=*start])
            });
            let mut p = Problem::error("", format_args!("this is not YAML: {}{hint}", e.info()));
            p.location = Some(Location { line: mark.line(), column: mark.col() + 1 });
            p
        })?;
        match event {
            Event::Scalar(..) | Event::Alias(_) | Event::SequenceStart(..) | Event::MappingStart(..) => {
                let here = location(&span);
                let scalar = matches!(event, Event::Scalar(..) | Event::Alias(_));
                let (start, end) = (byte(span.start.index()), byte(span.end.index()));
                cycle(&event, &anchors, here, text[start..end].trim())?;
                let parent = match stack.last() {
                    Some(Frame::Sequence { path, .. } | Frame::Mapping { path, .. }) => Some(path.clone()),
                    None => None,
                };
                let (path, key, key_start) = match stack.last_mut() {
                    None => (String::new(), here, start),
                    Some(Frame::Sequence { path, index }) => {
                        *index += 1;
                        (format!("{path}[{}]", *index - 1), here, start)
                    }
                    Some(Frame::Mapping { path, key: key @ None }) => {
                        let Event::Scalar(name, ..) = &event else {
                            let mut p = Problem::error(path.clone(), "a key must be a plain word");
                            p.location = Some(here);
                            return Err(p);
                        };
                        let full = child(path, name);
                        if map.places.contains_key(&full) {
                            let mut p = Problem::error(full, format_args!("the key `{name}` is given twice here"));
                            p.location = Some(here);
                            return Err(p);
                        }
                        map.has_merges |= name == merge::KEY;
                        *key = Some((full, here, start));
                        continue;
                    }
                    Some(Frame::Mapping { key, .. }) => key.take().unwrap_or((String::new(), here, start)),
                };
                if matches!(&event, Event::Scalar(value, ScalarStyle::Plain, ..) if value.is_empty()) {
                    let before = parent.as_ref().and_then(|p| map.children.get(p)?.last());
                    let before = before.and_then(|p| map.places.get_key_value(p));
                    if let Some(problem) = decimal_comma(text, (key_start, start), before) {
                        return Err(problem);
                    }
                }
                let entry = Entry { key, key_start, start, end };
                map.places.insert(path.clone(), entry);
                if let Some(parent) = parent {
                    map.children.entry(parent).or_default().push(path.clone());
                }
                if !scalar {
                    if stack.len() == DEEPEST {
                        let mut p = Problem::error("", format_args!("nested more than {DEEPEST} levels deep"));
                        p.location = Some(here);
                        return Err(p);
                    }
                    open.push((path.clone(), entry));
                    if let Event::SequenceStart(anchor, _) | Event::MappingStart(anchor, _) = &event {
                        anchors.push(*anchor);
                    }
                    stack.push(match event {
                        Event::SequenceStart(..) => Frame::Sequence { path, index: 0 },
                        _ => Frame::Mapping { path, key: None },
                    });
                }
            }
            Event::SequenceEnd | Event::MappingEnd => {
                stack.pop();
                anchors.pop();
                if let Some((path, entry)) = open.pop() {
                    map.places.insert(path, Entry { end: byte(span.end.index()), ..entry });
                }
            }
            Event::DocumentStart(..) => {
                n_documents += 1;
                if n_documents > 1 {
                    let mut p = Problem::error("", "a second document begins here (`---`); a file holds one");
                    p.location = Some(location(&span));
                    return Err(p);
                }
            }
            _ => {}
        }
    }
    if map.places.is_empty() {
        return Err(Problem::error("", "the file is empty"));
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Beam {
        chain: Vec<String>,
        #[serde(default)]
        length: f64,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct File {
        #[expect(dead_code, reason = "only its shape matters here")]
        beams: BTreeMap<String, Beam>,
    }

    #[test]
    fn every_value_has_its_place() {
        let text = "# comment é\nbeams:\n  left: {chain: [a, bé,\n    c]}\n";
        let (_, map) = read::<File>(text).unwrap();
        assert_eq!(map.locate("beams.left.chain[2]"), Some(Location { line: 4, column: 5 }));
        assert_eq!(map.locate("beams.left.chain[9]"), Some(Location { line: 3, column: 10 }));
        assert_eq!(map.locate("beams.left.nothing"), Some(Location { line: 3, column: 3 }));
        let range = map.range("beams.left.chain[1]").unwrap();
        assert_eq!(&text[range], "bé");
        let range = map.range("beams.left.chain").unwrap();
        assert_eq!(&text[range], "[a, bé,\n    c]");
    }

    #[test]
    fn wrong_shapes_say_where_and_what() {
        for (text, expected) in [
            (
                "beams:\n  a: {chian: [x]}\n",
                "f:2:7: error: beams.a.chian: unknown key `chian`, expected `chain` or `length`; did you mean `chain`?",
            ),
            (
                "beams:\n  a: {chain: [x], length: two}\n",
                "f:2:19: error: beams.a.length: found the text `two`, expected a number",
            ),
            ("beams:\n  a: {length: 2}\n", "f:2:3: error: beams.a: missing key `chain`"),
            ("beams: {a: {chain: []}}\nbeams: {}\n", "f:2:1: error: beams: the key `beams` is given twice here"),
            (
                "beams:\n  a: {chain: [x]}\n  b\nmore: {}\n",
                "f:3:3: error: this is not YAML: no `: ` follows `b`, expected `key: value`; a `:` and a blank end the key",
            ),
            (
                "beams: [a\n",
                "f:2:1: error: this is not YAML: while parsing a flow sequence, expected ',' or ']'; the `[` at 1:8 is not closed",
            ),
        ] {
            let e = read::<File>(text).unwrap_err();
            assert_eq!(e[0].render("f"), expected);
        }
        for text in ["beams: {a: {length: 28,48 cm2}}\n", "beams: {a: {length: 28,48 cm2, chain: []}}\n"] {
            assert_eq!(
                read::<File>(text).unwrap_err()[0].render("f"),
                "f:1:13: error: beams.a.length: `28,48 cm2`: a comma begins a new entry; write decimals with a point, `28.48 cm2`"
            );
        }
    }

    #[test]
    fn the_content_of_a_quoted_text_ends_at_its_quote() {
        let text = "a: \"x \\\" y\" # why\nb: 'it''s' # so\n";
        let map = source_map(text).unwrap();
        let end = |path: &str| &text[map.range(path).unwrap().start..map.content_end(path, text).unwrap()];
        assert_eq!(end("a"), "\"x \\\" y\"");
        assert_eq!(end("b"), "'it''s'");
    }

    #[test]
    fn the_content_of_a_block_ends_before_what_follows() {
        let text = "a:\n  b: {c: 1} # why\n  d: >\n    two\n    lines\n\n# next\ne:\n  - x\n  - {y: 2}\n\n# end\n";
        let (_, map) = read::<serde_yaml::Value>(text).unwrap();
        assert_eq!(map.children(""), ["a", "e"]);
        assert_eq!(map.children("a"), ["a.b", "a.d"]);
        let end = |path: &str| &text[map.key_start(path).unwrap()..map.content_end(path, text).unwrap()];
        assert_eq!(end("a.b"), "b: {c: 1}");
        assert_eq!(end("a"), "a:\n  b: {c: 1} # why\n  d: >\n    two\n    lines");
        assert_eq!(end("e"), "e:\n  - x\n  - {y: 2}");
    }
}
