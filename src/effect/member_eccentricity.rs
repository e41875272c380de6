//! Members whose axis lies beside the line of their nodes.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, times};
use super::structure::{Part, Structure};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "A member whose axis lies beside the line between its nodes: a stringer on a skin, a brace bolted to a face, a beam under a deck."]
#[derive(Debug, Clone, Copy)]
pub struct MemberEccentricity;

impl Effect for MemberEccentricity {
    fn name(&self) -> &'static str {
        "member-eccentricity"
    }

    fn about(&self) -> About {
        About {
            summary: "A member whose axis lies beside the line between its nodes: a stringer on a skin, a brace bolted to \
                    a face, a beam under a deck.",
            signature: "Bending of what it is joined to stretches it, and its tension bends what it is joined to; a member \
                    that stands alone only moves its sensors.",
            formulation: "Elastic, neutral and mass axis all lie e along the member's y (or z) from its nodes, by \
                    `shear_centre_y`, `neutral_axis_y` and `mass_offset_y`; e = 0 leaves them.",
            confusable: &["mass-offset", "bend-twist-coupling", "bending-stiffness-change"],
            references: &[
                "R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis, 4th ed., 2002, section 13.8",
                "W. McGuire, R. H. Gallagher, R. D. Ziemian, Matrix Structural Analysis, 2nd ed., 2000, section 13.3",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let along = |(i, axis): (usize, &'static str)| {
            let members = structure.members(|p| acts(structure, p, i + 1));
            members.into_iter().map(move |at| at.along(axis))
        };
        ["y", "z"].into_iter().enumerate().flat_map(along).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let axis = 1 + ["y", "z"].iter().position(|a| *a == at.direction()).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let r = structure.rigidity(&parts[0].elements);
        // A radius of gyration, 0.29 of a rectangle's height, doubles the bending stiffness about the line of the nodes: a third of it is a
        // fair size, three of it are as far as a member can lie from its nodes.
        let radius = (r.ei.into_iter().filter(|ei| *ei > 0.0).fold(f64::INFINITY, f64::min) / r.ea).sqrt();
        let most = 0.02 * r.length;
        let typical = if radius.is_finite() && radius > 0.0 { (0.3 * radius).min(most) } else { most };
        let toward =
            structure.model().elements()[parts[0].elements[0]].axes[axis].map(|c| (100.0 * c).round() / 100.0 + 0.0);
        let about = format!("axis beside the nodes of {}, along {toward:?} of {}", at.place(), parts[0].name);
        let e = b.parameter("offset", "m", typical, [-10.0 * typical, 10.0 * typical], &about);
        let word = at.direction();
        for (i, part) in parts.iter().enumerate() {
            let sign = if i == 0 { 1.0 } else { structure.image_sign(parts[0], axis) };
            let suffix = if parts.len() > 1 { format!(".{}", i + 1) } else { String::new() };
            for (k, (names, sign)) in structure.runs(part, axis, sign).into_iter().enumerate() {
                let piece = if k == 0 { String::new() } else { format!(".piece{}", k + 1) };
                let offset = times(sign, &e);
                let mut add = entry(&format!("shear_centre_{word}"), &offset);
                let neutral = format!("neutral_axis_{word}");
                // Where it is absent it follows the elastic axis by itself.
                if structure.part_has(part, &neutral) {
                    add.extend(entry(&neutral, &offset));
                }
                add.extend(entry(&format!("mass_offset_{word}"), &offset));
                b.change(&format!("{suffix}{piece}"), &names, OverrideSpec { add, ..OverrideSpec::default() });
            }
        }
        Ok(b.finish())
    }
}

/// Whether an offset along an axis of the part couples what it does: stretching with bending about the other, or bending with twist; and its
/// elements have a neutral axis all or none.
fn acts(structure: &Structure<'_>, part: &Part, axis: usize) -> bool {
    let word = ["x", "y", "z"][axis];
    let given = part.elements.iter().filter(|&&e| structure.property(e, &format!("neutral_axis_{word}")).is_some());
    let is_alike = [0, part.elements.len()].contains(&given.count());
    let other = if axis == 1 { Dof::Rz } else { Dof::Ry };
    is_alike
        && (structure.part_strains(part, Dof::Ux) && structure.part_moves(part, other)
            || structure.part_strains(part, if axis == 1 { Dof::Ry } else { Dof::Rz })
                && structure.part_moves(part, Dof::Rx))
}
