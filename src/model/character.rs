//! What kind of motion a mode is: where its strain energy sits, which way it moves, whether it is symmetric.

use super::compile::Model;
use super::dof_map::DofMap;
use super::geometry::{Geometry, NEAR_IMAGE, dot, images, minus};
use super::dependence::strain_parts;
use super::place::PlacedElement;
use super::{ModelError, ParametricModel};
use crate::element::{Axes, Dof};
use crate::linalg::{DMatrix, SymMatrix};
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
    /// Share of motion (sum of squares of displacements of the sections at nodes, on the line of their mass) along each global
    /// axis.
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
                "no node stands at the mirror image of `{}`, {place:?} m; the nearest, `{}`, is {:.3e} m off, and {:.0e} m would do",
                name(node),
                name(nearest),
                off(node, nearest),
                NEAR_IMAGE * size
            )
        })?;
        let row = row_of.get(&(partner, dof as usize)).ok_or_else(|| {
            format!("`{}` moves along {}, and its mirror image `{}` does not", name(node), dof.name(), name(partner))
        })?;
        // Displacements flip along the normal; rotations flip about the other two axes.
        let flips = (dof.axis() == axis) != dof.is_rotation();
        Ok((*row, if flips { -1.0 } else { 1.0 }))
    };
    let pairs = images.iter().enumerate().filter_map(|(node, image)| image.map(|other| (node, other, off(node, other))));
    let farthest = pairs.max_by(|a, b| a.2.total_cmp(&b.2).then(b.0.cmp(&a.0)));
    let difference = farthest.filter(|(_, _, off)| *off > ROUNDING * size).map(|(node, other, off)| {
        format!(
            "the halves differ by up to {off:.3e} m: `{}` stands that far from the mirror image of `{}`; they count as symmetric",
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

/// How the sections at every node move, on the line of their mass: where that line lies beside the nodes, a twist moves the nodes
/// and not the sections.
struct Motions {
    /// Per node and mode: squares of displacements along global axes, summed over the elements that meet there.
    squares: Vec<[f64; 3]>,
    /// Per node: how many elements meet there.
    elements: Vec<usize>,
    n_modes: usize,
}

impl Motions {
    fn new(n_nodes: usize, n_modes: usize) -> Self {
        Self { squares: vec![[0.0; 3]; n_nodes * n_modes], elements: vec![0; n_nodes], n_modes }
    }

    /// * `u` - displacements of the nodes of an element, in its axes
    /// * `line` - (y, z) of the line of its mass
    fn add(&mut self, element: &PlacedElement, mode: usize, u: &[f64], [y, z]: [f64; 2]) {
        for (k, &node) in element.nodes.iter().enumerate() {
            let [ux, uy, uz, rx, ry, rz] = std::array::from_fn(|d| u[6 * k + d]);
            // u + θ × (0, y, z)
            let local = [ux + z * ry - y * rz, uy - z * rx, uz + y * rx];
            let sum = &mut self.squares[node * self.n_modes + mode];
            for (global, sum) in sum.iter_mut().enumerate() {
                *sum += (0..3).map(|i| element.axes[i][global] * local[i]).sum::<f64>().powi(2);
            }
            self.elements[node] += usize::from(mode == 0);
        }
    }

    /// The mean over the elements that meet at a node; `None` where none does.
    fn squares(&self, node: usize, mode: usize) -> Option<[f64; 3]> {
        let n = self.elements[node];
        (n > 0).then(|| self.squares[node * self.n_modes + mode].map(|s| s / n as f64))
    }
}

/// The characters of shapes of a model at θ, the first `n_rigid` of them rigid-body modes.
pub(super) fn characters(
    model: &Model,
    theta: &[f64],
    shapes: &DMatrix<f64>,
    n_rigid: usize,
) -> Result<Vec<ModeCharacter>, ModelError> {
    let mut energies = vec![[0.0; 4]; shapes.ncols()]; // axial, bending, torsion, springs
    let mut motions = Motions::new(model.dof_map().n_nodes(), shapes.ncols());
    for (i, e) in model.elements().iter().enumerate() {
        let parts = strain_parts(e, theta)?;
        let k = if parts.is_none() { Some(model.element_matrices(i, theta)?.stiffness) } else { None };
        let is_line = e.kind.axes() == Axes::AlongNodes;
        let line = is_line.then(|| e.mass_axis(theta));
        for (mode, (energy, q)) in energies.iter_mut().zip(shapes.column_iter()).enumerate() {
            let u = model.element_displacements(i, q.as_slice());
            let force = |k: &SymMatrix| {
                let mut out = vec![0.0; u.len()];
                k.multiply(&u, &mut out);
                out
            };
            let of = |k: &SymMatrix| -> f64 { force(k).iter().zip(&u).map(|(f, u)| f * u).sum() };
            match (&parts, &k) {
                (Some(p), _) => {
                    for (sum, part) in energy.iter_mut().zip([&p.axial, &p.bending, &p.torsion, &p.springs]) {
                        *sum += of(part);
                    }
                }
                // By the work of its end forces: exact in the sum, and of an element whose line is the line of its nodes.
                (None, Some(k)) if is_line && !k.is_zero() => {
                    for (dof, (f, u)) in force(k).iter().zip(&u).enumerate() {
                        energy[[0, 1, 1, 2, 1, 1][dof % 6]] += f * u;
                    }
                }
                (None, Some(k)) if !k.is_zero() => energy[3] += of(k),
                _ => {}
            }
            if let Some(line) = line {
                motions.add(e, mode, &u, line);
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
            let own = |axis: usize| -> f64 {
                dofs.express(node, Dof::ALL[axis]).iter().map(|&(row, f)| f * q[row]).sum::<f64>().powi(2)
            };
            let squares = motions.squares(node, mode).unwrap_or_else(|| std::array::from_fn(own));
            square.iter_mut().zip(squares).for_each(|(sum, s)| *sum += s);
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

    /// A cantilever whose line of nodes lies at the centre of its section, or beside it: energies and directions are those of the section.
    #[test]
    fn a_character_does_not_depend_on_where_the_nodes_lie() {
        let characters = |offsets: &str| {
            let text = format!(
                "retune: 1\nname: c\nsections:\n  s: {{E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {{rectangle: {{width: 50 mm, height: 20 mm}}}}{offsets}}}\n\
                 nodes: {{a: [0, 0, 0], b: [1 m, 0, 0]}}\nbeams: {{ab: {{nodes: [a, b], section: s, subdivide: 20}}}}\nsupports: {{c: {{node: a}}}}\n"
            );
            let model = crate::model::load(&text, &crate::model::Registry::builtin()).unwrap().0;
            let options = crate::modal::SolveOptions { n_elastic: 10, shift: None };
            let modes = crate::model::solve_modes(&model, &[], options).unwrap();
            super::characters(&model, &[], &modes.shapes, modes.n_rigid).unwrap()
        };
        let centre = characters("");
        assert!((centre[5].torsion - 1.0).abs() < 1e-6, "{:?}", centre[5]);
        for offsets in [
            ", mass_offset_z: 0.05 m, shear_centre_z: 0.05 m",
            ", mass_offset_y: -0.2 m, shear_centre_y: -0.2 m, mass_offset_z: 0.01 m, shear_centre_z: 0.01 m",
        ] {
            for (mode, (a, b)) in centre.iter().zip(characters(offsets)).enumerate() {
                for (x, y) in [(a.torsion, b.torsion), (a.bending, b.bending), (a.axial, b.axial)] {
                    assert!((x - y).abs() < 1e-6, "mode {}: {a:?} {b:?}", mode + 1);
                }
                for axis in 0..3 {
                    assert!((a.direction[axis] - b.direction[axis]).abs() < 1e-6, "mode {}: {a:?} {b:?}", mode + 1);
                }
            }
        }
    }

    #[test]
    fn ordinals() {
        assert_eq!([1, 2, 3, 4, 11, 12, 21, 113].map(ordinal).join(" "), "1st 2nd 3rd 4th 11th 12th 21st 113th");
    }
}
