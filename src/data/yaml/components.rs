//! Components of mode shapes whose scale is known.

use super::Reader;
use crate::data::test::{Measured, Sensor, ShapeComponent};
use crate::units::Scalar;
use crate::yaml::child;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One component of a mode shape whose scale is known.
///
/// ```yaml
/// modes:
///   - frequency: 5.67 Hz
///     source: gvt
///     components:
///       - {sensor: tip, value: 0.42, sd: 0.02}                     # of the shape of unit modal mass
///       - {sensor: tip, relative_to: root, value: 3.1, sd: 0.1}    # of the shape that is one at `root`
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeComponentSpec {
    /// The sensor.
    pub sensor: String,
    /// The sensor at which the shape is one. When absent the shape has unit modal mass, φᵀ M φ = 1 kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_to: Option<String>,
    /// Its value in SI, up to the sign of the whole shape: 1/√kg for a displacement, 1/(m √kg) for a rotation.
    pub value: f64,
    /// Its standard deviation.
    pub sd: Scalar,
}

impl Reader<'_> {
    pub(super) fn components(&mut self, specs: &[ShapeComponentSpec], path: &str) -> Vec<ShapeComponent> {
        let mut out = Vec::new();
        for (i, c) in specs.iter().enumerate() {
            let path = format!("{}[{i}]", child(path, "components"));
            let Some(sensor) = self.sensor_index(&c.sensor, &child(&path, "sensor")) else { continue };
            let relative_to = match &c.relative_to {
                None => None,
                Some(name) => match self.sensor_index(name, &child(&path, "relative_to")) {
                    None => continue,
                    Some(k) if k == sensor => {
                        self.error(child(&path, "relative_to"), "a component relative to itself is one, always");
                        continue;
                    }
                    found => found,
                },
            };
            if !c.value.is_finite() {
                self.error(child(&path, "value"), "it must be a finite number");
            }
            let sd = self.sd(&c.sd, "1", c.value, &child(&path, "sd"));
            out.push(ShapeComponent {
                sensor,
                relative_to,
                measured: Measured { value: c.value, sd, sd_is_default: false },
            });
        }
        out
    }
}

/// As a file has it.
pub(super) fn written(c: &ShapeComponent, sensors: &[Sensor]) -> ShapeComponentSpec {
    ShapeComponentSpec {
        sensor: sensors[c.sensor].name.clone(),
        relative_to: c.relative_to.map(|k| sensors[k].name.clone()),
        value: c.measured.value,
        sd: Scalar::constant(c.measured.sd),
    }
}
