//! Edits of a model: a small closed set, each one named entry in one block of the file; and why one is refused.

use super::flow;
use crate::catalogue::did_you_mean;
use crate::model::Parameter;
use crate::model::spec::{
    ConfigurationSpec, ElementSpec, MassSpec, ModelSpec, Named, NodeOffsetSpec, NodeSpec, OverrideSpec, ParameterSpec,
    RigidLinkSpec, SpringSpec, SupportSpec,
};
use crate::units::Scalar;
use crate::yaml::{self, Problem, Severity};
use serde::{Deserialize, Serialize};

/// A parameter that an effect brings, in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NewParameter {
    /// `<effect>.<place>.<quantity>`.
    pub name: String,
    /// SI unit, `1` for a pure number.
    pub unit: String,
    /// The value at which the model is unchanged.
    pub neutral: f64,
    /// A size that an engineer would expect.
    pub typical: f64,
    /// Physical bounds.
    pub bounds: [f64; 2],
    /// Other sizes worth a start, where a single one does not represent the range: stores over a band of frequencies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grid: Vec<f64>,
    /// What it is.
    pub description: String,
}

impl NewParameter {
    /// Whether the neutral value lies on a bound, so that the size has one sign only.
    pub fn one_sided(&self) -> bool {
        self.bounds.contains(&self.neutral)
    }

    /// Where a value lies between the bounds, in \[0, 1\].
    pub fn in_box(&self, value: f64) -> f64 {
        let [low, high] = self.bounds;
        (value - low) / (high - low)
    }

    /// The value at a place between the bounds, in \[0, 1\].
    pub fn at(&self, x: f64) -> f64 {
        let [low, high] = self.bounds;
        low + x * (high - low)
    }

    /// Whether it may be a hundred times as large as is typical: between sizes that are decades apart modes may cross, so that each has a basin of
    /// its own, and no decade is less likely than the next.
    pub fn spans_decades(&self) -> bool {
        self.neutral == self.bounds[0] && self.bounds[1] - self.neutral > 100.0 * (self.typical - self.neutral)
    }

    /// As a parameter of a model.
    pub(crate) fn parameter(&self) -> Parameter {
        Parameter {
            name: self.name.clone(),
            unit: self.unit.clone(),
            unit_factor: 1.0,
            value: self.neutral,
            bounds: Some(self.bounds),
            prior_sd: None,
            description: self.description.clone(),
        }
    }

    fn spec(&self) -> ParameterSpec {
        ParameterSpec {
            value: quantity(self.neutral, &self.unit),
            bounds: Some(self.bounds.map(|b| quantity(b, &self.unit))),
            unit: None,
            prior_sd: None,
            description: self.description.clone(),
        }
    }
}

/// A number with a unit as a scalar of the file; three digits of a typical size are all that it means.
fn quantity(value: f64, unit: &str) -> Scalar {
    if unit == "1" { Scalar::constant(value) } else { scalar(&format!("{} {unit}", flow::number(value))) }
}

/// A scalar that this program itself writes.
///
/// # Panics
/// If the text is not a scalar: a mistake in an effect.
pub(super) fn scalar(text: &str) -> Scalar {
    Scalar::parse(text).unwrap_or_else(|e| panic!("an effect's scalar: {e}"))
}

/// One edit: an entry with a name, added to a block of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Edit {
    /// To `parameters`.
    AddParameter(NewParameter),
    /// To `nodes`.
    AddNode {
        /// Its name.
        name: String,
        /// What stands there.
        entry: NodeSpec,
    },
    /// To `node_offsets`.
    AddNodeOffset {
        /// Its name.
        name: String,
        /// What stands there.
        entry: NodeOffsetSpec,
    },
    /// To `masses`.
    AddMass {
        /// Its name.
        name: String,
        /// What stands there.
        entry: MassSpec,
    },
    /// To `springs`.
    AddSpring {
        /// Its name.
        name: String,
        /// What stands there.
        entry: SpringSpec,
    },
    /// To `elements`.
    AddElement {
        /// Its name.
        name: String,
        /// What stands there.
        entry: ElementSpec,
    },
    /// To `overrides`.
    AddOverride {
        /// Its name.
        name: String,
        /// What stands there.
        entry: OverrideSpec,
    },
    /// To `rigid_links`.
    AddRigidLink {
        /// Its name.
        name: String,
        /// What stands there.
        entry: RigidLinkSpec,
    },
    /// To `supports`.
    AddSupport {
        /// Its name.
        name: String,
        /// What stands there.
        entry: SupportSpec,
    },
    /// To a block of one configuration: springs, masses, overrides, supports.
    InConfiguration {
        /// The configuration.
        configuration: String,
        /// The edit.
        edit: Box<Edit>,
    },
    /// To what a configuration has not: an entry of the base model.
    Without {
        /// The configuration.
        configuration: String,
        /// The entry.
        name: String,
    },
}

impl Edit {
    /// The block of the file that it adds to.
    pub fn block(&self) -> String {
        let word = match self {
            Edit::AddParameter(_) => "parameters",
            Edit::AddNode { .. } => "nodes",
            Edit::AddNodeOffset { .. } => "node_offsets",
            Edit::AddMass { .. } => "masses",
            Edit::AddSpring { .. } => "springs",
            Edit::AddElement { .. } => "elements",
            Edit::AddOverride { .. } => "overrides",
            Edit::AddRigidLink { .. } => "rigid_links",
            Edit::AddSupport { .. } => "supports",
            Edit::InConfiguration { configuration, edit } => return of_configuration(configuration, &edit.block()),
            Edit::Without { configuration, .. } => return of_configuration(configuration, "without"),
        };
        word.to_string()
    }

    /// The name of the entry.
    pub fn name(&self) -> &str {
        match self {
            Edit::AddParameter(p) => &p.name,
            Edit::AddNode { name, .. }
            | Edit::AddNodeOffset { name, .. }
            | Edit::AddMass { name, .. }
            | Edit::AddSpring { name, .. }
            | Edit::AddElement { name, .. }
            | Edit::AddOverride { name, .. }
            | Edit::AddRigidLink { name, .. }
            | Edit::AddSupport { name, .. }
            | Edit::Without { name, .. } => name,
            Edit::InConfiguration { edit, .. } => edit.name(),
        }
    }

    /// The entry as it stands in the file.
    pub(super) fn value(&self) -> serde_json::Value {
        match self {
            Edit::AddParameter(p) => flow::value(&p.spec()),
            Edit::AddNode { entry, .. } => flow::value(entry),
            Edit::AddNodeOffset { entry, .. } => flow::value(entry),
            Edit::AddMass { entry, .. } => flow::value(entry),
            Edit::AddSpring { entry, .. } => flow::value(entry),
            Edit::AddElement { entry, .. } => flow::value(entry),
            Edit::AddOverride { entry, .. } => flow::value(entry),
            Edit::AddRigidLink { entry, .. } => flow::value(entry),
            Edit::AddSupport { entry, .. } => flow::value(entry),
            Edit::InConfiguration { edit, .. } => edit.value(),
            Edit::Without { name, .. } => flow::value(name),
        }
    }

    pub(super) fn apply(&self, spec: &mut ModelSpec) -> Result<(), PatchError> {
        fn insert<T: Clone>(map: &mut Named<T>, block: &str, name: &str, entry: &T) -> Result<(), PatchError> {
            if map.contains_key(name) {
                return Err(PatchError::NameTaken { path: yaml::child(block, name) });
            }
            map.insert(name.to_string(), entry.clone());
            Ok(())
        }
        fn configuration<'a>(spec: &'a mut ModelSpec, name: &str) -> Result<&'a mut ConfigurationSpec, PatchError> {
            if !spec.configurations.contains_key(name) {
                let suggestion = did_you_mean(name, spec.configurations.keys().map(String::as_str));
                return Err(PatchError::UnknownConfiguration { name: name.to_string(), suggestion });
            }
            Ok(&mut spec.configurations[name])
        }
        let block = &self.block();
        match self {
            Edit::InConfiguration { configuration: name, edit } => {
                let to = configuration(spec, name)?;
                match &**edit {
                    Edit::AddMass { name, entry } => insert(&mut to.masses, block, name, entry),
                    Edit::AddSpring { name, entry } => insert(&mut to.springs, block, name, entry),
                    Edit::AddOverride { name, entry } => insert(&mut to.overrides, block, name, entry),
                    Edit::AddSupport { name, entry } => insert(&mut to.supports, block, name, entry),
                    other => {
                        let why = "a configuration has no such block; the change is one of the base model";
                        Err(PatchError::NotEditable { path: other.block(), why })
                    }
                }
            }
            Edit::Without { configuration: of, name } => {
                configuration(spec, of)?.without.push(name.clone());
                Ok(())
            }
            Edit::AddParameter(p) => insert(&mut spec.parameters, block, &p.name, &p.spec()),
            Edit::AddNode { name, entry } => insert(&mut spec.nodes, block, name, entry),
            Edit::AddNodeOffset { name, entry } => insert(&mut spec.node_offsets, block, name, entry),
            Edit::AddMass { name, entry } => insert(&mut spec.masses, block, name, entry),
            Edit::AddSpring { name, entry } => insert(&mut spec.springs, block, name, entry),
            Edit::AddElement { name, entry } => insert(&mut spec.elements, block, name, entry),
            Edit::AddOverride { name, entry } => insert(&mut spec.overrides, block, name, entry),
            Edit::AddRigidLink { name, entry } => insert(&mut spec.rigid_links, block, name, entry),
            Edit::AddSupport { name, entry } => insert(&mut spec.supports, block, name, entry),
        }
    }
}

/// The path of a block of a configuration.
fn of_configuration(configuration: &str, block: &str) -> String {
    yaml::child(&yaml::child("configurations", configuration), block)
}

/// Why an effect cannot be added, or taken out again.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// A large model is changed by elements and supports alone.
    #[error("`{id}` changes more of a model of this size than elements and supports, and cannot be tried on it")]
    NotOnLarge {
        /// The effect and its place.
        id: String,
    },
    /// A name that no effect has.
    #[error("unknown effect `{name}`{suggestion} (see `retune list effects`)")]
    UnknownEffect {
        /// The name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// A place where the effect cannot act.
    #[error("the effect `{effect}` {}; {places}{suggestion}", nowhere(place))]
    UnknownPlace {
        /// The effect.
        effect: String,
        /// The place.
        place: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
        /// Where it can.
        places: String,
    },
    /// An effect of the sensors, without a test that says where they are.
    #[error("the effect `{effect}` acts where the sensors of a test stand; name the test")]
    NoSensors {
        /// The effect.
        effect: String,
    },
    /// A configuration that the file has not.
    #[error("the model has no configuration `{name}`{suggestion}")]
    UnknownConfiguration {
        /// The name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// The file has an entry of this name already.
    #[error("`{path}` is in the file already: the effect was added before, or the name is used otherwise")]
    NameTaken {
        /// Path of the entry.
        path: String,
    },
    /// The file, or the patch, is not readable.
    #[error("the text cannot be read: {}", .0.first().map_or_else(String::new, ToString::to_string))]
    Unreadable(Vec<Problem>),
    /// The patched model is not a model.
    #[error("the model with the change is refused: {}", errors(.0))]
    Refused(Vec<Problem>),
    /// A text in a form that is not edited.
    #[error("`{path}` cannot be edited in place: {why}")]
    NotEditable {
        /// Path of the block or value.
        path: String,
        /// Why, and what to write instead.
        why: &'static str,
    },
    /// No such parameter in the file.
    #[error("the file has no parameter `{name}`{suggestion}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// A value that cannot be written.
    #[error("the value of `{name}` is {value}; a file holds finite numbers only")]
    NotFinite {
        /// The parameter.
        name: String,
        /// The value.
        value: f64,
    },
    /// Nothing to undo.
    #[error("the file has no history: nothing was added to it by `add`, or its `history` block was removed")]
    NoHistory,
    /// Something else in the file relies on what is to be taken out.
    #[error("cannot undo `{id}`: `{path}` relies on `{name}`, which it brought; change that first")]
    StillUsed {
        /// The history entry.
        id: String,
        /// What uses it.
        path: String,
        /// The name that is used.
        name: String,
    },
}

/// What is wrong, without what is only worth a warning.
fn errors(problems: &[Problem]) -> String {
    let errors = problems.iter().filter(|p| p.severity == Severity::Error).map(|p| p.message.as_str());
    errors.collect::<Vec<_>>().join("; ")
}

/// Why not there.
fn nowhere(place: &str) -> String {
    if place.is_empty() { "needs a place, `EFFECT@PLACE`".to_string() } else { format!("cannot act at `{place}`") }
}

impl PatchError {
    pub(super) fn unknown_place(effect: &str, place: &str, places: &[String]) -> Self {
        const SHOWN: usize = 12;
        let list: Vec<String> = places.iter().take(SHOWN).map(|p| format!("`{p}`")).collect();
        let more = places.len().saturating_sub(SHOWN);
        let known = match (list.is_empty(), more) {
            (true, _) => "this structure has no place for it".to_string(),
            (_, 0) => format!("its places here are {}", list.join(", ")),
            _ => format!("its places here are {} and {more} more", list.join(", ")),
        };
        PatchError::UnknownPlace {
            effect: effect.to_string(),
            place: place.to_string(),
            suggestion: did_you_mean(place, places.iter().map(String::as_str)),
            places: known,
        }
    }
}
