//! Long work: on threads of the library, the GIL released, with Ctrl-C and progress.
//!
//! The thread that called waits for messages. It alone touches Python: it calls the progress function, and asks every few milliseconds whether
//! Ctrl-C was pressed. The first Ctrl-C stops a search, which then answers with its best; the next one, and the first one of work that
//! has no partial answer, raises KeyboardInterrupt at once, and what then still runs is forgotten.

use crate::error::Wrong;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Stack of a thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;
/// How long Ctrl-C may wait.
const PATIENCE: Duration = Duration::from_millis(20);
/// A progress function is called so often at most.
const EVERY: Duration = Duration::from_millis(100);

/// The threads of this process. A child of `fork` has none of its parent's: it gets its own.
fn pool() -> &'static rayon::ThreadPool {
    static POOL: Mutex<Option<(u32, &'static rayon::ThreadPool)>> = Mutex::new(None);
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let id = std::process::id();
    match *pool {
        Some((owner, pool)) if owner == id => pool,
        _ => {
            let new = rayon::ThreadPoolBuilder::new().stack_size(STACK).thread_name(|k| format!("retune-{k}")).build();
            // A machine that gives no threads at all gives one that waits.
            let new = new.or_else(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build());
            let new: &'static rayon::ThreadPool = Box::leak(Box::new(new.expect("a process can have a thread")));
            *pool = Some((id, new));
            new
        }
    }
}

/// Runs short work on the threads of the library, the GIL released.
pub(crate) fn on_pool<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    py.detach(|| pool().install(work))
}

/// What is told of a search.
#[derive(Debug, Clone)]
pub(crate) struct Told {
    /// What is being done.
    pub(crate) text: String,
    /// Evaluations so far, of a search that counts them.
    pub(crate) evaluations: Option<u64>,
    /// The best cost so far.
    pub(crate) cost: Option<f64>,
}

enum Message<T> {
    Told(Told),
    Done(Result<Result<T, Wrong>, Box<dyn Any + Send>>),
}

/// Work that runs: how it tells, and whether it shall stop.
#[derive(Clone)]
pub(crate) struct Job {
    /// Set when it shall answer with its best.
    pub(crate) stop: Arc<AtomicBool>,
    tell: Arc<dyn Fn(Told) + Send + Sync>,
}

impl Job {
    pub(crate) fn tell(&self, text: String, evaluations: Option<u64>, cost: Option<f64>) {
        (self.tell)(Told { text, evaluations, cost });
    }
}

/// Whether work answers with its best when it is stopped.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stops {
    WithItsBest,
    Never,
}

/// Runs work and waits for it.
///
/// * `progress` - called with (text, evaluations, cost)
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    stops: Stops,
    work: impl FnOnce(&Job) -> Result<T, Wrong> + Send + 'static,
) -> PyResult<T> {
    let (send, messages) = channel::<Message<T>>();
    let stop = Arc::new(AtomicBool::new(false));
    let job = Job { stop: Arc::clone(&stop), tell: teller(send.clone(), progress.is_some()) };
    pool().spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| work(&job)));
        // Nobody may be waiting any more.
        let _ = send.send(Message::Done(done));
    });
    let messages = Mutex::new(messages);
    let mut raised: Option<PyErr> = None;
    loop {
        let message = py.detach(|| messages.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(PATIENCE));
        let mut interruption = py.check_signals().err();
        match message {
            Ok(Message::Told(told)) => {
                if let (Some(progress), None) = (progress, &raised) {
                    interruption = interruption.or(progress.call1((told.text, told.evaluations, told.cost)).err());
                }
            }
            Ok(Message::Done(done)) => {
                let found = done.unwrap_or_else(|panic| resume_unwind(panic));
                return match (raised, interruption, found) {
                    (Some(error), ..) => Err(error),
                    // There is a result, and it came with the key.
                    (None, Some(error), _) if stops == Stops::Never => Err(error),
                    (None, Some(error), _) if !error.is_instance_of::<PyKeyboardInterrupt>(py) => Err(error),
                    (None, _, found) => match found {
                        Err(_) if stop.load(Ordering::Relaxed) => Err(Wrong::Stopped.into()),
                        found => Ok(found?),
                    },
                };
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(Wrong::Stopped.into()),
        }
        let Some(error) = interruption else { continue };
        if stops == Stops::Never || stop.swap(true, Ordering::SeqCst) {
            return Err(error);
        }
        if !error.is_instance_of::<PyKeyboardInterrupt>(py) {
            raised = Some(error);
        }
    }
}

/// Sends what is told, not too often.
fn teller<T: Send + 'static>(send: Sender<Message<T>>, is_heard: bool) -> Arc<dyn Fn(Told) + Send + Sync> {
    if !is_heard {
        return Arc::new(|_| {});
    }
    let last: Mutex<Option<Instant>> = Mutex::new(None);
    Arc::new(move |told| {
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_none_or(|at| at.elapsed() >= EVERY) {
            *last = Some(Instant::now());
            let _ = send.send(Message::Told(told));
        }
    })
}
