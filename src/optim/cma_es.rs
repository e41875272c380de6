//! Covariance matrix adaptation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::random::Draw;
use super::{About, OptimError, Optimizer, Optimum, Run, Stop, Termination};
use crate::linalg::{DMatrix, DVector};

/// CMA-ES with restarts of doubled population.
///
/// ```text
/// optimizer: {cma-es: {sigma: 0.3, restarts: 3}}
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CmaEs {
    /// Points a generation, 4 to 100000; by default 4 + 3 ln n.
    pub population: Option<usize>,
    /// First standard deviation as a share of each parameter's range, in (0, 1].
    pub sigma: f64,
    /// Restarts from random points, each with a doubled population.
    pub restarts: usize,
    /// Ends a descent when the costs of recent generations differ by less than this, relative to the best.
    pub tolerance: f64,
}

impl Default for CmaEs {
    fn default() -> Self {
        Self { population: None, sigma: 0.3, restarts: 3, tolerance: 1e-10 }
    }
}

/// What `retune explain cma-es` tells.
pub(super) const ABOUT: About = About {
    name: "cma-es",
    summary: "robust search without derivatives that learns the scales and correlations of the parameters",
    theory: "Points are drawn from a normal distribution, m + σ N(0, C); the better half, weighted, gives the next mean, and the \
paths of successful steps give the next σ and C. The result does not depend on how parameters are scaled or combined. \
Bounds are mirrors: a coordinate that leaves [0, 1] is folded back, so the search sees a continuous function without bounds \
whose minima are those inside. When a descent has converged, another starts at random with twice the population (IPOP), \
which sees wider basins. It needs a few thousand evaluations for 20 parameters.",
    sources: &[
        "N. Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772, 2016",
        "A. Auger, N. Hansen, A restart CMA evolution strategy with increasing population size, IEEE CEC, 2005",
    ],
};

/// A cost below this is nothing (sums of squares in units of standard deviations).
const NO_COST: f64 = 1e-20;
/// A distribution narrower than this has points that differ by rounding only.
const ROUNDING: f64 = 1e-13;
/// A covariance less well conditioned than this cannot be factored.
const LARGEST_CONDITION: f64 = 1e14;
/// The largest population of restarts.
const LARGEST_POPULATION: usize = 100_000;

impl Optimizer for CmaEs {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        self.validate()?;
        let start = run.clip(start)?;
        run.conclude(self.name(), |run| self.search(start, run))
    }
}

impl CmaEs {
    fn validate(&self) -> Result<(), OptimError> {
        if let Some(n) = self.population.filter(|n| !(4..=LARGEST_POPULATION).contains(n)) {
            return Err(OptimError::setting(ABOUT.name, "population", n, "between 4 and 100000"));
        }
        if !(self.sigma > 0.0 && self.sigma <= 1.0) {
            return Err(OptimError::setting(ABOUT.name, "sigma", self.sigma, "above 0 and at most 1"));
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(OptimError::setting(ABOUT.name, "tolerance", self.tolerance, "at least 0 and below 1"));
        }
        Ok(())
    }

    /// Descents from the start and then from random points, with populations that double.
    fn search(&self, start: DVector<f64>, run: &mut Run<'_>) -> Result<Termination, Stop> {
        run.cost(&start)?;
        let n = start.len();
        let mut population = self.population.unwrap_or(4 + (3.0 * (n as f64).ln()) as usize);
        let mut mean = start;
        for restart in 0..=self.restarts as u64 {
            let mut rng = run.rng(restart);
            if restart > 0 {
                mean.apply(|v| *v = rng.unit());
            }
            let mut distribution = Distribution::new(mean.clone(), self.sigma, population);
            distribution.descend(self.tolerance, &mut rng, run)?;
            population = (2 * population).min(LARGEST_POPULATION);
        }
        Ok(Termination::PointsAgree)
    }
}

/// The constants of Hansen's table 1, with weights of the better half only.
struct Strategy {
    population: usize,
    weights: Vec<f64>,
    mu_eff: f64,
    c_sigma: f64,
    d_sigma: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// E |N(0, I)|
    chi: f64,
}

impl Strategy {
    fn new(n: usize, population: usize) -> Self {
        let (n, lambda) = (n as f64, population as f64);
        let mut weights: Vec<f64> =
            (1..=population / 2).map(|i| (f64::midpoint(lambda, 1.0)).ln() - (i as f64).ln()).collect();
        let sum: f64 = weights.iter().sum();
        for w in &mut weights {
            *w /= sum;
        }
        let mu_eff = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mu_eff);
        Self {
            population,
            weights,
            mu_eff,
            c_sigma,
            d_sigma: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu: (1.0 - c_1).min(2.0 * (0.25 + mu_eff + 1.0 / mu_eff - 2.0) / ((n + 2.0).powi(2) + mu_eff)),
            chi: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

/// m + σ N(0, C) and its evolution paths.
struct Distribution {
    constants: Strategy,
    mean: DVector<f64>,
    sigma: f64,
    covariance: DMatrix<f64>,
    /// C = B D² Bᵀ
    axes: DMatrix<f64>,
    lengths: DVector<f64>,
    path_sigma: DVector<f64>,
    path_c: DVector<f64>,
}

impl Distribution {
    fn new(mean: DVector<f64>, sigma: f64, population: usize) -> Self {
        let n = mean.len();
        Self {
            constants: Strategy::new(n, population),
            mean,
            sigma,
            covariance: DMatrix::identity(n, n),
            axes: DMatrix::identity(n, n),
            lengths: DVector::from_element(n, 1.0),
            path_sigma: DVector::zeros(n),
            path_c: DVector::zeros(n),
        }
    }

    /// Generations until the costs agree or the distribution has collapsed.
    fn descend(&mut self, tolerance: f64, rng: &mut impl Draw, run: &mut Run<'_>) -> Result<(), Stop> {
        let (n, lambda) = (self.mean.len(), self.constants.population);
        let Strategy { c_1, c_mu, .. } = self.constants;
        let most = 100 + (150.0 * (n as f64 + 3.0).powi(2) / (lambda as f64).sqrt()) as usize;
        let memory = 10 + (30 * n).div_ceil(lambda);
        let factor_every = ((0.1 / (n as f64 * (c_1 + c_mu))) as usize).max(1);

        // y = B D z, x = fold(m + σ y)
        let mut steps = vec![DVector::zeros(n); lambda];
        let mut points = vec![DVector::zeros(n); lambda];
        let mut costs = vec![f64::INFINITY; lambda];
        let mut order: Vec<usize> = (0..lambda).collect();
        let mut z = DVector::zeros(n);
        let mut best_costs: Vec<f64> = Vec::new();
        for generation in 0..most {
            for (y, x) in steps.iter_mut().zip(&mut points) {
                for j in 0..n {
                    z[j] = self.lengths[j] * rng.normal();
                }
                self.axes.mul_to(&z, y);
                for j in 0..n {
                    x[j] = fold(self.mean[j] + self.sigma * y[j]);
                }
            }
            run.costs(&points, &mut costs)?;
            order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
            self.update(&steps, &order, generation);
            if generation % factor_every == 0 && !self.factor() {
                return Ok(());
            }

            best_costs.push(costs[order[0]]);
            let recent = &best_costs[best_costs.len().saturating_sub(memory)..];
            let highest = recent.iter().fold(costs[order[lambda - 1]], |a, &b| a.max(b));
            let lowest = recent.iter().fold(f64::INFINITY, |a, &b| a.min(b));
            let agree = recent.len() == memory && highest - lowest <= tolerance * lowest.abs() + NO_COST;
            let widest = self.covariance.diagonal().max().sqrt() * self.sigma;
            // a population without a finite cost learns nothing
            if agree || widest < ROUNDING || lowest.is_infinite() && recent.len() == memory {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Equations (9) to (12), (43) to (47) of the tutorial.
    fn update(&mut self, steps: &[DVector<f64>], order: &[usize], generation: usize) {
        let Strategy { weights, mu_eff, c_sigma, d_sigma, c_c, c_1, c_mu, chi, .. } = &self.constants;
        let n = self.mean.len() as f64;

        let mut step = DVector::zeros(self.mean.len());
        for (w, &i) in weights.iter().zip(order) {
            step.axpy(*w, &steps[i], 1.0);
        }
        self.mean.axpy(self.sigma, &step, 1.0);

        // C^(-1/2) y = B D⁻¹ Bᵀ y
        let whitened = &self.axes * self.axes.tr_mul(&step).component_div(&self.lengths);
        self.path_sigma.axpy((c_sigma * (2.0 - c_sigma) * mu_eff).sqrt(), &whitened, 1.0 - c_sigma);
        let path_length = self.path_sigma.norm();
        self.sigma *= (c_sigma / d_sigma * (path_length / chi - 1.0)).min(1.0).exp();
        self.sigma = self.sigma.min(1.0);

        let expected = (1.0 - (1.0 - c_sigma).powi(2 * (generation as i32 + 1))).sqrt() * chi * (1.4 + 2.0 / (n + 1.0));
        let h_sigma = f64::from(path_length < expected);
        self.path_c.axpy(h_sigma * (c_c * (2.0 - c_c) * mu_eff).sqrt(), &step, 1.0 - c_c);

        self.covariance *= 1.0 - c_1 - c_mu + (1.0 - h_sigma) * c_1 * c_c * (2.0 - c_c);
        self.covariance.ger(*c_1, &self.path_c, &self.path_c, 1.0);
        for (w, &i) in weights.iter().zip(order) {
            self.covariance.ger(c_mu * w, &steps[i], &steps[i], 1.0);
        }
    }

    /// C = B D² Bᵀ; false if C has become singular.
    fn factor(&mut self) -> bool {
        let eigen = self.covariance.clone().symmetric_eigen();
        let (smallest, largest) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
        let regular = smallest > 0.0 && largest < LARGEST_CONDITION * smallest;
        if regular {
            self.axes = eigen.eigenvectors;
            self.lengths = eigen.eigenvalues.map(f64::sqrt);
        }
        regular
    }
}

/// A number folded into [0, 1] by mirrors at 0 and 1.
fn fold(v: f64) -> f64 {
    let v = v.rem_euclid(2.0);
    if v > 1.0 { 2.0 - v } else { v }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_mirrors_at_both_bounds() {
        for (v, folded) in [(0.25, 0.25), (-0.25, 0.25), (1.25, 0.75), (2.25, 0.25), (-1.25, 0.75), (1.0, 1.0)] {
            assert_eq!(fold(v), folded);
        }
        assert!((0.0..=1.0).contains(&fold(-1e-18)));
    }
}
