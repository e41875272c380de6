//! The keys of a file format, from its JSON Schema: a table for the file and one for each kind of entry, at the place where it first stands.

use super::{cell, generated_by, paragraph, table};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, VecDeque};

/// The page of a file format.
///
/// * `schema` - JSON Schema, as schemars writes it: definitions in `$defs`, named by `$ref`
/// * `word` - the word of `retune schema`
pub(crate) fn keys(schema: &Value, word: &str, title: &str, introduction: &str) -> String {
    let mut pages = Pages { schema, place: BTreeMap::new(), waiting: VecDeque::new() };
    let mut out = generated_by(&format!("retune schema {word} --markdown"));
    out += &format!("\n# {title}\n\n{introduction}\n\n");
    // A file that is a list, or one of several forms, is told by what it holds.
    let root = match (schema.get("items"), schema.get("anyOf")) {
        (Some(items), _) => items,
        _ => schema,
    };
    out += &pages.object(root, "");
    while let Some((place, definition)) = pages.waiting.pop_front() {
        out += &format!("\n## `{place}`\n\n");
        if let Some(text) = definition.get("description").and_then(Value::as_str) {
            out += &format!("{}\n\n", described(text));
        }
        out += &pages.object(definition, &place);
    }
    out
}

/// A description: examples in it stay as they are.
fn described(text: &str) -> String {
    let mut is_code = false;
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            let is_fence = line.starts_with("```");
            is_code ^= is_fence;
            if is_code || is_fence { line.to_string() } else { paragraph(line) }
        })
        .collect();
    lines.join("\n")
}

struct Pages<'a> {
    schema: &'a Value,
    /// Where each definition is told.
    place: BTreeMap<String, String>,
    waiting: VecDeque<(String, &'a Value)>,
}

impl<'a> Pages<'a> {
    /// The table of the keys of an object, or the forms of something that has several.
    fn object(&mut self, object: &'a Value, place: &str) -> String {
        if let Some(properties) = object.get("properties").and_then(Value::as_object) {
            return self.properties(object, properties, place);
        }
        let forms = object.get("anyOf").or_else(|| object.get("oneOf")).and_then(Value::as_array);
        let mut rows = Vec::new();
        for form in forms.into_iter().flatten() {
            let text = form.get("description").and_then(Value::as_str).unwrap_or("");
            match form.get("properties").and_then(Value::as_object) {
                Some(named) => {
                    for (name, settings) in named {
                        let kind = self.kind(settings, &join(place, name));
                        rows.push(vec![format!("`{name}`"), kind, cell(text)]);
                    }
                }
                None => rows.push(vec![String::new(), self.kind(form, place), cell(text)]),
            }
        }
        table(&["key", "value", "what it is"], rows)
    }

    fn properties(&mut self, object: &'a Value, properties: &'a Map<String, Value>, place: &str) -> String {
        let required: Vec<&str> =
            object.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect();
        let rows: Vec<Vec<String>> = properties
            .iter()
            .map(|(name, value)| {
                let kind = self.kind(value, &join(place, name));
                let text = value.get("description").and_then(Value::as_str).unwrap_or("");
                let first = text.split("\n\n").next().unwrap_or("");
                let is_required = if required.contains(&name.as_str()) { " **required**" } else { "" };
                let default = match value.get("default") {
                    None | Some(Value::Null) => String::new(),
                    Some(Value::Object(o)) if o.is_empty() => String::new(),
                    Some(Value::Array(a)) if a.is_empty() => String::new(),
                    Some(value) => format!(" Default `{}`.", value.to_string().replace('"', "")),
                };
                vec![format!("`{name}`{is_required}"), kind, cell(first) + &default]
            })
            .collect();
        table(&["key", "value", "what it is"], rows)
    }

    /// What a value is, in words; a kind of entry that has keys of its own is told at `place`.
    fn kind(&mut self, value: &'a Value, place: &str) -> String {
        if let Some(name) = value.get("$ref").and_then(Value::as_str).and_then(|r| r.strip_prefix("#/$defs/")) {
            return self.reference(name, place);
        }
        if let Some(words) = value.get("enum").and_then(Value::as_array) {
            return words.iter().filter_map(Value::as_str).map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ");
        }
        if let Some(word) = value.get("const") {
            return format!("`{}`", word.to_string().trim_matches('"'));
        }
        if let Some(forms) = value.get("anyOf").or_else(|| value.get("oneOf")).and_then(Value::as_array) {
            let forms: Vec<String> = forms
                .iter()
                .filter(|f| f.get("type").is_none_or(|t| t != "null"))
                .map(|f| self.kind(f, place))
                .collect();
            return forms.join(" or ");
        }
        let kinds: Vec<&str> = match value.get("type") {
            Some(Value::String(one)) => vec![one],
            Some(Value::Array(several)) => several.iter().filter_map(Value::as_str).filter(|t| *t != "null").collect(),
            _ => Vec::new(),
        };
        let words: Vec<String> = kinds
            .iter()
            .map(|kind| match *kind {
                "array" => {
                    let items = value.get("items").map_or_else(String::new, |items| self.kind(items, place));
                    let n = value.get("maxItems").filter(|most| value.get("minItems") == Some(most));
                    let n = n.map_or_else(|| "list".to_string(), |n| format!("{n}"));
                    format!("{n} of: {items}")
                }
                "object" => match value.get("additionalProperties") {
                    Some(of @ Value::Object(_)) => {
                        let of = self.kind(of, &format!("{place}.NAME"));
                        format!("by name: {of}")
                    }
                    _ if value.get("properties").is_some() => match choice(value) {
                        Some(word) => format!("`{{{word}: number}}`"),
                        None => self.told(value, place),
                    },
                    _ => "map".to_string(),
                },
                "string" => "text".to_string(),
                "boolean" => "`true` or `false`".to_string(),
                "integer" => "whole number".to_string(),
                other => other.to_string(),
            })
            .collect();
        words.join(" or ")
    }

    fn reference(&mut self, name: &str, place: &str) -> String {
        let Some(definition) = self.schema.get("$defs").and_then(|all| all.get(name)) else { return name.to_string() };
        if name == "Scalar" {
            return "quantity".to_string();
        }
        if let Some(known) = self.place.get(name) {
            return format!("as [`{known}`](#{})", anchor(known));
        }
        if definition.get("properties").is_some() {
            self.place.insert(name.to_string(), place.to_string());
            return self.told(definition, place);
        }
        if let Some(forms) = definition.get("oneOf").and_then(Value::as_array).filter(|f| f.iter().all(is_word)) {
            return forms.iter().map(|f| self.kind(f, place)).collect::<Vec<_>>().join(", ");
        }
        // A form may hold itself, as a list of methods does.
        self.place.insert(name.to_string(), place.to_string());
        let kind = self.kind(definition, place);
        self.place.remove(name);
        kind
    }

    /// The keys of an entry have a section of their own.
    fn told(&mut self, definition: &'a Value, place: &str) -> String {
        let place = place.to_string();
        let link = format!("[`{place}`](#{})", anchor(&place));
        self.waiting.push_back((place, definition));
        link
    }
}

/// The word of a form that is one number under one word.
fn choice(form: &Value) -> Option<&str> {
    let properties = form.get("properties")?.as_object()?;
    let (word, value) = properties.iter().next().filter(|_| properties.len() == 1)?;
    value.get("type").filter(|kind| *kind == "number").map(|_| word.as_str())
}

fn is_word(form: &Value) -> bool {
    form.get("const").is_some()
}

fn join(place: &str, name: &str) -> String {
    if place.is_empty() { name.to_string() } else { format!("{place}.{name}") }
}

/// The anchor of a heading that is a place, as mdBook makes it.
fn anchor(place: &str) -> String {
    place.chars().filter(|c| c.is_alphanumeric() || matches!(c, '_' | '-')).collect::<String>().to_lowercase()
}
