//! What is missing: physical effects and measurement faults, compared with "nothing" by evidence.
//!
//! ```text
//! fit the base -> screen every placed effect and fault with the base projected out -> alarm, calibrated by simulation
//!   -> refit the best -> evidence, held-out modes, ties -> is what remains noise? -> verdict -> next measurement
//! ```
//!
//! [`diagnose`] reads from top to bottom. `scene`, `posed` and `fit` pose and solve the problem, `base` fits and screens, `screen`, `faults`
//! and `fault_places` are the hypotheses, `noise` the null distributions, `refit` and `evidence` the comparison, `verdict` the rules,
//! and `next_measurement` what would separate ties. [`learn`] repeats it. Stated numbers are SI.

mod aside;
mod base;
pub mod benchmark;
mod error;
mod evidence;
mod fit;
mod foreign;
mod joint;
mod learn;
mod listener;
mod mesh;
mod nested;
mod next_measurement;
mod noise;
mod odds;
mod overlooked;
mod pairs;
mod posed;
mod refit;
mod refit_fault;
mod scene;
mod screen;
mod several;
mod short_fit;
mod spread;
#[cfg(test)]
mod tests;
mod traces;
mod valley;
mod verdict;
mod warnings;
mod wider;
mod words;

pub use base::sensor_loads;
pub use error::DiagnosisError;
pub use foreign::{BasePair, BasePairs, ForeignMode};
pub use learn::{Attempt, Learned, Step, learn, learn_from_tests};
pub use listener::Listener;
pub use next_measurement::NextMeasurement;
pub use spread::{Property, Spread, SpreadFactor};

use crate::data::TestData;
use crate::effect::Effects;
use crate::fault::Faults;
use crate::linalg::DVector;
use crate::model::Model;
use crate::update::HowToPair;
use crate::update::slip_of_unit;
use base::{stage, stage_begun};
use evidence::{REMAINDER, p_of_less};
use refit::{Refit, Tried, refit};
use scene::Scene;
use serde::{Deserialize, Serialize};
use valley::in_the_lowest_valley;
use verdict::{MOST_NOISE, better_than_noise, conclude};

/// How to diagnose.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The effects to try.
    pub effects: Effects,
    /// The faults of the measurement to try.
    pub faults: Faults,
    /// How modes are paired.
    pub pairing: HowToPair,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Probability of a false alarm that is accepted, above 0.01: so much of it goes to the tests of what remains.
    pub alarm_level: f64,
    /// Told what is being done.
    pub listener: Listener,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            effects: Effects::builtin(),
            faults: Faults::builtin(),
            pairing: HowToPair::default(),
            seed: 0,
            alarm_level: 0.05,
            listener: Listener::default(),
        }
    }
}

/// What a diagnosis found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The model explains the data at the stated noise, or at evenly larger noise.
    Adequate,
    /// One effect explains what the model cannot.
    MissingEffect,
    /// A fault of the measurement explains it.
    MeasurementFault,
    /// One hypothesis does not suffice; two or more together do.
    SeveralEffects,
    /// Something is missing that is not in the catalogue.
    Unexplained,
    /// The model explains the data only with noise of more than twice the stated size, or with shapes that agree less than noise lets them:
    /// the stated noise or the model is wrong.
    NoiseOrModel,
}

impl Verdict {
    /// As in `--json`.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Adequate => "adequate",
            Verdict::MissingEffect => "missing-effect",
            Verdict::MeasurementFault => "measurement-fault",
            Verdict::SeveralEffects => "several-effects",
            Verdict::Unexplained => "unexplained",
            Verdict::NoiseOrModel => "noise-or-model",
        }
    }

    /// Whether hypotheses are named, not noise or nothing.
    pub fn names_hypotheses(self) -> bool {
        matches!(self, Verdict::MissingEffect | Verdict::MeasurementFault | Verdict::SeveralEffects)
    }

    /// Whether noise is said to explain the test, believed or not.
    pub fn is_about_noise(self) -> bool {
        matches!(self, Verdict::Adequate | Verdict::NoiseOrModel)
    }
}

/// What a hypothesis acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The structure.
    Effect,
    /// The measurement.
    Fault,
}

/// An estimate with its 90 % interval, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Name of the parameter.
    pub parameter: String,
    /// Value.
    pub value: f64,
    /// SI unit.
    pub unit: String,
    /// 90 % interval.
    pub interval: [f64; 2],
}

/// A hypothesis after its refit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HypothesisResult {
    /// `mass-offset@left_wing.y`, as `add` takes it; `sensor-sign@p11`.
    pub id: String,
    /// Effect or fault.
    pub kind: Kind,
    /// Name in the catalogue.
    pub name: String,
    /// Nodes, elements or sensors.
    pub location: String,
    /// Probability among all hypotheses, "none" and "something else": exp(ln odds + ln B) over the sum of these. Where several are named
    /// together, that of being one of them.
    pub probability: f64,
    /// ln of its prior odds, half for "nothing is missing".
    #[serde(default)]
    pub ln_odds: f64,
    /// ln of its Bayes factor against the base; against the other alone where two are named.
    pub ln_bayes: f64,
    /// Σ ((model - test)/σ)² without it: of what its Bayes factor is against.
    pub misfit_before: f64,
    /// The same with it, everything refitted.
    pub misfit_after: f64,
    /// Its first size or number; none for a fault without one.
    pub estimate: Option<f64>,
    /// 90 % interval of `estimate`.
    pub interval: Option<[f64; 2]>,
    /// Unit of `estimate`.
    pub unit: Option<String>,
    /// All its sizes.
    pub estimates: Vec<Estimate>,
    /// Σ over modes of the squared error of predicting each from the others, without it.
    pub held_out_before: f64,
    /// The same with it.
    pub held_out_after: f64,
    /// Ids that the data cannot tell from it: the ln evidence of both is within 3 of the best.
    pub tied_with: Vec<String>,
    /// Ids of hypotheses that explain the test as well with more numbers, and of which this is the limit: a body on a stiff spring is a point
    /// mass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limit_of: Vec<String>,
    /// The edit of the model file, or what to do about the fault.
    pub patch: String,
}

/// Several hypotheses of the catalogue together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Together {
    /// Their ids, if they are named.
    pub ids: Vec<String>,
    /// Probability of several together, of all combinations that were compared.
    pub probability: f64,
    /// ln of their prior odds: those of each multiplied.
    pub ln_odds: f64,
    /// ln of their Bayes factor against the base.
    pub ln_bayes: f64,
    /// Σ ((model - test)/σ)² with all of them.
    pub misfit_after: Option<f64>,
}

/// The result of a diagnosis; the fields of `--json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// What it found.
    pub verdict: Verdict,
    /// The same in a sentence.
    pub sentence: String,
    /// Probability of as good a best hypothesis if nothing were missing; calibrated on all that were tried.
    pub p_value: f64,
    /// Standard deviations seem so many times the stated ones; 1 where there is no reason to think so.
    pub noise_factor: f64,
    /// Σ ((model - test)/σ)² of the fitted base.
    pub misfit: f64,
    /// Σ over modes of the squared error of predicting each from the others, by the base.
    #[serde(default)]
    pub held_out: f64,
    /// Degrees of freedom of that misfit.
    pub degrees_of_freedom: f64,
    /// Number of effects in their places that were screened.
    pub screened_effects: usize,
    /// Number of those with a trace in these data.
    pub visible_effects: usize,
    /// Number of faults that were screened.
    pub screened_faults: usize,
    /// Probability that nothing is missing.
    pub probability_none: f64,
    /// ln of its Bayes factor against the base at its odds: zero, or what the p-value of the alarm leaves it at least.
    #[serde(default)]
    pub ln_bayes_none: f64,
    /// ln of its prior odds.
    #[serde(default)]
    pub ln_odds_none: f64,
    /// Probability of something outside the catalogue, alone or beside a hypothesis.
    pub probability_other: f64,
    /// ln of its Bayes factor against the base.
    #[serde(default)]
    pub ln_bayes_other: f64,
    /// ln of its prior odds, alone.
    #[serde(default)]
    pub ln_odds_other: f64,
    /// Probability of something outside the catalogue alone, with none of the hypotheses beside it.
    #[serde(default)]
    pub probability_only_other: f64,
    /// Several hypotheses together, where such were compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub together: Option<Together>,
    /// Refitted hypotheses by descending probability.
    pub hypotheses: Vec<HypothesisResult>,
    /// Measurements that would separate what is tied, best first.
    pub next_measurements: Vec<NextMeasurement>,
    /// What is spread over the structure, where that is more probable than a single hypothesis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<Spread>,
    /// Measured modes without a partner in the fitted base, from 1.
    pub unpaired_modes: Vec<usize>,
    /// Measured modes that take part in nothing: foreign ones, and those that the user has left out.
    #[serde(default)]
    pub foreign_modes: Vec<ForeignMode>,
    /// The pairs of every test at the fitted base.
    #[serde(default)]
    pub pairs: Vec<BasePairs>,
    /// Where what remains after the best hypothesis sits; empty if it looks like noise.
    pub remainder: String,
    /// Where the data allow less than one might think.
    pub warnings: Vec<String>,
}

/// Finds what a model lacks to explain a test.
///
/// Errors: nothing to compare with, a sensor without a place on the model, a model that cannot be solved anywhere.
pub fn diagnose(model: &Model, test: &TestData, settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    diagnose_tests(model, &[test], settings)
}

/// Finds what a model lacks to explain several tests of one structure, each made in a configuration of the model file.
///
/// All tests are fitted with the same parameters. An effect of the structure acts in every configuration, one of a support or of
/// a rig where it is; a fault acts on the tests that have its sensor. Modes are numbered through all tests.
///
/// * `model` - the model of the file, with its configurations
/// * `tests` - each names its configuration, or none for the base model
///
/// # Errors
/// As [`diagnose`]; an unknown configuration.
pub fn diagnose_tests(model: &Model, tests: &[&TestData], settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    Ok(investigate(Scene::new(model, tests)?, &[], None, settings)?.diagnosis)
}

/// A diagnosis with what a next step needs.
struct Investigation {
    diagnosis: Diagnosis,
    base: base::Stage,
    refits: Vec<Refit>,
}

fn investigate(
    scene: Scene,
    starts: &[DVector<f64>],
    weight: Option<f64>,
    settings: &Settings,
) -> Result<Investigation, DiagnosisError> {
    if scene.cases.iter().all(|c| c.test.has_nothing()) {
        return Err(DiagnosisError::NoData);
    }
    for case in &scene.cases {
        if let Some(slip) = slip_of_unit(&case.model, &case.test)? {
            return Err(DiagnosisError::Unit { slip });
        }
    }
    foreign::investigate(scene, starts, weight, settings)
}

/// The same with the modes as they stand.
///
/// * `begun` - where the parameters came while the pairs were decided
fn investigate_these(
    scene: Scene,
    starts: &[DVector<f64>],
    begun: Option<&DVector<f64>>,
    weight: Option<f64>,
    settings: &Settings,
) -> Result<Investigation, DiagnosisError> {
    let is_aside = scene.test.modes.iter().all(|m| m.standing.is_aside());
    if is_aside && !scene.cases.iter().any(|c| c.test.has_more_than_modes()) {
        return Err(DiagnosisError::NoPartner);
    }
    let base = stage_begun(scene, starts, begun, weight.unwrap_or(1.0), settings)?;
    let refits = refit(&base, false)?;
    let (base, mut refits) = in_the_lowest_valley(base, refits, settings)?;
    // Larger noise than stated is a hypothesis like the others: it is taken where none explains the test better.
    if weight.is_none() && base.scatter.s2 > 1.0 && !better_than_noise(&base, &refits.hypotheses)? {
        let factor = base.scatter.s2.sqrt();
        // Noise that is hardly believable has to stand against several things that are wrong at the stated noise, too.
        let at_stated_noise = if factor > MOST_NOISE { Some(conclude(&base, &mut refits, settings)?) } else { None };
        if let Some(diagnosis) = at_stated_noise.filter(|d| d.verdict.names_hypotheses()) {
            return Ok(Investigation { diagnosis, base, refits: refits.hypotheses });
        }
        let again =
            stage(base.scene.clone(), std::slice::from_ref(&base.fit.x), factor.recip(), settings, Some(&base.seen()))?;
        let mut found = refit(&again, false)?;
        let diagnosis = conclude(&again, &mut found, settings)?;
        // What is named may leave less than noise of that size: then the misfit of a wrong base was taken for scatter.
        if !leaves_too_little(&again, &diagnosis) {
            return Ok(Investigation { diagnosis, base: again, refits: found.hypotheses });
        }
    }
    let diagnosis = conclude(&base, &mut refits, settings)?;
    Ok(Investigation { diagnosis, base, refits: refits.hypotheses })
}

/// Whether what is named leaves clearly less than the noise that it was judged by.
fn leaves_too_little(base: &base::Stage, found: &Diagnosis) -> bool {
    let is_named = found.verdict.names_hypotheses();
    let left = found.hypotheses.first().map_or(f64::INFINITY, |h| h.misfit_after * base.weight * base.weight);
    is_named && p_of_less(left, found.degrees_of_freedom) < REMAINDER
}

/// The result of one refitted hypothesis, ties and probability to be filled in.
fn result(
    base: &base::Stage,
    r: &Refit,
    ln_odds: f64,
    held_out_before: f64,
    probability: f64,
    tied: Vec<String>,
) -> HypothesisResult {
    let (kind, location, patch) = match &r.tried {
        Tried::Effect(c) => (Kind::Effect, c.location.to_string(), c.patch.to_yaml()),
        Tried::Fault(f) => (Kind::Fault, f.location(&base.scene), f.remedy(&base.scene)),
    };
    let first = r.estimates.first();
    HypothesisResult {
        id: r.id(&base.scene),
        kind,
        name: r.name().to_string(),
        location,
        probability,
        ln_odds,
        ln_bayes: r.ln_bayes,
        misfit_before: base.fit.misfit,
        misfit_after: r.misfit,
        estimate: first.map(|e| e.value),
        interval: first.map(|e| e.interval),
        unit: first.map(|e| e.unit.clone()),
        estimates: r.estimates.clone(),
        held_out_before,
        held_out_after: r.held_out,
        tied_with: tied,
        limit_of: r.limit_of.clone(),
        patch,
    }
}
