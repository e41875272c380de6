//! Single components of mode shapes whose scale is known.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::data::ShapeComponent;
use crate::linalg::DMatrix;

/// Rows of the components that a test states of its modes ([`ShapeComponent`]).
///
/// ```text
/// r = (s φ_k - v)/σ          of the shape of unit modal mass, φᵀ M φ = 1 kg
/// r = (φ_k/φ_ref - v)/σ      relative to another sensor
/// ```
///
/// A shape of unit modal mass has a sign that nothing measures: s is 1 or -1, one for all components of a mode, the one with the smaller
/// Σ r². A ratio has none; where φ_ref vanishes it is bounded by [`super::NO_PARTNER`], and so is a component of a mode without a partner.
#[derive(Debug, Clone, Copy)]
pub struct ShapeComponents;

/// The components in the order of the rows: test mode, and what is stated.
fn stated<'a>(comparison: &Comparison<'a>) -> impl Iterator<Item = (usize, &'a ShapeComponent)> {
    let modes = comparison.test().modes.iter().enumerate();
    modes.flat_map(|(i, m)| m.components.iter().map(move |c| (i, c)))
}

/// s for a shape of unit modal mass: Σ w (s φ - v)² is least where s Σ w φ v is above zero.
fn sign(components: &[ShapeComponent], phi: impl Fn(usize) -> f64) -> f64 {
    let own = components.iter().filter(|c| c.relative_to.is_none());
    let cross: f64 = own.map(|c| phi(c.sensor) * c.measured.value / c.measured.sd.powi(2)).sum();
    if cross < 0.0 { -1.0 } else { 1.0 }
}

impl Residual for ShapeComponents {
    fn name(&self) -> &'static str {
        "shape-components"
    }

    fn summary(&self) -> &'static str {
        "components of shapes of unit modal mass, or relative to another sensor, each over its standard deviation"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        stated(comparison).count()
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        let sensor = |k: usize| comparison.test().sensors[k].name.as_str();
        stated(comparison).nth(row).map_or_else(String::new, |(mode, c)| {
            let relative = c.relative_to.map_or_else(String::new, |k| format!(" relative to {}", sensor(k)));
            format!("component of mode {} at {}{relative}", mode + 1, sensor(c.sensor))
        })
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        for (o, (mode, c)) in out.iter_mut().zip(stated(at.comparison)) {
            *o = match at.prediction.partner(mode) {
                _ if at.comparison.is_aside(mode) => 0.0,
                None => super::NO_PARTNER,
                Some(a) => {
                    let phi = at.prediction.at_sensors.column(a);
                    let value = match c.relative_to {
                        None => sign(&at.comparison.test().modes[mode].components, |k| phi[k]) * phi[c.sensor],
                        Some(reference) => phi[c.sensor] / phi[reference],
                    };
                    let r = (value - c.measured.value) / c.measured.sd;
                    if r.is_finite() { r } else { super::NO_PARTNER }
                }
            };
        }
    }

    fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>) {
        out.fill(0.0);
        for (row, (mode, c)) in stated(at.comparison).enumerate() {
            let Some(a) = at.prediction.partner(mode).filter(|_| !at.comparison.is_aside(mode)) else { continue };
            let Some((_, d_phi)) = &derivative.modes[a] else { continue };
            let phi = at.prediction.at_sensors.column(a);
            let components = &at.comparison.test().modes[mode].components;
            for j in 0..d_phi.ncols() {
                let slope = match c.relative_to {
                    None => sign(components, |k| phi[k]) * d_phi[(c.sensor, j)],
                    Some(k) => (d_phi[(c.sensor, j)] - phi[c.sensor] / phi[k] * d_phi[(k, j)]) / phi[k],
                };
                out[(row, j)] = if slope.is_finite() { slope / c.measured.sd } else { 0.0 };
            }
        }
    }
}
