//! Modes, pairs and frequency responses of model and test.

use super::{Floats, Levels, Spectrum};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Mode shapes of both sides.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Modes {
    /// Modes of the model, by ascending frequency.
    pub model: Vec<ModelMode>,
    /// Modes of the test, by ascending frequency.
    pub test: Vec<TestMode>,
}

/// A mode of the model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ModelMode {
    /// What it is called: `symmetric 1st bending`, or its number.
    pub label: String,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: Option<f64>,
    /// Displacement of every node, (ux, uy, uz) node after node; any scale.
    pub displacement: Floats,
    /// The same, rounded, instead of it: in the page of a large mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_levels: Option<Levels>,
    /// Its imaginary part, for a complex mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_imag: Option<Floats>,
    /// Rotation of every node, (rx, ry, rz), in rad on the scale of the displacement: the page then bends beams
    /// by their cubic shape functions. Left out for large models.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Floats>,
    /// What every sensor would read, on the scale of the displacement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_sensors: Option<Floats>,
    /// Its imaginary part, for a complex mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_sensors_imag: Option<Floats>,
}

/// A mode of the test.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TestMode {
    /// What the test calls it.
    pub label: String,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Its standard deviation, Hz.
    pub frequency_sd: Option<f64>,
    /// Damping ratio.
    pub damping_ratio: Option<f64>,
    /// `measured` or `synthetic`.
    pub origin: String,
    /// The reading of every sensor, any scale; NaN where a sensor did not measure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_sensors: Option<Floats>,
    /// Its imaginary part, for a complex shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_sensors_imag: Option<Floats>,
    /// The shape expanded to every node, (ux, uy, uz) node after node, on the scale of `at_sensors`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expanded: Option<Floats>,
    /// The same, rounded, instead of it: in the page of a large mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expanded_levels: Option<Levels>,
}

/// How the modes of model and test compare.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Comparison {
    /// Pairs of the model as reported, by ascending test frequency.
    pub pairs: Vec<Pair>,
    /// Pairs before the update.
    pub pairs_before: Vec<Pair>,
    /// Test modes without a partner, as indices into `modes.test`.
    pub unpaired_test: Vec<usize>,
    /// Why each of them has none, as a clause.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unpaired_reasons: Vec<String>,
    /// Model modes without a partner, as indices into `modes.model`.
    pub unpaired_model: Vec<usize>,
    /// Which criteria decide pass or fail, in words: `frequency within 5 %, MAC at least 0.9`.
    pub criteria: String,
    /// Half-width of the band of the frequency picture, as a fraction: 0.05.
    pub frequency_band: f64,
    /// MAC of the model as reported: rows model, columns test.
    pub mac: Option<LabelledMatrix>,
    /// MAC before the update.
    pub mac_before: Option<LabelledMatrix>,
    /// Cross-orthogonality of the paired shapes in the mass of the model at the sensors: rows model, columns test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_orthogonality: Option<LabelledMatrix>,
    /// Orthogonality of the shapes of the test with each other in the same mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub auto_orthogonality: Option<LabelledMatrix>,
    /// How that mass was found and what it costs, in one sentence.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub orthogonality_note: String,
    /// COMAC of every sensor.
    pub comac: Option<Floats>,
    /// COMAC of every sensor before the update.
    pub comac_before: Option<Floats>,
}

/// A mode of the test and its partner in the model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Pair {
    /// What the mode is called.
    pub label: String,
    /// Index into `modes.test`.
    pub test_mode: Option<usize>,
    /// Index into `modes.model`.
    pub model_mode: Option<usize>,
    /// Frequency of the test, Hz.
    pub test_hz: f64,
    /// Frequency of the model, Hz.
    pub model_hz: f64,
    /// (model - test)/test.
    pub error: f64,
    /// MAC, 0 to 1.
    pub mac: Option<f64>,
    /// Damping ratio of the test.
    pub test_damping: Option<f64>,
    /// Whether the criteria are met.
    pub passes: Option<bool>,
    /// Probability that they are, given the uncertainties.
    pub pass_probability: Option<f64>,
}

/// A matrix with names for rows and columns.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LabelledMatrix {
    /// What it is.
    pub title: String,
    /// What the rows are: `model`.
    pub row_axis: String,
    /// What the columns are: `test`.
    pub column_axis: String,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Row after row; what has no value is NaN, in JSON null, on the page blank.
    #[serde(deserialize_with = "with_gaps")]
    #[schemars(with = "Vec<Vec<Option<f64>>>")]
    pub values: Vec<Vec<f64>>,
}

/// Rows of numbers and nulls.
fn with_gaps<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<f64>>, D::Error> {
    let rows = Vec::<Vec<Option<f64>>>::deserialize(deserializer)?;
    Ok(rows.into_iter().map(|row| row.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect()).collect())
}

/// Frequency response functions of test and model on common lines.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Frfs {
    /// `receptance`, `mobility` or `accelerance`.
    pub quantity: String,
    /// Its unit: `(m/s²)/N`.
    pub unit: String,
    /// `measured` or `synthetic`.
    pub origin: String,
    /// How the functions of the model were computed, in one sentence.
    pub note: String,
    /// Frequency lines, Hz, ascending.
    pub frequency_hz: Floats,
    /// Frequency bands of the criteria.
    pub bands: Vec<Band>,
    /// The channels.
    pub channels: Vec<Channel>,
    /// Frequency domain assurance criterion of every excitation, on a coarser grid of lines: rows model, columns test.
    pub fdac: Vec<LabelledMatrix>,
    /// The same before the update.
    pub fdac_before: Vec<LabelledMatrix>,
}

/// A frequency band.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Band {
    /// Its name.
    pub name: String,
    /// Lower end, Hz.
    pub from_hz: f64,
    /// Upper end, Hz.
    pub to_hz: f64,
    /// Cross signature assurance criterion over all channels, the mean over the band's lines, 0 to 1.
    pub csac: Option<f64>,
    /// Cross signature scale factor over all channels, the mean over the band's lines, 0 to 1.
    pub csf: Option<f64>,
}

/// One frequency response function.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Channel {
    /// Name of the response, with its direction.
    pub response: String,
    /// Name of the excitation, with its direction.
    pub reference: String,
    /// Index of the response in the structure's sensors.
    pub sensor: Option<usize>,
    /// Index of the excitation in the structure's sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exciter: Option<usize>,
    /// 1 where both act along the directions of these sensors, -1 where one of them is turned round; missing where they act along others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sign: Option<f64>,
    /// As measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<Spectrum>,
    /// Of the model as reported.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<Spectrum>,
    /// Of the model before the update.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<Spectrum>,
    /// Coherence of the measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coherence: Option<Floats>,
    /// Frequency response assurance criterion in every band, 0 to 1.
    pub frac: Vec<Option<f64>>,
    /// The same before the update.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frac_before: Vec<Option<f64>>,
}
