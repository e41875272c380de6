//! Full refits of the best hypotheses: base parameters and size together.

use super::base::Stage;
use super::evidence::{REMAINDER, goodness_of_fit, held_out, ln_evidence};
use super::faults::{Change, Fault, GAIN_SD};
use super::scene::{Fit, STEPS, Scene, fit, fit_from};
use super::screen::{Score, start_sizes};
use super::{DiagnosisError, Estimate};
use crate::effect::{Candidate, NewParameter};
use crate::linalg::DVector;
use crate::model::{ParametricModel, Registry};
use crate::objective::Scaling;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Effects that are refitted in full, at most, before one of each further kind with half the best score.
const BEST: usize = 12;
/// Starts of a full refit, after a look at all.
const STARTS: usize = 4;
/// Effects that are fitted with a few steps where the best refits leave more than noise.
const SHORT_FITS: usize = 200;
/// Faults of every kind that are refitted then.
const FAULTS_OF_A_KIND: usize = 4;
/// Those steps.
const FEW_STEPS: usize = 6;
/// Faults that are refitted.
const BEST_FAULTS: usize = 4;
/// 90 % of a Gaussian lie within this many standard deviations.
const NINETY: f64 = 1.6449;

/// A hypothesis as it was tried.
#[derive(Debug, Clone)]
pub(super) enum Tried {
    Effect(Candidate),
    Fault(Fault),
}

/// A refitted hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Refit {
    pub(super) tried: Tried,
    /// The scene with the hypothesis in it, and its optimum.
    pub(super) scene: Scene,
    pub(super) fit: Fit,
    pub(super) ln_bayes: f64,
    pub(super) estimates: Vec<Estimate>,
    pub(super) held_out: f64,
    /// Misfit including the cost of data that a fault declares worthless.
    pub(super) misfit: f64,
}

impl Refit {
    pub(super) fn id(&self, original: &Scene) -> String {
        match &self.tried {
            Tried::Effect(c) => c.id(),
            Tried::Fault(f) => format!("{}@{}", f.name(), f.location(&original.test)),
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match &self.tried {
            Tried::Effect(c) => c.effect.name(),
            Tried::Fault(f) => f.name(),
        }
    }
}

/// Which effects deserve a refit: the best, one of every other kind that comes near, and stores where a mode is unpaired.
pub(super) fn chosen_effects(stage: &Stage, limit: usize) -> Vec<Score> {
    let kind = |s: &Score| stage.screened[s.index].candidate.effect.name();
    let mut out: Vec<Score> = stage.effects.iter().take(limit).copied().collect();
    let best = stage.effects.first().map_or(0.0, |s| s.t);
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for s in &out {
        *seen.entry(kind(s)).or_default() += 1;
    }
    for s in stage.effects.iter().skip(limit) {
        let store = !stage.fit.unpaired.is_empty() && !stage.screened[s.index].candidate.parameters[0].grid.is_empty();
        let store = store
            || (!stage.fit.unpaired.is_empty()
                && stage.screened[s.index].candidate.parameters.iter().any(|p| !p.grid.is_empty()));
        let count = seen.entry(kind(s)).or_default();
        if (*count == 0 && s.t > 0.5 * best) || (store && *count < 4) {
            *count += 1;
            out.push(*s);
        }
    }
    // What the data can hardly tell from the best is refitted with it, so that ties are complete.
    let best: Vec<(usize, usize)> = out.iter().take(3).map(|s| (s.index, s.column)).collect();
    let mut more = 0;
    for index in stage.directions.alike(&best) {
        if more < limit && !out.iter().any(|s| s.index == index) {
            out.extend(stage.effects.iter().find(|s| s.index == index));
            more += 1;
        }
    }
    out
}

/// What is refitted: an effect, or a fault with its number.
#[derive(Clone, Copy)]
enum Job<'a> {
    Effect(&'a Score),
    Fault(&'a (usize, f64, f64)),
}

/// Refits the best effects and faults of a stage, in parallel, in a fixed order; what cannot be fitted is left out.
///
/// Where none of them leaves noise, first-order scores have misled: then every other effect is fitted with a few steps, and
/// the best of those in full; and the best few of every kind of fault.
pub(super) fn refit(stage: &Stage, few: bool) -> Result<Vec<Refit>, DiagnosisError> {
    let base = ln_evidence(&stage.fit)?;
    let limit = if few { BEST / 2 } else { BEST };
    let scores = chosen_effects(stage, limit);
    let mut faults: Vec<&(usize, f64, f64)> = Vec::new();
    let best = stage.fault_scores.first().map_or(0.0, |f| f.1);
    for f in &stage.fault_scores {
        let kind = stage.faults[f.0].name();
        let new = !faults.iter().any(|g| stage.faults[g.0].name() == kind);
        if f.1 > 0.0 && (faults.len() < BEST_FAULTS || (new && f.1 > 0.5 * best)) && f.1 > 4.0 {
            faults.push(f);
        }
    }
    let jobs: Vec<Job<'_>> = scores.iter().map(Job::Effect).chain(faults.iter().copied().map(Job::Fault)).collect();
    let mut done = run(stage, &jobs, base);
    let mut leaves_noise = false;
    for r in &done {
        leaves_noise |= r.ln_bayes > 0.0 && goodness_of_fit(&r.fit, &r.fit.basis()?) > REMAINDER;
    }
    if !leaves_noise && !few && goodness_of_fit(&stage.fit, &stage.q) < REMAINDER {
        let taken = |s: &Score| scores.iter().any(|t| t.index == s.index);
        let rest: Vec<&Score> = stage.effects.iter().filter(|s| !taken(s)).take(SHORT_FITS).collect();
        let short: Vec<f64> = rest.par_iter().map(|s| short_fit(stage, s).unwrap_or(f64::INFINITY)).collect();
        let mut order: Vec<usize> = (0..rest.len()).filter(|&i| short[i].is_finite()).collect();
        order.sort_by(|&a, &b| short[a].total_cmp(&short[b]).then(a.cmp(&b)));
        let mut more: Vec<Job<'_>> = order.iter().take(limit).map(|&i| Job::Effect(rest[i])).collect();
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        for f in stage.fault_scores.iter().filter(|f| !faults.contains(f)) {
            let count = kinds.entry(stage.faults[f.0].name()).or_default();
            *count += 1;
            if *count <= FAULTS_OF_A_KIND {
                more.push(Job::Fault(f));
            }
        }
        done.extend(run(stage, &more, base));
    }
    Ok(done)
}

fn run(stage: &Stage, jobs: &[Job<'_>], base: f64) -> Vec<Refit> {
    let done: Vec<Option<Refit>> = jobs
        .par_iter()
        .map(|job| match job {
            Job::Effect(score) => refit_effect(stage, score, base).ok(),
            Job::Fault((index, _, number)) => refit_fault(stage, &stage.faults[*index], *number, base).ok(),
        })
        .collect();
    done.into_iter().flatten().collect()
}

/// The scene with an effect in it.
pub(super) fn with_effect(scene: &Scene, candidate: &Candidate) -> Result<Scene, DiagnosisError> {
    let patched = candidate.build(&scene.model, &Registry::builtin())?;
    let added = [scene.added.clone(), candidate.parameters.clone()].concat();
    Ok(Scene { model: patched.model, test: scene.test.clone(), added })
}

/// Where a fit of an effect may start: sizes of a ladder over the fitted and the nominal base.
fn starts(stage: &Stage, score: &Score) -> Vec<DVector<f64>> {
    let screened = &stage.screened[score.index];
    let candidate = &screened.candidate;
    let join = |x: &DVector<f64>, values: &[f64]| {
        let sizes =
            candidate.parameters.iter().zip(values).map(|(p, v)| (v - p.bounds[0]) / (p.bounds[1] - p.bounds[0]));
        DVector::from_iterator(x.len() + values.len(), x.iter().copied().chain(sizes))
    };
    let sizes = start_sizes(candidate, screened, Some(score));
    let nominal = stage.scene.start();
    sizes.iter().map(|v| join(&stage.fit.x, v)).chain(sizes.iter().map(|v| join(&nominal, v))).collect()
}

/// Φ after a few steps.
fn short_fit(stage: &Stage, score: &Score) -> Result<f64, DiagnosisError> {
    let scene = with_effect(&stage.scene, &stage.screened[score.index].candidate)?;
    Ok(fit_from(&scene, &starts(stage, score), stage.weight, 2, FEW_STEPS)?.phi)
}

fn refit_effect(stage: &Stage, score: &Score, base: f64) -> Result<Refit, DiagnosisError> {
    let candidate = &stage.screened[score.index].candidate;
    let scene = with_effect(&stage.scene, candidate)?;
    let fit = fit_from(&scene, &starts(stage, score), stage.weight, STARTS, STEPS)?;
    let priors = scene.priors();
    let first = stage.fit.x.len();
    let mut evidence = ln_evidence(&fit)?;
    for (k, p) in candidate.parameters.iter().enumerate() {
        evidence -= priors[first + k].1.ln();
        if p.one_sided() {
            evidence += std::f64::consts::LN_2;
        }
    }
    let estimates = estimates(&scene, &fit, &candidate.parameters)?;
    let held_out = held_out(&fit, stage.weight)?.iter().sum();
    let misfit = fit.misfit;
    Ok(Refit {
        tried: Tried::Effect(candidate.clone()),
        scene,
        fit,
        ln_bayes: evidence - base,
        estimates,
        held_out,
        misfit,
    })
}

/// Estimates with 90 % intervals, clipped to the bounds.
pub(super) fn estimates(scene: &Scene, fit: &Fit, of: &[NewParameter]) -> Result<Vec<Estimate>, DiagnosisError> {
    let (_, covariance) = fit.hessian()?;
    let parameters = scene.model.parameters();
    let free = Scaling::new(&scene.model).free().to_vec();
    let mut out = Vec::new();
    for p in of {
        let Some(index) = parameters.index_of(&p.name) else { continue };
        let Some(k) = free.iter().position(|&f| f == index) else { continue };
        let value = fit.theta[index];
        let half = NINETY * covariance[(k, k)].sqrt() * (p.bounds[1] - p.bounds[0]);
        out.push(Estimate {
            parameter: p.name.clone(),
            value,
            unit: p.unit.clone(),
            interval: [(value - half).max(p.bounds[0]), (value + half).min(p.bounds[1])],
        });
    }
    Ok(out)
}

fn refit_fault(stage: &Stage, fault: &Fault, number: f64, base: f64) -> Result<Refit, DiagnosisError> {
    let (w, s) = (stage.weight, fault.sensor);
    let starts = [stage.fit.x.clone(), stage.scene.start()];
    let mut number = number;
    let mut scene = stage.scene.clone();
    scene.test = fault.apply(&stage.scene.test, number);
    let mut found = fit(&scene, &starts, w)?;
    let readings = |fit: &Fit| -> Vec<(f64, f64, f64)> {
        // c φ/σ, t/σ with the original data, and the residual, of the measured modes of this sensor
        (0..fit.rows.n_modes)
            .filter(|&m| stage.fit.inverse_sd[(s, m)] > 0.0)
            .map(|m| {
                let i = fit.rows.shape(m, s);
                let t = stage.fit.test_shapes[(s, m)] * stage.fit.inverse_sd[(s, m)] * w;
                let own = fit.test_shapes[(s, m)] * fit.inverse_sd[(s, m)] * w;
                (fit.r[i] + own, t, fit.r[i])
            })
            .collect()
    };
    // Gain and κ are profiled: each round fits the base with the number, then the number with the base.
    let mut extra = 0.0;
    let mut estimates = Vec::new();
    if matches!(fault.change, Change::Gain | Change::Noisy) {
        for _ in 0..4 {
            let now = readings(&found);
            let next = if fault.change == Change::Gain {
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
            scene.test = fault.apply(&stage.scene.test, number);
            found = fit(&scene, std::slice::from_ref(&found.x), w)?;
        }
        let now = readings(&found);
        let m = now.len() as f64;
        let parameter = if fault.change == Change::Gain { "gain" } else { "factor on the standard deviation" };
        let sd;
        if fault.change == Change::Gain {
            let own: f64 = now.iter().map(|(seen, ..)| seen * seen).sum();
            let h = own + GAIN_SD.powi(-2);
            let ln_g = number.abs().ln();
            // A negative gain is a sign and a gain: two numbers for one.
            extra -= 0.5 * (ln_g / GAIN_SD).powi(2) + 0.5 * (h * GAIN_SD * GAIN_SD).ln();
            if number < 0.0 {
                extra -= std::f64::consts::LN_2 + 0.5 * GAIN_SD.powi(-2);
            }
            sd = number.abs() / h.sqrt();
        } else {
            let ln_k = number.ln();
            extra -= m * ln_k + 0.5 * ln_k * ln_k + 0.5 * (2.0 * m + 1.0).ln() - std::f64::consts::LN_2;
            sd = number / (2.0 * m + 1.0).sqrt();
        }
        estimates.push(Estimate {
            parameter: parameter.to_string(),
            value: number,
            unit: "1".to_string(),
            interval: [number - NINETY * sd, number + NINETY * sd],
        });
    }
    let mut misfit = found.misfit;
    if fault.change == Change::Dead {
        let own: f64 = readings(&found).iter().map(|(_, t, _)| t * t).sum();
        extra -= 0.5 * own;
        misfit += own / (w * w);
    }
    let held_out = held_out(&found, w)?.iter().sum();
    let ln_bayes = ln_evidence(&found)? + extra - base;
    Ok(Refit { tried: Tried::Fault(fault.clone()), scene, fit: found, ln_bayes, estimates, held_out, misfit })
}
