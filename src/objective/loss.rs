//! Losses for data with outliers, written as residuals.

use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a residual costs.
///
/// ```text
/// squares      ρ(r) = r²/2
/// huber k      ρ(r) = r²/2 for |r| ≤ k,  k |r| - k²/2 beyond
/// student-t ν  ρ(r) = (ν + 1)/2 ln(1 + r²/ν)
/// ```
///
/// A method of least squares sees s with s²/2 = ρ(r), s = sign(r) √(2ρ), so that every optimiser and every linearisation
/// works on it unchanged. With Huber's loss an outlier pulls with a constant force k, with Student's the less the
/// further off it is.
///
/// # Source
/// P. J. Huber, Robust estimation of a location parameter, Annals of Mathematical Statistics 35, 1964; K. L. Lange, R. J. A.
/// Little, J. M. G. Taylor, Robust statistical modeling using the t distribution, JASA 84, 1989.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "Choice", into = "Choice")]
pub enum Loss {
    /// Squares: Gaussian noise.
    #[default]
    Squares,
    /// Squares up to so many standard deviations, linear beyond; 1.345 keeps 95 % of the efficiency with Gaussian noise.
    Huber(f64),
    /// Student's t with so many degrees of freedom; 4 is common.
    StudentT(f64),
}

impl Loss {
    /// s and ds/dr of a residual r.
    pub fn transform(self, r: f64) -> (f64, f64) {
        match self {
            Loss::Huber(k) if r.abs() > k => {
                let s = (2.0 * k * r.abs() - k * k).sqrt();
                (s.copysign(r), k / s)
            }
            Loss::StudentT(nu) => {
                let s = ((nu + 1.0) * (r * r / nu).ln_1p()).sqrt();
                // s/r -> √((ν + 1)/ν) as r -> 0.
                let slope =
                    if r.abs() < 1e-7 { ((nu + 1.0) / nu).sqrt() } else { (nu + 1.0) * r.abs() / (nu + r * r) / s };
                (s.copysign(r), slope)
            }
            Loss::Squares | Loss::Huber(_) => (r, 1.0),
        }
    }

    /// Its number, which must be above zero.
    pub(crate) fn number(self) -> Option<f64> {
        match self {
            Loss::Squares => None,
            Loss::Huber(k) | Loss::StudentT(k) => Some(k),
        }
    }
}

/// A word, or a word with a number: `squares`, `{huber: 2}`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice {
    pub(crate) word: String,
    pub(crate) number: Option<f64>,
}

impl Choice {
    pub(crate) fn new(word: &str, number: Option<f64>) -> Self {
        Self { word: word.to_string(), number }
    }

    /// "expected `a`, `b: number`", with the nearest word.
    pub(crate) fn refused(&self, expected: &str, words: &[&str]) -> String {
        let suggestion = crate::catalogue::did_you_mean(&self.word, words.iter().copied());
        format!("`{}` is not one of {expected}, or lacks its number, or has one too many{suggestion}", self.word)
    }
}

impl Serialize for Choice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.number {
            None => serializer.serialize_str(&self.word),
            Some(number) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry(&self.word, &number)?;
                map.end()
            }
        }
    }
}

impl<'de> Deserialize<'de> for Choice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ChoiceVisitor;
        impl<'de> Visitor<'de> for ChoiceVisitor {
            type Value = Choice;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a word, or a word with a number such as `{huber: 2}`")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Choice, E> {
                Ok(Choice::new(text, None))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Choice, A::Error> {
                let wrong = || de::Error::custom("expected one word with one number, such as `{huber: 2}`");
                let (word, number): (String, f64) = map.next_entry()?.ok_or_else(wrong)?;
                if map.next_key::<String>()?.is_some() {
                    return Err(wrong());
                }
                Ok(Choice { word, number: Some(number) })
            }
        }
        deserializer.deserialize_any(ChoiceVisitor)
    }
}

impl TryFrom<Choice> for Loss {
    type Error = String;

    fn try_from(c: Choice) -> Result<Self, String> {
        match (c.word.as_str(), c.number) {
            ("squares", None) => Ok(Loss::Squares),
            ("huber", Some(k)) => Ok(Loss::Huber(k)),
            ("student-t", Some(nu)) => Ok(Loss::StudentT(nu)),
            _ => Err(c.refused(
                "`squares`, `{huber: k}`, `{student-t: degrees of freedom}`",
                &["squares", "huber", "student-t"],
            )),
        }
    }
}

impl From<Loss> for Choice {
    fn from(loss: Loss) -> Self {
        match loss {
            Loss::Squares => Choice::new("squares", None),
            Loss::Huber(k) => Choice::new("huber", Some(k)),
            Loss::StudentT(nu) => Choice::new("student-t", Some(nu)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_square_is_the_loss_and_the_slope_its_derivative() {
        for loss in [Loss::Squares, Loss::Huber(1.5), Loss::StudentT(4.0)] {
            for r in [-30.0, -2.0, -1.0, -1e-9, 0.0, 0.3, 1.4, 7.0] {
                let (s, slope) = loss.transform(r);
                let rho = match loss {
                    Loss::Huber(k) if r.abs() > k => k * r.abs() - k * k / 2.0,
                    Loss::StudentT(nu) => f64::midpoint(nu, 1.0) * (1.0 + r * r / nu).ln(),
                    _ => r * r / 2.0,
                };
                assert!((0.5 * s * s - rho).abs() < 1e-12 * (1.0 + rho), "{loss:?} {r}");
                let h = 1e-5;
                let difference = (loss.transform(r + h).0 - loss.transform(r - h).0) / (2.0 * h);
                assert!((difference - slope).abs() < 1e-6, "{loss:?} {r}: {difference} {slope}");
            }
        }
    }
}
