//! Properties that vary along a chain.

use super::location::Location;
use super::patch::{Builder, Patch, PatchError, entry, times};
use super::structure::{PartKind, Structure};
use super::torsion_stiffness_change::rigidity;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "A linear variation of bending or torsional stiffness, or of mass, along a chain that the model has as uniform (or wrongly tapered)."]
#[derive(Debug, Clone, Copy)]
pub struct Taper;

impl Effect for Taper {
    fn name(&self) -> &'static str {
        "taper"
    }

    fn about(&self) -> About {
        About {
            summary: "A linear variation of bending or torsional stiffness, or of mass, along a chain that the model \
                    has as uniform (or wrongly tapered).",
            signature: "A smooth change of shapes; the frequencies of one family shift by different amounts in a smooth \
                    order.",
            formulation: "The property of each element is multiplied by 1 + t s at its middle, s from -1 at the start of \
                    the chain to +1 at its end, so the mean stays; t = 0 leaves it.",
            confusable: &["stiffness-change", "bending-stiffness-change", "distributed-mass"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979, section 8.2",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        let chain = |p: &super::Part| p.kind == PartKind::Chain && p.elements.len() > 1 && structure.is_member(p);
        for dof in [Dof::Ry, Dof::Rz, Dof::Rx] {
            let chains = structure
                .places(|p| chain(p) && structure.part_strains(p, dof) && rigidity(structure, p, dof).is_some());
            all.extend(chains.into_iter().map(|at| at.along(dof.name())));
        }
        let heavy = structure.places(|p| chain(p) && p.elements.iter().any(|&e| structure.is_heavy(e)));
        all.extend(heavy.into_iter().map(|at| at.along("mass")));
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let property = match Dof::from_name(at.direction()) {
            Some(dof) => rigidity(structure, parts[0], dof).ok_or_else(unknown)?,
            None => "mass",
        };
        let mut b = Builder::new(self.name(), at);
        let what = ["bending stiffness", "torsional stiffness", "mass"]
            [if property == "mass" { 2 } else { usize::from(at.direction() == "rx") }];
        let about =
            format!("linear variation of the {what} along {}, relative, from the middle to its end", at.place());
        let t = b.parameter("slope", "1", 0.2, [-0.9, 0.9], &about);
        for (i, part) in parts.iter().enumerate() {
            // The partner may run the other way.
            let reversed = i > 0 && structure.image(parts[0].elements[0]) != part.elements.first().copied();
            let taper = entry(property, &times(if reversed { -1.0 } else { 1.0 }, &t));
            let suffix = if parts.len() > 1 { format!(".{}", i + 1) } else { String::new() };
            b.change(&suffix, std::slice::from_ref(&part.name), OverrideSpec { taper, ..OverrideSpec::default() });
        }
        Ok(b.finish())
    }
}
