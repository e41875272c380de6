//! The default: multistart with derivatives, a global search as insurance, a refinement.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    About, CmaEs, LevenbergMarquardt, LocalOptimum, Multistart, NelderMead, OptimError, Optimizer, Optimum, Run, Stage,
    Stop, Termination,
};
use crate::linalg::DVector;

/// Multistart with derivatives, insured by a global search without.
///
/// ```text
/// optimizer: {auto: {starts: 24, insurance: 1000}}
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Auto {
    /// Starts of the local method, at most, 1 to 10000.
    pub starts: usize,
    /// Starts before they may end early because further optima are improbable.
    pub fewest: usize,
    /// Evaluations of the global search at most, and at most 200 a parameter; 0 for none.
    pub insurance: u64,
}

impl Default for Auto {
    fn default() -> Self {
        Self { starts: 24, fewest: 8, insurance: 1000 }
    }
}

/// What `retune explain auto` tells.
pub(super) const ABOUT: About = About {
    name: "auto",
    summary: "multistart with derivatives, a global search as insurance, and what each of them found; the default",
    theory: "First levenberg-marquardt from many starts (see multistart): the fastest way to the optimum when there are \
derivatives. Then cma-es from the given start, which knows nothing of what was found: if its best point, refined, is \
better, the landscape has an optimum that the starts missed, and the result says so. Last, if the cost is neither ½ rᵀr \
nor a norm or a constraint that its residuals express, nelder-mead refines the best point on the cost itself.",
    sources: &[
        "C. G. E. Boender, A. H. G. Rinnooy Kan, Bayesian stopping rules for multistart global optimization methods, Mathematical Programming 37, 1987",
        "N. Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772, 2016",
    ],
};

/// Relative deviation of the cost from ½ rᵀr that rounding explains.
const ROUNDING: f64 = 1e-9;
/// Evaluations of the global search for each parameter: it needs about a hundred to converge along one (Hansen, section 5), and what it would do
/// beyond that, with few parameters, it does at one place.
const INSURANCE_EACH: u64 = 200;
/// A cost below this is nothing (sums of squares in units of standard deviations).
const NO_COST: f64 = 1e-8;

impl Optimizer for Auto {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        if !(1..=10_000).contains(&self.starts) {
            return Err(OptimError::setting(ABOUT.name, "starts", self.starts, "between 1 and 10000"));
        }
        let start = run.clip(start)?;
        let mut report = Report::default();
        let mut optimum = run.conclude(self.name(), |run| self.search(&start, &mut report, run))?;
        optimum.stages = report.stages;
        optimum.optima = report.optima;
        optimum.n_starts = report.n_starts;
        Ok(optimum)
    }
}

/// What the stages found.
#[derive(Default)]
struct Report {
    stages: Vec<Stage>,
    optima: Vec<LocalOptimum>,
    n_starts: usize,
}

impl Auto {
    fn search(&self, start: &DVector<f64>, report: &mut Report, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let local = LevenbergMarquardt::default();
        let multistart = Multistart { starts: self.starts, fewest: self.fewest, ..Multistart::default() };
        // a third of a limited budget is left to the insurance and the refinement
        let share = run.remaining().map_or(u64::MAX, |n| n - n / 3);
        let found = run.within(share, |run| multistart.minimize(start, run));
        let mut termination = Termination::PlanDone;
        if let Some(found) = report.add(found, &mut termination)? {
            (report.optima, report.n_starts) = (found.optima, found.n_starts);
        }

        if self.insurance > 0 && !termination.ends_the_run() {
            let known = run.best().map_or(f64::INFINITY, |(_, cost)| cost);
            let most = self.insurance.min(INSURANCE_EACH.saturating_mul(start.len() as u64));
            let share = run.remaining().map_or(most, |n| most.min(n / 2));
            let found = run.within(share, |run| CmaEs::default().minimize(start, run));
            if let Some(insured) = report.add(found, &mut termination)?
                && !termination.ends_the_run()
            {
                let refined = local.minimize(&insured.x, run);
                let refined = report.add(refined, &mut termination)?.unwrap_or(insured);
                if refined.cost < known - multistart.same * known.abs() - NO_COST {
                    report.optima.insert(0, LocalOptimum { x: refined.x, cost: refined.cost, n_starts: 0 });
                }
            }
        }

        let best = run.best().map(|(x, cost)| (x.clone(), cost));
        if let Some((x, cost)) = best
            && !termination.ends_the_run()
            && (termination == Termination::Stalled || !is_sum_of_squares(&x, cost, run)?)
        {
            report.add(NelderMead { size: 0.01, ..NelderMead::default() }.minimize(&x, run), &mut termination)?;
        }
        Ok(termination)
    }
}

/// Whether the cost is ½ rᵀr and walls at x, so that the local method has minimised the cost itself.
fn is_sum_of_squares(x: &DVector<f64>, cost: f64, run: &mut Run<'_>) -> Result<bool, Stop> {
    Ok(run.linearize(x)?.is_ok_and(|linearization| {
        (run.walls().cost(&linearization.residuals) - cost).abs() <= ROUNDING * cost.abs() + NO_COST
    }))
}

impl Report {
    /// Notes a stage; one that found nothing, or cannot run, is no obstacle to the others.
    fn add(
        &mut self,
        found: Result<Optimum, OptimError>,
        termination: &mut Termination,
    ) -> Result<Option<Optimum>, OptimError> {
        match found {
            Ok(found) => {
                *termination = found.termination;
                self.stages.push(found.stage());
                Ok(Some(found))
            }
            Err(OptimError::NoFinitePoint { termination: ended, .. }) => {
                *termination = ended;
                Ok(None)
            }
            Err(OptimError::Linearization { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }
}
