//! Arrays without units, and often without names: NumPy files and archives, and the variables of MATLAB files. One reading for all.
//!
//! A variable counts for what its name says ([`names`]) where its size allows that, or for what the user says it is ([`Roles`]):
//! nothing is taken because it happens to fit.
//!
//! | what | arrays |
//! |---|---|
//! | functions | a real vector of frequencies (lines) and a complex array, (lines x responses) or with references or components as a third axis, or a vector for each function |
//! | modes | frequencies (modes) or poles, shapes (points x modes), (points x 3 x modes), and damping ratios where there are |
//!
//! Vectors may be rows or columns, axes are found by their length, and two real arrays may be real and imaginary part,
//! or amplitude and phase.

mod build;
mod flatten;
mod join;
mod names;
mod pick;
mod roles;
#[cfg(test)]
mod tests;

pub use roles::Roles;

pub(super) use flatten::of_matlab;

use super::{MeasurementError, MeasurementOptions};
use crate::data::convert::{ConvertError, Question};
use crate::data::{FrfSet, npy};
use pick::Pick;
use retune_linalg::Complex;

/// A named array, its last index fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) array: npy::Array,
    /// Whether it comes from MATLAB, whose own functions order references after responses.
    pub(super) is_matlab: bool,
}

impl Variable {
    /// `H (200 x 4)`.
    fn label(&self) -> String {
        let size: Vec<String> = self.array.shape.iter().map(ToString::to_string).collect();
        format!("{} ({})", self.name.escape_debug(), if size.is_empty() { "1".to_string() } else { size.join(" x ") })
    }

    /// Lengths of its axes that are longer than one.
    fn axes(&self) -> Vec<usize> {
        self.array.shape.iter().copied().filter(|n| *n != 1).collect()
    }

    /// Its values as a real vector of either orientation.
    fn vector(&self) -> Option<&[f64]> {
        match &self.array.values {
            npy::Values::Real(v) if self.axes().len() <= 1 && !v.is_empty() => Some(v),
            _ => None,
        }
    }

    fn is_complex(&self) -> bool {
        matches!(self.array.values, npy::Values::Complex(_))
    }

    fn at(&self, index: usize) -> Complex<f64> {
        match &self.array.values {
            npy::Values::Real(v) => Complex::new(v[index], 0.0),
            npy::Values::Complex(v) => v[index],
        }
    }
}

/// Modes of arrays: a row of values for each.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ModeTable {
    /// Frequency in Hz, damping ratio where known, and values at the channels.
    pub(super) modes: Vec<(f64, Option<f64>, Vec<Complex<f64>>)>,
    /// Names of the points.
    pub(super) points: Vec<String>,
    /// Whether each point has three channels, along x, y and z.
    pub(super) has_components: bool,
}

/// What arrays are.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) functions: Option<FrfSet>,
    pub(super) modes: Option<ModeTable>,
    pub(super) notes: Vec<String>,
}

/// The arrays of one file, or of several that complete one another.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// Arrays of numbers.
    pub(super) variables: Vec<Variable>,
    /// Names of what are none.
    pub(super) others: Vec<String>,
}

impl Workspace {
    /// Puts the variables of another file beside these.
    pub(super) fn extend(&mut self, other: Workspace) {
        self.variables.extend(other.variables);
        self.others.extend(other.others);
    }

    /// Reads functions and modes; `None` where the names say of neither what it is.
    pub(super) fn read(&self, options: &MeasurementOptions) -> Result<Option<Found>, MeasurementError> {
        let mut notes = Vec::new();
        let list = join::joined(&self.variables, &options.variables, &mut notes)?;
        let pick = Pick::new(&list, &options.variables)?;
        if pick.functions.is_none() && pick.modes.is_none() {
            return Ok(None);
        }
        let mut found = Found { notes, ..Found::default() };
        let mut questions = Vec::new();
        let mut used = Vec::new();
        if let Some(picked) = &pick.functions {
            used.extend([picked.frequency, picked.values]);
            used.extend(picked.coherence);
            found.functions = build::functions(&list, picked, options, &mut found.notes, &mut questions)?;
        }
        if let Some(picked) = &pick.modes {
            used.extend([picked.source.variable(), picked.shapes]);
            used.extend(picked.damping);
            used.extend(picked.points);
            found.modes = build::modes(&list, picked, options, &mut found.notes, &mut questions)?;
        }
        if !questions.is_empty() {
            return Err(ConvertError::Questions(questions).into());
        }
        let left = list.iter().enumerate().filter(|(i, _)| !used.contains(i)).map(|(_, v)| v.name.as_str());
        let left: Vec<String> =
            left.chain(self.others.iter().map(String::as_str)).map(|n| format!("`{}`", n.escape_debug())).collect();
        if !left.is_empty() {
            found.notes.push(format!("left out: {}", listed(&left)));
        }
        Ok(Some(found))
    }

    /// The question that is left where the names do not say what the variables are.
    pub(super) fn question(&self) -> MeasurementError {
        let mut list: Vec<String> = self.variables.iter().map(Variable::label).collect();
        list.extend(self.others.iter().map(|n| format!("{} (no array of numbers)", n.escape_debug())));
        let held = if list.is_empty() { "there are none".to_string() } else { listed(&list) };
        let text = format!("the names of the variables do not say which of them are meant: {held}");
        let answers = ["frequency=NAME,shapes=NAME", "eigenvalues=NAME,shapes=NAME", "frequency=NAME,functions=NAME"];
        let answers = answers.map(String::from).to_vec();
        ConvertError::Questions(vec![Question { option: "variables", text, answers }]).into()
    }
}

/// A list for a message, cut where it is long.
fn listed(list: &[String]) -> String {
    const MOST: usize = 12;
    let shown = list.iter().take(MOST).cloned().collect::<Vec<_>>().join(", ");
    if list.len() > MOST { format!("{shown} and {} more", list.len() - MOST) } else { shown }
}
