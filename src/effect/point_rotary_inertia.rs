//! A moment of inertia that the model lacks at a node.

use super::edit::{Edit, PatchError};
use super::location::Location;
use super::patch::{Builder, Patch, body_at, entry};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::ParametricModel;
use crate::model::spec::{MassSpec, Named};

/// About which axes a body can turn.
const TURNS: [Dof; 3] = [Dof::Rx, Dof::Ry, Dof::Rz];

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
            formulation: "M gains J r² for the rotation r about one global axis, or about each that the node can turn about, each with \
                    its own J; J = 0 leaves it.",
            confusable: &["torsion-stiffness-change", "root-flexibility", "section-rotary-inertia", "mass-offset"],
            references: &[
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.total_mass() > 0.0 && structure.extent() > 0.0 {
            structure.nodes_along(&TURNS, |n, dof| turns_first(structure, n, dof))
        } else {
            Vec::new()
        }
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        // A fiftieth of the mass at a twentieth of the size.
        let typical = 0.02 * structure.total_mass() * (0.05 * structure.extent()).powi(2);
        let mut inertia = Named::new();
        let axes = structure.axes_at(at, &TURNS, |n, dof| turns_first(structure, n, dof));
        for dof in &axes {
            let axis = dof.name().trim_start_matches('r');
            let about = format!("moment of inertia about {axis} missing at {}", at.place());
            let quantity = if axes.len() > 1 { format!("inertia_{axis}{axis}") } else { "inertia".to_string() };
            let j = b.parameter(&quantity, "kg m2", typical, [0.0, 50.0 * typical], &about);
            inertia.extend(entry(&format!("{axis}{axis}"), &j));
        }
        let name = b.stem().to_string();
        let entry = MassSpec { inertia, ..body_at(&at.names) };
        b.edit(Edit::AddMass { name, entry });
        Ok(b.finish())
    }
}

/// Whether a node turns about an axis, and no node before it alike: nodes of one rigid body do, and the first stands for all.
fn turns_first(structure: &Structure<'_>, node: usize, dof: Dof) -> bool {
    let turning = |n: usize| structure.model().dof_map().express(n, dof);
    structure.node_moves(node, dof) && (0..node).all(|other| turning(other) != turning(node))
}
