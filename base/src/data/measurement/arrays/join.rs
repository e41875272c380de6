//! Variables that are parts of one: real and imaginary parts, amplitudes and phases, one function of many each.

use super::names::{self, Parts, PhaseUnit, Says, says};
use super::roles::{Role, Roles, find};
use super::{MeasurementError, Variable};
use crate::data::convert::ConvertError;
use crate::data::npy;
use retune_linalg::Complex;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// Beyond this the names of a file are not compared with one another.
const MOST: usize = 500;

/// The variables with their parts put together: those that the user names, and those whose names say so.
pub(super) fn joined<'a>(
    list: &'a [Variable],
    roles: &Roles,
    notes: &mut Vec<String>,
) -> Result<Vec<Cow<'a, Variable>>, MeasurementError> {
    let mut pairs: Vec<(usize, usize, String, Parts)> = Vec::new();
    for named in &roles.list {
        if let Some(second) = &named.imaginary {
            let parts = names::parts_of(&named.name, second);
            pairs.push((find(list, &named.name)?, find(list, second)?, named.name.clone(), parts));
        }
    }
    for (i, a) in list.iter().enumerate().filter(|_| list.len() <= MOST) {
        for (j, b) in list.iter().enumerate() {
            let is_taken = pairs.iter().any(|p| [p.0, p.1].iter().any(|k| *k == i || *k == j));
            if i == j || is_taken || a.is_complex() || b.is_complex() || a.array.shape != b.array.shape {
                continue;
            }
            if let Some((stem, parts)) = names::stem(&a.name, &b.name) {
                pairs.push((i, j, stem, parts));
            }
        }
    }
    let mut out = Vec::with_capacity(list.len());
    for (i, variable) in list.iter().enumerate() {
        if pairs.iter().any(|p| p.1 == i) {
            continue;
        }
        out.push(match pairs.iter().find(|p| p.0 == i) {
            None => Cow::Borrowed(variable),
            Some((_, j, name, parts)) => Cow::Owned(complex(variable, &list[*j], name, *parts, notes)?),
        });
    }
    Ok(stacked(out, roles, notes))
}

/// One complex array of two real ones.
fn complex(
    first: &Variable,
    second: &Variable,
    name: &str,
    parts: Parts,
    notes: &mut Vec<String>,
) -> Result<Variable, MeasurementError> {
    let what = match parts {
        Parts::Cartesian => "a real and an imaginary part",
        Parts::Polar(_) => "an amplitude and a phase",
    };
    let wrong = |why: String| -> MeasurementError {
        ConvertError::Unusable { what: format!("{} and {}", first.label(), second.label()), why }.into()
    };
    let (npy::Values::Real(a), npy::Values::Real(b)) = (&first.array.values, &second.array.values) else {
        return Err(wrong(format!("{what} are real arrays")));
    };
    if first.array.shape != second.array.shape {
        return Err(wrong(format!("{what} have one size")));
    }
    let values = match parts {
        Parts::Cartesian => a.iter().zip(b).map(|(re, im)| Complex::new(*re, *im)).collect(),
        Parts::Polar(unit) => {
            if let Some(value) = a.iter().find(|x| **x < 0.0) {
                return Err(wrong(format!("the amplitude {value} is negative; amplitudes in dB are not read")));
            }
            let unit = unit.or_else(|| phase_unit(b)).ok_or_else(|| {
                wrong(
                    "the phase does not say its unit, and its values fit both; name it `..._deg` or `..._rad`"
                        .to_string(),
                )
            })?;
            let (one, word) = match unit {
                PhaseUnit::Degrees => (PI / 180.0, "degrees"),
                PhaseUnit::Radians => (1.0, "radians"),
            };
            notes.push(format!(
                "variables `{}` and `{}` are taken for amplitude and phase in {word}",
                first.name.escape_debug(),
                second.name.escape_debug()
            ));
            a.iter().zip(b).map(|(r, phase)| Complex::from_polar(*r, phase * one)).collect()
        }
    };
    let array = npy::Array { shape: first.array.shape.clone(), values: npy::Values::Complex(values) };
    Ok(Variable { name: name.to_string(), array, is_matlab: first.is_matlab })
}

/// Unit of phases by their range: within half a turn of one unit, and far outside that of the other.
fn phase_unit(phases: &[f64]) -> Option<PhaseUnit> {
    let largest = phases.iter().filter(|x| x.is_finite()).map(|x| x.abs()).fold(0.0, f64::max);
    // Rounding of a file; functions turn by half a turn at every resonance.
    if largest <= PI * 1.001 {
        Some(PhaseUnit::Radians)
    } else if largest > 45.0 {
        Some(PhaseUnit::Degrees)
    } else {
        None
    }
}

/// Vectors whose names say that each is one function of many, `H11` and `H21`, as one array (lines x references x responses). The first number
/// of two is that of the response; a table of all numbers must be full, and nothing that the user names is touched.
fn stacked<'a>(list: Vec<Cow<'a, Variable>>, roles: &Roles, notes: &mut Vec<String>) -> Vec<Cow<'a, Variable>> {
    if roles.get(Role::Functions).is_some() || list.len() > MOST {
        return list;
    }
    // By letters, length and how many numbers there are: which variable has which numbers.
    let mut sets: BTreeMap<(String, usize, usize), BTreeMap<Vec<usize>, usize>> = BTreeMap::new();
    let mut twice = BTreeSet::new();
    for (i, v) in list.iter().enumerate() {
        let is_function = v.is_complex() && v.axes().len() == 1 && says(&v.name) == Says::Functions;
        if let Some((letters, numbers)) = names::numbered(&v.name).filter(|_| is_function) {
            let key = (letters, v.axes()[0], numbers.len());
            if sets.entry(key.clone()).or_default().insert(numbers, i).is_some() {
                twice.insert(key);
            }
        }
    }
    let mut out = list;
    let mut gone = BTreeSet::new();
    for (key, members) in sets.into_iter().filter(|(k, m)| m.len() > 1 && !twice.contains(k)) {
        let (letters, n_lines, _) = key;
        let responses: Vec<usize> = members.keys().map(|n| n[0]).collect::<BTreeSet<_>>().into_iter().collect();
        let references: Vec<usize> =
            members.keys().map(|n| n.get(1).copied().unwrap_or(0)).collect::<BTreeSet<_>>().into_iter().collect();
        if responses.len() * references.len() != members.len() {
            continue;
        }
        let mut values = vec![Complex::ZERO; n_lines * members.len()];
        for (numbers, &i) in &members {
            let o = responses.iter().position(|n| *n == numbers[0]).unwrap_or(0);
            let r = references.iter().position(|n| Some(n) == numbers.get(1)).unwrap_or(0);
            for line in 0..n_lines {
                values[(line * references.len() + r) * responses.len() + o] = out[i].at(line);
            }
        }
        let name = |i: &usize| format!("`{}`", out[*i].name.escape_debug());
        let used: Vec<String> = members.values().map(name).collect();
        let numbers = |list: &[usize]| list.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let of = if references.len() > 1 || references != [0] {
            format!(
                "the first number is that of the response, {}, the second that of the reference, {}",
                numbers(&responses),
                numbers(&references)
            )
        } else {
            format!("the number is that of the response, {}", numbers(&responses))
        };
        notes.push(format!("variables {} are taken together for functions: {of}", super::listed(&used)));
        let array = npy::Array {
            shape: vec![n_lines, references.len(), responses.len()],
            values: npy::Values::Complex(values),
        };
        let mut indices = members.into_values();
        if let Some(first) = indices.next() {
            gone.extend(indices);
            // In the order of this program, which is that of arrays of NumPy.
            out[first] = Cow::Owned(Variable { name: letters, array, is_matlab: false });
        }
    }
    let mut at = 0..;
    out.retain(|_| !at.next().is_some_and(|i| gone.contains(&i)));
    out
}
