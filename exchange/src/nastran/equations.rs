//! Equations of DEQATN: their text, and what of it is a sum of arguments with factors.

use retune::deck::{CardId, Deck};
use std::collections::HashMap;

/// Nesting of brackets and signs, at most.
const DEEPEST: usize = 64;

/// An equation without blanks, in capitals: `F(A,B)=...;G=...`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Equation {
    /// Name of the first statement.
    pub function: String,
    /// Names of its arguments.
    pub arguments: Vec<String>,
    /// All from its right side on.
    pub text: String,
}

/// The equation of a DEQATN.
pub(super) fn equation_of(deck: &Deck, card: CardId) -> Equation {
    let text = deck.text_of(card);
    let mut whole = String::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('$').next().unwrap_or_default();
        let mut expanded = String::new();
        for c in line.chars() {
            match c {
                '\t' => expanded.extend(std::iter::repeat_n(' ', 8 - expanded.len() % 8)),
                c => expanded.push(c),
            }
        }
        let from = if i == 0 { 16 } else { 8 };
        let body: String = expanded.chars().skip(from).take(72 - from).collect();
        whole.extend(body.chars().filter(|c| !c.is_whitespace()));
    }
    let whole = whole.to_uppercase();
    let (head, right) = whole.split_once('=').unwrap_or((&whole, ""));
    let (function, names) = head.split_once('(').unwrap_or((head, ""));
    let names = names.rsplit_once(')').map_or("", |n| n.0);
    let arguments = names.split(',').map(str::to_string).collect();
    Equation { function: function.to_string(), arguments, text: right.to_string() }
}

/// A constant and a factor of each argument.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Linear {
    pub constant: f64,
    pub factors: Vec<f64>,
}

impl Linear {
    fn constant(constant: f64, n: usize) -> Self {
        Self { constant, factors: vec![0.0; n] }
    }

    fn is_constant(&self) -> bool {
        self.factors.iter().all(|f| *f == 0.0)
    }

    fn plus(mut self, other: &Self, factor: f64) -> Self {
        self.constant += factor * other.constant;
        self.factors.iter_mut().zip(&other.factors).for_each(|(a, b)| *a += factor * b);
        self
    }

    fn times(self, factor: f64) -> Self {
        Self { constant: self.constant * factor, factors: self.factors.iter().map(|f| f * factor).collect() }
    }
}

/// The value of the last statement as a sum of the arguments.
///
/// * `names` - of the arguments that it is a sum of
/// * `constants` - arguments that are numbers
///
/// # Errors
/// What is not a sum of arguments with factors, in words.
pub(super) fn linear(equation: &Equation, names: &[String], constants: &[(String, f64)]) -> Result<Linear, String> {
    let n = names.len();
    let mut known: HashMap<String, Linear> =
        constants.iter().map(|(name, v)| (name.clone(), Linear::constant(*v, n))).collect();
    for (i, name) in names.iter().enumerate() {
        let mut own = Linear::constant(0.0, n);
        own.factors[i] = 1.0;
        known.insert(name.clone(), own);
    }
    let mut value = Err("it is empty".to_string());
    for (i, statement) in equation.text.split(';').filter(|s| !s.is_empty()).enumerate() {
        let (name, right) = match statement.split_once('=') {
            Some((name, right)) if i > 0 => (name, right),
            _ => (equation.function.as_str(), statement),
        };
        let mut parser = Parser { text: right.as_bytes(), at: 0, known: &known, n };
        let found = parser.sum(0)?;
        if parser.at < parser.text.len() {
            return Err(format!("`{}` is not understood", &right[parser.at..]));
        }
        known.insert(name.to_string(), found.clone());
        value = Ok(found);
    }
    let value = value?;
    let is_finite = value.constant.is_finite() && value.factors.iter().all(|f| f.is_finite());
    if is_finite { Ok(value) } else { Err("it has a value that is not a number".to_string()) }
}

struct Parser<'a> {
    text: &'a [u8],
    at: usize,
    known: &'a HashMap<String, Linear>,
    n: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn takes(&mut self, c: u8) -> bool {
        let is_next = self.peek() == Some(c);
        self.at += usize::from(is_next);
        is_next
    }

    fn sum(&mut self, depth: usize) -> Result<Linear, String> {
        if depth > DEEPEST {
            return Err("its brackets are nested too deeply".to_string());
        }
        let mut sign = 1.0;
        while let Some(c @ (b'+' | b'-')) = self.peek() {
            self.at += 1;
            sign = if c == b'-' { -sign } else { sign };
        }
        let mut value = self.product(depth)?.times(sign);
        while let Some(c @ (b'+' | b'-')) = self.peek() {
            self.at += 1;
            let next = self.product(depth)?;
            value = value.plus(&next, if c == b'-' { -1.0 } else { 1.0 });
        }
        Ok(value)
    }

    fn product(&mut self, depth: usize) -> Result<Linear, String> {
        let mut value = self.power(depth)?;
        loop {
            let is_divided = match self.peek() {
                Some(b'*') => false,
                Some(b'/') => true,
                _ => return Ok(value),
            };
            self.at += 1;
            let next = self.power(depth)?;
            value = match (is_divided, value.is_constant(), next.is_constant()) {
                (false, _, true) => value.times(next.constant),
                (false, true, false) => next.times(value.constant),
                (true, _, true) => value.times(1.0 / next.constant),
                (false, false, false) => return Err("it multiplies its arguments with each other".to_string()),
                (true, _, false) => return Err("it divides by its arguments".to_string()),
            };
        }
    }

    fn power(&mut self, depth: usize) -> Result<Linear, String> {
        let value = self.atom(depth)?;
        if !(self.peek() == Some(b'*') && self.text.get(self.at + 1) == Some(&b'*')) {
            return Ok(value);
        }
        self.at += 2;
        let sign = if self.takes(b'-') { -1.0 } else { 1.0 };
        let exponent = self.atom(depth)?;
        match (value.is_constant(), exponent.is_constant()) {
            (true, true) => Ok(Linear::constant(value.constant.powf(sign * exponent.constant), self.n)),
            (false, true) if sign * exponent.constant == 1.0 => Ok(value),
            _ => Err("it has powers of its arguments".to_string()),
        }
    }

    fn atom(&mut self, depth: usize) -> Result<Linear, String> {
        if self.takes(b'(') {
            let value = self.sum(depth + 1)?;
            return if self.takes(b')') { Ok(value) } else { Err("a bracket is not closed".to_string()) };
        }
        let rest = &self.text[self.at..];
        let is_word = |c: &u8| c.is_ascii_alphanumeric() || *c == b'_';
        if rest.first().is_some_and(u8::is_ascii_alphabetic) {
            let length = rest.iter().position(|c| !is_word(c)).unwrap_or(rest.len());
            let word = String::from_utf8_lossy(&rest[..length]).into_owned();
            self.at += length;
            if self.peek() == Some(b'(') {
                return self.function(&word, depth);
            }
            return self.known.get(&word).cloned().ok_or_else(|| format!("`{word}` is none of its arguments"));
        }
        // A number: digits, a point, an exponent with or without its letter.
        let mut length = rest.iter().position(|c| !c.is_ascii_digit() && *c != b'.').unwrap_or(rest.len());
        let mut text = String::from_utf8_lossy(&rest[..length]).into_owned();
        if length > 0 && rest.get(length).is_some_and(|c| matches!(c, b'E' | b'D')) {
            let sign = usize::from(rest.get(length + 1).is_some_and(|c| matches!(c, b'+' | b'-')));
            let digits = rest[length + 1 + sign..].iter().take_while(|c| c.is_ascii_digit()).count();
            if digits > 0 {
                let end = length + 1 + sign + digits;
                text.push('e');
                text.push_str(&String::from_utf8_lossy(&rest[length + 1..end]));
                length = end;
            }
        }
        let shown = || String::from_utf8_lossy(&rest[..rest.len().min(12)]).into_owned();
        let value = text.parse::<f64>().map_err(|_| format!("a number or a name is expected at `{}`", shown()))?;
        self.at += length;
        Ok(Linear::constant(value, self.n))
    }

    fn function(&mut self, word: &str, depth: usize) -> Result<Linear, String> {
        self.at += 1;
        let mut arguments = vec![self.sum(depth + 1)?];
        while self.takes(b',') {
            arguments.push(self.sum(depth + 1)?);
        }
        if !self.takes(b')') {
            return Err("a bracket is not closed".to_string());
        }
        if matches!(word, "SUM" | "AVG") {
            let n = if word == "AVG" { arguments.len() as f64 } else { 1.0 };
            let zero = Linear::constant(0.0, self.n);
            return Ok(arguments.iter().fold(zero, |sum, a| sum.plus(a, 1.0 / n)));
        }
        if !arguments.iter().all(Linear::is_constant) {
            return Err(format!("{word} of its arguments is not a sum of them"));
        }
        let x = arguments[0].constant;
        let value = match (word, arguments.len()) {
            ("SQRT", 1) => x.sqrt(),
            ("ABS", 1) => x.abs(),
            ("EXP", 1) => x.exp(),
            ("LOG", 1) => x.ln(),
            ("LOG10", 1) => x.log10(),
            ("SIN", 1) => x.sin(),
            ("COS", 1) => x.cos(),
            ("TAN", 1) => x.tan(),
            ("ATAN", 1) => x.atan(),
            ("PI", 1) => std::f64::consts::PI * x,
            ("MAX", _) => arguments.iter().map(|a| a.constant).fold(x, f64::max),
            ("MIN", _) => arguments.iter().map(|a| a.constant).fold(x, f64::min),
            _ => return Err(format!("the function {word} is not read")),
        };
        Ok(Linear::constant(value, self.n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<(f64, Vec<f64>), String> {
        let names = ["A".to_string(), "B".to_string()];
        let equation = Equation { function: "F".into(), arguments: names.to_vec(), text: text.into() };
        linear(&equation, &names, &[]).map(|l| (l.constant, l.factors))
    }

    #[test]
    fn sums_with_factors_are_found() {
        for (text, constant, factors) in [
            ("A+2.*B", 0.0, [1.0, 2.0]),
            ("-(A-B)/4.+1.5E1-3.D0", 12.0, [-0.25, 0.25]),
            ("2.**3*A-SQRT(16.)", -4.0, [8.0, 0.0]),
            ("SUM(A,B,1.)*PI(1.)", std::f64::consts::PI, [std::f64::consts::PI; 2]),
            ("A/2.;D=C+B;", f64::NAN, [0.0; 2]),
            ("A*(B-B+3.)", 0.0, [3.0, 0.0]),
            ("A**1", 0.0, [1.0, 0.0]),
            ("A/2.;D=F+B;G=D-1.", -1.0, [0.5, 1.0]),
        ] {
            match of(text) {
                Ok(found) => assert_eq!(found, (constant, factors.to_vec()), "{text}"),
                Err(why) => assert!(constant.is_nan() && why.contains("`C` is none of its arguments"), "{text}: {why}"),
            }
        }
    }

    #[test]
    fn what_is_no_sum_is_said() {
        for (text, why) in [
            ("A*B", "multiplies its arguments"),
            ("1./A", "divides by its arguments"),
            ("A**2", "powers of its arguments"),
            ("SIN(A)", "SIN of its arguments"),
            ("A+", "a number or a name is expected"),
            ("A B", "is not understood"),
            ("(A", "a bracket is not closed"),
            ("1./0.", "not a number"),
            ("", "empty"),
        ] {
            let found = of(text).unwrap_err();
            assert!(found.contains(why), "{text}: {found}");
        }
        assert!(of(&"(".repeat(100_000)).unwrap_err().contains("too deeply"));
        assert!(of(&"-".repeat(100_000)).is_err());
    }
}
