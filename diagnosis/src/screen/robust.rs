//! Fits that a few bad channels cannot pull aside.
//!
//! ```text
//! left out       fit without the channel s, for every s; kept where that takes away the most of the misfit
//! re-weighted    κ_s = max(1, rms_s / (1.5 median rms)),   σ_s -> κ_s σ_s,   fit again
//! ```
//!
//! One wrong channel moves a least-squares fit, spreads over the others, and hides. Without it the fit follows the others, and
//! the wrong one shows whole. Several wrong channels (a swapped pair) are found by weights: where channels that stand out are
//! given less, round after round, the rest decides.
//!
//! # Source
//! P. J. Huber, Robust Statistics, 1981, chapter 7 (iterative re-weighting).

use crate::effort::Effort;
use crate::error::DiagnosisError;
use crate::problem::fit::{Fit, evaluate, phi_of, shape_rows};
use crate::problem::race::{Pick, Round, fit, fit_by};
use crate::problem::scene::Scene;
use crate::thresholds::{FEWEST_CHANNELS, STANDS_OUT};
use rayon::prelude::*;
use retune::fault::{Number, PlacedFault};
use retune::linalg::{DMatrix, DVector};
use retune::objective::Scaling;

/// The fits, all evaluated with every channel and the stated standard deviations; none without shapes.
///
/// They start from the fit and from the estimates of the model, because a gross fault may have led the fit to pair the wrong
/// modes.
pub(crate) fn robust_fits(scene: &Scene, base: &Fit, weight: f64, effort: &Effort) -> Result<Vec<Fit>, DiagnosisError> {
    if !base.rows.has_shapes || base.rows.n_sensors < FEWEST_CHANNELS {
        return Ok(Vec::new());
    }
    let nominal = evaluate(scene, scene.start(), weight)?;
    let mut out = Vec::new();
    for start in [base, &nominal] {
        out.extend(rounds(scene, start.clone(), weight, effort.robust_rounds)?);
    }
    let starts = [base.x.clone(), nominal.x];
    let mut without: Vec<(f64, Fit)> = (0..base.rows.n_sensors)
        .into_par_iter()
        .filter_map(|sensor| {
            let rest = scene.corrected(&PlacedFault::silenced(sensor), 1.0);
            let rounds = vec![Round { pick: Pick::Lowest(2), steps: effort.robust_steps }];
            let found = fit_by(&rest, &[starts.to_vec()], rounds, weight).ok()?;
            Some((found.misfit, with_all_channels(scene, &found, weight).ok()?))
        })
        .collect();
    without.sort_by(|a, b| a.0.total_cmp(&b.0));
    out.extend(without.into_iter().take(effort.suspects).map(|w| w.1));
    Ok(out)
}

/// What faults without a number take away before anything is fitted: 2 (Φ of the fit - Φ with the fault corrected at the estimates, or
/// where the fit is), for those where that is positive.
///
/// A gross fault leads MAC to pair the wrong modes; corrected first, it does not. With functions, whose lines cost more than all that is
/// found so, nothing is looked at.
pub(crate) fn when_corrected(scene: &Scene, base: &Fit, weight: f64, faults: &[PlacedFault]) -> Vec<(usize, f64)> {
    if scene.has_functions() || !base.rows.has_shapes {
        return Vec::new();
    }
    // A fault leaves the model as it is, so its modes are solved once.
    let Ok(comparisons) = scene.comparisons() else { return Vec::new() };
    let solve = |x: DVector<f64>| {
        let theta = Scaling::new(scene.solved()).theta(&x);
        let solved = comparisons.iter().map(|c| c.solve(&theta)).collect::<Result<Vec<_>, _>>().ok()?;
        Some((x, theta, solved))
    };
    let points: Vec<_> = [scene.start(), base.x.clone()].into_iter().filter_map(solve).collect();
    faults
        .par_iter()
        .enumerate()
        .filter(|(_, fault)| matches!(fault.number(), Number::None | Number::Frequency { .. } | Number::Mixture))
        .filter_map(|(index, fault)| {
            let corrected = scene.corrected(fault, fault.number().neutral());
            let comparisons = corrected.comparisons().ok()?;
            let phi = |(x, theta, solved): &(DVector<f64>, Vec<f64>, Vec<_>)| {
                comparisons.iter().zip(solved).try_for_each(|(c, modes)| c.predict_solved(theta, modes)).ok()?;
                phi_of(&corrected, &comparisons, x, weight).ok()
            };
            let phi = points.iter().filter_map(phi).fold(f64::INFINITY, f64::min);
            let t = 2.0 * (base.phi - phi);
            (t > 0.0).then_some((index, t))
        })
        .collect()
}

/// A fit seen with all channels of the test and its own pairs: with the wrong channel in it MAC could pair other modes.
fn with_all_channels(scene: &Scene, fit: &Fit, weight: f64) -> Result<Fit, DiagnosisError> {
    let mut all = evaluate(scene, fit.x.clone(), weight)?;
    all.r.rows_mut(0, fit.rows.n_modes).copy_from(&fit.r.rows(0, fit.rows.n_modes));
    all.shapes.clone_from(&fit.shapes);
    all.modes_at.clone_from(&fit.modes_at);
    all.frequencies.clone_from(&fit.frequencies);
    all.unpaired.clone_from(&fit.unpaired);
    for mode in (0..fit.rows.n_modes).filter(|m| !fit.unpaired.contains(m)) {
        let column = |a: &DMatrix<f64>| -> Vec<f64> { a.column(mode).iter().copied().collect() };
        let (phi, test, w) = (column(&all.shapes), column(&all.test_shapes), column(&all.inverse_sd));
        for (sensor, v) in shape_rows(&phi, &test, &w).into_iter().enumerate() {
            all.r[all.rows.shape(mode, sensor)] = weight * v;
        }
    }
    all.phi = 0.5 * all.r.norm_squared();
    Ok(all)
}

/// Re-weights and fits until nothing moves.
fn rounds(scene: &Scene, mut now: Fit, weight: f64, most: usize) -> Result<Option<Fit>, DiagnosisError> {
    for _ in 0..most {
        let Some((rms, median)) = channels(&now) else { return Ok(None) };
        let factors: Vec<f64> = rms.iter().map(|v| (v / (STANDS_OUT * median)).max(1.0)).collect();
        let weighed = scene.weighed(&factors);
        let next = fit(&weighed, &[now.x.clone()], weight)?;
        let moved = (&next.x - &now.x).amax();
        now = evaluate(scene, next.x, weight)?;
        if moved < 1e-3 {
            break;
        }
    }
    Ok(Some(now))
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
