//! A mass that is not what the file says: the known mass of one test, or members and parts of another density.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

/// How much less and more than stated a mass may be, of itself.
const BOUNDS: [f64; 2] = [-0.95, 3.0];

#[doc = "A mass that is not what the file says: one that a configuration brings, or members, rods or solid parts of another density."]
#[derive(Debug, Clone, Copy)]
pub struct MassChange;

impl Effect for MassChange {
    fn name(&self) -> &'static str {
        "mass-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass that is not what the file says: one that a configuration brings, a wrong weight on the tip, ballast that was \
                    left in; members, rods or solid parts of another density.",
            signature: "Moves the modes in which the part moves, in proportion to the square of their shape there; of what one configuration \
                    brings only those of the tests made in it.",
            formulation: "The mass matrices of the part are multiplied by 1 + p, -0.95 <= p <= 3, rotary inertia of sections with them; p = 0 \
                    leaves it. More of a mass that stands in all configurations is a point-mass, less an absent-mass. Of beams and shells a \
                    distributed-mass says the same without rotary inertia; the more probable of the two is named.",
            confusable: &["distributed-mass", "point-mass", "stiffness-change", "mass-offset"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
                "J. A. Brandon, Strategies for Structural Dynamic Modification, 1990",
            ],
        }
    }

    /// Without rotary inertia.
    fn becomes(&self) -> &'static [&'static str] {
        &["distributed-mass"]
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| {
            let is_own = p.kind == PartKind::Mass && structure.context().is_own_mass(&p.name);
            let is_solid = || p.elements.iter().all(|&e| structure.is_solid(e));
            let has_a_density = || p.kind == PartKind::Group || p.kind != PartKind::Mass && is_solid();
            (is_own || structure.is_of_matrices(p) || has_a_density())
                && p.elements.iter().any(|&e| structure.is_heavy(e))
        })
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("mass of {} against the file, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, BOUNDS, &about);
        let factor = Some(scalar(&format!("1 + {p}")));
        b.change("", &entries(&parts), OverrideSpec { mass: factor, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
