//! What a report shows, as plain data: filled by whoever ran the analysis, drawn by [`super::html`] and its siblings.
//!
//! Every part is optional: an empty list or `None` leaves its section out of the page, so a model alone, a model with
//! a test, an update and a diagnosis all make a report. Numbers are SI unless a field says otherwise; frequencies are
//! in Hz; an error is (model - test)/test, so plus means that the model is too high; NaN and infinity are shown as
//! missing. Indices count from 0 into the list that the field names; an index outside its list is ignored by the page
//! and refused by [`ReportData::validate`].
//!
//! The JSON form of [`ReportData`] is the report's data format; [`SCHEMA`] is its version. Long numeric arrays are
//! base64 text, see [`Floats`] and [`Spectrum`].

mod comparison;
mod diagnosis;
mod encoding;
mod identification;
mod live;
mod localization;
mod posterior;
mod structure;
mod update;
mod validate;

pub use comparison::{Band, Channel, Comparison, Frfs, LabelledMatrix, ModelMode, Modes, Pair, TestMode};
pub use diagnosis::{
    Category, DampedMode, Damping, Diagnosis, Estimate, Hypothesis, Level, Measurement, Outcome, Place,
};
pub(crate) use encoding::base64 as encoding_base64;
#[cfg(test)]
pub(crate) use encoding::from_base64;
pub use encoding::{Doubles, Floats, Levels, Spectrum};
pub use identification::{Diagram, Identification, IdentifiedMode, Rejected};
pub use live::{
    Live, LiveAccuracy, LiveEntries, LiveHypothesis, LiveMatrix, LivePairing, LiveParameter, LivePlan, LiveSymmetry,
    LiveTerm, LiveTestEdit, LiveTestMode, LiveVersion,
};
pub use localization::{Localization, Suspect};
pub use posterior::{Posterior, Sampled};
pub use structure::{
    Carrier, Element, Exciter, Field, Node, PointMass, Property, PropertySet, RigidLink, Scale, Sensor, Structure,
    Support,
};
pub use update::{Bound, Combination, History, MassProperty, Parameter, Step, Steps, Update};
pub use validate::ReportError;

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

/// Version of the JSON form of [`ReportData`]; it rises when a field changes its meaning or goes away.
pub const SCHEMA: u32 = 3;

/// JSON Schema (draft 7) of a report as it is written.
///
/// What is left out where there is none is never null; the schema says so, for languages that tell one from the other.
pub fn schema() -> serde_json::Value {
    let never_null = |schema: &mut Schema| {
        let required: Vec<String> = schema
            .get("required")
            .and_then(|r| r.as_array())
            .map(|r| r.iter().filter_map(|v| v.as_str().map(str::to_string)).collect())
            .unwrap_or_default();
        let Some(properties) = schema.get_mut("properties").and_then(|p| p.as_object_mut()) else { return };
        for (_, property) in properties.iter_mut().filter(|(name, _)| !required.contains(name)) {
            without_null(property);
        }
    };
    let settings = SchemaSettings::draft07().for_serialize().with_transform(RecursiveTransform(never_null));
    settings.into_generator().into_root_schema_for::<ReportData>().to_value()
}

/// A schema that allowed null beside something else, without null.
fn without_null(property: &mut serde_json::Value) {
    let is_null = |v: &serde_json::Value| *v == serde_json::json!({"type": "null"});
    if let Some(kinds) = property.get_mut("type").and_then(|t| t.as_array_mut()) {
        kinds.retain(|k| k != "null");
        if let [one] = kinds.as_slice() {
            property["type"] = one.clone();
        }
    }
    let Some(list) = property.get_mut("anyOf").and_then(|a| a.as_array_mut()) else { return };
    list.retain(|v| !is_null(v));
    if list.len() == 1 {
        property["allOf"] = property["anyOf"].take();
        if let Some(map) = property.as_object_mut() {
            map.remove("anyOf");
        }
    }
}

/// Everything that one report shows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReportData {
    /// Version of this form: [`SCHEMA`].
    pub schema: u32,
    /// Title, verdict and provenance.
    pub meta: Meta,
    /// The structure that the 3-D views draw.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub structure: Option<Structure>,
    /// Mode shapes of model and test.
    #[serde(default)]
    pub modes: Modes,
    /// Paired modes, MAC matrices and COMAC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
    /// Frequency response functions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frfs: Option<Frfs>,
    /// Poles and modes that were identified.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identification: Option<Identification>,
    /// The model that the page computes with, one for each test that it can be held against; the first is that of the report.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub live: Vec<Live>,
    /// The update: cost, parameters, what the data cannot tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub update: Option<Update>,
    /// The misfit over the steps of `learn` or over versions of the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<Steps>,
    /// Samples of the posterior.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub posterior: Option<Posterior>,
    /// Where model and test disagree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub localization: Option<Localization>,
    /// Which physics is missing, where, how sure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Diagnosis>,
    /// Diagnoses of earlier steps, in their order; `diagnosis` is the last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier_diagnoses: Vec<Diagnosis>,
}

impl Default for ReportData {
    fn default() -> Self {
        Self {
            schema: SCHEMA,
            meta: Meta::default(),
            structure: None,
            modes: Modes::default(),
            comparison: None,
            frfs: None,
            identification: None,
            live: Vec::new(),
            update: None,
            steps: None,
            posterior: None,
            localization: None,
            diagnosis: None,
            earlier_diagnoses: Vec::new(),
        }
    }
}

/// Title, verdict and provenance of a report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Meta {
    /// Name of the structure or the study.
    pub title: String,
    /// One line below the title: which model against which test.
    pub subtitle: String,
    /// The answer, at the top of the page.
    pub verdict: Option<Verdict>,
    /// When the report was made, as text; left out where output must repeat bit for bit.
    pub created: Option<String>,
    /// Versions of the program and of what it stands on.
    pub versions: Vec<Named>,
    /// Seeds of every random stream.
    pub seeds: Vec<Named>,
    /// Commands that make this report again.
    pub commands: Vec<String>,
    /// The tests, the first that of the pictures.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tests: Vec<TestRecord>,
    /// Files that were read.
    pub files: Vec<FileRecord>,
    /// For each kind of data: measured or synthetic.
    pub data_items: Vec<DataItem>,
    /// What a reader should know before believing a number.
    pub warnings: Vec<String>,
    /// Why the page does not compute with the model, where it does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_live: Option<String>,
}

/// The answer of a report: one sentence and one number.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// Whether the model explains the test and, if not, what is missing.
    pub sentence: String,
    /// The number that carries the sentence, with its unit, as text: `0.93`, `41.2 -> 1.1`.
    pub number: String,
    /// What the number is: `probability of the best hypothesis`.
    pub number_label: String,
    /// How it stands.
    pub level: Level,
}

/// A name with its text.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// What it is.
    pub name: String,
    /// What it says.
    pub text: String,
}

impl Named {
    /// A name with its text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into() }
    }
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// What it was used for: `model`, `test`, `history`.
    pub role: String,
    /// Its path as given on the command line.
    pub path: String,
    /// Its SHA-256 in hexadecimal, or empty.
    pub sha256: String,
}

/// A test that the report rests on.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestRecord {
    /// Its name.
    pub name: String,
    /// The day on which it was measured, `2014-05-22`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// The configuration of the model that was tested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// What it has: `6 modes at 25 sensors`.
    pub content: String,
}

/// Where one kind of data comes from.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DataItem {
    /// Which data: `natural frequencies`, `mode shapes`.
    pub name: String,
    /// `measured` or `synthetic`.
    pub origin: String,
    /// By whom and how, or by which model.
    pub source: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The types of the page are generated from this file (`npm run build` in `web/`).
    #[test]
    fn the_schema_of_the_page_is_that_of_these_structs() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/web/report.schema.json");
        let now = format!("{:#}\n", schema());
        if std::env::var_os("RETUNE_WRITE").is_some() {
            std::fs::write(path, &now).unwrap();
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(there == now, "{path} is old: RETUNE_WRITE=1 writes it anew, then `npm run build` in report/web");
    }

    #[test]
    fn what_is_left_out_is_never_null_in_the_schema() {
        let schema = schema();
        let live = &schema["definitions"]["Live"];
        assert_eq!(
            live["properties"]["symmetry"]["allOf"],
            serde_json::json!([{"$ref": "#/definitions/LiveSymmetry"}])
        );
        assert!(live["required"].as_array().unwrap().iter().any(|r| r == "terms"));
        // What is written as null where there is none stays so.
        let pair = &schema["definitions"]["Pair"]["properties"]["mac"];
        assert_eq!(pair["type"], serde_json::json!(["number", "null"]));
    }
}
