//! Answers to what measurement files may leave open, as a user writes them.

use super::{MeasurementOptions, Measurements, Roles};
use crate::data::convert::{Duplicates, FrfOptions, LocalAxes, UnitsFrom};
use crate::data::{FrfQuantity, GeometryFrame};
use crate::units::FrequencyUnit;

/// Answers in words; what is absent is read from the files, or asked for.
#[derive(Debug, Clone, Copy, Default)]
pub struct Answers<'a> {
    /// Units of the files: `SI`, `mm-N-s`, `labels`.
    pub units: Option<&'a str>,
    /// What the functions are.
    pub quantity: Option<FrfQuantity>,
    /// Unit of the functions of a table without a row of units.
    pub unit: Option<&'a str>,
    /// Which of several functions of one pair of points counts.
    pub duplicates: Duplicates,
    /// Unit of the frequencies.
    pub frequency_unit: Option<&'a str>,
    /// Which of the matrices of local axes are axes.
    pub local_axes: Option<LocalAxes>,
    /// Direction of channels that do not know theirs: `+x` ... `-z`.
    pub direction: Option<&'a str>,
    /// Units of the geometry.
    pub geometry_units: Option<&'a str>,
    /// What variables of MATLAB and NumPy files are: `frequency=wn,shapes=V`.
    pub variables: Option<&'a str>,
    /// Where the axes of the geometry lie in the model.
    pub frame: Option<&'a str>,
}

impl Answers<'_> {
    /// The options of reading, and the frame of the geometry.
    ///
    /// # Errors
    /// An answer that is none, as `--option text: why`.
    pub fn options(&self) -> Result<(MeasurementOptions, Option<GeometryFrame>), String> {
        let frequency_unit = |text: &str| {
            let names = FrequencyUnit::NAMES.join(", ");
            FrequencyUnit::of_label(text)
                .ok_or_else(|| format!("--frequency-unit {text}: expected a unit of frequencies, such as {names}"))
        };
        let options = MeasurementOptions {
            frf: FrfOptions {
                units: self.units.map_or(Ok(UnitsFrom::File), UnitsFrom::from_name)?,
                quantity: self.quantity,
                duplicates: self.duplicates,
                frequency_unit: self.frequency_unit.map(frequency_unit).transpose()?,
                local_axes: self.local_axes,
            },
            unit: self.unit.map(str::to_string),
            geometry_units: self.geometry_units.map(UnitsFrom::from_name).transpose()?,
            direction: self.direction.map(axis).transpose()?,
            variables: self
                .variables
                .map_or(Ok(Roles::default()), Roles::parse)
                .map_err(|e| format!("--variables: {e}"))?,
        };
        let frame = self.frame.map(GeometryFrame::parse).transpose().map_err(|e| format!("--frame: {e}"))?;
        Ok((options, frame))
    }
}

/// A signed axis: `+x` ... `-z`.
fn axis(text: &str) -> Result<[f64; 3], String> {
    let sign = if text.starts_with('-') { -1.0 } else { 1.0 };
    let letter = text.strip_prefix(['+', '-']).unwrap_or(text);
    let at = ["x", "y", "z"].iter().position(|a| *a == letter);
    let at = at.ok_or_else(|| format!("--direction {text}: expected `+x`, `-x` ... `-z`"))?;
    let mut direction = [0.0; 3];
    direction[at] = sign;
    Ok(direction)
}

impl Measurements {
    /// Turns and moves everything from the axes of a geometry into those of the model.
    pub fn turn(&mut self, frame: &GeometryFrame) {
        if let Some(geometry) = &mut self.geometry {
            frame.place(geometry);
        }
        if let Some(set) = &mut self.frfs {
            frame.turn_functions(set);
        }
        if let Some(modes) = &mut self.modes {
            frame.turn_modes(modes);
        }
    }
}
