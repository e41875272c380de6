//! Systems with the factor of K + aM.

use super::factor::{Factor, FactorError};
use super::kernel::{Row, WIDTH};
use super::matrix::SparseSym;
use super::plan::SparsePlan;
use crate::{DMatrix, LinalgError};
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
    let mut factor = cholesky(plan, k, m, shift)?;
    Ok(solve_blocks(plan, forces, |block| factor.solve(block)))
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
        let mut work = structure.work();
        solve_blocks(&self.plan, forces, |block| structure.solve(&self.values, block, &mut work))
    }
}

fn cholesky<'a>(plan: &'a SparsePlan, k: &SparseSym, m: &SparseSym, shift: f64) -> Result<Factor<'a>, LinalgError> {
    plan.structure.cholesky(&plan.pencil(k, m).shifted(shift), plan.structure.values()?).map_err(|e| match e {
        FactorError::Pivot(place) => LinalgError::NotPositiveDefinite { row: plan.order[place], shift },
        FactorError::Memory => LinalgError::OutOfMemory,
    })
}

/// Solves for some columns at a time, in the elimination order.
fn solve_blocks(plan: &SparsePlan, forces: &DMatrix<f64>, mut solve: impl FnMut(&mut [Row])) -> DMatrix<f64> {
    assert_eq!(forces.nrows(), plan.n(), "forces on every row");
    let mut out = DMatrix::zeros(forces.nrows(), forces.ncols());
    for first in (0..forces.ncols()).step_by(WIDTH) {
        let width = WIDTH.min(forces.ncols() - first);
        let row = |&i: &usize| -> Row { std::array::from_fn(|l| if l < width { forces[(i, first + l)] } else { 0.0 }) };
        let mut block: Vec<Row> = plan.order.iter().map(row).collect();
        solve(&mut block);
        for (values, &i) in block.iter().zip(&plan.order) {
            for l in 0..width {
                out[(i, first + l)] = values[l];
            }
        }
    }
    out
}

/// (K + aM)⁻¹ F where K + aM need not be positive definite, by LDLᵀ.
///
/// * `plan` - of a pattern that covers `k` and `m`
/// * `forces` - F, (n x any number)
///
/// # Errors
/// [`LinalgError::OutOfMemory`].
///
/// # Panics
/// If sizes differ, or the plan's pattern does not cover the matrices.
pub fn solve_indefinite(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    shift: f64,
    forces: &DMatrix<f64>,
) -> Result<DMatrix<f64>, LinalgError> {
    let factor = plan.structure.indefinite(&plan.pencil(k, m).shifted(shift), plan.structure.values()?)?;
    let mut x = plan.ordered_rows(forces);
    factor.solve(&mut x)?;
    Ok(plan.restored_rows(&x))
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
