//! A bending stiffness that is locally wrong.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::torsion_stiffness_change::rigidity;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "A member, or an element of it, whose bending stiffness in one plane differs from the model's, while its torsion is right."]
#[derive(Debug, Clone, Copy)]
pub struct BendingStiffnessChange;

impl Effect for BendingStiffnessChange {
    fn name(&self) -> &'static str {
        "bending-stiffness-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A member, or an element of it, whose bending stiffness in one plane differs from the model's, \
                    while its torsion is right.",
            signature: "Shifts bending modes of that plane that curve the place; torsion modes stay.",
            formulation: "EIy (or EIz) of the elements is multiplied by 1 + p, through `Iy` or `EIy` as the file gives \
                    it; p = 0 leaves it.",
            confusable: &["stiffness-change", "joint-flexibility", "root-flexibility", "taper"],
            references: &[
                "O. S. Salawu, Detection of structural damage through changes in frequency: a review, Engineering Structures 19, 1997",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for dof in [Dof::Ry, Dof::Rz] {
            let places = structure.places(|p| {
                p.is_straight()
                    && p.elements.iter().all(|&e| structure.is_beam(e))
                    && structure.part_strains(p, dof)
                    && rigidity(structure, p, dof).is_some()
            });
            all.extend(places.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
        let property = rigidity(structure, parts[0], dof).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("bending stiffness of {} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, [-0.99, 2.0], &about);
        b.change(
            "",
            &entries(&parts),
            OverrideSpec { scale: entry(property, &format!("1 + {p}")), ..OverrideSpec::default() },
        );
        Ok(b.finish())
    }
}
