//! Sensors that the motions of the model contradict take no part in pairs and fits.
//!
//! A sensor that is turned over, exchanged, scaled or dead spoils every shape at once: pairs by these shapes are wrong, and a fit to them moves a
//! right model. [Which sensor](super::momentum) is decided without a fit, so it is left out before there is one.

use super::momentum::check_sensors_by_model;
use crate::correlation::CorrelationError;
use crate::data::TestData;
use crate::linalg::Complex;
use crate::model::MOST_DENSE_DOFS;
use crate::objective::Comparison;

/// Indices of the sensors of a test that the motions of the model at θ contradict, ascending.
///
/// # Errors
/// As [`check_sensors_by_model`].
pub(super) fn contradicted(comparison: &Comparison<'_>, theta: &[f64]) -> Result<Vec<usize>, CorrelationError> {
    let (model, test) = (comparison.model(), comparison.test());
    if !comparison.has_shapes() || model.dof_map().n_dof() > MOST_DENSE_DOFS {
        return Ok(Vec::new());
    }
    let check = match check_sensors_by_model(model, theta, &test.sensors, &test.modes, 0) {
        Ok(check) => check,
        // What stands in for a large model has coordinates and no nodes.
        Err(CorrelationError::UnknownPlace { .. }) => return Ok(Vec::new()),
        Err(e) => return Err(e),
    };
    let mut out: Vec<usize> = check.changes.iter().flat_map(|(change, _)| change.touches()).collect();
    out.sort_unstable();
    out.dedup();
    Ok(out)
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
