//! What kind of motion a mode is: where its strain energy sits, which way it moves, whether it is symmetric.

use super::dof_map::DofMap;
use super::geometry::{Geometry, NEAR_IMAGE, dot, images, minus};
use super::value::quantity;
use crate::element::Dof;
use std::collections::BTreeMap;

/// Shares of strain energy and direction of motion of one mode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ModeCharacter {
    /// Correlation of the shape with its mirror image: 1 symmetric, -1 antisymmetric; `None` without a symmetry plane.
    pub symmetry: Option<f64>,
    /// Share of strain energy in bending.
    pub bending: f64,
    /// Share of strain energy in torsion.
    pub torsion: f64,
    /// Share of strain energy in extension.
    pub axial: f64,
    /// How far what is stretched moves along itself, cos² by its energy: 1 of a bar that extends, ½ of braces at 45° and 0 of the chords of a
    /// truss that bends.
    pub along: f64,
    /// Share of strain energy in springs and bushings.
    pub springs: f64,
    /// Share of strain energy in superelements, shells and solids, whose kinds of strain are not told apart.
    pub matrices: f64,
    /// Share of motion (sum of squares of displacements of the sections at nodes, on the line of their mass) along each global
    /// axis.
    pub direction: [f64; 3],
    /// Whether several directions of displacement exist in the model, so that the direction is worth naming.
    pub names_direction: bool,
    /// Whether it is a rigid-body mode.
    pub is_rigid: bool,
    /// Whether it is a mechanism: no rigid-body mode, and nothing is strained.
    pub is_mechanism: bool,
}

/// A name for a mode by its kind and its number within the kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModeLabel {
    /// `symmetric`, `antisymmetric`, or `None`.
    pub family: Option<&'static str>,
    /// `S1B`
    pub short: String,
    /// `Sym 1st Bending`
    pub long: String,
}

/// Below this correlation with the mirror image a mode is neither symmetric nor antisymmetric.
const SYMMETRY_THRESHOLD: f64 = 0.5;
/// From so far on what is stretched extends; else the structure that it belongs to sways or bends.
const ALONG: f64 = 0.75;

impl ModeCharacter {
    /// `symmetric`, `antisymmetric`, or `None`.
    pub fn family(&self) -> Option<&'static str> {
        family(self.symmetry?)
    }

    fn kind(&self) -> (&'static str, &'static str) {
        let most = (0..3).max_by(|&a, &b| self.direction[a].total_cmp(&self.direction[b])).unwrap_or(2);
        if self.is_rigid {
            ("R", "Rigid Body")
        } else if self.is_mechanism {
            ("F", "Mechanism")
        } else if self.torsion > 0.5 {
            ("T", "Torsion")
        } else if self.axial > 0.5 && (self.along > ALONG || !self.names_direction) {
            ("X", "Extension")
        } else if self.axial > 0.5 {
            [("WX", "Fore-aft Sway"), ("WY", "Lateral Sway"), ("BZ", "Vertical Bending")][most]
        } else if self.springs > 0.5 {
            ("K", "on Springs")
        } else if self.matrices > 0.5 {
            if self.names_direction {
                [("MX", "Fore-aft Mode"), ("MY", "Lateral Mode"), ("MZ", "Vertical Mode")][most]
            } else {
                ("M", "Mode")
            }
        } else if self.names_direction {
            [("BX", "Fore-aft Bending"), ("BY", "Lateral Bending"), ("BZ", "Vertical Bending")][most]
        } else {
            ("B", "Bending")
        }
    }
}

/// `symmetric`, `antisymmetric` or neither, from the correlation with the mirror image.
pub fn family(symmetry: f64) -> Option<&'static str> {
    if symmetry > SYMMETRY_THRESHOLD {
        Some("symmetric")
    } else if symmetry < -SYMMETRY_THRESHOLD {
        Some("antisymmetric")
    } else {
        None
    }
}

/// Names modes in the order given: `Sym 1st Bending`, `Anti 2nd Torsion`; each kind counts for itself.
pub fn label_modes(characters: &[ModeCharacter]) -> Vec<ModeLabel> {
    let mut counts: Vec<((Option<&str>, &str), usize)> = Vec::new();
    characters
        .iter()
        .map(|c| {
            let (letter, word) = c.kind();
            let family = c.family();
            let key = (family, word);
            let seen = counts.iter().position(|(k, _)| *k == key).unwrap_or_else(|| {
                counts.push((key, 0));
                counts.len() - 1
            });
            counts[seen].1 += 1;
            let n = counts[seen].1;
            let (f, family_word) = match family {
                Some("symmetric") => ("S", "Sym "),
                Some(_) => ("A", "Anti "),
                None => ("", ""),
            };
            ModeLabel { family, short: format!("{f}{n}{letter}"), long: format!("{family_word}{} {word}", ordinal(n)) }
        })
        .collect()
}

fn ordinal(n: usize) -> String {
    let suffix = match (n % 10, n % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{n}{suffix}")
}

/// What the plane of symmetry makes of a model.
#[derive(Debug)]
pub(super) struct Reflection {
    /// Row -> (row of the mirror image, sign), or why there is none for some row.
    pub(super) rows: Result<Vec<(usize, f64)>, String>,
    /// How far the halves differ, where that is more than rounding of coordinates.
    pub(super) difference: Option<String>,
}

/// The rows and their mirror images; `None` without a plane of symmetry.
pub(super) fn mirror_rows(geometry: &Geometry, dofs: &DofMap) -> Option<Reflection> {
    /// Of the size of the structure: coordinates are written with as many digits.
    const ROUNDING: f64 = 1e-6;
    let (axis, _) = geometry.mirror?;
    let positions = dofs.positions();
    if let Some(node) = (0..positions.len()).find(|&n| geometry.is_coordinate(n)) {
        let why = format!("`{}` is a coordinate of a superelement, which has no mirror image", geometry.names[node]);
        return Some(Reflection { rows: Err(why), difference: None });
    }
    let images = images(positions, |p| geometry.mirrored(p));
    let row_of: BTreeMap<(usize, usize), usize> =
        dofs.rows().iter().enumerate().map(|(row, &(node, dof))| ((node, dof as usize), row)).collect();
    let name = |node: usize| &geometry.names[node];
    let off = |node: usize, other: usize| {
        let place = geometry.mirrored(positions[node]).unwrap_or_default();
        let d = minus(positions[other], place);
        dot(d, d).sqrt()
    };
    let size = geometry.size();
    let image = |&(node, dof): &(usize, Dof)| {
        let partner = images[node].ok_or_else(|| {
            let place = geometry.mirrored(positions[node]).unwrap_or_default().map(|x| x + 0.0);
            let nearest = (0..positions.len()).min_by(|&a, &b| off(node, a).total_cmp(&off(node, b))).unwrap_or(node);
            format!(
                "no node stands at the mirror image of `{}`, {place:?} m; the nearest, `{}`, is {} off, and {} would do",
                name(node),
                name(nearest),
                quantity(off(node, nearest), "m"),
                quantity(NEAR_IMAGE * size, "m")
            )
        })?;
        let row = row_of.get(&(partner, dof as usize)).ok_or_else(|| {
            format!("`{}` moves along {}, and its mirror image `{}` does not", name(node), dof.name(), name(partner))
        })?;
        // Displacements flip along the normal; rotations flip about the other two axes.
        let flips = (dof.axis() == axis) != dof.is_rotation();
        Ok((*row, if flips { -1.0 } else { 1.0 }))
    };
    let pairs =
        images.iter().enumerate().filter_map(|(node, image)| image.map(|other| (node, other, off(node, other))));
    let farthest = pairs.max_by(|a, b| a.2.total_cmp(&b.2).then(b.0.cmp(&a.0)));
    let difference = farthest.filter(|(_, _, off)| *off > ROUNDING * size).map(|(node, other, off)| {
        format!(
            "the halves differ by up to {}: `{}` stands that far from the mirror image of `{}`; they count as symmetric",
            quantity(off, "m"),
            name(other),
            name(node)
        )
    });
    Some(Reflection { rows: dofs.rows().iter().map(image).collect(), difference })
}

/// Correlation of a shape with its mirror image.
pub fn symmetry_index(mirror: &[(usize, f64)], shape: impl Fn(usize) -> f64) -> f64 {
    let (mut cross, mut own) = (0.0, 0.0);
    for (row, &(partner, sign)) in mirror.iter().enumerate() {
        cross += shape(row) * sign * shape(partner);
        own += shape(row) * shape(row);
    }
    if own > 0.0 { cross / own } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_counted_within_their_kind() {
        let bending = |s: f64| ModeCharacter { symmetry: Some(s), bending: 1.0, ..ModeCharacter::default() };
        let torsion = |s: f64| ModeCharacter { symmetry: Some(s), torsion: 0.8, ..ModeCharacter::default() };
        let labels = label_modes(&[bending(1.0), bending(-1.0), torsion(1.0), bending(0.9), torsion(0.1)]);
        let short: Vec<&str> = labels.iter().map(|l| l.short.as_str()).collect();
        assert_eq!(short, ["S1B", "A1B", "S1T", "S2B", "1T"]);
        assert_eq!(labels[3].long, "Sym 2nd Bending");
        assert_eq!(labels[4].long, "1st Torsion");
    }

    #[test]
    fn ordinals() {
        assert_eq!([1, 2, 3, 4, 11, 12, 21, 113].map(ordinal).join(" "), "1st 2nd 3rd 4th 11th 12th 21st 113th");
    }
}
