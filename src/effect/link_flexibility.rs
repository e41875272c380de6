//! A link that the model has as rigid and that gives.

use super::edit::PatchError;
use super::end_flexibility::flexible_end;
use super::location::Location;
use super::patch::Patch;
use super::structure::{Joint, Structure};
use super::{About, Effect};
use crate::element::Dof;

#[doc = "A rigid link, or the attachment of a member to it, that gives in one direction."]
#[derive(Debug, Clone, Copy)]
pub struct LinkFlexibility;

impl Effect for LinkFlexibility {
    fn name(&self) -> &'static str {
        "link-flexibility"
    }

    fn about(&self) -> About {
        About {
            summary: "A rigid link, or the attachment of a member to it, that gives in one direction.",
            signature: "Relative motion across the link: the member's root turns or moves against the body, in modes \
                    that load it.",
            formulation: "The end of the member at the link is joined to it by a spring of compliance c along or about \
                    one of the member's axes, condensed exactly; c = 0 leaves it. The flexibility of a link that \
                    carries a mass alone is `sprung-mass`.",
            confusable: &[
                "root-flexibility",
                "joint-flexibility",
                "bending-stiffness-change",
                "torsion-stiffness-change",
            ],
            references: &[
                "H. Ahmadian, J. E. Mottershead, M. I. Friswell, Joint modelling for finite element model updating, IMAC XIV, 1996",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.end_places(Joint::Link, &Dof::ALL)
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        flexible_end(self.name(), structure, at, |_| 0.0)
    }
}
