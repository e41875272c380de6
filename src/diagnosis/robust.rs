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
///
/// It starts from the fit and from the estimates of the model, because a gross fault may have led the fit to pair the wrong
/// modes; the one with the smaller median over the channels is kept.
pub(super) fn robust(scene: &Scene, base: &Fit, weight: f64) -> Result<Option<Fit>, DiagnosisError> {
    if !base.rows.has_shapes || base.rows.n_sensors < 4 {
        return Ok(None);
    }
    let mut best: Option<(f64, Fit)> = None;
    for start in [base.clone(), evaluate(scene, scene.start(), weight)?] {
        let Some((median, found)) = rounds(scene, start, weight)? else { continue };
        if best.as_ref().is_none_or(|b| median < b.0) {
            best = Some((median, found));
        }
    }
    Ok(best.map(|b| b.1))
}

/// Re-weights and fits until nothing moves; the median over the channels, and the fit.
fn rounds(scene: &Scene, mut now: Fit, weight: f64) -> Result<Option<(f64, Fit)>, DiagnosisError> {
    for _ in 0..ROUNDS {
        let Some((rms, median)) = channels(&now) else { return Ok(None) };
        let mut weighed = scene.clone();
        for mode in &mut weighed.test.modes {
            let Some(sd) = &mut mode.shape_sd else { continue };
            for (s, sd) in sd.iter_mut().enumerate() {
                *sd *= (rms[s] / (OUT * median)).max(1.0);
            }
        }
        let next = fit(&weighed, &[now.x.clone()], weight)?;
        let moved = (&next.x - &now.x).amax();
        now = evaluate(scene, next.x, weight)?;
        if moved < 1e-3 {
            break;
        }
    }
    Ok(channels(&now).map(|(_, median)| (median, now)))
}

/// Root mean square of every channel, and their median.
fn channels(fit: &Fit) -> Option<(Vec<f64>, f64)> {
    let rms: Vec<f64> = (0..fit.rows.n_sensors).map(|s| channel_rms(fit, s)).collect();
    let mut known: Vec<f64> = rms.iter().copied().filter(|v| *v > 0.0).collect();
    known.sort_by(f64::total_cmp);
    let median = *known.get(known.len() / 2)?;
    Some((rms, median))
}

/// Root mean square of the residuals of a sensor over the modes where it measured.
fn channel_rms(fit: &Fit, sensor: usize) -> f64 {
    let rows: Vec<usize> = (0..fit.rows.n_modes)
        .filter(|&m| fit.inverse_sd[(sensor, m)] > 0.0)
        .map(|m| fit.rows.shape(m, sensor))
        .collect();
    (rows.iter().map(|&i| fit.r[i] * fit.r[i]).sum::<f64>() / rows.len().max(1) as f64).sqrt()
}
