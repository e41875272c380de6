//! Samples of a posterior.

use super::Floats;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What sampling has found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Posterior {
    /// The free parameters.
    pub parameters: Vec<Sampled>,
    /// Number of samples; of many, every second, third, ... is in `values`.
    pub samples: usize,
    /// ln of the evidence of the model over its bounds.
    pub log_evidence: f64,
    /// Its standard error.
    pub log_evidence_se: f64,
    /// What else is to be known: stages, accepted steps, several peaks.
    pub note: String,
}

/// The posterior of one parameter, in its unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sampled {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Quantiles 5, 25, 50, 75 and 95 %.
    pub quantiles: [f64; 5],
    /// Correlations with all parameters, in their order.
    pub correlations: Vec<f64>,
    /// The samples.
    pub values: Floats,
}
