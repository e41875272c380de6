//! Mode shapes at the sensors.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::linalg::{DMatrix, DVector};

/// r_k = (c φ_model,k - φ_test,k)/σ_k with the scale c of each mode free.
///
/// ```text
/// c = Σ w φ_m φ_t / Σ w φ_m²,   w = 1/σ²      the weighted least-squares scale, eliminated exactly
/// ∂r = (c ∂φ_m + ∂c φ_m)/σ,   ∂c = (Σ w ∂φ_m φ_t - 2 c Σ w φ_m ∂φ_m)/Σ w φ_m²
/// ```
///
/// The rows of one mode have one degree of freedom less than there are sensors. Complex test shapes enter by the real
/// part after the phase that makes them as real as can be.
#[derive(Debug, Clone, Copy)]
pub struct Shape;

/// Sensors that measured a mode, with their values and weights 1/σ.
fn measured<'a>(
    comparison: &'a Comparison<'_>,
    mode: usize,
) -> impl Iterator<Item = (usize, f64, f64)> + Clone + use<'a> {
    let shape = comparison.shapes().column(mode);
    let sd = comparison.test().modes[mode].shape_sd.iter().flatten();
    shape.into_iter().zip(sd).enumerate().filter(|(_, (v, _))| !v.is_nan()).map(|(k, (v, sd))| (k, *v, 1.0 / sd))
}

/// The scale c and Σ w φ_m².
fn scale(rows: impl Iterator<Item = (usize, f64, f64)>, phi: impl Fn(usize) -> f64) -> (f64, f64) {
    let (mut cross, mut own) = (0.0, 0.0);
    for (k, test, w) in rows {
        cross += w * w * phi(k) * test;
        own += w * w * phi(k) * phi(k);
    }
    (if own > 0.0 { cross / own } else { 0.0 }, own)
}

impl Residual for Shape {
    fn name(&self) -> &'static str {
        "shape"
    }

    fn summary(&self) -> &'static str {
        "mode shapes at the sensors with a free scale per mode, each entry over its standard deviation"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.shapes().len()
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        let n = comparison.shapes().nrows();
        format!("shape of mode {} at {}", row / n + 1, comparison.test().sensors[row % n].name)
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let n = at.comparison.shapes().nrows();
        for mode in 0..at.comparison.test().modes.len() {
            let rows = measured(at.comparison, mode);
            let out = &mut out[n * mode..n * (mode + 1)];
            let Some(a) = at.prediction.partner(mode) else { continue };
            let phi = at.prediction.at_sensors.column(a);
            let (c, _) = scale(rows.clone(), |k| phi[k]);
            for (k, test, w) in rows {
                out[k] = (c * phi[k] - test) * w;
            }
        }
    }

    fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let n = at.comparison.shapes().nrows();
        for mode in 0..at.comparison.test().modes.len() {
            let Some(a) = at.prediction.partner(mode) else { continue };
            let Some((_, d_phi)) = &derivative.modes[a] else { continue };
            let rows: Vec<_> = measured(at.comparison, mode).collect();
            let phi = at.prediction.at_sensors.column(a);
            let (c, own) = scale(rows.iter().copied(), |k| phi[k]);
            if own == 0.0 {
                continue;
            }
            let mut d_c: DVector<f64> = DVector::zeros(d_phi.ncols());
            for &(k, test, w) in &rows {
                for j in 0..d_phi.ncols() {
                    d_c[j] += w * w * d_phi[(k, j)] * (test - 2.0 * c * phi[k]) / own;
                }
            }
            for &(k, _, w) in &rows {
                for j in 0..d_phi.ncols() {
                    out[(n * mode + k, j)] = (c * d_phi[(k, j)] + d_c[j] * phi[k]) * w;
                }
            }
        }
    }
}
