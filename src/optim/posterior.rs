//! The posterior distribution of the parameters and the evidence of the model, by transitional Markov chain Monte Carlo.

use super::genealogy::Genealogy;
use super::random::Draw;
use super::{Evaluator, OptimError, Termination, Threads};
use crate::linalg::{DMatrix, DVector};
use crate::objective::Objective;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::Range;
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
/// proposal is scaled so that about a third of the steps is accepted; all members take a step at once, as one batch, until they have
/// forgotten most of their costs. Valleys without a bottom, bounds and several peaks are met as they are.
///
/// The population is two halves, each weighed and resampled by itself; the proposal of one has the covariance of the other. A half whose
/// own scatter chose its steps would find Z too large: by a factor of 20 with 19 parameters and few steps. The error of ln Z is that of
/// families, for copies of one member are not independent samples, or the difference of the halves where that is larger.
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
    /// Metropolis steps of every member at each stage, at least, and twenty times as many at most; four times as many at the last.
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
    /// Its standard error, from the scatter of families of samples and of the halves of the population.
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
        let (n, d) = (self.n_samples.max(4), objective.n_parameters());
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
        let mut halves = [Half::new(0, n / 2), Half::new(n / 2, n)];
        let mut beta = 0.0;
        let mut scale = 2.38 / (d.max(1) as f64).sqrt();
        let (mut n_stages, mut acceptance) = (0, 1.0);
        while beta < 1.0 && n_stages < MOST_STAGES {
            let step = next_step(&costs, 1.0 - beta);
            beta = if beta + step >= 1.0 - 1e-12 { 1.0 } else { beta + step };
            n_stages += 1;
            let mut chosen = Vec::with_capacity(n);
            let mut weights = vec![0.0; n];
            for half in &mut halves {
                let found = half.weigh(&costs, step);
                let parents = resample(&found, half.range.len(), &mut common);
                weights[half.range.clone()].copy_from_slice(&found);
                chosen.extend(parents.iter().map(|&k| half.range.start + k));
                half.family.add(found.iter().map(|w| w * found.len() as f64 - 1.0).collect(), parents);
            }
            // Each half moves as the other scatters.
            let factors = [1, 0].map(|other: usize| {
                let range = halves[other].range.clone();
                spread_of(&samples[range.clone()], &weights[range])
            });
            if beta == 1.0 {
                let shares = shares(&halves);
                for (half, share) in halves.iter().zip(shares) {
                    weights[half.range.clone()].iter_mut().for_each(|w| *w *= share);
                }
                chosen = resample(&weights, n, &mut common);
            }
            samples = chosen.iter().map(|&k| samples[k].clone()).collect();
            costs = chosen.iter().map(|&k| costs[k]).collect();
            let start = costs.clone();
            let least = self.n_steps.max(1) * if beta == 1.0 { 4 } else { 1 };
            let (mut accepted, mut n_steps) = (0.0, 0);
            while n_steps < least || (n_steps < LONGEST * self.n_steps && correlation(&start, &costs) > FORGOTTEN) {
                let proposal = |(k, (x, rng)): (usize, (&DVector<f64>, &mut ChaCha8Rng))| {
                    x + &factors[usize::from(k >= n / 2)] * DVector::from_fn(d, |_, _| scale * rng.normal())
                };
                let proposals: Vec<DVector<f64>> = samples.iter().zip(&mut own).enumerate().map(proposal).collect();
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
                accepted += rate;
                n_steps += 1;
                // Towards a third, in small steps: the proposal forgets its past slowly enough for that to be harmless.
                scale = (scale * ((rate - 0.33) / 2.0).exp()).clamp(1e-3, 4.0);
            }
            acceptance = accepted / n_steps.max(1) as f64;
        }
        let (log_evidence, log_evidence_se) = evidence(&halves);
        Ok(Posterior { samples, costs, log_evidence, log_evidence_se, n_stages, evaluations, acceptance })
    }
}

/// Correlation of the costs before and after steps at which most is forgotten.
const FORGOTTEN: f64 = 0.3;
/// Steps of a stage at most, in those that it has at least.
const LONGEST: usize = 20;

/// A half of the population, which is weighed and resampled by itself.
struct Half {
    /// Its members.
    range: Range<usize>,
    /// Its ln Z so far.
    log_evidence: f64,
    family: Genealogy,
}

impl Half {
    fn new(first: usize, end: usize) -> Self {
        Self { range: first..end, log_evidence: 0.0, family: Genealogy::default() }
    }

    /// The weights of its members, of sum one, for a step Δβ; its evidence takes their mean. Equal weights where it has no member that
    /// can be evaluated: then it counts for nothing.
    fn weigh(&mut self, costs: &[f64], step: f64) -> Vec<f64> {
        let own = &costs[self.range.clone()];
        let (weights, log_mean, _) = weights(own, step);
        self.log_evidence += log_mean;
        if log_mean == f64::NEG_INFINITY { vec![1.0 / own.len() as f64; own.len()] } else { weights }
    }
}

/// The share of each half in the whole evidence.
fn shares(halves: &[Half; 2]) -> [f64; 2] {
    let most = halves[0].log_evidence.max(halves[1].log_evidence);
    let parts = [0, 1].map(|h: usize| (halves[h].log_evidence - most).exp() * halves[h].range.len() as f64);
    parts.map(|p| p / (parts[0] + parts[1]))
}

/// ln Z of both halves together, and its standard error.
fn evidence(halves: &[Half; 2]) -> (f64, f64) {
    let n = (halves[0].range.len() + halves[1].range.len()) as f64;
    let most = halves[0].log_evidence.max(halves[1].log_evidence);
    let sum: f64 = halves.iter().map(|h| (h.log_evidence - most).exp() * h.range.len() as f64).sum();
    let of_families: f64 =
        halves.iter().zip(shares(halves)).map(|(h, share)| share * share * h.family.variance()).sum();
    let difference = 0.5 * (halves[0].log_evidence - halves[1].log_evidence).abs();
    // A half that began with no point that can be evaluated says nothing.
    (most + (sum / n).ln(), of_families.sqrt().max(if difference.is_finite() { difference } else { 0.0 }))
}

/// Correlation of finite costs; zero where they do not scatter.
fn correlation(before: &[f64], after: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> =
        before.iter().zip(after).map(|(a, b)| (*a, *b)).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    let n = pairs.len() as f64;
    let (a, b) = pairs.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let moment = |f: fn(f64, f64) -> f64| pairs.iter().map(|p| f(p.0 - a, p.1 - b)).sum::<f64>();
    let scatter = (moment(|x, _| x * x) * moment(|_, y| y * y)).sqrt();
    if scatter > 0.0 { moment(|x, y| x * y) / scatter } else { 0.0 }
}

/// The weights exp(-Δβ cost), of sum one, ln of their mean, and their squared coefficient of variation.
fn weights(costs: &[f64], step: f64) -> (Vec<f64>, f64, f64) {
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let raw: Vec<f64> = costs.iter().map(|c| if c.is_finite() { (-step * (c - least)).exp() } else { 0.0 }).collect();
    let n = raw.len() as f64;
    let mean = raw.iter().sum::<f64>() / n;
    if mean == 0.0 {
        return (raw, f64::NEG_INFINITY, 0.0);
    }
    let spread = raw.iter().map(|w| (w / mean - 1.0).powi(2)).sum::<f64>() / n;
    (raw.iter().map(|w| w / (mean * n)).collect(), mean.ln() - step * least, spread)
}

/// The next Δβ.
fn next_step(costs: &[f64], most: f64) -> f64 {
    let spread = |step: f64| weights(costs, step).2;
    if spread(most) <= 1.0 {
        return most;
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if spread(middle) > 1.0 { high = middle } else { low = middle }
    }
    // Points that cannot be evaluated may alone scatter the weights by more: then the smallest step that is one.
    low.max(1e-12 * most)
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
    /// The sample of the lowest cost, the first of several; none without samples.
    pub fn best(&self) -> Option<usize> {
        (0..self.costs.len()).min_by(|&a, &b| self.costs[a].total_cmp(&self.costs[b]))
    }

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

    /// How often ln Z lies within one and two of the errors that are stated, over 50 seeds, and how large these are against the scatter.
    ///
    /// 68 % and 95 % are right for a normal error. Of 50, the 99 % band of 95 % reaches down to 43; that of 68 % from 25 to 42.
    fn assert_the_error_holds(name: &str, objective: &dyn Objective, exact: f64) {
        let off: Vec<(f64, f64)> = (0..50)
            .map(|seed| {
                let found = Tmcmc { n_samples: 400, seed, ..Tmcmc::default() }.sample(objective).unwrap();
                (found.log_evidence - exact, found.log_evidence_se)
            })
            .collect();
        let within = |times: f64| off.iter().filter(|(e, se)| e.abs() <= times * se).count();
        let rms = |f: fn(&(f64, f64)) -> f64| (off.iter().map(f).sum::<f64>() / 50.0).sqrt();
        let (scatter, stated) = (rms(|o| o.0 * o.0), rms(|o| o.1 * o.1));
        eprintln!(
            "{name}: {} and {} of 50 within one and two errors; {scatter:.3} scatter, {stated:.3} stated",
            within(1.0),
            within(2.0)
        );
        assert!(within(2.0) >= 43, "{name}: {} of 50 within two errors", within(2.0));
        assert!(within(1.0) >= 25, "{name}: {} of 50 within one error", within(1.0));
        assert!(stated < 2.0 * scatter, "{name}: {stated} is stated, and {scatter} is the scatter");
    }

    /// ½ (x - ½)ᵀ Σ⁻¹ (x - ½) in d dimensions, correlated, with standard deviations of 0.003 to 0.05, and its evidence.
    fn correlated(d: usize) -> (impl Fn(&DVector<f64>) -> f64 + Send + Sync, f64) {
        let turn = DMatrix::from_fn(d, d, |i, j| (1.7 * i as f64 + 2.3 * j as f64 + (i * j) as f64).sin()).qr().q();
        let sd = DVector::from_fn(d, |i, _| 0.05 * 10f64.powf(-1.2 * i as f64 / (d - 1) as f64));
        let exact = 0.5 * d as f64 * std::f64::consts::TAU.ln() + sd.iter().map(|s| s.ln()).sum::<f64>();
        let cost = move |x: &DVector<f64>| {
            let along = turn.tr_mul(&x.map(|v| v - 0.5));
            0.5 * along.iter().zip(sd.iter()).map(|(a, s)| (a / s).powi(2)).sum::<f64>()
        };
        (cost, exact)
    }

    #[test]
    fn the_stated_error_of_the_evidence_holds() {
        for d in [2, 6, 12] {
            let (cost, exact) = correlated(d);
            assert_the_error_holds(&format!("{d} correlated"), &Cost(d, cost), exact);
        }
        let peak = |x: &DVector<f64>, at: f64, s: f64| (-0.5 * x.map(|v| (v - at) / s).norm_squared()).exp();
        let two = move |x: &DVector<f64>| -(peak(x, 0.25, 0.02) + peak(x, 0.75, 0.05) + 1e-300).ln();
        let exact = (std::f64::consts::TAU * (0.02f64.powi(2) + 0.05f64.powi(2))).ln();
        assert_the_error_holds("two peaks", &Cost(2, two), exact);
        // A valley from bound to bound: the sum of three has the density ¾ in its middle.
        let valley = |x: &DVector<f64>| 0.5 * ((x.sum() - 1.5) / 0.01).powi(2);
        let exact = 0.5 * std::f64::consts::TAU.ln() + (0.01f64 * 0.75).ln();
        assert_the_error_holds("valley", &Cost(3, valley), exact);
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
