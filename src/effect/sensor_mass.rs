//! The mass of the accelerometers.

use super::location::Location;
use super::patch::{Builder, Edit, Patch, PatchError, scalar};
use super::structure::Structure;
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
            formulation: "M gains m (ux² + uy² + uz²) at the node of every sensor; m = 0 leaves it. It needs the sensors \
                    of the test.",
            confusable: &["point-mass", "distributed-mass"],
            references: &[
                "D. J. Ewins, Modal Testing: Theory, Practice and Application, 2000, section 3.3",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if sensors(structure).is_empty() { Vec::new() } else { vec![Location::whole()] }
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Rig
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let nodes = sensors(structure);
        let mut b = Builder::new(self.name(), at);
        // Ten grams, unless that is more than a twentieth of the structure.
        let typical = 0.01f64.min(0.05 * structure.total_mass() / nodes.len().max(1) as f64);
        let m = b.parameter("mass", "kg", typical, [0.0, 10.0 * typical], "mass of each sensor with its cable");
        let name = b.stem().to_string();
        let entry = MassSpec { nodes: Some(nodes), mass: Some(scalar(&m)), ..MassSpec::default() };
        b.edit(Edit::AddMass { name, entry });
        Ok(b.finish())
    }
}

/// Nodes of sensors that move, one for each sensor, in the order of the nodes.
fn sensors(structure: &Structure<'_>) -> Vec<String> {
    let moves = |n: usize| [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().any(|d| structure.node_moves(n, d));
    let mut nodes: Vec<usize> = structure
        .context()
        .sensor_nodes
        .iter()
        .filter_map(|name| structure.model().geometry().node(name))
        .filter(|&n| n < structure.n_nodes() && moves(n))
        .collect();
    nodes.sort_unstable();
    nodes.into_iter().map(|n| structure.node_name(n).to_string()).collect()
}
