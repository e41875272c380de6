//! A member that the structure does not have, or that is broken.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{Part, PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::Joined;
use crate::model::spec::OverrideSpec;

/// Nearly all of a member: what is left keeps its own dofs determined, and along a brace is still nothing beside the bending of a frame.
const NEARLY_ALL: f64 = 0.999_999;
/// A member of which less is lost is there.
const MOSTLY: f64 = 0.8;

#[doc = "A member of a structure with closed loops that is absent, broken or not connected: a diagonal, a strut, a second load path."]
#[derive(Debug, Clone, Copy)]
pub struct AbsentMember;

impl Effect for AbsentMember {
    fn name(&self) -> &'static str {
        "absent-member"
    }

    fn about(&self) -> About {
        About {
            summary: "A member of a structure with closed loops that is absent, broken or not connected: a diagonal, a strut, \
                    a second load path.",
            signature: "Modes that strain the member fall far, often by a tenth and more, and their shapes change between its \
                    ends; the others rise a little, for its mass is gone too.",
            formulation: "The stiffness of its elements is multiplied by 1 - p, their mass by (1 - p)²; p = 0 leaves them, p = 0.999999 \
                    takes nearly all, and its own modes leave the band. Only where the structure holds together without it.",
            confusable: &["stiffness-change", "joint-flexibility", "asymmetry"],
            references: &[
                "S. W. Doebling, C. R. Farrar, M. B. Prime, D. W. Shevitz, Damage identification and health monitoring of structural and mechanical systems from changes in their vibration characteristics: a literature review, Los Alamos LA-13070-MS, 1996",
                "O. S. Salawu, Detection of structural damage through changes in frequency: a review, Engineering Structures 19, 1997",
            ],
        }
    }

    fn plainly(&self, intervals: &[[f64; 2]]) -> Option<&'static str> {
        let is_there = intervals.first().is_some_and(|loss| loss[1] < MOSTLY);
        is_there.then_some("stiffness-change")
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| {
            let is_bar = p.kind == PartKind::Element && p.elements.iter().all(|&e| kind(structure, e) == "bar");
            let is_group = p.kind == PartKind::Group;
            (p.is_member || is_bar || is_group)
                && p.elements.iter().any(|&e| structure.deforms(e))
                && closes_a_loop(structure, p)
        })
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("share of {} that is absent", at.place());
        let p = b.parameter("loss", "1", 0.5, [0.0, NEARLY_ALL], &about);
        let left = || Some(scalar(&format!("1 - {p}")));
        b.change("", &entries(&parts), OverrideSpec { stiffness: left(), mass: left(), ..OverrideSpec::default() });
        // With equal factors the modes of the member by itself would stay in the band.
        b.change("mass", &entries(&parts), OverrideSpec { mass: left(), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}

fn kind<'a>(structure: &'a Structure<'_>, element: usize) -> &'a str {
    structure.model().elements()[element].kind.name()
}

/// Whether the nodes of a part that other things hold are joined without it as well.
fn closes_a_loop(structure: &Structure<'_>, part: &Part) -> bool {
    let model = structure.model();
    let rest = Joined::new(model, &part.elements);
    let mut ends: Vec<usize> = part.elements.iter().flat_map(|&e| model.elements()[e].nodes.iter().copied()).collect();
    ends.sort_unstable();
    ends.dedup();
    ends.retain(|&n| rest.is_held(n));
    ends.len() > 1 && ends.iter().all(|&n| rest.are_joined(n, ends[0]))
}
