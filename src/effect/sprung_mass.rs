//! A mass on a spring: stores, equipment, liquids.

use super::edit::PatchError;
use super::location::Location;
use super::patch::Patch;
use super::sprung::{store_locations, store_patch};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;

#[doc = "A mass on a spring at a node: a store, equipment on isolators, a pylon that gives, sloshing."]
#[derive(Debug, Clone, Copy)]
pub struct SprungMass;

impl Effect for SprungMass {
    fn name(&self) -> &'static str {
        "sprung-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass on a spring at a node: a store, equipment on isolators, a pylon that gives, sloshing.",
            signature: "An extra mode near its own frequency, with veering and a phase jump across it; below it acts as \
                    a point mass, above it as a spring to ground.",
            formulation: "A node of its own, joined to the host by a spring k in one direction and rigidly in the others \
                    of translation: K gains k (s - u)², M gains m ṡ². m = 0 leaves every mode (the store's dof is \
                    then massless and follows its host); its frequency is √(k/m)/2π.",
            confusable: &["point-mass", "sprung-inertia", "ground-spring"],
            references: &[
                "J. P. Den Hartog, Mechanical Vibrations, 1956, section 3.2",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
            ],
        }
    }

    /// On a stiff spring.
    fn becomes(&self) -> &'static [&'static str] {
        &["point-mass"]
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        store_locations(structure, &[Dof::Ux, Dof::Uy, Dof::Uz])
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        store_patch(self.name(), structure, at)
    }
}
