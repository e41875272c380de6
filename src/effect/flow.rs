//! Values as one line of YAML: `{node: n8, mass: 2*m_tip}`.

use serde::Serialize;
use serde_json::Value;

/// A value as JSON, the tree that [`flow`] writes.
///
/// # Panics
/// If it has a map whose keys are not text: the types of a model file have none.
pub(super) fn value<T: Serialize>(value: &T) -> Value {
    serde_json::to_value(value).unwrap_or_else(|e| panic!("a type that a file cannot hold: {e}"))
}

/// In flow style, on one line.
pub(super) fn flow(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let entries: Vec<String> = map.iter().map(|(k, v)| format!("{}: {}", word(k), flow(v))).collect();
            format!("{{{}}}", entries.join(", "))
        }
        Value::Array(list) => format!("[{}]", list.iter().map(flow).collect::<Vec<_>>().join(", ")),
        Value::String(text) => word(text),
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), number),
        other => other.to_string(),
    }
}

/// A text, quoted where YAML would read it as something else.
pub(super) fn word(text: &str) -> String {
    const SPECIAL: &str = "-?:,[]{}#&*!|>'\"%@`=~<.0123456789+";
    let keyword = matches!(
        text.to_lowercase().as_str(),
        "" | "null" | "true" | "false" | "yes" | "no" | "on" | "off" | "y" | "n"
    );
    let first = text.chars().next().unwrap_or(' ');
    // A number with a unit (`3 kg`) or a term with a sign (`-m_tip`) is a plain word, a bare number is not.
    let numeric = text.parse::<f64>().is_ok() || text.starts_with("0x") || text.starts_with("0o");
    let plain_start = !SPECIAL.contains(first)
        || first.is_ascii_digit()
        || (matches!(first, '-' | '+' | '.')
            && text[1..].starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.'));
    let plain = plain_start
        && !keyword
        && !numeric
        && text == text.trim()
        && !text.contains(": ")
        && !text.ends_with(':')
        && !text.contains(" #")
        && !text.contains(|c: char| ",[]{}".contains(c) || c.is_control());
    if plain { text.to_string() } else { Value::String(text.to_string()).to_string() }
}

/// A number as people write it: shortest decimal that reads back equal, with an exponent where that is shorter.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_string()
    } else if (1e-4..1e7).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the text, YAML reads back what was meant.
    #[test]
    fn every_word_reads_back() {
        for text in [
            "n8",
            "left_wing.1:n5",
            "0 kg",
            "-0.3*p",
            "1 + p",
            "no",
            "n",
            "12",
            "1e3",
            "a: b",
            "a #b",
            "é",
            "x:",
            "-",
            "- a",
            "{a}",
            "a, b",
            "'q'",
            "\"q\"",
            "",
            " a",
            "line\nbreak",
            "0x1F",
            "*a",
            "&a",
            "!a",
            "@a",
            "~",
            ".5 m",
            "%",
        ] {
            let line = format!("k: [{}, {{{}: 1}}]", word(text), word(text));
            let (v, _) = crate::yaml::read::<Value>(&line).unwrap_or_else(|e| panic!("{line}: {e:?}"));
            assert_eq!(v["k"][0], Value::String(text.to_string()), "{line}");
            assert!(v["k"][1].get(text).is_some(), "{line}");
        }
    }
}
