//! A support that gives.

use super::end_flexibility::flexible_end;
use super::location::Location;
use super::patch::{Patch, PatchError};
use super::structure::{Joint, Structure};
use super::{About, Belongs, Effect};
use crate::element::Dof;

#[doc = "A clamp, bearing or root that the model has as rigid and that gives in one direction."]
#[derive(Debug, Clone, Copy)]
pub struct RootFlexibility;

impl Effect for RootFlexibility {
    fn name(&self) -> &'static str {
        "root-flexibility"
    }

    fn about(&self) -> About {
        About {
            summary: "A clamp, bearing or root that the model has as rigid and that gives in one direction.",
            signature: "Lowers all modes that load the support, the lowest most; shapes show a slope or a displacement \
                    at the root that the model lacks.",
            formulation: "The member's end is joined to the support by a spring of compliance c, condensed exactly: K' = \
                    K - c K e eᵀ K/(1 + c eᵀ K e), by `end1_compliance_ry` and so on in the member's axes; c = 0 \
                    leaves it, c of several L/EI is a hinge.",
            confusable: &[
                "stiffness-change",
                "bending-stiffness-change",
                "torsion-stiffness-change",
                "point-rotary-inertia",
            ],
            references: &[
                "K. R. Chun, Free vibration of a beam with one end spring-hinged and the other free, J. Applied Mechanics 39, 1972",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.end_places(Joint::Root, &Dof::ALL)
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Support
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        flexible_end(self.name(), structure, at)
    }
}
