//! The edits of an effect, and how they are written.

use super::edit::{Edit, NewParameter, PatchError, scalar};
use super::flow::{self, flow};
use super::location::Location;
use super::text;
use crate::model::spec::{HistoryEntry, MassSpec, ModelSpec, Named, OverrideSpec};
use crate::units::Scalar;
use crate::yaml::{self, Problem};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// A hypothesis: the edits that put an effect into a model, at its neutral value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// The edits, parameters first.
    pub edits: Vec<Edit>,
}

impl Patch {
    /// The parameters that it brings, in the order in which they follow those of the model.
    pub fn parameters(&self) -> impl Iterator<Item = &NewParameter> {
        self.edits.iter().filter_map(|e| match e {
            Edit::AddParameter(p) => Some(p),
            _ => None,
        })
    }

    /// The same in one configuration of a file only: parameters stand in the base model, everything else in the configuration.
    pub(super) fn within(self, configuration: &str) -> Self {
        let inside = |edit: Edit| match edit {
            Edit::AddParameter(_) => edit,
            _ => Edit::InConfiguration { configuration: configuration.to_string(), edit: Box::new(edit) },
        };
        Self { edits: self.edits.into_iter().map(inside).collect() }
    }

    /// The same in the base model only, in none of these configurations.
    pub(super) fn outside<'a>(mut self, configurations: impl Iterator<Item = &'a String>) -> Self {
        let names: Vec<String> =
            self.edits.iter().filter(|e| !matches!(e, Edit::AddParameter(_))).map(|e| e.name().to_string()).collect();
        for configuration in configurations {
            self.edits.extend(
                names.iter().map(|name| Edit::Without { configuration: configuration.clone(), name: name.clone() }),
            );
        }
        self
    }

    /// The model with the edits; everything else, and the order of everything else, is as it was.
    pub fn apply(&self, spec: &ModelSpec) -> Result<ModelSpec, PatchError> {
        let mut spec = spec.clone();
        self.add_to(&mut spec)?;
        Ok(spec)
    }

    /// Makes the edits; those before one that is refused are made.
    pub fn add_to(&self, spec: &mut ModelSpec) -> Result<(), PatchError> {
        self.edits.iter().try_for_each(|e| e.apply(spec))
    }

    /// The text of a model file with the edits: one line for each, in its block, all other bytes as they were.
    ///
    /// The result is read again and compared with [`Self::apply`]; a file that cannot be edited so is refused.
    pub fn apply_to_text(&self, text: &str) -> Result<String, PatchError> {
        text::add(text, &self.edits, None)
    }

    /// The same with a line in the `history` block, which [`super::undo`] needs.
    ///
    /// * `id` - the effect and its place, `mass-offset@left_wing.y`
    /// * `because` - why, in the words of the diagnosis; may be empty
    pub fn add_to_text(&self, text: &str, id: &str, because: &str) -> Result<String, PatchError> {
        let entry = HistoryEntry { add: id.to_string(), because: because.to_string(), inserted: Vec::new() };
        text::add(text, &self.edits, Some(entry))
    }

    /// As readable YAML, one edit a line.
    pub fn to_yaml(&self) -> String {
        let mut out = String::from("edits:\n");
        for edit in &self.edits {
            if let serde_json::Value::Object(map) = flow::value(edit) {
                for (kind, fields) in &map {
                    let _ = writeln!(out, "  - {kind}: {}", flow(fields));
                }
            }
        }
        out
    }

    /// From [`Self::to_yaml`].
    pub fn from_yaml(text: &str) -> Result<Self, PatchError> {
        let (value, _) = yaml::read::<serde_json::Value>(text).map_err(PatchError::Unreadable)?;
        serde_json::from_value(value).map_err(|e| PatchError::Unreadable(vec![Problem::error("edits", e)]))
    }
}

/// Writes the patch of one effect at one place: names follow from both.
#[derive(Debug)]
pub(super) struct Builder {
    stem: String,
    patch: Patch,
}

impl Builder {
    pub(super) fn new(effect: &str, at: &Location) -> Self {
        Self { stem: format!("{}.{}", effect.replace('-', "_"), at.stem()), patch: Patch::default() }
    }

    /// The name of an entry; `<effect>.<place>`.
    pub(super) fn stem(&self) -> &str {
        &self.stem
    }

    /// A parameter that is zero where the model is unchanged; its name.
    pub(super) fn parameter(
        &mut self,
        quantity: &str,
        unit: &str,
        typical: f64,
        bounds: [f64; 2],
        description: &str,
    ) -> String {
        self.add(NewParameter {
            name: format!("{}.{quantity}", self.stem),
            unit: unit.to_string(),
            neutral: 0.0,
            typical: round(typical),
            bounds: bounds.map(round),
            grid: Vec::new(),
            description: description.to_string(),
        })
    }

    /// Any parameter; its name.
    pub(super) fn add(&mut self, parameter: NewParameter) -> String {
        let name = parameter.name.clone();
        self.patch.edits.push(Edit::AddParameter(parameter));
        name
    }

    pub(super) fn edit(&mut self, edit: Edit) {
        self.patch.edits.push(edit);
    }

    /// An override of these names, called `<effect>.<place>`, with `suffix` where there are several.
    pub(super) fn change(&mut self, suffix: &str, of: &[String], entry: OverrideSpec) {
        let name = format!("{}{suffix}", self.stem);
        self.edit(Edit::AddOverride { name, entry: OverrideSpec { of: of.to_vec(), ..entry } });
    }

    /// A name for an entry at each of several places: `<effect>.<place>`, with a number where there are several.
    pub(super) fn named<'p, T>(&self, places: &'p [T]) -> Vec<(String, &'p T)> {
        let name = |i: usize| if places.len() > 1 { format!("{}.{}", self.stem, i + 1) } else { self.stem.clone() };
        places.iter().enumerate().map(|(i, place)| (name(i), place)).collect()
    }

    pub(super) fn finish(self) -> Patch {
        self.patch
    }
}

/// One entry of a map of scalars.
pub(super) fn entry(key: &str, text: &str) -> Named<Scalar> {
    Named::from_iter([(key.to_string(), scalar(text))])
}

/// `factor * name`, shortest.
pub(super) fn times(factor: f64, name: &str) -> String {
    if factor == 1.0 {
        name.to_string()
    } else if factor == -1.0 {
        format!("-{name}")
    } else {
        format!("{}*{name}", flow::number(factor))
    }
}

/// `factor unit * name`.
pub(super) fn of_unit(factor: f64, unit: &str, name: &str) -> String {
    format!("{} {unit} * {name}", flow::number(factor))
}

/// `a and b`, with those of further pairs behind.
pub(super) fn between(pairs: &[[&str; 2]]) -> String {
    pairs.iter().map(|[a, b]| format!("{a} and {b}")).collect::<Vec<_>>().join(", and ")
}

/// To three significant digits: sizes and bounds are orders of magnitude.
pub(super) fn round(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// A body on one node, or a copy of it on each of several.
pub(super) fn body_at(nodes: &[String]) -> MassSpec {
    let (node, nodes) = node_or_nodes(nodes);
    MassSpec { node, nodes, ..MassSpec::default() }
}

/// `node` of an entry at one node, else `nodes`.
pub(super) fn node_or_nodes(names: &[String]) -> (Option<String>, Option<Vec<String>>) {
    match names {
        [node] => (Some(node.clone()), None),
        several => (None, Some(several.to_vec())),
    }
}
