//! Static angles.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::super::statics;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = (model - test)/σ for every angle of a static test; K u = f, exact derivatives by the adjoint equation.
#[derive(Debug, Clone, Copy)]
pub struct StaticAngle;

impl Residual for StaticAngle {
    fn name(&self) -> &'static str {
        "static-angle"
    }

    fn summary(&self) -> &'static str {
        "angles (sensors with `rotation: true`) under the loads of static tests, each over its standard deviation"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        statics::count(comparison, true)
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        statics::row_name(comparison, true, row)
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        statics::evaluate(at, true, out);
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        statics::differentiate(at, true, out);
    }
}
