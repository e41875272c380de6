use rand_chacha::ChaCha8Rng;

use super::super::random::Draw;
use super::super::{Run, Stop, Termination};
use super::{DifferentialEvolution, back_inside, first_population};
use crate::linalg::DVector;

const POPULATION: usize = 100;
const GENERATIONS: usize = 400;
/// The rest is from Tanabe and Fukunaga 2014, section IV: share of the best, members of the archive a member of the
/// population, length of the memory, smallest population.
const BEST_SHARE: f64 = 0.11;
const ARCHIVE_RATE: f64 = 2.6;
const MEMORY: usize = 6;
const SMALLEST_POPULATION: usize = 4;
/// Spread of CR and F around their remembered means.
const SPREAD: f64 = 0.1;

impl DifferentialEvolution {
    /// DE/current-to-pbest/1/bin with archive, success-history adaptation and linear population reduction (L-SHADE).
    ///
    /// ```text
    /// v = x_i + F_i (x_p - x_i) + F_i (x_a - x_b),   p among the best 11 %, b from population and archive
    /// u_j = v_j with probability CR_i and for one random j, x_ij otherwise
    /// x_i <- u if cost(u) <= cost(x_i); a member that is beaten goes to the archive
    /// ```
    pub(super) fn current_to_pbest(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let n_first = self.population.unwrap_or(POPULATION);
        let planned = (n_first as u64).saturating_mul(self.generations.unwrap_or(GENERATIONS) as u64);
        let planned = run.remaining().map_or(planned, |remaining| remaining.min(planned));
        let mut done = n_first as u64;

        let (points, costs) = first_population(n_first, start, run)?;
        let mut members: Vec<Member> = points.into_iter().zip(costs).map(|(x, cost)| Member { x, cost }).collect();
        let mut trials: Vec<DVector<f64>> = members.iter().map(|m| m.x.clone()).collect();
        let mut trial_costs = vec![f64::INFINITY; n_first];
        let mut factors = vec![Factors::default(); n_first];
        let mut archive: Vec<DVector<f64>> = Vec::new();
        let mut memory = SuccessHistory::new();
        let mut rng = run.rng(1);

        while done < planned {
            members.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let n = reduced(n_first, done, planned);
            members.truncate(n);
            archive.truncate(archive_size(n));

            let n_best = ((BEST_SHARE * n as f64).round() as usize).max(2);
            for (i, trial) in trials[..n].iter_mut().enumerate() {
                factors[i] = memory.draw(&mut rng);
                let p = rng.below(n_best);
                let a = other(n, &mut rng, |a| a == i);
                let b = other(n + archive.len(), &mut rng, |b| b == i || b == a);
                let from = if b < n { &members[b].x } else { &archive[b - n] };
                factors[i].mutate(&members[i].x, &members[p].x, &members[a].x, from, trial, &mut rng);
            }
            run.costs(&trials[..n], &mut trial_costs[..n])?;
            done += n as u64;

            for (member, (trial, (&cost, factors))) in
                members.iter_mut().zip(trials.iter().zip(trial_costs.iter().zip(&factors)))
            {
                if cost < member.cost {
                    memory.remember(*factors, member.cost - cost);
                    into_archive(&mut archive, &member.x, archive_size(n), &mut rng);
                }
                if cost <= member.cost {
                    member.x.copy_from(trial);
                    member.cost = cost;
                }
            }
            memory.update();
            if self.agree(members.iter().map(|m| m.cost)) {
                return Ok(Termination::PointsAgree);
            }
        }
        Ok(if run.remaining() == Some(0) { Termination::BudgetSpent } else { Termination::PlanDone })
    }
}

#[derive(Debug, Clone)]
struct Member {
    x: DVector<f64>,
    cost: f64,
}

/// F and CR of one trial.
#[derive(Debug, Clone, Copy, Default)]
struct Factors {
    weight: f64,
    crossover_rate: f64,
}

impl Factors {
    /// Overwrites `trial` with the mutant of `member`, crossed with it.
    fn mutate(
        self,
        member: &DVector<f64>,
        best: &DVector<f64>,
        a: &DVector<f64>,
        b: &DVector<f64>,
        trial: &mut DVector<f64>,
        rng: &mut ChaCha8Rng,
    ) {
        let certain = rng.below(member.len());
        for j in 0..member.len() {
            let mutated = rng.unit() < self.crossover_rate || j == certain;
            let mutant = member[j] + self.weight * (best[j] - member[j]) + self.weight * (a[j] - b[j]);
            trial[j] = if mutated { back_inside(mutant, member[j]) } else { member[j] };
        }
    }
}

/// The population after `done` of `planned` evaluations.
fn reduced(n_first: usize, done: u64, planned: u64) -> usize {
    let smallest = SMALLEST_POPULATION.min(n_first) as f64;
    let share = done as f64 / planned as f64;
    ((n_first as f64 + (smallest - n_first as f64) * share).round() as usize).max(SMALLEST_POPULATION)
}

fn archive_size(n: usize) -> usize {
    (ARCHIVE_RATE * n as f64).round() as usize
}

/// A random index that is not `taken`.
fn other(n: usize, rng: &mut ChaCha8Rng, taken: impl Fn(usize) -> bool) -> usize {
    loop {
        let candidate = rng.below(n);
        if !taken(candidate) {
            return candidate;
        }
    }
}

/// Adds a beaten member, in place of a random one if the archive is full.
fn into_archive(archive: &mut Vec<DVector<f64>>, x: &DVector<f64>, size: usize, rng: &mut ChaCha8Rng) {
    if archive.len() < size {
        archive.push(x.clone());
    } else {
        let replaced = rng.below(archive.len());
        archive[replaced].copy_from(x);
    }
}

/// The factors that succeeded, and what they gained.
#[derive(Debug)]
struct SuccessHistory {
    weight: [f64; MEMORY],
    /// Nothing where only CR = 0 succeeded: from then on CR stays 0 there.
    crossover_rate: [Option<f64>; MEMORY],
    next: usize,
    successes: Vec<(Factors, f64)>,
}

impl SuccessHistory {
    fn new() -> Self {
        Self { weight: [0.5; MEMORY], crossover_rate: [Some(0.5); MEMORY], next: 0, successes: Vec::new() }
    }

    /// F from a Cauchy and CR from a normal distribution around a random entry of the memory.
    fn draw(&self, rng: &mut ChaCha8Rng) -> Factors {
        let entry = rng.below(MEMORY);
        let crossover_rate = self.crossover_rate[entry].map_or(0.0, |m| (m + SPREAD * rng.normal()).clamp(0.0, 1.0));
        let weight = loop {
            let weight = self.weight[entry] + SPREAD * rng.cauchy();
            if weight > 0.0 {
                break weight.min(1.0);
            }
        };
        Factors { weight, crossover_rate }
    }

    fn remember(&mut self, factors: Factors, gain: f64) {
        self.successes.push((factors, gain));
    }

    /// Overwrites the oldest entry with this generation's means, weighted by gain.
    ///
    /// ```text
    /// mean = Σ w s² / Σ w s     (Lehmer), w = gain
    /// ```
    fn update(&mut self) {
        if self.successes.is_empty() {
            return;
        }
        // the gain over a point that had no cost is unknown: counted as the largest known one
        let largest = self.successes.iter().map(|s| s.1).filter(|g| g.is_finite()).fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let lehmer = |of: fn(&Factors) -> f64| {
            let sums = self.successes.iter().fold((0.0, 0.0), |(square, plain), (factors, gain)| {
                let (s, w) = (of(factors), gain.min(largest));
                (square + w * s * s, plain + w * s)
            });
            (sums.1 > 0.0).then(|| sums.0 / sums.1)
        };
        let weight = lehmer(|f| f.weight);
        let crossover_rate = lehmer(|f| f.crossover_rate);
        self.weight[self.next] = weight.unwrap_or(self.weight[self.next]);
        self.crossover_rate[self.next] = self.crossover_rate[self.next].and(crossover_rate);
        self.next = (self.next + 1) % MEMORY;
        self.successes.clear();
    }
}
