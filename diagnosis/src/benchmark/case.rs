//! One twin and the answer it got.

use super::Plan;
use super::foreign::{named_and_lost, with_foreign};
use super::hidden::{Hidden, OUTSIDE, TURN, Truth, rng};
use super::structures::Specimen;
use crate::answer::Investigation;
use crate::error::DiagnosisError;
use crate::foreign::investigate;
use crate::problem::changed::with_effect;
use crate::problem::fit::project;
use crate::problem::fit::{Fit, evaluate};
use crate::problem::race::fit;
use crate::problem::scene::Scene;
use crate::result::{Diagnosis, Kind, Verdict};
use crate::screen::traces::{faults_at, traces};
use crate::settings::Settings;
use crate::until::Until;
use retune::data::TestData;
use retune::effect::{Candidate, Context, candidates};
use retune::fault::{Number, PlacedFault, SingleTest};
use retune::linalg::DVector;
use retune::objective::Scaling;
use retune::optim::Draw;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A hypothesis that takes away more of the misfit than this can be seen at all.
pub(super) const VISIBLE_GAIN: f64 = 30.0;
/// Two hypotheses whose projected traces have a larger cosine than this say the same about these data.
const ALIKE: f64 = 0.99;

/// A twin to be made and diagnosed.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) hidden: Hidden,
    pub(super) seed: u64,
}

/// What kind of thing is hidden in a twin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// Nothing.
    Nothing,
    /// An effect of the catalogue.
    Effect,
    /// A fault of the measurement.
    Fault,
    /// A change of the structure that no effect makes.
    Outside,
}

/// What was hidden and what was found.
#[expect(clippy::struct_excessive_bools, reason = "each answers a question of its own")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the structure.
    pub structure: String,
    /// What kind of thing was hidden.
    pub class: Class,
    /// Name of what was hidden.
    pub name: String,
    /// `point-mass@n8`: what was hidden and where.
    pub id: String,
    /// Seed of the case.
    pub seed: u64,
    /// How much of the misfit the truth takes away: after a refit of the parameters; outside the catalogue as it is.
    pub gain: f64,
    /// Whether that is above 30. What cannot be seen is not diagnosed.
    pub visible: bool,
    /// The verdict; none where it was not diagnosed.
    pub verdict: Option<Verdict>,
    /// Calibrated p-value.
    pub p_value: f64,
    /// Name of the first hypothesis.
    pub found: String,
    /// Its id.
    pub found_id: String,
    /// Kind and place of the first hypothesis are right.
    pub right: bool,
    /// They are right, or leave the same trace in these data as what was hidden (cosine above 0.99).
    pub alike: bool,
    /// The kind is right.
    pub right_kind: bool,
    /// What was hidden is first, or tied with the first.
    pub tied: bool,
    /// What was hidden was refitted at all.
    pub refitted: bool,
    /// Number of hypotheses tied with the first.
    pub ties: usize,
    /// Stated probability of the most probable answer: nothing, something else, or a hypothesis.
    pub stated: f64,
    /// Whether that answer is right.
    pub stated_right: bool,
    /// Share of the error that the truth takes away which the found hypothesis takes away.
    pub removed: f64,
    /// Factor on the standard deviations that was estimated.
    pub noise_factor: f64,
    /// Sizes of the effect that was hidden, SI.
    pub sizes: Vec<f64>,
    /// The misfit that a refit of what was hidden leaves.
    pub misfit_of_truth: f64,
    /// Of the modes that are not of the structure: how many were named, and how many there are.
    pub foreign_named: [usize; 2],
    /// Of the modes that are: how many were called foreign, and how many there are.
    pub true_lost: [usize; 2],
    /// The whole answer, where a single case was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Diagnosis>,
}

impl Case {
    /// What is hidden and where, as `point-mass@n8`.
    pub(super) fn id(&self, specimen: &Specimen) -> String {
        match &self.hidden {
            Hidden::Nothing => "nothing".to_string(),
            Hidden::Effect(c) => c.id(),
            Hidden::Fault(f) => {
                let test = TestData { sensors: specimen.sensors.clone(), ..TestData::default() };
                f.id(&SingleTest::new(&test))
            }
            Hidden::Outside(kind) => (*kind).to_string(),
        }
    }
}

impl Specimen {
    /// The cases of a plan on this structure.
    pub(super) fn cases(&self, plan: &Plan, settings: &Settings, seed: u64) -> Vec<Case> {
        let mut rng = rng(seed, 1);
        let mut hidden = vec![Hidden::Nothing; plan.null];
        let Ok(Truth { test, .. }) = self.twin(&Hidden::Nothing, seed, plan) else { return Vec::new() };
        let context =
            Context { frequencies_hz: test.modes.iter().map(|m| m.frequency_hz.value).collect(), ..Context::default() };
        let mut kinds: BTreeMap<&str, Vec<Hidden>> = BTreeMap::new();
        for c in candidates(&self.model, &settings.effects, &context) {
            kinds.entry(c.effect.name()).or_default().push(Hidden::Effect(c));
        }
        for list in kinds.into_values() {
            draw(&mut rng, list, plan.effects, &mut hidden);
        }
        let mut kinds: BTreeMap<&str, Vec<Hidden>> = BTreeMap::new();
        let scene = Scene::new(&self.model, &[&test]);
        if let Ok((scene, base)) = scene.and_then(|s| fit(&s, &[s.start()], 1.0).map(|f| (s, f))) {
            let list = faults_at(&scene, &base, &settings.faults);
            let seen = traces(&scene, &base, 1.0, &list, &Until::the_end());
            for (f, _) in list.into_iter().zip(seen).filter(|(_, t)| t.is_some()) {
                kinds.entry(f.name()).or_default().push(Hidden::Fault(f));
            }
        }
        for list in kinds.into_values() {
            draw(&mut rng, list, plan.faults, &mut hidden);
        }
        for kind in OUTSIDE {
            hidden.extend(std::iter::repeat_n(Hidden::Outside(kind), plan.outside));
        }
        hidden
            .into_iter()
            .enumerate()
            .map(|(i, hidden)| Case { hidden, seed: seed.wrapping_mul(100_000).wrapping_add(i as u64) })
            .collect()
    }

    /// Makes the twin, diagnoses it, compares. `None` where the truth has no twin.
    pub(super) fn run(&self, case: &Case, plan: &Plan, settings: &Settings) -> Result<Option<Outcome>, DiagnosisError> {
        let Ok(truth) = self.twin(&case.hidden, case.seed, plan) else { return Ok(None) };
        let scene = Scene::new(&self.model, &[&truth.test])?;
        let right = Scaling::new(&self.model).x(&truth.theta);
        let base = fit(&scene, &[scene.start(), right.clone()], 1.0)?;
        let gain = match &case.hidden {
            Hidden::Nothing => 0.0,
            Hidden::Effect(c) => {
                base.misfit - true_fit(&scene, c, &truth, &[&right, &base.x])?.map_or(f64::NEG_INFINITY, |f| f.misfit)
            }
            Hidden::Fault(f) => base.misfit - corrected(&scene, f, &base)?,
            Hidden::Outside(_) => base.misfit - misfit_of(&truth)?,
        };
        if !gain.is_finite() {
            return Ok(None);
        }
        let (class, name) = match &case.hidden {
            Hidden::Nothing => (Class::Nothing, "nothing"),
            Hidden::Effect(c) => (Class::Effect, c.effect.name()),
            Hidden::Fault(f) => (Class::Fault, f.name()),
            Hidden::Outside(k) => (Class::Outside, *k),
        };
        let mut out = Outcome {
            structure: self.name.clone(),
            class,
            name: name.to_string(),
            id: case.id(self),
            seed: case.seed,
            gain,
            visible: gain > VISIBLE_GAIN,
            verdict: None,
            p_value: 1.0,
            found: String::new(),
            found_id: String::new(),
            right: false,
            alike: false,
            right_kind: false,
            tied: false,
            refitted: false,
            ties: 0,
            stated: 0.0,
            stated_right: false,
            removed: 0.0,
            noise_factor: 1.0,
            sizes: truth.sizes.clone(),
            misfit_of_truth: base.misfit - gain,
            foreign_named: [0, 0],
            true_lost: [0, 0],
            diagnosis: None,
        };
        if class != Class::Nothing && !out.visible {
            return Ok(Some(out));
        }
        let (test, added) = with_foreign(&truth.test, plan, case.seed);
        let scene = Scene::new(&self.model, &[&test])?;
        let found = investigate(scene, &[], None, &Settings { seed: case.seed, ..settings.clone() })?;
        compare(&mut out, &found, case);
        [out.foreign_named, out.true_lost] = named_and_lost(&found.diagnosis, &added, test.modes.len());
        out.diagnosis = plan.only.is_some().then_some(found.diagnosis);
        Ok(Some(out))
    }
}

/// A few of a list, without repetition.
fn draw(rng: &mut impl Draw, mut list: Vec<Hidden>, count: usize, out: &mut Vec<Hidden>) {
    for _ in 0..count.min(list.len()) {
        let k = rng.below(list.len());
        out.push(list.swap_remove(k));
    }
}

/// The fit of the model with the hidden effect in it, from the truth.
fn true_fit(
    scene: &Scene,
    candidate: &Candidate,
    truth: &Truth,
    bases: &[&DVector<f64>],
) -> Result<Option<Fit>, DiagnosisError> {
    let Ok(with) = with_effect(scene, candidate) else { return Ok(None) };
    let sizes: Vec<f64> = candidate.parameters.iter().zip(&truth.sizes).map(|(p, v)| p.in_box(*v)).collect();
    let starts: Vec<DVector<f64>> =
        bases.iter().map(|x| DVector::from_iterator(x.len() + sizes.len(), x.iter().chain(&sizes).copied())).collect();
    fit(&with, &starts, 1.0).map(Some)
}

/// The misfit of what was measured: that of the noise.
fn misfit_of(truth: &Truth) -> Result<f64, DiagnosisError> {
    let scene = Scene::new(&truth.structure, &[&truth.test])?;
    Ok(evaluate(&scene, Scaling::new(&truth.structure).x(&truth.theta), 1.0)?.misfit)
}

/// The misfit with the fault taken out of the data; of a channel that is wrong in a way with a number, without the channel.
fn corrected(scene: &Scene, fault: &PlacedFault, base: &Fit) -> Result<f64, DiagnosisError> {
    let clean = match fault.number() {
        Number::Factor { .. } | Number::Scatter | Number::Silence => {
            scene.corrected(&PlacedFault { only: fault.only, ..PlacedFault::silenced(fault.at.sensor()) }, 1.0)
        }
        Number::Angle { .. } => scene.corrected(fault, TURN),
        Number::None | Number::Frequency { .. } | Number::Mixture => scene.corrected(fault, fault.number().neutral()),
    };
    Ok(fit(&clean, &[scene.start(), base.x.clone()], 1.0)?.misfit)
}

fn compare(out: &mut Outcome, found: &Investigation, case: &Case) {
    let d = &found.diagnosis;
    out.verdict = Some(d.verdict);
    out.p_value = d.p_value;
    out.noise_factor = d.noise_factor;
    let named = d.verdict.names_hypotheses();
    if let Some(first) = d.hypotheses.first() {
        out.found.clone_from(&first.name);
        out.found_id.clone_from(&first.id);
        let same_kind = |k: Kind| (k == Kind::Fault) == matches!(case.hidden, Hidden::Fault(_));
        let same = |id: &str| same_id(id, &out.id);
        out.right = named && same(&first.id);
        out.right_kind = named && same_kind(first.kind) && first.name == out.name;
        out.alike = out.right || named && alike(found, &first.id, &out.id);
        // What the first is the limit of says the same with more numbers: the data cannot tell them apart either.
        out.tied = out.right || named && first.tied_with.iter().chain(&first.limit_of).any(|t| same(t));
        out.refitted = d.hypotheses.iter().any(|h| same(&h.id));
        out.ties = first.tied_with.len();
        let gain = d.misfit - out.misfit_of_truth;
        out.removed = if gain > 0.0 { (d.misfit - first.misfit_after) / gain } else { 0.0 };
    }
    let best = d.hypotheses.iter().max_by(|a, b| a.probability.total_cmp(&b.probability));
    let top = best.map_or(0.0, |h| h.probability);
    (out.stated, out.stated_right) = if d.probability_none >= top && d.probability_none >= d.probability_other {
        (d.probability_none, out.class == Class::Nothing)
    } else if d.probability_other >= top {
        (d.probability_other, out.class == Class::Outside)
    } else {
        (top, best.is_some_and(|h| same_id(&h.id, &out.id)))
    };
}

/// The same id; a swap or an exchange reads the same both ways.
fn same_id(a: &str, b: &str) -> bool {
    let sorted = |id: &str| {
        let (name, place) = id.split_once('@').unwrap_or((id, ""));
        // Which modes of a test are close, its noise has its part in.
        if name == "modes-mixed" {
            return name.to_string();
        }
        let mut parts: Vec<&str> = place.split('+').collect();
        if name == "sensor-swap" || name == "mode-order" {
            parts.sort_unstable();
        }
        format!("{name}@{}", parts.join("+"))
    };
    sorted(a) == sorted(b)
}

/// Whether two effects leave the same trace at the base fit, everything that a refit absorbs projected out.
fn alike(found: &Investigation, a: &str, b: &str) -> bool {
    let columns = |id: &str| -> Vec<DVector<f64>> {
        let screened = found.base.screened.iter().find(|s| s.candidate.id() == id);
        screened.map_or_else(Vec::new, |s| {
            s.columns.iter().map(|c| project(&found.base.q, &c.delta)).filter(|v| v.norm() > 1e-9).collect()
        })
    };
    let (a, b) = (columns(a), columns(b));
    a.iter().any(|u| b.iter().any(|v| u.dot(v).abs() > ALIKE * u.norm() * v.norm()))
}
