//! Air that moves with broad members.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// π ρ/4 of a thin plate in air at sea level, kg/m³.
const AIR: f64 = 0.25 * std::f64::consts::PI * 1.225;

#[doc = "The apparent mass of the air (or water) around a broad member: inertia normal to it, without weight."]
#[derive(Debug, Clone, Copy)]
pub struct AirMass;

impl Effect for AirMass {
    fn name(&self) -> &'static str {
        "air-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "The apparent mass of the air (or water) around a broad member: inertia normal to it, without \
                    weight.",
            signature: "Lowers the modes of light, broad surfaces that move normal to themselves; in-plane modes and \
                    the weighed mass stay. A test in vacuum would not show it.",
            formulation: "M gains ∫ m' w² dx for the motion w normal to a strip of chord c, m' = π ρ c²/4 (thin plate), \
                    by `air_mass_z` or `air_mass_y` on the mass axis; m' = 0 leaves it. A taper of the chord within \
                    a chain is not followed; its size is that of the mean square chord. Expected is that of air around \
                    a plate as wide as the sections (√12 times their radius of gyration).",
            confusable: &["distributed-mass", "mass-offset", "softening"],
            references: &[
                "R. L. Bisplinghoff, H. Ashley, R. L. Halfman, Aeroelasticity, 1955, section 5.6",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979, chapter 14",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for (axis, dof) in [("z", Dof::Uz), ("y", Dof::Uy)] {
            let members = structure.members(|p| structure.total_mass() > 0.0 && structure.part_moves(p, dof));
            all.extend(members.into_iter().map(|at| at.along(axis)));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let share = structure.total_mass() / structure.rigidity(&parts[0].elements).length;
        let typical = structure.section_width(&parts[0].elements).map_or(0.01 * share, |c| AIR * c * c);
        let about = format!("mass per length of the air that moves with {} along its {}", at.place(), at.direction());
        let air = b.parameter("mass_per_length", "kg/m", typical, [0.0, (50.0 * typical).max(0.5 * share)], &about);
        let property = format!("air_mass_{}", at.direction());
        b.change("", &entries(&parts), OverrideSpec { add: entry(&property, &air), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
