//! A mass that the model lacks at a node.

use super::edit::{Edit, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch, body_at};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::MassSpec;

#[doc = "A mass at a node that the model lacks: equipment, ballast, a fitting."]
#[derive(Debug, Clone, Copy)]
pub struct PointMass;

impl Effect for PointMass {
    fn name(&self) -> &'static str {
        "point-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass at a node that the model lacks: equipment, ballast, a fitting.",
            signature: "Lowers every mode in proportion to the square of its motion there, and leaves modes with a node \
                    there alone; rigid-body inertia grows.",
            formulation: "M gains m (ux² + uy² + uz²) at the node; m = 0 leaves it. A small m changes ω by -ω m |φ|²/2.",
            confusable: &["distributed-mass", "sensor-mass", "sprung-mass", "point-rotary-inertia"],
            references: &[
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.total_mass() <= 0.0 {
            return Vec::new();
        }
        structure.nodes(|n| [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().any(|d| structure.node_moves(n, d)))
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        let total = structure.total_mass();
        let about = format!("mass missing at {}", at.place());
        let m = b.parameter("mass", "kg", 0.02 * total, [0.0, 0.5 * total], &about);
        let name = b.stem().to_string();
        let entry = MassSpec { mass: Some(scalar(&m)), ..body_at(&at.names) };
        b.edit(Edit::AddMass { name, entry });
        Ok(b.finish())
    }
}
