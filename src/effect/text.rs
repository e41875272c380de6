//! Edits of the text of a model file that leave every other byte as it was: comments, order, spacing, line endings.
//!
//! An entry is added as a line at the end of its block, in the indentation of its siblings; a block that does not exist
//! is added in its usual place. Every result is read again and compared with what was meant.

use super::edit::{Edit, PatchError};
use super::flow::{self, flow, number, word};
use crate::catalogue::did_you_mean;
use crate::model::spec::{HistoryEntry, ModelSpec};
use crate::units::Scalar;
use crate::yaml::{self, SourceMap, child};
use serde_json::Value;
use std::ops::Range;

/// The blocks of a model file in their usual order.
const ORDER: [&str; 32] = [
    "retune",
    "name",
    "description",
    "active_dofs",
    "symmetry",
    "parameters",
    "frames",
    "lines",
    "mesh",
    "nodes",
    "node_offsets",
    "sections",
    "beams",
    "bars",
    "springs",
    "bushings",
    "masses",
    "elements",
    "superelements",
    "overrides",
    "rigid_links",
    "weighted_links",
    "ties",
    "supports",
    "preloads",
    "modal_damping",
    "constraints",
    "groups",
    "targets",
    "configurations",
    "imported",
    "history",
];

/// A line longer than this is broken into one line per key.
const WIDTH: usize = 120;

fn places(text: &str) -> Result<SourceMap, PatchError> {
    yaml::source_map(text).map_err(|p| PatchError::Unreadable(vec![p]))
}

/// The file, read; errors with their places.
fn read(text: &str) -> Result<(ModelSpec, SourceMap), PatchError> {
    yaml::read::<ModelSpec>(text).map_err(PatchError::Unreadable)
}

/// A text with edits, and with a history entry.
pub(super) fn add(text: &str, edits: &[Edit], history: Option<HistoryEntry>) -> Result<String, PatchError> {
    let (mut wanted, _) = read(text)?;
    edits.iter().try_for_each(|e| e.apply(&mut wanted))?;
    let mut out = text.to_string();
    let mut inserted = Vec::new();
    for edit in edits {
        out = insert_edit(&out, edit)?;
        inserted.push(child(&edit.block(), edit.name()));
    }
    if let Some(mut entry) = history {
        entry.inserted = inserted;
        out = insert(&out, "history", None, &flow::value(&entry))?;
        wanted.history.push(entry);
    }
    verify(&out, &wanted)?;
    Ok(out)
}

/// Adds one edit in its block; a block that a configuration has not yet is an entry of the configuration.
fn insert_edit(text: &str, edit: &Edit) -> Result<String, PatchError> {
    let block = edit.block();
    let name = (!matches!(edit, Edit::Without { .. })).then(|| edit.name());
    let value = edit.value();
    match edit {
        Edit::InConfiguration { configuration, .. } | Edit::Without { configuration, .. }
            if places(text)?.range(&block).is_none() =>
        {
            let parent = child("configurations", configuration);
            let whole = match name {
                Some(name) => Value::Object(serde_json::Map::from_iter([(name.to_string(), value)])),
                None => Value::Array(vec![value]),
            };
            insert(text, &parent, block.strip_prefix(&parent).map(|b| &b[1..]), &whole)
        }
        _ => insert(text, &block, name, &value),
    }
}

/// Whether a text says what it should.
fn verify(text: &str, wanted: &ModelSpec) -> Result<(), PatchError> {
    let why = "after the change it would read differently than it should; write the block with one entry a line";
    match read(text) {
        Ok((spec, _)) if spec == *wanted => Ok(()),
        _ => Err(PatchError::NotEditable { path: "the file".to_string(), why }),
    }
}

/// Adds an entry at the end of a block: `name: value` to a mapping, `- value` to a sequence.
fn insert(text: &str, block: &str, name: Option<&str>, value: &Value) -> Result<String, PatchError> {
    let map = places(text)?;
    let newline = newline(text);
    let Some(range) = map.range(block) else { return new_block(text, &map, block, name, value) };
    let last = map.children(block).last();
    let bracket = text[range.start..].chars().next().filter(|c| "{[".contains(*c));
    let mut out = text.to_string();
    if bracket.is_some() {
        let entry = name.map_or_else(|| flow(value), |name| format!("{}: {}", word(name), flow(value)));
        match last.and_then(|last| map.content_end(last, text)) {
            Some(end) => out.insert_str(end, &format!(", {entry}")),
            None => out.insert_str(range.start + 1, &entry),
        }
        return Ok(out);
    }
    let refused = || PatchError::NotEditable {
        path: block.to_string(),
        why: "write it as a block with one entry a line, or in brackets",
    };
    let last = last.ok_or_else(refused)?;
    let first = map.children(block).first().and_then(|c| map.key_start(c)).ok_or_else(refused)?;
    // The first entry of a sequence stands after its dash.
    let indent: String = text[line_start(text, first)..].chars().take_while(|c| *c == ' ').collect();
    let end = line_end(text, map.content_end(last, text).ok_or_else(refused)?);
    insert_lines(&mut out, end, &entry_lines(&indent, name, value), newline);
    Ok(out)
}

/// Adds a block with its first entry after the blocks that usually stand before it.
fn new_block(
    text: &str,
    map: &SourceMap,
    block: &str,
    name: Option<&str>,
    value: &Value,
) -> Result<String, PatchError> {
    let place = ORDER.iter().position(|b| *b == block).unwrap_or(ORDER.len());
    let blocks = map.children("");
    let before = blocks.iter().rev().find(|b| ORDER.iter().position(|o| o == b).is_some_and(|p| p < place));
    let refused = || PatchError::NotEditable {
        path: block.to_string(),
        why: "the whole file stands in brackets; write its blocks one below the other",
    };
    let start = map.key_start(before.or(blocks.first()).ok_or_else(refused)?).ok_or_else(refused)?;
    if start != line_start(text, start) {
        return Err(refused());
    }
    let at = match before {
        Some(b) => line_end(text, map.content_end(b, text).ok_or_else(refused)?),
        None => start,
    };
    let mut lines = if has_blank_lines(text, map) { vec![String::new()] } else { Vec::new() };
    lines.push(format!("{block}:"));
    lines.extend(entry_lines("  ", name, value));
    let mut out = text.to_string();
    insert_lines(&mut out, at, &lines, newline(text));
    Ok(out)
}

/// Whether the file separates its blocks by blank lines: whether one stands before any block but the first.
fn has_blank_lines(text: &str, map: &SourceMap) -> bool {
    map.children("").iter().skip(1).filter_map(|b| map.key_start(b)).any(|start| {
        // Comments right above a block belong to it.
        let mut above = text[..start].lines().rev().skip_while(|l| l.starts_with('#'));
        above.next().is_some_and(|l| l.trim().is_empty())
    })
}

/// An entry in block style: on one line if it is short enough, else one line per key.
fn entry_lines(indent: &str, name: Option<&str>, value: &Value) -> Vec<String> {
    let (head, deeper) = match name {
        Some(name) => (format!("{indent}{}:", word(name)), format!("{indent}  ")),
        None => (format!("{indent}-"), format!("{indent}  ")),
    };
    let line = format!("{head} {}", flow(value));
    match value {
        Value::Object(map) if line.chars().count() > WIDTH && !map.is_empty() => {
            let mut keys = map.iter().map(|(k, v)| format!("{}: {}", word(k), flow(v)));
            let mut lines = match name {
                Some(_) => vec![head],
                None => keys.next().map(|first| format!("{head} {first}")).into_iter().collect(),
            };
            lines.extend(keys.map(|k| format!("{deeper}{k}")));
            lines
        }
        _ => vec![line],
    }
}

/// Inserts whole lines at the start of a line, or after a last line without an end.
fn insert_lines(text: &mut String, at: usize, lines: &[String], newline: &str) {
    let lines = lines.join(newline);
    if at > 0 && !text[..at].ends_with('\n') {
        text.insert_str(at, &format!("{newline}{lines}"));
    } else {
        text.insert_str(at, &format!("{lines}{newline}"));
    }
}

fn newline(text: &str) -> &'static str {
    if text.contains("\r\n") { "\r\n" } else { "\n" }
}

fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |i| i + 1)
}

/// After the end of the line of a byte.
fn line_end(text: &str, at: usize) -> usize {
    text[at..].find('\n').map_or(text.len(), |i| at + i + 1)
}

/// What [`undo`] did.
#[derive(Debug, Clone, PartialEq)]
pub struct Undone {
    /// The text without what was added.
    pub text: String,
    /// The history entry that was undone.
    pub entry: HistoryEntry,
    /// Paths that it had inserted and that the user had removed meanwhile.
    pub missing: Vec<String>,
}

/// Takes out what the last `add` put in: byte for byte the text before, if nothing else changed since.
///
/// Values that were changed since (an update of the parameters) go with their entries. Errors: there is no history, or
/// something else in the file relies on what would be taken out.
pub fn undo(text: &str) -> Result<Undone, PatchError> {
    let (mut spec, _) = read(text)?;
    let entry = spec.history.pop().ok_or(PatchError::NoHistory)?;
    let mut out = remove(text, "history", &format!("history[{}]", spec.history.len()))?;
    let mut missing = Vec::new();
    let mut names = Vec::new();
    for path in entry.inserted.iter().rev() {
        let Some((configuration, block, name)) = parts(&spec, path) else { continue };
        names.push(name);
        let own = configuration.as_ref().map(|c| child("configurations", c));
        let whole = own.as_ref().map_or_else(|| block.to_string(), |own| child(own, block));
        let listed = configuration.as_ref().filter(|_| block == "without");
        let position = listed.and_then(|c| spec.configurations[c].without.iter().position(|n| n == name));
        let path = match (listed, position) {
            (Some(_), Some(k)) => format!("{whole}[{k}]"),
            _ => path.clone(),
        };
        let map = places(&out)?;
        if map.range(&path).is_none() {
            missing.push(path);
            continue;
        }
        out = match &own {
            // A block of a configuration goes with its last entry.
            Some(own) if map.children(&whole).len() == 1 => remove(&out, own, &whole)?,
            _ => remove(&out, &whole, &path)?,
        };
        match (configuration, block) {
            (Some(c), "without") => drop(spec.configurations[&c].without.remove(position.unwrap_or(0))),
            (Some(c), "masses") => drop(spec.configurations[&c].masses.shift_remove(name)),
            (Some(c), "springs") => drop(spec.configurations[&c].springs.shift_remove(name)),
            (Some(c), _) => drop(spec.configurations[&c].overrides.shift_remove(name)),
            (None, "parameters") => drop(spec.parameters.shift_remove(name)),
            (None, "nodes") => drop(spec.nodes.shift_remove(name)),
            (None, "node_offsets") => drop(spec.node_offsets.shift_remove(name)),
            (None, "masses") => drop(spec.masses.shift_remove(name)),
            (None, "springs") => drop(spec.springs.shift_remove(name)),
            (None, "elements") => drop(spec.elements.shift_remove(name)),
            (None, "overrides") => drop(spec.overrides.shift_remove(name)),
            (None, "supports") => drop(spec.supports.shift_remove(name)),
            (None, _) => drop(spec.rigid_links.shift_remove(name)),
        }
    }
    if let Some((path, name)) = still_used(&flow::value(&spec), "", &names) {
        return Err(PatchError::StillUsed { id: entry.add.clone(), path, name });
    }
    verify(&out, &spec)?;
    missing.reverse();
    Ok(Undone { text: out, entry, missing })
}

/// The configuration, the block and the name of an inserted path: `overrides.x`, `configurations.bench.overrides.x`.
fn parts<'a>(spec: &ModelSpec, path: &'a str) -> Option<(Option<String>, &'a str, &'a str)> {
    let Some(rest) = path.strip_prefix("configurations.") else {
        let (block, name) = path.split_once('.')?;
        return Some((None, block, name));
    };
    let inside = |c: &String| rest.strip_prefix(c.as_str()).and_then(|r| r.strip_prefix('.')?.split_once('.'));
    spec.configurations.keys().find_map(|c| inside(c).map(|(block, name)| (Some(c.clone()), block, name)))
}

/// The first place of a tree that names one of these.
fn still_used(value: &Value, path: &str, names: &[&str]) -> Option<(String, String)> {
    match value {
        Value::Object(map) => map.iter().find_map(|(k, v)| {
            let path = child(path, k);
            let key = names.contains(&k.as_str()).then(|| (path.clone(), k.clone()));
            key.or_else(|| still_used(v, &path, names))
        }),
        Value::Array(list) => list.iter().enumerate().find_map(|(i, v)| still_used(v, &format!("{path}[{i}]"), names)),
        Value::String(text) => {
            let scalar = Scalar::parse(text).ok();
            let named = scalar.iter().flat_map(Scalar::parameters).chain([text.as_str()]);
            named.into_iter().find(|n| names.contains(n)).map(|n| (path.to_string(), n.to_string()))
        }
        _ => None,
    }
}

/// The inverse of [`insert`]: takes out one entry, and the block where nothing is left of it.
fn remove(text: &str, block: &str, path: &str) -> Result<String, PatchError> {
    let map = places(text)?;
    let refused = || PatchError::NotEditable { path: path.to_string(), why: "it stands on a line with other entries" };
    let start = map.key_start(path).ok_or_else(refused)?;
    let end = map.content_end(path, text).ok_or_else(refused)?;
    let siblings = map.children(block);
    let index = siblings.iter().position(|s| s == path).ok_or_else(refused)?;
    let mut out = text.to_string();
    if map.range(block).is_some_and(|r| text[r.start..].starts_with(['{', '['])) {
        let previous = index.checked_sub(1).and_then(|i| map.content_end(&siblings[i], text));
        let next = siblings.get(index + 1).and_then(|s| map.key_start(s));
        out.replace_range(previous.unwrap_or(start)..if previous.is_some() { end } else { next.unwrap_or(end) }, "");
        return Ok(out);
    }
    let to = line_end(text, end);
    if siblings.len() > 1 {
        return Ok(cut(text, line_start(text, start), to));
    }
    let from = line_start(text, map.key_start(block).ok_or_else(refused)?);
    // The blank line before the block was added with it, if such a file gets one.
    let above = line_start(text, from.saturating_sub(1));
    if from > 0 && text[above..from].trim().is_empty() {
        let shorter = cut(text, above, to);
        if places(&shorter).is_ok_and(|map| has_blank_lines(&shorter, &map)) {
            return Ok(shorter);
        }
    }
    Ok(cut(text, from, to))
}

/// The text without these lines; where they are the last and have no line end, without the line end before them.
fn cut(text: &str, from: usize, to: usize) -> String {
    let mut head = &text[..from];
    if to == text.len() && !text.ends_with('\n') {
        head = head.strip_suffix('\n').unwrap_or(head);
        head = head.strip_suffix('\r').unwrap_or(head);
    }
    format!("{head}{}", &text[to..])
}

/// Writes new estimates of parameters into the text of a model file, in the unit in which each is written; comments and
/// everything else stay.
///
/// * `values` - name and SI value
///
/// Each number is the shortest decimal that reads back within 1e-15 of the value. Errors: an unknown name, a value that is
/// not finite, a value in the file that is an alias.
pub fn set_parameter_values(text: &str, values: &[(&str, f64)]) -> Result<String, PatchError> {
    let (spec, map) = read(text)?;
    let mut changes = Vec::new();
    for &(name, si) in values {
        let Some(parameter) = spec.parameters.get(name) else {
            let suggestion = did_you_mean(name, spec.parameters.keys().map(String::as_str));
            return Err(PatchError::UnknownParameter { name: name.to_string(), suggestion });
        };
        if !si.is_finite() {
            return Err(PatchError::NotFinite { name: name.to_string(), value: si });
        }
        let path = format!("parameters.{name}.value");
        let place = value_at(text, &map, &path, "the value is an alias; write the number itself")?;
        let old = &text[place.clone()];
        let unit = unit_text(&parameter.value);
        let factor = crate::units::Unit::parse(unit).map_or(1.0, |u| u.factor);
        let number = shortest(si, factor);
        let new = if unit.is_empty() { number } else { format!("{number} {unit}") };
        let quote = old.chars().next().filter(|c| matches!(c, '"' | '\''));
        changes.push((place, quote.map_or(new.clone(), |q| format!("{q}{new}{q}"))));
    }
    let out = replaced(text, changes);
    let (now, _) = read(&out)?;
    for &(name, si) in values {
        let si_of = |s: &Scalar| s.terms().iter().map(|t| t.factor).sum::<f64>();
        if now.parameters.get(name).is_none_or(|p| (si_of(&p.value) - si).abs() > 2e-15 * si.abs()) {
            let why = "the new value would read differently; write the value as one number with a unit";
            return Err(PatchError::NotEditable { path: format!("parameters.{name}.value"), why });
        }
    }
    Ok(out)
}

/// Where a value stands in the text.
///
/// # Errors
/// One that stands elsewhere: an alias, or what comes by a merge; one with an anchor or a tag. `why` is said of it.
fn value_at(text: &str, map: &SourceMap, path: &str, why: &'static str) -> Result<Range<usize>, PatchError> {
    let refused = || PatchError::NotEditable { path: path.to_string(), why };
    let start = map.range(path).ok_or_else(refused)?.start;
    let end = map.content_end(path, text).ok_or_else(refused)?;
    if text[start..end].starts_with(['*', '&', '!']) { Err(refused()) } else { Ok(start..end) }
}

/// The text with other values in some places.
fn replaced(text: &str, mut changes: Vec<(Range<usize>, String)>) -> String {
    changes.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
    let mut out = text.to_string();
    for (place, new) in changes {
        out.replace_range(place, &new);
    }
    out
}

/// The unit as written: `GPa` of `56 GPa`.
fn unit_text(s: &Scalar) -> &str {
    if s.terms().len() != 1 || s.terms()[0].dimension.is_none() {
        return "";
    }
    let text = s.text();
    let number = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | ' ' | 'e' | 'E')));
    number.map_or("", |end| text[end..].trim())
}

/// The shortest decimal d for which d times `factor` is `si` within 1e-15.
fn shortest(si: f64, factor: f64) -> String {
    let value = si / factor;
    (0..17)
        .map(|digits| format!("{value:.digits$e}").parse::<f64>().unwrap_or(value))
        .find(|v| (v * factor - si).abs() <= 1e-15 * si.abs())
        .map_or_else(|| number(value), number)
}

/// Keys under `mesh` and `superelements` whose value may be a path.
const PATHS: [&str; 7] = ["file", "k", "m", "c", "dofs", "nodes", "matrix"];

/// Gives the files that a model file names, a mesh and matrices, other paths, for it is to stand in another folder; everything else stays.
///
/// * `to` - what is to stand in the place of a path; none for what is not a file
///
/// # Errors
/// A text that is not a YAML; a path that is an alias.
pub fn move_files(text: &str, to: &dyn Fn(&str) -> Option<String>) -> Result<String, PatchError> {
    let (all, map) = yaml::read::<Value>(text).map_err(PatchError::Unreadable)?;
    let mut moved: Vec<(String, String)> = Vec::new();
    for block in ["mesh", "superelements"] {
        if let Some(value) = all.get(block) {
            find_files(value, block, to, &mut moved);
        }
    }
    let mut changes = Vec::new();
    for (path, new) in moved {
        let place = value_at(text, &map, &path, "the path is an alias; write it out")?;
        changes.push((place, Value::String(new).to_string()));
    }
    Ok(replaced(text, changes))
}

fn find_files(value: &Value, path: &str, to: &dyn Fn(&str) -> Option<String>, found: &mut Vec<(String, String)>) {
    match value {
        Value::Object(entries) => {
            // Nodes have names there, and none of them is a file.
            for (key, value) in entries.iter().filter(|(key, _)| *key != "attach") {
                let path = child(path, key);
                match value {
                    Value::String(file) if PATHS.contains(&key.as_str()) => {
                        found.extend(to(file).map(|new| (path, new)));
                    }
                    Value::String(_) => {}
                    _ => find_files(value, &path, to, found),
                }
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                find_files(value, &format!("{path}[{i}]"), to, found);
            }
        }
        _ => {}
    }
}
