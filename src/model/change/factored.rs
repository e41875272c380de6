//! What a change does to a superelement, or to a term of one: other factors on matrices that stay as they are.
//!
//! ```text
//! ΔK = Σ_k Δc_k(θ, s) A_k,    A_k: its K, M and C on the rows that they touch
//! ```

use super::scaled::{change_of_factors, times};
use crate::linalg::sparse::SparseSym;
use crate::linalg::{DMatrix, SymMatrix};
use crate::matrices::Entry;
use crate::model::dependence::{Monomial, Terms};
use crate::model::dof_map::DofMap;
use crate::model::entry::merge;
use crate::model::placed_element::PlacedElement;
use crate::model::placed_matrices::PlacedMatrices;
use crate::model::{ElementMatrices, Model};
use std::sync::Arc;

/// K, M and C of a superelement, or of a term of one, on the rows that any of them touches.
#[derive(Debug)]
pub(in crate::model) struct OnRows {
    /// Rows of the model, ascending.
    rows: Vec<usize>,
    /// K, M and C.
    matrices: [Option<SparseSym>; 3],
    /// Rᵀ M R of the six rigid motions about the origin.
    rigid: SymMatrix,
}

impl OnRows {
    pub(super) fn new(matrices: &PlacedMatrices, dofs: &DofMap, positions: &[[f64; 3]]) -> Self {
        let follows = matrices.follows(dofs);
        let lists = [&matrices.k, &matrices.m, &matrices.c].map(|a| {
            let mut entries = a.as_deref().map(|a| follows.reduce(a)).unwrap_or_default();
            merge(&mut entries);
            entries
        });
        let mut touched = vec![false; dofs.n_dof()];
        for e in lists.iter().flatten() {
            let (row, column) = e.place();
            touched[row] = true;
            touched[column] = true;
        }
        let rows: Vec<usize> = (0..touched.len()).filter(|&row| touched[row]).collect();
        let mut place = vec![0; touched.len()];
        rows.iter().enumerate().for_each(|(i, &row)| place[row] = i);
        let on_rows = lists.map(|list| {
            let entries =
                list.iter().map(Entry::triplet).map(|(row, column, value)| (place[row], place[column], value));
            (!list.is_empty()).then(|| SparseSym::from_triplets(rows.len(), entries))
        });
        let rigid = matrices.m.as_deref().map_or_else(|| SymMatrix::zeros(6), |m| matrices.rigid(m, positions));
        Self { rows, matrices: on_rows, rigid }
    }

    /// Rows of the model, ascending.
    pub(in crate::model) fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Vᵀ A V of K, M and C; without those that it has not, zero.
    ///
    /// * `v` - motions of its rows, the first `n_rigid` of them rigid
    pub(in crate::model) fn on_basis(&self, v: &DMatrix<f64>, n_rigid: usize) -> ElementMatrices {
        let [stiffness, mass, damping] = [(0, n_rigid), (1, 0), (2, n_rigid)].map(|(k, n_rigid)| {
            let none = || SymMatrix::zeros(v.ncols());
            self.matrices[k].as_ref().map_or_else(none, |a| SymMatrix::from_dense(&a.on_basis(v, n_rigid)))
        });
        ElementMatrices { stiffness, mass, weighed_mass: None, damping }
    }
}

/// What a change does to a superelement, or to a term of one.
#[derive(Debug, Clone)]
pub(super) struct Factored {
    /// With the change in its factors.
    pub(super) after: Box<PlacedElement>,
    /// The element of the model, by index.
    pub(super) before: usize,
    pub(super) of: Arc<OnRows>,
}

impl Factored {
    pub(super) fn new(after: PlacedElement, before: usize, of: Arc<OnRows>) -> Self {
        Self { after: Box::new(after), before, of }
    }

    pub(super) fn depends_on(&self, model: &Model, j: usize) -> bool {
        self.after.depends_on(j) || model.elements()[self.before].depends_on(j)
    }

    /// Terms of what it adds, for `whole`, its K, M and C on some coordinates.
    pub(super) fn terms(&self, model: &Model, whole: &ElementMatrices) -> Terms {
        let factors = change_of_factors(&self.after, &model.elements()[self.before]);
        times(&factors, &[(&Monomial::default(), whole)])
    }

    /// ΔK and ΔM at one point, as factors on its K and M.
    ///
    /// * `point` - θ of the model with the sizes behind it
    pub(super) fn at(&self, model: &Model, point: &[f64]) -> [f64; 2] {
        let before = &model.elements()[self.before];
        [(&self.after.stiffness_factor, &before.stiffness_factor), (&self.after.mass_factor, &before.mass_factor)]
            .map(|(after, before)| [after, before].map(|f| f.as_ref().map_or(1.0, |f| f.at(point))))
            .map(|[after, before]| after - before)
    }

    /// Adds Rᵀ ΔM R of the six rigid motions about the origin.
    pub(super) fn add_rigid_mass(&self, rigid: &mut SymMatrix, model: &Model, point: &[f64]) {
        rigid.add_scaled(self.at(model, point)[1], &self.of.rigid);
    }

    /// Whether factors on its K and M change any of them.
    pub(super) fn acts(&self, factors: [f64; 2]) -> bool {
        factors.iter().zip(&self.of.matrices).any(|(factor, a)| *factor != 0.0 && a.is_some())
    }

    /// A x of its K and M, times factors; `None` where it has none or the factor is zero.
    pub(super) fn times(&self, factors: [f64; 2], x: &DMatrix<f64>) -> [Option<DMatrix<f64>>; 2] {
        [0, 1].map(|k| {
            let a = self.of.matrices[k].as_ref().filter(|_| factors[k] != 0.0)?;
            Some(a.mul(x) * factors[k])
        })
    }
}
