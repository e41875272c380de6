//! Shear deformation of members.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "Shear deformation of members that the model has as Euler-Bernoulli beams."]
#[derive(Debug, Clone, Copy)]
pub struct ShearFlexibility;

impl Effect for ShearFlexibility {
    fn name(&self) -> &'static str {
        "shear-flexibility"
    }

    fn about(&self) -> About {
        About {
            summary: "Shear deformation of members that the model has as Euler-Bernoulli beams.",
            signature: "Lowers bending modes, the higher the more (deficit grows with the square of the wave number); \
                    torsion stays; shapes hardly change.",
            formulation: "Timoshenko beam with shear compliance c = 1/(κ G A), by `shear_compliance_z` (or y): Φ = 12 EI \
                    c/L²; c = 0 leaves it.",
            confusable: &["section-rotary-inertia", "axial-preload", "root-flexibility"],
            references: &[
                "S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic bars, 1921",
                "G. R. Cowper, The shear coefficient in Timoshenko's beam theory, 1966",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for (dof, bending, factor) in [(Dof::Uz, Dof::Ry, "kappa_z"), (Dof::Uy, Dof::Rz, "kappa_y")] {
            let members = structure.members(|p| {
                let has_shear = p.elements.iter().any(|&e| structure.property(e, factor).is_some());
                structure.part_strains(p, bending) && structure.part_strains(p, dof) && !has_shear
            });
            all.extend(members.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let r = structure.rigidity(&parts[0].elements);
        let (property, ei) =
            if at.direction() == "uz" { ("shear_compliance_z", r.ei[0]) } else { ("shear_compliance_y", r.ei[1]) };
        // 3 % of the tip deflection of the member as a cantilever under a tip force, L³/(3 EI), is shear.
        let typical = 0.01 * r.length.powi(2) / ei;
        let about = format!("shear compliance of {} along {}", at.place(), at.direction());
        let c = b.parameter("compliance", "1/N", typical, [0.0, 30.0 * typical], &about);
        b.change("", &entries(&parts), OverrideSpec { add: entry(property, &c), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
