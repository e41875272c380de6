//! Whether a set of functions is one, and the unit in which its numbers are near 1.

use super::IdentifyError;
use crate::data::FrfSet;
use retune_linalg::Complex;

/// The power of two next to the rms of the finite values: functions divided by it have squares and fourth powers within the range of numbers,
/// and keep every bit. 1 where all are zero.
pub(super) fn unit_of(values: impl Iterator<Item = Complex<f64>> + Clone) -> f64 {
    let values = values.filter(|h| h.is_finite());
    let largest = values.clone().map(|h| h.re.abs().max(h.im.abs())).fold(0.0, f64::max);
    if largest <= 0.0 {
        return 1.0;
    }
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), h| (sum + (h / largest).norm_sqr(), n + 1.0));
    // Within the range of normal numbers, as its inverse is.
    2.0_f64.powi((largest.log2() + 0.5 * f64::log2(sum / n)).round().clamp(-1000.0, 1000.0) as i32)
}

/// The set with an rms near 1.
pub(super) fn in_units(frfs: &FrfSet) -> FrfSet {
    let unit = unit_of(frfs.h.iter().copied());
    FrfSet { h: frfs.h.iter().map(|h| h / unit).collect(), ..frfs.clone() }
}

/// The vectors of the set must have the lengths that its channels and lines promise.
pub(super) fn check_layout(frfs: &FrfSet) -> Result<(), IdentifyError> {
    let expected = frfs.n_lines() * frfs.references.len() * frfs.responses.len();
    if frfs.h.len() != expected {
        return Err(IdentifyError::Layout { what: "h", expected, found: frfs.h.len() });
    }
    if let Some(c) = &frfs.coherence
        && c.len() != expected
    {
        return Err(IdentifyError::Layout { what: "coherence", expected, found: c.len() });
    }
    let f = &frfs.frequencies_hz;
    if let Some(line) = (0..f.len()).find(|&l| !f[l].is_finite() || f[l] < 0.0 || (l > 0 && f[l] <= f[l - 1])) {
        return Err(IdentifyError::Lines { line, value: f[line] });
    }
    Ok(())
}
