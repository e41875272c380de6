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

#[cfg(test)]
mod tests {
    use crate::data::{read_test, write_test};

    const TEXT: &str = "
retune_test: 1
name: components
sources: {deck: {kind: measured, text: by hand}}
sensors: {root: {node: a, direction: +z}, tip: {node: b, direction: +z}}
modes:
  - {frequency: 2 Hz, frequency_sd: 1 %, source: deck, components: [{sensor: tip, value: -0.4, sd: 5 %}, {sensor: tip, relative_to: root, value: 3, sd: 0.1}]}
";

    #[test]
    fn components_read_and_write_back() {
        let (data, _) = read_test(TEXT).unwrap();
        let [one, other] = data.modes[0].components.as_slice() else { panic!("{data:?}") };
        assert_eq!((one.sensor, one.relative_to, one.measured.value), (1, None, -0.4));
        assert!((one.measured.sd - 0.02).abs() < 1e-15);
        assert_eq!((other.sensor, other.relative_to), (1, Some(0)));
        assert_eq!(read_test(&write_test(&data)).unwrap().0.modes, data.modes);
        for (from, to, message) in [
            ("sensor: tip, value", "sensor: tap, value", "no sensor `tap`; did you mean `tip`?"),
            ("relative_to: root", "relative_to: tip", "a component relative to itself is one"),
            ("value: 3", "value: .inf", "it must be a finite number"),
            ("sd: 0.1", "sd: 0", "above zero"),
        ] {
            let problems = read_test(&TEXT.replacen(from, to, 1)).unwrap_err();
            assert!(problems.iter().any(|p| p.message.contains(message)), "{message}: {problems:?}");
        }
    }
}
