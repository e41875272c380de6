//! Sections: sets of element properties, and cross-sections that give them.

use super::{Named, ShapeSpec};
use crate::units::Scalar;
use schemars::JsonSchema;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A set of element properties: those of `retune explain beam` (or of any other element), or a `shape` that gives them.
pub type SectionSpec = Named<SectionValue>;

/// A property of a section: a scalar, or under the key `shape` a cross-section.
#[derive(Debug, Clone, PartialEq)]
pub enum SectionValue {
    /// The value of a property.
    Scalar(Scalar),
    /// A cross-section that gives `A`, `Iy`, `Iz`, `J`, the rigidities of a laminate, and where its axes are.
    Shape(ShapeSpec),
}

impl Serialize for SectionValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            SectionValue::Scalar(s) => s.serialize(serializer),
            SectionValue::Shape(s) => s.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for SectionValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SectionVisitor;
        impl<'de> Visitor<'de> for SectionVisitor {
            type Value = SectionValue;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, a number with a unit such as `56 GPa`, parameters with factors, or a shape such as `{rectangle: {width: 20 mm, height: 5 mm}}`")
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<SectionValue, E> {
                if value.is_finite() {
                    Ok(SectionValue::Scalar(Scalar::constant(value)))
                } else {
                    Err(E::custom(format!("{value} is not a finite number")))
                }
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<SectionValue, E> {
                self.visit_f64(value as f64)
            }
            fn visit_u64<E: de::Error>(self, value: u64) -> Result<SectionValue, E> {
                self.visit_f64(value as f64)
            }
            fn visit_str<E: de::Error>(self, value: &str) -> Result<SectionValue, E> {
                Scalar::parse(value).map(SectionValue::Scalar).map_err(E::custom)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SectionValue, A::Error> {
                ShapeSpec::deserialize(de::value::MapAccessDeserializer::new(map)).map(SectionValue::Shape)
            }
        }
        deserializer.deserialize_any(SectionVisitor)
    }
}

impl JsonSchema for SectionValue {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SectionValue".into()
    }
    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let scalar = generator.subschema_for::<Scalar>();
        let shape = generator.subschema_for::<ShapeSpec>();
        schemars::json_schema!({"anyOf": [scalar, shape]})
    }
}
