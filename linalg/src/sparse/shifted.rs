//! Systems with the factor of K + aM.

use super::factor::{Factor, FactorError};
use super::kernel::{Row, WIDTH};
use super::matrix::SparseSym;
use super::plan::{Ordered, SparsePlan};
use crate::{DMatrix, LinalgError};
use rayon::prelude::*;
use std::sync::Arc;

/// (K + aM)⁻¹ F.
///
/// * `plan` - of a pattern that covers `k` and `m`
/// * `forces` - F, (n x any number)
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`] if K + aM is not; [`LinalgError::OutOfMemory`].
///
/// # Panics
/// If sizes differ, or the plan's pattern does not cover the matrices.
pub fn solve_shifted(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    shift: f64,
    forces: &DMatrix<f64>,
) -> Result<DMatrix<f64>, LinalgError> {
    let values = cholesky(plan, k, m, shift)?.into_values();
    let structure = &plan.structure;
    Ok(solve_blocks(plan, forces, |block| structure.solve(&values, block, &mut structure.work())))
}

/// The factor of K + aM, kept for many solutions.
#[derive(Debug)]
pub struct PencilFactor {
    plan: Arc<SparsePlan>,
    values: Vec<f64>,
}

impl PencilFactor {
    /// Factors K + aM.
    ///
    /// * `plan` - of a pattern that covers `k` and `m`
    ///
    /// # Errors
    /// As [`solve_shifted`].
    ///
    /// # Panics
    /// If the plan's pattern does not cover the matrices.
    pub fn new(plan: Arc<SparsePlan>, k: &SparseSym, m: &SparseSym, shift: f64) -> Result<Self, LinalgError> {
        let values = cholesky(&plan, k, m, shift)?.into_values();
        Ok(Self { plan, values })
    }

    /// The plan that it was made by.
    pub fn plan(&self) -> &Arc<SparsePlan> {
        &self.plan
    }

    /// (K + aM)⁻¹ F.
    ///
    /// * `forces` - F, (n x any number)
    ///
    /// # Panics
    /// If F has another number of rows.
    pub fn solve(&self, forces: &DMatrix<f64>) -> DMatrix<f64> {
        let structure = &self.plan.structure;
        solve_blocks(&self.plan, forces, |block| structure.solve(&self.values, block, &mut structure.work()))
    }
}

fn cholesky<'a>(plan: &'a SparsePlan, k: &SparseSym, m: &SparseSym, shift: f64) -> Result<Factor<'a>, LinalgError> {
    plan.structure.cholesky(&plan.pencil(k, m).shifted(shift), plan.structure.values()?).map_err(|e| match e {
        FactorError::Pivot(place) => LinalgError::NotPositiveDefinite { row: plan.order[place], shift },
        FactorError::Memory => LinalgError::OutOfMemory,
    })
}

/// Solves for some columns at a time, in the elimination order, on several threads.
fn solve_blocks(plan: &SparsePlan, forces: &DMatrix<f64>, solve: impl Fn(&mut [Row]) + Sync) -> DMatrix<f64> {
    assert_eq!(forces.nrows(), plan.n(), "forces on every row");
    let n = forces.nrows();
    let mut out = DMatrix::zeros(n, forces.ncols());
    if n == 0 {
        return out;
    }
    let blocks = out.as_mut_slice().par_chunks_mut(WIDTH * n).zip(forces.as_slice().par_chunks(WIDTH * n));
    blocks.for_each(|(to, from)| {
        let width = from.len() / n;
        let row = |&i: &usize| -> Row { std::array::from_fn(|l| if l < width { from[l * n + i] } else { 0.0 }) };
        let mut block: Vec<Row> = plan.order.iter().map(row).collect();
        solve(&mut block);
        for (values, &i) in block.iter().zip(&plan.order) {
            (0..width).for_each(|l| to[l * n + i] = values[l]);
        }
    });
    out
}

/// K and M in an elimination order, for solutions with K + aM of many a, which need not be positive definite.
#[derive(Debug)]
pub struct IndefinitePencil<'a> {
    plan: &'a SparsePlan,
    pencil: Ordered,
}

impl<'a> IndefinitePencil<'a> {
    /// Orders K and M.
    ///
    /// # Panics
    /// If sizes differ, or the plan's pattern does not cover the matrices.
    pub fn new(plan: &'a SparsePlan, k: &SparseSym, m: &SparseSym) -> Self {
        Self { plan, pencil: plan.pencil(k, m) }
    }

    /// (K + aM)⁻¹ F, by LDLᵀ.
    ///
    /// * `forces` - F, (n x any number)
    ///
    /// # Errors
    /// [`LinalgError::OutOfMemory`].
    ///
    /// # Panics
    /// If F has another number of rows.
    pub fn solve(&self, shift: f64, forces: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        let structure = &self.plan.structure;
        let factor = structure.indefinite(&self.pencil.shifted(shift), structure.values()?)?;
        let mut x = self.plan.ordered_rows(forces);
        factor.solve(&mut x)?;
        Ok(self.plan.restored_rows(&x))
    }
}

/// Number of negative eigenvalues of K + aM, by the inertia of its factorisation; `None` if a pivot is not a number.
///
/// By Sylvester's law of inertia it is the number of λ below -a of K φ = λ M φ, and of directions without mass in which K is
/// negative.
///
/// * `plan` - of a pattern that covers `k` and `m`
///
/// # Errors
/// [`LinalgError::OutOfMemory`].
///
/// # Panics
/// If the plan's pattern does not cover the matrices.
pub fn count_negative(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    shift: f64,
) -> Result<Option<usize>, LinalgError> {
    let factor = plan.structure.indefinite(&plan.pencil(k, m).shifted(shift), plan.structure.values()?)?;
    Ok(factor.negative())
}
