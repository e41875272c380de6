//! Open lists: one member, one file, one line.
//!
//! `catalogue!` declares the members of a folder and the list that everything else iterates: the command line, the
//! documentation, the conformance tests. [`nearest`] finds the right word behind a misspelt one.

use std::borrow::Cow;

/// Declares a list of stateless members of a trait, each in a module of its own.
///
/// ```text
/// catalogue! { ELEMENTS: dyn Element;
///     bar::Bar,
///     beam::Beam,
/// }
/// ```
///
/// The modules themselves are declared beside the macro (`mod bar;`), so that `cargo fmt` sees them; the architecture
/// test checks that every file of the folder is listed.
#[macro_export]
macro_rules! catalogue {
    ($(#[$doc:meta])* $list:ident: dyn $trait:ident; $($module:ident::$member:ident),+ $(,)?) => {
        $(pub use $module::$member;)+
        $(#[$doc])*
        pub const $list: &[&dyn $trait] = &[$(&$member),+];
    };
}
pub use catalogue;

/// A closed list of alternatives, each with the word that chooses it in options, in files and from Python.
pub trait Choice: Copy + Sized + Send + Sync + 'static {
    /// What an alternative is, for messages: `cost`.
    const NOUN: &'static str;
    /// Every alternative with its word and what it does, in the order in which they are listed.
    const ALL: &'static [(Self, &'static str, &'static str)];

    /// The word of an alternative.
    fn word(self) -> &'static str;

    /// The alternative of a word.
    ///
    /// # Errors
    /// For any other word: the list, and the nearest word.
    fn parse(word: &str) -> Result<Self, String> {
        if let Some((member, ..)) = Self::ALL.iter().find(|(_, known, _)| *known == word) {
            return Ok(*member);
        }
        let words = || Self::ALL.iter().map(|(_, word, _)| *word);
        let list = words().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ");
        Err(format!("`{word}` is not a known {}; there are {list}{}", Self::NOUN, did_you_mean(word, words())))
    }
}

/// Gives the variants of an enum their words. One that is forgotten does not compile.
#[macro_export]
macro_rules! choice {
    ($type:ident, $noun:literal; $($variant:ident $word:literal $about:literal,)+) => {
        impl $crate::catalogue::Choice for $type {
            const NOUN: &'static str = $noun;
            const ALL: &'static [(Self, &'static str, &'static str)] = &[$((Self::$variant, $word, $about)),+];

            fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word),+
                }
            }
        }
    };
}
pub use choice;

/// Words longer than these are not typing errors.
const LONGEST: usize = 100;
/// Letters from which on a word may be the beginning of another.
const ABBREVIATION: usize = 4;

/// The candidate closest to `word`, if it is close enough to be what a typing error meant.
///
/// Closeness is the Damerau-Levenshtein distance, at most a third of the word's length (at least 1, at most 3; none for a
/// single letter), without regard to case. Ties go to the first candidate. Where none is so close, a word of four letters or more is taken for the
/// beginning of the only candidate that begins with it.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = word.chars().count();
    // Of one letter every other letter is a neighbour.
    let limit = if length > 1 { (length / 3).clamp(1, 3) } else { 0 };
    let lower = word.to_lowercase();
    let (mut closest, mut begun, mut n_begun) = (None, None, 0);
    for c in candidates {
        // The distance is at least the difference in length; and it takes the product of both lengths in memory.
        if length <= LONGEST && c.chars().count().abs_diff(length) <= limit {
            let distance = strsim::damerau_levenshtein(&lower, &c.to_lowercase());
            if distance <= limit && closest.is_none_or(|(least, _)| distance < least) {
                closest = Some((distance, c));
            }
        }
        if length >= ABBREVIATION && c.len() <= LONGEST && c.to_lowercase().starts_with(&lower) && begun != Some(c) {
            begun = Some(c);
            n_begun += 1;
        }
    }
    closest.map(|(_, c)| c).or(begun.filter(|_| n_begun == 1))
}

/// The clause "; did you mean `x`?" for an error message, or nothing.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, candidates).map_or_else(String::new, |c| format!("; did you mean `{c}`?"))
}

/// A count with its noun: `1 node`, `2 nodes`, `1 frequency`, `2 frequencies`.
pub fn counted(n: usize, noun: &str) -> String {
    format!("{n} {}", plural(n, noun))
}

/// A noun as it stands behind a count.
pub fn plural(n: usize, noun: &str) -> Cow<'_, str> {
    let vowel_before = |stem: &str| stem.ends_with(['a', 'e', 'o', 'u']);
    if n == 1 {
        Cow::Borrowed(noun)
    } else if let Some(stem) = noun.strip_suffix('y').filter(|stem| !vowel_before(stem)) {
        Cow::Owned(format!("{stem}ies"))
    } else if let Some(stem) = noun.strip_suffix("um") {
        Cow::Owned(format!("{stem}a"))
    } else if noun.ends_with(['s', 'x']) || noun.ends_with("ch") || noun.ends_with("sh") {
        Cow::Owned(format!("{noun}es"))
    } else {
        Cow::Owned(format!("{noun}s"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nouns_follow_their_count() {
        for (n, noun, expected) in [
            (1, "node", "1 node"),
            (0, "node", "0 nodes"),
            (2, "frequency", "2 frequencies"),
            (2, "array", "2 arrays"),
            (3, "spectrum", "3 spectra"),
            (2, "mass", "2 masses"),
        ] {
            assert_eq!(counted(n, noun), expected);
        }
    }

    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Wood {
        Oak,
        Beech,
    }
    choice! { Wood, "wood";
        Oak "oak" "Hard.",
        Beech "beech" "Harder.",
    }

    #[test]
    fn an_alternative_is_found_by_its_word_alone() {
        for (wood, word, _) in Wood::ALL {
            assert_eq!((Wood::parse(word), wood.word()), (Ok(*wood), *word));
        }
        let message = Wood::parse("beach").unwrap_err();
        assert_eq!(message, "`beach` is not a known wood; there are `oak`, `beech`; did you mean `beech`?");
    }

    #[test]
    fn the_nearest_word_is_found_and_far_ones_are_not() {
        let words = ["mass", "inertia", "offset"];
        assert_eq!(nearest("inertai", words), Some("inertia"));
        assert_eq!(nearest("MASS", words), Some("mass"));
        assert_eq!(nearest("stiffness", words), None);
        assert_eq!(did_you_mean("ofset", words), "; did you mean `offset`?");
        // The beginning of one word, not of several.
        let words = ["joint-flexibility", "joint-damping", "joints"];
        assert_eq!(nearest("joint-flex", words), Some("joint-flexibility"));
        assert_eq!(nearest("joint-", words), Some("joints"));
        assert_eq!(nearest("join", ["joint-flexibility", "joint-damping"]), None);
    }
}
