//! Systems whose matrix is singular along one mode: derivatives of shapes.

use super::matrix::SparseSym;
use super::plan::SparsePlan;
use crate::{DMatrix, DVector, LinalgError};

/// Z with (K - λM) Z = F and a zero in one row, for forces that do no work on the mode.
///
/// * `plan` - of a pattern that covers `k` and `m`
/// * `lambda`, `shape` - a mode, simple (n)
/// * `forces` - F with Fᵀ φ = 0, (n x any number)
///
/// The row and column where |φ| √K is largest are struck out, which leaves a regular matrix with the same pattern; it is
/// factored as LDLᵀ and the solution is refined once. `None` where λ is double: no Z satisfies the equations then.
///
/// # Errors
/// [`LinalgError::OutOfMemory`].
///
/// # Panics
/// If sizes differ, or the plan's pattern does not cover the matrices.
///
/// # Source
/// R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA Journal 14(9), 1976.
pub fn solve_beside_mode(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    lambda: f64,
    shape: &DVector<f64>,
    forces: &DMatrix<f64>,
) -> Result<Option<DMatrix<f64>>, LinalgError> {
    let n = plan.n();
    if forces.ncols() == 0 || n == 0 {
        return Ok(Some(DMatrix::zeros(n, forces.ncols())));
    }
    let shifted = plan.pencil(k, m).shifted(-lambda);
    let weight = |i: usize| shape[plan.order[i]].abs() * k.diagonal(plan.order[i]).max(0.0).sqrt();
    let fixed = (0..n).fold(0, |best, i| if weight(i) > weight(best) { i } else { best });
    let mut struck = shifted.clone();
    for j in 0..n {
        for p in struck.columns[j]..struck.columns[j + 1] {
            let i = struck.rows[p];
            if (i == fixed) != (j == fixed) {
                struck.values[p] = 0.0;
            } else if i == fixed {
                struck.values[p] = k.diagonal(plan.order[fixed]).max(f64::MIN_POSITIVE);
            }
        }
    }
    let mut right = plan.ordered_rows(forces);
    let factor = plan.structure.indefinite(&struck, plan.structure.values()?)?;
    let strike = |x: &mut DMatrix<f64>| x.row_mut(fixed).fill(0.0);
    let mut z = right.clone();
    strike(&mut z);
    factor.solve(&mut z)?;
    let mut correction = &right - shifted.mul(&z);
    strike(&mut correction);
    factor.solve(&mut correction)?;
    z += correction;
    // At a double λ the matrix is singular still, and the struck row is not satisfied by itself.
    let size = shifted.abs().mul(&z.abs()).amax() + right.amax();
    right -= shifted.mul(&z);
    if !z.iter().all(|v| v.is_finite()) || right.amax() > 1e-8 * size {
        return Ok(None);
    }
    Ok(Some(plan.restored_rows(&z)))
}
