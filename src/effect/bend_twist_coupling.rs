//! Elastic coupling of bending and torsion.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, times};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "Elastic coupling between bending and twist of a member: unbalanced laminates, skewed stiffeners, open sections."]
#[derive(Debug, Clone, Copy)]
pub struct BendTwistCoupling;

impl Effect for BendTwistCoupling {
    fn name(&self) -> &'static str {
        "bend-twist-coupling"
    }

    fn about(&self) -> About {
        About {
            summary: "Elastic coupling between bending and twist of a member: unbalanced laminates, skewed \
                    stiffeners, open sections.",
            signature: "Bending modes gain twist and torsion modes gain bending, independent of where the masses sit; \
                    frequencies change to second order.",
            formulation: "U gains K/L (φ2-φ1)(r2-r1), so My = EIy ry' + K rx', by `bend_twist_y` (or z); K = 0 leaves it, \
                    |K| stays below √(EI GJ). On a symmetric partner the sign follows the mirrored axes.",
            confusable: &["mass-offset", "asymmetry"],
            references: &[
                "T. A. Weisshaar, B. L. Foist, Vibration tailoring of advanced composite lifting surfaces, J. Aircraft 22, 1985",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for (axis, dof) in [("y", Dof::Ry), ("z", Dof::Rz)] {
            let property = format!("bend_twist_{axis}");
            let members = structure.members(|p| {
                let coupled = p.elements.iter().any(|&e| structure.property(e, &property).is_some_and(|k| k != 0.0));
                let least = structure.least_coupling(p)[usize::from(axis == "z")];
                structure.part_strains(p, dof) && structure.part_strains(p, Dof::Rx) && !coupled && least > 0.0
            });
            all.extend(members.into_iter().map(|at| at.along(axis)));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let axis = if at.direction() == "y" { 1 } else { 2 };
        // Below the limit of a definite section for every value of the parameters of the model.
        let limit = parts.iter().map(|p| structure.least_coupling(p)[axis - 1]).fold(f64::MAX, f64::min);
        let about = format!("coupling rigidity of bending about {} and twist of {}", at.direction(), at.place());
        let k = b.parameter("rigidity", "N m2", 0.1 * limit, [-0.7 * limit, 0.7 * limit], &about);
        let property = format!("bend_twist_{}", at.direction());
        for (i, part) in parts.iter().enumerate() {
            // Both rotations change sign with their axes under reflection.
            let sign =
                if i == 0 { 1.0 } else { structure.image_sign(parts[0], 0) * structure.image_sign(parts[0], axis) };
            let add = entry(&property, &times(sign, &k));
            let suffix = if parts.len() > 1 { format!(".{}", i + 1) } else { String::new() };
            b.change(&suffix, &part.of, OverrideSpec { add, ..OverrideSpec::default() });
        }
        Ok(b.finish())
    }
}
