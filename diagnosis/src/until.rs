//! Until when a diagnosis may search.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Until when a diagnosis may search: a time, a wish to stop, or the end.
///
/// What is reached then is the answer, and says so. It depends on the speed of the machine: only a search that comes to its end gives the same
/// answer everywhere.
#[derive(Debug, Clone, Default)]
pub struct Until {
    deadline: Option<Instant>,
    stop: Option<Arc<AtomicBool>>,
    /// Set once a search has been told that it is over.
    cut: Arc<AtomicBool>,
}

impl Until {
    /// To the end.
    pub fn the_end() -> Self {
        Self::default()
    }

    /// For so long from now on.
    #[must_use]
    pub fn elapsed(self, budget: Duration) -> Self {
        Self { deadline: Instant::now().checked_add(budget), ..self }
    }

    /// Until this flag is set.
    #[must_use]
    pub fn stopped_by(self, flag: Arc<AtomicBool>) -> Self {
        Self { stop: Some(flag), ..self }
    }

    /// Whether it is time to answer.
    pub fn is_over(&self) -> bool {
        let is_over = self.deadline.is_some_and(|d| Instant::now() >= d)
            || self.stop.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed));
        if is_over {
            self.cut.store(true, Ordering::Relaxed);
        }
        is_over
    }

    /// Whether a search has left something out for it.
    pub fn was_cut(&self) -> bool {
        self.cut.load(Ordering::Relaxed)
    }
}
