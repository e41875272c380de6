//! Shapes at the sensors.

use super::{DEFAULT_SHAPE_SD, DefaultsSpec, Reader, doubts};
use crate::catalogue::{counted, did_you_mean};
use crate::data::test::usable_scale;
use crate::units::Scalar;
use crate::yaml::child;
use indexmap::IndexMap;
use retune_linalg::{Complex, DVector};
use schemars::JsonSchema;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A measured shape.
///
/// ```yaml
/// shape: {real: [0.1, 0.4, null, 1.0]}          # in the order of the sensors
/// shape: {real: {root: 0.1, mid: 0.4, tip: 1.0}, sd: 2 %}
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeSpec {
    /// The source of the shape; that of the mode when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Values in any scale: a list in the order of the sensors, `.nan` or `null` where a sensor did not measure, or `{tip: 0.42}` by sensors.
    pub real: EntriesSpec,
    /// Imaginary parts of a complex shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imaginary: Option<EntriesSpec>,
    /// Standard deviation of each entry: `2 %` of the largest entry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<Scalar>,
    /// Standard deviations entry by entry, in the scale of the shape, instead of `sd`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sds: Option<EntriesSpec>,
}

/// A number for every sensor: `[0.1, null, 1.0]` in their order, or `{root: 0.1, tip: 1.0}` by their names.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum EntriesSpec {
    /// In the order of the sensors; none where a sensor did not measure.
    InOrder(Vec<Option<f64>>),
    /// By sensors; those that are not named did not measure.
    BySensor(IndexMap<String, Option<f64>>),
}

impl<'de> Deserialize<'de> for EntriesSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct EntriesVisitor;
        impl<'de> Visitor<'de> for EntriesVisitor {
            type Value = EntriesSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("numbers in the order of the sensors, `[0.1, null, 1.0]`, or by sensors, `{tip: 1.0}`")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<EntriesSpec, A::Error> {
                Deserialize::deserialize(de::value::SeqAccessDeserializer::new(seq)).map(EntriesSpec::InOrder)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<EntriesSpec, A::Error> {
                Deserialize::deserialize(de::value::MapAccessDeserializer::new(map)).map(EntriesSpec::BySensor)
            }
        }
        deserializer.deserialize_any(EntriesVisitor)
    }
}

impl Reader<'_> {
    /// One number per sensor, NaN where there is none.
    fn entries(&mut self, entries: &EntriesSpec, path: &str) -> Option<Vec<f64>> {
        let sensors = &self.spec.sensors;
        let n = sensors.len();
        match entries {
            EntriesSpec::InOrder(list) if list.len() != n => {
                self.error(
                    path,
                    format_args!(
                        "{} for {}; `.nan` stands where a sensor did not measure",
                        counted(list.len(), "value"),
                        counted(n, "sensor")
                    ),
                );
                None
            }
            EntriesSpec::InOrder(list) => Some(list.iter().map(|v| v.unwrap_or(f64::NAN)).collect()),
            EntriesSpec::BySensor(map) => {
                let unknown: Vec<&String> = map.keys().filter(|name| !sensors.contains_key(*name)).collect();
                for name in &unknown {
                    let suggestion = did_you_mean(name, sensors.keys().map(String::as_str));
                    self.error(child(path, name), format_args!("there is no sensor `{name}`{suggestion}"));
                }
                let of = |name: &String| map.get(name).copied().flatten().unwrap_or(f64::NAN);
                unknown.is_empty().then(|| sensors.keys().map(of).collect())
            }
        }
    }

    /// The shape with its standard deviations.
    pub(super) fn shape(
        &mut self,
        s: &ShapeSpec,
        path: &str,
        defaults: &DefaultsSpec,
    ) -> Option<(DVector<Complex<f64>>, DVector<f64>)> {
        let real = self.entries(&s.real, &child(path, "real"))?;
        let imaginary = match &s.imaginary {
            Some(imaginary) => Some(self.entries(imaginary, &child(path, "imaginary"))?),
            None => None,
        };
        let sds = match &s.sds {
            Some(sds) => Some(self.entries(sds, &child(path, "sds"))?),
            None => None,
        };
        let n = real.len();
        let mut shape = DVector::from_fn(n, |i, _| Complex::new(real[i], imaginary.as_ref().map_or(0.0, |im| im[i])));
        if shape.iter().any(|v| v.re.is_infinite() || v.im.is_infinite()) {
            self.error(child(path, "real"), "a value is infinite");
        }
        let largest = shape.iter().filter(|v| !v.re.is_nan()).map(|v| v.norm()).fold(0.0, f64::max);
        if largest == 0.0 {
            let measured = shape.iter().any(|v| !v.re.is_nan());
            let why = if measured {
                "the shape is zero at every sensor"
            } else {
                "no sensor measured this shape; leave it out"
            };
            self.error(child(path, "real"), why);
            return None;
        }
        let assumed = DEFAULT_SHAPE_SD * largest;
        let mut sd = match (sds, &s.sd, &defaults.shape_sd) {
            (Some(mut list), None, _) => {
                // Where nothing was measured nothing is asked.
                for (sd, _) in list.iter_mut().zip(&real).filter(|(sd, v)| sd.is_nan() && v.is_nan()) {
                    *sd = assumed;
                }
                if list.iter().any(|v| !(*v > 0.0 && v.is_finite())) {
                    self.error(child(path, "sds"), "standard deviations must be above zero");
                } else if let Some(sd) = list.iter().find(|sd| !doubts::is_sensible_sd(**sd, largest)) {
                    self.error(child(path, "sds"), doubts::senseless_sd(*sd, "1", largest));
                }
                DVector::from_vec(list)
            }
            (Some(_), Some(_), _) => {
                self.error(path, "give `sd` or `sds`, not both");
                return None;
            }
            (None, Some(sd), _) => DVector::from_element(n, self.sd(sd, "1", largest, &child(path, "sd"))),
            (None, None, Some(sd)) => DVector::from_element(n, self.sd(sd, "1", largest, "defaults.shape_sd")),
            (None, None, None) => DVector::from_element(n, assumed),
        };
        usable_scale(&mut shape, &mut sd);
        Some((shape, sd))
    }
}

#[cfg(test)]
mod tests {
    use crate::data::{TestData, read_test};

    fn read(modes: &str) -> Result<TestData, Vec<String>> {
        let text = format!(
            "retune_test: 1\nname: t\nsources: {{gvt: {{kind: measured, text: by hand}}}}\n\
             sensors: {{root: {{node: a, direction: +z}}, tip: {{node: b, direction: +z}}}}\nmodes:\n  - {modes}\n"
        );
        read_test(&text).map(|r| r.0).map_err(|p| p.iter().map(|p| format!("{} {}", p.path, p.message)).collect())
    }

    /// By sensors in any order, and with the only source.
    #[test]
    fn a_shape_may_name_its_sensors() {
        let by_name =
            read("{label: B1, frequency: 2 Hz, shape: {real: {tip: 1.0, root: 0.5}, sds: {root: 0.1, tip: 0.2}}}");
        let in_order = read("{label: B1, frequency: 2 Hz, source: gvt, shape: {real: [0.5, 1.0], sds: [0.1, 0.2]}}");
        assert_eq!(by_name.unwrap().modes, in_order.unwrap().modes);
        let part = read("{frequency: 2 Hz, shape: {real: {tip: 1.0}, sds: {tip: 0.2}}}").unwrap();
        let shape = part.modes[0].shape.as_ref().unwrap();
        assert!(shape[0].re.is_nan() && (shape[1].re - 1.0).abs() < 1e-15);
        let error = read("{frequency: 2 Hz, shape: {real: {top: 1.0}}}").unwrap_err();
        assert_eq!(error[..1], ["modes[0].shape.real.top there is no sensor `top`; did you mean `tip`?"]);
    }
}
