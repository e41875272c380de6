//! Parameters: named numbers with bounds.

use crate::units::{Scalar, four_digits};

/// One parameter, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Unit that tables print it in.
    pub unit: String,
    /// SI value of one such unit.
    pub unit_factor: f64,
    /// Estimate, SI.
    pub value: f64,
    /// Bounds of an update, SI; a parameter without bounds is a constant.
    pub bounds: Option<[f64; 2]>,
    /// Standard deviation of a Gaussian prior around the estimate, SI.
    pub prior_sd: Option<f64>,
    /// What it is.
    pub description: String,
}

impl Parameter {
    /// The values that it may take: its bounds, or its value.
    pub fn range(&self) -> [f64; 2] {
        self.bounds.unwrap_or([self.value; 2])
    }

    /// A value in SI expressed in the unit of tables.
    pub fn display(&self, si: f64) -> f64 {
        si / self.unit_factor
    }

    /// A value as a user writes it, SI, and whether it was a plain number, which is in the unit that the file declares.
    ///
    /// # Errors
    /// No number, another dimension, a value outside the bounds.
    pub fn parse(&self, text: &str) -> Result<(f64, bool), String> {
        let Self { name, unit, .. } = self;
        let shown = |si: f64| format!("{} {unit}", four_digits(self.display(si))).trim_end().to_string();
        let value = Scalar::parse(text).map_err(|e| format!("{name}: {e}"))?;
        let is_plain = value.terms().iter().all(|t| t.dimension.is_none() && t.parameter.is_none());
        let value = if is_plain {
            self.unit_factor * value.terms().iter().map(|t| t.factor).sum::<f64>()
        } else {
            value.constant_in(unit).map_err(|e| format!("{name}: {e}"))?
        };
        match self.bounds {
            // A bound itself may be rounded on its way through a unit.
            Some([lower, upper]) if value < lower - 1e-9 * lower.abs() || value > upper + 1e-9 * upper.abs() => {
                Err(format!(
                    "{name}={text}: {} is outside the bounds of `{name}`, {} to {}: check the unit, or widen `bounds` in the model file",
                    shown(value),
                    shown(lower),
                    shown(upper)
                ))
            }
            _ => Ok((value, is_plain)),
        }
    }

    /// Whether a value lies on a bound, within 1e-6 of the interval.
    pub fn at_bound(&self, value: f64) -> bool {
        self.bounds.is_some_and(|[lower, upper]| {
            let margin = 1e-6 * (upper - lower);
            value <= lower + margin || value >= upper - margin
        })
    }
}

/// The parameters of a model, in file order; θ is the vector of their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterSet {
    parameters: Vec<Parameter>,
}

impl ParameterSet {
    /// From a list with unique names.
    pub fn new(parameters: Vec<Parameter>) -> Self {
        Self { parameters }
    }

    /// Number of parameters, free and constant: the length of θ.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// All of them.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Parameter> + Clone {
        self.parameters.iter()
    }

    /// One by its index in θ.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn get(&self, index: usize) -> &Parameter {
        &self.parameters[index]
    }

    /// Index in θ of a name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// Names in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|p| p.name.as_str())
    }

    /// How far a parameter is moved for a derivative by differences: about the cube root of rounding, of its interval or of its value, balances
    /// truncation and cancellation.
    pub fn difference_step(&self, theta: &[f64], j: usize) -> f64 {
        let scale = self.parameters[j].bounds.map_or(theta[j].abs(), |[l, u]| u - l);
        1e-5 * if scale > 0.0 { scale } else { 1.0 }
    }

    /// θ at the estimates.
    pub fn nominal(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// Indices in θ of the parameters with bounds: those that an update may change.
    pub fn free(&self) -> Vec<usize> {
        (0..self.len()).filter(|&i| self.parameters[i].bounds.is_some()).collect()
    }
}
