//! Whether a stiffness matrix is that of a stable structure.

use super::modes::{ModalError, Modes};
use retune_linalg::sparse::{SparsePlan, SparseSym, count_negative};
use retune_linalg::{DMatrix, LinalgError};

/// Number of independent motions that the stiffness drives away from rest instead of holding them; a buckled structure has one or more.
///
/// It is the number of negative eigenvalues of K, by the inertia of a factorisation, beyond what rounding of K can make negative:
///
/// ```text
/// K + 100 ε diag |K_ii|
/// ```
///
/// `None` if a pivot is not a number.
///
/// * `plan` - of a pattern that covers the matrix
///
/// # Errors
/// [`LinalgError::OutOfMemory`].
pub fn unstable_directions(plan: &SparsePlan, stiffness: &SparseSym) -> Result<Option<usize>, LinalgError> {
    let n = stiffness.n();
    let diagonal = SparseSym::from_triplets(n, (0..n).map(|i| (i, i, stiffness.diagonal(i).abs())));
    count_negative(plan, stiffness, &diagonal, 100.0 * f64::EPSILON)
}

/// A failure, or the instability that is behind it.
pub(super) fn unstable_or(error: ModalError, plan: &SparsePlan, k: &SparseSym) -> ModalError {
    match unstable_directions(plan, k) {
        Ok(Some(n)) if n > 0 && may_be_unstable(&error) => ModalError::Unstable { n },
        _ => error,
    }
}

/// [`unstable_or`] for dense matrices.
pub(super) fn dense_unstable_or(error: ModalError, k: &DMatrix<f64>) -> ModalError {
    if !may_be_unstable(&error) {
        return error;
    }
    let k = SparseSym::from_dense(k);
    match SparsePlan::new(&k, &k, &(0..k.n()).collect::<Vec<_>>()) {
        Ok(plan) => unstable_or(error, &plan, &k),
        Err(_) => error,
    }
}

fn may_be_unstable(error: &ModalError) -> bool {
    use LinalgError::{MissedModes, NoConvergence, NotPositiveDefinite};
    matches!(error, ModalError::Linalg(NotPositiveDefinite { .. } | NoConvergence { .. } | MissedModes { .. }))
}

/// Refuses modes with a negative λ that is not rounding:
///
/// ```text
/// λ < -10 ε |φ|ᵀ|K||φ|
/// ```
///
/// * `times_absolute` - |K| x
pub(super) fn check_stable(
    modes: &Modes,
    times_absolute: impl Fn(&DMatrix<f64>) -> DMatrix<f64>,
) -> Result<(), ModalError> {
    let is_negative = |&j: &usize| {
        modes.lambda[j] < 0.0 && {
            let phi = modes.shapes.columns(j, 1).abs();
            modes.lambda[j] < -10.0 * f64::EPSILON * phi.dot(&times_absolute(&phi))
        }
    };
    match modes.elastic().filter(is_negative).count() {
        0 => Ok(()),
        n => Err(ModalError::Unstable { n }),
    }
}
