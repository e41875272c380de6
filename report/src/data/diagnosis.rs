//! Which physics is missing, where, how sure, and what else it could be.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a statement stands; the page shows it by a word and a sign as well as by colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// As it should be.
    Good,
    /// Explained, with something to look at.
    Warning,
    /// Not explained.
    Bad,
    /// No judgement.
    #[default]
    Neutral,
}

/// What the diagnosis found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The model explains the test.
    #[default]
    Adequate,
    /// A missing effect explains what is left.
    MissingEffect,
    /// A fault of the measurement explains it.
    MeasurementFault,
    /// One hypothesis does not suffice; two or more together do.
    SeveralEffects,
    /// Several hypotheses explain it equally well.
    Tied,
    /// None of the hypotheses explains it.
    Unexplained,
    /// The model explains it only with noise that is not believable: the stated noise or the model is wrong.
    NoiseOrModel,
}

/// The result of a diagnosis.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Diagnosis {
    /// Which model it is about, where a report has several: `before step 1`. Empty when there is one.
    pub title: String,
    /// What it found.
    pub outcome: Outcome,
    /// The same in one sentence.
    pub sentence: String,
    /// Probability of a misfit this large if nothing were missing.
    pub p_value: Option<f64>,
    /// Below which probability an alarm is raised.
    pub alarm_level: Option<f64>,
    /// Number of candidates that were screened.
    pub screened: Option<u64>,
    /// The same in words: `332 effects in their places, 278 of them with a trace in these data; 940 faults`.
    pub tried: String,
    /// Misfit of the fitted model without any hypothesis.
    pub misfit: Option<f64>,
    /// What noise alone would leave of it: its degrees of freedom.
    pub degrees_of_freedom: Option<f64>,
    /// Standard deviations seem so many times the stated ones.
    pub noise_factor: Option<f64>,
    /// Hypotheses by descending probability, `none` and `something else` among them.
    pub hypotheses: Vec<Hypothesis>,
    /// Measurements that would separate what is tied, best first.
    pub next_measurements: Vec<Measurement>,
    /// What remains unexplained, in words; empty if nothing.
    pub remainder: String,
    /// Where the remainder sits.
    pub remainder_place: Option<Place>,
    /// What measured damping ratios say, where the model has no damping.
    pub damping: Option<Damping>,
    /// Where the data allow less than one might think.
    pub warnings: Vec<String>,
}

/// What measured damping ratios say.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Damping {
    /// In one sentence.
    pub sentence: String,
    /// Laws of damping by descending probability, in the columns of hypotheses.
    pub laws: Vec<Hypothesis>,
    /// The ratios.
    pub modes: Vec<DampedMode>,
}

/// A mode with a measured damping ratio.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DampedMode {
    /// Its number, from 1.
    pub mode: u64,
    /// Measured frequency, Hz.
    pub frequency_hz: f64,
    /// Measured ratio.
    pub ratio: f64,
    /// Standard deviation of `ratio`.
    pub sd: f64,
    /// By the most probable law.
    pub by_law: f64,
}

/// What a hypothesis acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Category {
    /// A physical effect that the model lacks.
    #[default]
    Effect,
    /// A fault of the measurement.
    Measurement,
    /// Nothing is missing.
    None,
    /// Something outside the catalogue.
    Other,
}

/// A place on the structure, as indices.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Place {
    /// In words: `outer wing`.
    pub text: String,
    /// Where that is on a mesh, whose names say little: `64 elements within 0.06 m of (0.384, 0.15, 0.01) m`; empty elsewhere.
    pub on_mesh: String,
    /// Nodes.
    pub nodes: Vec<usize>,
    /// Elements.
    pub elements: Vec<usize>,
    /// Sensors.
    pub sensors: Vec<usize>,
}

/// A hypothesis.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Hypothesis {
    /// What other hypotheses call it in `tied_with`: `mass-offset@outer_wing`.
    pub id: String,
    /// What it acts on.
    pub category: Category,
    /// Its kind in the catalogue: `mass-offset`.
    pub kind: String,
    /// One sentence: what it is.
    pub summary: String,
    /// Where.
    pub place: Place,
    /// Probability.
    pub probability: Option<f64>,
    /// Log Bayes factor against the model as it is.
    pub log_bayes_factor: Option<f64>,
    /// Misfit without it.
    pub misfit_before: Option<f64>,
    /// Misfit with it, after a refit.
    pub misfit_after: Option<f64>,
    /// Misfit of held-out data without it.
    pub held_out_before: Option<f64>,
    /// Misfit of held-out data with it.
    pub held_out_after: Option<f64>,
    /// Its sizes.
    pub estimates: Vec<Estimate>,
    /// Hypotheses that the data cannot tell from this one.
    pub tied_with: Vec<String>,
    /// What speaks for it.
    pub evidence_for: Vec<String>,
    /// What speaks against it.
    pub evidence_against: Vec<String>,
    /// The edit of the model file that `add` would make, as text.
    pub patch: String,
}

/// A size of a hypothesis, estimated from the data.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Estimate {
    /// What is estimated: `offset aft of the elastic axis`.
    pub quantity: String,
    /// Its value, in `unit`.
    pub value: f64,
    /// Unit of value and interval; empty for a pure number.
    pub unit: String,
    /// Interval of the estimate; which one is said by `interval_label`.
    pub interval: Option<[f64; 2]>,
    /// `90 %`, or empty.
    pub interval_label: String,
}

/// A measurement that would tell hypotheses apart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Measurement {
    /// What to measure.
    pub what: String,
    /// Why.
    pub why: String,
    /// Which hypotheses it separates.
    pub separates: Vec<String>,
    /// Expected log Bayes factor of the worst pair after it.
    pub expected_log_bayes_factor: Option<f64>,
    /// Where.
    pub place: Option<Place>,
}
