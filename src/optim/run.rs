use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::checkpoint::{Checkpoint, Fingerprint};
use super::{CheckpointError, Evaluator, Improvement, Observer, OptimError, Optimum, Progress, Termination, Threads};
use crate::linalg::DVector;
use crate::objective::{EvalError, Linearization, Objective, PathCounts, Walls};

/// Everything around a method: counting, batches, stopping, observers, random streams, history and checkpoints.
///
/// ```text
/// let mut run = Run::new(&objective).seed(7).budget(20_000).cancel(ctrl_c).observer(&mut bar);
/// let optimum = DifferentialEvolution::default().minimize(&start, &mut run)?;
/// ```
///
/// A method asks for batches of points ([`costs`](Self::costs)); the run has them evaluated, keeps the best, and answers
/// with a [`Stop`] when nothing further may be evaluated. Two runs with the same objective, method, start, seed and
/// budget visit the same points with the same bits, whoever evaluates them and on how many threads.
pub struct Run<'a> {
    objective: &'a dyn Objective,
    evaluator: &'a dyn Evaluator,
    observers: Vec<&'a mut dyn Observer>,
    cancel: Arc<AtomicBool>,
    checkpoint: Option<Checkpoint>,
    seed: u64,
    target: f64,
    budget: Option<u64>,
    count: Count,
    scope: Scope,
    n_scopes: u64,
    warnings: Vec<String>,
}

/// What has been evaluated.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    evaluations: u64,
    linearizations: u64,
    failures: u64,
    replayed: u64,
    paths: PathCounts,
}

impl Count {
    fn spent(self) -> u64 {
        self.evaluations + self.linearizations
    }

    fn add(&mut self, paths: PathCounts) {
        self.paths.batch += paths.batch;
        self.paths.reference += paths.reference;
    }
}

/// One method at work: its own best point and its share of the budget.
#[derive(Debug, Default)]
struct Scope {
    method: String,
    /// Count at which this scope's budget is spent, if limited.
    limit: Option<u64>,
    stream: u64,
    best: Option<(DVector<f64>, f64)>,
    history: Vec<Improvement>,
}

/// Why a run evaluates no further. Hand it on with `?`: [`Run::conclude`] turns it into the result.
#[derive(Debug)]
pub enum Stop {
    /// An ordinary end: budget, target, cancellation.
    Ended(Termination),
    /// There is no result.
    Failed(OptimError),
}

impl From<OptimError> for Stop {
    fn from(error: OptimError) -> Self {
        Self::Failed(error)
    }
}

impl<'a> Run<'a> {
    /// A run with seed 0, on threads, without limit of evaluations.
    pub fn new(objective: &'a dyn Objective) -> Self {
        Self {
            objective,
            evaluator: &Threads,
            observers: Vec::new(),
            cancel: Arc::default(),
            checkpoint: None,
            seed: 0,
            target: f64::NEG_INFINITY,
            budget: None,
            count: Count::default(),
            scope: Scope::default(),
            n_scopes: 0,
            warnings: Vec::new(),
        }
    }

    /// The seed of every random number of this run.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// At most so many evaluations; a linearization counts as one, even where an objective takes it by differences.
    #[must_use]
    pub fn budget(mut self, evaluations: u64) -> Self {
        self.budget = Some(evaluations);
        self.scope.limit = Some(evaluations);
        self
    }

    /// Stops as soon as the best cost is at or below `cost`.
    #[must_use]
    pub fn target(mut self, cost: f64) -> Self {
        self.target = cost;
        self
    }

    /// Stops cleanly, keeping the best point, once the flag is true (set it from a Ctrl-C handler).
    #[must_use]
    pub fn cancel(mut self, flag: Arc<AtomicBool>) -> Self {
        self.cancel = flag;
        self
    }

    /// Tells `observer` about every batch.
    #[must_use]
    pub fn observer(mut self, observer: &'a mut dyn Observer) -> Self {
        self.observers.push(observer);
        self
    }

    /// Hands batches to `evaluator` instead of threads.
    #[must_use]
    pub fn evaluator(mut self, evaluator: &'a dyn Evaluator) -> Self {
        self.evaluator = evaluator;
        self
    }

    /// Writes every answer to `checkpoint`, after taking from it those that an interrupted run has left there.
    #[must_use]
    pub fn checkpoint(mut self, checkpoint: Checkpoint) -> Self {
        self.checkpoint = Some(checkpoint);
        self
    }

    /// Number of parameters, the length of x.
    pub fn n_parameters(&self) -> usize {
        self.objective.n_parameters()
    }

    /// Number of residuals.
    pub fn n_residuals(&self) -> usize {
        self.objective.n_residuals()
    }

    /// Which residuals stand for constraints.
    pub fn walls(&self) -> Walls {
        self.objective.walls()
    }

    /// Evaluations left to the method at work, if limited.
    pub fn remaining(&self) -> Option<u64> {
        self.scope.limit.map(|limit| limit.saturating_sub(self.count.spent()))
    }

    /// The best point and cost that the method at work has met.
    pub fn best(&self) -> Option<(&DVector<f64>, f64)> {
        self.scope.best.as_ref().map(|(x, cost)| (x, *cost))
    }

    /// A random stream of the method at work; equal numbers give equal streams, others independent ones.
    pub fn rng(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(mix(self.scope.stream ^ mix(stream)));
        rng
    }

    /// A seed for something random outside this run, derived like [`rng`](Self::rng).
    pub(crate) fn seed_for(&self, stream: u64) -> u64 {
        mix(self.seed ^ mix(self.scope.stream ^ mix(stream)))
    }

    /// The start, checked and moved into the unit box.
    pub fn clip(&self, start: &DVector<f64>) -> Result<DVector<f64>, OptimError> {
        if self.n_parameters() == 0 {
            return Err(OptimError::NoParameters);
        }
        if start.len() != self.n_parameters() {
            return Err(OptimError::StartLength { found: start.len(), expected: self.n_parameters() });
        }
        match start.iter().position(|v| !v.is_finite()) {
            Some(parameter) => Err(OptimError::StartNotFinite { parameter, value: start[parameter] }),
            None => Ok(start.map(|v| v.clamp(0.0, 1.0))),
        }
    }

    /// The costs of the points, overwriting `out`; a point that cannot be evaluated costs +∞.
    ///
    /// If the budget ends inside the batch, its first points are evaluated and count; the rest is not.
    ///
    /// # Panics
    /// If `out` and `points` differ in length.
    pub fn costs(&mut self, points: &[DVector<f64>], out: &mut [f64]) -> Result<(), Stop> {
        assert_eq!(points.len(), out.len(), "one cost a point");
        let n = self.admit(points)?;
        let (points, out) = (&points[..n], &mut out[..n]);

        let done = self.replay_costs(points, out)?;
        if done < n {
            let before = self.objective.path_counts();
            self.evaluate(&points[done..], &mut out[done..])?;
            self.confirm(points, out);
            let after = self.objective.path_counts();
            let paths = PathCounts { batch: after.batch - before.batch, reference: after.reference - before.reference };
            self.count.add(paths);
            self.record(|checkpoint| checkpoint.append_costs(&points[done..], &out[done..], paths));
        }

        for (x, &cost) in points.iter().zip(out.iter()) {
            self.count.evaluations += 1;
            self.count.failures += u64::from(!cost.is_finite());
            self.scope.keep(x, cost, self.count.spent());
        }
        self.report();
        match &self.scope.best {
            Some((_, cost)) if *cost <= self.target => Err(Stop::Ended(Termination::TargetReached)),
            _ => Ok(()),
        }
    }

    /// The cost of one point.
    pub fn cost(&mut self, x: &DVector<f64>) -> Result<f64, Stop> {
        let mut cost = [f64::INFINITY];
        self.costs(std::slice::from_ref(x), &mut cost)?;
        Ok(cost[0])
    }

    /// Residuals and Jacobians at the points, in order; if the budget ends among them, the run stops.
    pub fn linearizations(&mut self, points: &[DVector<f64>]) -> Result<Vec<Result<Linearization, EvalError>>, Stop> {
        if self.admit(points)? < points.len() {
            return Err(Stop::Ended(Termination::BudgetSpent));
        }
        let replayed = match self.open_checkpoint()? {
            Some(checkpoint) => checkpoint.next_linearizations(points).map_err(OptimError::from)?,
            None => None,
        };
        let results = if let Some(results) = replayed {
            self.count.replayed += points.len() as u64;
            results
        } else {
            let results = self
                .evaluator
                .linearizations(self.objective, points, &self.cancel)
                .map_err(|source| OptimError::Evaluator { source })?;
            self.stop_if_cancelled()?;
            self.record(|checkpoint| checkpoint.append_linearizations(points, &results));
            results
        };
        self.count.linearizations += points.len() as u64;
        self.report();
        Ok(results)
    }

    /// Residuals and Jacobian at one point.
    pub fn linearize(&mut self, x: &DVector<f64>) -> Result<Result<Linearization, EvalError>, Stop> {
        let results = self.linearizations(std::slice::from_ref(x))?;
        results.into_iter().next().ok_or_else(|| OptimError::Evaluator { source: "no answer".into() }.into())
    }

    /// Runs `search` as the method `name`, with a best point, history and random streams of its own, and makes the result.
    pub fn conclude(
        &mut self,
        name: &str,
        search: impl FnOnce(&mut Self) -> Result<Termination, Stop>,
    ) -> Result<Optimum, OptimError> {
        self.n_scopes += 1;
        let inner = Scope {
            method: name.to_owned(),
            limit: self.scope.limit,
            stream: mix(self.scope.stream ^ self.n_scopes),
            ..Scope::default()
        };
        let before = self.count;
        let outer = std::mem::replace(&mut self.scope, inner);
        let ended = search(self);
        let inner = std::mem::replace(&mut self.scope, outer);
        self.scope.absorb(&inner);

        let termination = match ended {
            Ok(termination) | Err(Stop::Ended(termination)) => termination,
            Err(Stop::Failed(error)) => return Err(error),
        };
        self.record(Checkpoint::flush);
        let evaluations = self.count.evaluations - before.evaluations;
        let Some((x, cost)) = inner.best else {
            return Err(OptimError::NoFinitePoint { evaluations, termination });
        };
        Ok(Optimum {
            method: inner.method,
            x,
            cost,
            termination,
            evaluations,
            linearizations: self.count.linearizations - before.linearizations,
            failures: self.count.failures - before.failures,
            paths: PathCounts {
                batch: self.count.paths.batch - before.paths.batch,
                reference: self.count.paths.reference - before.paths.reference,
            },
            history: inner.history,
            stages: Vec::new(),
            optima: Vec::new(),
            n_starts: 0,
            warnings: self.warnings.clone(),
        })
    }

    /// Runs `search` with at most so many further evaluations.
    pub fn within<T>(&mut self, evaluations: u64, search: impl FnOnce(&mut Self) -> T) -> T {
        let outer = self.scope.limit;
        let inner = self.count.spent().saturating_add(evaluations);
        self.scope.limit = Some(outer.map_or(inner, |outer| outer.min(inner)));
        let result = search(self);
        self.scope.limit = outer;
        result
    }

    /// How many of the points may be evaluated: an error if none.
    fn admit(&self, points: &[DVector<f64>]) -> Result<usize, Stop> {
        for x in points {
            assert_eq!(x.len(), self.n_parameters(), "a point has one value a parameter");
            // without a branch for each value
            let is_inside = x.iter().fold(true, |inside, v| inside & (0.0..=1.0).contains(v));
            if !is_inside && let Some(parameter) = x.iter().position(|v| !(0.0..=1.0).contains(v)) {
                return Err(OptimError::OutsideBox { parameter, value: x[parameter] }.into());
            }
        }
        self.stop_if_cancelled()?;
        let remaining = self.remaining().map_or(usize::MAX, |n| usize::try_from(n).unwrap_or(usize::MAX));
        if remaining == 0 && !points.is_empty() {
            return Err(Stop::Ended(Termination::BudgetSpent));
        }
        Ok(points.len().min(remaining))
    }

    fn stop_if_cancelled(&self) -> Result<(), Stop> {
        if self.cancel.load(Ordering::Relaxed) { Err(Stop::Ended(Termination::Cancelled)) } else { Ok(()) }
    }

    fn evaluate(&self, points: &[DVector<f64>], out: &mut [f64]) -> Result<(), Stop> {
        self.evaluator
            .costs(self.objective, points, out, &self.cancel)
            .map_err(|source| OptimError::Evaluator { source })?;
        self.stop_if_cancelled()?;
        for cost in out {
            if !cost.is_finite() {
                *cost = f64::INFINITY;
            }
        }
        Ok(())
    }

    /// Has the best point of a batch confirmed before it becomes the best of the run; a cost found wrong is replaced. The search goes on
    /// with the right one, so that nobody need know.
    fn confirm(&mut self, points: &[DVector<f64>], out: &mut [f64]) {
        let known = self.scope.best.as_ref().map_or(f64::INFINITY, |(_, cost)| *cost);
        loop {
            let best = (0..out.len()).min_by(|&a, &b| out[a].total_cmp(&out[b]).then(a.cmp(&b)));
            let Some(best) = best.filter(|&i| out[i] < known) else { return };
            let confirmed = self.objective.confirm(&points[best], out[best]);
            if confirmed.to_bits() == out[best].to_bits() {
                return;
            }
            out[best] = if confirmed.is_finite() { confirmed } else { f64::INFINITY };
        }
    }

    /// The checkpoint, with its head read or written.
    fn open_checkpoint(&mut self) -> Result<Option<&mut Checkpoint>, Stop> {
        let fingerprint = Fingerprint {
            seed: self.seed,
            n_parameters: self.objective.n_parameters() as u64,
            n_residuals: self.objective.n_residuals() as u64,
        };
        let Some(checkpoint) = &mut self.checkpoint else { return Ok(None) };
        checkpoint.begin(&fingerprint, self.budget).map_err(OptimError::from)?;
        Ok(Some(checkpoint))
    }

    /// Takes the first costs from the checkpoint, as many as it has, and returns their number.
    ///
    /// The first recorded cost is evaluated again: if its bits differ, the model or the test has changed.
    fn replay_costs(&mut self, points: &[DVector<f64>], out: &mut [f64]) -> Result<usize, Stop> {
        let mut done = 0;
        while done < points.len()
            && let Some(checkpoint) = self.open_checkpoint()?
            && let Some((n, paths)) =
                checkpoint.next_costs(&points[done..], &mut out[done..]).map_err(OptimError::from)?
        {
            if self.count.replayed == 0 {
                let mut again = [f64::INFINITY];
                self.evaluate(&points[..1], &mut again)?;
                if again[0].to_bits() != out[0].to_bits() {
                    again[0] = self.objective.confirm(&points[0], again[0]);
                }
                if again[0].to_bits() != out[0].to_bits()
                    && let Some(checkpoint) = &self.checkpoint
                {
                    return Err(OptimError::from(checkpoint.other_objective(out[0], again[0])).into());
                }
            }
            done += n;
            self.count.replayed += n as u64;
            self.count.add(paths);
        }
        Ok(done)
    }

    /// Writes to the checkpoint. A run does not end for a disk that fills up later: it goes on without, and says so.
    fn record(&mut self, write: impl FnOnce(&mut Checkpoint) -> Result<(), CheckpointError>) {
        if let Some(checkpoint) = &mut self.checkpoint
            && let Err(error) = write(checkpoint)
        {
            self.checkpoint = None;
            self.warnings.push(format!("the run cannot be resumed beyond evaluation {}: {error}", self.count.spent()));
        }
    }

    fn report(&mut self) {
        let progress = Progress {
            method: &self.scope.method,
            evaluations: self.count.spent(),
            replayed: self.count.replayed,
            budget: self.budget,
            cost: self.scope.best.as_ref().map_or(f64::INFINITY, |(_, cost)| *cost),
            x: self.scope.best.as_ref().map(|(x, _)| x),
        };
        for observer in &mut self.observers {
            observer.progress(&progress);
        }
    }
}

impl Scope {
    fn keep(&mut self, x: &DVector<f64>, cost: f64, evaluations: u64) {
        match &mut self.best {
            Some((best, best_cost)) if cost < *best_cost => {
                best.copy_from(x);
                *best_cost = cost;
            }
            None if cost.is_finite() => self.best = Some((x.clone(), cost)),
            _ => return,
        }
        self.history.push(Improvement { evaluations, cost });
    }

    /// Takes over what a method inside this one has found.
    fn absorb(&mut self, inner: &Self) {
        let known = self.best.as_ref().map_or(f64::INFINITY, |(_, cost)| *cost);
        self.history.extend(inner.history.iter().filter(|i| i.cost < known));
        if let Some((x, cost)) = &inner.best
            && *cost < known
        {
            self.best = Some((x.clone(), *cost));
        }
    }
}

/// Steele, Lea and Flood's 64-bit finalizer (SplitMix, 2014): distinct numbers become unrelated ones.
fn mix(z: u64) -> u64 {
    let z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
