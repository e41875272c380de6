//! The only fitter: many starts, of which few survive (successive halving).
//!
//! An [`Entry`] is a problem with runners, each a point of its box. In a round, runners are chosen by Φ and moved by a few damped Gauss-Newton steps; after
//! it, entries by the Φ of their best runner. Whatever is fitted is fitted so: one problem from many starts, or many hypotheses of which the
//! best deserve more steps.
//!
//! # Source
//! K. Jamieson, A. Talwalkar, Non-stochastic best arm identification and hyperparameter optimization, AISTATS 2016.

use super::fit::{Fit, evaluate};
use super::rows::Posed;
use super::scene::Scene;
use crate::effort::Effort;
use crate::error::DiagnosisError;
use crate::thresholds::FIT_TOLERANCE;
use rayon::prelude::*;
use retune::linalg::DVector;
use retune::linalg::batch::BATCH;
use retune::objective::{BatchPath, Objective};
use retune::optim::{LevenbergMarquardt, Optimizer, Run};
use std::sync::Arc;

/// Steps of a fit, at most.
pub(crate) const STEPS: usize = 60;

/// Which runners of an entry take part in a round.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Pick {
    /// The first of all and the lowest of the others, so many in all.
    Lowest(usize),
    /// The same of every group: those that look best may all lie in one basin, those of different groups hardly do.
    OfEach(usize),
}

/// Which entries go on after a round.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Keep {
    All,
    /// All; the lower half alone runs in the rounds that follow.
    HalfAhead,
    /// The lower half.
    Half,
    Best(usize),
}

/// What an entry does in a round.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Round {
    pub(crate) pick: Pick,
    /// Of each runner, at most.
    pub(crate) steps: usize,
}

/// A point of the box, and Φ there once it is known.
#[derive(Debug, Clone)]
struct Runner {
    x: DVector<f64>,
    phi: Option<f64>,
}

/// A problem, the points from which it is fitted, and its rounds.
#[derive(Debug, Clone)]
pub(crate) struct Entry<T> {
    /// What the problem is, for the caller.
    pub(crate) of: T,
    pub(crate) scene: Scene,
    rounds: Vec<Round>,
    /// In groups; after a round the lowest first.
    groups: Vec<Vec<Runner>>,
    /// The way of every test to the batched kernel, compiled once for all rounds.
    kernels: Vec<Arc<BatchPath>>,
}

impl<T> Entry<T> {
    /// * `groups` - starts that belong together
    pub(crate) fn new(of: T, scene: Scene, groups: &[Vec<DVector<f64>>], rounds: Vec<Round>) -> Self {
        let runner = |x: &DVector<f64>| Runner { x: x.clone(), phi: None };
        let kernels = scene.cases.iter().map(|_| Arc::new(BatchPath::with_derivatives())).collect();
        let groups = groups.iter().map(|g| g.iter().map(runner).collect()).collect();
        Self { of, scene, rounds, groups, kernels }
    }

    /// Φ of the best runner; infinite before the first round.
    pub(crate) fn phi(&self) -> f64 {
        self.groups.iter().flatten().filter_map(|r| r.phi).fold(f64::INFINITY, f64::min)
    }

    /// The problem at its best runner.
    ///
    /// # Errors
    /// There is none, or it cannot be evaluated.
    pub(crate) fn fit(&self, weight: f64) -> Result<Fit, DiagnosisError> {
        let best = self.groups.iter().flatten().next().ok_or(DiagnosisError::NoStart)?;
        evaluate(&self.scene, best.x.clone(), weight)
    }

    /// A round; its runners are all that is left, in one group, the lowest first.
    fn run(&mut self, round: usize, weight: f64) -> Result<(), DiagnosisError> {
        let Some(&Round { pick, steps }) = self.rounds.get(round) else { return Ok(()) };
        if round == 0 {
            self.scene.work.fit();
        }
        let comparisons = self.scene.comparisons()?;
        let posed = Posed::new(&self.scene, &comparisons, self.scene.priors(), weight).through(&self.kernels);
        if posed.n_parameters() == 0 {
            self.groups = vec![vec![Runner { x: DVector::zeros(0), phi: None }]];
            return Ok(());
        }
        let mut chosen: Vec<DVector<f64>> = match pick {
            Pick::Lowest(most) => lowest(&posed, &self.groups.concat(), most),
            Pick::OfEach(most) => self.groups.iter().flat_map(|group| lowest(&posed, group, most)).collect(),
        };
        let method = LevenbergMarquardt { steps, tolerance: FIT_TOLERANCE, ..LevenbergMarquardt::default() };
        if round == 0 && self.scene.has_functions() {
            chosen = through_modes(&self.scene, &posed, chosen, weight, &method);
        }
        // Compiled once, before several threads ask for it.
        posed.costs(&[], &mut []);
        let run = |start: &DVector<f64>| method.minimize(start, &mut Run::new(&posed));
        let found: Vec<_> = chosen.par_iter().map(run).collect();
        let mut runners = Vec::with_capacity(found.len());
        let mut failure = None;
        for result in found {
            match result {
                Ok(o) => runners.push(Runner { phi: Some(o.cost), x: o.x }),
                Err(e) => failure = Some(e),
            }
        }
        if let Some(e) = failure.filter(|_| runners.is_empty()) {
            return Err(e.into());
        }
        // Stable: of equal ones the first stays first.
        let phi = |r: &Runner| r.phi.unwrap_or(f64::INFINITY);
        runners.sort_by(|a, b| phi(a).total_cmp(&phi(b)));
        self.groups = vec![runners];
        self.kernels.iter().for_each(|kernel| kernel.rest());
        Ok(())
    }
}

/// Fits a scene from several starts and keeps the lowest; the first of equal ones.
///
/// # Errors
/// No start can be evaluated.
pub(crate) fn fit(scene: &Scene, starts: &[DVector<f64>], weight: f64) -> Result<Fit, DiagnosisError> {
    fit_by(scene, &[starts.to_vec()], vec![Round { pick: Pick::Lowest(starts.len()), steps: STEPS }], weight)
}

/// Fits a scene from groups of starts by these rounds.
///
/// # Errors
/// As [`fit`].
pub(crate) fn fit_by(
    scene: &Scene,
    groups: &[Vec<DVector<f64>>],
    rounds: Vec<Round>,
    weight: f64,
) -> Result<Fit, DiagnosisError> {
    let count = rounds.len();
    let mut alone = Entry::new((), scene.clone(), groups, rounds);
    (0..count).try_for_each(|round| alone.run(round, weight))?;
    alone.fit(weight)
}

/// Rounds of a full fit: half of the runners go on after a few steps, half of these after twice as many, and the best to the end.
///
/// * `groups` - number of groups of starts: where one of each is more than the effort has, they are told apart before
/// * `of_each` - how many of a group
pub(crate) fn in_full(groups: usize, of_each: usize, effort: &Effort) -> Vec<Round> {
    let (few, steps) = (effort.starts, effort.first_steps);
    let many = groups * of_each > few;
    let of_each = many.then_some(Round { pick: Pick::OfEach(of_each), steps });
    let halving = [(few, steps), (few.div_ceil(2), 2 * steps), (1, STEPS)];
    of_each.into_iter().chain(halving.map(|(n, steps)| Round { pick: Pick::Lowest(n), steps })).collect()
}

/// Entries after all rounds, the lowest first; those that cannot be evaluated are left out.
///
/// * `keep` - for every round, which go on after it
/// * `may_run` - asked before an entry runs for the first time
pub(crate) fn race<T: Send>(
    mut entries: Vec<Entry<T>>,
    keep: &[Keep],
    weight: f64,
    may_run: impl Fn() -> bool + Sync,
) -> Vec<Entry<T>> {
    let mut in_race = entries.len();
    for (round, keep) in keep.iter().enumerate() {
        // An entry that fails later stays where it was.
        let run = |entry: &mut Entry<T>| {
            let done = (round > 0 || may_run()) && entry.run(round, weight).is_ok();
            done || round > 0
        };
        let ran: Vec<bool> = entries[..in_race].par_iter_mut().map(run).collect();
        let mut ran = ran.into_iter().chain(std::iter::repeat(true));
        entries.retain(|e| ran.next() == Some(true) && e.phi().is_finite());
        in_race = in_race.min(entries.len());
        // Stable: of equal ones the first stays first.
        entries[..in_race].sort_by(|a, b| a.phi().total_cmp(&b.phi()));
        match *keep {
            Keep::All => {}
            Keep::HalfAhead => in_race = in_race.div_ceil(2),
            Keep::Half => entries.truncate(entries.len().div_ceil(2)),
            Keep::Best(few) => entries.truncate(few),
        }
        in_race = in_race.min(entries.len());
    }
    entries
}

/// The first of the runners, then those with the lowest objective, in that order.
fn lowest(posed: &Posed<'_>, runners: &[Runner], most: usize) -> Vec<DVector<f64>> {
    let at = |r: &Runner| r.x.clone();
    if runners.len() <= most {
        return runners.iter().map(at).collect();
    }
    let unknown: Vec<DVector<f64>> = runners[1..].iter().filter(|r| r.phi.is_none()).map(at).collect();
    let mut found = vec![f64::INFINITY; unknown.len()];
    // As above.
    posed.costs(&[], &mut []);
    unknown.par_chunks(BATCH).zip(found.par_chunks_mut(BATCH)).for_each(|(points, out)| posed.costs(points, out));
    let mut found = found.into_iter();
    let mut phi = |r: &Runner| r.phi.or_else(|| found.next()).unwrap_or(f64::INFINITY);
    let mut costs: Vec<(f64, usize)> = runners.iter().enumerate().skip(1).map(|(i, r)| (phi(r), i)).collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    std::iter::once(0).chain(costs.iter().map(|c| c.1)).take(most).map(|i| at(&runners[i])).collect()
}

/// Starts from where the modes alone lead, where frequency responses agree better there.
///
/// Amplitudes have a basin for every resonance that may be taken for another: a start that is a bandwidth away ends in a wrong one. The
/// modes have been paired by their shapes, and a fit to them costs little.
fn through_modes(
    scene: &Scene,
    posed: &Posed<'_>,
    starts: Vec<DVector<f64>>,
    weight: f64,
    method: &LevenbergMarquardt,
) -> Vec<DVector<f64>> {
    let of_modes = scene.without_functions();
    let Ok(comparisons) = of_modes.comparisons() else { return starts };
    let modes = Posed::new(&of_modes, &comparisons, scene.priors(), weight);
    let method = LevenbergMarquardt { steps: method.steps.max(FEWEST_STEPS), ..*method };
    let cost = |x: &DVector<f64>| posed.cost(x).unwrap_or(f64::INFINITY);
    let through = |start: DVector<f64>| match method.minimize(&start, &mut Run::new(&modes)) {
        Ok(found) if cost(&found.x) < cost(&start) => found.x,
        _ => start,
    };
    starts.into_par_iter().map(through).collect()
}

/// Steps of a fit to the modes, at least: those are cheap.
const FEWEST_STEPS: usize = 8;
