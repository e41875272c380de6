//! The update and the fall of the error.

use super::LabelledMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What an update did.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Update {
    /// Which optimiser, in words.
    pub optimizer: String,
    /// Which cost, in words: `half the squared norm of (model - test)/sigma`.
    pub objective: String,
    /// Why it ended, in words.
    pub termination: String,
    /// Evaluations of the model.
    pub evaluations: Option<u64>,
    /// Cost at the start.
    pub cost_before: Option<f64>,
    /// Cost at the end.
    pub cost_after: Option<f64>,
    /// Cost over evaluations, one for each stage or run.
    pub histories: Vec<History>,
    /// Parameters.
    pub parameters: Vec<Parameter>,
    /// Correlation of the estimates.
    pub correlation: Option<LabelledMatrix>,
    /// Combinations of parameters that the data do not determine.
    pub unidentifiable: Vec<Combination>,
    /// What the outputs do when the parameters move: rows outputs, columns parameters.
    pub sensitivities: Vec<LabelledMatrix>,
    /// Mass properties against their targets.
    pub mass_properties: Vec<MassProperty>,
}

impl Update {
    /// Whether the parameters have moved; where they have not, they are told as they are.
    pub fn has_moved(&self) -> bool {
        self.parameters.iter().any(|p| p.after.is_some())
    }
}

/// Best cost over evaluations.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct History {
    /// Its name: `differential evolution`, `refiner`.
    pub name: String,
    /// Evaluations so far, ascending.
    pub evaluations: Vec<u64>,
    /// Best cost so far.
    pub best_cost: Vec<f64>,
}

/// A bound that a parameter sits on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
}

/// A parameter before and after, in the unit that it is shown in.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Before the update.
    pub before: f64,
    /// After it; missing where nothing was updated.
    pub after: Option<f64>,
    /// Lower bound.
    pub lower: Option<f64>,
    /// Upper bound.
    pub upper: Option<f64>,
    /// Interval of the estimate; which one is said by `interval_label`.
    pub interval: Option<[f64; 2]>,
    /// `95 %`, or empty.
    pub interval_label: String,
    /// The bound that the estimate sits on.
    pub at_bound: Option<Bound>,
    /// Share of the prior's variance that the data removed, 0 (not determined) to 1.
    pub determined: Option<f64>,
}

/// A direction in parameter space along which the data say nothing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Combination {
    /// Parameter names with their weights in scaled units, largest first.
    pub weights: Vec<(String, f64)>,
    /// Singular value relative to the largest.
    pub relative_singular_value: Option<f64>,
    /// What it means, in words.
    pub meaning: String,
}

/// A mass property against its target.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MassProperty {
    /// What it is: `total mass`.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The target.
    pub target: Option<f64>,
    /// Half-width of the accepted interval.
    pub tolerance: Option<f64>,
    /// Before the update.
    pub before: Option<f64>,
    /// After it.
    pub after: Option<f64>,
    /// Whether the value after (or before, where nothing was updated) is inside the tolerance.
    pub within: Option<bool>,
    /// Where the target comes from.
    pub source: String,
}

/// The misfit over steps of `learn` or versions of the model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Steps {
    /// What the misfit is, in words.
    pub measure: String,
    /// Misfit that noise alone would leave.
    pub noise_floor: Option<f64>,
    /// Names of the modes in `Step::per_mode`.
    pub mode_labels: Vec<String>,
    /// The steps in order.
    pub steps: Vec<Step>,
}

/// One step.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Step {
    /// Its name: `initial`, `refitted`, `+ mass-offset @ outer wing`.
    pub name: String,
    /// Total misfit.
    pub misfit: f64,
    /// Misfit of every mode.
    pub per_mode: Vec<Option<f64>>,
    /// Misfit of data that the fit did not see, on the same measure.
    pub held_out: Option<f64>,
    /// The same of every mode.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held_out_per_mode: Vec<Option<f64>>,
    /// One sentence.
    pub note: String,
}
