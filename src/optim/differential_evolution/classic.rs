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
        let mut recipes = Recipes::new(n, start.len());
        recipes.draw(crossover_rate, &mut rng);
        let mut next = recipes.clone();
        for _generation in 1..self.generations.unwrap_or(GENERATIONS) {
            for (i, trial) in trials.iter_mut().enumerate() {
                recipes.apply(i, weight, &members, trial);
            }
            // No draw depends on a cost, so the next ones are made beside the evaluations.
            rayon::in_place_scope(|scope| {
                scope.spawn(|_| next.draw(crossover_rate, &mut rng));
                run.costs(&trials, &mut trial_costs)
            })?;
            std::mem::swap(&mut recipes, &mut next);
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

/// What chance decides of every trial point of a generation.
#[derive(Clone)]
struct Recipes {
    others: Vec<[usize; 3]>,
    /// Whether a parameter is the mutant's, the parameters of a member side by side.
    is_mutated: Vec<bool>,
    n_parameters: usize,
}

impl Recipes {
    fn new(n_members: usize, n_parameters: usize) -> Self {
        Self { others: vec![[0; 3]; n_members], is_mutated: vec![false; n_members * n_parameters], n_parameters }
    }

    fn draw(&mut self, crossover_rate: f64, rng: &mut impl Draw) {
        let n = self.others.len();
        for (i, others) in self.others.iter_mut().enumerate() {
            *others = three_others(i, n, rng);
            let certain = rng.below(self.n_parameters);
            for (j, is_mutated) in self.is_mutated[i * self.n_parameters..][..self.n_parameters].iter_mut().enumerate()
            {
                *is_mutated = rng.unit() < crossover_rate || j == certain;
            }
        }
    }

    fn apply(&self, i: usize, weight: f64, members: &[DVector<f64>], trial: &mut DVector<f64>) {
        let [a, b, c] = self.others[i].map(|k| members[k].as_slice());
        let member = members[i].as_slice();
        let is_mutated = &self.is_mutated[i * self.n_parameters..];
        for (j, value) in trial.as_mut_slice().iter_mut().enumerate() {
            let mutant = back_inside(a[j] + weight * (b[j] - c[j]), member[j]);
            *value = if is_mutated[j] { mutant } else { member[j] };
        }
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
