//! Mass along members that the model lacks or has too much.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "Mass along a chain, an element or a group, or over a skin, that the model lacks or has too much: wiring, paint, an empty pipe."]
#[derive(Debug, Clone, Copy)]
pub struct DistributedMass;

impl Effect for DistributedMass {
    fn name(&self) -> &'static str {
        "distributed-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "Mass along a chain, an element or a group, or over a skin, that the model lacks or has too much: wiring, paint, an empty pipe.",
            signature: "Lowers all modes, or raises them, those with much motion of the member more; the modes of one chain keep their \
                    ratios.",
            formulation: "M gains ∫ μ |v|² dx over the beams by `added_mass_per_length`, on the mass axis, or over the \
                    area of shells by `mass_per_area`; μ = 0 leaves it, and below zero it takes up to nine tenths of their mass.",
            confusable: &["point-mass", "air-mass", "stiffness-change", "taper"],
            references: &[
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    /// With the rotary inertia of sections.
    fn becomes(&self) -> &'static [&'static str] {
        &["mass-change"]
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let translates = |p: &super::Part| [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().any(|d| structure.part_moves(p, d));
        structure.places(|p| {
            structure.total_mass() > 0.0
                && (p.elements.iter().all(|&e| structure.is_beam(e))
                    || p.kind != PartKind::Mass && p.elements.iter().all(|&e| structure.is_shell(e)))
                && translates(p)
                // Single elements of a rigid body are not told apart.
                && (p.kind != PartKind::Element || p.elements.iter().any(|&e| structure.deforms(e)))
        })
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let is_skin = structure.is_shell(parts[0].elements[0]);
        let (unit, quantity, property, words) = if is_skin {
            ("kg/m2", "mass_per_area", "mass_per_area", "mass per area missing on")
        } else {
            ("kg/m", "mass_per_length", "added_mass_per_length", "mass per length missing along")
        };
        let extent = |of: &[usize]| if is_skin { structure.area(of) } else { structure.rigidity(of).length };
        let size = extent(&parts[0].elements);
        let elements: Vec<usize> = parts.iter().flat_map(|p| p.elements.iter().copied()).collect();
        let typical = 0.02 * structure.total_mass() / size;
        // No element may have more taken away than it has.
        let lightest = elements.iter().map(|&e| structure.mass_of(&[e]) / extent(&[e])).fold(f64::INFINITY, f64::min);
        let most_too_much = 0.9 * lightest;
        let about = format!("{words} {}", at.place());
        let mu = b.parameter(quantity, unit, typical, [-most_too_much, 25.0 * typical], &about);
        b.change("", &entries(&parts), OverrideSpec { add: entry(property, &mu), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
