//! Names for what a deck numbers or calls by a word of its own.

use std::collections::HashSet;

/// A comment without the rules of signs at its ends.
pub(crate) fn heading(text: &str) -> &str {
    text.trim_matches(|c: char| "-=*#_+$!: ".contains(c) || c.is_whitespace())
}

/// A word for a key of a model file: letters, digits and `_`, beginning with a letter; `None` where nothing is left or it is a sentence.
pub(crate) fn slug(text: &str) -> Option<String> {
    /// A name and no sentence.
    const LONGEST: usize = 48;
    let mut out = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            out.push(c.to_ascii_lowercase());
        } else if !out.is_empty() && !out.ends_with('_') {
            out.push('_');
        }
    }
    let out = out.trim_end_matches('_').to_string();
    // Words that YAML reads as something else.
    let is_word = !matches!(out.as_str(), "yes" | "no" | "on" | "off" | "true" | "false" | "null" | "y" | "n");
    let begins = out.starts_with(|c: char| c.is_ascii_alphabetic());
    (out.len() >= 2 && out.len() <= LONGEST && begins && is_word).then_some(out)
}

/// Names that are taken.
#[derive(Debug, Clone, Default)]
pub(crate) struct Taken(HashSet<String>);

impl Taken {
    /// The name, or with a number behind it where it is taken.
    pub(crate) fn unique(&mut self, name: &str) -> String {
        if self.0.insert(name.to_string()) {
            return name.to_string();
        }
        let mut n = 2;
        loop {
            let next = format!("{name}_{n}");
            if self.0.insert(next.clone()) {
                return next;
            }
            n += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_become_words() {
        assert_eq!(heading("--- Left body flap ---"), "Left body flap");
        assert_eq!(slug("Left body flap"), Some("left_body_flap".to_string()));
        assert_eq!(slug("12 of"), None);
    }

    #[test]
    fn a_name_that_is_taken_gets_a_number() {
        let mut names = Taken::default();
        assert_eq!([names.unique("rib"), names.unique("rib"), names.unique("rib")], ["rib", "rib_2", "rib_3"]);
    }
}
