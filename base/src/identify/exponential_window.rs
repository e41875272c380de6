//! The damping that an exponential window adds to a test.

use crate::data::TestMode;
use std::f64::consts::TAU;

/// Takes the damping of an exponential window out of identified modes.
///
/// ```text
/// w(t) = exp(-σ t):   H_w(s) = H(s + σ),   λ = λ_w + σ
/// a = ζ_w ω_w - σ,    b = ω_w √(1 - ζ_w²),   ω = √(a² + b²),   ζ = a / ω
/// ```
///
/// ω_w = 2π f_w and ζ_w are identified from windowed signals, ω and ζ are those of the structure. Shapes stay as they are: the residues of
/// H_w are those of H. Standard deviations stay too, for σ is known exactly.
///
/// * `rate` - σ, 1/s
///
/// Returns the frequencies of modes, Hz, in which the window has as much damping as was identified, or more: they have lost their
/// damping ratio.
pub fn remove_exponential_window(modes: &mut [TestMode], rate: f64) -> Vec<f64> {
    let mut lost = Vec::new();
    for mode in modes {
        let Some(zeta) = &mut mode.damping_ratio else { continue };
        let omega = TAU * mode.frequency_hz.value;
        let own = zeta.value * omega - rate;
        let damped = omega * (1.0 - zeta.value * zeta.value).max(0.0).sqrt();
        if own > 0.0 {
            let omega = own.hypot(damped);
            mode.frequency_hz.value = omega / TAU;
            zeta.value = own / omega;
        } else {
            mode.frequency_hz.value = damped / TAU;
            mode.damping_ratio = None;
            lost.push(mode.frequency_hz.value);
        }
    }
    lost
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Measured, Origin};

    fn mode(omega: f64, zeta: f64) -> TestMode {
        let measured = |value| Measured { value, sd: 1e-3, sd_is_default: false };
        TestMode {
            label: None,
            frequency_hz: measured(omega / TAU),
            damping_ratio: Some(measured(zeta)),
            origin: Origin::Measured(String::new()),
            shape: None,
            shape_sd: None,
            shape_origin: None,
            components: Vec::new(),
            standing: crate::data::Standing::Open,
            space: None,
        }
    }

    #[test]
    fn the_pole_moves_back_by_the_rate_of_the_window() {
        // λ = -2 + 100i, seen through a window of 5 1/s as -7 + 100i.
        let (a, b, rate) = (2.0_f64, 100.0_f64, 5.0_f64);
        let seen = (a + rate).hypot(b);
        let mut modes = [mode(seen, (a + rate) / seen)];
        assert!(remove_exponential_window(&mut modes, rate).is_empty());
        assert!((modes[0].frequency_hz.value * TAU / a.hypot(b) - 1.0).abs() < 1e-14);
        assert!((modes[0].damping_ratio.unwrap().value / (a / a.hypot(b)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_window_with_all_the_damping_leaves_none() {
        let mut modes = [mode(100.0, 0.02), mode(1000.0, 0.02)];
        let lost = remove_exponential_window(&mut modes, 3.0);
        assert_eq!(lost.len(), 1);
        assert!(modes[0].damping_ratio.is_none() && modes[1].damping_ratio.is_some());
    }
}
