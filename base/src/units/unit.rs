//! Units of numbers in files: parsed, checked against what is expected, converted to SI.
//!
//! A unit is a product of powers: `N m2`, `kg/m`, `N*m^2`, `N m/rad`, `1/s`. What follows a `/` up to the next `/`
//! divides only the next factor, as in `kg/m s` = (kg/m) s; write `kg/(m s)` or `kg/m/s` to divide by both. Angles have no
//! dimension: `deg` is π/180, `rad` is 1. `g` is the gram; the acceleration of gravity is `g0`. Characters are read in their
//! compatibility form (NFKC), so that both micro signs, superscripts and the squares of fonts (`㎜`) mean what they look like.
//!
//! Only frequencies know angles: there `rad/s` is 1/2π of a hertz, see [`Unit::hertz`].

use super::spellings;
use crate::catalogue::did_you_mean;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::fmt;
use unicode_normalization::UnicodeNormalization;

/// Powers of length, mass and time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dimension {
    /// Power of length.
    pub length: i8,
    /// Power of mass.
    pub mass: i8,
    /// Power of time.
    pub time: i8,
}

impl Dimension {
    /// A pure number, an angle, a ratio.
    pub const NONE: Dimension = Dimension { length: 0, mass: 0, time: 0 };

    fn times(self, other: Dimension, power: i8) -> Dimension {
        Dimension {
            length: self.length.saturating_add(other.length.saturating_mul(power)),
            mass: self.mass.saturating_add(other.mass.saturating_mul(power)),
            time: self.time.saturating_add(other.time.saturating_mul(power)),
        }
    }

    /// The dimension of a quotient.
    #[must_use]
    pub fn quotient(self, other: Dimension) -> Dimension {
        self.times(other, -1)
    }

    /// The dimension of a product.
    #[must_use]
    pub fn product(self, other: Dimension) -> Dimension {
        self.times(other, 1)
    }
}

impl fmt::Display for Dimension {
    /// In SI base units, `m2 kg/s2` style; `1` for a pure number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts: Vec<String> = [("kg", self.mass), ("m", self.length), ("s", self.time)]
            .into_iter()
            .filter(|(_, p)| *p != 0)
            .map(|(name, p)| if p == 1 { name.to_string() } else { format!("{name}^{p}") })
            .collect();
        f.write_str(if parts.is_empty() { "1" } else { "" })?;
        f.write_str(&parts.join(" "))
    }
}

/// A unit: its dimension and the factor to SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its dimension.
    pub dimension: Dimension,
    /// Value in SI = number times factor.
    pub factor: f64,
    /// Of a frequency: Hz in one of its SI unit, 1 where it counts turns (`Hz`, `rpm`), 1/2π where it counts angles (`rad/s`). `None`
    /// for all others, `1/s` with them, which says neither.
    pub turns: Option<f64>,
}

const INCH: f64 = 0.0254;
const POUND: f64 = 0.453_592_37;
/// Standard acceleration of free fall, m/s².
pub const GRAVITY: f64 = 9.806_65;

/// name, factor to SI, powers of length, mass, time.
#[rustfmt::skip]
const UNITS: &[(&str, f64, i8, i8, i8)] = &[
    ("1", 1.0, 0, 0, 0), ("%", 0.01, 0, 0, 0), ("ppm", 1e-6, 0, 0, 0),
    ("rad", 1.0, 0, 0, 0), ("mrad", 1e-3, 0, 0, 0), ("deg", TAU / 360.0, 0, 0, 0), ("°", TAU / 360.0, 0, 0, 0), ("rev", TAU, 0, 0, 0),
    ("m", 1.0, 1, 0, 0), ("km", 1e3, 1, 0, 0), ("dm", 0.1, 1, 0, 0), ("cm", 1e-2, 1, 0, 0), ("mm", 1e-3, 1, 0, 0),
    ("um", 1e-6, 1, 0, 0), ("in", INCH, 1, 0, 0), ("ft", 12.0 * INCH, 1, 0, 0), ("mil", 1e-3 * INCH, 1, 0, 0),
    ("kg", 1.0, 0, 1, 0), ("g", 1e-3, 0, 1, 0), ("mg", 1e-6, 0, 1, 0), ("Mg", 1e3, 0, 1, 0), ("t", 1e3, 0, 1, 0), ("lb", POUND, 0, 1, 0),
    ("lbm", POUND, 0, 1, 0), ("oz", POUND / 16.0, 0, 1, 0), ("slug", POUND * GRAVITY / (12.0 * INCH), 0, 1, 0),
    ("slinch", POUND * GRAVITY / INCH, 0, 1, 0),
    ("s", 1.0, 0, 0, 1), ("ms", 1e-3, 0, 0, 1), ("min", 60.0, 0, 0, 1), ("h", 3600.0, 0, 0, 1),
    ("Hz", 1.0, 0, 0, -1), ("mHz", 1e-3, 0, 0, -1), ("kHz", 1e3, 0, 0, -1), ("MHz", 1e6, 0, 0, -1), ("rpm", 1.0 / 60.0, 0, 0, -1),
    ("g0", GRAVITY, 1, 0, -2),
    ("N", 1.0, 1, 1, -2), ("mN", 1e-3, 1, 1, -2), ("kN", 1e3, 1, 1, -2), ("MN", 1e6, 1, 1, -2), ("GN", 1e9, 1, 1, -2), ("lbf", POUND * GRAVITY, 1, 1, -2),
    ("kgf", GRAVITY, 1, 1, -2), ("dyn", 1e-5, 1, 1, -2), ("daN", 10.0, 1, 1, -2), ("kip", 1e3 * POUND * GRAVITY, 1, 1, -2),
    ("Pa", 1.0, -1, 1, -2), ("hPa", 1e2, -1, 1, -2), ("kPa", 1e3, -1, 1, -2), ("MPa", 1e6, -1, 1, -2), ("GPa", 1e9, -1, 1, -2),
    ("bar", 1e5, -1, 1, -2), ("psi", POUND * GRAVITY / (INCH * INCH), -1, 1, -2), ("ksi", 1e3 * POUND * GRAVITY / (INCH * INCH), -1, 1, -2),
    ("Msi", 1e6 * POUND * GRAVITY / (INCH * INCH), -1, 1, -2), ("Mpsi", 1e6 * POUND * GRAVITY / (INCH * INCH), -1, 1, -2),
    ("J", 1.0, 2, 1, -2), ("W", 1.0, 2, 1, -3),
];

/// Every unit by its name, in the order of the reference: name, factor to SI, dimension.
pub fn units() -> impl Iterator<Item = (&'static str, f64, Dimension)> {
    UNITS.iter().map(|&(name, factor, length, mass, time)| (name, factor, Dimension { length, mass, time }))
}

/// Units that count angles.
const ANGLES: [&str; 5] = ["rad", "mrad", "deg", "°", "rev"];
/// Units that count turns in a time.
const TURNS: [&str; 5] = ["Hz", "mHz", "kHz", "MHz", "rpm"];

/// Why a text is not a unit, or not the one needed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UnitError {
    /// A word that names no unit.
    #[error("unknown unit `{name}`{suggestion}")]
    Unknown {
        /// The word.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// Grammar.
    #[error("`{text}` is not a unit: {why}")]
    Malformed {
        /// The text.
        text: String,
        /// What was expected.
        why: &'static str,
    },
    /// Another dimension than expected.
    #[error("the unit of `{given}` does not fit: expected {expected}")]
    Mismatch {
        /// The unit in the file.
        given: String,
        /// An SI unit of the right dimension.
        expected: String,
    },
}

impl Unit {
    /// One, without dimension.
    pub const ONE: Unit = Unit { dimension: Dimension::NONE, factor: 1.0, turns: None };

    /// Parses a unit such as `N m2`, `kg/m`, `N*m^2/rad`.
    pub fn parse(text: &str) -> Result<Unit, UnitError> {
        let malformed = |why| UnitError::Malformed { text: text.trim().to_string(), why };
        let normal = if text.is_ascii() { Cow::Borrowed(text) } else { Cow::Owned(text.nfkc().collect::<String>()) };
        if let Some(name) = spellings::of_whole(normal.trim()) {
            return Unit::parse(name);
        }
        let mut unit = Unit::ONE;
        // Powers of angles and of turns.
        let (mut angle, mut turn) = (0i8, 0i8);
        let mut rest = normal.trim();
        let (mut sign, mut group) = (1i8, 0usize);
        let mut group_sign = 1i8;
        let mut pending = true; // a factor must follow
        while !rest.is_empty() {
            let c = rest.chars().next().unwrap_or(' ');
            match c {
                ' ' | '*' | '·' | '⋅' | '.' => {
                    pending = pending || c != ' ';
                    rest = &rest[c.len_utf8()..];
                }
                '/' => {
                    sign = -sign;
                    pending = true;
                    rest = &rest[1..];
                }
                '(' => {
                    if group > 0 {
                        return Err(malformed("parentheses do not nest"));
                    }
                    (group, group_sign, sign) = (1, sign, 1);
                    rest = &rest[1..];
                }
                ')' => {
                    if group == 0 {
                        return Err(malformed("a closing parenthesis without an opening one"));
                    }
                    (group, group_sign, sign) = (0, 1, 1);
                    rest = &rest[1..];
                }
                _ => {
                    let end = rest.find(|c: char| !(c.is_alphabetic() || matches!(c, '%' | '°'))).unwrap_or(rest.len());
                    let (mut name, mut after) = rest.split_at(end);
                    if name.is_empty() && rest.starts_with('1') {
                        (name, after) = rest.split_at(1);
                    }
                    if rest.starts_with(',') {
                        return Err(malformed("decimals are written with a point, `0.1`, not with a comma"));
                    }
                    if name.is_empty() {
                        return Err(malformed("expected a unit such as `kg`, `N m2` or `kg/m`"));
                    }
                    if name == "g" && after.starts_with('0') {
                        (name, after) = rest.split_at(2);
                    }
                    let (power, after) =
                        read_power(after).ok_or_else(|| malformed("a power must be between -9 and 9"))?;
                    let name = name.replace('μ', "u");
                    let &(name, factor, length, mass, time) = known(&name)
                        .or_else(|| spellings::of_word(&name).and_then(known))
                        .ok_or_else(|| UnitError::Unknown { suggestion: suggestion(&name), name: name.clone() })?;
                    let power = power * sign * group_sign;
                    angle = angle.saturating_add(if ANGLES.contains(&name) { power } else { 0 });
                    turn = turn.saturating_add(if TURNS.contains(&name) { power } else { 0 });
                    unit.factor *= factor.powi(i32::from(power));
                    unit.dimension = unit.dimension.times(Dimension { length, mass, time }, power);
                    sign = 1;
                    pending = false;
                    rest = after;
                }
            }
        }
        if group > 0 {
            return Err(malformed("an opening parenthesis without a closing one"));
        }
        if pending && !text.trim().is_empty() {
            return Err(malformed("a unit is missing at its end"));
        }
        unit.turns = match (angle, turn) {
            _ if unit.dimension != FREQUENCY => None,
            (1, 0) => Some(1.0 / TAU),
            (0, 1) => Some(1.0),
            _ => None,
        };
        Ok(unit)
    }

    /// One of this unit in Hz, of a frequency that says whether it counts turns or angles.
    ///
    /// ```text
    /// f = ω / 2π:   1 Hz, 1000 for kHz, 1/60 for rpm, 1/2π for rad/s, 1/360 for deg/s
    /// ```
    pub fn hertz(&self) -> Option<f64> {
        self.turns.map(|t| t * self.factor)
    }

    /// The dimension of a unit that this program itself writes.
    ///
    /// # Panics
    /// If the text is not a unit: a mistake in a catalogue.
    pub fn known(text: &str) -> Unit {
        Self::parse(text).unwrap_or_else(|e| panic!("a catalogue's unit: {e}"))
    }
}

/// A frequency's dimension.
const FREQUENCY: Dimension = Dimension { length: 0, mass: 0, time: -1 };

fn known(name: &str) -> Option<&'static (&'static str, f64, i8, i8, i8)> {
    UNITS.iter().find(|u| u.0 == name)
}

/// Two units that are written as one word: `Nm`.
pub(super) fn two_units(name: &str) -> Option<(&str, &str)> {
    let mut halves = name.char_indices().skip(1).map(|(at, _)| name.split_at(at));
    // `m` at the front is a prefix that the unit does not have here, `mPa`.
    halves.find(|(a, b)| *a != "m" && known(a).is_some() && known(b).is_some())
}

/// The unit that a typing error meant, as a clause for a message; none of another prefix, which would be wrong by powers of ten.
fn suggestion(name: &str) -> String {
    if let Some(meant) = spellings::ambiguous(name) {
        return format!("; did you mean {meant}?");
    }
    if let Some((a, b)) = two_units(name) {
        return format!("; did you mean `{a} {b}`?");
    }
    let first = name.chars().next().unwrap_or(' ');
    // Of the prefixes, `m` and `M` alone differ by nothing but their case.
    let same_prefix = |unit: &str| {
        unit.len() > 1
            && unit.starts_with(|c: char| c == first || (c.eq_ignore_ascii_case(&first) && !matches!(c, 'm' | 'M')))
    };
    let other_case: Vec<&str> = UNITS.iter().map(|u| u.0).filter(|u| u.eq_ignore_ascii_case(name)).collect();
    if other_case.iter().any(|u| !same_prefix(u)) {
        let known = other_case.join("` or `");
        return format!("; the case of its letters counts, and `{known}` is known");
    }
    did_you_mean(name, UNITS.iter().map(|u| u.0).filter(|u| same_prefix(u)))
}

/// A unit of a frequency axis.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyUnit {
    /// As it was written.
    pub name: String,
    /// One of it in Hz.
    pub hertz: f64,
}

impl FrequencyUnit {
    /// Names for a question.
    pub const NAMES: [&'static str; 5] = ["Hz", "kHz", "rad/s", "deg/s", "rpm"];

    /// Reads the unit of a frequency as programs write it: `Hz`, `[rad/sec]`, `RPM`, `1/min`, `cycles/s`.
    ///
    /// `None` for everything else; `1/s` is among it, because it may stand for Hz and for rad/s.
    pub fn of_label(label: &str) -> Option<Self> {
        let name = label.trim().trim_matches(['[', ']', '(', ')']).trim();
        let hertz = Unit::parse(name).ok().and_then(|u| u.hertz()).or_else(|| {
            Some(match name.to_lowercase().as_str() {
                "hz" | "c/s" | "rev/sec" | "rps" => 1.0,
                "khz" | "kilohertz" => 1e3,
                "krpm" => 1e3 / 60.0,
                "rad/s" | "rad/sec" | "radian/s" | "radians/s" | "rad/second" | "radians/sec" | "rads/s" => 1.0 / TAU,
                "deg/s" | "deg/sec" | "degrees/s" | "°/s" => 1.0 / 360.0,
                _ => return None,
            })
        })?;
        Some(Self { name: name.to_string(), hertz })
    }
}

/// `2`, `^2`, `^-1`, `-1` after a unit's name; 1 if there is none.
fn read_power(text: &str) -> Option<(i8, &str)> {
    let body = text.strip_prefix('^').unwrap_or(text);
    // The superscript of a minus is a minus of its own.
    let minus = ['-', '−'].into_iter().find(|c| body.starts_with(*c)).map_or(0, char::len_utf8);
    let digits = &body[minus..];
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    if end == 0 {
        return if body.len() == text.len() { Some((1, text)) } else { None };
    }
    let power: i8 = digits[..end].parse().ok()?;
    (power <= 9).then(|| (if minus > 0 { -power } else { power }, &digits[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_convert_to_si() {
        for (text, factor, dimension) in [
            ("GPa", 1e9, (-1, 1, -2)),
            ("N m2", 1.0, (3, 1, -2)),
            ("N*m^2", 1.0, (3, 1, -2)),
            ("N·m²", 1.0, (3, 1, -2)),
            ("kg/m", 1.0, (-1, 1, 0)),
            ("kg m2", 1.0, (2, 1, 0)),
            ("lbf/in", POUND * GRAVITY / INCH, (0, 1, -2)),
            ("N m/rad", 1.0, (2, 1, -2)),
            ("kg/(m s)", 1.0, (-1, 1, -1)),
            ("kg/m/s", 1.0, (-1, 1, -1)),
            ("1/s", 1.0, (0, 0, -1)),
            ("mm4", 1e-12, (4, 0, 0)),
            ("g0", GRAVITY, (1, 0, -2)),
            ("%", 0.01, (0, 0, 0)),
            ("m s^-2", 1.0, (1, 0, -2)),
            ("m·s⁻²", 1.0, (1, 0, -2)),
            ("N⋅m/°", 360.0 / TAU, (2, 1, -2)),
            // Greek mu, the micro sign, and a square of East Asian fonts.
            ("\u{3bc}m", 1e-6, (1, 0, 0)),
            ("\u{b5}m", 1e-6, (1, 0, 0)),
            ("\u{339c}²", 1e-6, (2, 0, 0)),
            ("N\u{a0}m", 1.0, (2, 1, -2)),
            ("Mg", 1e3, (0, 1, 0)),
        ] {
            let unit = Unit::parse(text).unwrap();
            let (length, mass, time) = dimension;
            assert_eq!(unit.dimension, Dimension { length, mass, time }, "{text}");
            assert!((unit.factor / factor - 1.0).abs() < 1e-14, "{text}");
        }
    }

    #[test]
    fn frequencies_count_turns_or_angles() {
        let hertz = |text: &str| Unit::parse(text).unwrap().hertz();
        for (text, value) in [
            ("Hz", 1.0),
            ("kHz", 1e3),
            ("rpm", 1.0 / 60.0),
            ("rad/s", 1.0 / TAU),
            ("deg/s", 1.0 / 360.0),
            ("rev/s", 1.0),
            ("rev/min", 1.0 / 60.0),
            ("°/s", 1.0 / 360.0),
        ] {
            assert!((hertz(text).unwrap() / value - 1.0).abs() < 1e-15, "{text}");
        }
        for text in ["1/s", "m", "rad", "rad2/s", "Hz rad", "rad/s2", "N/m", "rad Hz"] {
            assert_eq!(hertz(text), None, "{text}");
        }
        let label = |text: &str| FrequencyUnit::of_label(text).map(|u| u.hertz);
        assert_eq!(label("[Hz]"), Some(1.0));
        assert_eq!(label(" RPM"), Some(1.0 / 60.0));
        assert_eq!(label("rad/sec"), Some(1.0 / TAU));
        assert_eq!(label("mHz"), Some(1e-3));
        for text in ["1/s", "NONE", "", "m/s2", "order", "s"] {
            assert_eq!(label(text), None, "{text}");
        }
    }

    #[test]
    fn wrong_units_say_what_is_wrong() {
        for (text, message) in [
            ("Nm", "unknown unit `Nm`; did you mean `N m`?"),
            ("KG", "unknown unit `KG`; did you mean `kg`?"),
            ("Mm", "unknown unit `Mm`; the case of its letters counts, and `mm` is known"),
            ("MM", "unknown unit `MM`; the case of its letters counts, and `mm` is known"),
            ("MG", "unknown unit `MG`; the case of its letters counts, and `mg` or `Mg` is known"),
            ("xm", "unknown unit `xm`"),
            ("mPa", "unknown unit `mPa`; the case of its letters counts, and `MPa` is known"),
            ("Gpa", "unknown unit `Gpa`; did you mean `GPa`?"),
            ("kg/", "`kg/` is not a unit: a unit is missing at its end"),
            ("kg/(m", "`kg/(m` is not a unit: an opening parenthesis without a closing one"),
            ("m^99", "`m^99` is not a unit: a power must be between -9 and 9"),
            ("5", "`5` is not a unit: expected a unit such as `kg`, `N m2` or `kg/m`"),
        ] {
            assert_eq!(Unit::parse(text).unwrap_err().to_string(), message);
        }
    }
}
