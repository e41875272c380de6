//! Rotary inertia of the cross-sections of members.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "Rotary inertia of the cross-sections: Rayleigh's term against bending slopes, or twist inertia beside that of the model."]
#[derive(Debug, Clone, Copy)]
pub struct SectionRotaryInertia;

impl Effect for SectionRotaryInertia {
    fn name(&self) -> &'static str {
        "section-rotary-inertia"
    }

    fn about(&self) -> About {
        About {
            summary: "Rotary inertia of the cross-sections: Rayleigh's term against bending slopes, or twist inertia \
                    beside that of the model.",
            signature: "Lowers high bending modes (about y or z) in proportion to the square of their wave number, or \
                    torsion modes (about x); the first modes hardly.",
            formulation: "M gains ∫ j r² dx for the rotation r of the section; a section with radius of gyration ρ has j \
                    = μ ρ²; j = 0 leaves it.",
            confusable: &["shear-flexibility", "axial-preload", "point-rotary-inertia"],
            references: &[
                "Lord Rayleigh, The Theory of Sound, 1894, section 186",
                "S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic bars, 1921",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for dof in [Dof::Rx, Dof::Ry, Dof::Rz] {
            let members = structure.members(|p| {
                // The twist inertia that a density implies would be lost by adding to it.
                let implied = dof == Dof::Rx
                    && p.elements.iter().any(|&e| {
                        structure.property(e, "density").is_some()
                            && structure.property(e, "polar_inertia_per_length").is_none()
                    });
                structure.rigidity(&p.elements).mass > 0.0 && structure.part_moves(p, dof) && !implied
            });
            all.extend(members.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let r = structure.rigidity(&parts[0].elements);
        // A radius of gyration of a fiftieth of the length: beyond a fifth it is not a beam.
        let of_radius = |ratio: f64| r.mass * (ratio * r.length).powi(2);
        let about = format!("rotary inertia per length of {} about its {}", at.place(), &at.direction()[1..]);
        let j = b.parameter("inertia_per_length", "kg m", of_radius(0.02), [0.0, of_radius(0.2)], &about);
        let property = match at.direction() {
            "rx" => "polar_inertia_per_length",
            "ry" => "rotary_inertia_y",
            _ => "rotary_inertia_z",
        };
        b.change("", &entries(&parts), OverrideSpec { add: entry(property, &j), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
