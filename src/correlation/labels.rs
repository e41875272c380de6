//! What the names of two modes say about whether they are one: evidence, never a constraint.

use crate::data::family_of_label;

/// ln of the odds that two names give where they say the same kind of motion and its number.
const SAME: f64 = 1.5;
/// The same where one of them does not tell the number or the direction.
const SAME_KIND: f64 = 0.5;
/// Another kind of motion, or another direction: one name of five or so is given by another rule than the model's.
const OTHER_KIND: f64 = -1.5;
/// Another symmetry: that is named wrongly less often.
const OTHER_FAMILY: f64 = -3.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Bending,
    Torsion,
    Extension,
    RigidBody,
    OnSprings,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Direction {
    ForeAft,
    Lateral,
    Vertical,
}

/// What a name tells; nothing where it tells nothing.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Label {
    text: String,
    family: Option<&'static str>,
    motion: Option<Motion>,
    direction: Option<Direction>,
    number: Option<u32>,
}

const ORDINALS: [&str; 9] = ["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth"];

/// Beginnings of words, the longer of two that begin alike first; `foreaft` stands for `fore-aft` and `fore aft`.
const MOTIONS: [(&str, Motion); 10] = [
    ("bend", Motion::Bending),
    ("flex", Motion::Bending),
    ("flap", Motion::Bending),
    ("tors", Motion::Torsion),
    ("twist", Motion::Torsion),
    ("sway", Motion::Bending),
    ("axial", Motion::Extension),
    ("exten", Motion::Extension),
    ("rigid", Motion::RigidBody),
    ("spring", Motion::OnSprings),
];
const DIRECTIONS: [(&str, Direction); 14] = [
    ("foreaft", Direction::ForeAft),
    ("inplane", Direction::ForeAft),
    ("chordwise", Direction::ForeAft),
    ("edgewise", Direction::ForeAft),
    ("leadlag", Direction::ForeAft),
    ("longitudinal", Direction::ForeAft),
    ("lateral", Direction::Lateral),
    ("sideways", Direction::Lateral),
    ("sway", Direction::Lateral),
    ("vertical", Direction::Vertical),
    ("outofplane", Direction::Vertical),
    ("flap", Direction::Vertical),
    ("heave", Direction::Vertical),
    ("plunge", Direction::Vertical),
];

impl Label {
    /// Reads a name such as `Sym 1st Bending`, `2nd Vertical Bending`, `first in-plane bending`, `S1B`, `2BZ`, `T1`.
    pub(crate) fn read(text: &str) -> Self {
        let lower = text.to_lowercase();
        let words: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
        // A word with the one and the two that follow: `in plane`, `out of plane`.
        let run = |i: usize, n: usize| words.get(i..i + n).map(<[&str]>::concat).unwrap_or_default();
        let runs: Vec<String> =
            (0..words.len()).flat_map(|i| (1..=3).map(move |n| (i, n))).map(|(i, n)| run(i, n)).collect();
        let begins = |start: &str| runs.iter().any(|r| r.starts_with(start));
        let mut out = Self {
            text: lower.trim().to_string(),
            family: family_of_label(text),
            motion: MOTIONS.iter().find(|m| begins(m.0)).map(|m| m.1),
            direction: DIRECTIONS.iter().find(|d| begins(d.0)).map(|d| d.1),
            number: words.iter().find_map(|w| ordinal(w)),
        };
        for word in &words {
            out.short(word);
        }
        out
    }

    /// A short name: `S1B`, `A2T`, `1BX`, `2B`, `B1`.
    fn short(&mut self, word: &str) {
        if word.len() > 5 || !word.chars().any(|c| c.is_ascii_digit()) {
            return;
        }
        let rest =
            word.strip_prefix(['s', 'a']).filter(|r| r.starts_with(|c: char| c.is_ascii_digit())).unwrap_or(word);
        let digits: String = rest.chars().filter(char::is_ascii_digit).collect();
        let letters: String = rest.chars().filter(|c| !c.is_ascii_digit()).collect();
        let (motion, direction) = match letters.as_str() {
            "b" => (Motion::Bending, None),
            "bx" | "wx" => (Motion::Bending, Some(Direction::ForeAft)),
            "by" | "wy" => (Motion::Bending, Some(Direction::Lateral)),
            "bz" | "vb" => (Motion::Bending, Some(Direction::Vertical)),
            "t" => (Motion::Torsion, None),
            "x" => (Motion::Extension, None),
            _ => return,
        };
        self.motion = self.motion.or(Some(motion));
        self.direction = self.direction.or(direction);
        self.number = self.number.or(digits.parse().ok());
    }

    /// The symmetry that it tells.
    pub(crate) fn family(&self) -> Option<&'static str> {
        self.family
    }

    /// ln of the odds that two modes are one which their names give.
    pub(crate) fn ln_odds(&self, other: &Self) -> f64 {
        if !self.text.is_empty() && self.text == other.text {
            return SAME;
        }
        let differ = |a: Option<&'static str>, b: Option<&'static str>| matches!((a, b), (Some(a), Some(b)) if a != b);
        let of_family = if differ(self.family, other.family) { OTHER_FAMILY } else { 0.0 };
        let (Some(motion), Some(others)) = (self.motion, other.motion) else { return of_family };
        let is_other = matches!((self.direction, other.direction), (Some(a), Some(b)) if a != b);
        let of_kind = if motion != others || is_other {
            OTHER_KIND
        } else {
            match (self.number, other.number) {
                // Each direction is counted for itself where directions are told.
                (Some(a), Some(b)) if self.direction == other.direction && a == b => SAME,
                (Some(a), Some(b)) if self.direction == other.direction && a != b => 0.0,
                _ => SAME_KIND,
            }
        };
        of_family + of_kind
    }
}

/// `2nd`, `second`, `2` as a number.
fn ordinal(word: &str) -> Option<u32> {
    if let Some(k) = ORDINALS.iter().position(|o| *o == word) {
        return Some(k as u32 + 1);
    }
    let digits: String = word.chars().take_while(char::is_ascii_digit).collect();
    let rest = &word[digits.len()..];
    ["", "st", "nd", "rd", "th"].contains(&rest).then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn odds(a: &str, b: &str) -> f64 {
        Label::read(a).ln_odds(&Label::read(b))
    }

    #[test]
    fn names_of_one_mode_are_known_in_several_spellings() {
        for (a, b) in [
            ("1st Fore-aft Bending", "first in-plane bending"),
            ("2nd Vertical Bending", "out of plane bending 2"),
            ("S1B", "Sym 1st Bending"),
            ("A2T", "antisymmetric 2nd torsion"),
            ("2nd twist", "2nd Torsion"),
            ("Shell mode 7", "shell mode 7"),
        ] {
            assert_eq!(odds(a, b), SAME, "{a} and {b}");
        }
    }

    #[test]
    fn a_partial_name_says_a_little_and_another_kind_speaks_against() {
        assert_eq!(odds("bending", "2nd Vertical Bending"), SAME_KIND);
        assert_eq!(odds("2nd Bending", "2nd Vertical Bending"), SAME_KIND, "other directions count too");
        assert_eq!(odds("1st Bending", "2nd Bending"), 0.0);
        assert_eq!(odds("1st Torsion", "1st Bending"), OTHER_KIND);
        assert_eq!(odds("1st Vertical Bending", "1st Fore-aft Bending"), OTHER_KIND);
        assert_eq!(odds("Sym 1st Bending", "Anti 1st Bending"), OTHER_FAMILY + SAME);
        assert_eq!(odds("symmetric", "Anti 1st Bending"), OTHER_FAMILY);
        assert_eq!(odds("shell mode", "1st Bending"), 0.0);
        assert_eq!(odds("", ""), 0.0);
    }
}
