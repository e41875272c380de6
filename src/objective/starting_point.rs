//! Where a search starts.

use crate::model::ParametricModel;

/// The estimates, moved into their bounds.
pub fn starting_point(model: &dyn ParametricModel) -> Vec<f64> {
    model.parameters().iter().map(|p| p.bounds.map_or(p.value, |[l, u]| p.value.max(l).min(u))).collect()
}

/// Whether a model has damping of its own at its estimates.
pub fn is_damped(model: &dyn ParametricModel) -> bool {
    model.modal_damping().is_some()
        || model.assemble_sparse(&starting_point(model)).is_ok_and(|system| system.damping.is_some())
}
