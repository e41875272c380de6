//! A stiffness that is locally wrong.

use super::location::Location;
use super::patch::{Builder, Patch, PatchError, scalar};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "A part of the structure that is softer or stiffer than the model has it: damage, a splice, a doubler, a wrong modulus."]
#[derive(Debug, Clone, Copy)]
pub struct StiffnessChange;

impl Effect for StiffnessChange {
    fn name(&self) -> &'static str {
        "stiffness-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A part of the structure that is softer or stiffer than the model has it: damage, a splice, a \
                    doubler, a wrong modulus.",
            signature: "Shifts modes that strain the part, up or down together; curvature of the shapes changes there.",
            formulation: "The stiffness matrix of the elements is multiplied by 1 + p; p = 0 leaves it, p = -1 would \
                    remove it.",
            confusable: &[
                "bending-stiffness-change",
                "torsion-stiffness-change",
                "joint-flexibility",
                "taper",
                "softening",
            ],
            references: &[
                "O. S. Salawu, Detection of structural damage through changes in frequency: a review, Engineering Structures 19, 1997",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| p.kind != PartKind::Mass && p.elements.iter().any(|&e| structure.deforms(e)))
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("stiffness of {} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, [-0.99, 2.0], &about);
        b.change(
            "",
            &entries(&parts),
            OverrideSpec { stiffness: Some(scalar(&format!("1 + {p}"))), ..OverrideSpec::default() },
        );
        Ok(b.finish())
    }
}
