//! A torsional stiffness that is locally wrong.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Part, Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// Largest change: a closed section twists a hundred times less than the same walls with a slot.
const CLOSED: f64 = 100.0;

#[doc = "A member, or an element of it, whose torsional stiffness differs from the model's, while its bending is right: an open section, a missing bond."]
#[derive(Debug, Clone, Copy)]
pub struct TorsionStiffnessChange;

impl Effect for TorsionStiffnessChange {
    fn name(&self) -> &'static str {
        "torsion-stiffness-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A member, or an element of it, whose torsional stiffness differs from the model's, while its \
                    bending is right: an open section, a missing bond.",
            signature: "Shifts torsion modes that twist the place; bending modes stay, except through sweep or offset.",
            formulation: "GJ of the elements is multiplied by 1 + p, through `J` or `GJ` as the file gives it; p = 0 \
                    leaves it.",
            confusable: &["stiffness-change", "point-rotary-inertia", "root-flexibility", "joint-flexibility"],
            references: &[
                "O. S. Salawu, Detection of structural damage through changes in frequency: a review, Engineering Structures 19, 1997",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let places = structure.places(|p| {
            p.is_straight()
                && p.elements.iter().all(|&e| structure.is_beam(e))
                && structure.part_strains(p, Dof::Rx)
                && rigidity(structure, p, Dof::Rx).is_some()
        });
        places.into_iter().map(|at| at.along(Dof::Rx.name())).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
        let property = rigidity(structure, parts[0], dof).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("torsional stiffness of {} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, [-0.99, CLOSED], &about);
        b.change(
            "",
            &entries(&parts),
            OverrideSpec { scale: entry(property, &format!("1 + {p}")), ..OverrideSpec::default() },
        );
        Ok(b.finish())
    }
}

/// The property that carries the rigidity of a part about an axis, the same for all its elements: `Iy` or `EIy`, `J` or `GJ`.
pub(super) fn rigidity(structure: &Structure<'_>, part: &Part, dof: Dof) -> Option<&'static str> {
    let names = match dof {
        Dof::Rx => ["J", "GJ"],
        Dof::Ry => ["Iy", "EIy"],
        Dof::Rz => ["Iz", "EIz"],
        _ => return None,
    };
    names.into_iter().find(|name| structure.part_has(part, name))
}
