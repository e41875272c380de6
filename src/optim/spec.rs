//! The list of methods, and the choice of one in YAML.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{
    About, Auto, CmaEs, DifferentialEvolution, LevenbergMarquardt, Multistart, NelderMead, OptimError, Optimizer,
    Optimum, Run, Sequence, auto, cma_es, differential_evolution, levenberg_marquardt, multistart, nelder_mead,
    sequence,
};
use crate::catalogue::did_you_mean;
use crate::linalg::DVector;

/// Declares the methods: a variant with settings for each, and the list that everything else iterates.
macro_rules! choice {
    ($($variant:ident = $module:ident),+ $(,)?) => {
        /// A method and its settings, as written in YAML.
        ///
        /// ```text
        /// optimizer: nelder-mead                                  # a name: default settings
        /// optimizer: {nelder-mead: {size: 0.02}}                  # a name with settings
        /// optimizer: [differential-evolution, nelder-mead]        # one after another
        /// ```
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub enum OptimizerSpec {
            $(
                #[doc = concat!("See [`", stringify!($variant), "`].")]
                $variant($variant),
            )+
            /// See [`Sequence`].
            Sequence(Sequence),
            /// See [`Own`].
            Own(Own),
        }

        /// Every method, in the order of the reference pages.
        pub const OPTIMIZERS: &[About] = &[$($module::ABOUT,)+ sequence::ABOUT];

        /// The names that may be written in YAML; a sequence is written as a list.
        const NAMES: &[&str] = &[$($module::ABOUT.name),+];

        impl OptimizerSpec {
            /// The method of that name, or of that abbreviation, with default settings.
            pub fn by_name(name: &str) -> Option<Self> {
                let name = full_name(name);
                $(if name == $module::ABOUT.name { return Some(Self::$variant($variant::default())); })+
                None
            }

            /// The method.
            pub fn as_dyn(&self) -> &dyn Optimizer {
                match self {
                    $(Self::$variant(method) => method,)+
                    Self::Sequence(sequence) => sequence,
                    Self::Own(own) => own.0,
                }
            }

            fn with_settings<'de, A: MapAccess<'de>>(name: &str, map: &mut A) -> Result<Option<Self>, A::Error> {
                let name = full_name(name);
                $(if name == $module::ABOUT.name { return map.next_value().map(Self::$variant).map(Some); })+
                Ok(None)
            }

            fn named_schemas(generator: &mut SchemaGenerator) -> Vec<Schema> {
                let mut all = Vec::new();
                $(for name in spellings($module::ABOUT.name) {
                    let settings = generator.subschema_for::<$variant>();
                    all.push(json_schema!({
                        "type": "object",
                        "description": $module::ABOUT.summary,
                        "properties": { (name): settings },
                        "required": [name],
                        "additionalProperties": false,
                    }));
                })+
                all
            }
        }

        impl Serialize for OptimizerSpec {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                match self {
                    $(Self::$variant(settings) => {
                        let mut map = serializer.serialize_map(Some(1))?;
                        map.serialize_entry($module::ABOUT.name, settings)?;
                        map.end()
                    })+
                    Self::Sequence(sequence) => {
                        let mut list = serializer.serialize_seq(Some(sequence.steps.len()))?;
                        for step in &sequence.steps {
                            list.serialize_element(step)?;
                        }
                        list.end()
                    }
                    Self::Own(own) => serializer.serialize_str(own.0.name()),
                }
            }
        }
    };
}

/// A method of a user's own, which no file can name. It is equal to itself alone.
#[derive(Debug, Clone, Copy)]
pub struct Own(pub &'static dyn Optimizer);

impl PartialEq for Own {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(self.0, other.0) && self.0.name() == other.0.name()
    }
}

/// Abbreviations that the field uses, and what they stand for.
pub const ABBREVIATIONS: &[(&str, &str)] =
    &[("lm", "levenberg-marquardt"), ("de", "differential-evolution"), ("nm", "nelder-mead")];

/// The name of a method, whether it is given in full or abbreviated.
pub fn full_name(name: &str) -> &str {
    ABBREVIATIONS.iter().find(|(short, _)| *short == name).map_or(name, |(_, full)| full)
}

/// A name and its abbreviations.
fn spellings(name: &'static str) -> impl Iterator<Item = &'static str> {
    let short = ABBREVIATIONS.iter().filter(move |(_, full)| *full == name).map(|(short, _)| *short);
    std::iter::once(name).chain(short)
}

/// JSON Schema of an optimiser and its settings, as `optimizer:` and `--optimizer` take them.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(OptimizerSpec).to_value()
}

choice! {
    Auto = auto,
    DifferentialEvolution = differential_evolution,
    NelderMead = nelder_mead,
    LevenbergMarquardt = levenberg_marquardt,
    CmaEs = cma_es,
    Multistart = multistart,
}

impl Default for OptimizerSpec {
    fn default() -> Self {
        Self::Auto(Auto::default())
    }
}

impl Optimizer for OptimizerSpec {
    fn name(&self) -> &'static str {
        self.as_dyn().name()
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        self.as_dyn().minimize(start, run)
    }
}

impl<'de> Deserialize<'de> for OptimizerSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SpecVisitor)
    }
}

struct SpecVisitor;

impl SpecVisitor {
    fn unknown<E: de::Error>(name: &str) -> E {
        let expected = NAMES.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
        let hint = did_you_mean(name, NAMES.iter().copied());
        E::custom(format_args!("unknown optimizer `{name}`, expected one of {expected}{hint}"))
    }
}

impl<'de> Visitor<'de> for SpecVisitor {
    type Value = OptimizerSpec;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "the name of an optimizer, a name with settings such as {nelder-mead: {size: 0.02}}, or a list of these",
        )
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<Self::Value, E> {
        OptimizerSpec::by_name(name).ok_or_else(|| Self::unknown(name))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let Some(name) = map.next_key::<String>()? else {
            return Err(de::Error::custom("an optimizer without a name, expected for example {nelder-mead: {}}"));
        };
        let spec = OptimizerSpec::with_settings(&name, &mut map)?.ok_or_else(|| Self::unknown(&name))?;
        match map.next_key::<String>()? {
            None => Ok(spec),
            Some(other) => Err(de::Error::custom(format_args!(
                "`{other}` beside `{name}`: one optimizer at a time; write [{name}, {other}] for one after another"
            ))),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut steps = Vec::new();
        while let Some(step) = list.next_element()? {
            steps.push(step);
        }
        if steps.is_empty() {
            return Err(de::Error::custom("an empty list of optimizers, expected at least one"));
        }
        Ok(OptimizerSpec::Sequence(Sequence { steps }))
    }
}

impl JsonSchema for OptimizerSpec {
    fn schema_name() -> Cow<'static, str> {
        "OptimizerSpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = NAMES.iter().copied().flat_map(spellings).collect();
        let mut forms = vec![json_schema!({ "type": "string", "enum": names })];
        forms.extend(Self::named_schemas(generator));
        let step = generator.subschema_for::<Self>();
        forms.push(
            json_schema!({ "type": "array", "items": step, "minItems": 1, "description": sequence::ABOUT.summary }),
        );
        json_schema!({ "anyOf": forms, "description": "How the cost is minimised." })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(yaml: &str) -> Result<OptimizerSpec, String> {
        serde_yaml::from_str(yaml).map_err(|e| e.to_string())
    }

    #[test]
    fn a_name_settings_and_a_list_are_read() {
        assert_eq!(read("nelder-mead"), Ok(OptimizerSpec::NelderMead(NelderMead::default())));
        assert_eq!(
            read("{nelder-mead: {size: 0.02}}"),
            Ok(OptimizerSpec::NelderMead(NelderMead { size: 0.02, ..Default::default() }))
        );
        let Ok(OptimizerSpec::Sequence(sequence)) =
            read("- differential-evolution: {strategy: classic, population: 200}\n- nelder-mead\n")
        else {
            panic!("not a sequence");
        };
        assert_eq!(sequence.steps.len(), 2);
        assert!(read("{multistart: {local: [levenberg-marquardt, nelder-mead]}}").is_ok());
    }

    #[test]
    fn abbreviations_are_read_as_their_methods() {
        for (short, full) in ABBREVIATIONS {
            let method = OptimizerSpec::by_name(full);
            assert!(method.is_some() && OptimizerSpec::by_name(short) == method, "{short}");
        }
        assert_eq!(
            read("[de, {nm: {size: 0.02}}]"),
            read("[differential-evolution, {nelder-mead: {size: 0.02}}]"),
            "a name with settings and a list take abbreviations too"
        );
        assert!(read("[de, {nm: {size: 0.02}}]").is_ok());
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (yaml, message) in [
            ("a: 1\nb: 2", "unknown optimizer `a`, expected one of"),
            ("nelder-maed", "did you mean `nelder-mead`?"),
            (
                "nelder-mead: {sise: 1}",
                "nelder-mead: unknown field `sise`, expected one of `size`, `tolerance`, `restarts` at line 1 column 15",
            ),
            ("{nelder-mead: {}, cma-es: {}}", "write [nelder-mead, cma-es] for one after another"),
            ("[]", "an empty list of optimizers"),
            ("7", "the name of an optimizer, a name with settings"),
        ] {
            let error = read(yaml).expect_err(yaml);
            assert!(error.contains(message), "{yaml}: {error}");
        }
    }

    #[test]
    fn every_method_survives_a_round_trip_and_has_a_schema() {
        for about in OPTIMIZERS.iter().filter(|a| a.name != sequence::ABOUT.name) {
            let spec = OptimizerSpec::by_name(about.name).expect(about.name);
            assert_eq!(spec.as_dyn().name(), about.name);
            let yaml = serde_yaml::to_string(&spec).expect("plain data");
            assert_eq!(read(&yaml), Ok(spec), "{yaml}");
        }
        let schema = serde_json::to_string(&schemars::schema_for!(OptimizerSpec)).expect("plain data");
        assert!(schema.contains("differential_weight") && schema.contains("nelder-mead"), "{schema}");
    }
}
