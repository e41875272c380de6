//! The patch of every effect that puts a spring between a member's end and its node.

use super::edit::PatchError;
use super::location::{ALL_AXES, BENDING, Location};
use super::patch::{Builder, Patch, entry};
use super::structure::{Joint, Structure};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

/// A compliance at the ends that a location names, in the direction that it names; two for both directions of bending, and one for
/// each in which a support holds the end for all of them.
///
/// Typical is a twentieth of the member's own compliance as a cantilever in that direction: L/EI, L/GJ, L³/(3 EI), L/EA; or of what is soft for
/// the whole structure, where that is more and `least` says so.
pub(super) fn flexible_end(
    effect: &str,
    structure: &Structure<'_>,
    at: &Location,
    least: impl Fn(Dof) -> f64,
) -> Result<Patch, PatchError> {
    let unknown = || PatchError::unknown_place(effect, &at.to_string(), &[]);
    let ends = at.names.iter().map(|n| structure.end(n).ok_or_else(unknown)).collect::<Result<Vec<_>, _>>()?;
    let first = ends.first().ok_or_else(unknown)?;
    let is_held = |dof: &Dof| first.joint[*dof as usize] == Some(Joint::Root);
    let dofs = match at.direction() {
        ALL_AXES => Dof::ALL.into_iter().filter(is_held).collect(),
        BENDING => vec![Dof::Ry, Dof::Rz],
        dof => vec![Dof::from_name(dof).ok_or_else(unknown)?],
    };
    let r = structure.rigidity(&structure.member_of(first.element).ok_or_else(unknown)?.elements);
    let (l, [eiy, eiz]) = (r.length, r.ei);
    let mut b = Builder::new(effect, at);
    let mut sizes = Vec::new();
    for &dof in &dofs {
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
        let own = own.max(least(dof));
        let name = if dofs.len() > 1 { format!("compliance_{dof}") } else { "compliance".to_string() };
        let about = format!("compliance of the joint at {} in {} of the member", at.place(), dof);
        sizes.push((dof, b.parameter(&name, dof.compliance_unit(), 0.05 * own, [0.0, 50.0 * own], &about)));
    }
    for (i, end) in ends.iter().enumerate() {
        let element = structure.element_of_file(end.element).to_string();
        let property = |dof: Dof| format!("end{}_compliance_{dof}", end.side);
        let add = sizes.iter().flat_map(|(dof, c)| entry(&property(*dof), c)).collect();
        let suffix = if ends.len() > 1 { format!(".{}", i + 1) } else { String::new() };
        b.change(&suffix, &[element], OverrideSpec { add, ..OverrideSpec::default() });
    }
    Ok(b.finish())
}
