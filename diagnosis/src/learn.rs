//! Learning: diagnose, add the best effect, refit, until nothing more is justified.

use super::error::DiagnosisError;
use super::foreign::investigate;
use super::problem::changed::with_effect;
use super::problem::evidence::{held_out, ln_evidence};
use super::problem::race::fit;
use super::problem::scene::Scene;
use super::result::{Diagnosis, Verdict};
use super::search::hypothesis::{Estimate, Tried, all_estimates, estimates};
use super::search::prior::Odds;
use super::settings::Settings;
use crate::thresholds::{STRONG, WORTH_A_TRY};
use retune::data::TestData;
use retune::effect::{Candidate, Context, Effects, PatchError, Structure, set_parameter_values};
use retune::linalg::DVector;
use retune::model::{Model, ParametricModel};

/// A step of learning.
#[derive(Debug, Clone)]
pub struct Step {
    /// What was diagnosed before the addition.
    pub diagnosis: Diagnosis,
    /// The effect that was added: none in the last step.
    pub added: Option<Candidate>,
    /// Id of a fault that was taken out of the data, if one was.
    pub corrected: Option<String>,
    /// The model of this step in the configuration of the first test, with `theta` its fitted values.
    pub model: Model,
    /// Fitted parameters, SI.
    pub theta: Vec<f64>,
    /// Σ ((model - test)/σ)², measured rows.
    pub misfit: f64,
    /// The same per mode.
    pub misfit_per_mode: Vec<f64>,
    /// Squared error of every mode predicted from the others.
    pub held_out: Vec<f64>,
    /// Where a tie was decided for the most probable: the others.
    pub tie: Vec<String>,
    /// Ids of effects that had become unnecessary and were taken out.
    pub dropped: Vec<String>,
    /// Sizes of the effects that this model has been given, with intervals.
    pub sizes: Vec<Estimate>,
    /// All free parameters of this model with intervals, the sizes among them; SI values, in the order of the model.
    pub parameters: Vec<Estimate>,
    /// Numbers of the fault that was taken out after it: a gain.
    pub correction: Vec<Estimate>,
}

/// Additions that were tried and taken back, because what they left could not be explained, or because they are not clearly more
/// probable together than a change of many parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attempt {
    /// Their ids, in order.
    pub ids: Vec<String>,
    /// What they left, Σ ((model - test)/σ)².
    pub misfit: f64,
}

/// A history of learning.
#[derive(Debug, Clone)]
pub struct Learned {
    /// Steps in order; the first has the model as it was, fitted.
    pub steps: Vec<Step>,
    /// Ids of the effects in the last model, in the order of their addition.
    pub effects: Vec<Candidate>,
    /// Whether it stopped because the data cannot decide between effects.
    pub stopped_for_tie: bool,
    /// The tests with every fault taken out that was found.
    pub tests: Vec<TestData>,
    /// What was tried beyond the last step.
    pub attempt: Option<Attempt>,
}

impl Learned {
    /// The model of every step as an edit of the model file that was learned from: effects added, parameters at their fitted values.
    ///
    /// * `original` - the text of that file
    ///
    /// # Errors
    /// A text that is not a model file, or not that one.
    pub fn model_texts(&self, original: &str) -> Result<Vec<String>, PatchError> {
        let mut present: Vec<&Candidate> = Vec::new();
        let mut out = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            present.retain(|c| !step.dropped.contains(&c.id()));
            let mut text = original.to_string();
            for c in &present {
                text = c.patch.add_to_text(&text, &c.id(), "found by retune learn")?;
            }
            let free = step.model.parameters().iter().zip(&step.theta).filter(|(p, _)| p.bounds.is_some());
            let values: Vec<(&str, f64)> = free.map(|(p, v)| (p.name.as_str(), *v)).collect();
            out.push(set_parameter_values(&text, &values)?);
            present.extend(&step.added);
        }
        Ok(out)
    }
}

/// Where to go back to from an attempt.
struct Back {
    step: usize,
    scene: Scene,
    effects: Vec<Candidate>,
    /// ln of the odds times the Bayes factor of the change of many parts.
    ln_spread: f64,
    /// The same of all that was added since.
    ln_added: f64,
}

/// Adds effects one after another as long as a diagnosis asks for them.
///
/// * `take_best` - decide ties for the most probable instead of stopping
/// * `limit` - largest number of effects
///
/// A fault of the measurement is corrected in the data (and reported), not added to the model.
pub fn learn(
    model: &Model,
    test: &TestData,
    settings: &Settings,
    take_best: bool,
    limit: usize,
) -> Result<Learned, DiagnosisError> {
    learn_from_tests(model, &[test], settings, take_best, limit)
}

/// The same from several tests of one structure, each made in a configuration of the model file.
///
/// # Errors
/// As [`diagnose_tests`](super::diagnose_tests).
pub fn learn_from_tests(
    model: &Model,
    tests: &[&TestData],
    settings: &Settings,
    take_best: bool,
    limit: usize,
) -> Result<Learned, DiagnosisError> {
    let mut scene = Scene::new(model, tests)?;
    let mut starts: Vec<DVector<f64>> = Vec::new();
    let mut weight = None;
    let mut effects: Vec<Candidate> = Vec::new();
    let mut steps = Vec::new();
    let mut stopped_for_tie = false;
    let mut dropped = Vec::new();
    let mut back: Option<Back> = None;
    for round in 0..=limit {
        let found = investigate(scene.clone(), &starts, weight, settings)?;
        weight = Some(found.base.weight);
        let fit = &found.base.fit;
        let per_mode = (0..fit.rows.n_modes)
            .map(|m| fit.mode_rows(m).iter().map(|&i| fit.r[i] * fit.r[i]).sum::<f64>() / found.base.weight.powi(2))
            .collect();
        let mut step = Step {
            diagnosis: found.diagnosis,
            added: None,
            corrected: None,
            model: scene.model_in_full()?,
            theta: fit.theta.clone(),
            misfit: fit.misfit,
            misfit_per_mode: per_mode,
            held_out: held_out(fit, found.base.weight)?,
            tie: Vec::new(),
            dropped: std::mem::take(&mut dropped),
            sizes: estimates(&scene, fit, &scene.added)?,
            parameters: all_estimates(&scene, fit)?,
            correction: Vec::new(),
        };
        let best = found.refits.first();
        // What is spread over all elements is learnt as one effect after another only where each explains much.
        let is_spread = step.diagnosis.spread.is_some();
        let excess = step.misfit - step.diagnosis.degrees_of_freedom / found.base.weight.powi(2);
        let worthwhile = !step.diagnosis.verdict.is_about_noise()
            && best.is_some_and(|b| !is_spread || step.misfit - b.misfit > WORTH_A_TRY * excess)
            && (is_spread || step.diagnosis.probability_only_other < 0.5)
            && best.is_some_and(|b| b.ln_bayes > STRONG)
            && step.diagnosis.p_value < settings.alarm_level.max(f64::from(u8::from(!fit.unpaired.is_empty())));
        let has_time = !settings.until.is_over();
        let Some(best) = best.filter(|_| worthwhile && has_time && round < limit) else {
            steps.push(step);
            break;
        };
        let ties = step.diagnosis.hypotheses.first().map(|h| h.tied_with.clone()).unwrap_or_default();
        if !take_best && !are_one_effect(scene.model(), &settings.effects, &best.tried, &ties) {
            step.tie = ties;
            stopped_for_tie = true;
            steps.push(step);
            break;
        }
        let odds = Odds::new(&found.base);
        if let Some(spread) = step.diagnosis.spread.as_ref().filter(|_| back.is_none()) {
            let (step, scene, effects) = (steps.len(), scene.clone(), effects.clone());
            let ln_spread = odds.of_something_else() + spread.ln_bayes;
            back = Some(Back { step, scene, effects, ln_spread, ln_added: 0.0 });
        }
        if let Some(back) = &mut back {
            back.ln_added += odds.of(best) + best.ln_bayes;
        }
        step.tie = ties;
        scene = best.scene.clone().in_full(Some(&best.fit.x))?;
        starts = vec![best.fit.x.clone()];
        match &best.tried {
            Tried::Effect(c) => {
                effects.push(c.clone());
                step.added = Some(c.clone());
            }
            Tried::Fault(f) => {
                step.corrected = Some(f.id(&found.base.scene));
                step.correction.clone_from(&best.estimates);
            }
        }
        steps.push(step);
        if effects.len() > 1 {
            dropped = prune(model, &mut scene, &mut starts, &mut effects, weight.unwrap_or(1.0))?;
        }
    }
    let is_explained = steps.last().is_some_and(|s| {
        let verdict = s.diagnosis.verdict;
        verdict == Verdict::Adequate || stopped_for_tie && verdict.names_hypotheses()
    });
    let mut attempt = None;
    if let Some(back) = back.filter(|b| !is_explained || b.ln_added < b.ln_spread + STRONG) {
        let given = |s: &Step| s.added.as_ref().map(Candidate::id).or_else(|| s.corrected.clone());
        let ids: Vec<String> = steps[back.step..].iter().filter_map(given).collect();
        attempt = steps.last().map(|s| Attempt { ids, misfit: s.misfit });
        steps.truncate(back.step + 1);
        if let Some(last) = steps.last_mut() {
            (last.added, last.corrected) = (None, None);
            (last.tie, last.correction) = (Vec::new(), Vec::new());
        }
        (scene, effects, stopped_for_tie) = (back.scene, back.effects, false);
    }
    let tests = scene.cases.iter().map(|c| (*c.test).clone()).collect();
    Ok(Learned { steps, effects, stopped_for_tie, tests, attempt })
}

/// Whether a hypothesis and all others, by their ids, are one effect that ends a little earlier or later: at places, one of every two a
/// wider one, that share an element or a node.
fn are_one_effect(model: &Model, effects: &Effects, tried: &Tried, others: &[String]) -> bool {
    if others.is_empty() {
        return true;
    }
    let Tried::Effect(one) = tried else { return false };
    let unknown = Context::default();
    let structure = Structure::new(model, &unknown);
    let wider = structure.clone().on_wider_places();
    let is_same = |id: &String| {
        let Ok(other) = effects.candidate(&structure, id) else { return false };
        one.effect.name() == other.effect.name()
            && (wider.is_wide(&one.location) || wider.is_wide(&other.location))
            && structure.overlap(&one.location, &other.location)
    };
    others.iter().all(is_same)
}

/// Takes out effects whose removal, after a refit of the rest, does not cost evidence.
fn prune(
    model: &Model,
    scene: &mut Scene,
    starts: &mut Vec<DVector<f64>>,
    effects: &mut Vec<Candidate>,
    weight: f64,
) -> Result<Vec<String>, DiagnosisError> {
    let mut out = Vec::new();
    let mut k = 0;
    while effects.len() > 1 && k + 1 < effects.len() {
        let with = score(scene, starts, weight)?;
        let mut rest = effects.clone();
        let gone = rest.remove(k);
        let bare = scene.with_file(model.spec().clone(), Vec::new())?;
        let Ok(smaller) = rest.iter().try_fold(bare, |s, c| with_effect(&s, c)?.in_full(None)) else {
            k += 1;
            continue;
        };
        let keep: Vec<f64> = smaller
            .solved()
            .parameters()
            .free()
            .iter()
            .filter_map(|&i| {
                let name = &smaller.solved().parameters().get(i).name;
                let all = scene.solved().parameters();
                let position = all.free().iter().position(|&f| all.get(f).name == *name)?;
                Some(starts[0][position])
            })
            .collect();
        let start = DVector::from_vec(keep);
        let without = score(&smaller, std::slice::from_ref(&start), weight)?;
        if without.0 >= with.0 {
            out.push(gone.id());
            *effects = rest;
            *scene = smaller;
            *starts = vec![without.1];
        } else {
            k += 1;
        }
    }
    Ok(out)
}

/// ln evidence with the priors of the sizes, and the optimum.
fn score(scene: &Scene, starts: &[DVector<f64>], weight: f64) -> Result<(f64, DVector<f64>), DiagnosisError> {
    let mut all = starts.to_vec();
    all.push(scene.start());
    let found = fit(scene, &all, weight)?;
    Ok((ln_evidence(&found)? + scene.ln_size_priors(&scene.added), found.x))
}
