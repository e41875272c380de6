//! Units of foreign files.

use crate::data::FrfQuantity;
use crate::data::uff::{Dataset, Level, Note, Units, UniversalFile};

/// A thing the user must say, because the file does not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// What it is about, and the option that answers it: `units`, `quantity`, `duplicates`.
    pub option: &'static str,
    /// What is asked and why.
    pub text: String,
    /// Possible answers.
    pub answers: Vec<String>,
}

/// Standard gravity, m/s². Source: 3rd General Conference on Weights and Measures, 1901.
const GRAVITY: f64 = 9.806_65;
/// A pound-force in newtons: 0.453 592 37 kg times standard gravity.
const POUND_FORCE: f64 = 0.453_592_37 * GRAVITY;

/// Units of length, force and, where it has one of its own, acceleration, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitSystem {
    /// Its name, for messages.
    pub name: String,
    /// The unit of length, m.
    pub length: f64,
    /// The unit of force, N.
    pub force: f64,
    /// The unit of acceleration, m/s², when it is not the unit of length per s².
    pub acceleration: Option<f64>,
}

impl UnitSystem {
    /// The names that [`UnitSystem::from_name`] knows.
    pub const NAMES: [&'static str; 10] =
        ["SI", "mm-N-s", "mm-mN-s", "cm-cN-s", "m-kgf-s", "mm-kgf-s", "in-lbf-s", "ft-lbf-s", "m-N-g", "in-lbf-g"];

    /// A system by its name: unit of length, unit of force, then `s`, or `g` for accelerations in standard gravity.
    pub fn from_name(name: &str) -> Option<Self> {
        let spelled = if name.eq_ignore_ascii_case("SI") { "m-N-s" } else { name };
        let mut parts = spelled.split('-');
        let (length, force, time) = (parts.next()?, parts.next()?, parts.next()?);
        if parts.next().is_some() || !matches!(time, "s" | "g") {
            return None;
        }
        let acceleration = (time == "g").then_some(GRAVITY);
        Some(Self {
            name: name.to_owned(),
            length: unit_of_length(length)?,
            force: unit_of_force(force)?,
            acceleration,
        })
    }

    /// From dataset 164, in which an SI value is the value of the file divided by the factor.
    pub fn from_dataset(units: &Units) -> Option<Self> {
        let is_sound = |f: f64| f.is_finite() && f > 0.0;
        (is_sound(units.length) && is_sound(units.force)).then(|| Self {
            name: format!("dataset 164, code {} {}", units.code, units.description).trim_end().to_owned(),
            length: 1.0 / units.length,
            force: 1.0 / units.force,
            acceleration: None,
        })
    }

    /// One unit of a response of this quantity, in SI.
    pub fn response(&self, quantity: FrfQuantity) -> f64 {
        match quantity {
            FrfQuantity::Accelerance => self.acceleration.unwrap_or(self.length),
            FrfQuantity::Receptance | FrfQuantity::Mobility => self.length,
        }
    }
}

/// Where the units of a file come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum UnitsFrom {
    /// What the file says: dataset 164 and the labels of the axes, which must not contradict each other.
    #[default]
    File,
    /// The labels of the axes, against dataset 164 if need be.
    Labels,
    /// A stated system, whatever the file says.
    System(UnitSystem),
}

impl UnitsFrom {
    /// The name that [`UnitsFrom::from_name`] knows; `None` for what the file says.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::File => None,
            Self::Labels => Some("labels"),
            Self::System(system) => Some(&system.name),
        }
    }

    /// `file`, `labels`, or a system by its name.
    ///
    /// # Errors
    /// What names there are.
    pub fn from_name(name: &str) -> Result<Self, String> {
        match name {
            "file" => Ok(Self::File),
            "labels" => Ok(Self::Labels),
            _ => UnitSystem::from_name(name).map(Self::System).ok_or_else(|| {
                format!("`{name}` is not a system of units; there are {}, and `labels`", UnitSystem::NAMES.join(", "))
            }),
        }
    }
}

fn unit_of_length(word: &str) -> Option<f64> {
    Some(match word {
        "m" => 1.0,
        "dm" => 0.1,
        "cm" => 0.01,
        "mm" => 1.0e-3,
        "um" | "µm" | "μm" => 1.0e-6,
        "in" | "inch" => 0.0254,
        "ft" => 0.3048,
        _ => return None,
    })
}

fn unit_of_force(word: &str) -> Option<f64> {
    Some(match word {
        "N" => 1.0,
        "kN" => 1.0e3,
        "daN" => 10.0,
        "cN" => 0.01,
        "mN" => 1.0e-3,
        "lbf" | "lb" => POUND_FORCE,
        "kgf" | "kp" => GRAVITY,
        _ => return None,
    })
}

/// A label such as `m/s²`, `(mm/s^2)`, `g`: its quantity and one unit of it in SI.
pub fn response_unit(label: &str) -> Option<(FrfQuantity, f64)> {
    let text = plain(label);
    if matches!(text.as_str(), "g" | "gn" | "g0") {
        return Some((FrfQuantity::Accelerance, GRAVITY));
    }
    let (length, rest) = text.split_once('/').unwrap_or((&text, ""));
    let quantity = match rest {
        "" => FrfQuantity::Receptance,
        "s" => FrfQuantity::Mobility,
        "s2" | "s/s" | "sec2" => FrfQuantity::Accelerance,
        _ => return None,
    };
    Some((quantity, unit_of_length(length)?))
}

/// A label such as `N`, `lbf`: one unit of force in SI.
pub fn force_unit(label: &str) -> Option<f64> {
    unit_of_force(&plain(label))
}

/// A label of a ratio such as `m/s²/N`, `g/lbf`, `(1/N)*(m/s²)`: quantity, unit of response and unit of force in SI.
pub fn ratio_unit(label: &str) -> Option<(FrfQuantity, f64, f64)> {
    let text = plain(label);
    let (response, force) = match text.strip_prefix("1/").and_then(|t| t.split_once('*')) {
        Some((force, response)) => (response.to_owned(), force.to_owned()),
        None => text.rsplit_once('/').map(|(r, f)| (r.to_owned(), f.to_owned()))?,
    };
    let (quantity, unit) = response_unit(&response)?;
    Some((quantity, unit, unit_of_force(&force)?))
}

fn plain(label: &str) -> String {
    let text = label.replace("**", "^").replace('²', "2");
    text.chars().filter(|c| !matches!(c, '(' | ')' | '[' | ']' | '^' | ' ')).collect()
}

/// The dataset 164 that holds for a dataset of a file: the last before it, else the first after it.
pub(super) fn units_at(file: &UniversalFile, index: usize) -> Option<&Units> {
    fn units(dataset: &Dataset) -> Option<&Units> {
        match dataset {
            Dataset::Units(units) => Some(units),
            _ => None,
        }
    }
    let before = file.datasets.iter().take(index).rev().find_map(units);
    before.or_else(|| file.datasets.iter().skip(index).find_map(units))
}

/// One unit in SI, from what the file says in two places; they must agree to a thousandth.
pub(super) fn agreed(stated: Option<f64>, labelled: Option<f64>, what: &str) -> Result<f64, Question> {
    const AGREE: f64 = 1.0e-3;
    let answers = || {
        let mut answers: Vec<String> = UnitSystem::NAMES.map(String::from).to_vec();
        answers.push("labels".to_owned());
        answers
    };
    match (stated, labelled) {
        (Some(a), Some(b)) if (a / b - 1.0).abs() > AGREE => Err(Question {
            option: "units",
            text: format!(
                "dataset 164 says that the unit of {what} is {a} in SI, the label of its axis says {b}; which one holds?"
            ),
            answers: answers(),
        }),
        (Some(a), _) => Ok(a),
        (None, Some(b)) => Ok(b),
        (None, None) => Err(Question {
            option: "units",
            text: format!("the unit of {what} is not stated: neither dataset 164 nor a label that is understood"),
            answers: answers(),
        }),
    }
}

/// Units of length and force for geometry or shapes.
pub(super) fn plain_system(units: Option<&Units>, from: &UnitsFrom, what: &str) -> Result<UnitSystem, Question> {
    if let UnitsFrom::System(system) = from {
        return Ok(system.clone());
    }
    units.and_then(UnitSystem::from_dataset).ok_or_else(|| Question {
        option: "units",
        text: format!("the unit of {what} is not stated: there is no usable dataset 164"),
        answers: UnitSystem::NAMES.map(String::from).to_vec(),
    })
}

/// A note without place.
pub(super) fn note(level: Level, dataset: i64, seen: impl Into<String>, assumed: impl Into<String>) -> Note {
    Note { level, line: 0, dataset: Some(dataset), seen: seen.into(), assumed: assumed.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_understood_or_refused() {
        use FrfQuantity::{Accelerance, Mobility, Receptance};
        assert_eq!(response_unit("m/s²"), Some((Accelerance, 1.0)));
        assert_eq!(response_unit("(mm/s^2)"), Some((Accelerance, 1.0e-3)));
        assert_eq!(response_unit("g"), Some((Accelerance, 9.80665)));
        assert_eq!(response_unit("in/s"), Some((Mobility, 0.0254)));
        assert_eq!(response_unit("m"), Some((Receptance, 1.0)));
        assert_eq!(response_unit("Pa"), None);
        assert_eq!(ratio_unit("m/s2/N"), Some((Accelerance, 1.0, 1.0)));
        assert_eq!(ratio_unit("(1/N)*(m/s²)"), Some((Accelerance, 1.0, 1.0)));
        assert_eq!(ratio_unit("g/lbf"), Some((Accelerance, 9.80665, 0.45359237 * 9.80665)));
        assert_eq!(ratio_unit("NONE"), None);
    }

    #[test]
    fn the_named_systems_exist_and_the_pound_is_right() {
        for name in UnitSystem::NAMES {
            assert!(UnitSystem::from_name(name).is_some(), "{name}");
        }
        assert_eq!(UnitSystem::from_name("furlong-N-s"), None);
        // The example of dataset 164: 0.224808943099710480 pounds in a newton.
        let pounds = 1.0 / UnitSystem::from_name("ft-lbf-s").unwrap().force;
        assert!((pounds / 0.224_808_943_099_710_48 - 1.0).abs() < 1.0e-7);
    }
}
