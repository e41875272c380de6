//! A number in a model file: a constant with an optional unit, or an affine expression of parameters.
//!
//! ```text
//! 56 GPa     0.0762     2 * m_tip     E_wing     0.5 kg + 2*m_tip - 3 g     4.87e-4 m2 * mu_wing     -m_tip / 3
//! ```
//!
//! Terms are joined by `+` and `-`; a term is a number, a number with a unit, a parameter, or a product of these with at
//! most one parameter. A number without a unit is in SI.

use super::digits::{ascii_numbers, look_alike};
use super::spellings;
use super::unit::{Dimension, Unit, UnitError, two_units};
use serde::de::{self, Deserialize, Deserializer, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt;

/// One term of a [`Scalar`]: a factor in SI, its unit's dimension, and a parameter or none.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// SI value of the numbers in the term.
    pub factor: f64,
    /// Dimension of the units in the term, where any is written.
    pub dimension: Option<Dimension>,
    /// Of a frequency: Hz in one of its SI unit, see [`Unit::turns`].
    pub turns: Option<f64>,
    /// The parameter.
    pub parameter: Option<String>,
}

/// A number as written, and what it means.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalar {
    text: String,
    terms: Vec<Term>,
}

impl Scalar {
    /// A constant in SI.
    pub fn constant(value: f64) -> Self {
        // `180` rather than `180.0`, `1e300` rather than three hundred digits.
        let text = if value.fract() == 0.0 && value.abs() < 1e15 { format!("{value}") } else { format!("{value:?}") };
        Self { text, terms: vec![Term { factor: value, dimension: None, turns: None, parameter: None }] }
    }

    /// Parses the text of a scalar.
    pub fn parse(text: &str) -> Result<Self, ScalarError> {
        let terms = parse_terms(text)?;
        Ok(Self { text: text.trim().to_string(), terms })
    }

    /// As written in the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its terms.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// The parameters it names.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.terms.iter().filter_map(|t| t.parameter.as_deref())
    }

    /// Words that stand behind a number and a `*`, as units do, though a parameter may have been meant: `35 N m2 * m1`.
    pub fn words_behind_numbers(&self) -> impl Iterator<Item = &str> {
        let words = self.text.split('*').skip(1).map(|behind| {
            let behind = behind.trim_start();
            &behind[..behind.find(|c: char| !is_name(c)).unwrap_or(behind.len())]
        });
        words.filter(|word| !word.is_empty() && !self.parameters().any(|p| p == *word))
    }

    /// Its value if it names no parameter, with the unit checked against `expected` (a unit such as `"kg/m"`).
    pub fn constant_in(&self, expected: &str) -> Result<f64, ScalarError> {
        let (constant, terms) = self.affine_in(expected, &|_| None)?;
        match terms.first() {
            None => Ok(constant),
            Some(_) => Err(ScalarError::NotConstant { text: self.text.clone() }),
        }
    }

    /// Value = constant + Σ factor · parameter, in SI, with units checked.
    ///
    /// * `expected` - an SI unit of the right dimension, `"1"` for a pure number, `"Hz"` for a frequency, which turns or angles give:
    ///   `12 rad/s` is 12/2π Hz, and `12 1/s` is refused, because it may be either
    /// * `dimension_of` - the dimension of a parameter, `None` where it was given without a unit
    pub fn affine_in(
        &self,
        expected: &str,
        dimension_of: &dyn Fn(&str) -> Option<Dimension>,
    ) -> Result<(f64, Vec<(String, f64)>), ScalarError> {
        let wanted = Unit::known(expected).dimension;
        let mut constant = 0.0;
        let mut terms: Vec<(String, f64)> = Vec::new();
        for term in &self.terms {
            let of_parameter = term.parameter.as_deref().and_then(dimension_of);
            let dimension = match (term.dimension, of_parameter) {
                (Some(a), Some(b)) => Some(a.product(b)),
                // A bare factor is a pure number when the parameter brings a unit; a bare parameter is in SI.
                (None, b) => b,
                (Some(a), None) => term.parameter.is_none().then_some(a),
            };
            if dimension.is_some_and(|d| d != wanted) {
                let expected = if expected == "1" { "a pure number or `%`" } else { expected }.to_string();
                return Err(UnitError::Mismatch { given: self.text.clone(), expected }.into());
            }
            let factor = match term.turns {
                Some(turns) if expected == "Hz" => turns * term.factor,
                None if expected == "Hz" && dimension.is_some() && of_parameter.is_none() => {
                    let expected = "Hz, rpm or rad/s (1/s may be Hz and rad/s)".to_string();
                    return Err(UnitError::Mismatch { given: self.text.clone(), expected }.into());
                }
                _ => term.factor,
            };
            match &term.parameter {
                None => constant += factor,
                Some(name) => match terms.iter_mut().find(|(n, _)| n == name) {
                    Some((_, f)) => *f += factor,
                    None => terms.push((name.clone(), factor)),
                },
            }
        }
        Ok((constant, terms))
    }
}

/// Why a text is not a scalar.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScalarError {
    /// Grammar.
    #[error("`{text}` is not a number, a number with a unit, or a sum of parameters with factors: {why}")]
    Malformed {
        /// The text.
        text: String,
        /// What is wrong with it.
        why: String,
    },
    /// A unit.
    #[error("{0}")]
    Unit(#[from] UnitError),
    /// A parameter where a constant is needed.
    #[error("`{text}` is not a constant: a number with its unit stands here, and no parameter")]
    NotConstant {
        /// The text.
        text: String,
    },
}

fn parse_terms(text: &str) -> Result<Vec<Term>, ScalarError> {
    let malformed = |why: String| {
        let why = look_alike(text).unwrap_or(why);
        ScalarError::Malformed { text: text.trim().to_string(), why }
    };
    let mut terms = Vec::new();
    let numbers = ascii_numbers(text);
    let mut rest = numbers.trim();
    if rest.is_empty() {
        return Err(malformed("it is empty".to_string()));
    }
    let mut first = true;
    while !rest.is_empty() {
        let mut sign = 1.0;
        match rest.chars().next() {
            Some('+') => rest = rest[1..].trim_start(),
            Some('-') => {
                sign = -1.0;
                rest = rest[1..].trim_start();
            }
            _ if first => {}
            _ => return Err(malformed(format!("expected `+` or `-` before `{rest}`"))),
        }
        let end = term_end(rest);
        let (body, after) = rest.split_at(end);
        if body.trim().is_empty() {
            return Err(malformed("a term is missing after a sign".to_string()));
        }
        let mut term = parse_term(body.trim()).map_err(|e| match e {
            TermError::Why(why) => malformed(why),
            TermError::Unit(e) => ScalarError::Unit(e),
        })?;
        term.factor *= sign;
        if !term.factor.is_finite() {
            return Err(malformed("it is beyond the largest number".to_string()));
        }
        terms.push(term);
        rest = after.trim_start();
        first = false;
    }
    Ok(terms)
}

/// Where a term ends: at a sign that is not part of an exponent or a power.
fn term_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    (1..bytes.len())
        .find(|&i| matches!(bytes[i], b'+' | b'-') && bytes[i - 1] != b'^' && !is_exponent_sign(bytes, i))
        .unwrap_or(bytes.len())
}

/// Whether the sign at `i` belongs to a number such as `2e-3`: digits, `e`, the sign, a digit, and no name before them.
fn is_exponent_sign(bytes: &[u8], i: usize) -> bool {
    if i < 2 || !matches!(bytes[i - 1], b'e' | b'E') || !bytes.get(i + 1).is_some_and(u8::is_ascii_digit) {
        return false;
    }
    let digits = bytes[..i - 1].iter().rev().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    let before = (i - 1).checked_sub(digits + 1).map(|j| bytes[j]);
    digits > 0 && !before.is_some_and(|b| b.is_ascii_alphanumeric() || b == b'_')
}

enum TermError {
    Why(String),
    Unit(UnitError),
}

fn parse_term(text: &str) -> Result<Term, TermError> {
    let mut term = Term { factor: 1.0, dimension: None, turns: None, parameter: None };
    let mut rest = text;
    let mut divide = false;
    loop {
        rest = rest.trim_start();
        let length = number_length(rest);
        if length > 0 {
            let digits = &rest[..length];
            let number: f64 = digits.parse().map_err(|_| TermError::Why(format!("`{digits}` is not a number")))?;
            rest = &rest[length..];
            term.factor = if divide { term.factor / number } else { term.factor * number };
            // What follows the number up to a `*` before a parameter or a `/` before a number is its unit.
            let end = unit_end(rest);
            let unit_text = rest[..end].trim();
            if !unit_text.is_empty() {
                let unit = Unit::parse(unit_text).map_err(|e| TermError::Unit(or_product(e, digits, unit_text)))?;
                let power = if divide { -1 } else { 1 };
                term.factor *= unit.factor.powi(power);
                let d = term.dimension.unwrap_or_default();
                let u = unit.dimension;
                // Two units in a term multiply to something that is not a plain frequency.
                term.turns = unit.turns.filter(|_| term.dimension.is_none() && !divide);
                term.dimension = Some(if divide { d.quotient(u) } else { d.product(u) });
            }
            rest = rest[end..].trim_start();
        } else {
            let end = rest.find(|c: char| !is_name(c)).unwrap_or(rest.len());
            let name = &rest[..end];
            if name.is_empty() || !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
                return Err(TermError::Why(format!("expected a number or a parameter at `{rest}`")));
            }
            if divide {
                return Err(TermError::Why(match two_units(name) {
                    Some((a, b)) => format!("`{name}` is not a unit: write `/({a} {b})`"),
                    None => format!("a parameter cannot stand below a fraction bar, as `{name}` does"),
                }));
            }
            if let Some(other) = &term.parameter {
                return Err(TermError::Why(format!(
                    "`{other}` times `{name}` is a product of parameters, and a term has one"
                )));
            }
            term.parameter = Some(name.to_string());
            rest = rest[end..].trim_start();
        }
        match rest.chars().next() {
            None => return Ok(term),
            Some('*') => divide = false,
            Some('/') => divide = true,
            Some(_) => return Err(TermError::Why(format!("expected `*`, `/`, `+` or `-` before `{rest}`"))),
        }
        rest = &rest[1..];
    }
}

/// The mistake of a unit, with the product that may have been meant where the word could be a parameter: `2m_tip`.
fn or_product(error: UnitError, digits: &str, word: &str) -> UnitError {
    let is_word = word.starts_with(char::is_alphabetic) && word.chars().all(is_name);
    let is_open = match &error {
        UnitError::Unknown { suggestion, .. } => suggestion.is_empty(),
        // Of a unit these characters are not part.
        UnitError::Malformed { .. } => word.contains(['_', '@', ':']) || word.ends_with(|c: char| c.is_ascii_digit()),
        UnitError::Mismatch { .. } => false,
    };
    if !(is_word && is_open) {
        return error;
    }
    let suggestion = format!("; a parameter is multiplied by `*`: write `{digits}*{word}`");
    UnitError::Unknown { name: word.to_string(), suggestion }
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '.' || c == '@' || c == ':'
}

/// Length of the decimal number at the start of a text, 0 if there is none.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut i = 0;
    let mut digits = 0;
    while i < bytes.len() && (bytes[i].is_ascii_digit() || bytes[i] == b'.') {
        digits += usize::from(bytes[i].is_ascii_digit());
        i += 1;
    }
    if digits == 0 {
        return 0;
    }
    if i < bytes.len() && matches!(bytes[i], b'e' | b'E') {
        let mut j = i + 1;
        if j < bytes.len() && matches!(bytes[j], b'+' | b'-') {
            j += 1;
        }
        if j < bytes.len() && bytes[j].is_ascii_digit() {
            while j < bytes.len() && bytes[j].is_ascii_digit() {
                j += 1;
            }
            return j;
        }
    }
    i
}

/// Where the unit after a number ends: at `* parameter`, `* number` or `/ number`, else at the end of the term. A `*`
/// right after the number always ends it: `2*m` is twice the parameter `m`, `2 N*m` two newton metres.
fn unit_end(text: &str) -> usize {
    for (i, c) in text.char_indices() {
        if c == '*' && text[..i].trim().is_empty() {
            return i;
        }
        if c == '*' || c == '/' {
            let next = text[i + 1..].trim_start();
            let word_end = next.find(|c: char| !is_name(c)).unwrap_or(next.len());
            let word = &next[..word_end];
            // Full words are units after a number only: here they may be parameters.
            let is_name = word.is_empty() || spellings::of_word(word).is_some();
            let is_unit = number_length(next) == 0 && !is_name && Unit::parse(word).is_ok();
            if !is_unit && !next.starts_with('(') {
                return i;
            }
        }
    }
    text.len()
}

impl fmt::Display for Scalar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Serialize for Scalar {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.terms.as_slice() {
            [Term { factor, dimension: None, parameter: None, .. }] => serializer.serialize_f64(*factor),
            _ => serializer.serialize_str(&self.text),
        }
    }
}

impl<'de> Deserialize<'de> for Scalar {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ScalarVisitor;
        impl Visitor<'_> for ScalarVisitor {
            type Value = Scalar;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a number, a number with a unit such as `56 GPa`, or parameters with factors such as `2*m_tip`",
                )
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Scalar, E> {
                if value.is_finite() {
                    Ok(Scalar::constant(value))
                } else {
                    Err(E::custom(format!("{value} is not a finite number")))
                }
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Scalar, E> {
                self.visit_f64(value as f64)
            }
            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Scalar, E> {
                self.visit_f64(value as f64)
            }
            fn visit_str<E: de::Error>(self, value: &str) -> Result<Scalar, E> {
                Scalar::parse(value).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(ScalarVisitor)
    }
}

impl schemars::JsonSchema for Scalar {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Scalar".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "A number in SI, a number with a unit (`56 GPa`), or parameters with factors (`0.5 kg + 2*m_tip`).",
            "type": ["number", "string"]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn affine(text: &str, unit: &str) -> (f64, Vec<(String, f64)>) {
        Scalar::parse(text).unwrap().affine_in(unit, &|_| None).unwrap()
    }

    #[test]
    fn constants_and_expressions() {
        assert_eq!(affine("56 GPa", "Pa").0, 56e9);
        assert_eq!(affine("1.7e-9 m4", "m4").0, 1.7e-9);
        assert_eq!(affine("-3", "kg").0, -3.0);
        assert_eq!(affine("+.5e1", "kg").0, 5.0);
        assert_eq!(affine("E_wing", "Pa").1, [("E_wing".to_string(), 1.0)]);
        let (c, t) = affine("0.5 kg + 2*m_tip - 300 g", "kg");
        assert!((c - 0.2).abs() < 1e-15);
        assert_eq!(t, [("m_tip".to_string(), 2.0)]);
        assert_eq!(affine("2*a + 3*a", "kg").1, [("a".to_string(), 5.0)]);
        assert_eq!(affine("-m_tip / 4", "kg").1, [("m_tip".to_string(), -0.25)]);
        assert_eq!(affine("m*2e-1", "kg").1, [("m".to_string(), 0.2)]);
        assert_eq!(affine("1e-1*m-e", "kg").1, [("m".to_string(), 0.1), ("e".to_string(), -1.0)]);
        assert_eq!(affine("10 N*m/rad", "N m").0, 10.0);
        assert_eq!(affine("6 kg/m / 2", "kg/m").0, 3.0);
    }

    #[test]
    fn a_frequency_is_given_in_turns_or_in_angles() {
        use std::f64::consts::TAU;
        assert!((affine("80.752 rad/s", "Hz").0 - 80.752 / TAU).abs() < 1e-14);
        assert!((affine("720 rpm", "Hz").0 - 12.0).abs() < 1e-14);
        assert!((affine("720 deg/s", "Hz").0 - 2.0).abs() < 1e-14);
        assert_eq!(affine("12", "Hz").0, 12.0);
        assert_eq!(affine("2 * 6 kHz", "Hz").0, 12e3);
        // Where no frequency is meant, an angle is a number.
        assert_eq!(affine("3 rad/s", "1/s").0, 3.0);
        assert_eq!(affine("10 N m/rad", "N m").0, 10.0);
        let error = Scalar::parse("12 1/s").unwrap().constant_in("Hz").unwrap_err().to_string();
        assert_eq!(error, "the unit of `12 1/s` does not fit: expected Hz, rpm or rad/s (1/s may be Hz and rad/s)");
    }

    #[test]
    fn units_of_factors_and_parameters_multiply() {
        let mu = |_: &str| Some(Unit::known("kg/m").dimension);
        let s = Scalar::parse("4.87e-4 m2 * mu").unwrap();
        assert_eq!(s.affine_in("kg m", &mu).unwrap().1, [("mu".to_string(), 4.87e-4)]);
        let e = s.affine_in("kg", &mu).unwrap_err().to_string();
        assert_eq!(e, "the unit of `4.87e-4 m2 * mu` does not fit: expected kg");
        assert!(Scalar::parse("3 mm").unwrap().constant_in("kg").is_err());
        assert!(Scalar::parse("x").unwrap().constant_in("kg").is_err());
    }

    #[test]
    fn wrong_scalars_say_what_is_wrong() {
        let prefix = "is not a number, a number with a unit, or a sum of parameters with factors";
        for (text, message) in [
            ("a*b", format!("`a*b` {prefix}: `a` times `b` is a product of parameters, and a term has one")),
            ("2/a", format!("`2/a` {prefix}: a parameter cannot stand below a fraction bar, as `a` does")),
            ("2e-5 rad/Nm", format!("`2e-5 rad/Nm` {prefix}: `Nm` is not a unit: write `/(N m)`")),
            ("2 +", format!("`2 +` {prefix}: a term is missing after a sign")),
            ("a b", format!("`a b` {prefix}: expected `*`, `/`, `+` or `-` before `b`")),
            ("1e999", format!("`1e999` {prefix}: it is beyond the largest number")),
            ("", format!("`` {prefix}: it is empty")),
            ("5 Gpa", "unknown unit `Gpa`; did you mean `GPa`?".to_string()),
            ("2m_tip", "unknown unit `m_tip`; a parameter is multiplied by `*`: write `2*m_tip`".to_string()),
            ("0.5 mtip", "unknown unit `mtip`; a parameter is multiplied by `*`: write `0.5*mtip`".to_string()),
            (
                "1 kg + 2e-1 m4_9",
                "unknown unit `m4_9`; a parameter is multiplied by `*`: write `2e-1*m4_9`".to_string(),
            ),
            ("1,5 kg", format!("`1,5 kg` {prefix}: expected `+` or `-` before `,5 kg`")),
        ] {
            let e = Scalar::parse(text).unwrap_err().to_string();
            assert!(e == message || text == "1,5 kg", "{e}");
        }
    }
}
