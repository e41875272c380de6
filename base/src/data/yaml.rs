//! The YAML test file: sensors, modes with uncertainties and origins, mass properties.

mod components;
mod doubts;
mod family;
mod masses;
mod partner;
mod shape;
mod statics;
mod write;

pub use family::family_of_label;
pub use statics::{DEFAULT_FRF_SD, DEFAULT_STATIC_SD};
pub use write::write_test;

use self::components::ShapeComponentSpec;
use self::masses::MassPropertySpec;
use self::partner::PartnerSpec;
use self::shape::{EntriesSpec, ShapeSpec};
use self::statics::{FrfSpec, StaticTestSpec};
use super::correction::{self, Correction};
use super::date::Date;
use super::test::{Measured, Origin, Place, Sensor, TestData, TestMode};
use crate::catalogue::did_you_mean;
use crate::units::Scalar;
use crate::yaml::{self, Problem, Severity, child};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::de::{self, Deserializer, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Standard deviation of a frequency whose file gives none, relative: what repeated tests of one structure scatter.
pub const DEFAULT_FREQUENCY_SD: f64 = 0.005;
/// Standard deviation of a damping ratio whose file gives none, relative.
pub const DEFAULT_DAMPING_SD: f64 = 0.1;
/// Standard deviation of a shape whose file gives none, relative to its largest entry.
pub const DEFAULT_SHAPE_SD: f64 = 0.03;
/// Standard deviation of a mass property whose file gives none, relative (of a centre of gravity: 1 cm).
pub const DEFAULT_MASS_SD: f64 = 0.01;

/// A test file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestSpec {
    /// Version of the format: 1.
    pub retune_test: u32,
    /// Name of the test.
    pub name: String,
    /// A paragraph for people.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// The day on which it was measured: `2014-05-22`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<Date>,
    /// The configuration of the model that was tested, when it has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// Where the numbers come from: a name for each source.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub sources: IndexMap<String, SourceSpec>,
    /// Sensors, in the order of every shape.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub sensors: IndexMap<String, SensorSpec>,
    /// Standard deviations of numbers that bring none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub defaults: Option<DefaultsSpec>,
    /// Measured modes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<ModeSpec>,
    /// Static tests: loads on the supported structure, and what the sensors read under them.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub static_tests: IndexMap<String, StaticTestSpec>,
    /// Frequency response functions that a fit may use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frfs: Option<FrfSpec>,
    /// What has been taken out of the readings, and functions from files still have.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub corrections: Vec<Correction>,
    /// Measured mass properties: `mass`, `cg_x` ... `cg_z`, `inertia_xx` ... `inertia_yz`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub mass_properties: IndexMap<String, MassPropertySpec>,
}

/// A source of numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceSpec {
    /// Whether the numbers were measured or computed.
    pub kind: SourceKind,
    /// By whom, where, when, how.
    pub text: String,
}

/// Measured or computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SourceKind {
    /// Measured on the structure.
    Measured,
    /// Computed by a model.
    Synthetic,
}

/// A sensor: on a node, or on an element at a fraction of its length; moved from there by `position` or `offset`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorSpec {
    /// The node it sits on or is rigidly connected to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// The element it sits on or is rigidly connected to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
    /// Where on the element, 0 at its first node, 1 at its second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fraction: Option<Scalar>,
    /// Its own position in global axes, when it is elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[Scalar; 3]>,
    /// Its rigid arm from the node or the point of the element, in global axes; instead of `position`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<[Scalar; 3]>,
    /// Direction: an axis with a sign such as `+z`, or a vector.
    pub direction: DirectionSpec,
    /// Whether it reads a rotation about the direction.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub rotation: bool,
    /// Mass of the transducer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<Scalar>,
}

/// A direction: `+x`, `-z`, or `[0, 0.6, 0.8]` of any length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionSpec(pub [f64; 3]);

impl Serialize for DirectionSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            for (sign, word) in [(1.0, "+"), (-1.0, "-")] {
                let mut v = [0.0; 3];
                v[i] = sign;
                if self.0 == v {
                    return serializer.serialize_str(&format!("{word}{axis}"));
                }
            }
        }
        self.0.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for DirectionSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct DirectionVisitor;
        impl<'de> Visitor<'de> for DirectionVisitor {
            type Value = DirectionSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an axis with a sign such as `+z`, or a vector `[x, y, z]`")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<DirectionSpec, E> {
                let (sign, axis) = match text.as_bytes() {
                    [b'-', rest @ ..] => (-1.0, rest),
                    [b'+', rest @ ..] | rest => (1.0, rest),
                };
                let mut v = [0.0; 3];
                let i = ["x", "y", "z"].iter().position(|a| a.as_bytes() == axis).ok_or_else(|| {
                    E::custom(format!(
                        "`{text}` is not a direction: expected `+x`, `-x` ... `-z`, or a vector `[x, y, z]`"
                    ))
                })?;
                v[i] = sign;
                Ok(DirectionSpec(v))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<DirectionSpec, A::Error> {
                let v: [f64; 3] = Deserialize::deserialize(de::value::SeqAccessDeserializer::new(seq))?;
                let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                if !(length > 0.0 && length.is_finite()) {
                    return Err(de::Error::custom("a direction has three finite numbers, not all zero"));
                }
                Ok(DirectionSpec(v.map(|x| x / length)))
            }
        }
        deserializer.deserialize_any(DirectionVisitor)
    }
}

impl JsonSchema for DirectionSpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "DirectionSpec".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                {"enum": ["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"]},
                {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
            ]
        })
    }
}

/// Standard deviations of numbers that bring none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DefaultsSpec {
    /// Of frequencies: `0.3 %` of the value, or in Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_sd: Option<Scalar>,
    /// Of damping ratios: `10 %` of the value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_sd: Option<Scalar>,
    /// Of shape entries: `2 %` of the largest entry of the shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape_sd: Option<Scalar>,
}

/// A measured mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModeSpec {
    /// The test's name for it. A name such as `Sym 1st Bending` or `S1B` also tells its symmetry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Natural frequency.
    pub frequency: Scalar,
    /// Its standard deviation: `0.3 %` of the value, or in Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_sd: Option<Scalar>,
    /// Damping ratio.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<Scalar>,
    /// Its standard deviation, `10 %` of the value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_sd: Option<Scalar>,
    /// The source of frequency and damping; the only one when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Shape at the sensors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<ShapeSpec>,
    /// Components of the shape of unit modal mass, or of the shape that is one at a sensor.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<ShapeComponentSpec>,
    /// Its partner in the model, for a pairing that the user knows better: the name of the model's mode, or its number among the elastic
    /// modes, as `retune compare` counts them: 1 is the first above the rigid-body modes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pair_with: Option<PartnerSpec>,
    /// `false` leaves the mode out of every comparison and fit.
    #[serde(default = "yes", rename = "use", skip_serializing_if = "Clone::clone")]
    pub is_used: bool,
    /// `true` for a mode that is not of the structure: of a suspension, a shaker, a neighbour.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub foreign: bool,
    /// A name that close modes share whose shapes are mixtures, as small imperfections of a structure mix them: the model's shapes are compared
    /// with the space that they span together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<String>,
}

fn yes() -> bool {
    true
}

/// What a file without sources is told.
const NO_SOURCE: &str =
    "say under `sources` where the numbers come from: `sources: {gvt: {kind: measured, text: 'by whom, where, when'}}`";

/// Version of the format of test files that is read and written.
pub(crate) const FORMAT: u32 = 1;

/// Reads the text of a test file; warnings come with the data, problems with their places.
pub fn read_test(text: &str) -> Result<(TestData, Vec<Problem>), Vec<Problem>> {
    let (spec, map) = yaml::read::<TestSpec>(text).map_err(|problems| {
        let problems = yaml::outdated(text, problems, "retune_test", FORMAT);
        yaml::mistaken(text, problems, "retune", "this is a model file; a test file begins with `retune_test: 1`")
    })?;
    let mut reader = Reader { spec: &spec, problems: Vec::new() };
    let data = reader.read();
    if reader.problems.iter().all(|p| p.severity != Severity::Error) {
        reader.problems.extend(doubts::doubts(&data));
    }
    let problems = map.place(reader.problems);
    if problems.iter().any(|p| p.severity == Severity::Error) { Err(problems) } else { Ok((data, problems)) }
}

/// For modes that the file does not give by ascending frequency: everything counts them so.
fn counted_otherwise(modes: &[TestMode]) -> Option<String> {
    if modes.iter().any(|m| m.frequency_hz.value <= 0.0) {
        return None;
    }
    let mut order: Vec<usize> = (0..modes.len()).collect();
    order.sort_by(|&a, &b| modes[a].frequency_hz.value.total_cmp(&modes[b].frequency_hz.value));
    // Of those that have changed places, the one that has moved farthest.
    let moved = (0..order.len()).filter(|&k| order[k] != k).max_by_key(|&k| (order[k].abs_diff(k), order.len() - k))?;
    Some(format!(
        "modes are counted by ascending frequency, and the file gives them in another order: mode {} is number {} of the file, at {:.4} Hz",
        moved + 1,
        order[moved] + 1,
        modes[order[moved]].frequency_hz.value
    ))
}

/// JSON Schema of test files.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(TestSpec).to_value()
}

struct Reader<'a> {
    spec: &'a TestSpec,
    problems: Vec<Problem>,
}

impl Reader<'_> {
    fn error(&mut self, path: impl Into<String>, message: impl fmt::Display) {
        let problem = Problem::error(path, message);
        // A default is read once for every mode that needs it.
        if !self.problems.contains(&problem) {
            self.problems.push(problem);
        }
    }

    fn number(&mut self, s: &Scalar, unit: &str, path: &str) -> f64 {
        s.constant_in(unit).unwrap_or_else(|e| {
            self.error(path, e);
            1.0
        })
    }

    /// A standard deviation: in `unit`, or `%` of `value`.
    fn sd(&mut self, s: &Scalar, unit: &str, value: f64, path: &str) -> f64 {
        let percent = s.text().trim_end().ends_with('%');
        let number = self.number(s, if percent { "1" } else { unit }, path);
        if number <= 0.0 {
            self.error(path, "a standard deviation must be above zero");
        }
        let sd = if percent { number * value.abs() } else { number };
        if number > 0.0 && !doubts::is_sensible_sd(sd, value) {
            self.error(path, doubts::senseless_sd(sd, unit, value));
        }
        sd
    }

    /// * `source` - its name; the only one when absent
    fn origin(&mut self, source: Option<&str>, path: &str) -> Origin {
        let sources = &self.spec.sources;
        let found = match (source, sources.len()) {
            (Some(name), _) => sources.get(name),
            (None, 1) => sources.first().map(|(_, source)| source),
            (None, _) => None,
        };
        match (found, source) {
            (Some(SourceSpec { kind: SourceKind::Measured, text }), _) => return Origin::Measured(text.clone()),
            (Some(SourceSpec { kind: SourceKind::Synthetic, text }), _) => return Origin::Synthetic(text.clone()),
            (None, Some(name)) => {
                let suggestion = did_you_mean(name, sources.keys().map(String::as_str));
                self.error(path, format_args!("source `{name}` is not defined under `sources`{suggestion}"));
            }
            (None, None) if sources.is_empty() => {
                // Once for all numbers.
                if !self.problems.iter().any(|p| p.message == NO_SOURCE) {
                    self.error(path, NO_SOURCE);
                }
            }
            (None, None) => {
                let known: Vec<String> = sources.keys().map(|name| format!("`{name}`")).collect();
                self.error(path, format_args!("say which source it is from: {}", known.join(", ")));
            }
        }
        Origin::Synthetic(String::new())
    }

    fn read(&mut self) -> TestData {
        let spec = self.spec;
        self.problems.extend(yaml::version_problem("retune_test", spec.retune_test.into(), FORMAT));
        if spec.modes.is_empty()
            && spec.mass_properties.is_empty()
            && spec.sensors.is_empty()
            && spec.static_tests.is_empty()
        {
            self.error("", "the test has neither modes nor static tests nor mass properties nor sensors");
        }
        let sensors: Vec<Sensor> = spec.sensors.iter().map(|(name, s)| self.sensor(name, s)).collect();
        let mut modes: Vec<TestMode> =
            spec.modes.iter().enumerate().map(|(i, m)| self.mode(m, &format!("modes[{i}]"))).collect();
        if modes.iter().any(|m| m.frequency_hz.sd_is_default) {
            let text = format!(
                "no standard deviation of frequencies is given; {} % of each is assumed",
                100.0 * DEFAULT_FREQUENCY_SD
            );
            self.problems.push(Problem::warning("modes", text));
        }
        if spec.modes.iter().any(|m| m.shape.as_ref().is_some_and(|s| s.sd.is_none() && s.sds.is_none()))
            && spec.defaults.as_ref().is_none_or(|d| d.shape_sd.is_none())
        {
            let text = format!(
                "no standard deviation of shapes is given; {} % of the largest entry is assumed",
                100.0 * DEFAULT_SHAPE_SD
            );
            self.problems.push(Problem::warning("modes", text));
        }
        self.problems.extend(counted_otherwise(&modes).map(|text| Problem::warning("modes", text)));
        modes.sort_by(|a, b| a.frequency_hz.value.total_cmp(&b.frequency_hz.value));
        let mass_properties = spec.mass_properties.iter().filter_map(|(name, p)| self.mass_property(name, p)).collect();
        let static_tests = spec.static_tests.iter().map(|(name, t)| self.static_test(name, t)).collect();
        let frf_fit = spec.frfs.as_ref().map(|f| self.frf_fit(f));
        self.problems.extend(correction::problems(&spec.corrections, &sensors));
        TestData {
            name: spec.name.clone(),
            description: spec.description.clone(),
            date: spec.date,
            configuration: spec.configuration.clone(),
            sensors,
            modes,
            mass_properties,
            static_tests,
            frfs: None,
            frf_fit,
            corrections: spec.corrections.clone(),
        }
    }

    fn sensor(&mut self, name: &str, s: &SensorSpec) -> Sensor {
        let path = child("sensors", name);
        let position =
            s.position.as_ref().map(|p| [0, 1, 2].map(|i| self.number(&p[i], "m", &format!("{path}.position[{i}]"))));
        let offset =
            s.offset.as_ref().map(|p| [0, 1, 2].map(|i| self.number(&p[i], "m", &format!("{path}.offset[{i}]"))));
        if position.is_some() && offset.is_some() {
            self.error(child(&path, "offset"), "give `position` or `offset`, not both");
        }
        let place = match (&s.node, &s.element) {
            (Some(node), None) => {
                if s.fraction.is_some() {
                    self.error(child(&path, "fraction"), "`fraction` goes with `element`");
                }
                Place::Node { node: node.clone(), position }
            }
            (None, Some(element)) => {
                let fraction = s.fraction.as_ref().map_or(0.5, |f| self.number(f, "1", &child(&path, "fraction")));
                if !(0.0..=1.0).contains(&fraction) {
                    self.error(child(&path, "fraction"), format_args!("{fraction} is not between 0 and 1"));
                }
                Place::Element { element: element.clone(), fraction, position }
            }
            _ => {
                self.error(&path, "give exactly one of `node` and `element`");
                Place::Node { node: String::new(), position }
            }
        };
        let mass = s.mass.as_ref().map(|m| self.number(m, "kg", &child(&path, "mass")));
        if mass.is_some_and(|m| m < 0.0) {
            self.error(child(&path, "mass"), "a mass must be zero or above");
        }
        Sensor { name: name.to_string(), place, offset, direction: s.direction.0, is_rotation: s.rotation, mass }
    }

    fn mode(&mut self, m: &ModeSpec, path: &str) -> TestMode {
        let frequency = self.number(&m.frequency, "Hz", &child(path, "frequency"));
        if frequency <= 0.0 {
            self.error(child(path, "frequency"), format_args!("{frequency} Hz: a frequency must be above zero"));
        }
        let defaults = self.spec.defaults.clone().unwrap_or_default();
        let frequency_sd = match (&m.frequency_sd, &defaults.frequency_sd) {
            (Some(s), _) => Some(self.sd(s, "Hz", frequency, &child(path, "frequency_sd"))),
            (None, Some(s)) => Some(self.sd(s, "Hz", frequency, "defaults.frequency_sd")),
            (None, None) => None,
        };
        let damping_ratio = m.damping.as_ref().map(|d| {
            let value = self.number(d, "1", &child(path, "damping"));
            if !(0.0..1.0).contains(&value) {
                self.error(
                    child(path, "damping"),
                    format_args!("a damping ratio of {value} is not between 0 and 1 (write `2 %` for 0.02)"),
                );
            }
            let sd = match (&m.damping_sd, &defaults.damping_sd) {
                (Some(s), _) => Some(self.sd(s, "1", value, &child(path, "damping_sd"))),
                (None, Some(s)) => Some(self.sd(s, "1", value, "defaults.damping_sd")),
                (None, None) => None,
            };
            Measured { value, sd: sd.unwrap_or(DEFAULT_DAMPING_SD * value), sd_is_default: sd.is_none() }
        });
        let origin = self.origin(m.source.as_deref(), &child(path, "source"));
        let shape = m.shape.as_ref().and_then(|s| self.shape(s, &child(path, "shape"), &defaults));
        let shape_origin = m.shape.as_ref().map(|s| match &s.source {
            Some(source) => self.origin(Some(source), &format!("{path}.shape.source")),
            None => origin.clone(),
        });
        let (shape, shape_sd) = shape.unzip();
        let components = self.components(&m.components, path);
        let standing = self.standing(m, path);
        TestMode {
            label: m.label.clone(),
            frequency_hz: Measured {
                value: frequency,
                sd: frequency_sd.unwrap_or(DEFAULT_FREQUENCY_SD * frequency),
                sd_is_default: frequency_sd.is_none(),
            },
            damping_ratio,
            origin,
            shape,
            shape_sd,
            shape_origin,
            components,
            standing,
            space: m.space.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything counts modes by frequency, and a file that does not is told which is which.
    #[test]
    fn modes_in_another_order_are_told() {
        let text = |modes: &str| {
            format!(
                "retune_test: 1\nname: t\nsources: {{made: {{kind: synthetic, text: by hand}}}}\nmodes: [{modes}]\n"
            )
        };
        let mode = |hz: &str| format!("{{frequency: {hz} Hz, source: made}}");
        let told = |list: [&str; 4]| {
            let (_, warnings) = read_test(&text(&list.map(mode).join(", "))).unwrap_or_else(|p| panic!("{p:?}"));
            warnings.iter().find(|w| w.message.contains("counted")).map(|w| w.message.clone())
        };
        assert_eq!(told(["1", "2", "3", "4"]), None);
        let told = told(["1", "3.5", "3", "4"]).unwrap();
        assert!(told.ends_with("mode 2 is number 3 of the file, at 3.0000 Hz"), "{told}");
    }
    use crate::data::{Partner, Standing};

    const TEXT: &str = "
retune_test: 1
name: trial
sources:
  gvt: {kind: measured, text: 'by hand'}
  model: {kind: synthetic, text: 'computed'}
sensors:
  p1: {node: n1, direction: +z}
  p2: {element: wing.2, fraction: 0.25, position: [1 m, 20 cm, 0], direction: [0, 3, 4], mass: 5 g}
modes:
  - {label: S1B, frequency: 5.67 Hz, frequency_sd: 0.3 %, damping: 1.5 %, source: gvt, shape: {source: model, real: [1, -0.5], sd: 2 %}}
  - {frequency: 2, source: gvt, shape: {real: [null, 1], imaginary: [0, 0.1]}}
mass_properties:
  mass: {value: 5.4 kg, sd: 20 g, source: gvt}
";

    #[test]
    fn a_test_file_reads_with_units_and_origins() {
        let (data, warnings) = read_test(TEXT).unwrap();
        assert_eq!(data.sensors[1].direction, [0.0, 0.6, 0.8]);
        assert_eq!(data.modes[1].frequency_hz, Measured { value: 5.67, sd: 5.67 * 0.003, sd_is_default: false });
        assert_eq!(data.modes[1].shape_origin.as_ref().unwrap().word(), "synthetic");
        assert!(data.modes[0].shape.as_ref().unwrap()[0].re.is_nan());
        assert_eq!(data.mass_properties[0].measured.sd, 0.02);
        // Two about standard deviations, one about the order of the modes.
        assert_eq!(warnings.len(), 3, "{warnings:?}");
    }

    #[test]
    fn what_is_written_reads_back_equal() {
        let (data, _) = read_test(TEXT).unwrap();
        let (again, _) = read_test(&write_test(&data)).unwrap();
        assert_eq!(write_test(&again), write_test(&data));
        assert_eq!(format!("{:?}", again.modes[1]), format!("{:?}", data.modes[1]));
        assert_eq!(again.sensors, data.sensors);
    }

    #[test]
    fn a_shape_of_any_scale_has_squares() {
        let small = TEXT.replace("real: [1, -0.5], sd: 2 %", "real: [1e-200, -5e-201], sd: 2 %");
        let large = TEXT.replace("real: [1, -0.5], sd: 2 %", "real: [1e250, -5e249], sds: [2e248, 2e248]");
        for text in [small, large] {
            let mode = read_test(&text).unwrap().0.modes.swap_remove(1);
            let (shape, sd) = (mode.shape.unwrap(), mode.shape_sd.unwrap());
            assert!(shape[0].re >= 1.0 && shape[0].re < 2.0 && (shape[1].re / shape[0].re + 0.5).abs() < 1e-15);
            assert!((sd[0] / shape[0].re - 0.02).abs() < 1e-15);
        }
    }

    #[test]
    fn the_users_word_about_a_mode_reads_strictly_and_is_written_back() {
        let with = |keys: &str| TEXT.replace("  - {frequency: 2,", &format!("  - {{{keys}, frequency: 2,"));
        for (keys, standing) in [
            ("pair_with: 2nd Vertical Bending", Standing::With(Partner::Label("2nd Vertical Bending".into()))),
            ("pair_with: 3", Standing::With(Partner::Number(3))),
            ("pair_with: '3'", Standing::With(Partner::Label("3".into()))),
            ("use: false", Standing::Unused),
            ("use: true", Standing::Open),
            ("foreign: true", Standing::Foreign),
        ] {
            let (data, _) = read_test(&with(keys)).unwrap();
            assert_eq!(data.modes[0].standing, standing, "{keys}");
            let (again, _) = read_test(&write_test(&data)).unwrap();
            assert_eq!(again.modes[0].standing, standing, "{keys}, written");
        }
        let (data, _) = read_test(&with("space: bending")).unwrap();
        assert_eq!(data.modes[0].space.as_deref(), Some("bending"));
        assert_eq!(read_test(&write_test(&data)).unwrap().0.modes[0].space, data.modes[0].space);
        for (keys, text) in [
            ("pair_with: 0", "numbered from 1"),
            ("pair_with: -2", "numbered from 1"),
            ("pair_with: 1.5", "or its number from 1"),
            ("pair_with: ''", "is empty"),
            ("use: maybe", "bool"),
            ("foreign: true, pair_with: 3", "leave one of them out"),
            ("use: false, pair_with: 3", "leave one of them out"),
        ] {
            let problems = read_test(&with(keys)).unwrap_err();
            assert!(problems.iter().any(|p| p.message.contains(text)), "{keys}: {problems:?}");
            assert!(problems[0].location.is_some(), "{keys}");
        }
    }

    #[test]
    fn labels_tell_the_symmetry() {
        assert_eq!(family_of_label("Sym 1st Bending"), Some("symmetric"));
        assert_eq!(family_of_label("A2T"), Some("antisymmetric"));
        assert_eq!(family_of_label("Anti 1st Torsion"), Some("antisymmetric"));
        assert_eq!(family_of_label("1st bending, anti-symmetric"), Some("antisymmetric"));
        assert_eq!(family_of_label("2nd symmetric torsion"), Some("symmetric"));
        assert_eq!(family_of_label("Shell mode"), None);
    }

    /// Sizes beyond all sense are refused where they stand, whatever they are the standard deviation of.
    #[test]
    fn senseless_standard_deviations_are_refused() {
        for (from, to, path) in [
            ("frequency_sd: 0.3 %", "frequency_sd: 1e100 Hz", "modes[0].frequency_sd"),
            ("frequency_sd: 0.3 %", "frequency_sd: 1e80 Hz", "modes[0].frequency_sd"),
            ("frequency_sd: 0.3 %", "frequency_sd: 1e-100 Hz", "modes[0].frequency_sd"),
            ("frequency_sd: 0.3 %", "frequency_sd: 1e20 %", "modes[0].frequency_sd"),
            ("damping: 1.5 %", "damping: 1.5 %, damping_sd: 1e60", "modes[0].damping_sd"),
            ("sd: 2 %}", "sd: 1e30}", "modes[0].shape.sd"),
            ("sd: 2 %}", "sds: [0.02, 1e90]}", "modes[0].shape.sds"),
        ] {
            let text = TEXT.replacen(from, to, 1);
            assert!(text != TEXT, "{from}");
            let problems = read_test(&text).unwrap_err();
            assert!(
                problems.iter().any(|p| p.path == path && p.message.contains("a standard deviation of")),
                "{to}: {problems:?}"
            );
        }
    }

    #[test]
    fn corrections_name_sensors_and_say_one_thing() {
        let with = |line: &str| read_test(&format!("{TEXT}corrections:\n  - {line}\n"));
        let sensor = read_test(TEXT).unwrap().0.sensors[0].name.clone();
        assert_eq!(with(&format!("{{sensor: {sensor}, factor: -1}}")).unwrap().0.corrections.len(), 1);
        for (line, word) in [
            ("{sensor: nobody, factor: -1}".to_string(), "no sensor `nobody`"),
            (format!("{{sensor: {sensor}}}"), "says one of"),
            (format!("{{sensor: {sensor}, factor: 0}}"), "not zero"),
            (format!("{{sensor: {sensor}, factor: 2, reads_nothing: true}}"), "says one of"),
        ] {
            let problems = with(&line).unwrap_err();
            assert!(problems.iter().any(|p| p.message.contains(word)), "{line}: {problems:?}");
        }
    }
}
