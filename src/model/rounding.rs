//! What rounding has left of sums that cancel.

/// A sum that is no more than this part of the sum of its terms' moduli is rounding.
const ROUNDING: f64 = 1e-13;

/// A sum, or zero where it is rounding.
///
/// * `size` - the sum of its terms' moduli
pub(super) fn clean(sum: f64, size: f64) -> f64 {
    if sum.abs() <= ROUNDING * size { 0.0 } else { sum }
}
