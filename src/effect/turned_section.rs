//! A member whose section is turned about its axis.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, round};
use super::structure::{Part, PartKind, Structure, entries};
use super::torsion_stiffness_change::rigidity;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "A member whose section stands turned about its axis: a flat bar on edge, a column with its web across."]
#[derive(Debug, Clone, Copy)]
pub struct TurnedSection;

/// Second moments of area that differ by less look alike from all sides, and by more are of a plate and of no beam.
const ALIKE: f64 = 1.2;
const FLAT: f64 = 100.0;

/// Typical is a turn by which the weaker axis gains a tenth: of a flat section a larger one is no slope.
const GAIN: f64 = 0.1;

impl Effect for TurnedSection {
    fn name(&self) -> &'static str {
        "turned-section"
    }

    fn about(&self) -> About {
        About {
            summary: "A member whose section stands turned about its axis: a flat bar on edge, a column with its web across.",
            signature: "Bending modes of one plane of the member rise and those of the other fall, by the ratio of its second \
                    moments of area; torsion stays.",
            formulation: "Iy' = Iy + s (Iz - Iy), Iz' = Iz + s (Iy - Iz), s = sin²α of a turn by α; s = 1, a quarter turn, is \
                    exact, between them the coupling of the planes by Iyz is left out; s = 0 leaves it. Shear areas and mass \
                    stay.",
            confusable: &["bending-stiffness-change", "stiffness-change", "asymmetry"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.is_wider() {
            return Vec::new();
        }
        structure.places(|p| {
            p.kind != PartKind::Mass
                && [Dof::Ry, Dof::Rz].iter().any(|&dof| structure.part_strains(p, dof))
                && ratio(structure, p).is_some()
        })
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let ratio = ratio(structure, parts[0]).ok_or_else(unknown)?;
        let [y, z] = [Dof::Ry, Dof::Rz].map(|dof| rigidity(structure, parts[0], dof));
        let (y, z) = (y.ok_or_else(unknown)?, z.ok_or_else(unknown)?);
        let mut b = Builder::new(self.name(), at);
        let about = format!("sin² of the angle by which the section of {} is turned, 1: a quarter turn", at.place());
        let typical = round(GAIN / (ratio.max(1.0 / ratio) - 1.0));
        let s = b.parameter("share", "1", typical, [0.0, 1.0], &about);
        let factor = |at_a_quarter: f64| {
            let change = at_a_quarter - 1.0;
            format!("1 {} {}*{s}", if change < 0.0 { '-' } else { '+' }, change.abs())
        };
        let mut scale = entry(y, &factor(ratio));
        scale.extend(entry(z, &factor(1.0 / ratio)));
        b.change("", &entries(&parts), OverrideSpec { scale, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}

/// Iz/Iy of a part, where all of its elements have one and the planes differ.
fn ratio(structure: &Structure<'_>, part: &Part) -> Option<f64> {
    if !part.elements.iter().all(|&e| structure.is_beam(e)) {
        return None;
    }
    let [y, z] = [rigidity(structure, part, Dof::Ry)?, rigidity(structure, part, Dof::Rz)?];
    let of = |e: usize| Some(structure.property(e, z)? / structure.property(e, y)?);
    let first = of(*part.elements.first()?)?;
    let is_one = part.elements.iter().all(|&e| of(e).is_some_and(|r| (r / first - 1.0).abs() < 1e-9));
    (is_one && (ALIKE..FLAT).contains(&first.max(1.0 / first))).then_some(first)
}
