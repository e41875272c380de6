//! One candidate alone, by the dense eigensolver: what the batch kernel is compared with and falls back to.

use super::results::{BatchModes, Cause, Outcome};
use super::{BatchError, BatchModel};
use crate::{DMatrix, LinalgError, lowest_modes};

/// Scales of the nominal model, rad²/s².
pub(super) struct Scale {
    /// The lowest elastic λ.
    pub(super) first: f64,
    /// The last wanted one.
    pub(super) last: f64,
    /// Shift of the reference path.
    pub(super) shift: f64,
}

/// The lowest elastic λ, and the shift a with the smallest relative error over all wanted modes.
///
/// The error of the inverse problem is ε (λ + a)²/a, relative to λ smallest at a = λ; the geometric mean of the first
/// and the last wanted λ balances the two ends.
pub(super) fn nominal_scale(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    rigid: usize,
    n_modes: usize,
) -> Result<Scale, BatchError> {
    // K_ii / M_ii is above the lowest λ of the structure with dof i alone: a first guess, far too high.
    let guess = (0..k.nrows())
        .filter(|&i| m[(i, i)] > 0.0 && k[(i, i)] > 0.0)
        .map(|i| k[(i, i)] / m[(i, i)])
        .fold(f64::INFINITY, f64::min);
    let mut shift = if guess.is_finite() { guess } else { 1.0 };
    let mut scale = None;
    for _ in 0..3 {
        let pairs = lowest_modes(k, m, rigid + n_modes, shift).map_err(BatchError::Nominal)?;
        if pairs.values.len() < rigid + n_modes {
            let available = pairs.values.len().saturating_sub(rigid);
            return Err(BatchError::TooManyModes { asked: n_modes, available });
        }
        let (first, last) = (pairs.values[rigid], pairs.values[rigid + n_modes - 1]);
        // Rounding noise instead of an elastic mode.
        if first.is_nan() || first <= 1e-13 * (shift + last) {
            return Err(BatchError::Mechanism { rigid });
        }
        shift = (first * last).sqrt();
        scale = Some(Scale { first, last, shift });
    }
    scale.ok_or(BatchError::Mechanism { rigid })
}

impl BatchModel {
    /// The elastic modes of one candidate by the reference path: λ (rad²/s²) ascending, and full shapes as columns.
    ///
    /// # Errors
    /// Those of [`lowest_modes`].
    ///
    /// # Panics
    /// If `theta` does not have one value per parameter.
    pub fn reference(&self, theta: &[f64]) -> Result<(Vec<f64>, DMatrix<f64>), LinalgError> {
        let (k, m) = self.pencil.assemble(theta);
        let pairs = lowest_modes(&k, &m, self.rigid + self.plan.n_modes, self.shift)?;
        let elastic = pairs.values.len().saturating_sub(self.rigid);
        let values = pairs.values.iter().skip(self.rigid).copied().collect();
        Ok((values, pairs.vectors.columns(self.rigid.min(pairs.vectors.ncols()), elastic).into_owned()))
    }

    /// Redoes one candidate by the reference path, into the results.
    pub(super) fn solve_alone(&self, theta: &[f64], cause: Cause, candidate: usize, modes: &mut BatchModes) {
        let n_modes = self.plan.n_modes;
        let found = self.reference(theta);
        // A value at rounding level is a motion without strain energy that is not a rigid-body mode: a mechanism.
        let elastic = |values: &[f64]| values[0] > 1e-12 * (self.shift + values[n_modes - 1]);
        match found {
            Ok((values, shapes)) if cause != Cause::Mass && values.len() == n_modes && elastic(&values) => {
                let observed = &self.sensors * shapes;
                for (j, &lambda) in values.iter().enumerate() {
                    let (value, shape) = modes.slot(candidate, j);
                    *value = lambda;
                    let seen = observed.column(j);
                    if self.plan.with_shapes {
                        shape.copy_from_slice(seen.as_slice());
                    }
                    if let Some(references) = &self.plan.references {
                        let n = references.len() / self.plan.n_rows.max(1);
                        let product = |r: usize| (0..seen.len()).map(|i| references[i * n + r] * seen[i]).sum::<f64>();
                        let products = (0..n).map(product).chain([seen.norm_squared()]);
                        modes.products_mut(candidate, j).iter_mut().zip(products).for_each(|(out, p)| *out = p);
                    }
                }
                modes.set_outcome(candidate, Outcome::Reference(cause));
            }
            other => {
                modes.blank(candidate, Outcome::NotSolvable { cause, reason: other.err() });
            }
        }
    }
}
