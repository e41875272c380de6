//! The error of a mesh of shells and solids, estimated from one solution on it.
//!
//! In a mode the strains ε of each element jump at the edges of the next one. Recovered strains ε* are continuous: at every node a polynomial is
//! fitted to the strains in the elements around it, and the functions of the nodes carry these values into the elements. What both differ by is
//! energy that the mesh does not find, and it makes the structure too stiff:
//!
//! ```text
//! η² = Σ ∫ (ε* - ε)ᵀ D (ε* - ε) dV / λ             φᵀ M φ = 1
//! ```
//!
//! Energy against hourglass patterns, which no strain stands for, counts as missed too. Elements whose strains bend what the functions of their nodes leave straight carry their mass along straight lines too: M* is the mass along
//! what is bent ([`crate::element::StrainField::mass`]), and
//!
//! ```text
//! δ = φᵀ (M* - M) φ,        f_mesh / f ≈ √((1 + η²)(1 + δ))
//! ```
//!
//! # Source
//! O. C. Zienkiewicz, J. Z. Zhu, A simple error estimator and adaptive procedure for practical engineering analysis, Int. J. Numer. Meth. Engng 24
//! (1987) 337-357; the same, The superconvergent patch recovery and a posteriori error estimates, 33 (1992) 1331-1382. For frequencies: N.-E. Wiberg,
//! R. Bausys, P. Hager, Improved eigenfrequencies and eigenmodes in free vibration analysis, Computers and Structures 73 (1999) 79-89.

mod recovery;

use super::ModelError;
use super::compile::Model;
use super::geometry::{Vector, dot, plus};
use crate::element::{ElementInput, StrainField};
use crate::linalg::SymMatrix;
use crate::modal::Modes;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What the mesh does to one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshError {
    /// Index of the mode, rigid-body modes first.
    pub mode: usize,
    /// Relative error of its frequency, f_mesh / f - 1: positive where the mesh makes it too high.
    pub relative: f64,
    /// The part of the mesh, or the section, in which most of the error arises.
    pub part: String,
}

/// Strains of an element in some modes.
struct Strained {
    element: usize,
    /// Elements with the same number are of one material and section: strains are continuous between them.
    class: usize,
    /// Axes of a shell's plane, global; `None` of a solid.
    plane: Option<[Vector; 3]>,
    rigidity: [[f64; 6]; 6],
    /// Order of the polynomial that is fitted to strains around a node.
    order: usize,
    points: Vec<Point>,
    /// φᵀ (M* - M) φ by mode.
    mass: Vec<f64>,
    /// Energy against hourglass patterns by mode.
    hourglass: Vec<f64>,
}

/// A point of an element.
struct Point {
    at: Vector,
    n: Vec<f64>,
    weight: f64,
    is_sample: bool,
    /// By mode.
    strains: Vec<[f64; 6]>,
}

impl Model {
    /// The error that the mesh makes in the frequencies of some modes, by their strains alone; empty for a model without shells and solids.
    ///
    /// Errors of its beams are not in it: these are exact in bending under end forces, and `subdivide` makes them as fine as one likes.
    ///
    /// * `modes` - modes at θ, mass-normalised
    /// * `which` - indices of elastic ones
    ///
    /// # Errors
    /// [`ModelError::Element`] for an element that has no matrices at θ.
    pub fn mesh_errors(&self, theta: &[f64], modes: &Modes, which: &[usize]) -> Result<Vec<MeshError>, ModelError> {
        let strained = self.strained(theta, modes, which)?;
        if strained.is_empty() {
            return Ok(Vec::new());
        }
        let recovered = recovery::recover(self, &strained, which.len());
        let energies: Vec<Vec<f64>> =
            strained.par_iter().zip(&recovered).map(|(e, at_nodes)| e.missed(at_nodes)).collect();
        let error = |(k, &mode): (usize, &usize)| {
            let lambda = modes.lambda[mode];
            let (mut eta, mut delta) = (0.0, 0.0);
            let mut by_part: BTreeMap<String, f64> = BTreeMap::new();
            for (e, energy) in strained.iter().zip(&energies) {
                let own = energy[k] / lambda;
                eta += own;
                delta += e.mass[k];
                *by_part.entry(self.part_of(e.element)).or_default() += own + e.mass[k];
            }
            let part = by_part.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|p| p.0).unwrap_or_default();
            MeshError { mode, relative: ((1.0 + eta) * (1.0 + delta)).max(0.0).sqrt() - 1.0, part }
        };
        Ok(which.iter().enumerate().filter(|(_, m)| modes.lambda[**m] > 0.0).map(error).collect())
    }

    /// The part of the mesh of an element, else its section, else its own name.
    fn part_of(&self, element: usize) -> String {
        let e = &self.elements()[element];
        let part = e.path.strip_prefix("mesh.parts.").map(str::to_string);
        part.or_else(|| e.section.clone()).unwrap_or_else(|| e.name.clone())
    }

    fn strained(&self, theta: &[f64], modes: &Modes, which: &[usize]) -> Result<Vec<Strained>, ModelError> {
        let shapes: Vec<Vec<f64>> = which.iter().map(|&m| modes.shapes.column(m).iter().copied().collect()).collect();
        let of = |i: usize| -> Result<Option<(Strained, Vec<u64>)>, ModelError> {
            let e = &self.elements()[i];
            if e.matrices.is_some() || e.nodes.len() < 3 {
                return Ok(None);
            }
            let values = e.values_at(theta);
            let input = ElementInput { points: &e.points, values: &values };
            let failed = |source| ModelError::Element { element: e.name.clone(), path: e.path.clone(), source };
            let Some(field) = e.kind.strain_field(&input).map_err(failed)? else { return Ok(None) };
            let factor = e.stiffness_factor.as_ref().map_or(1.0, |f| f.at(theta));
            let mut class: Vec<u64> = values.iter().map(|v| v.map_or(u64::MAX, f64::to_bits)).collect();
            class.push(factor.to_bits());
            if field.plane.is_none() {
                class.extend(e.axes.iter().flatten().map(|v| v.to_bits()));
            }
            Ok(Some((self.strained_element(i, &field, factor, theta, &shapes)?, class)))
        };
        let all: Vec<Result<_, ModelError>> = (0..self.elements().len()).into_par_iter().map(of).collect();
        let mut classes: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
        let mut out = Vec::new();
        for one in all {
            let Some((mut strained, class)) = one? else { continue };
            let next = classes.len();
            strained.class = *classes.entry(class).or_insert(next);
            out.push(strained);
        }
        Ok(out)
    }

    fn strained_element(
        &self,
        i: usize,
        field: &StrainField,
        factor: f64,
        theta: &[f64],
        shapes: &[Vec<f64>],
    ) -> Result<Strained, ModelError> {
        let e = &self.elements()[i];
        let own = self.element_matrices(i, theta)?.mass;
        let mass_factor = e.mass_factor.as_ref().map_or(1.0, |f| f.at(theta));
        let moved: Vec<Vec<f64>> = shapes.iter().map(|q| self.element_displacements(i, q)).collect();
        let energy = |a: &SymMatrix, u: &[f64]| -> f64 {
            let row = |i: usize| -> f64 { u[i] * (0..u.len()).map(|j| a.get(i, j) * u[j]).sum::<f64>() };
            (0..u.len()).map(row).sum()
        };
        let mass = moved.iter().map(|u| mass_factor * energy(&field.mass, u) - energy(&own, u));
        let hourglass = moved.iter().map(|u| field.hourglass.as_ref().map_or(0.0, |h| factor * energy(h, u)));
        let first = e.ends(&self.geometry().positions)[0];
        let to_global = |v: Vector| (0..3).fold([0.0; 3], |sum, k| plus(sum, v[k], e.axes[k]));
        let point = |p: &crate::element::StrainPoint| Point {
            at: plus(first, 1.0, to_global(p.at)),
            n: p.n.clone(),
            weight: p.weight,
            is_sample: p.is_sample,
            strains: moved.iter().map(|u| p.strains(u)).collect(),
        };
        Ok(Strained {
            element: i,
            class: 0,
            plane: field.plane.map(|axes| axes.map(to_global)),
            rigidity: field.rigidity.map(|row| row.map(|v| factor * v)),
            order: field.order,
            points: field.points.iter().map(point).collect(),
            mass: mass.collect(),
            hourglass: hourglass.collect(),
        })
    }
}

impl Strained {
    /// ∫ (ε* - ε)ᵀ D (ε* - ε), and what hourglass patterns take, by mode.
    ///
    /// * `at_nodes` - ε* at its nodes, by mode, in its own axes
    fn missed(&self, at_nodes: &[Vec<[f64; 6]>]) -> Vec<f64> {
        let mut energy = self.hourglass.clone();
        for p in self.points.iter().filter(|p| p.weight > 0.0) {
            for (k, energy) in energy.iter_mut().enumerate() {
                let off: [f64; 6] = std::array::from_fn(|c| {
                    let there: f64 = p.n.iter().zip(at_nodes).map(|(n, of_node)| n * of_node[k][c]).sum();
                    there - p.strains[k][c]
                });
                *energy += p.weight * (0..6).map(|a| off[a] * dot6(&self.rigidity[a], &off)).sum::<f64>();
            }
        }
        energy
    }

    /// Its normal, of a shell.
    fn normal(&self) -> Option<Vector> {
        self.plane.map(|axes| axes[2])
    }

    /// The angle from an axis to its own x axis, seen along a normal onto which its plane is turned the shortest way, rad.
    fn turned_from(&self, x: Vector, normal: Vector) -> f64 {
        let Some([own, ..]) = self.plane else { return 0.0 };
        let away = dot(own, normal);
        let flat = plus(own, -away, normal);
        let y = super::geometry::cross(normal, x);
        dot(flat, y).atan2(dot(flat, x))
    }
}

fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
