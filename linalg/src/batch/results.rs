//! The results of a batch.

use super::solve::Plan;
use crate::LinalgError;

/// Why the batch kernel did not accept its own result for a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// K without its rigid motions has a pivot that is not positive.
    Stiffness,
    /// M is not positive semidefinite.
    Mass,
    /// Fewer modes above the rounding noise than asked for, or a cluster larger than the kernel's margin.
    Count,
    /// An eigenpair missed the residual test.
    Residual,
}

/// How a candidate was solved.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Outcome {
    /// By the batch kernel.
    Batch,
    /// Alone, by the reference path; its modes are as good.
    Reference(Cause),
    /// Not yet: the batch kernel does not guarantee its result and was asked to leave it; values and shapes are NaN.
    Left(Cause),
    /// Not at all: K or M is not what a structure has; values and shapes are NaN.
    NotSolvable {
        /// What the batch kernel objected to.
        cause: Cause,
        /// What the reference path said, if it failed too.
        reason: Option<LinalgError>,
    },
}

/// Elastic modes of several candidates, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchModes {
    n_modes: usize,
    /// Numbers of a shape; 0 where shapes are not wanted.
    n_rows: usize,
    n_products: usize,
    values: Vec<f64>,
    shapes: Vec<f64>,
    products: Vec<f64>,
    parities: Vec<i8>,
    outcomes: Vec<Outcome>,
}

impl BatchModes {
    pub(super) fn new(plan: &Plan, candidates: usize) -> Self {
        let (n_modes, n_products) = (plan.n_modes, plan.n_products());
        let n_rows = if plan.with_shapes { plan.n_rows } else { 0 };
        Self {
            n_modes,
            n_rows,
            n_products,
            products: Vec::with_capacity(candidates * n_modes * n_products),
            values: Vec::with_capacity(candidates * n_modes),
            shapes: Vec::with_capacity(candidates * n_modes * n_rows),
            parities: Vec::with_capacity(candidates * n_modes),
            outcomes: Vec::with_capacity(candidates),
        }
    }

    /// Makes room for this many candidates.
    pub(super) fn reset(&mut self, candidates: usize) {
        self.values.resize(candidates * self.n_modes, f64::NAN);
        self.shapes.resize(candidates * self.n_modes * self.n_rows, f64::NAN);
        self.products.resize(candidates * self.n_modes * self.n_products, f64::NAN);
        self.parities.clear();
        self.parities.resize(candidates * self.n_modes, 0);
        self.outcomes.clear();
        self.outcomes.resize(candidates, Outcome::Batch);
    }

    /// Where value and shape of one mode go.
    pub(super) fn slot(&mut self, candidate: usize, mode: usize) -> (&mut f64, &mut [f64]) {
        let at = candidate * self.n_modes + mode;
        (&mut self.values[at], &mut self.shapes[at * self.n_rows..(at + 1) * self.n_rows])
    }

    /// Where the products of one shape go.
    pub(super) fn products_mut(&mut self, candidate: usize, mode: usize) -> &mut [f64] {
        let at = (candidate * self.n_modes + mode) * self.n_products;
        &mut self.products[at..at + self.n_products]
    }

    pub(super) fn set_parity(&mut self, candidate: usize, mode: usize, parity: i8) {
        self.parities[candidate * self.n_modes + mode] = parity;
    }

    /// Overwrites values and shapes of a candidate without modes.
    pub(super) fn blank(&mut self, candidate: usize, outcome: Outcome) {
        for j in 0..self.n_modes {
            let (value, shape) = self.slot(candidate, j);
            *value = f64::NAN;
            shape.fill(f64::NAN);
            self.products_mut(candidate, j).fill(f64::NAN);
        }
        self.set_outcome(candidate, outcome);
    }

    pub(super) fn set_outcome(&mut self, candidate: usize, outcome: Outcome) {
        self.outcomes[candidate] = outcome;
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.outcomes.len()
    }

    /// Whether there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.outcomes.is_empty()
    }

    /// How a candidate was solved.
    ///
    /// # Panics
    /// If there is no such candidate.
    pub fn outcome(&self, candidate: usize) -> &Outcome {
        &self.outcomes[candidate]
    }

    /// λ = ω² of the elastic modes of a candidate, rad²/s², ascending.
    ///
    /// # Panics
    /// If there is no such candidate.
    pub fn values(&self, candidate: usize) -> &[f64] {
        &self.values[candidate * self.n_modes..(candidate + 1) * self.n_modes]
    }

    /// One shape of a candidate at the sensor rows, mass-normalised (φᵀ M φ = 1); its sign is arbitrary but repeatable. Empty
    /// where shapes are not wanted.
    ///
    /// # Panics
    /// If there is no such candidate or mode.
    pub fn shape(&self, candidate: usize, mode: usize) -> &[f64] {
        assert!(mode < self.n_modes, "mode {mode} of {}", self.n_modes);
        let at = candidate * self.n_modes + mode;
        &self.shapes[at * self.n_rows..(at + 1) * self.n_rows]
    }

    /// Products φᵀ r of one shape at the sensor rows with every reference and, last, φᵀ φ; empty without references.
    ///
    /// # Panics
    /// If there is no such candidate or mode.
    pub fn products(&self, candidate: usize, mode: usize) -> &[f64] {
        assert!(mode < self.n_modes, "mode {mode} of {}", self.n_modes);
        let at = (candidate * self.n_modes + mode) * self.n_products;
        &self.products[at..at + self.n_products]
    }

    /// Which family of shapes a mode belongs to: +1 if the mirror leaves it unchanged, -1 if it changes its sign, 0 where
    /// the model has no mirror or the reference path, which does not tell, has found the mode.
    ///
    /// # Panics
    /// If there is no such candidate or mode.
    pub fn parity(&self, candidate: usize, mode: usize) -> i8 {
        assert!(mode < self.n_modes, "mode {mode} of {}", self.n_modes);
        self.parities[candidate * self.n_modes + mode]
    }

    /// How many candidates were not solved by the batch kernel itself.
    pub fn n_redone(&self) -> usize {
        self.outcomes.iter().filter(|o| **o != Outcome::Batch).count()
    }
}
