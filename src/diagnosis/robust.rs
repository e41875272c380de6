//! A fit that a few bad channels cannot pull aside.
//!
//! ```text
//! κ_s = max(1, rms_s / (1.5 median rms)),   σ_s -> κ_s σ_s,   fit again
//! ```
//!
//! One wrong channel moves a least-squares fit, spreads over the others, and hides. Where channels that stand out are given
//! less weight, round after round, the fit follows the others, and the wrong one shows whole.
//!
//! # Source
//! P. J. Huber, Robust Statistics, 1981, chapter 7 (iterative re-weighting).

use super::DiagnosisError;
use super::scene::{Fit, Scene, evaluate, fit};

/// Rounds of re-weighting.
const ROUNDS: usize = 4;
/// A channel stands out above so many times the median.
const OUT: f64 = 1.5;

/// The robust fit, evaluated with the stated standard deviations; `None` without shapes.
pub(super) fn robust(scene: &Scene, base: &Fit, weight: f64) -> Result<Option<Fit>, DiagnosisError> {
    if !base.rows.has_shapes || base.rows.n_sensors < 4 {
        return Ok(None);
    }
    let mut now = base.clone();
    for _ in 0..ROUNDS {
        let rms: Vec<f64> = (0..now.rows.n_sensors).map(|s| channel_rms(&now, s)).collect();
        let mut known: Vec<f64> = rms.iter().copied().filter(|v| *v > 0.0).collect();
        known.sort_by(f64::total_cmp);
        let Some(&median) = known.get(known.len() / 2) else { return Ok(None) };
        let mut weighed = scene.clone();
        for mode in &mut weighed.test.modes {
            let Some(sd) = &mut mode.shape_sd else { continue };
            for (s, sd) in sd.iter_mut().enumerate() {
                *sd *= (rms[s] / (OUT * median)).max(1.0);
            }
        }
        let next = fit(&weighed, &[now.x.clone(), scene.start()], weight)?;
        let moved = (&next.x - &now.x).amax();
        now = evaluate(scene, next.x, weight)?;
        if moved < 1e-3 {
            break;
        }
    }
    Ok(Some(now))
}

/// Root mean square of the residuals of a sensor over the modes where it measured.
fn channel_rms(fit: &Fit, sensor: usize) -> f64 {
    let rows: Vec<usize> = (0..fit.rows.n_modes)
        .filter(|&m| fit.inverse_sd[(sensor, m)] > 0.0)
        .map(|m| fit.rows.shape(m, sensor))
        .collect();
    (rows.iter().map(|&i| fit.r[i] * fit.r[i]).sum::<f64>() / rows.len().max(1) as f64).sqrt()
}
