//! A bending stiffness that is locally wrong.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Part, PartKind, Structure, entries};
use super::torsion_stiffness_change::rigidity;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// Largest change: an I section on its side is up to twenty times as stiff about one axis as it is upright.
const TURNED: f64 = 20.0;

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
                    while its torsion is right; a skin that bends more easily than it stretches: delamination.",
            signature: "Shifts bending modes of that plane that curve the place; torsion modes stay.",
            formulation: "EIy (or EIz) of the elements is multiplied by 1 + p, through `Iy` or `EIy` as the file gives \
                    it; of shells `bending_factor` is 1 + p times what it was, and their membranes stay, as where plies \
                    have come apart; p = 0 leaves it.",
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
        let skins = structure.places(|p| {
            let stated = |e: &&usize| structure.property(**e, "bending_factor").is_some();
            let n_stated = p.elements.iter().filter(stated).count();
            p.kind != PartKind::Mass
                && (n_stated == 0 || n_stated == p.elements.len())
                && p.elements.iter().all(|&e| structure.is_shell(e) && structure.property(e, "thickness").is_some())
                && p.elements.iter().any(|&e| structure.deforms(e))
        });
        all.extend(skins);
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        if at.direction().is_empty() {
            return Ok(of_skin(self.name(), structure, &parts, at));
        }
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
        let property = rigidity(structure, parts[0], dof).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("bending stiffness of {} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, [-0.99, TURNED], &about);
        b.change(
            "",
            &entries(&parts),
            OverrideSpec { scale: entry(property, &format!("1 + {p}")), ..OverrideSpec::default() },
        );
        Ok(b.finish())
    }
}

/// The bending of shells in a place, with their membranes as they are.
fn of_skin(effect: &'static str, structure: &Structure<'_>, parts: &[&Part], at: &Location) -> Patch {
    let mut b = Builder::new(effect, at);
    let about = format!("bending stiffness of {} against the model, factor less one", at.place());
    let p = b.parameter("change", "1", -0.1, [-0.99, 2.0], &about);
    let all = || parts.iter().flat_map(|p| &p.elements);
    let is_stated = all().any(|&e| structure.property(e, "bending_factor").is_some());
    let factor = entry("bending_factor", &format!("1 + {p}"));
    let change = if is_stated {
        OverrideSpec { scale: factor, ..OverrideSpec::default() }
    } else {
        OverrideSpec { set: factor, ..OverrideSpec::default() }
    };
    b.change("", &entries(parts), change);
    b.finish()
}
