//! Methods one after another.

use super::{
    About, DifferentialEvolution, NelderMead, OptimError, Optimizer, OptimizerSpec, Optimum, Run, Stop, Termination,
};
use crate::linalg::DVector;

/// Methods that hand their best point on: a global search, then a local refiner.
///
/// ```text
/// optimizer: [differential-evolution, nelder-mead]
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// The methods, in order; at least one.
    pub steps: Vec<OptimizerSpec>,
}

impl Sequence {
    /// A global search without derivatives, then a local refiner: for costs with kinks, such as norms of errors and
    /// penalties of constraints, and with many minima.
    ///
    /// ```text
    /// optimizer: [{differential-evolution: {generations: 500}}, nelder-mead]
    /// ```
    ///
    /// Up to 50 000 evaluations in 500 generations of 100, and the local ones. Audited on the Body Freedom Flutter
    /// aircraft, 19 parameters: within 60 000 evaluations it finds the known global minimum of the paper's cost, where
    /// the paper's own settings (`strategy: classic`, 200 x 100) stop at 1.3 to 1.8 times that cost.
    pub fn global_then_local() -> Self {
        let global = DifferentialEvolution { generations: Some(500), ..DifferentialEvolution::default() };
        let steps =
            vec![OptimizerSpec::DifferentialEvolution(global), OptimizerSpec::NelderMead(NelderMead::default())];
        Self { steps }
    }
}

/// What `retune explain sequence` tells.
pub(super) const ABOUT: About = About {
    name: "sequence",
    summary: "methods one after another, written as a list; each starts from the best point of the one before",
    theory: "A global search finds the basin, a local method its bottom: [differential-evolution, nelder-mead]. The budget is \
shared: each method leaves a tenth of what it finds to each of the methods after it.",
    sources: &[],
};

impl Optimizer for Sequence {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        if self.steps.is_empty() {
            let expected = "a list of at least one optimizer".to_owned();
            return Err(OptimError::Setting { method: ABOUT.name, setting: "steps", value: "empty".into(), expected });
        }
        let steps: Vec<&dyn Optimizer> = self.steps.iter().map(OptimizerSpec::as_dyn).collect();
        in_sequence(&steps, start, run)
    }
}

/// Runs methods one after another, each from the best point so far; a user's own may be among them.
///
/// Each method leaves a tenth of the evaluations it finds to each method after it. The sequence ends early when the run
/// is cancelled or its target is reached.
pub fn in_sequence(steps: &[&dyn Optimizer], start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
    let start = run.clip(start)?;
    let mut stages = Vec::new();
    let (mut optima, mut n_starts) = (Vec::new(), 0);
    let mut optimum = run.conclude(ABOUT.name, |run| {
        let mut termination = Termination::PlanDone;
        for (i, step) in steps.iter().enumerate() {
            let from = run.best().map_or_else(|| start.clone(), |(x, _)| x.clone());
            let later = (steps.len() - 1 - i).min(9) as u64;
            let share = run.remaining().map_or(u64::MAX, |n| n - n / 10 * later);
            let found = run.within(share, |run| step.minimize(&from, run));
            termination = match found {
                Ok(found) => {
                    stages.push(found.stage());
                    if n_starts == 0 {
                        (optima, n_starts) = (found.optima, found.n_starts);
                    }
                    found.termination
                }
                // nothing was evaluated any more, but the steps before have a result
                Err(OptimError::NoFinitePoint { termination, .. }) if run.best().is_some() => termination,
                Err(error) => return Err(Stop::Failed(error)),
            };
            if termination.ends_the_run() {
                break;
            }
        }
        Ok(termination)
    })?;
    optimum.stages = stages;
    optimum.optima = optima;
    optimum.n_starts = n_starts;
    Ok(optimum)
}
