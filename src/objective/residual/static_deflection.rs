//! Static deflections.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::super::statics;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = (model - test)/σ for every deflection of a static test; K u = f, exact derivatives by the adjoint equation.
#[derive(Debug, Clone, Copy)]
pub struct StaticDeflection;

impl Residual for StaticDeflection {
    fn name(&self) -> &'static str {
        "static-deflection"
    }

    fn summary(&self) -> &'static str {
        "deflections under the loads of static tests, each over its standard deviation"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        statics::count(comparison, false)
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        statics::row_name(comparison, false, row)
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        statics::evaluate(at, false, out);
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        statics::differentiate(at, false, out);
    }
}
