//! Frequency response functions as they are measured.

use retune_linalg::Complex;
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

crate::catalogue::choice! { FrfQuantity, "quantity";
    Receptance "receptance" "Displacement over force",
    Mobility "mobility" "Velocity over force",
    Accelerance "accelerance" "Acceleration over force",
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

    /// The set with the points that roved as responses: where more references than responses were measured, as with a hammer that roves and
    /// sensors that stay, references and responses change places by reciprocity, H_oi = H_io. Shapes are then at the points that were
    /// hit.
    pub fn by_reciprocity(&self) -> std::borrow::Cow<'_, Self> {
        let (n_ref, n_res) = (self.references.len(), self.responses.len());
        let is_measured = |i: usize, o: usize| {
            (0..self.n_lines()).any(|l| {
                let h = self.at(l, i, o);
                h.is_finite() && h != Complex::ZERO
            })
        };
        let references = (0..n_ref).filter(|&i| (0..n_res).any(|o| is_measured(i, o))).count();
        let responses = (0..n_res).filter(|&o| (0..n_ref).any(|i| is_measured(i, o))).count();
        if references <= responses {
            return std::borrow::Cow::Borrowed(self);
        }
        std::borrow::Cow::Owned(Self {
            quantity: self.quantity,
            frequencies_hz: self.frequencies_hz.clone(),
            references: self.responses.clone(),
            responses: self.references.clone(),
            h: turn(&self.h, n_ref, n_res),
            coherence: self.coherence.as_ref().map(|c| turn(c, n_ref, n_res)),
            n_averages: self.n_averages,
        })
    }

    /// The value at a line, reference and response.
    pub fn at(&self, line: usize, reference: usize, response: usize) -> Complex<f64> {
        self.h[self.index(line, reference, response)]
    }

    /// Leaves out lines that say nothing, and returns their frequencies: those at which no function has a value, and the line at 0 Hz when
    /// a function lacks it. A function that was not measured does not count.
    pub fn drop_empty_lines(&mut self) -> Vec<f64> {
        let width = self.references.len() * self.responses.len();
        if width == 0 || self.h.len() != width * self.n_lines() {
            return Vec::new();
        }
        let mut is_measured = vec![false; width];
        for line in self.h.chunks_exact(width) {
            is_measured.iter_mut().zip(line).for_each(|(known, h)| *known |= h.is_finite());
        }
        let says = |h: &[Complex<f64>], hz: f64| {
            let mut measured = h.iter().zip(&is_measured).filter(|(_, m)| **m).map(|(h, _)| h.is_finite());
            if hz == 0.0 { measured.all(|known| known) } else { measured.any(|known| known) }
        };
        let keep: Vec<bool> =
            self.h.chunks_exact(width).zip(&self.frequencies_hz).map(|(h, hz)| says(h, *hz)).collect();
        if !is_measured.contains(&true) || !keep.contains(&false) {
            return Vec::new();
        }
        let by_cell = || keep.iter().flat_map(|k| std::iter::repeat_n(*k, width));
        let mut cells = by_cell();
        self.h.retain(|_| cells.next() == Some(true));
        if let Some(coherence) = &mut self.coherence {
            let mut cells = by_cell();
            coherence.retain(|_| cells.next() == Some(true));
        }
        let dropped = self.frequencies_hz.iter().zip(&keep).filter(|(_, keep)| !**keep).map(|(f, _)| *f).collect();
        let mut lines = keep.iter();
        self.frequencies_hz.retain(|_| lines.next() == Some(&true));
        dropped
    }

    /// How many values of the measured functions are not numbers, and how many values these functions have.
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

/// (lines x references x responses) to (lines x responses x references).
fn turn<T: Copy>(values: &[T], n_ref: usize, n_res: usize) -> Vec<T> {
    let size = (n_ref * n_res).max(1);
    values
        .chunks(size)
        .flat_map(|line| (0..n_res).flat_map(move |o| (0..n_ref).map(move |i| line[i * n_res + o])))
        .collect()
}

/// The lines of [`FrfSet::drop_empty_lines`] in words.
pub(super) fn left_out(dropped: &[f64]) -> String {
    // The line at 0 Hz goes where one function lacks it, any other where all do.
    let elastic: Vec<f64> = dropped.iter().copied().filter(|f| *f != 0.0).collect();
    let of_zero = "not every function has a value at 0 Hz; this line is left out";
    let of_others = match &elastic[..] {
        [] => return of_zero.to_string(),
        [one] => format!("no function has a value at {one} Hz; this line is left out"),
        [first, ..] => {
            format!(
                "no function has a value at {} lines, the first of them {first} Hz; these are left out",
                elastic.len()
            )
        }
    };
    if elastic.len() == dropped.len() { of_others } else { format!("{of_zero}; {of_others}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_no_function_has_are_left_out_and_one_hole_is_not() {
        let channel = |name: &str| Channel { name: name.to_owned(), direction: None };
        let nan = Complex::new(f64::NAN, 0.0);
        let one = Complex::new(1.0, 0.0);
        let set = FrfSet {
            quantity: FrfQuantity::Mobility,
            frequencies_hz: vec![0.0, 1.0, 2.0, 3.0],
            references: vec![channel("a")],
            responses: vec![channel("a"), channel("b"), channel("not measured")],
            // 0 Hz is there in one of two functions, 1 Hz in both, 2 Hz in none, 3 Hz in one.
            h: vec![nan, one, nan, one, one, nan, nan, nan, nan, nan, one, nan],
            coherence: Some((0..12).map(f64::from).collect()),
            n_averages: None,
        };
        let mut ours = set.clone();
        assert_eq!(ours.drop_empty_lines(), [0.0, 2.0]);
        assert_eq!(ours.frequencies_hz, [1.0, 3.0]);
        assert_eq!(ours.coherence.as_deref(), Some(&[3.0, 4.0, 5.0, 9.0, 10.0, 11.0][..]));
        assert!(ours.at(0, 0, 0) == one && !ours.at(1, 0, 0).is_finite() && ours.at(1, 0, 1) == one);
        assert!(ours.drop_empty_lines().is_empty());
        // A set without any value stays as it is.
        let mut empty = FrfSet { h: vec![nan; 12], ..set };
        assert!(empty.drop_empty_lines().is_empty() && empty.n_lines() == 4);
    }
}
