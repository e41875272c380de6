//! Directions of elements.

use super::ElementError;
use crate::linalg::vector3::{self, Vector3, dot};

/// A length below this, m, is rounding.
const SMALLEST: f64 = 1e-150;

/// The vector over its length.
///
/// # Errors
/// [`ElementError::Inverted`] where it has none.
pub(super) fn unit(a: Vector3) -> Result<Vector3, ElementError> {
    let is_long = dot(a, a).sqrt() > SMALLEST;
    vector3::unit(a).filter(|_| is_long).ok_or(ElementError::Inverted)
}
