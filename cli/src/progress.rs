//! Progress of a search on standard error: cost, speed, time left.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use retune::diagnosis::Listener;
use retune::optim::{Observer, Pace, Progress};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A line that follows a run; silent when standard error is no terminal.
pub(crate) struct Line {
    bar: ProgressBar,
    pace: Pace,
}

impl Line {
    pub(crate) fn new() -> Self {
        Self { bar: spinner(), pace: Pace::start() }
    }
}

/// A line that says what is being done; silent when standard error is no terminal, gone when dropped.
pub(crate) struct Spinner(ProgressBar);

impl Spinner {
    pub(crate) fn new() -> Self {
        Self(spinner())
    }

    pub(crate) fn listener(&self) -> Listener {
        let bar = self.0.clone();
        Listener::new(move |what| bar.set_message(what.to_string()))
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
            "{}: {} evaluations, cost {:.6}, {:.0}/s{left}",
            p.method,
            p.evaluations,
            p.cost,
            self.pace.evaluations_per_s(p)
        ));
    }
}

/// A flag that Ctrl-C sets; a second Ctrl-C ends the program at once.
pub(crate) fn cancel_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    // Without a handler Ctrl-C ends the program at once, as usual.
    let _ = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        eprintln!("\nstopping; once more Ctrl-C ends at once");
    });
    flag
}

/// A bar over a known number of things; silent when standard error is no terminal.
pub(crate) fn bar(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}, {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}
