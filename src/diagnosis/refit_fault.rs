//! Full refits of faults of the measurement: base parameters, and the fault's own number profiled.

use super::base::{FaultScore, Stage};
use super::evidence::{degrees_of_freedom, held_out_in_all, ln_evidence};
use super::faults::{Change, FREQUENCY_SD, Fault, GAIN_SD, LN_SLIP, LOOSE, TURN_SD, response_of};
use super::fit::{Fit, STEPS, fit, fit_from};
use super::refit::{NINETY, Refit, STARTS, Tried};
use super::scene::Scene;
use super::traces::number_slope;
use super::{DiagnosisError, Estimate};
use crate::linalg::DVector;

/// Rounds of fitting the base with the number, then the number with the base.
const ROUNDS: usize = 4;
/// Degrees of freedom that the other data must have where a frequency is taken out, but for rounding: one is tested.
const LEFT: f64 = 0.9;
/// Most that a sensor is turned in a round, rad.
const MOST_TURN: f64 = 0.5;

/// Base parameters and the number of a fault, if it has one.
///
/// * `bases` - values of the base from which it starts
/// * `base` - ln evidence of the base
pub(super) fn refit_fault(
    stage: &Stage,
    score: &FaultScore,
    bases: &[DVector<f64>],
    base: f64,
) -> Result<Refit, DiagnosisError> {
    let fault = &stage.faults[score.index];
    let (w, s) = (stage.weight, fault.sensor);
    let starts: Vec<_> = score.aside.iter().map(|&k| &stage.aside[k]).chain(bases).cloned().collect();
    let mut number = score.number;
    let mut scene = stage.scene.corrected(fault, number);
    let mut found = fit_from(&scene, &starts, w, STARTS, STEPS)?;
    let readings = |fit: &Fit| -> Vec<(f64, f64, f64)> {
        // c φ/σ, t/σ with the original data, and the residual, of the measured modes of this sensor
        fault
            .modes(&stage.scene)
            .filter(|&m| stage.fit.inverse_sd[(s, m)] > 0.0)
            .map(|m| {
                let i = fit.rows.shape(m, s);
                let t = stage.fit.test_shapes[(s, m)] * stage.fit.inverse_sd[(s, m)] * w;
                let own = fit.test_shapes[(s, m)] * fit.inverse_sd[(s, m)] * w;
                (fit.r[i] + own, t, fit.r[i])
            })
            .collect()
    };
    let has_functions = stage.scene.has_functions();
    // Gain and κ are profiled: each round fits the base with the number, then the number with the base.
    let mut extra = 0.0;
    let mut estimates = Vec::new();
    if let Change::Frequency(m) = fault.change {
        let known = stage.scene.test.modes[m].frequency_hz;
        // Its partner may be another where the shapes alone decide.
        for _ in 0..2 {
            number = known.value / found.frequencies[m];
            if !(number.is_finite() && number > 0.0) {
                return Err(DiagnosisError::NoStart);
            }
            scene = stage.scene.corrected(fault, number);
            found = fit(&scene, std::slice::from_ref(&found.x), w)?;
        }
        // Its own row is free now. Where the others are as many as the parameters that fit them, they do not tell that it is wrong.
        if degrees_of_freedom(&found, &found.basis()?) - 1.0 < LEFT {
            return Err(DiagnosisError::NoStart);
        }
        let h = (w * known.value / known.sd).powi(2) + FREQUENCY_SD.powi(-2);
        extra -= cost_of_number(number.ln(), FREQUENCY_SD, h);
        let slope = found.j.row(m).transpose();
        let (_, covariance) = found.hessian()?;
        let sd = slope.dot(&(covariance * &slope)).sqrt() * LOOSE * known.sd / number / w;
        let value = found.frequencies[m];
        estimates.push(estimate("frequency", value, "Hz", sd));
    }
    if fault.is_angle() {
        for _ in 0..ROUNDS {
            let slope = number_slope(&stage.scene, &found, w, fault, number)?;
            let step = -(slope.dot(&found.r) + number / TURN_SD.powi(2)) / (slope.norm_squared() + TURN_SD.powi(-2));
            if !step.is_finite() || step.abs() < 1e-5 {
                break;
            }
            number += step.clamp(-MOST_TURN, MOST_TURN);
            scene = stage.scene.corrected(fault, number);
            found = fit(&scene, std::slice::from_ref(&found.x), w)?;
        }
        let h = number_slope(&stage.scene, &found, w, fault, number)?.norm_squared() + TURN_SD.powi(-2);
        extra -= cost_of_number(number, TURN_SD, h);
        estimates.push(estimate("angle", number.to_degrees(), "deg", h.powf(-0.5).to_degrees()));
    }
    if fault.is_gain() || fault.change == Change::Noisy {
        for _ in 0..ROUNDS {
            let now = readings(&found);
            let next = if fault.is_gain() && has_functions {
                let slope = number_slope(&stage.scene, &found, w, fault, number)?;
                number * (-slope.dot(&found.r) / slope.norm_squared().max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0).exp()
            } else if fault.is_gain() {
                // g c φ with the present g is `seen`, and t the reading: the best new gain is g t·seen/seen·seen.
                let (cross, own) = now.iter().fold((0.0, 0.0), |(c, o), (seen, t, _)| (c + seen * t, o + seen * seen));
                number.abs() * if own > 0.0 { cross / own } else { 1.0 }
            } else {
                let mean = now.iter().map(|(_, _, r)| r * r).sum::<f64>() / now.len().max(1) as f64;
                (number * mean.sqrt()).max(1.0)
            };
            if !next.is_finite() || next == 0.0 || (next / number - 1.0).abs() < 1e-4 {
                break;
            }
            number = next;
            scene = stage.scene.corrected(fault, number);
            found = fit(&scene, std::slice::from_ref(&found.x), w)?;
        }
        let now = readings(&found);
        let parameter = if fault.is_gain() { "gain" } else { "factor on the standard deviation" };
        let sd;
        if fault.is_gain() {
            let own = if has_functions {
                number_slope(&stage.scene, &found, w, fault, number)?.norm_squared()
            } else {
                now.iter().map(|(seen, ..)| seen * seen).sum()
            };
            let h = own + GAIN_SD.powi(-2);
            let ln_g = number.abs().ln();
            // A negative gain is a sign and a gain: two numbers for one.
            extra -= cost_of_number(ln_g, GAIN_SD, h);
            if number < 0.0 {
                extra -= std::f64::consts::LN_2 + 0.5 * GAIN_SD.powi(-2);
            }
            sd = number.abs() / h.sqrt();
        } else {
            let m = now.len() as f64;
            let ln_k = number.ln();
            extra -= m * ln_k + 0.5 * ln_k * ln_k + 0.5 * (2.0 * m + 1.0).ln() - std::f64::consts::LN_2;
            sd = number / (2.0 * m + 1.0).sqrt();
        }
        estimates.push(estimate(parameter, number, "1", sd));
    }
    let mut misfit = found.misfit;
    if fault.change == Change::Dead {
        let own: f64 = readings(&found).iter().map(|(_, t, _)| t * t).sum();
        extra -= 0.5 * own + dead_functions(&stage.scene, fault);
        misfit += own / (w * w);
    }
    let held_out = held_out_in_all(&found, w)?;
    let ln_bayes = ln_evidence(&found)? + extra - base;
    let tried = Tried::Fault(fault.clone());
    let ln_odds = if let Change::Frequency(_) = fault.change { LN_SLIP } else { 0.0 };
    let limit_of = Vec::new();
    Ok(Refit { tried, scene, fit: found, ln_bayes, estimates, held_out, misfit, overlooked: 0, ln_odds, limit_of })
}

/// What a number x ~ N(0, `sd`²) takes from ln evidence, by Laplace's method: ½ (x/sd)² + ½ ln(h sd²).
///
/// * `h` - the curvature of the cost in x, the prior in it
fn cost_of_number(x: f64, sd: f64, h: f64) -> f64 {
    0.5 * (x / sd).powi(2) + 0.5 * (h * sd * sd).ln()
}

/// With its 90 % interval.
fn estimate(parameter: &str, value: f64, unit: &str, sd: f64) -> Estimate {
    let interval = [value - NINETY * sd, value + NINETY * sd];
    Estimate { parameter: parameter.to_string(), value, unit: unit.to_string(), interval }
}

/// What frequency responses of a channel cost that reads noise only, of unknown level, beside those of a model:
///
/// ```text
/// Σ ln(s/σ) + ½ ((ln|H| - mean)/s)²,    s = π/√24, the standard deviation of the logarithm of a complex Gaussian's modulus
/// ```
fn dead_functions(scene: &Scene, fault: &Fault) -> f64 {
    let spread = std::f64::consts::PI / 24.0_f64.sqrt();
    let mut cost = 0.0;
    for case in fault.cases(scene) {
        let (Some(set), Some(fit)) = (&case.test.frfs, &case.test.frf_fit) else { continue };
        let own = case.sensors.iter().position(|&s| s == fault.sensor);
        let Some(response) = own.and_then(|k| response_of(set, &case.test.sensors, k)) else { continue };
        let used = (0..set.n_lines()).filter(|&l| fit.uses(set.frequencies_hz[l]));
        let logs: Vec<f64> = used
            .flat_map(|l| (0..set.references.len()).map(move |r| set.at(l, r, response).norm()))
            .filter(|v| v.is_finite() && *v > 0.0)
            .map(f64::ln)
            .collect();
        let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
        cost += logs.iter().map(|v| (spread / fit.relative_sd).ln() + 0.5 * ((v - mean) / spread).powi(2)).sum::<f64>();
    }
    cost
}
