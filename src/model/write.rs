//! Changing values in the text of a model file, with everything else left as it stands.

use super::spec::ModelSpec;
use crate::units::{Scalar, Unit};
use crate::yaml::{self, Problem};

/// Why a text cannot be changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The text is no model file.
    #[error("the text is no model file: {0}")]
    NotAModel(Problem),
    /// A parameter is not there.
    #[error("the file has no parameter `{name}`")]
    NoParameter {
        /// Its name.
        name: String,
    },
}

/// Writes new estimates, in SI, of parameters into the text of a model file, each in the unit it is written in.
///
/// Comments, order and formatting of everything else stay as they are. The shortest decimal that gives the value back
/// to within 1e-15 is written.
pub fn set_parameter_values(text: &str, values: &[(&str, f64)]) -> Result<String, WriteError> {
    let (spec, map) = yaml::read::<ModelSpec>(text).map_err(|mut p| WriteError::NotAModel(p.swap_remove(0)))?;
    let mut changes = Vec::new();
    for &(name, value) in values {
        let missing = || WriteError::NoParameter { name: name.to_string() };
        let parameter = spec.parameters.get(name).ok_or_else(missing)?;
        let range = map.range(&format!("parameters.{name}.value")).ok_or_else(missing)?;
        changes.push((range, written(&parameter.value, value)));
    }
    changes.sort_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(text.len());
    let mut done = 0;
    for (range, new) in changes {
        out.push_str(&text[done..range.start]);
        out.push_str(&new);
        done = range.end;
    }
    out.push_str(&text[done..]);
    Ok(out)
}

/// A value in the unit of the scalar that it replaces.
fn written(old: &Scalar, value: f64) -> String {
    let unit = unit_text(old.text()).and_then(|u| Unit::parse(u).ok().map(|unit| (u, unit)));
    match unit {
        Some((text, unit)) => format!("{} {text}", shortest(value, unit.factor)),
        None => shortest(value, 1.0),
    }
}

/// The unit behind the number: `GPa` of `56 GPa`.
fn unit_text(text: &str) -> Option<&str> {
    let end = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | ' ' | 'e' | 'E')))?;
    Some(text[end..].trim()).filter(|t| !t.is_empty())
}

/// The shortest decimal whose product with `factor` is `value` to within 1e-15.
fn shortest(value: f64, factor: f64) -> String {
    let number = value / factor;
    (6..17)
        .map(|digits| format!("{number:.digits$e}").parse().unwrap_or(number))
        .find(|rounded: &f64| (rounded * factor - value).abs() <= 1e-15 * value.abs())
        .map_or_else(|| format!("{number:?}"), |rounded| format!("{rounded:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_change_and_comments_stay() {
        let text = "retune: 1 # one\nname: x\nparameters:\n  E: {value: 40 GPa, bounds: [1 GPa, 2 GPa]} # steel\n  m:\n    # mass\n    value: 2\nnodes: {a: [0, 0, 0]}\n";
        let new = set_parameter_values(text, &[("m", 0.1 + 0.2), ("E", 56.25e9)]).unwrap();
        assert_eq!(new, text.replace("40 GPa", "56.25 GPa").replace("value: 2\n", "value: 0.3\n"));
        assert!(set_parameter_values(text, &[("z", 1.0)]).is_err());
    }
}
