//! Costs of many points through the batched kernel.
//!
//! ```text
//! eight points -> θ -> modes at the sensors (linalg::batch) -> MAC, partners, mass properties -> the objective's own cost
//! ```
//!
//! The kernel and the reference path ([`Comparison::predict`]) differ in how the modes are found, nothing else: partners
//! follow the same rules and the cost is computed by the same function. A candidate that the kernel does not guarantee is
//! evaluated by the reference path; so is all of a model that the kernel does not take (no polynomial of its parameters, not
//! solvable in the middle of its bounds, too large). After the first batch of a thread nothing is allocated.

mod affine;
mod compiled;

use crate::once::Once;
use std::sync::atomic::{AtomicU64, Ordering};

use self::compiled::Compiled;
use super::PathCounts;
use super::comparison::Comparison;
use super::prediction::{Prediction, PredictionDerivative};
use super::scaling::Scaling;
use crate::linalg::DVector;
use crate::linalg::batch::BATCH;

/// An objective's way to the batched kernel, made at its first use.
#[derive(Debug, Default)]
pub struct BatchPath {
    compiled: Once<Option<Compiled>>,
    /// Whether shapes are kept at all dofs, from which they have derivatives.
    has_derivatives: bool,
    batch: AtomicU64,
    reference: AtomicU64,
}

/// The cost of a prediction at θ; the buffer is for residuals. A cost that is not finite sends the point to the reference
/// path, which says why.
pub(super) type CostOf<'a> = &'a dyn Fn(&Prediction, &[f64], &mut DVector<f64>) -> f64;

/// A prediction at θ with its derivatives.
pub(super) type Linearized<'a, T> = &'a dyn Fn(&Prediction, &PredictionDerivative, &[f64]) -> T;

impl BatchPath {
    /// One that gives derivatives too, for one objective or for several of the same model and test.
    pub fn with_derivatives() -> Self {
        Self { has_derivatives: true, ..Self::default() }
    }

    /// Whether it gives derivatives.
    pub(super) fn has_derivatives(&self) -> bool {
        self.has_derivatives
    }

    /// Gives the memory of its threads back.
    pub fn rest(&self) {
        if let Some(Some(compiled)) = self.compiled.get() {
            compiled.rest();
        }
    }

    /// What is made of a prediction at x and its derivatives; `None` where the kernel does not guarantee them.
    pub(super) fn linearize<T>(
        &self,
        (comparison, scaling): (&Comparison<'_>, &Scaling),
        x: &DVector<f64>,
        of: Linearized<'_, T>,
    ) -> Option<T> {
        let compiled = self.compiled(comparison, scaling, true)?;
        let mut bench = compiled.bench();
        let made = compiled.linearize(&mut bench, (comparison, scaling), x, of);
        compiled.put_back(bench);
        let counter = if made.is_some() { &self.batch } else { &self.reference };
        counter.fetch_add(1, Ordering::Relaxed);
        made
    }

    /// The costs of the points, overwriting `out`.
    ///
    /// * `needs_shapes`, `cost_of` - the objective's cost of a prediction, and whether it looks at shapes
    /// * `reference` - its cost at x by the reference path, +∞ where there is none
    pub(super) fn costs(
        &self,
        (comparison, scaling): (&Comparison<'_>, &Scaling),
        points: &[DVector<f64>],
        out: &mut [f64],
        (needs_shapes, cost_of): (bool, CostOf<'_>),
        reference: impl Fn(&DVector<f64>) -> f64,
    ) {
        assert_eq!(points.len(), out.len(), "one cost a point");
        let Some(compiled) = self.compiled(comparison, scaling, needs_shapes) else {
            self.reference.fetch_add(points.len() as u64, Ordering::Relaxed);
            points.iter().zip(out).for_each(|(x, cost)| *cost = reference(x));
            return;
        };
        let mut bench = compiled.bench();
        for (points, out) in points.chunks(BATCH).zip(out.chunks_mut(BATCH)) {
            compiled.evaluate(&mut bench, (comparison, scaling), points, out, cost_of);
            let mut redone = 0;
            for (x, cost) in points.iter().zip(out) {
                if !cost.is_finite() {
                    *cost = reference(x);
                    redone += 1;
                }
            }
            self.batch.fetch_add(points.len() as u64 - redone, Ordering::Relaxed);
            self.reference.fetch_add(redone, Ordering::Relaxed);
        }
        compiled.put_back(bench);
    }

    /// A cost found by the kernel, if the reference path agrees with it to 1e-9; else that of the reference path.
    pub(super) fn confirm(&self, cost: f64, reference: impl FnOnce() -> f64) -> f64 {
        if !matches!(self.compiled.get(), Some(Some(_))) {
            return cost;
        }
        self.reference.fetch_add(1, Ordering::Relaxed);
        let again = reference();
        if (again - cost).abs() <= AGREEMENT * again.abs() + NO_COST { cost } else { again }
    }

    pub(super) fn counts(&self) -> PathCounts {
        PathCounts { batch: self.batch.load(Ordering::Relaxed), reference: self.reference.load(Ordering::Relaxed) }
    }

    fn compiled(&self, comparison: &Comparison<'_>, scaling: &Scaling, needs_shapes: bool) -> Option<&Compiled> {
        let made = || Compiled::new(comparison, scaling, needs_shapes, self.has_derivatives);
        self.compiled.get_or_find(made).as_ref()
    }
}

/// Relative difference of two costs that rounding explains: 1e-9 in an eigenvalue is the kernel's promise.
const AGREEMENT: f64 = 1e-9;
/// Difference of costs that is nothing: rounding of a cost that vanishes at a perfect fit.
const NO_COST: f64 = 1e-12;

#[cfg(test)]
mod tests;
