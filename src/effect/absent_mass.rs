//! A mass of the file that is lighter than stated, or not there.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "A mass of the file that is lighter than stated, or not there: equipment that was taken out, a tank that was empty."]
#[derive(Debug, Clone, Copy)]
pub struct AbsentMass;

impl Effect for AbsentMass {
    fn name(&self) -> &'static str {
        "absent-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass of the file that is lighter than stated, or not there: equipment that was taken out, a tank that \
                    was empty.",
            signature: "Raises the modes that move the body, in proportion to the square of their shape there; where it has inertia, \
                    the modes that turn it too.",
            formulation: "The mass matrix of the body is multiplied by 1 - p, 0 <= p <= 1; p = 0 leaves it. More mass is a point-mass or an \
                    eccentric-mass; a mass that one configuration alone brings is the matter of mass-change.",
            confusable: &["mass-change", "point-mass", "stiffness-change"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
                "J. A. Brandon, Strategies for Structural Dynamic Modification, 1990",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| {
            let is_of_file = p.kind == PartKind::Mass && !structure.context().is_own_mass(&p.name);
            is_of_file && p.elements.iter().any(|&e| structure.is_heavy(e))
        })
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("share of {} that is not there", at.place());
        let p = b.parameter("loss", "1", 0.1, [0.0, 1.0], &about);
        let left = Some(scalar(&format!("1 - {p}")));
        b.change("", &entries(&parts), OverrideSpec { mass: left, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
