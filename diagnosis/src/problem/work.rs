//! What a diagnosis has computed, counted: times depend on the machine, these do not.

use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// What a diagnosis has computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkDone {
    /// Least-squares fits, from however many starts.
    pub fits: usize,
    /// Points at which the residuals of all tests were asked for, inside a fit.
    pub evaluations: usize,
    /// Points at which their sum of squares alone was, for the choice of starts: by the batched kernel where it takes the model.
    pub costs: usize,
    /// Points at which their derivatives were.
    pub linearizations: usize,
}

impl WorkDone {
    /// What came after `before`.
    #[must_use]
    pub fn since(self, before: Self) -> Self {
        Self {
            fits: self.fits - before.fits,
            evaluations: self.evaluations - before.evaluations,
            costs: self.costs - before.costs,
            linearizations: self.linearizations - before.linearizations,
        }
    }
}

/// Counts from any thread.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    fits: AtomicUsize,
    evaluations: AtomicUsize,
    costs: AtomicUsize,
    linearizations: AtomicUsize,
}

impl Counters {
    pub(crate) fn fit(&self) {
        self.fits.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn evaluation(&self) {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn costs(&self, points: usize) {
        self.costs.fetch_add(points, Ordering::Relaxed);
    }

    pub(crate) fn linearization(&self) {
        self.linearizations.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn so_far(&self) -> WorkDone {
        let of = |n: &AtomicUsize| n.load(Ordering::Relaxed);
        WorkDone {
            fits: of(&self.fits),
            evaluations: of(&self.evaluations),
            costs: of(&self.costs),
            linearizations: of(&self.linearizations),
        }
    }
}
