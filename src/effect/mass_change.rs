//! The known mass of one test that is not what the file says.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

/// How much less and more than stated a mass may be, of itself.
const BOUNDS: [f64; 2] = [-0.95, 3.0];

#[doc = "A mass that one configuration brings, the known mass of a test, lighter or heavier than the file says."]
#[derive(Debug, Clone, Copy)]
pub struct MassChange;

impl Effect for MassChange {
    fn name(&self) -> &'static str {
        "mass-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass that one configuration brings, the known mass of a test, lighter or heavier than the file says: a wrong \
                    weight on the tip, ballast that was left in.",
            signature: "Moves the modes of the tests made in that configuration, in proportion to the square of their shape at the \
                    mass, and of no other test.",
            formulation: "The mass matrix of the point mass is multiplied by 1 + p, -0.95 <= p <= 3; p = 0 leaves it. More mass in all \
                    configurations is a point-mass, less an absent-mass.",
            confusable: &["point-mass", "stiffness-change", "mass-offset"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
                "J. A. Brandon, Strategies for Structural Dynamic Modification, 1990",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| {
            let is_own = p.kind == PartKind::Mass && structure.context().is_own_mass(&p.name);
            (is_own || structure.is_of_matrices(p)) && p.elements.iter().any(|&e| structure.is_heavy(e))
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
