//! The patch of every effect that puts a spring between a member's end and its node.

use super::location::Location;
use super::patch::{Builder, Patch, PatchError, entry};
use super::structure::Structure;
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// A compliance at the ends that a location names, in the direction that it names.
///
/// Typical is a twentieth of the member's own compliance as a cantilever in that direction: L/EI, L/GJ, L³/(3 EI), L/EA.
pub(super) fn flexible_end(effect: &str, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
    let unknown = || PatchError::unknown_place(effect, &at.to_string(), &[]);
    let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
    let ends = at.names.iter().map(|n| structure.end(n).ok_or_else(unknown)).collect::<Result<Vec<_>, _>>()?;
    let first = ends.first().ok_or_else(unknown)?;
    let r = structure.rigidity(&structure.member_of(first.element).ok_or_else(unknown)?.elements);
    let (l, [eiy, eiz]) = (r.length, r.ei);
    let own = match dof {
        Dof::Ux => l / r.ea,
        Dof::Uy => l.powi(3) / (3.0 * eiz),
        Dof::Uz => l.powi(3) / (3.0 * eiy),
        Dof::Rx => l / r.gj,
        Dof::Ry => l / eiy,
        Dof::Rz => l / eiz,
    };
    if !own.is_finite() {
        return Err(unknown());
    }
    let unit = if dof.is_rotation() { "rad/(N m)" } else { "m/N" };
    let mut b = Builder::new(effect, at);
    let about = format!("compliance of the joint at {} in {} of the member", at.place(), dof);
    let c = b.parameter("compliance", unit, 0.05 * own, [0.0, 50.0 * own], &about);
    for (i, end) in ends.iter().enumerate() {
        let element = structure.element_of_file(end.element).to_string();
        let property = format!("end{}_compliance_{dof}", end.side);
        let suffix = if ends.len() > 1 { format!(".{}", i + 1) } else { String::new() };
        b.change(&suffix, &[element], OverrideSpec { add: entry(&property, &c), ..OverrideSpec::default() });
    }
    Ok(b.finish())
}
