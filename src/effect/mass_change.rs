//! A point mass that is not what the file says.

use super::location::Location;
use super::patch::{Builder, Patch, PatchError, scalar};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

/// Share of a mass that may be absent.
const MOST: f64 = 0.95;
/// How many times more than stated a mass of one configuration may be.
const HEAVIER: f64 = 3.0;

#[doc = "A point mass that is lighter than the file says; or the known mass of one test, lighter or heavier."]
#[derive(Debug, Clone, Copy)]
pub struct MassChange;

impl Effect for MassChange {
    fn name(&self) -> &'static str {
        "mass-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A point mass that is lighter than the file says: equipment that was left out or weighed with its case; or \
                    the known mass of one test, lighter or heavier.",
            signature: "Raises modes in proportion to the square of their shape at the mass, and moves shapes towards it. A mass \
                    of one configuration moves only the modes of the tests made in it.",
            formulation: "The mass matrix of the point mass is multiplied by 1 - p, 0 <= p <= 0.95 (more at a node is a \
                    point-mass); that of a mass which stands in one configuration only by 1 + p, -0.95 <= p <= 3. p = 0 leaves \
                    it.",
            confusable: &["point-mass", "stiffness-change", "mass-offset"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
                "J. A. Brandon, Strategies for Structural Dynamic Modification, 1990",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| p.kind == PartKind::Mass && p.elements.iter().any(|&e| structure.is_heavy(e)))
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let factor = if at.names.iter().all(|name| structure.context().is_own_mass(name)) {
            let about = format!("mass of {} against the file, factor less one", at.place());
            let p = b.parameter("change", "1", 0.1, [-MOST, HEAVIER], &about);
            format!("1 + {p}")
        } else {
            let about = format!("share of the mass of {} that is not there", at.place());
            let p = b.parameter("loss", "1", 0.2, [0.0, MOST], &about);
            format!("1 - {p}")
        };
        b.change("", &entries(&parts), OverrideSpec { mass: Some(scalar(&factor)), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
