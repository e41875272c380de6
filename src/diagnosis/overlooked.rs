//! Modes of a model that a test should have seen: an effect that brings one is believed less.

use crate::model::extent;
use crate::objective::{Comparison, Prediction};

/// Largest motion at a sensor of a mode that is seen well, as a share of the largest anywhere.
const SEEN: f64 = 0.2;
/// What counts as no motion, as a share of that which a rotation makes at the end of the structure.
const ROUNDING: f64 = 1e-6;

/// ln of the odds that a test overlooks a mode that its sensors see well, among those that it lists: one of twenty.
pub(super) const LN_OVERLOOKED: f64 = -3.0;

/// Frequencies of modes, Hz, up to the highest tested one, that the sensors see well and no measured mode is paired with; none where the
/// test has no shapes.
pub(super) fn overlooked(comparison: &Comparison<'_>, p: &Prediction) -> Vec<f64> {
    if !comparison.has_shapes() {
        return Vec::new();
    }
    let highest = comparison.test().modes.iter().map(|m| m.frequency_hz.value).fold(0.0, f64::max);
    let dofs = comparison.model().dof_map();
    // A mode of rotations alone moves a sensor by rounding, and everything else too.
    let arm = ROUNDING * extent(dofs.positions());
    let largest = |a: usize| {
        let shape = p.modes.shapes.column(p.modes.n_rigid + a);
        let motion =
            |(v, row): (&f64, &(_, crate::element::Dof))| v.abs() * if row.1.is_rotation() { arm } else { 1.0 };
        shape.iter().zip(dofs.rows()).map(motion).fold(0.0, f64::max)
    };
    let is_overlooked = |&a: &usize| {
        p.frequencies_hz[a] < highest
            && p.pairs.pairs.iter().all(|pair| pair.analytical != a)
            && p.at_sensors.column(a).amax() > SEEN * largest(a)
    };
    (0..p.frequencies_hz.len()).filter(is_overlooked).map(|a| p.frequencies_hz[a]).collect()
}
