//! Numbers in files: units, and scalars that may name parameters.

mod scalar;
mod unit;

pub use scalar::{Scalar, ScalarError, Term};
pub use unit::{Dimension, FrequencyUnit, Unit, UnitError};
