//! Who is told what a diagnosis is doing; it changes no result.

use super::problem::work::WorkDone;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

type Tell = dyn Fn(&str) + Send + Sync;

type Took = dyn Fn(&StepTaken) + Send + Sync;

/// Told what is being done, in words: `screening effects, 120 of 340`. Called from any thread.
#[derive(Clone, Default)]
pub struct Listener {
    tell: Option<Arc<Tell>>,
    took: Option<Arc<Took>>,
}

/// A step of a search that has been taken.
#[derive(Debug, Clone, PartialEq)]
pub struct StepTaken {
    /// What it did.
    pub step: &'static str,
    /// Sizes of the hypotheses that stand in the base: none for the model as it is.
    pub beside: Vec<String>,
    /// Hypotheses that it fitted, in full or with a few steps.
    pub fitted: usize,
    /// What these fits took.
    pub work: WorkDone,
    /// Hypotheses that are known after it.
    pub known: usize,
    /// The best of these: its id, ln of its Bayes factor, and the misfit that it leaves.
    pub best: Option<(String, f64, f64)>,
}

impl fmt::Display for StepTaken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.beside.is_empty() {
            write!(f, "beside {}: ", self.beside.join(", "))?;
        }
        write!(
            f,
            "{}: {} fitted ({} costs, {} derivatives), {} known",
            self.step,
            self.fitted,
            self.work.evaluations + self.work.costs,
            self.work.linearizations,
            self.known
        )?;
        match &self.best {
            Some((id, ln_bayes, misfit)) => write!(f, "; {id} leads with ln B {ln_bayes:.1}, misfit {misfit:.1}"),
            None => Ok(()),
        }
    }
}

impl Listener {
    /// One that is told.
    pub fn new(tell: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { tell: Some(Arc::new(tell)), took: None }
    }

    /// The same, told of every step of the search, too.
    #[must_use]
    pub fn with_steps(self, took: impl Fn(&StepTaken) + Send + Sync + 'static) -> Self {
        Self { took: Some(Arc::new(took)), ..self }
    }

    /// Says one thing.
    pub(super) fn say(&self, what: &str) {
        if let Some(tell) = &self.tell {
            tell(what);
        }
    }

    /// Tells a step.
    pub(super) fn took(&self, step: &StepTaken) {
        if let Some(took) = &self.took {
            took(step);
        }
    }

    /// Counts through work of a known amount.
    pub(super) fn work<'a>(&'a self, what: &'a str, total: usize) -> Work<'a> {
        Work { listener: self, what, total, done: AtomicUsize::new(0) }
    }
}

impl fmt::Debug for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.tell.is_some() { "Listener(..)" } else { "Listener" })
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
        if self.listener.tell.is_some() {
            self.listener.say(&format!("{}, {done} of {}", self.what, self.total));
        }
    }
}
