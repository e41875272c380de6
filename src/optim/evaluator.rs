use std::cell::Cell;
use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::Yield;
use rayon::prelude::*;

use crate::linalg::DVector;
use crate::linalg::batch::BATCH;
use crate::objective::{EvalError, Linearization, Objective};

/// Who evaluates the batches of a [`Run`](super::Run): threads by default, another engine from outside.
///
/// Results are in the order of the points, and equal points have equal results, wherever they are evaluated: that is
/// what makes a run repeatable. When `cancel` becomes true an evaluator may return early with any values; the run then
/// discards the batch.
pub trait Evaluator: Send + Sync {
    /// The costs of the points, overwriting `out`; a point that cannot be evaluated costs +∞.
    fn costs(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        out: &mut [f64],
        cancel: &AtomicBool,
    ) -> Result<(), Box<dyn Error + Send + Sync>>;

    /// Residuals and Jacobians at the points, one for each, in order.
    fn linearizations(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        cancel: &AtomicBool,
    ) -> Result<Vec<Result<Linearization, EvalError>>, Box<dyn Error + Send + Sync>>;
}

/// Evaluates a batch on the threads of the current rayon pool, in chunks of sixteen points, of eight where there are few for each
/// thread.
///
/// Eight is what a batched kernel solves at once in SIMD lanes, sixteen what it takes best. A result does not depend on the points
/// in the same chunk, and so not on the number of threads.
#[derive(Debug, Clone, Copy, Default)]
pub struct Threads;

/// Chunks for each thread from which on they are as large as the kernel takes them best.
const MANY: usize = 4;

impl Evaluator for Threads {
    fn costs(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        out: &mut [f64],
        cancel: &AtomicBool,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        if points.len() <= BATCH / 2 {
            objective.costs(points, out);
            return Ok(());
        }
        let many = points.len() >= MANY * BATCH * rayon::current_num_threads();
        if many {
            keep_awake();
        }
        let chunk = if many { BATCH } else { BATCH / 2 };
        points.par_chunks(chunk).zip(out.par_chunks_mut(chunk)).with_max_len(1).for_each(|(points, out)| {
            if !cancel.load(Ordering::Relaxed) {
                objective.costs(points, out);
            }
        });
        Ok(())
    }

    fn linearizations(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        _cancel: &AtomicBool,
    ) -> Result<Vec<Result<Linearization, EvalError>>, Box<dyn Error + Send + Sync>> {
        Ok(points.par_iter().map(|x| objective.linearize(x)).collect())
    }
}

/// How long a thread without work looks for more.
const LINGER: Duration = Duration::from_micros(200);

/// Has the other threads of this pool look for work a while longer than they would.
///
/// Between two generations of a fast search some 50 us go by, in which they fall asleep, and they take as long to wake. A thread outside
/// the pool only waits for them: it needs its core between two batches.
fn keep_awake() {
    thread_local!(static AWAKE: Cell<bool> = const { Cell::new(false) });
    let Some(own) = rayon::current_thread_index() else { return };
    rayon::spawn_broadcast(move |context| {
        if context.index() == own || AWAKE.replace(true) {
            return;
        }
        let mut last = Instant::now();
        while last.elapsed() < LINGER {
            match rayon::yield_now() {
                Some(Yield::Executed) => last = Instant::now(),
                _ => std::hint::spin_loop(),
            }
        }
        AWAKE.set(false);
    });
}
