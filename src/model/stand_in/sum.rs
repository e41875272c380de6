//! Terms of K, M and C on few coordinates, as they are summed.

use crate::linalg::{DMatrix, SymMatrix};
use crate::model::assembly::{AffinePart, Basis};
use crate::model::dependence::Monomial;
use crate::model::entry::Entry;
use crate::model::system::System;
use crate::model::{ElementMatrices, Model, ParametricModel};
use std::collections::BTreeMap;

/// Number of the rigid vectors of a basis, coordinates of the six rigid motions, (n_basis x 6), and those vectors as sums of the motions, (6 x
/// n_rigid): by least squares, as products with X lose digits of motions that K does not strain.
///
/// * `about` - the coordinates to some digits; zero for what is no motion of the structure
pub(super) fn rigid(model: &Model, basis: &DMatrix<f64>, about: &DMatrix<f64>) -> (usize, DMatrix<f64>, DMatrix<f64>) {
    let n_rigid = about.row_iter().take_while(|row| row.amax() > 0.0).count();
    let (mut coordinates, none) = (DMatrix::zeros(basis.ncols(), 6), DMatrix::zeros(6, n_rigid));
    if n_rigid == 0 {
        return (0, coordinates, none);
    }
    let v = basis.columns(0, n_rigid).into_owned();
    let motions = model.dof_map().rigid_motions();
    let Some(inverse) = v.tr_mul(&v).try_inverse() else { return (n_rigid, about.clone(), none) };
    let all = inverse * v.tr_mul(&motions);
    let left = &motions - &v * &all;
    for k in (0..6).filter(|&k| left.column(k).amax() <= 1e-6 * motions.column(k).amax()) {
        coordinates.view_mut((0, k), (n_rigid, 1)).copy_from(&all.column(k));
    }
    let own = coordinates.rows(0, n_rigid).into_owned();
    let least = 1e-9 * own.amax();
    let parts = if least > 0.0 { own.pseudo_inverse(least).unwrap_or(none) } else { none };
    (n_rigid, coordinates, parts)
}

/// Terms of K, M and C as they are summed, lower triangles.
pub(super) struct Sum {
    size: usize,
    pub(super) constant: [DMatrix<f64>; 3],
    parameters: Vec<Option<[DMatrix<f64>; 3]>>,
    products: BTreeMap<Monomial, [DMatrix<f64>; 3]>,
    pub(super) origin: Vec<f64>,
}

impl Sum {
    pub(super) fn new(size: usize, n_parameters: usize) -> Self {
        let parameters = vec![None; n_parameters];
        Self { size, constant: zeros(size), parameters, products: BTreeMap::new(), origin: Vec::new() }
    }

    pub(super) fn parameter(&mut self, j: usize) -> &mut [DMatrix<f64>; 3] {
        self.parameters[j].get_or_insert_with(|| zeros(self.size))
    }

    pub(super) fn product(&mut self, monomial: &Monomial) -> &mut [DMatrix<f64>; 3] {
        self.products.entry(monomial.clone()).or_insert_with(|| zeros(self.size))
    }

    pub(super) fn into_affine(self) -> AffinePart {
        let entries = |a: &DMatrix<f64>| -> Vec<Entry> {
            let lower = (0..a.nrows()).flat_map(|row| (0..=row).map(move |column| (row, column)));
            lower
                .map(|(row, column)| Entry { row, column, value: a[(row, column)] })
                .filter(|e| e.value != 0.0)
                .collect()
        };
        let basis =
            |[k, m, c]: &[DMatrix<f64>; 3]| Basis { stiffness: entries(k), mass: entries(m), damping: entries(c) };
        AffinePart {
            constant: basis(&self.constant),
            parameters: self.parameters.iter().map(|p| p.as_ref().map_or_else(Basis::default, basis)).collect(),
            products: self.products.iter().map(|(monomial, all)| (monomial.clone(), basis(all))).collect(),
            origin: self.origin,
        }
    }
}

fn zeros(size: usize) -> [DMatrix<f64>; 3] {
    [(); 3].map(|()| DMatrix::zeros(size, size))
}

/// K, M and C of a system, to be added to.
pub(super) fn of_system(system: &mut System) -> [Option<&mut DMatrix<f64>>; 3] {
    [Some(&mut system.stiffness), Some(&mut system.mass), system.damping.as_mut()]
}

/// Adds Bᵀ a B of an element's K, M and C.
pub(super) fn add(into: [Option<&mut DMatrix<f64>>; 3], b: &DMatrix<f64>, matrices: &ElementMatrices, n_rigid: usize) {
    let parts = [(&matrices.stiffness, n_rigid), (&matrices.mass, 0), (&matrices.damping, n_rigid)];
    for (target, (a, n_rigid)) in into.into_iter().zip(parts) {
        if let Some(target) = target {
            add_to(target, b, a, n_rigid);
        }
    }
}

/// Adds Bᵀ a B; forces of the first `n_rigid` coordinates, which are rigid motions, that are rounding are none.
fn add_to(target: &mut DMatrix<f64>, b: &DMatrix<f64>, a: &SymMatrix, n_rigid: usize) {
    const ROUNDING: f64 = 1e-9;
    if a.is_zero() {
        return;
    }
    let a = a.to_dense();
    let mut force = &a * b;
    let mut none = vec![false; n_rigid];
    if n_rigid > 0 {
        let size = a.abs() * b.columns(0, n_rigid).abs();
        for (j, none) in none.iter_mut().enumerate() {
            if force.column(j).amax() <= ROUNDING * size.column(j).amax() {
                force.column_mut(j).fill(0.0);
                *none = true;
            }
        }
    }
    let mut own = b.tr_mul(&force);
    for (j, _) in none.iter().enumerate().filter(|(_, none)| **none) {
        own.row_mut(j).fill(0.0);
    }
    *target += own;
}
