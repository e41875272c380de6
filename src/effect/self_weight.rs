//! Axial forces that the structure's own weight makes.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, of_unit, round};
use super::structure::Structure;
use super::{About, Effect};
use crate::model::AXES;
use crate::model::spec::OverrideSpec;
use indexmap::IndexMap;

/// Standard acceleration of free fall, m/s².
const G: f64 = 9.806_65;
/// Forces below this share of Euler's load of their member change nothing that can be measured.
const FAINT: f64 = 1e-4;
/// Members with forces of their own, at most: each is an entry of the file.
const MOST: usize = 500;

#[doc = "The structure's own weight as a preload: columns that it compresses soften, hangers that it pulls stiffen, each by its own force."]
#[derive(Debug, Clone, Copy)]
pub struct SelfWeight;

impl Effect for SelfWeight {
    fn name(&self) -> &'static str {
        "self-weight"
    }

    fn about(&self) -> About {
        About {
            summary: "The structure's own weight as a preload: columns that it compresses soften, hangers that it pulls \
                    stiffen, each by its own force.",
            signature: "Shifts low bending modes of members along the weight, most where most hangs on them or stands on \
                    them; torsion stays.",
            formulation: "K u = M a along one global axis; each beam takes the mean axial force of that solution as its \
                    `axial_force`, in proportion to the acceleration a; a = 0 leaves it, a = -9.8 m/s² along z is the \
                    weight of what stands upright.",
            confusable: &["axial-preload", "softening", "stiffness-change"],
            references: &[
                "R. W. Clough, J. Penzien, Dynamics of Structures, 2nd ed., 1993, section 10.6",
                "A. Bokaian, Natural frequencies of beams under compressive axial loads, J. Sound and Vibration 126, 1988",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.is_wider() {
            return Vec::new();
        }
        let acts = |axis: &usize| structure.forces_of_acceleration(*axis).is_some_and(|f| matters(structure, f));
        (0..3).filter(acts).map(|axis| Location::whole().along(AXES[axis])).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let axis = AXES.iter().position(|a| *a == at.direction()).ok_or_else(unknown)?;
        let forces = structure.forces_of_acceleration(axis).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("acceleration along {} whose inertia the structure carries", AXES[axis]);
        let a = b.parameter("acceleration", "m/s2", G, [-1.5 * G, 1.5 * G], &about);
        for (k, (names, force)) in by_force(structure, forces).into_iter().enumerate() {
            let add = entry("axial_force", &of_unit(force, "kg", &a));
            b.change(&format!(".{}", k + 1), &names, OverrideSpec { add, ..OverrideSpec::default() });
        }
        Ok(b.finish())
    }
}

/// Mean force of every member of the file that has one, N s²/m, members with the same force together.
fn by_force(structure: &Structure<'_>, forces: &[(usize, f64)]) -> Vec<(Vec<String>, f64)> {
    let mut members: IndexMap<&str, (f64, f64)> = IndexMap::new();
    for &(e, force) in forces {
        let (sum, length) = members.entry(structure.element_of_file(e)).or_default();
        *sum += force * structure.length(e);
        *length += structure.length(e);
    }
    let largest = members.values().map(|(sum, length)| (sum / length).abs()).fold(0.0, f64::max);
    let mut out: IndexMap<u64, Vec<String>> = IndexMap::new();
    for (name, (sum, length)) in members {
        let force = round(sum / length);
        if force.abs() >= 1e-3 * largest {
            out.entry(force.to_bits()).or_default().push(name.to_string());
        }
    }
    out.into_iter().map(|(force, names)| (names, f64::from_bits(force))).collect()
}

/// Whether some member feels it, and not too many do.
fn matters(structure: &Structure<'_>, forces: &[(usize, f64)]) -> bool {
    let feels = |&(e, force): &(usize, f64)| {
        let Some(member) = structure.member_of(e) else { return false };
        let r = structure.rigidity(&member.elements);
        let ei = r.ei.into_iter().filter(|ei| *ei > 0.0).fold(f64::INFINITY, f64::min);
        let euler = std::f64::consts::PI.powi(2) * ei / r.length.powi(2);
        euler.is_finite() && (force * G).abs() > FAINT * euler
    };
    forces.iter().any(feels) && by_force(structure, forces).len() <= MOST
}
