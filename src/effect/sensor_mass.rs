//! The mass of the accelerometers.

use super::edit::{Edit, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{SensorLoad, Structure};
use super::{About, Belongs, Effect};
use crate::element::Dof;
use crate::model::spec::MassSpec;

#[doc = "The mass of the accelerometers and their cables, the same at every sensor, which the model lacks."]
#[derive(Debug, Clone, Copy)]
pub struct SensorMass;

impl Effect for SensorMass {
    fn name(&self) -> &'static str {
        "sensor-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "The mass of the accelerometers and their cables, the same at every sensor, which the model \
                    lacks.",
            signature: "Lowers modes in proportion to the sum of their squares at the sensors; light parts with many \
                    sensors most. A second test with dummy masses shows it.",
            formulation: "M gains m (ux² + uy² + uz²) at the place of every sensor, on the arm on which it stands, once for a \
                    triaxial one; m = 0 leaves it. It needs the sensors of the test.",
            confusable: &["point-mass", "distributed-mass"],
            references: &[
                "D. J. Ewins, Modal Testing: Theory, Practice and Application, 2000, section 3.3",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if carried(structure).is_empty() { Vec::new() } else { vec![Location::whole()] }
    }

    fn needs_sensors(&self) -> bool {
        true
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Rig
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let all = carried(structure);
        let n_sensors: f64 = all.iter().map(|load| load.share).sum();
        let mut b = Builder::new(self.name(), at);
        // Ten grams, unless that is more than a twentieth of the structure.
        let typical = 0.01f64.min(0.05 * structure.total_mass() / n_sensors.max(1.0));
        let m = b.parameter("mass", "kg", typical, [0.0, 10.0 * typical], "mass of each sensor with its cable");
        let stem = b.stem().to_string();
        // One entry for all that stand on their node, and for each share and arm.
        let mut entries: Vec<(&SensorLoad, Vec<String>)> = Vec::new();
        for load in all {
            match entries.iter_mut().find(|(known, _)| (known.share, known.arm) == (load.share, load.arm)) {
                Some((_, nodes)) => nodes.push(load.node.clone()),
                None => entries.push((load, vec![load.node.clone()])),
            }
        }
        for (k, (load, nodes)) in entries.into_iter().enumerate() {
            let mass = if load.share < 1.0 { format!("{:?}*{m}", load.share) } else { m.clone() };
            let offset = load.arm.iter().any(|a| *a != 0.0).then(|| load.arm.map(|a| scalar(&format!("{a:?} m"))));
            let entry = MassSpec { nodes: Some(nodes), mass: Some(scalar(&mass)), offset, ..MassSpec::default() };
            // An entry of several nodes has `.2` for its second.
            let name = if k == 0 { stem.clone() } else { format!("{stem}_{}", k + 1) };
            b.edit(Edit::AddMass { name, entry });
        }
        Ok(b.finish())
    }
}

/// Sensors on nodes that move, in the order of the nodes.
fn carried<'a>(structure: &'a Structure<'_>) -> Vec<&'a SensorLoad> {
    let moves = |n: usize| Dof::ALL.into_iter().any(|d| structure.node_moves(n, d));
    let mut all: Vec<(usize, &SensorLoad)> = structure
        .context()
        .sensors
        .iter()
        .filter_map(|load| Some((structure.model().geometry().node(&load.node)?, load)))
        .filter(|&(n, _)| n < structure.n_nodes() && moves(n))
        .collect();
    all.sort_by_key(|&(n, _)| n);
    all.into_iter().map(|(_, load)| load).collect()
}
