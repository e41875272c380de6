//! Methods one after another.

use super::{
    About, DifferentialEvolution, Multistart, NelderMead, OptimError, Optimizer, OptimizerSpec, Optimum, Run, Stop,
    Termination,
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
    /// A global search without derivatives, then a local refiner: for costs with many kinks and minima in wide valleys,
    /// such as the paper's, with shapes and constraints in it.
    ///
    /// ```text
    /// optimizer: [{differential-evolution: {generations: 500}}, nelder-mead]
    /// ```
    ///
    /// At most 50 000 evaluations in 500 generations of 100, and some thousand local ones. Audited on the Body Freedom
    /// Flutter aircraft, 19 parameters: all of ten seeds find the known global minimum of the paper's cost to nine digits
    /// with 30 000 to 36 000 evaluations; the paper's own settings (`strategy: classic`, 20 000 evaluations) are known to
    /// stop at 1.3 to 1.8 times that cost.
    pub fn global_then_local() -> Self {
        let global = DifferentialEvolution { generations: Some(500), ..DifferentialEvolution::default() };
        Self {
            steps: vec![OptimizerSpec::DifferentialEvolution(global), OptimizerSpec::NelderMead(NelderMead::default())],
        }
    }

    /// Local searches with derivatives from 40 starts, then a local refiner: for costs that are smooth but for a few kinks
    /// and whose best minimum may be a narrow one, such as frequency errors under constraints.
    ///
    /// ```text
    /// optimizer: [{multistart: {starts: 40, early_end: false}}, nelder-mead]
    /// ```
    ///
    /// Gradient steps end where they meet the kink of a constraint; the simplex, which does not mind, goes on from the best
    /// of the 40. Audited on the same aircraft, frequencies only, modes kept in their families: all of ten seeds find the
    /// lowest of four known minima within 1e-7 of its value, with 18 000 to 58 000 evaluations. It attracts one start in
    /// five, and [`Self::global_then_local`] misses it nine times in ten.
    pub fn many_starts_then_local() -> Self {
        let many = Multistart { early_end: false, ..Multistart::default() };
        Self { steps: vec![OptimizerSpec::Multistart(many), OptimizerSpec::NelderMead(NelderMead::default())] }
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
