//! What the user says that variables are.

use super::{MeasurementError, Variable};
use crate::catalogue::did_you_mean;
use crate::data::convert::ConvertError;
use std::borrow::Borrow;
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
    Components,
    Modes,
}

const AXES: [(&str, Axis); 6] = [
    ("lines", Axis::Lines),
    ("responses", Axis::Responses),
    ("references", Axis::References),
    ("points", Axis::Points),
    ("components", Axis::Components),
    ("modes", Axis::Modes),
];

/// A variable as the user names it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    pub(super) role: Role,
    pub(super) name: String,
    /// The variable of its imaginary part, or of its phase.
    pub(super) imaginary: Option<String>,
    /// What runs along its axes, in order; empty where that is left open.
    pub(super) axes: Vec<Axis>,
}

/// Which variables of files of arrays are meant, and what they are.
///
/// ```text
/// frequency=wn,shapes=V,damping=z        modes; shapes=V:modes-points says what runs along the axes
/// frequency=x,functions=Hre+Him          functions of a real and an imaginary part, or of an amplitude and a phase
/// functions=H:lines-responses-references the order of the axes
/// functions=H:lines-points-components    components along x, y and z at each point
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
                format!("`{}` is not a `role=name`; the roles are {}", part.escape_debug(), words().join(", "))
            })?;
            let word = word.trim();
            let Some(&(_, role)) = ROLES.iter().find(|r| r.0 == word) else {
                let hint = did_you_mean(word, words());
                return Err(format!(
                    "`{}` is not a role of a variable{hint}; there are {}",
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
                return Err(format!("`{part}`: an axis is given twice"));
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
