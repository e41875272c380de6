//! Numbers in files: units, and scalars that may name parameters.

mod digits;
mod scalar;
mod spellings;
mod unit;

pub use digits::ascii_numbers;
pub use scalar::{Scalar, ScalarError, Term};
pub use unit::{Dimension, FrequencyUnit, Unit, UnitError};

/// A number as people write it: `-7850`, `0.05`, and powers of ten only where they are shorter.
pub(crate) fn plain(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}
