//! Progress of a search on standard error: cost, speed, time left.

use crate::output::tell;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use retune::catalogue::counted;
use retune::optim::{Observer, Pace, Progress};
use retune_diagnosis::Listener;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A line of a log comes so often.
const EVERY: Duration = Duration::from_secs(15);

/// A line that follows a run; silent when standard error is not a terminal.
pub(crate) struct Line {
    bar: ProgressBar,
    pace: Pace,
}

impl Line {
    pub(crate) fn new() -> Self {
        Self { bar: spinner(), pace: Pace::start() }
    }
}

/// A line that says what is being done, gone when dropped; where standard error is not a terminal, now and then a line of a log.
pub(crate) struct Spinner(ProgressBar);

impl Spinner {
    pub(crate) fn new() -> Self {
        Self(spinner())
    }

    pub(crate) fn listener(&self) -> Listener {
        let bar = self.0.clone();
        if !bar.is_hidden() {
            return Listener::new(move |what| bar.set_message(what.to_string()));
        }
        let (begun, log) = (Instant::now(), Log::default());
        Listener::new(move |what| {
            if let Some(line) = log.line(begun.elapsed(), what) {
                tell(&line);
            }
        })
    }
}

/// Lines that show a long run alive: none of a short one.
#[derive(Default)]
struct Log {
    told: Mutex<Duration>,
}

impl Log {
    /// The line of what is being done so long after the begin, if one is due.
    fn line(&self, after: Duration, what: &str) -> Option<String> {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let is_due = after >= *told + EVERY;
        is_due.then(|| {
            *told = after;
            format!("after {:.0} s: {what}", after.as_secs_f64())
        })
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

fn spinner() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

impl Drop for Line {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Line {
    fn progress(&mut self, p: &Progress<'_>) {
        let left = self.pace.seconds_left(p).map_or_else(String::new, |s| format!(", at most {s:.0} s left"));
        self.bar.set_message(format!(
            "{}: {}, cost {:.6}, {:.0}/s{left}",
            p.method,
            counted(p.evaluations as usize, "evaluation"),
            p.cost,
            self.pace.evaluations_per_s(p)
        ));
    }
}

/// A bar over a known number of things; silent when standard error is not a terminal.
pub(crate) fn bar(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}, {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

#[cfg(test)]
mod tests {
    use super::Log;
    use std::time::Duration;

    #[test]
    fn a_log_has_few_lines() {
        let log = Log::default();
        let at = |seconds: u64| log.line(Duration::from_secs(seconds), "screening effects, 3 of 9");
        let lines: Vec<u64> = (0..100).filter(|&s| at(s).is_some()).collect();
        assert_eq!(lines, [15, 30, 45, 60, 75, 90]);
        assert_eq!(at(120).as_deref(), Some("after 120 s: screening effects, 3 of 9"));
    }
}
