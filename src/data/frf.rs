//! Frequency response functions as they are measured.

use crate::linalg::Complex;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a frequency response function is: response over force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrfQuantity {
    /// Displacement over force, m/N.
    Receptance,
    /// Velocity over force, m/(N s).
    Mobility,
    /// Acceleration over force, 1/kg.
    Accelerance,
}

impl FrfQuantity {
    /// Number of time derivatives from displacement: 0, 1, 2; the FRF is (iω)^order times the receptance.
    pub fn order(self) -> i32 {
        self as i32
    }
}

/// One end of a frequency response function: a named point and a signed direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the point: the sensor's name, or the node's label in a universal file.
    pub name: String,
    /// Signed unit direction in global axes, when known.
    pub direction: Option<[f64; 3]>,
}

impl Channel {
    /// Name and direction, `12.+z`; a direction that is not along an axis is left out.
    pub fn label(&self) -> String {
        let along = self.direction.and_then(|d| {
            let axis = (0..3).find(|i| d[*i].abs() > 1.0 - 1.0e-12)?;
            Some(format!("{}.{}{}", self.name, if d[axis] < 0.0 { '-' } else { '+' }, ["x", "y", "z"][axis]))
        });
        along.unwrap_or_else(|| self.name.clone())
    }
}

/// A set of frequency response functions on common frequency lines.
///
/// `h[(line * n_references + reference) * n_responses + response]`; a function that was not measured is NaN in all lines.
#[derive(Debug, Clone, PartialEq)]
pub struct FrfSet {
    /// Which kind of function.
    pub quantity: FrfQuantity,
    /// Frequency lines, Hz, ascending.
    pub frequencies_hz: Vec<f64>,
    /// Points of excitation.
    pub references: Vec<Channel>,
    /// Points of response.
    pub responses: Vec<Channel>,
    /// The values, SI.
    pub h: Vec<Complex<f64>>,
    /// Ordinary coherence of each value, in the layout of `h`, when measured.
    pub coherence: Option<Vec<f64>>,
    /// Number of averages behind each line, when known: with the coherence it gives the variance of `h`.
    pub n_averages: Option<usize>,
}

impl FrfSet {
    /// Number of frequency lines.
    pub fn n_lines(&self) -> usize {
        self.frequencies_hz.len()
    }

    /// Index into `h` and `coherence`.
    pub fn index(&self, line: usize, reference: usize, response: usize) -> usize {
        (line * self.references.len() + reference) * self.responses.len() + response
    }

    /// The value at a line, reference and response.
    pub fn at(&self, line: usize, reference: usize, response: usize) -> Complex<f64> {
        self.h[self.index(line, reference, response)]
    }

    /// How many values of the measured functions are no numbers, and how many values these functions have.
    pub fn missing(&self) -> (usize, usize) {
        let (mut missing, mut all) = (0, 0);
        for reference in 0..self.references.len() {
            for response in 0..self.responses.len() {
                let values = (0..self.n_lines()).map(|line| self.at(line, reference, response));
                let n_known = values.filter(|h| h.is_finite()).count();
                if n_known > 0 {
                    missing += self.n_lines() - n_known;
                    all += self.n_lines();
                }
            }
        }
        (missing, all)
    }
}
