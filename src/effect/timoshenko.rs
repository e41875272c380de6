//! Shear deformation and rotary inertia of sections whose sizes are known.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, of_unit};
use super::structure::{Part, Structure};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// Shear correction factor of a solid rectangle, and within a tenth that of a solid circle.
const KAPPA: f64 = 5.0 / 6.0;
/// The most that thin walls make of it.
const MOST: f64 = 3.0;

#[doc = "Members that the model has as Euler-Bernoulli beams, though their sections are stout: shear deformation and rotary inertia together."]
#[derive(Debug, Clone, Copy)]
pub struct Timoshenko;

impl Effect for Timoshenko {
    fn name(&self) -> &'static str {
        "timoshenko"
    }

    fn about(&self) -> About {
        About {
            summary: "Members that the model has as Euler-Bernoulli beams, though their sections are stout: shear \
                    deformation and rotary inertia together.",
            signature: "Lowers bending modes, the higher the more, in both planes by what the section says; torsion and \
                    stretching stay.",
            formulation: "c = s/(κ G A) with κ = 5/6, and rotary inertia j = s ρ I, in both planes of bending; s = 0 is \
                    Euler and Bernoulli, s = 1 the solid section, s up to 3 thin walls.",
            confusable: &["shear-flexibility", "section-rotary-inertia", "axial-preload"],
            references: &[
                "S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic bars, 1921",
                "G. R. Cowper, The shear coefficient in Timoshenko's beam theory, 1966",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let is_known = |p: &Part| p.elements.iter().all(|&e| Known::of(structure, e).is_some());
        let mut all = structure.members(is_known);
        let beams = || (0..structure.model().elements().len()).filter(|&e| structure.is_beam(e) && bends(structure, e));
        if all.len() > 1 && beams().all(|e| Known::of(structure, e).is_some()) && !structure.is_wider() {
            all.push(Location::whole());
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let elements: Vec<usize> = if at.names.is_empty() {
            (0..structure.model().elements().len()).filter(|&e| structure.is_beam(e) && bends(structure, e)).collect()
        } else {
            structure.parts_at(self.name(), at)?.into_iter().flat_map(|p| p.elements.clone()).collect()
        };
        // One entry for all elements of one section.
        let mut sections: Vec<(Known, Vec<String>)> = Vec::new();
        for e in elements {
            let known = Known::of(structure, e).ok_or_else(unknown)?;
            let name = structure.element_of_file(e).to_string();
            match sections.iter_mut().find(|(k, _)| *k == known) {
                Some((_, names)) if names.last() == Some(&name) => {}
                Some((_, names)) => names.push(name),
                None => sections.push((known, vec![name])),
            }
        }
        let mut b = Builder::new(self.name(), at);
        let about = format!("shear and rotary inertia of {}, as parts of those of solid sections", at.place());
        let s = b.parameter("share", "1", 1.0, [0.0, MOST], &about);
        for (k, (known, names)) in sections.iter().enumerate() {
            let mut add = entry("shear_compliance_y", &of_unit(known.compliance, "1/N", &s));
            add.extend(entry("shear_compliance_z", &of_unit(known.compliance, "1/N", &s)));
            add.extend(entry("rotary_inertia_y", &of_unit(known.rotary[0], "kg m", &s)));
            add.extend(entry("rotary_inertia_z", &of_unit(known.rotary[1], "kg m", &s)));
            let suffix = if sections.len() > 1 { format!(".{}", k + 1) } else { String::new() };
            b.change(&suffix, names, OverrideSpec { add, ..OverrideSpec::default() });
        }
        Ok(b.finish())
    }
}

fn bends(structure: &Structure<'_>, e: usize) -> bool {
    structure.strains(e, Dof::Ry) || structure.strains(e, Dof::Rz)
}

/// What a section says of shear and rotary inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Known {
    /// 1/(κ G A), 1/N.
    compliance: f64,
    /// ρ Iy and ρ Iz, kg m.
    rotary: [f64; 2],
}

impl Known {
    /// Of a beam that bends, that gives area, inertias and moduli, and that has neither shear nor rotary inertia.
    fn of(structure: &Structure<'_>, e: usize) -> Option<Self> {
        let get = |name: &str| structure.property(e, name);
        let has = |name: &str| get(name).is_some_and(|v| v != 0.0);
        let is_stout = ["kappa_y", "kappa_z", "shear_compliance_y", "shear_compliance_z"].into_iter().any(has)
            || has("rotary_inertia_y")
            || has("rotary_inertia_z");
        if is_stout || !structure.is_beam(e) || !bends(structure, e) {
            return None;
        }
        let area = get("A")?;
        let g = get("G").or_else(|| Some(get("E")? / (2.0 * (1.0 + get("nu")?))))?;
        let density = get("density").or_else(|| Some(get("mass_per_length")? / area))?;
        let own = Self { compliance: 1.0 / (KAPPA * g * area), rotary: [density * get("Iy")?, density * get("Iz")?] };
        (own.compliance.is_finite() && own.compliance > 0.0 && density > 0.0).then_some(own)
    }
}
