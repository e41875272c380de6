//! What a fault of the measurement would change at a fit, by re-weighting rows: its screening.

use super::DiagnosisError;
use super::fault_places::faults;
use super::faults::{Change, Fault};
use super::fit::Fit;
use super::posed::Posed;
use super::scene::{Prior, Scene};
use super::screen::project;
use crate::correlation::observation_matrix;
use crate::linalg::{DMatrix, DVector};
use rayon::prelude::*;

/// What a fault explains at the base fit.
#[derive(Debug, Clone)]
pub(super) enum Trace {
    /// A fixed change δ of the residual: T = -2 δ'·r' - |δ'|².
    Fixed(DVector<f64>),
    /// A direction with a free multiple.
    Free(DVector<f64>),
    /// The rows of one sensor, for a noisy one.
    Block(Vec<usize>),
    /// Rows that are replaced: cost before minus cost as noise alone. Holds rows and the readings over their σ.
    Replaced(Vec<usize>, Vec<f64>),
}

/// Step of differences: rows are nearly linear in ln g and in angles; those of functions are, those of shapes in g.
const STEP: f64 = 1e-4;

/// The weighted residual of one mode's shape with its free scale, at its measured sensors.
pub(super) fn shape_rows(phi: &[f64], test: &[f64], inverse_sd: &[f64]) -> Vec<f64> {
    let (mut cross, mut own) = (0.0, 0.0);
    for k in 0..phi.len() {
        let w = inverse_sd[k] * inverse_sd[k];
        cross += w * phi[k] * test[k];
        own += w * phi[k] * phi[k];
    }
    let c = if own > 0.0 { cross / own } else { 0.0 };
    (0..phi.len()).map(|k| (c * phi[k] - test[k]) * inverse_sd[k]).collect()
}

/// What each fault would change at the fit; `None` where the model cannot tell (it has no motion in that direction).
pub(super) fn traces(scene: &Scene, fit: &Fit, weight: f64, faults: &[Fault]) -> Vec<Option<Trace>> {
    faults.par_iter().map(|fault| trace(scene, fit, weight, fault)).collect()
}

/// Modes in which the sensor of a fault counts at a fit.
fn measured_modes(scene: &Scene, fit: &Fit, fault: &Fault) -> Vec<usize> {
    fault.modes(scene).filter(|&m| fit.inverse_sd[(fault.sensor, m)] > 0.0 && !fit.unpaired.contains(&m)).collect()
}

/// What a sensor of another axis or place, or along the direction of a tilt, would read of the modes of the model; `None` where nothing
/// moves it.
fn readings(scene: &Scene, fit: &Fit, fault: &Fault) -> Option<Vec<f64>> {
    let sensor = fault.sensor(&scene.test.sensors);
    let mut readings = vec![0.0; fit.rows.n_modes];
    let mut moves = false;
    for case in fault.cases(scene).filter(|c| c.sensors.contains(&fault.sensor)) {
        let row = observation_matrix(&case.model, std::slice::from_ref(&sensor)).ok()?;
        moves |= row.amax() > 0.0;
        case.modes().for_each(|m| readings[m] = (&row * &fit.modes_at[m])[0]);
    }
    moves.then_some(readings)
}

/// Every fault that the test could show at a fit.
pub(super) fn faults_at(scene: &Scene, fit: &Fit) -> Vec<Fault> {
    faults(scene).into_iter().filter(|fault| !reads_noise_only(scene, fit, fault)).collect()
}

/// Whether a sensor along another axis would read noise only, less than three standard deviations in all modes together: it cannot be told
/// from a dead one, and that is what it is called.
fn reads_noise_only(scene: &Scene, fit: &Fit, fault: &Fault) -> bool {
    const SEEN: f64 = 9.0;
    if !matches!(fault.change, Change::Axis(_)) || scene.has_functions() {
        return false;
    }
    let modes = measured_modes(scene, fit, fault);
    if modes.is_empty() {
        return false;
    }
    let Some(readings) = readings(scene, fit, fault) else { return true };
    let s = fault.sensor;
    let signal = |&m: &usize| {
        let column = |a: &DMatrix<f64>| -> Vec<f64> { a.column(m).iter().copied().collect() };
        let (mut phi, test, w) = (column(&fit.shapes), column(&fit.test_shapes), column(&fit.inverse_sd));
        phi[s] = readings[m];
        (shape_rows(&phi, &test, &w)[s] + test[s] * w[s]).powi(2)
    };
    modes.iter().map(signal).sum::<f64>() < SEEN
}

fn trace(scene: &Scene, fit: &Fit, weight: f64, fault: &Fault) -> Option<Trace> {
    let rows = fit.rows;
    let s = fault.sensor;
    if let Change::DrivingPoint { .. } = fault.change {
        return driving_point(scene, fit, weight, fault).ok();
    }
    if (fault.is_gain() || fault.is_angle()) && scene.has_functions() {
        return number_slope(scene, fit, weight, fault, fault.neutral()).ok().map(Trace::Free);
    }
    let mut delta = DVector::zeros(fit.r.len());
    if let Change::Order(a, b) = fault.change {
        let modes = &scene.test.modes;
        for (own, other) in [(a, b), (b, a)] {
            let f = modes[other].frequency_hz;
            delta[own] = weight * (fit.frequencies[own] - f.value) / f.sd - fit.r[own];
        }
        return delta.iter().all(|v| v.is_finite()).then_some(Trace::Fixed(delta));
    }
    if let Change::Frequency(m) = fault.change {
        let f = scene.test.modes[m].frequency_hz;
        delta[m] = weight * f.value / f.sd;
        return fit.frequencies[m].is_finite().then_some(Trace::Free(delta));
    }
    let measured = measured_modes(scene, fit, fault);
    if measured.is_empty() {
        return None;
    }
    let replaced = match &fault.change {
        Change::Axis(_) | Change::Position { .. } | Change::Tilted(_) => Some(readings(scene, fit, fault)?),
        _ => None,
    };
    match fault.change {
        Change::Noisy => return Some(Trace::Block(measured.iter().map(|&m| rows.shape(m, s)).collect())),
        Change::Dead => {
            let readings =
                measured.iter().map(|&m| weight * fit.test_shapes[(s, m)] * fit.inverse_sd[(s, m)]).collect();
            return Some(Trace::Replaced(measured.iter().map(|&m| rows.shape(m, s)).collect(), readings));
        }
        _ => {}
    }
    for &m in &measured {
        let column = |a: &DMatrix<f64>| -> Vec<f64> { a.column(m).iter().copied().collect() };
        let (mut phi, mut test, mut w) = (column(&fit.shapes), column(&fit.test_shapes), column(&fit.inverse_sd));
        let before = fault.is_angle().then(|| shape_rows(&phi, &test, &w));
        match &fault.change {
            Change::Gain => {
                let r = shape_rows(&phi, &test, &w);
                // c φ/σ of this sensor: its reading as the model sees it.
                delta[rows.shape(m, s)] = weight * (r[s] + test[s] * w[s]);
                continue;
            }
            Change::Sign => test[s] = -test[s],
            Change::Swap(other) => {
                test.swap(s, *other);
                w.swap(s, *other);
            }
            Change::Turned(other) => {
                (phi[s], phi[*other]) = (phi[s] + STEP * phi[*other], phi[*other] - STEP * phi[s]);
            }
            Change::Tilted(_) => phi[s] += STEP * replaced.as_ref()?[m],
            _ => phi[s] = replaced.as_ref()?[m],
        }
        for (k, v) in shape_rows(&phi, &test, &w).into_iter().enumerate() {
            let row = rows.shape(m, k);
            delta[row] = match &before {
                Some(before) => weight * (v - before[k]) / STEP,
                None => weight * v - fit.r[row],
            };
        }
    }
    if fault.change == Change::Gain || fault.is_angle() {
        return Some(Trace::Free(delta));
    }
    (delta.norm() > super::screen::VISIBLE).then_some(Trace::Fixed(delta))
}

/// What another place of the force changes in the functions.
fn driving_point(scene: &Scene, fit: &Fit, weight: f64, fault: &Fault) -> Result<Trace, DiagnosisError> {
    let delta = corrected_rows(scene, fit, weight, fault, 1.0)? - &fit.r;
    Ok(Trace::Fixed(of_measured(fit, delta)))
}

/// ∂r/∂ln g of a gain, or ∂r/∂α of an angle, at a fit whose test it has corrected by `number`.
pub(super) fn number_slope(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    fault: &Fault,
    number: f64,
) -> Result<DVector<f64>, DiagnosisError> {
    let moved = |h: f64| if fault.is_gain() { number * h.exp() } else { number + h };
    let [above, below] = [STEP, -STEP].map(|h| corrected_rows(scene, fit, weight, fault, moved(h)));
    Ok(of_measured(fit, (above? - below?) / (2.0 * STEP)))
}

/// The rows at the parameters of a fit, of tests that a fault has corrected.
fn corrected_rows(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    fault: &Fault,
    number: f64,
) -> Result<DVector<f64>, DiagnosisError> {
    let changed = scene.corrected(fault, number);
    let comparisons = changed.comparisons()?;
    let posed = Posed::new(&changed, &comparisons, vec![Prior::NONE; fit.x.len()], weight);
    Ok(posed.data_rows(&fit.theta)?)
}

/// Zero beyond the measured rows.
fn of_measured(fit: &Fit, mut rows: DVector<f64>) -> DVector<f64> {
    let measured = fit.rows.measured;
    rows.rows_mut(measured, rows.len() - measured).fill(0.0);
    rows
}

impl Trace {
    /// The same with the base projected out.
    pub(super) fn projected(&self, q: &DMatrix<f64>) -> Self {
        match self {
            Trace::Fixed(d) => Trace::Fixed(project(q, d)),
            Trace::Free(d) => Trace::Free(project(q, d)),
            other => other.clone(),
        }
    }

    /// Twice the gain of log-likelihood for a projected residual, numbers at their best values.
    pub(super) fn score(&self, r: &DVector<f64>) -> f64 {
        match self {
            Trace::Fixed(d) => (-2.0 * d.dot(r) - d.norm_squared()).max(0.0),
            Trace::Free(d) => {
                let own = d.norm_squared();
                // What is left of a channel by which the base is determined is not a hypothesis.
                if own < super::screen::VISIBLE { 0.0 } else { d.dot(r).powi(2) / own }
            }
            Trace::Block(rows) => {
                let m = rows.len() as f64;
                let sum: f64 = rows.iter().map(|&i| r[i] * r[i]).sum();
                if sum > m { sum - m - m * (sum / m).ln() } else { 0.0 }
            }
            Trace::Replaced(rows, readings) => {
                let now: f64 = rows.iter().map(|&i| r[i] * r[i]).sum();
                (now - readings.iter().map(|v| v * v).sum::<f64>()).max(0.0)
            }
        }
    }

    /// The gain, κ or angle that fits best; `neutral` where there is none.
    pub(super) fn number(&self, r: &DVector<f64>, neutral: f64) -> f64 {
        match self {
            Trace::Free(d) => (neutral - d.dot(r) / d.norm_squared().max(f64::MIN_POSITIVE)).clamp(-20.0, 20.0),
            Trace::Block(rows) => {
                let mean = rows.iter().map(|&i| r[i] * r[i]).sum::<f64>() / rows.len() as f64;
                mean.sqrt().max(1.0)
            }
            _ => neutral,
        }
    }
}
