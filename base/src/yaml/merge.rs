//! Merge keys: `<<: *anchor` takes the entries of another map, `<<: [*first, *second]` those of several.
//!
//! A file with merge keys is written out: every alias by what it names, every merge key by the entries that it brings and that do
//! not stand beside it. What stands beside it holds, and of several maps the first. Each line of the text written out knows the line
//! of the file that it comes from, so that errors name the place where a value really stands.
//!
//! Source: YAML, merge key language-independent type, version 1.1, 2005.

use super::{Location, Problem, child, location};
use saphyr_parser::{Event, Parser, ScalarStyle};
use std::collections::{BTreeMap, BTreeSet};

/// The key.
pub(super) const KEY: &str = "<<";
/// Aliases unfold to at most so many values, or ten times what the file holds: more is a mistake, or meant to do harm.
const MOST_VALUES: usize = 100_000;
const TOO_MANY: &str =
    "the aliases of the file unfold to more values than a file can need; nest fewer of them in one another";

/// A file written out.
#[derive(Debug, Default)]
pub(super) struct Expanded {
    /// The text, one value a line.
    pub(super) text: String,
    /// Where the value of each line stands in the file.
    pub(super) lines: Vec<Location>,
    /// Where the values of merged maps and of aliases stand, by path.
    pub(super) places: BTreeMap<String, Location>,
}

struct Node {
    at: Location,
    kind: Kind,
}

/// Key, where it stands, value.
type Entry = (String, Location, usize);

enum Kind {
    /// A scalar as it is written out.
    Scalar(String),
    Sequence(Vec<usize>),
    Mapping(Vec<Entry>),
    /// The node that an alias names.
    Alias(usize),
}

fn problem(at: Location, message: &str) -> Problem {
    Problem { location: Some(at), ..Problem::error("", message) }
}

/// Writes a text out that parses and has no cycles: [`source_map`](super::source_map) was there before.
pub(super) fn expanded(text: &str) -> Result<Expanded, Problem> {
    let nodes = nodes(text)?;
    let mut out = Writer { nodes: &nodes, out: Expanded::default(), left: MOST_VALUES.max(10 * nodes.len()) };
    if !nodes.is_empty() {
        out.write(0, "", None, 0)?;
    }
    Ok(out.out)
}

/// The nodes of a text, the whole of it first.
fn nodes(text: &str) -> Result<Vec<Node>, Problem> {
    let mut nodes: Vec<Node> = Vec::new();
    let mut anchors: BTreeMap<usize, usize> = BTreeMap::new();
    // Collections that are open, with the key that waits for its value.
    let mut open: Vec<(usize, Option<(String, Location)>)> = Vec::new();
    for event in Parser::new_from_str(text) {
        let Ok((event, span)) = event else { break };
        let at = location(&span);
        let (kind, anchor) = match event {
            Event::Scalar(value, style, anchor, tag) => {
                if let Some((i, key @ None)) = open.last_mut()
                    && matches!(nodes[*i].kind, Kind::Mapping(_))
                {
                    *key = Some((value.into_owned(), at));
                    continue;
                }
                let is_text = tag.is_some_and(|t| t.is_yaml_core_schema() && t.suffix == "str");
                let is_plain = style == ScalarStyle::Plain && !is_text;
                (Kind::Scalar(if is_plain { plain(&value) } else { quoted(&value) }), anchor)
            }
            Event::SequenceStart(anchor, _) => (Kind::Sequence(Vec::new()), anchor),
            Event::MappingStart(anchor, _) => (Kind::Mapping(Vec::new()), anchor),
            Event::Alias(anchor) => {
                let target = anchors.get(&anchor).copied();
                (Kind::Alias(target.ok_or_else(|| problem(at, "an alias names nothing"))?), 0)
            }
            Event::SequenceEnd | Event::MappingEnd => {
                open.pop();
                continue;
            }
            _ => continue,
        };
        let is_collection = matches!(kind, Kind::Sequence(_) | Kind::Mapping(_));
        let index = nodes.len();
        nodes.push(Node { at, kind });
        if let Some((parent, key)) = open.last_mut() {
            match &mut nodes[*parent].kind {
                Kind::Sequence(items) => items.push(index),
                Kind::Mapping(entries) => entries.extend(key.take().map(|(key, at)| (key, at, index))),
                _ => {}
            }
        }
        // An anchor that is open names what it stands in only once that is complete; the map of places has refused the others.
        if anchor > 0 {
            anchors.insert(anchor, index);
        }
        if is_collection {
            open.push((index, None));
        }
    }
    Ok(nodes)
}

/// A scalar that YAML reads by its look, as it is where that is safe between brackets; what else is a text.
fn plain(value: &str) -> String {
    let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '+' | '-' | '~');
    match value {
        "" => "~".to_string(),
        "-" => quoted(value),
        _ if value.chars().all(is_safe) && !value.starts_with("---") && !value.starts_with("...") => value.to_string(),
        _ => quoted(value),
    }
}

/// A text in double quotes.
fn quoted(value: &str) -> String {
    let mut out = String::from('"');
    for c in value.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() || matches!(c, '\u{feff}' | '\u{2028}' | '\u{2029}') => {
                out += &format!("\\U{:08x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

struct Writer<'n> {
    nodes: &'n [Node],
    out: Expanded,
    left: usize,
}

impl<'n> Writer<'n> {
    /// Follows aliases.
    fn target(&self, mut node: usize) -> usize {
        // An alias names a node before it.
        while let Kind::Alias(target) = self.nodes[node].kind {
            node = target;
        }
        node
    }

    /// Writes a node; `key` is where its key stands.
    fn write(&mut self, node: usize, path: &str, key: Option<Location>, depth: usize) -> Result<(), Problem> {
        let at = key.unwrap_or(self.nodes[node].at);
        self.left = self.left.checked_sub(1).ok_or_else(|| problem(at, TOO_MANY))?;
        if depth > super::DEEPEST {
            return Err(problem(at, &format!("nested more than {} levels deep", super::DEEPEST)));
        }
        self.out.places.insert(path.to_string(), at);
        let nodes = self.nodes;
        match &nodes[self.target(node)].kind {
            Kind::Scalar(text) => self.out.text += text,
            Kind::Sequence(items) => {
                self.begin('[', at);
                for (i, item) in items.iter().enumerate() {
                    self.write(*item, &format!("{path}[{i}]"), None, depth + 1)?;
                    self.end_of_line(",", at);
                }
                self.out.text.push(']');
            }
            Kind::Mapping(entries) => {
                self.begin('{', at);
                for (key, at, value) in self.merged(entries, depth)? {
                    self.out.text += &quoted(key);
                    self.out.text += ": ";
                    self.write(value, &child(path, key), Some(at), depth + 1)?;
                    self.end_of_line(",", at);
                }
                self.out.text.push('}');
            }
            Kind::Alias(_) => {}
        }
        Ok(())
    }

    fn begin(&mut self, bracket: char, at: Location) {
        self.out.text.push(bracket);
        self.end_of_line("", at);
    }

    fn end_of_line(&mut self, last: &str, at: Location) {
        self.out.text += last;
        self.out.text.push('\n');
        self.out.lines.push(at);
    }

    /// The entries of a map with those that its merge key brings, which come first.
    fn merged(&mut self, entries: &'n [Entry], depth: usize) -> Result<Vec<(&'n str, Location, usize)>, Problem> {
        let own = || entries.iter().filter(|e| e.0 != KEY).map(|(key, at, value)| (key.as_str(), *at, *value));
        let Some((_, at, value)) = entries.iter().find(|e| e.0 == KEY) else { return Ok(own().collect()) };
        let wrong = || problem(*at, "`<<` takes a map, as in `<<: *name`, or a list of maps, `<<: [*first, *second]`");
        if depth > super::DEEPEST {
            return Err(problem(*at, &format!("nested more than {} levels deep", super::DEEPEST)));
        }
        let nodes = self.nodes;
        let value = self.target(*value);
        let maps: Vec<usize> = match &nodes[value].kind {
            Kind::Mapping(_) => vec![value],
            Kind::Sequence(items) => items.iter().map(|i| self.target(*i)).collect(),
            _ => return Err(wrong()),
        };
        let mut seen: BTreeSet<&str> = own().map(|e| e.0).collect();
        let mut all = Vec::new();
        for map in maps {
            let Kind::Mapping(entries) = &nodes[map].kind else { return Err(wrong()) };
            for (key, at, value) in self.merged(entries, depth + 1)? {
                self.left = self.left.checked_sub(1).ok_or_else(|| problem(at, TOO_MANY))?;
                if seen.insert(key) {
                    all.push((key, at, value));
                }
            }
        }
        all.extend(own());
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Problem, read, source_map};
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Debug, Deserialize, PartialEq, Clone)]
    #[serde(deny_unknown_fields)]
    struct Section {
        name: String,
        #[serde(default)]
        width: f64,
        #[serde(default)]
        list: Vec<String>,
    }

    type File = BTreeMap<String, Section>;

    fn refused(text: &str) -> String {
        let problems: Vec<Problem> = read::<File>(text).unwrap_err();
        problems[0].render("f")
    }

    const TEXT: &str = "
a: &a {name: 12, width: 2.5, list: [x, 'y: z', \"q\\t\"]}
b: &b
  <<: *a
  width: 3
c: {<<: [{name: first}, *b], list: []}
d: *b
";

    #[test]
    fn entries_are_taken_and_what_stands_beside_holds() {
        let (file, map) = read::<File>(TEXT).unwrap();
        let list = ["x", "y: z", "q\t"].map(String::from).to_vec();
        let a = Section { name: "12".into(), width: 2.5, list };
        let b = Section { width: 3.0, ..a.clone() };
        assert_eq!((&file["a"], &file["b"], &file["d"]), (&a, &b, &b));
        assert_eq!(file["c"], Section { name: "first".into(), width: 3.0, list: Vec::new() });
        // Where the values stand: in the map that is merged, and in that beside it.
        let line = |path: &str| map.locate(path).unwrap().line;
        assert_eq!((line("b.name"), line("b.width"), line("b.list[1]"), line("c.width")), (2, 5, 2, 5));
        assert_eq!((line("d"), line("c.list")), (7, 6));
        assert_eq!(map.range("b.name"), None);
    }

    #[test]
    fn errors_name_the_line_where_the_value_stands() {
        assert_eq!(
            refused(&TEXT.replace("width: 2.5", "width: two").replace("width: 3", "list: []")),
            "f:2:18: error: a.width: found the text `two`, expected a number"
        );
        assert!(
            refused(&TEXT.replace("width: 3", "widht: 3")).starts_with("f:5:3: error: b.widht: unknown key `widht`")
        );
        assert_eq!(refused("a: &a {width: 1}\nb: {<<: *a}\n"), "f:1:1: error: a: missing key `name`");
        assert!(refused("a: {<<: 3}\n").starts_with("f:1:5: error: `<<` takes a map"));
        assert!(refused("a: {<<: [3]}\n").starts_with("f:1:5: error: `<<` takes a map"));
        assert!(refused("a: {<<: {name: x}, <<: {width: 1}}\n").contains("given twice"));
    }

    #[test]
    fn cycles_and_bombs_are_refused() {
        for text in ["a: &a {name: x, <<: *a}\n", "a: &a {name: x, list: [*a]}\n", "a: &a\n  name: [1, {b: *a}]\n"] {
            let said = source_map(text).unwrap_err().render("f");
            assert!(said.contains("`*a` stands inside what it names"), "{said}");
        }
        let mut text = String::from("l0: &l0 {name: x}\n");
        for k in 1..30 {
            text += &format!("l{k}: &l{k} {{name: [*l{}, *l{}]}}\n", k - 1, k - 1);
        }
        text += "z: {<<: *l0}\n";
        assert!(refused(&text).contains("unfold to more values"), "{}", refused(&text));
        // Merges of merges, which bring nothing new.
        let mut text = String::from("l0: &l0 {name: x}\n");
        for k in 1..40 {
            text += &format!("l{k}: &l{k} {{<<: [*l{}, *l{}]}}\n", k - 1, k - 1);
        }
        assert!(refused(&text).contains("unfold to more values"), "{}", refused(&text));
    }
}
