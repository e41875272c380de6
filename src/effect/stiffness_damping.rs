//! Internal damping of members.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "Damping inside a part, in proportion to its stiffness: material and joint damping, locally or of the whole structure."]
#[derive(Debug, Clone, Copy)]
pub struct StiffnessDamping;

impl Effect for StiffnessDamping {
    fn name(&self) -> &'static str {
        "stiffness-damping"
    }

    fn about(&self) -> About {
        About {
            summary: "Damping inside a part, in proportion to its stiffness: material and joint damping, locally or \
                    of the whole structure.",
            signature: "Damping ratios of modes that strain the part rise, in proportion to frequency and to the share \
                    of strain energy there; shapes become complex where it is local.",
            formulation: "C gains β K of the elements; β = 0 leaves it. ζ = β ω/2 times the share of strain energy; a \
                    loss factor η at ω is β = η/ω.",
            confusable: &["ground-dashpot", "mass-damping"],
            references: &[
                "S. Adhikari, Damping models for structural vibration, 2000",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let strained = |&e: &usize| structure.deforms(e);
        let mut all = structure.places(|p| p.kind != PartKind::Mass && p.elements.iter().any(strained));
        if structure.stiff_entries(true).len() > 1 {
            all.push(Location::whole());
        }
        all
    }

    fn damps(&self) -> bool {
        true
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let of = if at.names.is_empty() {
            structure.stiff_entries(true)
        } else {
            entries(&structure.parts_at(self.name(), at)?)
        };
        let mut b = Builder::new(self.name(), at);
        // A damping ratio of 1 % at the characteristic frequency.
        let typical = 0.02 / structure.omega2().sqrt();
        let about = format!("internal damping of {}, relative to its stiffness", at.place());
        let beta = b.parameter("time", "s", typical, [0.0, 50.0 * typical], &about);
        b.change("", &of, OverrideSpec { stiffness_damping: Some(scalar(&beta)), ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
