//! Mass of members at their nodes instead of along them, or the other way.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::Structure;
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

/// The two ways: what the model has spread is at the nodes, what it has at the nodes is spread.
const WAYS: [&str; 2] = ["lumped", "consistent"];

#[doc = "Mass of members that sits at their joints where the model spreads it, or is spread where the model lumps it: another mass matrix than the model's."]
#[derive(Debug, Clone, Copy)]
pub struct MassLumping;

impl Effect for MassLumping {
    fn name(&self) -> &'static str {
        "mass-lumping"
    }

    fn about(&self) -> About {
        About {
            summary: "Mass of members that sits at their joints where the model spreads it, or is spread where the model lumps \
                    it: another mass matrix than the model's.",
            signature: "Shifts all modes alike in direction, the more the higher they are; total mass and rigid-body modes stay.",
            formulation: "M = (1 - s) M_consistent + s M_lumped, by `lumping` s of beams and bars. `lumped`: s = p of all that \
                    have none, p = 0 leaves it, p = 1 puts half of every element at each of its ends. `consistent`: s (1 - p) \
                    of all that have one.",
            confusable: &["softening", "distributed-mass", "section-rotary-inertia"],
            references: &[
                "J. S. Archer, Consistent mass matrix for distributed mass systems, J. Structural Division ASCE 89, 1963",
                "R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis, 4th ed., 2002, section 11.3",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.is_wider() {
            return Vec::new();
        }
        let has = |way: &&&str| !members(structure, way).is_empty();
        WAYS.iter().filter(has).map(|way| Location::whole().along(way)).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let of = members(structure, at.direction());
        if of.is_empty() {
            return Err(PatchError::unknown_place(self.name(), &at.to_string(), &[]));
        }
        let mut b = Builder::new(self.name(), at);
        let p = b.parameter(
            "share",
            "1",
            0.5,
            [0.0, 1.0],
            &format!("share of the mass of members that is {}", at.direction()),
        );
        let change = match at.direction() {
            "lumped" => OverrideSpec { add: entry("lumping", &p), ..OverrideSpec::default() },
            _ => OverrideSpec { scale: entry("lumping", &format!("1 - {p}")), ..OverrideSpec::default() },
        };
        b.change("", &of, change);
        Ok(b.finish())
    }
}

/// Entries of beams and bars whose mass can be changed this way.
fn members(structure: &Structure<'_>, way: &str) -> Vec<String> {
    let model = structure.model();
    let is_lumped = |e: usize| structure.property(e, "lumping").is_some_and(|s| s > 0.0);
    let can = |e: usize| match way {
        "lumped" => !is_lumped(e),
        "consistent" => is_lumped(e),
        _ => false,
    };
    let has_mass = |e: usize| structure.is_heavy(e) && structure.deforms(e);
    let of_entry = |name: &&String| {
        model.element_set(name).is_some_and(|own| own.iter().any(|&e| has_mass(e)) && own.iter().all(|&e| can(e)))
    };
    let spec = model.spec();
    spec.beams.keys().chain(spec.bars.keys()).filter(of_entry).cloned().collect()
}
