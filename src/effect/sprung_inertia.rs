//! A moment of inertia on a torsion spring: control surfaces.

use super::edit::PatchError;
use super::location::Location;
use super::patch::Patch;
use super::sprung::{store_locations, store_patch};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;

#[doc = "A moment of inertia on a torsion spring at a node: a control surface on its actuator, a store that pitches."]
#[derive(Debug, Clone, Copy)]
pub struct SprungInertia;

impl Effect for SprungInertia {
    fn name(&self) -> &'static str {
        "sprung-inertia"
    }

    fn about(&self) -> About {
        About {
            summary: "A moment of inertia on a torsion spring at a node: a control surface on its actuator, a store \
                    that pitches.",
            signature: "An extra mode near its own frequency with rotation of the host; torsion modes veer with it.",
            formulation: "A node of its own, joined to the host by a torsion spring k about one axis: K gains k (s - r)², \
                    M gains J ṡ². J = 0 leaves every mode; its frequency is √(k/J)/2π. Static unbalance of the \
                    surface is not part of it: see `mass-offset`.",
            confusable: &["point-rotary-inertia", "sprung-mass", "torsion-stiffness-change"],
            references: &[
                "J. P. Den Hartog, Mechanical Vibrations, 1956, section 3.2",
                "R. L. Bisplinghoff, H. Ashley, R. L. Halfman, Aeroelasticity, 1955",
            ],
        }
    }

    /// On a stiff spring.
    fn becomes(&self) -> &'static [&'static str] {
        &["point-rotary-inertia"]
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        store_locations(structure, &[Dof::Rx, Dof::Ry, Dof::Rz])
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        store_patch(self.name(), structure, at)
    }
}
