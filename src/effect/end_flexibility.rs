//! The patch of every effect that puts a spring between a member's end and its node.

use super::edit::PatchError;
use super::flow::number;
use super::location::{ABOUT, ALL_AXES, BENDING, Location, LocationKind};
use super::patch::{Builder, Patch, entry};
use super::structure::{End, Joint, Structure};
use crate::element::Dof;
use crate::model::AXES;
use crate::model::spec::{Named, OverrideSpec};
use crate::units::Scalar;

/// Largest compliance against that of the member: a hundred times it is a hinge of a slender one, and a short one may carry so much mass that it moves
/// on a joint ten times as soft below the first mode of the rest.
const HINGE: f64 = 1000.0;

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
    let ends = match (at.kind, Dof::from_name(at.direction())) {
        (LocationKind::Group, Some(dof)) => at.names.iter().flat_map(|n| structure.connections_of(n, dof)).collect(),
        _ => at.names.iter().map(|n| structure.end(n).ok_or_else(unknown)).collect::<Result<Vec<_>, _>>()?,
    };
    let first = ends.first().ok_or_else(unknown)?;
    if let Some(axis) = ABOUT.iter().position(|about| *about == at.direction()) {
        return Ok(hinged_end(effect, structure, at, (&ends, axis)));
    }
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
        sizes.push((dof, b.parameter(&name, dof.compliance_unit(), 0.05 * own, [0.0, HINGE * own], &about)));
    }
    change_ends(&mut b, structure, &ends, |end| {
        sizes.iter().flat_map(|(dof, c)| entry(&format!("end{}_compliance_{dof}", end.side), c)).collect()
    });
    Ok(b.finish())
}

/// A compliance about one of the structure's own axes, x, y or z, at ends whose members have none along it. Typical is as about the axes of the member,
/// each by its share.
fn hinged_end(effect: &str, structure: &Structure<'_>, at: &Location, (ends, axis): (&[&End], usize)) -> Patch {
    // To a micrometre per metre.
    let local = |end: &End| structure.model().elements()[end.element].axes.map(|own| (1e6 * own[axis]).round() / 1e6);
    let first = ends[0];
    let r = structure.rigidity(structure.member_of(first.element).map_or(&[first.element][..], |m| &m.elements));
    let shares = local(first).into_iter().zip([r.gj, r.ei[0], r.ei[1]]).filter(|(n, _)| *n != 0.0);
    let own: f64 = shares.map(|(n, k)| n * n * r.length / k).sum();
    let mut b = Builder::new(effect, at);
    let about = format!("compliance of the joint at {} about {} of the structure", at.place(), AXES[axis]);
    let c = b.parameter("compliance", Dof::Rx.compliance_unit(), 0.05 * own, [0.0, HINGE * own], &about);
    change_ends(&mut b, structure, ends, |end| {
        let axes = local(end).into_iter().zip(AXES).filter(|(n, _)| *n != 0.0);
        let axes = axes.flat_map(|(n, name)| entry(&format!("end{}_hinge_{name}", end.side), &number(n)));
        entry(&format!("end{}_hinge_compliance", end.side), &c).into_iter().chain(axes).collect()
    });
    b.finish()
}

/// Adds properties to the elements of ends: one override for all to which the same is added.
fn change_ends(b: &mut Builder, structure: &Structure<'_>, ends: &[&End], of: impl Fn(&End) -> Named<Scalar>) {
    let mut changes: Vec<(Named<Scalar>, Vec<String>)> = Vec::new();
    for end in ends {
        let (add, element) = (of(end), structure.element_of_file(end.element).to_string());
        match changes.iter_mut().find(|(known, _)| *known == add) {
            Some((_, elements)) => elements.push(element),
            None => changes.push((add, vec![element])),
        }
    }
    let several = changes.len() > 1;
    for (i, (add, elements)) in changes.into_iter().enumerate() {
        let suffix = if several { format!(".{}", i + 1) } else { String::new() };
        b.change(&suffix, &elements, OverrideSpec { add, ..OverrideSpec::default() });
    }
}
