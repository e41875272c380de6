//! A moment of inertia that the model lacks at a node.

use super::location::Location;
use super::patch::{Builder, Edit, Patch, PatchError, body_at, entry};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::ParametricModel;
use crate::model::spec::MassSpec;

#[doc = "A moment of inertia at a node that the model lacks: an extended body modelled as a point."]
#[derive(Debug, Clone, Copy)]
pub struct PointRotaryInertia;

impl Effect for PointRotaryInertia {
    fn name(&self) -> &'static str {
        "point-rotary-inertia"
    }

    fn about(&self) -> About {
        About {
            summary: "A moment of inertia at a node that the model lacks: an extended body modelled as a point.",
            signature: "Lowers modes that rotate the node about the axis, torsion first; modes that only translate it \
                    stay.",
            formulation: "M gains J r² for the rotation r about one global axis; J = 0 leaves it.",
            confusable: &["torsion-stiffness-change", "root-flexibility", "section-rotary-inertia", "mass-offset"],
            references: &[
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for dof in [Dof::Rx, Dof::Ry, Dof::Rz] {
            let turning = |n: usize| structure.model().dof_map().express(n, dof);
            // Nodes of one rigid body turn alike: the first stands for all.
            let first = |n: usize| (0..n).all(|other| turning(other) != turning(n));
            let nodes = structure.nodes(|n| structure.node_moves(n, dof) && first(n));
            all.extend(nodes.into_iter().map(|at| at.along(dof.name())));
        }
        if structure.total_mass() > 0.0 && structure.extent() > 0.0 { all } else { Vec::new() }
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        let axis = at.direction().trim_start_matches('r');
        // A fiftieth of the mass at a twentieth of the size.
        let typical = 0.02 * structure.total_mass() * (0.05 * structure.extent()).powi(2);
        let about = format!("moment of inertia about {axis} missing at {}", at.place());
        let j = b.parameter("inertia", "kg m2", typical, [0.0, 50.0 * typical], &about);
        let name = b.stem().to_string();
        let inertia = entry(&format!("{axis}{axis}"), &j);
        let entry = MassSpec { inertia, ..body_at(&at.names) };
        b.edit(Edit::AddMass { name, entry });
        Ok(b.finish())
    }
}
