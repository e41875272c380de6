//! The mass of the transducers, put into the model.

use super::CorrelationError;
use super::observe::{locate, sensor_position};
use crate::data::{Place, Sensor};
use crate::model::spec::{MassSpec, ModelSpec};
use crate::model::{Model, ParametricModel};
use crate::units::Scalar;

/// The model file with the masses of the sensors added, and their sum, kg.
///
/// ```text
/// on a node       the whole mass, at the sensor's own position by a rigid arm
/// on an element   (1 - s) of it at the first node and s at the second: total mass and first moment are exact, the rotary
///                 inertia of the element grows by at most m L²/4 more than the sensor's own
/// ```
/// Sensors at one place (a triaxial transducer read as three) are one mass, the largest that they state. The names of the
/// new entries begin with `sensor `. Without such masses in the model, frequencies of the model are compared with those of a
/// heavier structure: relative shift -½ m φ² for a mass-normalised shape φ.
///
/// # Errors
/// A sensor names a node or element that the model does not have.
pub fn with_sensor_masses(model: &Model, sensors: &[Sensor]) -> Result<(ModelSpec, f64), CorrelationError> {
    let mut spec = model.spec().clone();
    let scalar = |value: f64, unit: &str| {
        Scalar::parse(&format!("{value:?} {unit}")).unwrap_or_else(|_| Scalar::constant(value))
    };
    let weighed: Vec<&Sensor> = sensors.iter().filter(|s| s.mass.is_some_and(|m| m > 0.0)).collect();
    let mut total = 0.0;
    for t in transducers(model, weighed)? {
        let mass = t.mass.unwrap_or(0.0);
        total += mass;
        for (k, (node, share)) in t.shares.into_iter().enumerate() {
            let mut name = format!("sensor {}", t.name);
            if k > 0 {
                name += " (second node)";
            }
            let entry = MassSpec {
                node: Some(node),
                mass: Some(scalar(share * mass, "kg")),
                offset: t.arm.iter().any(|a| a.abs() > 0.0).then(|| t.arm.map(|a| scalar(a, "m"))),
                ..MassSpec::default()
            };
            spec.masses.insert(name, entry);
        }
    }
    Ok((spec, total))
}

/// What stands at one place of the structure, however many directions it reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Transducer {
    /// Name of its first sensor.
    pub name: String,
    /// The largest mass that its sensors state, kg.
    pub mass: Option<f64>,
    /// The nodes that carry it, and their shares.
    pub shares: Vec<(String, f64)>,
    /// From the structure to the transducer, m.
    pub arm: [f64; 3],
}

/// The places where sensors stand: coordinates of one transducer, written three times, are one. One inside an element is carried by its
/// nodes as [`with_sensor_masses`] says.
///
/// # Errors
/// A sensor names a node or element that the model does not have.
pub fn transducers<'a>(
    model: &Model,
    sensors: impl IntoIterator<Item = &'a Sensor>,
) -> Result<Vec<Transducer>, CorrelationError> {
    let names = &model.geometry().names;
    let mut found: Vec<([f64; 3], Transducer)> = Vec::new();
    for sensor in sensors {
        let at = sensor_position(model, sensor)?;
        // A tenth of a millimetre.
        let is_same = |p: &[f64; 3]| (0..3).map(|k| (p[k] - at[k]).powi(2)).sum::<f64>() < 1e-8;
        if let Some((_, known)) = found.iter_mut().find(|(p, _)| is_same(p)) {
            known.mass = known.mass.into_iter().chain(sensor.mass).reduce(f64::max);
            continue;
        }
        let (point, _) = locate(model, sensor, None)?;
        let shares = match &sensor.place {
            Place::Node { node, .. } => vec![(node.clone(), 1.0)],
            Place::Element { element, position: Some(place), .. }
                if matches!(model.point_near(element, *place), Ok(Some(_))) =>
            {
                // On a surface or a volume: at the node of the part that is nearest.
                let nodes = model.element_set(element).into_iter().flatten().flat_map(|&e| &model.elements()[e].nodes);
                let distance = |n: &usize| {
                    let p = model.geometry().positions[*n];
                    (0..3).map(|k| (p[k] - place[k]).powi(2)).sum::<f64>()
                };
                let nearest = nodes.copied().min_by(|a, b| distance(a).total_cmp(&distance(b)));
                nearest.map(|n| vec![(names[n].clone(), 1.0)]).unwrap_or_default()
            }
            Place::Element { element, fraction, .. } => {
                let ends = model.element_set(element).and_then(|set| {
                    let first = model.elements()[*set.first()?].nodes.first()?;
                    let last = model.elements()[*set.last()?].nodes.last()?;
                    Some((names[*first].clone(), names[*last].clone()))
                });
                ends.map_or_else(Vec::new, |(a, b)| vec![(a, 1.0 - fraction), (b, *fraction)])
            }
        };
        let transducer = Transducer {
            name: sensor.name.clone(),
            mass: sensor.mass,
            shares: shares.into_iter().filter(|(_, share)| *share > 0.0).collect(),
            // Differences of coordinates, to a nanometre.
            arm: std::array::from_fn(|k| (1e9 * (at[k] - point.position[k])).round() / 1e9),
        };
        found.push((at, transducer));
    }
    Ok(found.into_iter().map(|(_, t)| t).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ParametricModel, Registry, load};

    const TEXT: &str = "
retune: 1
name: strip
active_dofs: [uz, ry]
nodes: {a: [0, 0, 0], b: [1 m, 0, 0], c: [2 m, 0, 0]}
beams: {span: {chain: [a, b, c], properties: {EIy: 100 N m2, mass_per_length: 0.5 kg/m}}}
supports: {clamp: {node: a}}
";

    fn sensor(name: &str, place: Place, offset: Option<[f64; 3]>, mass: f64) -> Sensor {
        Sensor {
            name: name.to_string(),
            place,
            offset,
            direction: [0.0, 0.0, 1.0],
            is_rotation: false,
            mass: Some(mass),
        }
    }

    #[test]
    fn masses_come_once_at_their_places() {
        let (model, _, _) = load(TEXT, &Registry::builtin()).unwrap();
        let node = |n: &str| Place::Node { node: n.to_string(), position: None };
        let sensors = [
            sensor("tip x", node("c"), None, 0.01),
            sensor("tip z", node("c"), None, 0.02),
            sensor("arm", node("b"), Some([0.1, 0.0, 0.0]), 0.03),
            sensor(
                "quarter",
                Place::Element { element: "span.2".to_string(), fraction: 0.25, position: None },
                None,
                0.04,
            ),
        ];
        let (spec, total) = with_sensor_masses(&model, &sensors).unwrap();
        assert!((total - 0.09).abs() < 1e-15, "{total}");
        let (loaded, problems) = Model::new(spec, &Registry::builtin()).unwrap();
        assert!(problems.is_empty(), "{problems:?}");
        let theta = loaded.parameters().nominal();
        let (before, after) = (
            model.mass_properties(&model.parameters().nominal()).unwrap().unwrap(),
            loaded.mass_properties(&theta).unwrap().unwrap(),
        );
        assert!((after.mass - before.mass - 0.09).abs() < 1e-12);
        // First moment about x = 0: 0.02 · 2 + 0.03 · 1.1 + 0.04 · 1.25.
        let moment = after.mass * after.cg[0] - before.mass * before.cg[0];
        assert!((moment - 0.123).abs() < 1e-12, "{moment}");
        let unknown = sensor("x", node("q"), None, 0.01);
        assert!(with_sensor_masses(&model, &[unknown]).is_err());
    }
}
