//! Measured mass properties.

use super::{DEFAULT_MASS_SD, Reader};
use crate::catalogue::did_you_mean;
use crate::data::test::{MassProperty, MassQuantity, Measured};
use crate::units::Scalar;
use crate::yaml::child;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A measured mass property.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassPropertySpec {
    /// Its value.
    pub value: Scalar,
    /// Its standard deviation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<Scalar>,
    /// Its source; the only one of the file when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// The mass properties that a file may name: word, quantity, unit.
const MASS_WORDS: [(&str, MassQuantity, &str); 10] = [
    ("mass", MassQuantity::Mass, "kg"),
    ("cg_x", MassQuantity::Cg(0), "m"),
    ("cg_y", MassQuantity::Cg(1), "m"),
    ("cg_z", MassQuantity::Cg(2), "m"),
    ("inertia_xx", MassQuantity::Inertia(0, 0), "kg m2"),
    ("inertia_yy", MassQuantity::Inertia(1, 1), "kg m2"),
    ("inertia_zz", MassQuantity::Inertia(2, 2), "kg m2"),
    ("inertia_xy", MassQuantity::Inertia(0, 1), "kg m2"),
    ("inertia_xz", MassQuantity::Inertia(0, 2), "kg m2"),
    ("inertia_yz", MassQuantity::Inertia(1, 2), "kg m2"),
];

impl MassQuantity {
    /// The word in files and tables: `mass`, `cg_x`, `inertia_yy`, ...
    pub fn word(self) -> &'static str {
        MASS_WORDS.iter().find(|w| w.1 == self).map_or("inertia", |w| w.0)
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        MASS_WORDS.iter().find(|w| w.1 == self).map_or("kg m2", |w| w.2)
    }
}

impl Reader<'_> {
    pub(super) fn mass_property(&mut self, name: &str, p: &MassPropertySpec) -> Option<MassProperty> {
        let path = child("mass_properties", name);
        let Some(&(_, quantity, unit)) = MASS_WORDS.iter().find(|w| w.0 == name) else {
            let suggestion = did_you_mean(name, MASS_WORDS.iter().map(|w| w.0));
            self.error(path, format_args!("`{name}` is not a mass property{suggestion}"));
            return None;
        };
        let value = self.number(&p.value, unit, &child(&path, "value"));
        let sd = p.sd.as_ref().map(|s| self.sd(s, unit, value, &child(&path, "sd")));
        let default =
            if matches!(quantity, MassQuantity::Cg(_)) { DEFAULT_MASS_SD } else { DEFAULT_MASS_SD * value.abs() };
        let origin = self.origin(p.source.as_deref(), &child(&path, "source"));
        Some(MassProperty {
            quantity,
            measured: Measured { value, sd: sd.unwrap_or(default), sd_is_default: sd.is_none() },
            origin,
        })
    }
}
