//! A mass axis that is not the elastic axis.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, times};
use super::structure::{Part, PartKind, Structure};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::{Named, OverrideSpec};

#[doc = "The centres of gravity of a member's sections, or of the bodies on it, lie beside the elastic axis: inertial bend-twist coupling."]
#[derive(Debug, Clone, Copy)]
pub struct MassOffset;

impl Effect for MassOffset {
    fn name(&self) -> &'static str {
        "mass-offset"
    }

    fn about(&self) -> About {
        About {
            summary: "The centres of gravity of a member's sections, or of the bodies on it, lie beside the elastic \
                    axis: inertial bend-twist coupling.",
            signature: "Bending modes gain twist in proportion to the inertia, nodal lines turn; frequencies of bending \
                    and torsion repel each other, to second order where the structure is symmetric.",
            formulation: "The mass axis of the beams lies e along their y (or z) by `mass_offset_y`, and the bodies on \
                    them by their `offset`: M gains m e (ẇ φ̇) and m e² φ̇². e = 0 leaves it. `y_lumps` moves the \
                    bodies only, `y_all` both; a single body moves along its own x, y, z.",
            confusable: &["bend-twist-coupling", "point-rotary-inertia", "asymmetry"],
            references: &[
                "R. L. Bisplinghoff, H. Ashley, R. L. Halfman, Aeroelasticity, 1955, section 3.7",
                "D. H. Hodges, G. A. Pierce, Introduction to Structural Dynamics and Aeroelasticity, 2011",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for (i, axis) in ["y", "z"].into_iter().enumerate() {
            let couples = |p: &Part| couples(structure, p, i + 1);
            let distributed = |p: &Part| couples(p) && structure.rigidity(&p.elements).mass > 0.0;
            let carries = |p: &Part| couples(p) && !heavy_lumps(structure, p).is_empty();
            // One body alone is a place of its own.
            let lumped = |p: &Part| couples(p) && heavy_lumps(structure, p).len() > 1;
            for (word, members) in [
                (axis.to_string(), structure.members(distributed)),
                (format!("{axis}_lumps"), structure.members(lumped)),
                (format!("{axis}_all"), structure.members(|p| distributed(p) && carries(p))),
            ] {
                all.extend(members.into_iter().map(|at| at.along(&word)));
            }
        }
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let bodies = structure.places(|p| {
                p.kind == PartKind::Mass
                    && couples(structure, p, i)
                    && structure.property(p.elements[0], "mass").is_some_and(|m| m > 0.0)
            });
            all.extend(bodies.into_iter().map(|at| at.along(axis)));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let (axis_word, what) = at.direction().split_once('_').unwrap_or((at.direction(), ""));
        let axis = ["x", "y", "z"].iter().position(|a| *a == axis_word).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let is_body = parts[0].kind == PartKind::Mass;
        let size = if is_body { 0.4 * structure.extent() } else { structure.rigidity(&parts[0].elements).length };
        let toward =
            structure.model().elements()[parts[0].elements[0]].axes[axis].map(|c| (100.0 * c).round() / 100.0 + 0.0);
        let about =
            format!("centres of gravity beside the axis of {}, along {toward:?} of {}", at.place(), parts[0].name);
        let e = b.parameter("offset", "m", 0.05 * size, [-0.25 * size, 0.25 * size], &about);
        for (i, part) in parts.iter().enumerate() {
            let sign = if i == 0 { 1.0 } else { structure.image_sign(parts[0], axis) };
            let suffix = if parts.len() > 1 { format!(".{}", i + 1) } else { String::new() };
            if is_body {
                let add = entry(&format!("offset_{axis_word}"), &times(sign, &e));
                b.change(&suffix, std::slice::from_ref(&part.name), OverrideSpec { add, ..OverrideSpec::default() });
                continue;
            }
            if what != "lumps" {
                for (k, (names, sign)) in structure.runs(part, axis, sign).into_iter().enumerate() {
                    let piece = if k == 0 { String::new() } else { format!(".piece{}", k + 1) };
                    let add = entry(&format!("mass_offset_{axis_word}"), &times(sign, &e));
                    b.change(&format!("{suffix}{piece}"), &names, OverrideSpec { add, ..OverrideSpec::default() });
                }
            }
            if !what.is_empty() {
                for (k, (names, add)) in lump_offsets(structure, part, axis, sign, &e).into_iter().enumerate() {
                    let piece = if k == 0 { String::new() } else { (k + 1).to_string() };
                    b.change(
                        &format!("{suffix}.lumps{piece}"),
                        &names,
                        OverrideSpec { add, ..OverrideSpec::default() },
                    );
                }
            }
        }
        Ok(b.finish())
    }
}

/// Whether an offset along an axis of the part couples a motion with a rotation: the velocity of the cg is u + r × e.
fn couples(structure: &Structure<'_>, part: &Part, axis: usize) -> bool {
    let moves = |d: usize| structure.part_moves(part, Dof::ALL[d]);
    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
    // e along x: r_y moves it along z, r_z along y.
    moves(third) && moves(3 + second) || moves(second) && moves(3 + third)
}

/// The bodies with mass that a member carries: on its nodes, but not on a body that it shares with its symmetric partner, nor
/// where it is mounted on springs to ground.
fn heavy_lumps<'s>(structure: &'s Structure<'_>, part: &Part) -> Vec<&'s Part> {
    let elements = structure.model().elements();
    let partner = part.partner.map(|j| &structure.parts()[j]);
    let carried = |m: usize| {
        let node = elements[m].nodes[0];
        let shared = partner.is_some_and(|p| {
            p.elements.iter().flat_map(|&e| &elements[e].nodes).any(|&other| structure.same_body(node, other))
        });
        structure.property(m, "mass").is_some_and(|m| m > 0.0) && !shared && !structure.is_mounted(node)
    };
    structure.lumps_on(&part.elements).into_iter().filter(|l| l.elements.iter().all(|&m| carried(m))).collect()
}

/// Offsets of the bodies on a member along an axis of its first element, in the axes of each body; bodies with the same
/// numbers together.
fn lump_offsets(
    structure: &Structure<'_>,
    part: &Part,
    axis: usize,
    sign: f64,
    parameter: &str,
) -> Vec<(Vec<String>, Named<crate::units::Scalar>)> {
    let elements = structure.model().elements();
    let direction = elements[part.elements[0]].axes[axis];
    let mut all: Vec<(Vec<String>, Named<crate::units::Scalar>)> = Vec::new();
    for lump in heavy_lumps(structure, part) {
        let mut add = Named::new();
        for (k, word) in ["x", "y", "z"].into_iter().enumerate() {
            let cosine: f64 = elements[lump.elements[0]].axes[k].iter().zip(direction).map(|(a, b)| a * b).sum();
            if cosine.abs() > 1e-9 {
                // Twelve digits: an angle read from a drawing has four.
                let cosine: f64 = format!("{:.11e}", sign * cosine).parse().unwrap_or(sign * cosine);
                add.extend(entry(&format!("offset_{word}"), &times(cosine, parameter)));
            }
        }
        match all.iter_mut().find(|(_, a)| *a == add) {
            Some((names, _)) => names.push(lump.name.clone()),
            None => all.push((vec![lump.name.clone()], add)),
        }
    }
    all
}
