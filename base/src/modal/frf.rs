//! Frequency response functions from modes, with modal damping.

use super::Modes;
use retune_linalg::{Complex, DMatrix};
use std::f64::consts::TAU;

/// Damping ratio of every mode.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalDamping {
    /// One ratio per mode, 1.
    pub ratios: Vec<f64>,
}

impl ModalDamping {
    /// One ratio for all modes.
    pub fn uniform(n_modes: usize, ratio: f64) -> Self {
        Self { ratios: vec![ratio; n_modes] }
    }
}

/// (iω)^order times the receptance between exciters and sensors, by superposition of all given modes.
///
/// ```text
/// H[k,s](ω) = (iω)^p Σ_r φ_kr φ_sr / (ω_r² - ω² + 2 i ζ_r ω_r ω)      time factor e^{+iωt}
/// ```
///
/// * `modes` - all modes that matter in the band, rigid-body modes included
/// * `responses`, `references` - sensor rows (n_sensor x n_dof), exciter rows (n_exciter x n_dof)
/// * `frequencies_hz` - lines; a free structure has no receptance at 0 Hz, and the result there is not finite
/// * `order` - 0 receptance, 1 mobility, 2 accelerance
///
/// Returns `h[(line * n_references + reference) * n_responses + response]`, SI, the layout of `FrfSet`.
pub fn synthesize(
    modes: &Modes,
    damping: &ModalDamping,
    responses: &DMatrix<f64>,
    references: &DMatrix<f64>,
    frequencies_hz: &[f64],
    order: i32,
) -> Vec<Complex<f64>> {
    let at_responses = responses * &modes.shapes;
    let at_references = references * &modes.shapes;
    let mut h = Vec::with_capacity(frequencies_hz.len() * references.nrows() * responses.nrows());
    for f in frequencies_hz {
        let omega = TAU * f;
        let power = Complex::new(0.0, omega).powi(order);
        let gains: Vec<Complex<f64>> = (0..modes.len())
            .map(|r| {
                let omega_r = modes.lambda[r].max(0.0).sqrt();
                let denominator =
                    Complex::new(modes.lambda[r] - omega * omega, 2.0 * damping.ratios[r] * omega_r * omega);
                power / denominator
            })
            .collect();
        for s in 0..references.nrows() {
            for k in 0..responses.nrows() {
                h.push((0..modes.len()).map(|r| gains[r] * (at_responses[(k, r)] * at_references[(s, r)])).sum());
            }
        }
    }
    h
}

/// [`synthesize`] for accelerance, (iω)² = -ω² times the receptance, 1/kg.
pub fn accelerance(
    modes: &Modes,
    damping: &ModalDamping,
    responses: &DMatrix<f64>,
    references: &DMatrix<f64>,
    frequencies_hz: &[f64],
) -> Vec<Complex<f64>> {
    synthesize(modes, damping, responses, references, frequencies_hz, 2)
}
