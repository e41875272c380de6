//! Properties that vary along a chain.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch, entry, times};
use super::structure::{Part, PartKind, Structure};
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
        let chain = |p: &Part| p.is_member && p.elements.len() > 1 && p.kind != PartKind::Element;
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
            let sign = if reversed { -1.0 } else { 1.0 };
            let suffix = if parts.len() > 1 { format!(".{}", i + 1) } else { String::new() };
            if part.kind == PartKind::Chain {
                let taper = entry(property, &times(sign, &t));
                b.change(&suffix, &part.of, OverrideSpec { taper, ..OverrideSpec::default() });
                continue;
            }
            for (k, (name, s)) in along(structure, part).into_iter().enumerate() {
                let (operator, s) = if sign * s < 0.0 { ("-", -sign * s) } else { ("+", sign * s) };
                let factor = format!("1 {operator} {}", times(s, &t));
                let change = match property {
                    "mass" => OverrideSpec { mass: Some(scalar(&factor)), ..OverrideSpec::default() },
                    _ => OverrideSpec { scale: entry(property, &factor), ..OverrideSpec::default() },
                };
                b.change(&format!("{suffix}.{}", k + 1), &[name], change);
            }
        }
        Ok(b.finish())
    }
}

/// The elements of a line as the file has them, with s at their middle, to four digits.
fn along(structure: &Structure<'_>, part: &Part) -> Vec<(String, f64)> {
    let mut pieces: Vec<(&str, f64)> = Vec::new();
    for e in structure.path(&part.elements).unwrap_or_default() {
        let (name, length) = (structure.element_of_file(e), structure.length(e));
        match pieces.last_mut().filter(|(last, _)| *last == name) {
            Some((_, l)) => *l += length,
            None => pieces.push((name, length)),
        }
    }
    let total: f64 = pieces.iter().map(|(_, l)| l).sum();
    let mut before = 0.0;
    let middle = |(name, length): (&str, f64)| {
        let s = (2.0 * before + length) / total - 1.0;
        before += length;
        (name.to_string(), (1e4 * s).round() / 1e4)
    };
    pieces.into_iter().map(middle).collect()
}
