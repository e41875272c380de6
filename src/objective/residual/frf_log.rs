//! Amplitudes of frequency response functions.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = ln(|H_model|/|H_test|)/σ for every value of the functions in the chosen bands, σ relative to the value.
///
/// ```text
/// ∂r = Re(H* ∂H)/|H|² / σ
/// ```
///
/// Where the loss factor is an estimate by measured ratios, what its error does to all functions alike is taken out as far as it is expected.
/// Smooth over resonances and antiresonances, so that a model that is still far off finds its way; it does not see phases.
#[derive(Debug, Clone, Copy)]
pub struct FrfLog;

impl Residual for FrfLog {
    fn name(&self) -> &'static str {
        "frf-log"
    }

    fn summary(&self) -> &'static str {
        "logarithms of the amplitudes of frequency response functions in the chosen bands"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.responses().map_or(0, |r| r.values.len())
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        comparison.responses().map_or_else(String::new, |r| r.name(comparison.test(), row))
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        let Some(rows) = at.comparison.responses() else { return };
        for ((o, h), v) in
            out.iter_mut().zip(rows.values_of(at.comparison.model(), at.theta, at.prediction)).zip(&rows.values)
        {
            *o = (h.norm() / v.measured.norm()).ln() / v.relative_sd;
        }
        rows.common_of_log().into_iter().for_each(|error| error.whiten(out));
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        let Some(rows) = at.comparison.responses() else { return };
        let (h, slopes) = rows.evaluate(at.comparison.model(), at.theta, at.prediction, Some(at.scaling.free()));
        for (i, v) in rows.values.iter().enumerate() {
            for j in 0..out.ncols() {
                out[(i, j)] = (h[i].conj() * slopes[(i, j)]).re / h[i].norm_sqr() / v.relative_sd;
            }
        }
        if let Some(error) = rows.common_of_log() {
            out.column_iter_mut().for_each(|mut column| error.whiten(column.as_mut_slice()));
        }
    }
}
