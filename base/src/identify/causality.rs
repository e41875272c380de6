//! The sign of time: are the functions written for exp(+iωt) or for exp(-iωt)?

use super::{IdentifyOptions, identify};
use crate::data::{FrfSet, Measurements};
use retune_linalg::Complex;

/// Reverses the imaginary parts of measured functions that are written for exp(-iωt), as [`reversed_time`] tells; whether it did.
pub fn forward_in_time(found: &mut Measurements) -> bool {
    if let Some(forward) = found.frfs.as_ref().and_then(reversed_time) {
        found.frfs = Some(forward);
        found.is_time_reversed = true;
        return true;
    }
    false
}

/// The functions for exp(+iωt), where they are written for exp(-iωt); `None` where they are as they should be.
///
/// A structure answers after the force, whatever is measured, and wherever. The energy of the impulse response h of any function has its
/// centre at
///
/// ```text
/// t = ∫ t |h(t)|² dt / ∫ |h(t)|² dt = -∫ Im(H* dH/dω) dω / ∫ |H|² dω > 0
/// ```
/// (Parseval), and the conjugate has it at -t. By lines, Σ_l -Im(H*_l H_(l+1)) has the sign of t even where a resonance lies between two of
/// them, for its arc turns by less than π. Where the sum over all functions is negative, the functions and their conjugates are both identified;
/// the conjugates are taken when they have modes in stable columns, and more than twice as many as the functions as they are. An early
/// trigger, which also moves t, gives neither of them poles.
///
/// Functions without values or with an odd layout are left as they are: [`identify`] says what is wrong with these.
pub fn reversed_time(frfs: &FrfSet) -> Option<FrfSet> {
    if super::layout::check_layout(frfs).is_err() || centre(frfs) >= 0.0 {
        return None;
    }
    let conjugate = FrfSet { h: frfs.h.iter().map(Complex::conj).collect(), ..frfs.clone() };
    let n_modes = |set: &FrfSet| {
        identify(set, &IdentifyOptions::default())
            .map_or(0, |found| found.modes.iter().filter(|m| m.n_orders > 0).count())
    };
    let after = n_modes(&conjugate);
    (after > 0 && 2 * n_modes(frfs) < after).then_some(conjugate)
}

/// Sum over functions of the centre of the energy in time, in units of 1/Δω; each function counts alike.
fn centre(frfs: &FrfSet) -> f64 {
    let mut sum = 0.0;
    for i in 0..frfs.references.len() {
        for o in 0..frfs.responses.len() {
            let values: Vec<Complex<f64>> = (0..frfs.n_lines())
                .filter(|&l| frfs.frequencies_hz[l] > 0.0)
                .map(|l| frfs.at(l, i, o))
                .filter(|h| h.is_finite())
                .collect();
            let largest = values.iter().map(|h| h.re.abs().max(h.im.abs())).fold(0.0, f64::max);
            if largest > 0.0 {
                let unit: Vec<Complex<f64>> = values.iter().map(|h| h / largest).collect();
                let power: f64 = unit.iter().map(Complex::norm_sqr).sum();
                sum -= unit.windows(2).map(|w| (w[0].conj() * w[1]).im).sum::<f64>() / power;
            }
        }
    }
    sum
}
