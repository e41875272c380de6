use std::time::Instant;

use crate::linalg::DVector;

/// Where a run stands after a batch.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Name of the method at work.
    pub method: &'a str,
    /// Costs and linearizations evaluated so far.
    pub evaluations: u64,
    /// How many of them came from a checkpoint.
    pub replayed: u64,
    /// Evaluations allowed, if limited.
    pub budget: Option<u64>,
    /// The best cost so far (+∞ before the first finite one).
    pub cost: f64,
    /// The best point so far.
    pub x: Option<&'a DVector<f64>>,
}

/// Is told about the progress of a run, after every batch.
pub trait Observer {
    /// Called after every batch; what it does cannot change the run.
    fn progress(&mut self, progress: &Progress<'_>);
}

impl<F: FnMut(&Progress<'_>)> Observer for F {
    fn progress(&mut self, progress: &Progress<'_>) {
        self(progress);
    }
}

/// Evaluations a second and the time left, for observers: the only clock in this module, and no result depends on it.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    started: Instant,
}

impl Pace {
    /// Starts the clock.
    pub fn start() -> Self {
        Self { started: Instant::now() }
    }

    /// Seconds since the start.
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Evaluations a second since the start, not counting those from a checkpoint.
    pub fn evaluations_per_s(&self, progress: &Progress<'_>) -> f64 {
        pace(progress, self.elapsed_s())
    }

    /// Seconds until the budget is spent at the present pace; nothing without a budget or a pace.
    ///
    /// An upper estimate: a search that converges ends earlier.
    pub fn seconds_left(&self, progress: &Progress<'_>) -> Option<f64> {
        seconds_left(progress, self.elapsed_s())
    }
}

fn pace(progress: &Progress<'_>, elapsed_s: f64) -> f64 {
    let done = (progress.evaluations - progress.replayed) as f64;
    if elapsed_s > 0.0 { done / elapsed_s } else { 0.0 }
}

fn seconds_left(progress: &Progress<'_>, elapsed_s: f64) -> Option<f64> {
    let left = progress.budget?.saturating_sub(progress.evaluations) as f64;
    let pace = pace(progress, elapsed_s);
    (pace > 0.0).then(|| left / pace)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replayed_evaluations_do_not_count_towards_the_pace() {
        let progress = Progress { method: "m", evaluations: 300, replayed: 100, budget: Some(700), cost: 1.0, x: None };
        assert_eq!(pace(&progress, 10.0), 20.0);
        assert_eq!(seconds_left(&progress, 10.0), Some(20.0));
        assert_eq!(seconds_left(&Progress { budget: None, ..progress }, 10.0), None);
        assert_eq!(seconds_left(&progress, 0.0), None);
    }
}
