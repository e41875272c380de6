//! What is known of the parameters before the test.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = (θ - estimate)/prior_sd for every parameter with a `prior_sd`.
#[derive(Debug, Clone, Copy)]
pub struct Prior;

impl Residual for Prior {
    fn name(&self) -> &'static str {
        "prior"
    }

    fn summary(&self) -> &'static str {
        "distance of each parameter from its estimate, over its prior standard deviation"
    }

    fn is_data(&self) -> bool {
        false
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.model().parameters().iter().filter(|p| p.prior_sd.is_some()).count()
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        let mut with_prior = comparison.model().parameters().iter().filter(|p| p.prior_sd.is_some());
        with_prior.nth(row).map_or_else(String::new, |p| format!("prior of {}", p.name))
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn needs_shapes(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        let parameters = at.comparison.model().parameters();
        let rows = parameters.iter().zip(at.theta).filter_map(|(p, v)| p.prior_sd.map(|sd| (v - p.value) / sd));
        out.iter_mut().zip(rows).for_each(|(o, r)| *o = r);
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let parameters = at.comparison.model().parameters();
        let mut row = 0;
        for (i, p) in parameters.iter().enumerate() {
            if let Some(sd) = p.prior_sd {
                if let Some(column) = at.scaling.free().iter().position(|&f| f == i) {
                    out[(row, column)] = 1.0 / sd;
                }
                row += 1;
            }
        }
    }
}
