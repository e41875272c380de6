//! A joint between members that gives.

use super::edit::PatchError;
use super::end_flexibility::flexible_end;
use super::location::Location;
use super::patch::Patch;
use super::structure::{Joint, Structure};
use super::{About, Effect};
use crate::element::Dof;

#[doc = "A joint between members, or between a member and the body at its end, that the model has as rigid and that turns."]
#[derive(Debug, Clone, Copy)]
pub struct JointFlexibility;

impl Effect for JointFlexibility {
    fn name(&self) -> &'static str {
        "joint-flexibility"
    }

    fn about(&self) -> About {
        About {
            summary: "A joint between members, or between a member and the body at its end, that the model has as \
                    rigid and that turns.",
            signature: "Lowers modes with a large moment at the joint; shapes show a jump of slope (or twist) there.",
            formulation: "The end of one member is joined to the node by a rotational spring of compliance c about one of \
                    its axes, condensed exactly; c = 0 leaves it. Where two members meet, the joint is at the end \
                    of the first; where more meet, at each. Also both ends of a member alike, `brace:a+brace:b.ry`: a \
                    brace that is bolted where the model welds it. Of a member that stands askew also about an axis of the \
                    structure, `fin.3:top.about_x`, by `end2_hinge_compliance` with that axis in the member's own.",
            confusable: &[
                "bending-stiffness-change",
                "torsion-stiffness-change",
                "stiffness-change",
                "link-flexibility",
            ],
            references: &[
                "H. Ahmadian, J. E. Mottershead, M. I. Friswell, Joint modelling for finite element model updating, IMAC XIV, 1996",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = structure.end_places(Joint::Member, &[Dof::Rx, Dof::Ry, Dof::Rz]);
        // Twist gives alike at either end: both together are as one.
        let bending = [Dof::Ry, Dof::Rz];
        all.extend(structure.both_ends(Joint::Member, &bending));
        all.extend(structure.connections(&bending, &all));
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        flexible_end(self.name(), structure, at, |_| 0.0)
    }
}
