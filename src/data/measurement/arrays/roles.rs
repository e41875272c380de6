//! What the user says that variables are.

use super::{MeasurementError, Variable, names};
use crate::catalogue::did_you_mean;
use crate::data::convert::ConvertError;
use crate::data::npy;
use crate::linalg::Complex;
use std::borrow::{Borrow, Cow};
use std::fmt;

/// What a variable may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Frequency,
    Functions,
    Shapes,
    Damping,
    Eigenvalues,
    Coherence,
    Points,
}

const ROLES: [(&str, Role); 7] = [
    ("frequency", Role::Frequency),
    ("functions", Role::Functions),
    ("shapes", Role::Shapes),
    ("damping", Role::Damping),
    ("eigenvalues", Role::Eigenvalues),
    ("coherence", Role::Coherence),
    ("points", Role::Points),
];

/// What runs along an axis of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    Lines,
    Responses,
    References,
    Points,
    Modes,
}

const AXES: [(&str, Axis); 5] = [
    ("lines", Axis::Lines),
    ("responses", Axis::Responses),
    ("references", Axis::References),
    ("points", Axis::Points),
    ("modes", Axis::Modes),
];

/// A variable as the user names it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    pub(super) role: Role,
    pub(super) name: String,
    /// The variable of its imaginary part.
    imaginary: Option<String>,
    /// What runs along its axes, in order; empty where that is left open.
    pub(super) axes: Vec<Axis>,
}

/// Which variables of files of arrays are meant, and what they are.
///
/// ```text
/// frequency=wn,shapes=V,damping=z        modes; shapes=V:modes-points says what runs along the axes
/// frequency=x,functions=Hre+Him          functions of a real and an imaginary part
/// functions=H:lines-responses-references the order of the axes
/// eigenvalues=lam,shapes=V               poles in 1/s, or real ω² in rad²/s²
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Roles {
    text: String,
    pub(super) list: Vec<Named>,
}

impl Roles {
    /// Reads `role=name` pairs, separated by commas.
    ///
    /// # Errors
    /// What is wrong, with the roles and axes there are.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut list: Vec<Named> = Vec::new();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let words = || ROLES.map(|r| r.0);
            let (word, name) = part.split_once('=').ok_or_else(|| {
                format!("`{}` is no `role=name`; the roles are {}", part.escape_debug(), words().join(", "))
            })?;
            let word = word.trim();
            let Some(&(_, role)) = ROLES.iter().find(|r| r.0 == word) else {
                let hint = did_you_mean(word, words());
                return Err(format!(
                    "`{}` is no role of a variable{hint}; there are {}",
                    word.escape_debug(),
                    words().join(", ")
                ));
            };
            if list.iter().any(|n| n.role == role) {
                return Err(format!("`{word}` is given twice"));
            }
            let axis = |w: &str| AXES.iter().find(|a| a.0 == w).map(|a| a.1);
            let split = name.rsplit_once(':').and_then(|(name, axes)| {
                Some((name, axes.split('-').map(|w| axis(w.trim())).collect::<Option<Vec<Axis>>>()?))
            });
            let (name, axes) = split.unwrap_or((name, Vec::new()));
            if axes.iter().enumerate().any(|(i, a)| axes[..i].contains(a)) {
                return Err(format!("`{part}`: an axis stands twice"));
            }
            let (name, imaginary) = match name.split_once('+') {
                Some((re, im)) => (re.trim(), Some(im.trim().to_string())),
                None => (name.trim(), None),
            };
            list.push(Named { role, name: name.to_string(), imaginary, axes });
        }
        Ok(Self { text: text.trim().to_string(), list })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    pub(super) fn get(&self, role: Role) -> Option<&Named> {
        self.list.iter().find(|n| n.role == role)
    }
}

impl fmt::Display for Roles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The variable of a name.
pub(super) fn find<V: Borrow<Variable>>(list: &[V], name: &str) -> Result<usize, MeasurementError> {
    list.iter().position(|v| v.borrow().name == name).ok_or_else(|| {
        let hint = did_you_mean(name, list.iter().map(|v| v.borrow().name.as_str()));
        let held = super::listed(&list.iter().map(|v| v.borrow().label()).collect::<Vec<_>>());
        let why =
            format!("there is no such variable{hint}; there are {}", if held.is_empty() { "none" } else { &held });
        ConvertError::Unusable { what: format!("`{}`", name.escape_debug()), why }.into()
    })
}

/// The variables with real and imaginary parts put together: those that the user names, and those whose names say so.
pub(super) fn joined<'a>(list: &'a [Variable], roles: &Roles) -> Result<Vec<Cow<'a, Variable>>, MeasurementError> {
    /// Beyond this the names of a file are not compared with one another.
    const MOST: usize = 500;
    let mut pairs: Vec<(usize, usize, String)> = Vec::new();
    for named in &roles.list {
        if let Some(imaginary) = &named.imaginary {
            pairs.push((find(list, &named.name)?, find(list, imaginary)?, named.name.clone()));
        }
    }
    for (i, a) in list.iter().enumerate().filter(|_| list.len() <= MOST) {
        for (j, b) in list.iter().enumerate() {
            let is_taken = pairs.iter().any(|p| [p.0, p.1].iter().any(|k| *k == i || *k == j));
            if i == j || is_taken || a.is_complex() || b.is_complex() || a.array.shape != b.array.shape {
                continue;
            }
            if let Some(stem) = names::stem(&a.name, &b.name) {
                pairs.push((i, j, stem));
            }
        }
    }
    let mut out = Vec::with_capacity(list.len());
    for (i, variable) in list.iter().enumerate() {
        if pairs.iter().any(|p| p.1 == i) {
            continue;
        }
        let Some((_, j, name)) = pairs.iter().find(|p| p.0 == i) else {
            out.push(Cow::Borrowed(variable));
            continue;
        };
        let other = &list[*j];
        let (npy::Values::Real(re), npy::Values::Real(im)) = (&variable.array.values, &other.array.values) else {
            let why = "a real and an imaginary part are real arrays".to_string();
            return Err(
                ConvertError::Unusable { what: format!("{} and {}", variable.label(), other.label()), why }.into()
            );
        };
        if variable.array.shape != other.array.shape {
            let why = "a real and an imaginary part have one size".to_string();
            return Err(
                ConvertError::Unusable { what: format!("{} and {}", variable.label(), other.label()), why }.into()
            );
        }
        let values = re.iter().zip(im).map(|(re, im)| Complex::new(*re, *im)).collect();
        let array = npy::Array { shape: variable.array.shape.clone(), values: npy::Values::Complex(values) };
        out.push(Cow::Owned(Variable { name: name.clone(), array, is_matlab: variable.is_matlab }));
    }
    Ok(out)
}
