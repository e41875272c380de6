//! Parameters of the file: values, bounds, units.

use crate::model::parameter::{Parameter, ParameterSet};
use crate::model::spec::ModelSpec;
use crate::units::{Dimension, Scalar, Unit};
use crate::yaml::{Problem, child};
use std::collections::BTreeMap;

/// Reads parameters; bounds and units are checked.
pub(in crate::model) fn parameters(
    spec: &ModelSpec,
    problems: &mut Vec<Problem>,
) -> (ParameterSet, BTreeMap<String, Dimension>) {
    let mut set = Vec::new();
    let mut dimensions = BTreeMap::new();
    for (name, p) in &spec.parameters {
        let path = child("parameters", name);
        if !name.starts_with(|c: char| c.is_alphabetic() || c == '_')
            || !name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '.' | ':' | '@'))
        {
            problems.push(Problem::error(
                &path,
                "a parameter's name starts with a letter and has only letters, digits, `_`, `.`, `:`, `@`",
            ));
        }
        let unit_text = p
            .unit
            .clone()
            .or_else(|| written_unit(&p.value))
            .or_else(|| p.bounds.as_ref().and_then(|b| written_unit(&b[1])));
        let unit = match unit_text.as_deref().map(Unit::parse) {
            None => None,
            Some(Ok(unit)) => Some(unit),
            Some(Err(e)) => {
                problems.push(Problem::error(child(&path, "unit"), e));
                None
            }
        };
        let number = |s: &Scalar, key: &str, problems: &mut Vec<Problem>| -> f64 {
            let path = child(&path, key);
            let dimension = s.terms().first().and_then(|t| t.dimension);
            if let (Some(d), Some(u)) = (dimension, unit) {
                if d != u.dimension {
                    let unit = unit_text.as_deref().unwrap_or("1");
                    problems.push(Problem::error(
                        &path,
                        format_args!("the unit of `{}` does not fit: expected {unit}", s.text()),
                    ));
                }
            } else if dimension.is_none()
                && unit.is_some_and(|u| u.dimension != Dimension::NONE && u.factor != 1.0)
                && s.terms().iter().any(|t| t.factor != 0.0)
            {
                let unit = unit_text.as_deref().unwrap_or("1");
                let others = if p.unit.is_some() { "this parameter is" } else { "others of this parameter are" };
                problems.push(Problem::error(
                    &path,
                    format_args!("`{}` has no unit while {others} in {unit}; write `{} {unit}`", s.text(), s.text()),
                ));
            }
            if s.terms().iter().any(|t| t.parameter.is_some()) {
                problems.push(Problem::error(
                    path,
                    format_args!("`{}` names another parameter; here a number is needed", s.text()),
                ));
                return 0.0;
            }
            s.terms().iter().map(|t| t.factor).sum()
        };
        let before = problems.len();
        let value = number(&p.value, "value", problems);
        let bounds =
            p.bounds.as_ref().map(|b| [number(&b[0], "bounds[0]", problems), number(&b[1], "bounds[1]", problems)]);
        if let Some([lower, upper]) = bounds.filter(|_| problems.len() == before) {
            if lower >= upper {
                problems.push(Problem::error(
                    child(&path, "bounds"),
                    format_args!(
                        "the lower bound `{}` must be below the upper `{}`",
                        p.bounds.as_ref().map_or("", |b| b[0].text()),
                        p.bounds.as_ref().map_or("", |b| b[1].text())
                    ),
                ));
            } else if value < lower || value > upper {
                problems.push(Problem::warning(
                    child(&path, "value"),
                    format_args!(
                        "the estimate {} lies outside its bounds {} .. {}; an update starts from the nearest bound",
                        p.value.text(),
                        p.bounds.as_ref().map_or("", |b| b[0].text()),
                        p.bounds.as_ref().map_or("", |b| b[1].text())
                    ),
                ));
            }
        }
        let prior_sd = p.prior_sd.as_ref().map(|s| number(s, "prior_sd", problems));
        if prior_sd.is_some_and(|sd| sd <= 0.0) {
            problems.push(Problem::error(child(&path, "prior_sd"), "a standard deviation must be above zero"));
        }
        if let Some(u) = unit {
            dimensions.insert(name.clone(), u.dimension);
        }
        set.push(Parameter {
            name: name.clone(),
            unit: unit_text.unwrap_or_default(),
            unit_factor: unit.map_or(1.0, |u| u.factor),
            value,
            bounds,
            prior_sd,
            description: p.description.clone(),
        });
    }
    (ParameterSet::new(set), dimensions)
}

/// The unit as written behind a number: `GPa` of `56 GPa`.
fn written_unit(s: &Scalar) -> Option<String> {
    s.terms().first().and_then(|t| t.dimension)?;
    let text = s.text();
    let end = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | ' ' | 'e' | 'E')))?;
    Some(text[end..].trim().to_string())
}
