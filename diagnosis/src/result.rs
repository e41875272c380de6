//! The answer of a diagnosis.

use super::damping::DampingReading;
use super::problem::work::WorkDone;
use super::search::hypothesis::Estimate;
use super::search::spread::Spread;
use serde::{Deserialize, Serialize};

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
    /// Where none are named, because they leave more than noise: the ids of the two that explain most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub best: Vec<String>,
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
    /// The same with all that is named in the model; none where nothing is named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pairs_with: Vec<BasePairs>,
    /// What measured damping ratios say, where the model has no damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingReading>,
    /// Where what remains after the best hypothesis sits; empty if it looks like noise.
    pub remainder: String,
    /// Where the data allow less than one might think.
    pub warnings: Vec<String>,
    /// What it took.
    #[serde(default)]
    pub work: WorkDone,
    /// Whether the search was stopped before its end: then this is the best answer so far.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_partial: bool,
}

/// A measured mode without a partner, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForeignMode {
    /// The mode, from 1, through all tests.
    pub mode: usize,
    /// Hz.
    pub frequency_hz: f64,
    /// Its name in the test.
    pub label: Option<String>,
    /// Probability that it is not of the structure; none where the user or a limit of theirs has put it aside.
    pub probability: Option<f64>,
    /// Why it has no partner.
    pub reason: String,
}

/// The pairs of one test at a fit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BasePairs {
    /// The test.
    pub test: String,
    /// Frequencies of the modes of the model, Hz.
    pub model_hz: Vec<f64>,
    /// MAC, a row for each of them, a column for each measured mode.
    pub mac: Vec<Vec<f64>>,
    /// A measured mode each, in their order.
    pub modes: Vec<BasePair>,
}

/// A measured mode at a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BasePair {
    /// Hz.
    pub test_hz: f64,
    /// Number of its partner, from 1.
    pub model_mode: Option<usize>,
    /// Their MAC, where the mode has a shape.
    pub mac: Option<f64>,
    /// Probability of the pair that was inferred before the fit; of one that the test file names, by what is measured alone.
    pub probability: Option<f64>,
    /// Whether the test file names it (`pair_with`).
    #[serde(default)]
    pub by_user: bool,
    /// Why there is no partner.
    pub reason: Option<String>,
}

/// A measurement and what it is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextMeasurement {
    /// What to measure.
    pub what: String,
    /// Where; a node, or empty.
    pub place: String,
    /// Expected ln Bayes factor between the two tied hypotheses that it separates worst.
    pub expected_ln_bayes: f64,
}
