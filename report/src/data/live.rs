//! A model that the page itself computes with: its matrices as functions of parameters, on few coordinates.

use super::encoding::{Doubles, Floats};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The terms of K and M on one basis, sensors on that basis, the test, and how right all that is.
///
/// ```text
/// K(θ) = Σ_t c_t(θ) K_t,    M(θ) = Σ_t c_t(θ) M_t,    c_t(θ) = Π_j θ_j^p
/// K φ = λ M φ,    at the sensors S φ,    at node i  D_i φ
/// ```
///
/// θ are the parameters of the model, then the sizes of the hypotheses that can be switched on. All in SI.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Live {
    /// Name of the test that it is held against.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub test_name: String,
    /// The configuration of the model, where it has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// The structure with the sensors of this test, where it is not that of the report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub structure: Option<super::Structure>,
    /// Number of coordinates, n.
    pub n: usize,
    /// Whether they are as many as the model has, so that whatever is put at a node is exact too.
    pub is_complete: bool,
    /// The first so many coordinates are rigid-body motions; one that nothing strains has rows of zeros in K.
    pub n_rigid: usize,
    /// a of X = K + aM, rad²/s², which is positive definite where the structure is stable.
    pub shift: f64,
    /// Number of elastic modes to compute.
    pub n_elastic: usize,
    /// Parameters of the model, then sizes of hypotheses.
    pub parameters: Vec<LiveParameter>,
    /// Versions of the model that the sliders can be set to, the oldest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub versions: Vec<LiveVersion>,
    /// Hypotheses of the diagnosis that can be switched on, the most probable first.
    pub hypotheses: Vec<LiveHypothesis>,
    /// Hypotheses that cannot, with the reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<super::Named>,
    /// K and M.
    pub terms: Vec<LiveTerm>,
    /// S by rows, (n_sensor x n).
    pub sensors: Doubles,
    /// What tells symmetric from antisymmetric modes, where the structure has a plane of symmetry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub symmetry: Option<LiveSymmetry>,
    /// Displacements of the nodes by coordinates, (n x 3 n_node), f32.
    pub displacement: Floats,
    /// Rotations, in the same order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Floats>,
    /// The modes of the test.
    pub test: Vec<LiveTestMode>,
    /// Damping ratio of the modes of the model that no mode of the test with a damping is paired with, in frequency responses.
    pub damping: f64,
    /// How modes are paired.
    pub pairing: LivePairing,
    /// χ² that noise alone leaves about.
    pub n_data: usize,
    /// χ² of static readings and frequency responses that the page does not compute, and leaves out.
    pub not_computed: f64,
    /// How right the coordinates are.
    pub accuracy: LiveAccuracy,
}

/// A parameter with a slider.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveParameter {
    /// Its name.
    pub name: String,
    /// Unit that people read it in; empty for a pure number.
    pub unit: String,
    /// SI value of one such unit.
    pub unit_factor: f64,
    /// Value of the report's model, SI; of a size, the value at which the model is unchanged.
    pub value: f64,
    /// Value in the first version of the model, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial: Option<f64>,
    /// Ends of the slider, SI; equal for a constant.
    pub range: [f64; 2],
    /// What it is.
    pub description: String,
}

/// A version of the model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveVersion {
    /// Its name: `initial`, `paper`.
    pub name: String,
    /// (parameter, value in SI) of those that differ from the report and that it has.
    pub values: Vec<(usize, f64)>,
}

/// A hypothesis with a switch.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveHypothesis {
    /// As in the diagnosis.
    pub id: String,
    /// What it is.
    pub kind: String,
    /// Its sizes, as indices of [`Live::parameters`].
    pub sizes: Vec<usize>,
    /// What the diagnosis estimates them to be, SI.
    pub estimates: Vec<f64>,
    /// Its probability in the diagnosis.
    pub probability: f64,
    /// Numbers of the elements of the model that it alters: what two hypotheses do to one element does not simply add up.
    pub alters: Vec<usize>,
    /// How right the coordinates are with it alone.
    pub accuracy: LiveAccuracy,
    /// Of a fault of the measurement: the test without it. The model stays as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<LiveTestEdit>,
}

/// What a test would be without a fault with number g: the entries that change.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveTestEdit {
    /// Whether g is an angle, rad, not a factor.
    pub is_angle: bool,
    /// Of the frequencies of the modes, Hz.
    pub frequency: LiveEntries,
    /// Of their standard deviations.
    pub frequency_sd: LiveEntries,
    /// Of the shapes, mode after mode.
    pub shape: LiveEntries,
    /// Of their standard deviations.
    pub shape_sd: LiveEntries,
    /// Of [`Live::sensors`].
    pub sensors: LiveEntries,
    /// The space that each mode is of then; empty where none has another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spaces: Vec<Option<String>>,
    /// What to do about the fault.
    pub remedy: String,
}

/// Entries of an array as functions of a number g: a + b g + c/g of a factor, a + b cos g + c sin g of an angle; NaN is not measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveEntries {
    /// Where.
    pub at: Vec<usize>,
    /// a, b, c of each.
    pub values: Doubles,
}

/// One term: a factor and its matrices.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveTerm {
    /// (parameter, power) of each factor; none for the constant term.
    pub powers: Vec<(usize, i32)>,
    /// K_t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<LiveMatrix>,
    /// M_t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<LiveMatrix>,
}

/// A symmetric matrix (n x n).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LiveMatrix {
    /// The rows of its lower triangle, n(n + 1)/2 numbers.
    Lower(Doubles),
    /// Σ d u uᵀ: d, then n numbers u, again and again.
    Sum(Doubles),
}

/// Φᵀ P Φ and Φᵀ Φ by rows of their lower triangles, with P the reflection of the rows of the model: the symmetry index of a shape y is yᵀ P y / yᵀ y.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveSymmetry {
    /// Φᵀ P Φ.
    pub mirror: Doubles,
    /// Φᵀ Φ.
    pub gram: Doubles,
}

/// A mode of the test.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveTestMode {
    /// Its name.
    pub label: String,
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Standard deviation of it, Hz.
    pub frequency_sd: f64,
    /// Its real shape at the sensors, NaN where not measured; empty without one.
    pub shape: Doubles,
    /// Standard deviations of the shape.
    pub shape_sd: Doubles,
    /// Its damping ratio.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Symmetry, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub family: Option<String>,
    /// Modes of one name here are one space: they are compared as what they span.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<String>,
    /// What is settled about its partner.
    pub plan: LivePlan,
    /// (M φ)ᵀ of the mode that it follows, by coordinates; empty where it follows none.
    #[serde(default, skip_serializing_if = "Doubles::is_empty")]
    pub followed: Doubles,
    /// Whether that alone tells its partner.
    #[serde(default)]
    pub followed_alone: bool,
}

/// What is settled about the partner of a test mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LivePlan {
    /// Nothing: the rule pairs it.
    #[default]
    Free,
    /// It has none.
    Aside,
    /// This elastic mode.
    Fixed(usize),
    /// The mode of this number among those of its family that the rule has left.
    Ranked(usize),
}

/// The rule and the gates of the pairs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LivePairing {
    /// `mac`, `near-mac`, `order` or `label`.
    pub by: String,
    /// Smallest likeness of a pair.
    pub min_mac: f64,
    /// g of the relative frequency window; none for an open one.
    pub frequency_window: Option<f64>,
    /// Whether symmetric and antisymmetric modes are kept apart.
    pub same_family_only: bool,
}

/// How far the coordinates have been held against the whole model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiveAccuracy {
    /// Number of random points in the ranges of the sliders at which both were solved.
    pub points: usize,
    /// Largest relative difference of the frequency of each elastic mode there.
    pub frequency: Vec<f64>,
    /// Largest difference of a MAC with the test, of each elastic mode.
    pub mac: Vec<f64>,
}

impl LiveAccuracy {
    /// The largest relative difference of a frequency among the lowest modes.
    pub fn worst(&self, n_modes: usize) -> f64 {
        self.frequency.iter().take(n_modes).copied().fold(0.0, f64::max)
    }
}
