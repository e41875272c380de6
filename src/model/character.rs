//! What kind of motion a mode is: where its strain energy sits, which way it moves, whether it is symmetric.

use super::compile::Model;
use super::dof_map::DofMap;
use super::geometry::{Geometry, images};
use super::{ModelError, ParametricModel};
use crate::element::{Axes, Dof};
use crate::linalg::DMatrix;
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
    /// Share of strain energy in springs and bushings.
    pub springs: f64,
    /// Share of motion (sum of squares of displacements at nodes) along each global axis.
    pub direction: [f64; 3],
    /// Whether several directions of displacement exist in the model, so that the direction is worth naming.
    pub names_direction: bool,
    /// Whether it is a rigid-body mode.
    pub is_rigid: bool,
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

impl ModeCharacter {
    /// `symmetric`, `antisymmetric`, or `None`.
    pub fn family(&self) -> Option<&'static str> {
        family(self.symmetry?)
    }

    fn kind(&self) -> (&'static str, &'static str) {
        if self.is_rigid {
            ("R", "Rigid Body")
        } else if self.torsion > 0.5 {
            ("T", "Torsion")
        } else if self.axial > 0.5 {
            ("X", "Extension")
        } else if self.springs > 0.5 {
            ("K", "on Springs")
        } else if self.names_direction {
            let most = (0..3).max_by(|&a, &b| self.direction[a].total_cmp(&self.direction[b])).unwrap_or(2);
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

/// Row -> (row of the mirror image, sign), for every row, or which row has no image; `None` without a plane of symmetry.
pub(super) fn mirror_rows(geometry: &Geometry, dofs: &DofMap) -> Option<Result<Vec<(usize, f64)>, String>> {
    let (axis, _) = geometry.mirror?;
    let images = images(dofs.positions(), |p| geometry.mirrored(p));
    let row_of: BTreeMap<(usize, usize), usize> =
        dofs.rows().iter().enumerate().map(|(row, &(node, dof))| ((node, dof as usize), row)).collect();
    let name = |node: usize| &geometry.names[node];
    let image = |&(node, dof): &(usize, Dof)| {
        let partner = images[node].ok_or_else(|| {
            let place = geometry.mirrored(dofs.positions()[node]).unwrap_or_default().map(|x| x + 0.0);
            format!("no node stands at the mirror image of `{}`, {place:?} m", name(node))
        })?;
        let row = row_of.get(&(partner, dof as usize)).ok_or_else(|| {
            format!("`{}` moves along {}, and its mirror image `{}` does not", name(node), dof.name(), name(partner))
        })?;
        // Displacements flip along the normal; rotations flip about the other two axes.
        let flips = (dof.axis() == axis) != dof.is_rotation();
        Ok((*row, if flips { -1.0 } else { 1.0 }))
    };
    Some(dofs.rows().iter().map(image).collect())
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

/// The characters of shapes of a model at θ, the first `n_rigid` of them rigid-body modes.
pub(super) fn characters(
    model: &Model,
    theta: &[f64],
    shapes: &DMatrix<f64>,
    n_rigid: usize,
) -> Result<Vec<ModeCharacter>, ModelError> {
    let mut energies = vec![[0.0; 4]; shapes.ncols()]; // axial, bending, torsion, springs
    for (i, e) in model.elements().iter().enumerate() {
        let k = model.element_matrices(i, theta)?.stiffness;
        if k.is_zero() {
            continue;
        }
        for (energy, q) in energies.iter_mut().zip(shapes.column_iter()) {
            let u = model.element_displacements(i, q.as_slice());
            let part = |dofs: &[usize]| -> f64 {
                let mut sum = 0.0;
                for node in 0..e.nodes.len() {
                    for other in 0..e.nodes.len() {
                        for &a in dofs {
                            for &b in dofs {
                                sum += u[6 * node + a] * k.get(6 * node + a, 6 * other + b) * u[6 * other + b];
                            }
                        }
                    }
                }
                sum
            };
            match e.kind.axes() {
                Axes::AlongNodes => {
                    energy[0] += part(&[0]);
                    energy[1] += part(&[1, 5]) + part(&[2, 4]);
                    energy[2] += part(&[3]);
                }
                Axes::Given => energy[3] += part(&[0, 1, 2, 3, 4, 5]),
            }
        }
    }
    let dofs = model.dof_map();
    let moves = |axis: usize| dofs.rows().iter().any(|r| !r.1.is_rotation() && r.1.axis() == axis);
    let names_direction = (0..3).filter(|a| moves(*a)).count() > 1;
    let mut out = Vec::with_capacity(energies.len());
    for (mode, (energy, q)) in energies.iter().zip(shapes.column_iter()).enumerate() {
        let mut c = ModeCharacter { is_rigid: mode < n_rigid, names_direction, ..ModeCharacter::default() };
        c.symmetry = model.mirror().map(|m| symmetry_index(m, |i| q[i]));
        let total: f64 = energy.iter().sum();
        if total > 0.0 && !c.is_rigid {
            [c.axial, c.bending, c.torsion, c.springs] = energy.map(|e| e / total);
        }
        let mut square = [0.0; 3];
        for node in 0..dofs.n_nodes() {
            for axis in 0..3 {
                let u: f64 = dofs.express(node, Dof::ALL[axis]).iter().map(|&(row, f)| f * q[row]).sum();
                square[axis] += u * u;
            }
        }
        let sum: f64 = square.iter().sum();
        if sum > 0.0 {
            c.direction = square.map(|s| s / sum);
        }
        out.push(c);
    }
    Ok(out)
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
