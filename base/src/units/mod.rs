//! Numbers in files: units, and scalars that may name parameters.

mod digits;
mod scalar;
mod spellings;
mod unit;

pub use digits::ascii_numbers;
pub use scalar::{Scalar, ScalarError, Term};
pub use unit::{Dimension, FrequencyUnit, GRAVITY, Unit, UnitError, units};

/// A number as people write it: `-7850`, `0.05`, and powers of ten only where they are shorter.
pub fn plain(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// Four significant digits; powers of ten outside 1e-3 to 1e6.
pub fn four_digits(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "–".into()
    } else if size == 0.0 {
        "0".into()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{value:.3e}")
    } else {
        let decimals = (3.0 - size.log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    }
}
