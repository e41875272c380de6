//! Damping by the surrounding air.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "Damping in proportion to mass: the drag of the surrounding air, or of bungees, on members or on the whole structure."]
#[derive(Debug, Clone, Copy)]
pub struct MassDamping;

impl Effect for MassDamping {
    fn name(&self) -> &'static str {
        "mass-damping"
    }

    fn about(&self) -> About {
        About {
            summary: "Damping in proportion to mass: the drag of the surrounding air, or of bungees, on members or on \
                    the whole structure.",
            signature: "Damping ratios of low modes rise most, in proportion to 1/ω; rigid-body modes are damped; \
                    shapes stay real where it acts on everything.",
            formulation: "C gains α M of the elements; α = 0 leaves it. ζ = α/(2 ω) times the share of kinetic energy.",
            confusable: &["stiffness-damping", "ground-dashpot"],
            references: &[
                "S. Adhikari, Damping models for structural vibration, 2000",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = structure.places(|p| {
            (p.is_member || structure.is_of_matrices(p)) && p.elements.iter().any(|&e| structure.is_heavy(e))
        });
        if heavy_entries(structure).len() > 1 {
            all.push(Location::whole());
        }
        all
    }

    fn damps(&self) -> bool {
        true
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let of =
            if at.names.is_empty() { heavy_entries(structure) } else { entries(&structure.parts_at(self.name(), at)?) };
        let mut b = Builder::new(self.name(), at);
        // A damping ratio of 1 % at the characteristic frequency.
        let typical = 0.02 * structure.omega2().sqrt();
        let about = format!("damping of {} relative to its mass", at.place());
        let alpha = b.parameter("rate", "1/s", typical, [0.0, 50.0 * typical], &about);
        b.change("", &of, OverrideSpec { mass_damping: Some(scalar(&alpha)), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}

/// Names of the entries of the file with mass that moves.
fn heavy_entries(structure: &Structure<'_>) -> Vec<String> {
    let spec = structure.model().spec();
    let members = spec.beams.keys().chain(spec.bars.keys()).chain(spec.elements.keys()).chain(spec.masses.keys());
    let members = members.chain(spec.superelements.keys());
    let heavy = |name: &&String| {
        structure.model().element_set(name).is_some_and(|set| set.iter().any(|&e| structure.is_heavy(e)))
    };
    members.filter(heavy).cloned().collect()
}
