//! Who is told what a diagnosis is doing; it changes no result.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

type Tell = dyn Fn(&str) + Send + Sync;

/// Told what is being done, in words: `screening effects, 120 of 340`. Called from any thread.
#[derive(Clone, Default)]
pub struct Listener(Option<Arc<Tell>>);

impl Listener {
    /// One that is told.
    pub fn new(tell: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(tell)))
    }

    /// Says one thing.
    pub(super) fn say(&self, what: &str) {
        if let Some(tell) = &self.0 {
            tell(what);
        }
    }

    /// Counts through work of a known amount.
    pub(super) fn work<'a>(&'a self, what: &'a str, total: usize) -> Work<'a> {
        Work { listener: self, what, total, done: AtomicUsize::new(0) }
    }
}

impl fmt::Debug for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Listener(..)" } else { "Listener" })
    }
}

/// Work of a known amount.
pub(super) struct Work<'a> {
    listener: &'a Listener,
    what: &'a str,
    total: usize,
    done: AtomicUsize,
}

impl Work<'_> {
    /// One more is done.
    pub(super) fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.listener.0.is_some() {
            self.listener.say(&format!("{}, {done} of {}", self.what, self.total));
        }
    }
}
