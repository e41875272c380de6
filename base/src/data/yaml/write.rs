//! Writing test files.

use super::statics::{FrfSpec, StaticLoadSpec, StaticReadingSpec, StaticTestSpec};
use super::{
    DirectionSpec, EntriesSpec, FORMAT, MassPropertySpec, ModeSpec, PartnerSpec, SensorSpec, ShapeSpec, SourceKind,
    SourceSpec, TestSpec,
};
use crate::data::convert::Duplicates;
use crate::data::{Origin, Place, Sensor, Standing, StaticLoad, StaticReading, TestData};
use crate::units::Scalar;
use crate::yaml;
use indexmap::IndexMap;
use retune_linalg::Complex;

/// Writes a test file.
pub fn write_test(data: &TestData) -> String {
    let mut sources: IndexMap<String, SourceSpec> = IndexMap::new();
    let mut source = |origin: &Origin| -> String {
        let (kind, text) = match origin {
            Origin::Measured(t) => (SourceKind::Measured, t),
            Origin::Synthetic(t) => (SourceKind::Synthetic, t),
        };
        if let Some((name, _)) = sources.iter().find(|(_, s)| s.kind == kind && s.text == *text) {
            return name.clone();
        }
        let count = sources.values().filter(|s| s.kind == kind).count();
        let name = if count == 0 { origin.word().to_string() } else { format!("{}_{}", origin.word(), count + 1) };
        sources.insert(name.clone(), SourceSpec { kind, text: text.clone() });
        name
    };
    let si = |value: f64, unit: &str| {
        let text = format!("{value:?} {unit}");
        Scalar::parse(&text).unwrap_or_else(|_| Scalar::constant(value))
    };
    let modes: Vec<ModeSpec> = data
        .modes
        .iter()
        .map(|m| {
            let shape = m.shape.as_ref().map(|shape| {
                let part = |f: fn(&Complex<f64>) -> f64| {
                    EntriesSpec::InOrder(shape.iter().map(|v| Some(f(v)).filter(|x| !x.is_nan())).collect())
                };
                ShapeSpec {
                    source: m.shape_origin.as_ref().filter(|o| **o != m.origin).map(&mut source),
                    real: part(|v| v.re),
                    imaginary: shape.iter().any(|v| v.im != 0.0 && !v.im.is_nan()).then(|| part(|v| v.im)),
                    sd: None,
                    sds: m.shape_sd.as_ref().map(|sd| EntriesSpec::InOrder(sd.iter().copied().map(Some).collect())),
                }
            });
            ModeSpec {
                label: m.label.clone(),
                frequency: si(m.frequency_hz.value, "Hz"),
                frequency_sd: (!m.frequency_hz.sd_is_default).then(|| si(m.frequency_hz.sd, "Hz")),
                damping: m.damping_ratio.map(|d| Scalar::constant(d.value)),
                damping_sd: m.damping_ratio.filter(|d| !d.sd_is_default).map(|d| Scalar::constant(d.sd)),
                source: Some(source(&m.origin)),
                shape,
                components: m.components.iter().map(|c| super::components::written(c, &data.sensors)).collect(),
                pair_with: match &m.standing {
                    Standing::With(partner) => Some(PartnerSpec(partner.clone())),
                    _ => None,
                },
                is_used: m.standing != Standing::Unused,
                foreign: m.standing == Standing::Foreign,
                space: m.space.clone(),
            }
        })
        .collect();
    let mass_properties = data
        .mass_properties
        .iter()
        .map(|p| {
            let unit = p.quantity.unit();
            let spec = MassPropertySpec {
                value: si(p.measured.value, unit),
                sd: (!p.measured.sd_is_default).then(|| si(p.measured.sd, unit)),
                source: Some(source(&p.origin)),
            };
            (p.quantity.word().to_string(), spec)
        })
        .collect();
    let static_tests = data
        .static_tests
        .iter()
        .map(|t| {
            let reading = |r: &StaticReading| {
                let sensor = &data.sensors[r.sensor];
                let unit = if sensor.is_rotation { "rad" } else { "m" };
                let sd = (!r.measured.sd_is_default).then(|| si(r.measured.sd, unit));
                (sensor.name.clone(), StaticReadingSpec { value: si(r.measured.value, unit), sd })
            };
            let spec = StaticTestSpec {
                source: Some(source(&t.origin)),
                loads: t.loads.iter().map(|l| load(l, &data.sensors, &si)).collect(),
                readings: t.readings.iter().map(reading).collect(),
            };
            (t.name.clone(), spec)
        })
        .collect();
    let frfs = data.frf_fit.as_ref().map(|f| FrfSpec {
        files: f.files.clone(),
        unit: f.reading.unit.clone(),
        units: f.reading.frf.units.name().map(str::to_string),
        quantity: f.reading.frf.quantity,
        duplicates: Some(f.reading.frf.duplicates).filter(|d| *d != Duplicates::Ask),
        frequency_unit: f.reading.frf.frequency_unit.as_ref().map(|u| u.name.clone()),
        local_axes: f.reading.frf.local_axes,
        variables: Some(f.reading.variables.text().to_string()).filter(|t| !t.is_empty()),
        bands: f.bands_hz.iter().map(|b| b.map(|v| si(v, "Hz"))).collect(),
        sd: Some(Scalar::constant(f.relative_sd)),
        loss_factor: f.loss_factor.map(Scalar::constant),
    });
    let sensors = data
        .sensors
        .iter()
        .map(|s| {
            let (node, element, fraction, position) = match &s.place {
                Place::Node { node, position } => (Some(node.clone()), None, None, position),
                Place::Element { element, fraction, position } => {
                    (None, Some(element.clone()), Some(Scalar::constant(*fraction)), position)
                }
            };
            let spec = SensorSpec {
                node,
                element,
                fraction,
                position: position.map(|p| p.map(Scalar::constant)),
                offset: s.offset.map(|p| p.map(Scalar::constant)),
                direction: DirectionSpec(s.direction),
                rotation: s.is_rotation,
                mass: s.mass.map(|m| si(m, "kg")),
            };
            (s.name.clone(), spec)
        })
        .collect();
    yaml::write(&TestSpec {
        retune_test: FORMAT,
        name: data.name.clone(),
        description: data.description.clone(),
        date: data.date,
        configuration: data.configuration.clone(),
        sources,
        sensors,
        defaults: None,
        modes,
        static_tests,
        frfs,
        corrections: data.corrections.clone(),
        mass_properties,
    })
}

/// A load at the sensor that stands in its place, else on its node.
fn load(l: &StaticLoad, sensors: &[Sensor], si: &dyn Fn(f64, &str) -> Scalar) -> StaticLoadSpec {
    let sensor = sensors.iter().find(|s| s.place == l.place && s.offset == l.offset).map(|s| s.name.clone());
    let node = match &l.place {
        Place::Node { node, .. } if sensor.is_none() => Some(node.clone()),
        _ => None,
    };
    StaticLoadSpec {
        sensor,
        node,
        weight: None,
        force: (!l.is_moment).then(|| si(l.value, "N")),
        moment: l.is_moment.then(|| si(l.value, "N m")),
        direction: Some(DirectionSpec(l.direction)),
    }
}
