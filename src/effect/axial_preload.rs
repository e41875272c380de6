//! A static axial force.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// Strain of a preload that is found in use, at most: half of the yield strain of structural steel.
const USUAL: f64 = 5e-4;
/// Strain that no structural metal or laminate bears for long.
const STRONGEST: f64 = 0.01;
/// Strain at which structural steel yields.
const YIELD: f64 = 2e-3;

#[doc = "A static axial force in a member: tension stiffens it against bending, compression softens it."]
#[derive(Debug, Clone, Copy)]
pub struct AxialPreload;

impl Effect for AxialPreload {
    fn name(&self) -> &'static str {
        "axial-preload"
    }

    fn about(&self) -> About {
        About {
            summary: "A static axial force in a member: tension stiffens it against bending, compression softens it.",
            signature: "Shifts low bending modes most (relative effect falls with the square of the wave number); \
                    torsion stays.",
            formulation: "Geometric stiffness P ∫ (v'² + w'²) dx by `axial_force`, tension positive; P = 0 leaves it. A \
                    pinned beam has ω² = ω0² (1 + P L²/(π² EI)).",
            confusable: &["shear-flexibility", "section-rotary-inertia", "root-flexibility"],
            references: &[
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
                "A. Bokaian, Natural frequencies of beams under tensile axial loads, J. Sound and Vibration 142, 1990",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.members(|p| structure.part_strains(p, Dof::Ry) || structure.part_strains(p, Dof::Rz))
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let r = structure.rigidity(&parts[0].elements);
        let bends = [Dof::Ry, Dof::Rz].map(|d| structure.part_strains(parts[0], d));
        let ei =
            r.ei.into_iter().zip(bends).filter(|(ei, b)| *b && *ei > 0.0).map(|(ei, _)| ei).fold(f64::MAX, f64::min);
        // Euler's load of the longest stretch that nothing else holds: with both ends clamped it buckles at four times that, as a
        // cantilever at a quarter.
        let (span, is_held) = structure.free_span(&parts[0].elements);
        let euler = std::f64::consts::PI.powi(2) * ei / span.powi(2);
        let least = if is_held { -4.0 } else { -0.25 };
        // A stub yields long before it buckles, and a tie bears much more than what would buckle it.
        let (usual, most, tie) =
            if r.ea > 0.0 { (USUAL * r.ea, STRONGEST * r.ea, YIELD * r.ea) } else { (f64::MAX, f64::MAX, 0.0) };
        // What is there already is known to a tenth; without it a member is in compression sooner.
        let own = structure.axial_force(&parts[0].elements);
        let about = format!("axial force in {}, tension positive", at.place());
        let p = b.parameter(
            "force",
            "N",
            usual.min((0.05 * euler).max(0.1 * own.abs())),
            [(least * euler - own.max(0.0)).max(-most), most.min((10.0 * euler).max(tie))],
            &about,
        );
        b.change("", &entries(&parts), OverrideSpec { add: entry("axial_force", &p), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
