//! Natural frequencies.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{NO_PARTNER, Point, Residual};
use crate::linalg::DMatrix;

/// r = (f_model - f_test)/σ_f for every measured mode; zero for one that is aside, [`NO_PARTNER`] where the model has none for it.
#[derive(Debug, Clone, Copy)]
pub struct Frequency;

impl Residual for Frequency {
    fn name(&self) -> &'static str {
        "frequency"
    }

    fn summary(&self) -> &'static str {
        "natural frequencies of paired modes, each over its standard deviation"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.test().modes.len()
    }

    fn row_name(&self, _: &Comparison<'_>, row: usize) -> String {
        format!("frequency of mode {}", row + 1)
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn needs_shapes(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        for (i, mode) in at.comparison.test().modes.iter().enumerate() {
            let alone = if at.comparison.is_aside(i) { 0.0 } else { NO_PARTNER };
            out[i] = at
                .prediction
                .partner(i)
                .map_or(alone, |a| (at.prediction.frequencies_hz[a] - mode.frequency_hz.value) / mode.frequency_hz.sd);
        }
    }

    fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>) {
        out.fill(0.0);
        for (i, mode) in at.comparison.test().modes.iter().enumerate() {
            if let Some((df, _)) = at.prediction.partner(i).and_then(|a| derivative.modes[a].as_ref()) {
                out.set_row(i, &(df.transpose() / mode.frequency_hz.sd));
            }
        }
    }
}
