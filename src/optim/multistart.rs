//! A local method from many starts.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::random::latin_hypercube;
use super::{
    About, Ask, AskTell, LevenbergMarquardt, LocalOptimum, OptimError, Optimizer, OptimizerSpec, Optimum, Problem, Run,
    Stop, Termination,
};
use crate::linalg::DVector;

/// A local method from many starts, and which optima they found.
///
/// ```text
/// optimizer: {multistart: {local: levenberg-marquardt, starts: 40}}
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Multistart {
    /// The method that is started.
    pub local: Box<OptimizerSpec>,
    /// Starts, at most, 1 to 10000; the first is the given start, the others fill the box.
    pub starts: usize,
    /// Starts before it may end early; small models can afford more, and an optimum of a narrow valley needs them.
    pub fewest: usize,
    /// Whether to end before the last start once further optima are improbable.
    pub early_end: bool,
    /// Optima whose costs differ by less than this, relatively, and that no ridge separates, count as one.
    pub same: f64,
}

impl Default for Multistart {
    fn default() -> Self {
        Self {
            local: Box::new(OptimizerSpec::LevenbergMarquardt(LevenbergMarquardt::default())),
            starts: 40,
            fewest: WAVE,
            early_end: true,
            same: 1e-3,
        }
    }
}

/// What `retune explain multistart` tells.
pub(super) const ABOUT: About = About {
    name: "multistart",
    summary: "a local method from many starts; says how many found the best optimum and which others exist",
    theory: "The given start and points of a Latin hypercube are descended from, eight at a time in step, so that their \
evaluations form batches. Two end points are one optimum if their costs agree and the cost half way between them is no \
higher; parameters that the data cannot tell apart thus do not multiply optima. From W optima met in N starts, Boender and \
Rinnooy Kan's posterior expectation of their true number is W (N - 1)/(N - W - 2); the search ends when that is below W + ½: \
after 8 starts if all agree.",
    sources: &[
        "C. G. E. Boender, A. H. G. Rinnooy Kan, Bayesian stopping rules for multistart global optimization methods, Mathematical Programming 37, 1987",
        "M. D. McKay, R. J. Beckman, W. J. Conover, A comparison of three methods for selecting values of input variables in the analysis of output from a computer code, Technometrics 21, 1979",
    ],
};

/// Starts that advance together.
const WAVE: usize = 8;
/// Costs below this (in squares of standard deviations) are equal.
const NO_COST: f64 = 1e-8;

impl Optimizer for Multistart {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        self.validate()?;
        let start = run.clip(start)?;
        let mut met = Met::default();
        let mut optimum = run.conclude(self.name(), |run| self.search(&start, &mut met, run))?;
        optimum.optima = met.optima;
        optimum.n_starts = met.n_starts;
        Ok(optimum)
    }
}

impl Multistart {
    fn validate(&self) -> Result<(), OptimError> {
        if !(1..=10_000).contains(&self.starts) {
            return Err(OptimError::setting(ABOUT.name, "starts", self.starts, "between 1 and 10000"));
        }
        if !(0.0..1.0).contains(&self.same) {
            return Err(OptimError::setting(ABOUT.name, "same", self.same, "at least 0 and below 1"));
        }
        Ok(())
    }

    fn search(&self, start: &DVector<f64>, met: &mut Met, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let local: Arc<dyn Optimizer> = Arc::new(self.local.as_ref().clone());
        let mut starts = latin_hypercube(self.starts, start.len(), &mut run.rng(0));
        starts[0].copy_from(start);
        for wave in starts.chunks(WAVE) {
            let share = run.remaining().map(|n| (n / wave.len() as u64).max(1));
            let mut searches: Vec<AskTell> = wave
                .iter()
                .enumerate()
                .map(|(i, x)| {
                    let seed = run.seed_for((met.n_starts + i) as u64 + 1);
                    let problem =
                        Problem { n_parameters: x.len(), n_residuals: run.n_residuals(), seed, budget: share };
                    AskTell::with_walls(Arc::clone(&local), x.clone(), problem, run.walls())
                })
                .collect();
            let mut cut_short = false;
            for found in in_step(&mut searches, run)? {
                match found {
                    // an end point for want of evaluations is not an optimum
                    Some(found) if found.termination == Termination::BudgetSpent => cut_short = true,
                    Some(found) => met.classify(found, self.same, run)?,
                    None => met.n_starts += 1,
                }
            }
            if cut_short {
                return Ok(Termination::BudgetSpent);
            }
            if self.early_end && met.n_starts >= self.fewest && met.is_probably_all() {
                break;
            }
        }
        Ok(Termination::PlanDone)
    }
}

/// Advances searches together: the open questions of all form one batch. Returns their results, nothing for a search
/// that found no finite cost.
fn in_step(searches: &mut [AskTell], run: &mut Run<'_>) -> Result<Vec<Option<Optimum>>, Stop> {
    let mut found: Vec<Option<Optimum>> = vec![None; searches.len()];
    let mut running = vec![true; searches.len()];
    // how many costs and linearizations each search asks for
    let mut shares = vec![(0, 0); searches.len()];
    let (mut points, mut places): (Vec<DVector<f64>>, Vec<DVector<f64>>) = Default::default();
    let mut costs = Vec::new();
    loop {
        points.clear();
        places.clear();
        shares.fill((0, 0));
        for (i, search) in searches.iter_mut().enumerate() {
            if !running[i] {
                continue;
            }
            match search.ask() {
                Ok(Ask::Costs(asked)) => {
                    points.extend_from_slice(asked);
                    shares[i].0 = asked.len();
                }
                Ok(Ask::Linearizations(asked)) => {
                    places.extend_from_slice(asked);
                    shares[i].1 = asked.len();
                }
                Ok(Ask::Done(optimum)) => {
                    found[i] = Some(optimum.clone());
                    running[i] = false;
                }
                Err(OptimError::NoFinitePoint { .. } | OptimError::Linearization { .. }) => running[i] = false,
                Err(error) => return Err(error.into()),
            }
        }
        if !running.contains(&true) {
            return Ok(found);
        }
        costs.resize(points.len(), f64::INFINITY);
        run.costs(&points, &mut costs)?;
        let mut linearizations = if places.is_empty() { Vec::new() } else { run.linearizations(&places)? }.into_iter();
        let mut told = 0;
        for (search, &(n_costs, n_places)) in searches.iter_mut().zip(&shares) {
            if n_costs > 0 {
                search.tell_costs(&costs[told..told + n_costs])?;
                told += n_costs;
            }
            if n_places > 0 {
                search.tell_linearizations(linearizations.by_ref().take(n_places).collect())?;
            }
        }
    }
}

/// The optima met so far, best first.
#[derive(Debug, Default)]
struct Met {
    optima: Vec<LocalOptimum>,
    n_starts: usize,
}

impl Met {
    /// Counts an end point towards a known optimum, or as a new one.
    fn classify(&mut self, found: Optimum, same: f64, run: &mut Run<'_>) -> Result<(), Stop> {
        let Optimum { x, cost, .. } = found;
        self.n_starts += 1;
        for optimum in &mut self.optima {
            let higher = cost.max(optimum.cost);
            let tolerance = same * higher.abs() + NO_COST;
            if (cost - optimum.cost).abs() > tolerance {
                continue;
            }
            let half_way = (&x + &optimum.x) * 0.5;
            if run.cost(&half_way)? <= higher + tolerance {
                optimum.n_starts += 1;
                if cost < optimum.cost {
                    (optimum.x, optimum.cost) = (x, cost);
                    self.optima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
                }
                return Ok(());
            }
        }
        self.optima.push(LocalOptimum { x, cost, n_starts: 1 });
        self.optima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        Ok(())
    }

    /// Boender and Rinnooy Kan's rule.
    fn is_probably_all(&self) -> bool {
        let (w, n) = (self.optima.len() as f64, self.n_starts as f64);
        w > 0.0 && n > w + 2.0 && w * (n - 1.0) / (n - w - 2.0) < w + 0.5
    }
}
