//! Ends of members inside joints that do not deform.

use super::edit::PatchError;
use super::location::{Location, LocationKind};
use super::patch::{Builder, Patch, entry};
use super::structure::{JointEnd, Structure};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

/// A length that an engineer would expect, and the longest, as shares of the element at the end: a mesh four times as fine still holds the
/// longest at both ends of a quarter of it.
const TYPICAL: f64 = 0.05;
const LONGEST: f64 = 0.12;

#[doc = "A member that is stiff over the depth of its joint or clamp, so that it deforms over less than the length between its nodes."]
#[derive(Debug, Clone, Copy)]
pub struct RigidEnd;

impl Effect for RigidEnd {
    fn name(&self) -> &'static str {
        "rigid-end"
    }

    fn about(&self) -> About {
        About {
            summary: "A member that is stiff over the depth of its joint or clamp, so that it deforms over less than the \
                    length between its nodes.",
            signature: "Raises all modes that bend the member at that end, as a shorter span does; shapes are straight \
                    inside the joint.",
            formulation: "The beam begins at the end of a rigid arm of length a along it, by `end1_rigid_length` (or 2); its \
                    mass there moves with the node; a = 0 leaves it. `whole` gives every end in a joint, a link or a \
                    support the same a.",
            confusable: &["stiffness-change", "bending-stiffness-change", "softening"],
            references: &[
                "W. McGuire, R. H. Gallagher, R. D. Ziemian, Matrix Structural Analysis, 2nd ed., 2000, section 13.3",
                "J. E. Mottershead, M. I. Friswell, G. H. T. Ng, J. A. Brandon, Geometric parameters for finite element model updating of joints and constraints, Mech. Syst. Signal Process. 10, 1996",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = structure.joint_end_places();
        if structure.joint_ends().len() > 2 && !all.is_empty() {
            all.push(Location::whole());
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let all = structure.joint_ends();
        let ends: Vec<&JointEnd> = if at.kind == LocationKind::Whole {
            all.iter().collect()
        } else {
            let named = |name: &String| all.iter().find(|e| structure.joint_end_name(e) == *name).ok_or_else(unknown);
            at.names.iter().map(named).collect::<Result<_, _>>()?
        };
        let shortest = ends.iter().map(|e| structure.length(e.element)).fold(f64::INFINITY, f64::min);
        if !shortest.is_finite() {
            return Err(unknown());
        }
        let mut b = Builder::new(self.name(), at);
        let about = format!("length that does not deform at {}", at.place());
        let length = b.parameter("length", "m", TYPICAL * shortest, [0.0, LONGEST * shortest], &about);
        for side in [1, 2] {
            let mut of: Vec<String> = Vec::new();
            for end in ends.iter().filter(|e| e.side == side) {
                let name = structure.element_of_file(end.element).to_string();
                of.push(name);
            }
            // The parts of a subdivided element follow one another.
            of.dedup();
            if !of.is_empty() {
                let add = entry(&format!("end{side}_rigid_length"), &length);
                let is_alone = ends.iter().all(|e| e.side == side);
                let suffix = if is_alone { String::new() } else { format!(".end{side}") };
                b.change(&suffix, &of, OverrideSpec { add, ..OverrideSpec::default() });
            }
        }
        Ok(b.finish())
    }
}
