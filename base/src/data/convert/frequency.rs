//! Abscissas of functions in Hz.

use super::units::Question;
use crate::data::uff::{Axis, Function};
use crate::units::FrequencyUnit;
use std::collections::BTreeSet;

/// Data type of an abscissa of speeds in revolutions per minute.
const RPM: i64 = 19;

/// What is said of the units of several axes, each thing once.
#[derive(Debug, Default)]
pub(super) struct AxisNotes(BTreeSet<(String, &'static str)>);

impl AxisNotes {
    /// What was seen and what was assumed.
    pub(super) fn each(self) -> impl Iterator<Item = (String, &'static str)> {
        self.0.into_iter()
    }
}

/// One unit of an abscissa in Hz: what the user states, else what the axis says, else 1.
///
/// # Errors
/// A question where the axis has a unit that is none of a frequency.
pub(super) fn hertz(axis: &Axis, stated: Option<&FrequencyUnit>, notes: &mut AxisNotes) -> Result<f64, Question> {
    let said = said(axis);
    let known = said.as_deref().and_then(FrequencyUnit::of_label);
    match (stated, said, known) {
        (Some(own), Some(said), known) => {
            if known.is_none_or(|k| (k.hertz / own.hertz - 1.0).abs() > 1e-9) {
                let seen = format!("frequencies labelled `{said}`, which the option says are {}", own.name);
                notes.0.insert((seen, "the option counts"));
            }
            Ok(own.hertz)
        }
        (Some(own), None, _) => Ok(own.hertz),
        (None, _, Some(unit)) => {
            if unit.hertz != 1.0 {
                notes.0.insert((format!("frequencies in {}", unit.name), "they were converted to Hz"));
            }
            Ok(unit.hertz)
        }
        (None, Some(said), None) => Err(Question {
            option: "frequency-unit",
            text: format!("`{said}` is not understood as the unit of frequencies"),
            answers: FrequencyUnit::NAMES.map(String::from).to_vec(),
        }),
        (None, None, None) => Ok(1.0),
    }
}

/// The unit that an axis states: its own field, else what stands in brackets in its label, else what its type implies.
fn said(axis: &Axis) -> Option<String> {
    let is_filled = |text: &str| !matches!(text.trim(), "" | "NONE" | "None" | "none");
    if is_filled(&axis.units) {
        return Some(axis.units.trim().to_owned());
    }
    let label = axis.label.trim();
    let bracket = [('(', ')'), ('[', ']')].into_iter().find_map(|(open, close)| {
        let (_, rest) = label.split_once(open)?;
        rest.split_once(close).map_or(Some(rest), |(inner, _)| Some(inner))
    });
    match bracket.filter(|b| is_filled(b)) {
        Some(unit) => Some(unit.trim().to_owned()),
        None if axis.data_type == RPM => Some("rpm".to_owned()),
        None => None,
    }
}

/// The abscissa of each point, in Hz.
pub(super) fn points_hz(f: &Function, hertz: f64) -> Vec<f64> {
    let mut points = f.points();
    if hertz != 1.0 {
        for x in &mut *points {
            *x *= hertz;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn axis(data_type: i64, label: &str, units: &str) -> Axis {
        Axis { label: label.to_owned(), units: units.to_owned(), ..Axis::of(data_type) }
    }

    #[test]
    fn the_unit_of_an_axis_is_read_where_it_stands() {
        let mut notes = AxisNotes::default();
        for (data_type, label, units, value) in [
            (18, "Frequency", "Hz", 1.0),
            (18, "Frequency", "NONE", 1.0),
            (18, "NONE", "", 1.0),
            (18, "Frequency", "rad/s", 1.0 / TAU),
            (18, "Frequency (deg/s)", "NONE", 1.0 / 360.0),
            (18, "Frequency [kHz]", "NONE", 1e3),
            (18, "Speed", "RPM", 1.0 / 60.0),
            (19, "NONE", "NONE", 1.0 / 60.0),
        ] {
            assert_eq!(hertz(&axis(data_type, label, units), None, &mut notes), Ok(value), "{label} {units}");
        }
        assert_eq!(notes.each().count(), 5);
    }

    #[test]
    fn a_unit_that_is_none_of_a_frequency_is_asked_about_and_the_answer_counts() {
        let mut notes = AxisNotes::default();
        let wrong = axis(18, "Frequency", "1/s");
        assert_eq!(hertz(&wrong, None, &mut notes).unwrap_err().option, "frequency-unit");
        let answer = FrequencyUnit::of_label("rad/s");
        assert_eq!(hertz(&wrong, answer.as_ref(), &mut notes), Ok(1.0 / TAU));
        assert_eq!(hertz(&axis(18, "Frequency", "Hz"), answer.as_ref(), &mut notes), Ok(1.0 / TAU));
        assert_eq!(notes.each().count(), 2);
    }
}
