//! Sensors that the motions of the model contradict take no part in pairs and fits.
//!
//! A sensor that is turned over, exchanged, scaled or dead spoils every shape at once: pairs by these shapes are wrong, and a fit to them moves a
//! right model. [Which sensor](super::momentum) is decided without a fit, so it is left out before there is one.

use super::momentum::{SensorCheck, check_observed};
use crate::correlation::CorrelationError;
use crate::data::TestData;
use crate::linalg::Complex;
use crate::objective::Comparison;

/// What the motions of the model at θ say of the sensors of a test with shapes.
///
/// # Errors
/// The model has no modes at θ.
pub(super) fn check(comparison: &Comparison<'_>, theta: &[f64]) -> Result<Option<SensorCheck>, CorrelationError> {
    if !comparison.has_shapes() {
        return Ok(None);
    }
    let test = comparison.test();
    let observed = comparison.sensors_at(theta).map_err(|e| CorrelationError::Model(e.to_string()))?;
    check_observed(comparison.model(), theta, &observed, &test.sensors, &test.modes, 0).map(Some)
}

/// A test as if these sensors had not measured.
pub(super) fn without(test: &TestData, sensors: &[usize]) -> TestData {
    let mut out = test.clone();
    for shape in out.modes.iter_mut().filter_map(|m| m.shape.as_mut()) {
        for &s in sensors {
            shape[s] = Complex::new(f64::NAN, f64::NAN);
        }
    }
    out
}
