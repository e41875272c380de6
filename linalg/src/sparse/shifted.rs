//! Systems with the factor of K + aM.

use super::factor::FactorError;
use super::kernel::{Row, WIDTH};
use super::matrix::SparseSym;
use super::plan::SparsePlan;
use crate::{DMatrix, LinalgError};

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
    assert_eq!(forces.nrows(), plan.n(), "forces on every row");
    let mut factor =
        plan.structure.cholesky(&plan.pencil(k, m).shifted(shift), plan.structure.values()?).map_err(|e| match e {
            FactorError::Pivot(place) => LinalgError::NotPositiveDefinite { row: plan.order[place], shift },
            FactorError::Memory => LinalgError::OutOfMemory,
        })?;
    let mut out = DMatrix::zeros(forces.nrows(), forces.ncols());
    for first in (0..forces.ncols()).step_by(WIDTH) {
        let width = WIDTH.min(forces.ncols() - first);
        let row = |&i: &usize| -> Row { std::array::from_fn(|l| if l < width { forces[(i, first + l)] } else { 0.0 }) };
        let mut block: Vec<Row> = plan.order.iter().map(row).collect();
        factor.solve(&mut block);
        for (values, &i) in block.iter().zip(&plan.order) {
            for l in 0..width {
                out[(i, first + l)] = values[l];
            }
        }
    }
    Ok(out)
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
