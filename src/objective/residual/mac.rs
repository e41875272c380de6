//! MAC of paired modes, as a residual.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::linalg::DMatrix;

/// r = √(1 - MAC)/σ with σ = 0.1 for every measured mode with a shape; 1/σ where the model has no partner for it, zero where it is aside.
///
/// √(1 - MAC) is the sine of the angle between the shapes, so the term is smooth where they differ; it has a kink where
/// they agree, where [`super::Shape`] is the better term. σ = 0.1 is a MAC of 0.99.
#[derive(Debug, Clone, Copy)]
pub struct Mac;

const SIGMA: f64 = 0.1;

impl Residual for Mac {
    fn name(&self) -> &'static str {
        "mac"
    }

    fn summary(&self) -> &'static str {
        "sine of the angle between paired shapes, the square root of 1 - MAC, over 0.1"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.test().modes.len()
    }

    fn row_name(&self, _: &Comparison<'_>, row: usize) -> String {
        format!("MAC of mode {}", row + 1)
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn needs_shapes(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        for (i, mode) in at.comparison.test().modes.iter().enumerate() {
            out[i] = match (mode.shape.is_some() && !at.comparison.is_aside(i), at.prediction.partner(i)) {
                (false, _) => 0.0,
                (true, Some(a)) => (1.0 - at.prediction.mac[(a, i)]).max(0.0).sqrt() / SIGMA,
                (true, None) => 1.0 / SIGMA,
            };
        }
    }

    fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let shapes = at.comparison.shapes();
        for (i, mode) in at.comparison.test().modes.iter().enumerate() {
            let Some(a) = at.prediction.partner(i).filter(|_| mode.shape.is_some()) else { continue };
            let Some((_, d_phi)) = &derivative.modes[a] else { continue };
            let phi = at.prediction.at_sensors.column(a);
            let rows: Vec<usize> = (0..shapes.nrows()).filter(|&k| !shapes[(k, i)].is_nan()).collect();
            let sum = |f: &dyn Fn(usize) -> f64| rows.iter().map(|&k| f(k)).sum::<f64>();
            let (cross, own) = (sum(&|k| phi[k] * shapes[(k, i)]), sum(&|k| phi[k] * phi[k]));
            let test = sum(&|k| shapes[(k, i)] * shapes[(k, i)]);
            let mac = cross * cross / (own * test);
            let sine = (1.0 - mac).max(0.0).sqrt();
            // At equal shapes the angle has no derivative; zero is its mean over directions.
            if sine < 1e-9 {
                continue;
            }
            for j in 0..d_phi.ncols() {
                let d_cross = sum(&|k| d_phi[(k, j)] * shapes[(k, i)]);
                let d_own = 2.0 * sum(&|k| d_phi[(k, j)] * phi[k]);
                let d_mac = 2.0 * cross * d_cross / (own * test) - mac * d_own / own;
                out[(i, j)] = -0.5 * d_mac / sine / SIGMA;
            }
        }
    }
}
