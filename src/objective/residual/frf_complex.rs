//! Frequency response functions, real and imaginary parts.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = Re and Im of (H_model - H_test)/σ for every value of the functions in the chosen bands.
///
/// σ is relative to the value, but never below 5 % of that of the function's root mean square. The sharpest term near the
/// optimum, and one with many false optima far from it, where resonances of model and test do not overlap: begin with
/// [`super::FrfLog`] or frequencies.
#[derive(Debug, Clone, Copy)]
pub struct FrfComplex;

impl Residual for FrfComplex {
    fn name(&self) -> &'static str {
        "frf-complex"
    }

    fn summary(&self) -> &'static str {
        "real and imaginary parts of frequency response functions in the chosen bands"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.responses().map_or(0, |r| 2 * r.values.len())
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        let part = if row.is_multiple_of(2) { "real" } else { "imaginary" };
        comparison
            .responses()
            .map_or_else(String::new, |r| format!("{part} part of {}", r.name(comparison.test(), row / 2)))
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        let Some(rows) = at.comparison.responses() else { return };
        let h = rows.values_of(at.comparison.model(), at.theta, at.prediction);
        for (i, v) in rows.values.iter().enumerate() {
            let r = (h[i] - v.measured) / v.sd;
            (out[2 * i], out[2 * i + 1]) = (r.re, r.im);
        }
        rows.common_of_parts().into_iter().for_each(|error| error.whiten(out));
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        let Some(rows) = at.comparison.responses() else { return };
        let (_, slopes) = rows.evaluate(at.comparison.model(), at.theta, at.prediction, Some(at.scaling.free()));
        for (i, v) in rows.values.iter().enumerate() {
            for j in 0..out.ncols() {
                let d = slopes[(i, j)] / v.sd;
                (out[(2 * i, j)], out[(2 * i + 1, j)]) = (d.re, d.im);
            }
        }
        if let Some(error) = rows.common_of_parts() {
            out.column_iter_mut().for_each(|mut column| error.whiten(column.as_mut_slice()));
        }
    }
}
