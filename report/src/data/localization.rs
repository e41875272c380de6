//! Where model and test disagree.

use super::Place;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elements and groups ranked by how far the residual energy there stands above noise.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Localization {
    /// The finding in one sentence; it also says that nothing stands out.
    pub sentence: String,
    /// Whether anything stands out of the noise.
    pub stands_out: bool,
    /// Probability that noise alone gives any element a p-value as low as the lowest.
    pub p_family: Option<f64>,
    /// Elements, the most suspicious first.
    pub elements: Vec<Suspect>,
    /// Groups of elements, the most suspicious first.
    pub groups: Vec<Suspect>,
}

/// How much disagreement sits in one place.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Suspect {
    /// The element or group.
    pub place: Place,
    /// Energy of the model error there over what noise alone exceeds in 5 % of tests: above 1 it stands out.
    pub above_noise: Option<f64>,
    /// Energy of the model error over the strain energy there: about the square of the relative stiffness error.
    pub relative_energy: Option<f64>,
    /// Probability that noise alone gives this energy or more.
    pub p_value: Option<f64>,
}
