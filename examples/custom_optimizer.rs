//! An optimiser of your own: compass search. It asks for the 2 n neighbours of the best point in one batch, goes to the
//! best of them, and halves its step when none is better.
//!
//! `Run` counts, bounds, stops, evaluates in parallel and keeps the best point. Run it with
//! `cargo run --example custom_optimizer`.

use retune::linalg::DVector;
use retune::objective::{EvalError, Objective};
use retune::optim::{NelderMead, OptimError, Optimizer, Optimum, Run, Termination, in_sequence};

#[derive(Debug)]
pub(crate) struct CompassSearch {
    pub(crate) first_step: f64,
    pub(crate) last_step: f64,
}

impl Optimizer for CompassSearch {
    fn name(&self) -> &'static str {
        "compass-search"
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        let mut x = run.clip(start)?;
        run.conclude(self.name(), |run| {
            let mut cost = run.cost(&x)?;
            let mut step = self.first_step;
            while step > self.last_step {
                let neighbours: Vec<DVector<f64>> = (0..2 * x.len())
                    .map(|k| {
                        let mut p = x.clone();
                        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                        p[k / 2] = (p[k / 2] + sign * step).clamp(0.0, 1.0);
                        p
                    })
                    .collect();
                let mut costs = vec![0.0; neighbours.len()];
                run.costs(&neighbours, &mut costs)?;
                let best = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
                if costs[best] < cost {
                    (x, cost) = (neighbours[best].clone(), costs[best]);
                } else {
                    step *= 0.5;
                }
            }
            Ok(Termination::PointsAgree)
        })
    }
}

/// A curved valley with its end at (0.5, 0.25).
struct Valley;

impl Objective for Valley {
    fn n_parameters(&self) -> usize {
        2
    }
    fn n_residuals(&self) -> usize {
        2
    }
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        Ok(DVector::from_vec(vec![5.0 * (x[1] - x[0] * x[0]), 0.5 - x[0]]))
    }
}

pub(crate) fn main() -> Result<(), OptimError> {
    let start = DVector::from_vec(vec![0.9, 0.1]);
    let compass = CompassSearch { first_step: 0.25, last_step: 1e-4 };
    let alone = compass.minimize(&start, &mut Run::new(&Valley).budget(5_000))?;
    println!("alone: {:.4}, {:.4} after {} evaluations", alone.x[0], alone.x[1], alone.evaluations);
    // Beside the built-in methods: a rough search first, Nelder-Mead to finish.
    let rough = CompassSearch { first_step: 0.25, last_step: 0.05 };
    let both = in_sequence(&[&rough, &NelderMead::default()], &start, &mut Run::new(&Valley).budget(5_000))?;
    println!("then Nelder-Mead: {:.6}, {:.6} after {} evaluations", both.x[0], both.x[1], both.evaluations);
    Ok(())
}
