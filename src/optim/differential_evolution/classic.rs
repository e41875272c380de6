use super::super::random::Draw;
use super::super::{Run, Stop, Termination};
use super::{DifferentialEvolution, back_inside, first_population};
use crate::linalg::DVector;

const POPULATION: usize = 200;
const GENERATIONS: usize = 100;
const DIFFERENTIAL_WEIGHT: f64 = 0.8;
const CROSSOVER_RATE: f64 = 0.9;

impl DifferentialEvolution {
    /// DE/rand/1/bin (Storn and Price 1997), a generation at a time.
    ///
    /// ```text
    /// v = x_a + F (x_b - x_c),   a, b, c and i all different
    /// u_j = v_j with probability CR and for one random j, x_ij otherwise
    /// x_i <- u if cost(u) <= cost(x_i)
    /// ```
    pub(super) fn classic(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let n = self.population.unwrap_or(POPULATION);
        let weight = self.differential_weight.unwrap_or(DIFFERENTIAL_WEIGHT);
        let crossover_rate = self.crossover_rate.unwrap_or(CROSSOVER_RATE);

        let (mut members, mut costs) = first_population(n, start, run)?;
        let (mut trials, mut trial_costs) = (members.clone(), costs.clone());
        let mut rng = run.rng(1);
        for _generation in 1..self.generations.unwrap_or(GENERATIONS) {
            for (i, trial) in trials.iter_mut().enumerate() {
                let [a, b, c] = three_others(i, n, &mut rng);
                let certain = rng.below(start.len());
                let [a, b, c, member] = [a, b, c, i].map(|k| members[k].as_slice());
                for (j, value) in trial.as_mut_slice().iter_mut().enumerate() {
                    let is_mutated = rng.unit() < crossover_rate || j == certain;
                    let mutant = back_inside(a[j] + weight * (b[j] - c[j]), member[j]);
                    *value = if is_mutated { mutant } else { member[j] };
                }
            }
            run.costs(&trials, &mut trial_costs)?;
            for i in 0..n {
                if trial_costs[i] <= costs[i] {
                    members[i].copy_from(&trials[i]);
                    costs[i] = trial_costs[i];
                }
            }
            if self.agree(costs.iter().copied()) {
                return Ok(Termination::PointsAgree);
            }
        }
        Ok(if run.remaining() == Some(0) { Termination::BudgetSpent } else { Termination::PlanDone })
    }
}

/// Three members that differ from each other and from `i`.
fn three_others(i: usize, n: usize, rng: &mut impl Draw) -> [usize; 3] {
    let mut chosen = [i; 4];
    for k in 1..4 {
        chosen[k] = loop {
            let candidate = rng.below(n);
            if !chosen[..k].contains(&candidate) {
                break candidate;
            }
        };
    }
    [chosen[1], chosen[2], chosen[3]]
}
