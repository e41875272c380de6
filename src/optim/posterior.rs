//! The posterior distribution of the parameters and the evidence of the model, by transitional Markov chain Monte Carlo.

use super::random::Draw;
use super::{Evaluator, OptimError, Termination, Threads};
use crate::linalg::{DMatrix, DVector};
use crate::objective::Objective;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Samples of the posterior ∝ exp(-cost(x)) over the unit box.
///
/// ```text
/// p_β(x) ∝ exp(-β cost(x)),   0 = β_0 < β_1 < ... < 1,   each step as long as the weights w = exp(-Δβ cost) have a
///                                                        coefficient of variation of one
/// ln Z = Σ ln mean(w)         the evidence ∫ exp(-cost(x)) dx over the box
/// ```
///
/// A population starts uniform in the box. At each stage it is weighed, resampled, and moved by Metropolis steps whose
/// proposal has the covariance of the population, scaled so that about a third of the steps is accepted; all members
/// take a step at once, as one batch. Valleys without a bottom, bounds and several peaks are met as they are.
///
/// The prior is uniform between the bounds; prior terms of the objective act on top of it. Evidences of two models may be
/// compared on the same data with the same standard deviations: their constants cancel.
///
/// # Source
/// J. Ching, Y.-C. Chen, Transitional Markov chain Monte Carlo method for Bayesian model updating, model class selection, and
/// model averaging, Journal of Engineering Mechanics 133(7), 2007; W. Betz, I. Papaioannou, D. Straub, Transitional Markov
/// chain Monte Carlo: observations and improvements, Journal of Engineering Mechanics 142(5), 2016.
#[derive(Debug, Clone)]
pub struct Tmcmc {
    /// Members of the population, which is also the number of samples.
    pub n_samples: usize,
    /// Metropolis steps of every member at each stage; four times as many at the last.
    pub n_steps: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Stops the sampling with an error once true.
    pub cancel: Arc<AtomicBool>,
}

impl Default for Tmcmc {
    fn default() -> Self {
        Self { n_samples: 1000, n_steps: 5, seed: 0, cancel: Arc::default() }
    }
}

/// Samples of a posterior, of equal weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// The samples, points of the unit box.
    pub samples: Vec<DVector<f64>>,
    /// Their costs.
    pub costs: Vec<f64>,
    /// ln ∫ exp(-cost(x)) dx over the unit box.
    pub log_evidence: f64,
    /// Its standard error, from the scatter of the weights.
    pub log_evidence_se: f64,
    /// Stages from the prior to the posterior.
    pub n_stages: usize,
    /// Costs evaluated.
    pub evaluations: u64,
    /// Share of accepted steps at the last stage.
    pub acceptance: f64,
}

/// Most stages: far beyond any posterior that double precision can resolve.
const MOST_STAGES: usize = 400;

impl Tmcmc {
    /// Samples the posterior of an objective, evaluated on threads.
    ///
    /// # Errors
    /// No point of the box can be evaluated; cancelled; an evaluator that fails.
    pub fn sample(&self, objective: &dyn Objective) -> Result<Posterior, OptimError> {
        self.sample_by(objective, &Threads)
    }

    /// [`Tmcmc::sample`] with an evaluator of one's own.
    ///
    /// # Errors
    /// As [`Tmcmc::sample`].
    pub fn sample_by(&self, objective: &dyn Objective, evaluator: &dyn Evaluator) -> Result<Posterior, OptimError> {
        let (n, d) = (self.n_samples.max(2), objective.n_parameters());
        // One stream for resampling, one for each member: what one does never depends on the others.
        let stream = |k: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(k);
            rng
        };
        let mut common = stream(0);
        let mut own: Vec<ChaCha8Rng> = (0..n).map(|k| stream(1 + k as u64)).collect();
        let mut evaluations = 0;
        let mut evaluate = |points: &[DVector<f64>]| -> Result<Vec<f64>, OptimError> {
            let mut costs = vec![f64::INFINITY; points.len()];
            evaluator
                .costs(objective, points, &mut costs, &self.cancel)
                .map_err(|source| OptimError::Evaluator { source })?;
            if self.cancel.load(Ordering::Relaxed) {
                return Err(OptimError::Cancelled);
            }
            evaluations += points.len() as u64;
            Ok(costs.into_iter().map(|c| if c.is_nan() { f64::INFINITY } else { c }).collect())
        };

        let mut samples: Vec<DVector<f64>> = own.iter_mut().map(|rng| DVector::from_fn(d, |_, _| rng.unit())).collect();
        let mut costs = evaluate(&samples)?;
        if costs.iter().all(|c| !c.is_finite()) {
            return Err(OptimError::NoFinitePoint { evaluations: n as u64, termination: Termination::PlanDone });
        }
        let (mut beta, mut log_evidence, mut variance) = (0.0, 0.0, 0.0);
        let mut scale = 2.38 / (d.max(1) as f64).sqrt();
        let (mut n_stages, mut acceptance) = (0, 1.0);
        while beta < 1.0 && n_stages < MOST_STAGES {
            let (step, weights, log_mean, spread) = next_step(&costs, 1.0 - beta);
            beta = if beta + step >= 1.0 - 1e-12 { 1.0 } else { beta + step };
            log_evidence += log_mean;
            variance += spread / n as f64;
            n_stages += 1;
            let factor = spread_of(&samples, &weights);
            let chosen = resample(&weights, n, &mut common);
            samples = chosen.iter().map(|&k| samples[k].clone()).collect();
            costs = chosen.iter().map(|&k| costs[k]).collect();
            let n_steps = self.n_steps.max(1) * if beta == 1.0 { 4 } else { 1 };
            let mut accepted = 0.0;
            for _ in 0..n_steps {
                let proposals: Vec<DVector<f64>> = samples
                    .iter()
                    .zip(&mut own)
                    .map(|(x, rng)| x + &factor * DVector::from_fn(d, |_, _| scale * rng.normal()))
                    .collect();
                let inside: Vec<usize> =
                    (0..n).filter(|&k| proposals[k].iter().all(|v| (0.0..=1.0).contains(v))).collect();
                let points: Vec<DVector<f64>> = inside.iter().map(|&k| proposals[k].clone()).collect();
                let found = evaluate(&points)?;
                let mut taken = 0.0;
                for ((k, point), cost) in inside.into_iter().zip(points).zip(found) {
                    // The draw is made whatever the outcome, so that streams stay in step.
                    if own[k].unit() < (beta * (costs[k] - cost)).exp() {
                        (samples[k], costs[k]) = (point, cost);
                        taken += 1.0;
                    }
                }
                let rate = taken / n as f64;
                accepted += rate / n_steps as f64;
                // Towards a third, in small steps: the proposal forgets its past slowly enough for that to be harmless.
                scale = (scale * ((rate - 0.33) / 2.0).exp()).clamp(1e-3, 4.0);
            }
            acceptance = accepted;
        }
        Ok(Posterior {
            samples,
            costs,
            log_evidence,
            log_evidence_se: variance.sqrt(),
            n_stages,
            evaluations,
            acceptance,
        })
    }
}

/// The next Δβ, the weights (of sum one), ln of their mean, and their squared coefficient of variation.
fn next_step(costs: &[f64], most: f64) -> (f64, Vec<f64>, f64, f64) {
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let weigh = |step: f64| -> (Vec<f64>, f64, f64) {
        let raw: Vec<f64> =
            costs.iter().map(|c| if c.is_finite() { (-step * (c - least)).exp() } else { 0.0 }).collect();
        let n = raw.len() as f64;
        let mean = raw.iter().sum::<f64>() / n;
        let spread = raw.iter().map(|w| (w / mean - 1.0).powi(2)).sum::<f64>() / n;
        (raw.iter().map(|w| w / (mean * n)).collect(), mean.ln() - step * least, spread)
    };
    let whole = weigh(most);
    if whole.2 <= 1.0 {
        return (most, whole.0, whole.1, whole.2);
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if weigh(middle).2 > 1.0 { high = middle } else { low = middle }
    }
    // Points that cannot be evaluated may alone scatter the weights by more: then the smallest step that is one.
    let step = low.max(1e-12 * most);
    let (weights, log_mean, spread) = weigh(step);
    (step, weights, log_mean, spread)
}

/// A factor of the weighted covariance of the population, slightly inflated so that it is never singular.
fn spread_of(samples: &[DVector<f64>], weights: &[f64]) -> DMatrix<f64> {
    let d = samples[0].len();
    let mut mean = DVector::zeros(d);
    samples.iter().zip(weights).for_each(|(x, w)| mean += x * *w);
    let mut covariance = DMatrix::zeros(d, d);
    for (x, w) in samples.iter().zip(weights) {
        let off = x - &mean;
        covariance += &off * off.transpose() * *w;
    }
    let largest = covariance.diagonal().max();
    for j in 0..d {
        covariance[(j, j)] += 1e-10 * largest + 1e-20;
    }
    match covariance.clone().cholesky() {
        Some(c) => c.l(),
        None => DMatrix::from_diagonal(&covariance.diagonal().map(f64::sqrt)),
    }
}

/// Systematic resampling: each member as often as its weight says, up to one.
fn resample(weights: &[f64], n: usize, rng: &mut ChaCha8Rng) -> Vec<usize> {
    let first = rng.unit();
    let mut out = Vec::with_capacity(n);
    let (mut k, mut sum) = (0, weights[0]);
    for i in 0..n {
        let goal = (first + i as f64) / n as f64;
        while sum < goal && k + 1 < weights.len() {
            k += 1;
            sum += weights[k];
        }
        out.push(k);
    }
    out
}

impl Posterior {
    /// Mean of each parameter, (n_parameters).
    pub fn mean(&self) -> DVector<f64> {
        let n = self.samples.len() as f64;
        self.samples.iter().fold(DVector::zeros(self.samples[0].len()), |sum, x| sum + x) / n
    }

    /// Covariance of the parameters.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mean = self.mean();
        let n = self.samples.len() as f64;
        self.samples.iter().fold(DMatrix::zeros(mean.len(), mean.len()), |sum, x| {
            let off = x - &mean;
            sum + &off * off.transpose() / (n - 1.0)
        })
    }

    /// A quantile of one parameter, interpolated between samples.
    pub fn quantile(&self, parameter: usize, probability: f64) -> f64 {
        let mut values: Vec<f64> = self.samples.iter().map(|x| x[parameter]).collect();
        values.sort_by(f64::total_cmp);
        let place = probability.clamp(0.0, 1.0) * (values.len() - 1) as f64;
        let below = place.floor() as usize;
        let above = (below + 1).min(values.len() - 1);
        values[below] + (place - below as f64) * (values[above] - values[below])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::EvalError;

    /// A cost of its own.
    struct Cost<F>(usize, F);

    impl<F: Fn(&DVector<f64>) -> f64 + Send + Sync> Objective for Cost<F> {
        fn n_parameters(&self) -> usize {
            self.0
        }
        fn n_residuals(&self) -> usize {
            1
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(DVector::from_element(1, (2.0 * (self.1)(x)).sqrt()))
        }
    }

    fn sample(objective: &dyn Objective, seed: u64) -> Posterior {
        Tmcmc { n_samples: 2000, seed, ..Tmcmc::default() }.sample(objective).unwrap()
    }

    /// A correlated Gaussian well inside the box: mean, covariance, and Z = (2π)^{3/2} √det Σ.
    #[test]
    fn a_gaussian_gives_its_moments_and_its_evidence() {
        let l = DMatrix::from_row_slice(3, 3, &[0.05, 0.0, 0.0, 0.03, 0.02, 0.0, -0.01, 0.01, 0.06]);
        let sigma = &l * l.transpose();
        let inverse = sigma.clone().try_inverse().unwrap();
        let objective = Cost(3, move |x: &DVector<f64>| {
            let off = x - DVector::from_row_slice(&[0.4, 0.5, 0.6]);
            0.5 * (off.transpose() * &inverse * &off)[(0, 0)]
        });
        let exact = 1.5 * std::f64::consts::TAU.ln() + 0.5 * sigma.determinant().ln();
        let found = sample(&objective, 1);
        // The scatter of ln Z over seeds is about its standard error; four of them.
        assert!((found.log_evidence - exact).abs() < 4.0 * found.log_evidence_se, "{} {exact}", found.log_evidence);
        assert!(found.log_evidence_se < 0.1);
        let mean = found.mean();
        for j in 0..3 {
            let sd = sigma[(j, j)].sqrt();
            // 2000 samples, of which correlation leaves a quarter or more: 4/√500 standard deviations.
            assert!((mean[j] - [0.4, 0.5, 0.6][j]).abs() < 0.18 * sd, "{j}: {}", mean[j]);
            assert!((found.covariance()[(j, j)].sqrt() / sd - 1.0).abs() < 0.13);
            let q = found.quantile(j, 0.95) - found.quantile(j, 0.05);
            assert!((q / (2.0 * 1.644_854 * sd) - 1.0).abs() < 0.15);
        }
    }

    /// Only x1 + x2 is seen: the marginals are uniform between the bounds.
    #[test]
    fn a_valley_is_filled_from_bound_to_bound() {
        let found = sample(&Cost(2, |x: &DVector<f64>| 0.5 * ((x[0] + x[1] - 1.0) / 0.01).powi(2)), 3);
        for p in [0.1, 0.25, 0.5, 0.75, 0.9] {
            assert!((found.quantile(0, p) - p).abs() < 0.08, "{p}: {}", found.quantile(0, p));
        }
        // Z = ∫ of the Gaussian across, times the length of the valley in x1: √(2π) 0.01.
        let exact = 0.5 * std::f64::consts::TAU.ln() + 0.01f64.ln();
        assert!((found.log_evidence - exact).abs() < 4.0 * found.log_evidence_se);
    }

    #[test]
    fn two_peaks_keep_their_weights() {
        let peak = |x: f64, at: f64, s: f64| (-0.5 * ((x - at) / s).powi(2)).exp();
        let found = sample(&Cost(1, move |x: &DVector<f64>| -(peak(x[0], 0.2, 0.02) + peak(x[0], 0.8, 0.06)).ln()), 5);
        let share = found.samples.iter().filter(|x| x[0] > 0.5).count() as f64 / 2000.0;
        assert!((share - 0.75).abs() < 0.08, "{share}");
    }

    #[test]
    fn bits_do_not_depend_on_threads() {
        let objective = Cost(2, |x: &DVector<f64>| 50.0 * (x[0] - 0.3).powi(2) + 20.0 * (x[1] - x[0]).powi(2));
        let with = |n: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| Tmcmc { n_samples: 100, seed: 9, ..Tmcmc::default() }.sample(&objective).unwrap())
        };
        assert_eq!(with(1), with(2));
    }

    #[test]
    fn nothing_that_works_is_an_error() {
        assert!(Tmcmc::default().sample(&Cost(1, |_: &DVector<f64>| f64::NAN)).is_err());
        let cancelled = Tmcmc::default();
        cancelled.cancel.store(true, Ordering::Relaxed);
        assert!(cancelled.sample(&Cost(1, |x: &DVector<f64>| x[0])).is_err());
    }
}
