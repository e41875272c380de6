//! What a reduced mode leaves in the equations of the full model.

use crate::linalg::sparse::{PencilFactor, SparsePlan, SparseSym, on_motions};
use crate::linalg::{DMatrix, LinalgError, symmetric_values, tall_tr_mul};
use crate::modal::{ModalError, Modes};
use crate::model::{AffinePart, Entry, ModelError, ParametricModel, System};
use std::sync::Arc;

/// λ_m of the estimate lies this much above λ: nearer ones are turned among each other.
const APART: f64 = 1.5;

/// Forces that are answered at once.
const AT_ONCE: usize = 64;

/// A matrix of K or M of one term, with what it makes of the basis.
#[derive(Debug)]
struct Force {
    /// Number of its term.
    term: usize,
    is_mass: bool,
    matrix: SparseSym,
    /// Columns of the Gram matrix, one for each vector of the basis.
    columns: Vec<usize>,
}

/// |r|² as a quadratic form.
#[derive(Debug)]
pub(super) struct Residual {
    /// X.
    factor: Arc<PencilFactor>,
    shift: f64,
    n_rigid: usize,
    forces: Vec<Force>,
    /// A V of all forces, (n x columns), and its Gram matrix in X⁻¹.
    all: DMatrix<f64>,
    gram: DMatrix<f64>,
}

impl Residual {
    pub(super) fn new(
        full: &dyn ParametricModel,
        terms: &AffinePart,
        theta: &[f64],
        shift: f64,
        n_rigid: usize,
    ) -> Result<Self, ModelError> {
        let system = full.assemble_sparse(theta)?;
        let n = full.dof_map().n_dof();
        let node: Vec<usize> = full.dof_map().rows().iter().map(|r| r.0).collect();
        let plan = SparsePlan::new(&system.stiffness, &system.mass, &node).map_err(ModalError::from)?;
        let factor =
            PencilFactor::new(Arc::new(plan), &system.stiffness, &system.mass, shift).map_err(ModalError::from)?;
        let mut forces = Vec::new();
        for (term, basis) in terms.bases().enumerate() {
            let mut push = |list: &[Entry], is_mass: bool| {
                if !list.is_empty() {
                    let matrix = SparseSym::from_triplets(n, list.iter().map(Entry::triplet));
                    forces.push(Force { term, is_mass, matrix, columns: Vec::new() });
                }
            };
            push(&basis.stiffness, false);
            push(&basis.mass, true);
        }
        let (all, gram) = (DMatrix::zeros(n, 0), DMatrix::zeros(0, 0));
        Ok(Self { factor: Arc::new(factor), shift, n_rigid, forces, all, gram })
    }

    /// Vᵀ A V of each term: its number, whether A is its M and not its K, and the product.
    ///
    /// * `basis` - V, that was taken in
    pub(super) fn on_basis(&self, basis: &DMatrix<f64>) -> Vec<(usize, bool, DMatrix<f64>)> {
        let of = |force: &Force| {
            let made = self.all.select_columns(&force.columns);
            let n_none = if force.is_mass { 0 } else { self.n_rigid };
            let projected = on_motions(basis, &made, n_none);
            (force.term, force.is_mass, projected)
        };
        self.forces.iter().map(of).collect()
    }

    /// The factor of X.
    pub(super) fn factor(&self) -> &Arc<PencilFactor> {
        &self.factor
    }

    /// a.
    pub(super) fn shift(&self) -> f64 {
        self.shift
    }

    /// Takes in the columns of a basis that it does not have yet.
    pub(super) fn extend(&mut self, basis: &DMatrix<f64>) {
        let before = self.forces.first().map_or(0, |f| f.columns.len());
        let count = basis.ncols() - before;
        let new = basis.columns(before, count).into_owned();
        let first = self.all.ncols();
        let size = first + count * self.forces.len();
        let mut all = std::mem::replace(&mut self.all, DMatrix::zeros(0, 0)).resize_horizontally(size, 0.0);
        for (k, force) in self.forces.iter_mut().enumerate() {
            let n_none = if force.is_mass { 0 } else { self.n_rigid.saturating_sub(before).min(count) };
            let place = first + k * count;
            all.columns_mut(place, count).copy_from(&force.matrix.forces(&new, n_none));
            force.columns.extend(place..place + count);
        }
        let mut gram = std::mem::replace(&mut self.gram, DMatrix::zeros(0, 0)).resize(size, size, 0.0);
        // Of a large model all answers together are as large as all forces.
        for from in (first..size).step_by(AT_ONCE) {
            let some = AT_ONCE.min(size - from);
            let answers = self.factor.solve(&all.columns(from, some).into_owned());
            gram.columns_mut(from, some).copy_from(&tall_tr_mul(&all, &answers));
        }
        let beside = gram.view((0, first), (first, size - first)).transpose();
        gram.view_mut((first, 0), beside.shape()).copy_from(&beside);
        (self.all, self.gram) = (all, gram);
    }

    /// Estimated relative errors of frequencies.
    ///
    /// * `factors` - of the terms at θ
    /// * `system`, `modes` - of the reduced model at θ
    pub(super) fn frequency_errors(
        &self,
        factors: &[f64],
        system: &System,
        modes: &Modes,
        n_modes: usize,
    ) -> Result<Vec<f64>, LinalgError> {
        let values = symmetric_values(&(&system.stiffness + &system.mass * self.shift))?;
        let alpha = values.min().max(f64::MIN_POSITIVE);
        let elastic: Vec<usize> = modes.elastic().collect();
        let [stiffness, both, mass] = self.at(factors);
        let mut out = Vec::with_capacity(n_modes);
        for &mode in elastic.iter().take(n_modes) {
            let (lambda, y) = (modes.lambda[mode], modes.shapes.column(mode));
            let squared =
                y.dot(&(&stiffness * y)) - 2.0 * lambda * y.dot(&(&both * y)) + lambda * lambda * y.dot(&(&mass * y));
            let above = elastic.iter().map(|&k| modes.lambda[k]).find(|l| *l > APART * lambda);
            let gap = above.map_or(1.0, |above| (above + self.shift) / (above - lambda));
            out.push(0.5 * squared.max(0.0) / alpha * gap / lambda);
        }
        Ok(out)
    }

    /// Vᵀ K X⁻¹ K V, Vᵀ K X⁻¹ M V and Vᵀ M X⁻¹ M V at these factors of the terms: one pass over the Gram matrix, whatever the number of modes.
    fn at(&self, factors: &[f64]) -> [DMatrix<f64>; 3] {
        let n = self.forces.first().map_or(0, |f| f.columns.len());
        let mut out = [(); 3].map(|()| DMatrix::zeros(n, n));
        for right in &self.forces {
            for left in &self.forces {
                let product = factors[left.term] * factors[right.term];
                // Vᵀ M X⁻¹ K V is the transpose of the second.
                if product == 0.0 || left.is_mass && !right.is_mass {
                    continue;
                }
                let sum = &mut out[usize::from(left.is_mass) + usize::from(right.is_mass)];
                for (mut sum, &column) in sum.column_iter_mut().zip(&right.columns) {
                    let gram = self.gram.column(column);
                    for (sum, &row) in sum.iter_mut().zip(&left.columns) {
                        *sum += product * gram[row];
                    }
                }
            }
        }
        out
    }
}
