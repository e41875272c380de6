//! Which physics is missing, where, how sure, and what else it could be.

use serde::{Deserialize, Serialize};

/// How a statement stands; the page shows it by a word and a sign as well as by colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The model explains the test.
    #[default]
    Adequate,
    /// A missing effect explains what is left.
    MissingEffect,
    /// A fault of the measurement explains it.
    MeasurementFault,
    /// Several hypotheses explain it equally well.
    Tied,
    /// None of the hypotheses explains it.
    Unexplained,
}

/// The result of a diagnosis.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Diagnosis {
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
    /// Hypotheses by descending probability, `none` and `something else` among them.
    pub hypotheses: Vec<Hypothesis>,
    /// Measurements that would separate what is tied, best first.
    pub next_measurements: Vec<Measurement>,
    /// What remains unexplained, in words; empty if nothing.
    pub remainder: String,
    /// Where the remainder sits.
    pub remainder_place: Option<Place>,
}

/// What a hypothesis acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
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
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Place {
    /// In words: `outer wing`.
    pub text: String,
    /// Nodes.
    pub nodes: Vec<usize>,
    /// Elements.
    pub elements: Vec<usize>,
    /// Sensors.
    pub sensors: Vec<usize>,
}

/// A hypothesis.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
    /// What is estimated: `offset aft of the elastic axis`.
    pub quantity: String,
    /// Its estimate, in `unit`.
    pub estimate: Option<f64>,
    /// 95 % interval of the estimate.
    pub interval: Option<[f64; 2]>,
    /// Unit of estimate and interval.
    pub unit: String,
    /// Hypotheses that the data cannot tell from this one.
    pub tied_with: Vec<String>,
    /// What speaks for it.
    pub evidence_for: Vec<String>,
    /// What speaks against it.
    pub evidence_against: Vec<String>,
    /// The edit of the model file that `add` would make, as text.
    pub patch: String,
}

/// A measurement that would tell hypotheses apart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
