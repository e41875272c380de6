//! Left and right that are not alike.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{PartKind, Structure};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "Two sides of the structure that the model has alike, and that differ in stiffness or mass."]
#[derive(Debug, Clone, Copy)]
pub struct Asymmetry;

impl Effect for Asymmetry {
    fn name(&self) -> &'static str {
        "asymmetry"
    }

    fn about(&self) -> About {
        About {
            summary: "Two sides of the structure that the model has alike, and that differ in stiffness or mass.",
            signature: "Modes lose their symmetry and pairs of modes split; frequencies change to second order only, \
                    shapes to first.",
            formulation: "The stiffness (or mass) of one side is multiplied by 1 + p, that of the other by 1 - p; p = 0 \
                    leaves both.",
            confusable: &["stiffness-change", "point-mass", "distributed-mass"],
            references: &[
                "C. Pierre, Mode localization and eigenvalue loci veering phenomena in disordered structures, J. Sound and Vibration 126, 1988",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for what in ["stiffness", "mass"] {
            let places = structure.places(|p| {
                let acts = |&e: &usize| if what == "mass" { structure.is_heavy(e) } else { structure.deforms(e) };
                (p.kind == PartKind::Group || p.is_member) && p.elements.iter().any(acts)
            });
            all.extend(places.into_iter().filter(|at| at.names.len() == 2).map(|at| at.along(what)));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("{} of {} above the mean of both sides, relative", at.direction(), at.names[0]);
        let p = b.parameter("difference", "1", 0.05, [-0.8, 0.8], &about);
        for (i, (part, sign)) in parts.into_iter().zip(["+", "-"]).enumerate() {
            let factor = Some(scalar(&format!("1 {sign} {p}")));
            let entry = if at.direction() == "mass" {
                OverrideSpec { mass: factor, ..OverrideSpec::default() }
            } else {
                OverrideSpec { stiffness: factor, ..OverrideSpec::default() }
            };
            b.change(&format!(".{}", i + 1), &part.of, entry);
        }
        Ok(b.finish())
    }
}
