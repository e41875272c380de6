//! Full refits of faults of the measurement: base parameters, and the fault's own number profiled.

use super::hypothesis::{Estimate, Refit, Tried};
use crate::error::DiagnosisError;
use crate::problem::evidence::{degrees_of_freedom, held_out_in_all, ln_evidence};
use crate::problem::fit::Fit;
use crate::problem::race::{fit, fit_by, in_full};
use crate::problem::scene::Scene;
use crate::screen::stage::Stage;
use crate::screen::traces::{FaultScore, number_slope};
use crate::thresholds::{NINETY, OTHERS_TELL};
use retune::fault::{LOOSE, Number, PlacedFault, mixture_sd, response_of};
use retune::linalg::DVector;

/// Most that a sensor is turned in a round, rad.
const MOST_TURN: f64 = 0.5;

/// Base parameters and the number of a fault, if it has one.
///
/// * `bases` - values of the base from which it starts
/// * `base` - ln evidence of the base
pub(crate) fn refit_fault(
    stage: &Stage,
    score: &FaultScore,
    bases: &[DVector<f64>],
    base: f64,
) -> Result<Refit, DiagnosisError> {
    let fault = &stage.faults[score.index];
    let starts: Vec<_> = score.robust.iter().map(|&k| &stage.robust[k]).chain(bases).cloned().collect();
    let scene = stage.scene.corrected(fault, score.number);
    let fit = fit_by(&scene, &[starts], in_full(1, 1, stage.effort()), stage.weight)?;
    let mut found = Numbered { stage, fault, number: score.number, scene, fit };
    let Told { ln_number, estimates, silent } = match fault.number() {
        Number::None => Told::default(),
        Number::Factor { sd } => found.factor(sd)?,
        Number::Angle { sd } => found.angle(sd)?,
        Number::Frequency { sd } => found.frequency(sd)?,
        Number::Scatter => found.scatter()?,
        Number::Silence => found.silence(),
        Number::Mixture => found.mixture(),
    };
    let Numbered { scene, fit, .. } = found;
    Ok(Refit {
        tried: Tried::Fault(fault.clone()),
        ln_bayes: ln_evidence(&fit)? + ln_number - base,
        estimates,
        held_out: held_out_in_all(&fit, stage.weight)?,
        misfit: fit.misfit + silent,
        missed: 0,
        ln_odds: fault.fault.ln_odds(),
        limit_of: Vec::new(),
        scene,
        fit,
    })
}

/// What the number of a fault adds to the evidence, and what it is.
#[derive(Default)]
struct Told {
    /// Of its prior and its width, or of what its likelihood costs.
    ln_number: f64,
    estimates: Vec<Estimate>,
    /// Σ (reading/σ)² of readings that are taken for noise.
    silent: f64,
}

/// A reading of the sensor of a fault in one mode, over its weighted standard deviation.
struct Reading {
    /// What the model says, c φ/σ, with the present correction.
    seen: f64,
    /// What was measured.
    measured: f64,
    residual: f64,
}

/// A fault with its number, and the fit of the base with both.
struct Numbered<'a> {
    stage: &'a Stage,
    fault: &'a PlacedFault,
    number: f64,
    scene: Scene,
    fit: Fit,
}

impl Numbered<'_> {
    /// Takes another number and fits the base with it.
    fn fit_with(&mut self, number: f64) -> Result<(), DiagnosisError> {
        self.number = number;
        self.scene = self.stage.scene.corrected(self.fault, number);
        self.fit = fit(&self.scene, std::slice::from_ref(&self.fit.x), self.stage.weight)?;
        Ok(())
    }

    /// The measured readings of its sensor.
    fn readings(&self) -> Vec<Reading> {
        let (stage, fit, s) = (self.stage, &self.fit, self.fault.at.sensor());
        let tests = (0..stage.scene.cases.len()).filter(|&k| self.fault.is_in(k));
        let modes = tests.flat_map(|k| stage.scene.cases[k].modes());
        let reading = |m: usize| {
            let residual = fit.r[fit.rows.shape(m, s)];
            Reading {
                seen: residual + fit.test_shapes[(s, m)] * fit.inverse_sd[(s, m)] * stage.weight,
                measured: stage.fit.test_shapes[(s, m)] * stage.fit.inverse_sd[(s, m)] * stage.weight,
                residual,
            }
        };
        modes.filter(|&m| stage.fit.inverse_sd[(s, m)] > 0.0).map(reading).collect()
    }

    /// ∂r/∂ln g, or ∂r/∂α.
    fn slope(&self) -> Result<DVector<f64>, DiagnosisError> {
        number_slope(&self.stage.scene, &self.fit, self.stage.weight, self.fault, self.number)
    }

    /// Rounds of fitting the number with the base, then the base with the number, until it stays.
    fn alternate(&mut self, next: impl Fn(&Self) -> Result<f64, DiagnosisError>) -> Result<(), DiagnosisError> {
        for _ in 0..self.stage.effort().number_rounds {
            let next = next(self)?;
            if !next.is_finite() || next == 0.0 || (next / self.number - 1.0).abs() < 1e-4 {
                break;
            }
            self.fit_with(next)?;
        }
        Ok(())
    }

    /// A gain: the best with the base as it is, of shapes g = t·seen/seen·seen.
    fn factor(&mut self, sd: f64) -> Result<Told, DiagnosisError> {
        let by_slope = self.stage.scene.has_functions() || self.fault.at.is_of_statics();
        self.alternate(|now| {
            if by_slope {
                let slope = now.slope()?;
                let step = -slope.dot(&now.fit.r) / slope.norm_squared().max(f64::MIN_POSITIVE);
                return Ok(now.number * step.clamp(-1.0, 1.0).exp());
            }
            let sums = |(c, o): (f64, f64), r: &Reading| (c + r.seen * r.measured, o + r.seen * r.seen);
            let (cross, own) = now.readings().iter().fold((0.0, 0.0), sums);
            Ok(now.number.abs() * if own > 0.0 { cross / own } else { 1.0 })
        })?;
        let own =
            if by_slope { self.slope()?.norm_squared() } else { self.readings().iter().map(|r| r.seen * r.seen).sum() };
        let h = own + sd.powi(-2);
        let mut ln_number = -cost_of_number(self.number.abs().ln(), sd, h);
        // A negative gain is a sign and a gain: two numbers for one.
        if self.number < 0.0 {
            ln_number -= std::f64::consts::LN_2 + 0.5 * sd.powi(-2);
        }
        let estimates = vec![estimate("gain", self.number, "1", self.number.abs() / h.sqrt())];
        Ok(Told { ln_number, estimates, silent: 0.0 })
    }

    fn angle(&mut self, sd: f64) -> Result<Told, DiagnosisError> {
        for _ in 0..self.stage.effort().number_rounds {
            let slope = self.slope()?;
            let step = -(slope.dot(&self.fit.r) + self.number / sd.powi(2)) / (slope.norm_squared() + sd.powi(-2));
            if !step.is_finite() || step.abs() < 1e-5 {
                break;
            }
            self.fit_with(self.number + step.clamp(-MOST_TURN, MOST_TURN))?;
        }
        let h = self.slope()?.norm_squared() + sd.powi(-2);
        let ln_number = -cost_of_number(self.number, sd, h);
        let estimate = estimate("angle", self.number.to_degrees(), "deg", h.powf(-0.5).to_degrees());
        Ok(Told { ln_number, estimates: vec![estimate], silent: 0.0 })
    }

    /// A frequency that the model tells from all other data.
    fn frequency(&mut self, sd: f64) -> Result<Told, DiagnosisError> {
        let Some(&m) = self.fault.at.modes().first() else { return Err(DiagnosisError::NoStart) };
        let known = self.stage.scene.test.modes[m].frequency_hz;
        // Its partner may be another where the shapes alone decide.
        for _ in 0..2 {
            let number = known.value / self.fit.frequencies[m];
            if !(number.is_finite() && number > 0.0) {
                return Err(DiagnosisError::NoStart);
            }
            self.fit_with(number)?;
        }
        // Its own row is free now. Where the others are as many as the parameters that fit them, they do not tell that it is wrong.
        if degrees_of_freedom(&self.fit, &self.fit.basis()?) - 1.0 < OTHERS_TELL {
            return Err(DiagnosisError::NoStart);
        }
        let w = self.stage.weight;
        let h = (w * known.value / known.sd).powi(2) + sd.powi(-2);
        let slope = self.fit.j.row(m).transpose();
        let (_, covariance) = self.fit.hessian()?;
        let sd_hz = slope.dot(&(covariance * &slope)).sqrt() * LOOSE * known.sd / self.number / w;
        let estimate = estimate("frequency", self.fit.frequencies[m], "Hz", sd_hz);
        Ok(Told { ln_number: -cost_of_number(self.number.ln(), sd, h), estimates: vec![estimate], silent: 0.0 })
    }

    /// A factor κ on standard deviations: the root mean square of the residuals.
    fn scatter(&mut self) -> Result<Told, DiagnosisError> {
        self.alternate(|now| {
            let readings = now.readings();
            let sum: f64 = readings.iter().map(|r| r.residual * r.residual).sum();
            Ok((now.number * (sum / readings.len().max(1) as f64).sqrt()).max(1.0))
        })?;
        let m = self.readings().len() as f64;
        let ln_k = self.number.ln();
        let ln_number = -(m * ln_k + 0.5 * ln_k * ln_k + 0.5 * (2.0 * m + 1.0).ln() - std::f64::consts::LN_2);
        let sd = self.number / (2.0 * m + 1.0).sqrt();
        Ok(Told {
            ln_number,
            estimates: vec![estimate("factor on the standard deviation", self.number, "1", sd)],
            silent: 0.0,
        })
    }

    /// The angles by which the shapes of close modes are mixed, each with its prior.
    fn mixture(&self) -> Told {
        let (test, weight) = (&self.stage.scene.test, self.stage.weight);
        let own = self.fault.at.modes();
        let mut told = Told::default();
        let mixed = self.fit.turned.iter().filter_map(|&(a, b, angle)| Some((a, b, angle?)));
        for (a, b, angle) in mixed.filter(|(a, b, _)| own.contains(a) && own.contains(b)) {
            let sd = mixture_sd(test, a, b);
            let h = weight * weight * self.fit.angle_slope(a, b).norm_squared() + sd.powi(-2);
            told.ln_number -= cost_of_number(angle, sd, h);
            let name = format!("angle of modes {}+{}", a + 1, b + 1);
            told.estimates.push(estimate(&name, angle.to_degrees(), "deg", h.powf(-0.5).to_degrees()));
        }
        told
    }

    /// Readings as noise about zero.
    fn silence(&self) -> Told {
        let own: f64 = self.readings().iter().map(|r| r.measured * r.measured).sum();
        let functions = dead_functions(&self.stage.scene, self.fault);
        Told { ln_number: -(0.5 * own + functions), estimates: Vec::new(), silent: own / self.stage.weight.powi(2) }
    }
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
fn dead_functions(scene: &Scene, fault: &PlacedFault) -> f64 {
    let spread = std::f64::consts::PI / 24.0_f64.sqrt();
    let mut cost = 0.0;
    for case in scene.cases.iter().enumerate().filter(|(k, _)| fault.is_in(*k)).map(|(_, case)| case) {
        let (Some(set), Some(fit)) = (&case.test.frfs, &case.test.frf_fit) else { continue };
        let own = case.sensors.iter().position(|&s| s == fault.at.sensor());
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
