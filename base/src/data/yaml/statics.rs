//! Static tests and frequency responses in test files.

use super::{DirectionSpec, Reader};
use crate::catalogue::did_you_mean;
use crate::data::convert::{Duplicates, FrfOptions, LocalAxes, UnitsFrom, ratio_unit};
use crate::data::{
    FrfFit, FrfQuantity, Measured, MeasurementOptions, Place, Roles, StaticLoad, StaticReading, StaticTest,
};
use crate::units::{FrequencyUnit, GRAVITY, Scalar};
use crate::yaml::{Problem, child};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Standard deviation of a static reading whose file gives none, relative.
pub const DEFAULT_STATIC_SD: f64 = 0.02;
/// Standard deviation of a value of a frequency response function whose file gives none, relative.
pub const DEFAULT_FRF_SD: f64 = 0.05;

/// A static test.
///
/// ```yaml
/// static_tests:
///   bending:
///     source: bench
///     loads: [{sensor: tip, weight: 500 g}]
///     readings: {tip: {value: -35.2 mm, sd: 0.3 mm}, tip_twist: {value: 0.1 deg, sd: 0.05 deg}}
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticTestSpec {
    /// The source of the readings; the only one of the file when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The loads, all at once.
    pub loads: Vec<StaticLoadSpec>,
    /// By name of a sensor: how its reading changed under the loads.
    pub readings: IndexMap<String, StaticReadingSpec>,
}

/// A load: a weight, a force or a moment at the place of a sensor or on a node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticLoadSpec {
    /// It acts at the place of this sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
    /// It acts on this node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// A mass that hangs there: its weight pulls along -z, or along `direction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight: Option<Scalar>,
    /// A force along `direction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Scalar>,
    /// A moment about `direction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment: Option<Scalar>,
    /// Direction of the load; that of the sensor for a force or moment at one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<DirectionSpec>,
}

/// A reading: a deflection, or the angle of a sensor with `rotation: true`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticReadingSpec {
    /// Its change under the loads.
    pub value: Scalar,
    /// Its standard deviation, absolute or `2 %`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<Scalar>,
}

/// Frequency response functions of the test, and how a fit uses them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrfSpec {
    /// Files of the functions, relative to this file.
    pub files: Vec<String>,
    /// Unit of the functions of a table or an array that states none: `m/s2/N`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Units of universal files, whatever they say: `SI`, `mm-N-s`, `in-lbf-s`, ..., or `labels` to believe the labels of their axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<String>,
    /// What the functions are, where their file does not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<FrfQuantity>,
    /// Which of several functions of one pair of points counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duplicates: Option<Duplicates>,
    /// Unit of the frequencies, whatever the files say: `Hz`, `kHz`, `rad/s`, `deg/s`, `rpm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_unit: Option<String>,
    /// Whether the `rows` or the `columns` of local axes (dataset 2420) are axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub local_axes: Option<LocalAxes>,
    /// What variables of files of arrays are, where their names do not say it: `frequency=x,functions=H`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variables: Option<String>,
    /// Only lines in these bands: `[[4 Hz, 7 Hz], [15 Hz, 22 Hz]]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<[Scalar; 2]>,
    /// Standard deviation of a value, relative to it: `5 %`, which is assumed when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<Scalar>,
    /// Loss factor of the whole structure beside the model's own damping, twice the damping ratio at resonance. When absent: zero for a
    /// model with damping, else twice the median of the measured damping ratios.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss_factor: Option<Scalar>,
}

impl Reader<'_> {
    /// Index of a sensor, or a problem.
    pub(super) fn sensor_index(&mut self, name: &str, path: &str) -> Option<usize> {
        let found = self.spec.sensors.get_index_of(name);
        if found.is_none() {
            let suggestion = did_you_mean(name, self.spec.sensors.keys().map(String::as_str));
            self.error(path, format_args!("the test has no sensor `{name}`{suggestion}"));
        }
        found
    }

    pub(super) fn static_test(&mut self, name: &str, t: &StaticTestSpec) -> StaticTest {
        let path = child("static_tests", name);
        if t.loads.is_empty() {
            self.error(child(&path, "loads"), "a static test has at least one load");
        }
        if t.readings.is_empty() {
            self.error(child(&path, "readings"), "a static test has at least one reading");
        }
        let loads = t.loads.iter().enumerate();
        let loads = loads.filter_map(|(i, l)| self.static_load(l, &format!("{path}.loads[{i}]"))).collect();
        let mut readings = Vec::new();
        for (sensor, r) in &t.readings {
            let path = child(&child(&path, "readings"), sensor);
            let Some(index) = self.sensor_index(sensor, &path) else { continue };
            let unit = if self.spec.sensors[index].rotation { "1" } else { "m" };
            let value = self.number(&r.value, unit, &child(&path, "value"));
            let sd = r.sd.as_ref().map(|s| self.sd(s, unit, value, &child(&path, "sd")));
            if sd.is_none() {
                let text = format!("no standard deviation is given; {} % is assumed", 100.0 * DEFAULT_STATIC_SD);
                self.problems.push(Problem::warning(path.clone(), text));
                if value == 0.0 {
                    self.error(&path, "a reading of zero needs a standard deviation");
                }
            }
            let measured =
                Measured { value, sd: sd.unwrap_or(DEFAULT_STATIC_SD * value.abs()), sd_is_default: sd.is_none() };
            readings.push(StaticReading { sensor: index, measured });
        }
        let origin = self.origin(t.source.as_deref(), &child(&path, "source"));
        StaticTest { name: name.to_string(), loads, readings, origin }
    }

    fn static_load(&mut self, l: &StaticLoadSpec, path: &str) -> Option<StaticLoad> {
        let at = match (&l.sensor, &l.node) {
            (Some(sensor), None) => {
                let index = self.sensor_index(sensor, &child(path, "sensor"))?;
                let spec = self.spec.sensors[index].clone();
                // Its own problems are told where it is defined.
                let told = self.problems.len();
                let own = self.sensor(sensor, &spec);
                self.problems.truncate(told);
                Some((own.place, own.offset, own.is_rotation, Some(own.direction)))
            }
            (None, Some(node)) => Some((Place::Node { node: node.clone(), position: None }, None, false, None)),
            _ => {
                self.error(path, "give exactly one of `sensor` and `node`");
                None
            }
        };
        let (place, offset, at_rotation, of_sensor) = at?;
        let own = l.direction.map(|d| d.0);
        let down = [0.0, 0.0, -1.0];
        let (value, is_moment, direction) = match (&l.weight, &l.force, &l.moment) {
            (Some(w), None, None) => {
                (GRAVITY * self.number(w, "kg", &child(path, "weight")), false, Some(own.unwrap_or(down)))
            }
            (None, Some(f), None) => {
                (self.number(f, "N", &child(path, "force")), false, own.or(of_sensor.filter(|_| !at_rotation)))
            }
            (None, None, Some(m)) => {
                (self.number(m, "N m", &child(path, "moment")), true, own.or(of_sensor.filter(|_| at_rotation)))
            }
            _ => {
                self.error(path, "give exactly one of `weight`, `force` and `moment`");
                return None;
            }
        };
        let Some(direction) = direction else {
            let what = if is_moment { "moment" } else { "force" };
            self.error(path, format_args!("the {what} needs a `direction`"));
            return None;
        };
        Some(StaticLoad { place, offset, direction, is_moment, value })
    }

    pub(super) fn frf_fit(&mut self, f: &FrfSpec) -> FrfFit {
        if f.files.is_empty() {
            self.error("frfs.files", "name at least one file");
        }
        let mut bands_hz = Vec::with_capacity(f.bands.len());
        for (i, band) in f.bands.iter().enumerate() {
            let path = format!("frfs.bands[{i}]");
            let [low, high] = [0, 1].map(|k| self.number(&band[k], "Hz", &format!("{path}[{k}]")));
            if !(low >= 0.0 && low < high) {
                self.error(path, format_args!("{low} Hz to {high} Hz is not a band: give two ascending frequencies"));
            }
            bands_hz.push([low, high]);
        }
        if f.sd.is_none() {
            let text = format!("no standard deviation is given; {} % of each value is assumed", 100.0 * DEFAULT_FRF_SD);
            self.problems.push(Problem::warning("frfs", text));
        }
        let relative_sd = f.sd.as_ref().map_or(DEFAULT_FRF_SD, |s| self.sd(s, "1", 1.0, "frfs.sd"));
        let loss_factor = f.loss_factor.as_ref().map(|s| self.number(s, "1", "frfs.loss_factor"));
        if let Some(loss_factor) = loss_factor.filter(|value| !(0.0..1.0).contains(value)) {
            self.error("frfs.loss_factor", format_args!("{loss_factor} is not between 0 and 1"));
        }
        if let Some(unit) = f.unit.as_deref().filter(|unit| ratio_unit(unit).is_none()) {
            self.error(
                "frfs.unit",
                format_args!("`{unit}` is not a unit of response over force, such as `m/s2/N` or `g/N`"),
            );
        }
        let units = f.units.as_deref().map_or(Ok(UnitsFrom::default()), UnitsFrom::from_name);
        let units = units.unwrap_or_else(|reason| {
            self.error("frfs.units", reason);
            UnitsFrom::default()
        });
        let frequency_unit = f.frequency_unit.as_deref().and_then(|text| {
            let unit = FrequencyUnit::of_label(text);
            if unit.is_none() {
                let names = FrequencyUnit::NAMES.join(", ");
                self.error(
                    "frfs.frequency_unit",
                    format_args!("`{text}` is not a unit of frequencies, such as {names}"),
                );
            }
            unit
        });
        let frf = FrfOptions {
            units,
            quantity: f.quantity,
            duplicates: f.duplicates.unwrap_or_default(),
            frequency_unit,
            local_axes: f.local_axes,
        };
        let variables = f.variables.as_deref().map_or(Ok(Roles::default()), Roles::parse).unwrap_or_else(|reason| {
            self.error("frfs.variables", reason);
            Roles::default()
        });
        let reading = MeasurementOptions { frf, unit: f.unit.clone(), variables, ..MeasurementOptions::default() };
        FrfFit {
            files: f.files.clone(),
            reading,
            bands_hz,
            lines_hz: None,
            relative_sd,
            loss_factor,
            damping_error: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::data::{read_test, write_test};

    const TEXT: &str = "
retune_test: 1
name: bench
sources: {bench: {kind: measured, text: by hand}}
sensors:
  tip: {node: b, direction: +z}
  twist: {node: b, direction: +x, rotation: true}
static_tests:
  bending:
    source: bench
    loads: [{sensor: tip, weight: 500 g}, {node: b, force: 2 N, direction: [0, 0, 2]}]
    readings: {tip: {value: -35.2 mm, sd: 0.3 mm}}
  torsion:
    source: bench
    loads: [{sensor: twist, moment: 1 N m}]
    readings: {twist: {value: 2 deg}}
";

    #[test]
    fn static_tests_read_with_units_and_write_back() {
        let (data, warnings) = read_test(TEXT).unwrap();
        let [bending, torsion] = data.static_tests.as_slice() else { panic!("{data:?}") };
        assert!((bending.loads[0].value - 4.903_325).abs() < 1e-12);
        assert_eq!(bending.loads[0].direction, [0.0, 0.0, -1.0]);
        assert_eq!(bending.loads[1].direction, [0.0, 0.0, 1.0]);
        assert!((bending.readings[0].measured.value + 0.0352).abs() < 1e-15);
        assert!(torsion.loads[0].is_moment && torsion.loads[0].direction == [1.0, 0.0, 0.0]);
        assert!((torsion.readings[0].measured.value - 2f64.to_radians()).abs() < 1e-15);
        assert_eq!(warnings.len(), 1);
        let (again, _) = read_test(&write_test(&data)).unwrap();
        assert_eq!(again.static_tests, data.static_tests);
    }

    #[test]
    fn mistakes_are_found_where_they_stand() {
        for (from, to, line, text) in [
            ("sensor: tip, weight", "sensor: tipp, weight", 11, "did you mean `tip`?"),
            ("weight: 500 g}", "weight: 500 mm}", 11, "kg"),
            ("{tip: {value", "{top: {value", 12, "no sensor `top`"),
            ("-35.2 mm", "-35.2 deg", 12, "m"),
            ("moment: 1 N m", "force: 1 N", 15, "needs a `direction`"),
            ("node: b, force: 2 N,", "node: b,", 11, "exactly one of `weight`"),
        ] {
            let problems = read_test(&TEXT.replace(from, to)).unwrap_err();
            let found =
                problems.iter().find(|p| p.message.contains(text)).unwrap_or_else(|| panic!("{to}: {problems:?}"));
            assert_eq!(found.location.map(|l| l.line), Some(line), "{to}: {problems:?}");
        }
    }
}
