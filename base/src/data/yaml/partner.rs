//! `pair_with`: the mode of the model that a user names.

use super::{ModeSpec, Reader};
use crate::data::{Partner, Standing};
use crate::yaml::child;
use schemars::JsonSchema;
use serde::de::{self, Deserializer, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A mode of the model: its name, or its number from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartnerSpec(pub Partner);

impl Serialize for PartnerSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Partner::Number(n) => n.serialize(serializer),
            Partner::Label(label) => label.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for PartnerSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PartnerVisitor;
        impl Visitor<'_> for PartnerVisitor {
            type Value = PartnerSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a mode of the model such as `2nd Vertical Bending`, or its number from 1")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<PartnerSpec, E> {
                if text.trim().is_empty() {
                    return Err(E::custom(
                        "the name of a mode is empty; leave `pair_with` out if the partner is not known",
                    ));
                }
                Ok(PartnerSpec(Partner::Label(text.trim().to_string())))
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> Result<PartnerSpec, E> {
                match usize::try_from(number) {
                    Ok(n) if n > 0 => Ok(PartnerSpec(Partner::Number(n))),
                    _ => Err(E::custom("the modes of the model are numbered from 1")),
                }
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<PartnerSpec, E> {
                u64::try_from(number)
                    .map_err(|_| E::custom("the modes of the model are numbered from 1"))
                    .and_then(|n| self.visit_u64(n))
            }
        }
        deserializer.deserialize_any(PartnerVisitor)
    }
}

impl JsonSchema for PartnerSpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PartnerSpec".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "The name of a mode of the model, or its number from 1",
            "anyOf": [{"type": "string", "minLength": 1}, {"type": "integer", "minimum": 1}]
        })
    }
}

impl Reader<'_> {
    /// What the user says of the mode.
    pub(super) fn standing(&mut self, m: &ModeSpec, path: &str) -> Standing {
        if m.pair_with.is_some() && (!m.is_used || m.foreign) {
            let other = if m.foreign { "`foreign: true`" } else { "`use: false`" };
            self.error(
                child(path, "pair_with"),
                format_args!("the mode has a partner here and none by {other}; leave one of them out"),
            );
        }
        match &m.pair_with {
            _ if m.foreign => Standing::Foreign,
            _ if !m.is_used => Standing::Unused,
            Some(PartnerSpec(partner)) => Standing::With(partner.clone()),
            None => Standing::Open,
        }
    }
}
