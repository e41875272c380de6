//! Differential evolution: a population improves itself by the differences of its members.
//!
//! Two strategies: [`classic`] is the recipe of the paper behind the flagship, [`current_to_pbest`] the one to use.

mod classic;
mod current_to_pbest;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::random::latin_hypercube;
use super::{About, OptimError, Optimizer, Optimum, Run, Stop};
use crate::linalg::DVector;

/// Differential evolution.
///
/// ```text
/// optimizer: {differential-evolution: {strategy: classic, population: 200, generations: 100}}
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DifferentialEvolution {
    /// How trial points are made.
    pub strategy: Strategy,
    /// Members of the (first) population, 4 to 100000; by default 200 (classic) or 100 (current-to-pbest).
    pub population: Option<usize>,
    /// Generations of a full population, at most; by default 100 (classic) or 400 (current-to-pbest).
    pub generations: Option<usize>,
    /// F, the factor of the difference, in (0, 2]; by default 0.8. Only classic: the other strategy adapts it.
    pub differential_weight: Option<f64>,
    /// CR, the chance that a parameter is taken from the mutant, in [0, 1]; by default 0.9. Only classic.
    pub crossover_rate: Option<f64>,
    /// Ends the search when the costs of the population differ by less than this, relative to the best.
    pub tolerance: f64,
}

/// How trial points are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// DE/rand/1/bin with constant factors (Storn and Price 1997).
    Classic,
    /// Towards one of the best, with archive, adapted factors and a shrinking population (L-SHADE).
    #[default]
    CurrentToPbest,
}

impl Default for DifferentialEvolution {
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            population: None,
            generations: None,
            differential_weight: None,
            crossover_rate: None,
            tolerance: 1e-10,
        }
    }
}

/// What `retune explain differential-evolution` tells.
pub(super) const ABOUT: About = About {
    name: "differential-evolution",
    summary: "global search by a population, without derivatives; survives points that cannot be evaluated",
    theory: "Each member x_i of a population is challenged by a trial point, made of differences of other members, and \
replaced if the trial is no worse. Classic (DE/rand/1/bin): v = x_a + F (x_b - x_c), mixed with x_i parameter by parameter \
with probability CR. Current-to-pbest: v = x_i + F (x_p - x_i) + F (x_b - x_c), where x_p is one of the best 11 % and x_c \
may come from an archive of replaced members; F and CR are drawn around values that succeeded before, and the population \
shrinks linearly to four. A parameter that leaves its bounds is set half way between the member and the bound. Steps \
scale with the spread of the population, so the search passes from global to local by itself. It needs thousands of \
evaluations, all of one generation independent of each other; follow it with a local method.",
    sources: &[
        "R. Storn, K. Price, Differential evolution - a simple and efficient heuristic for global optimization over continuous spaces, J. Global Optimization 11, 1997",
        "J. Zhang, A. C. Sanderson, JADE: adaptive differential evolution with optional external archive, IEEE Trans. Evolutionary Computation 13, 2009",
        "R. Tanabe, A. S. Fukunaga, Improving the search performance of SHADE using linear population size reduction, IEEE CEC, 2014",
    ],
};

/// Below this a cost, a sum of squares in units of standard deviations, is nothing: an absolute floor for comparisons.
const NO_COST: f64 = 1e-20;

impl DifferentialEvolution {
    fn validate(&self) -> Result<(), OptimError> {
        if let Some(n) = self.population.filter(|n| !(4..=100_000).contains(n)) {
            return Err(OptimError::setting(ABOUT.name, "population", n, "between 4 and 100000"));
        }
        if let Some(n) = self.generations.filter(|n| !(1..=1_000_000_000).contains(n)) {
            return Err(OptimError::setting(ABOUT.name, "generations", n, "between 1 and 1e9"));
        }
        if let Some(f) = self.differential_weight.filter(|f| !(*f > 0.0 && *f <= 2.0)) {
            return Err(OptimError::setting(ABOUT.name, "differential_weight", f, "above 0 and at most 2"));
        }
        if let Some(cr) = self.crossover_rate.filter(|cr| !(0.0..=1.0).contains(cr)) {
            return Err(OptimError::setting(ABOUT.name, "crossover_rate", cr, "between 0 and 1"));
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(OptimError::setting(ABOUT.name, "tolerance", self.tolerance, "at least 0 and below 1"));
        }
        if self.strategy == Strategy::CurrentToPbest {
            for (name, value) in
                [("differential_weight", self.differential_weight), ("crossover_rate", self.crossover_rate)]
            {
                if let Some(value) = value {
                    let expected =
                        "left out, because `strategy: current-to-pbest` adapts it; or use `strategy: classic`";
                    return Err(OptimError::setting(ABOUT.name, name, value, expected));
                }
            }
        }
        Ok(())
    }

    /// Whether the costs of a population agree within the tolerance.
    fn agree(&self, costs: impl Iterator<Item = f64>) -> bool {
        let (mut best, mut worst) = (f64::INFINITY, f64::NEG_INFINITY);
        for cost in costs {
            best = best.min(cost);
            worst = worst.max(cost);
        }
        worst - best <= self.tolerance * best.abs() + NO_COST
    }
}

impl Optimizer for DifferentialEvolution {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        self.validate()?;
        let start = run.clip(start)?;
        run.conclude(self.name(), |run| match self.strategy {
            Strategy::Classic => self.classic(&start, run),
            Strategy::CurrentToPbest => self.current_to_pbest(&start, run),
        })
    }
}

/// The first population: the start and a Latin hypercube, with their costs.
fn first_population(n: usize, start: &DVector<f64>, run: &mut Run<'_>) -> Result<(Vec<DVector<f64>>, Vec<f64>), Stop> {
    let mut points = latin_hypercube(n, start.len(), &mut run.rng(0));
    points[0].copy_from(start);
    let mut costs = vec![f64::INFINITY; n];
    run.costs(&points, &mut costs)?;
    Ok((points, costs))
}

/// A mutant's parameter moved back into [0, 1]: half way from the member to the bound that is exceeded (JADE).
fn back_inside(mutant: f64, member: f64) -> f64 {
    // Both ways are computed, so that no branch waits for a random number.
    let (below, above) = (0.5 * member, 0.5 * (1.0 + member));
    let inside = if mutant > 1.0 { above } else { mutant };
    if mutant < 0.0 { below } else { inside }
}
