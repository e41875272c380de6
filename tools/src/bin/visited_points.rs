//! Is any cost of the batched kernel wrong where optimisers go? Fits of the flagship by several methods, costs and seeds;
//! every cost that an optimiser is given is computed again by the reference path.
//!
//! ```text
//! cargo run --release -p retune-tools --bin visited_points -- 1000000 1e-9     # points, largest relative difference
//! ```
//!
//! The reference is the dense path: assembly of K and M, faer's Cholesky factorisation and eigensolver on scaled matrices.
//! Fails if any cost differs by more.
#![allow(missing_docs, clippy::print_stdout)]

use retune::correlation::PairingOptions;
use retune::data::read_test;
use retune::linalg::DVector;
use retune::model::{Registry, load};
use retune::objective::{
    Comparison, EvalError, LeastSquares, Linearization, Objective, PaperCost, PathCounts, Walls, starting_point,
};
use retune::optim::{OptimizerSpec, Run};
use std::error::Error;
use std::sync::{Mutex, PoisonError};

const METHODS: [&str; 6] = [
    "{differential-evolution: {strategy: classic, tolerance: 0}}",
    "{differential-evolution: {tolerance: 0}}",
    "cma-es",
    "nelder-mead",
    "multistart",
    "auto",
];

/// What the checks found.
#[derive(Debug, Default)]
struct Tally {
    points: usize,
    worst: f64,
    wrong: Vec<(DVector<f64>, f64, f64)>,
}

/// An objective that computes every cost twice.
struct Checked<'a> {
    inner: &'a dyn Objective,
    tolerance: f64,
    tally: Mutex<Tally>,
}

impl Objective for Checked<'_> {
    fn n_parameters(&self) -> usize {
        self.inner.n_parameters()
    }
    fn n_residuals(&self) -> usize {
        self.inner.n_residuals()
    }
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        self.inner.residuals(x)
    }
    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        self.inner.linearize(x)
    }
    fn walls(&self) -> Walls {
        self.inner.walls()
    }
    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        self.inner.cost(x)
    }
    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        self.inner.costs(points, out);
        for (x, &cost) in points.iter().zip(out.iter()) {
            let reference = self.inner.cost(x).unwrap_or(f64::INFINITY);
            let same = cost.to_bits() == reference.to_bits();
            let error = if same { 0.0 } else { (cost - reference).abs() / reference.abs() };
            let mut tally = self.tally.lock().unwrap_or_else(PoisonError::into_inner);
            tally.points += 1;
            tally.worst = tally.worst.max(error);
            // Not `error > tolerance`: NaN is wrong too.
            let right = error <= self.tolerance;
            if !right {
                tally.wrong.push((x.clone(), cost, reference));
            }
        }
    }
    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        self.inner.confirm(x, cost)
    }
    fn path_counts(&self) -> PathCounts {
        self.inner.path_counts()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [points, tolerance] = arguments.as_slice() else {
        return Err("usage: visited_points POINTS TOLERANCE".into());
    };
    let (points, tolerance): (usize, f64) = (points.parse()?, tolerance.parse()?);
    let text = |name: &str| std::fs::read_to_string(format!("{}/../models/{name}", env!("CARGO_MANIFEST_DIR")));
    let (model, ..) = load(&text("bff.yaml")?, &Registry::builtin()).map_err(|p| format!("{p:?}"))?;
    let (test, ..) = read_test(&text("bff_gvt.yaml")?).map_err(|p| format!("{p:?}"))?;
    let comparison = Comparison::new(&model, &test, PairingOptions::default())?;
    let (mut total, mut kernel, mut wrong, mut worst) = (0, 0, 0, 0.0f64);
    for seed in 0.. {
        for (name, method) in ["paper", "least-squares", "frequencies"].iter().flat_map(|c| METHODS.map(|m| (*c, m))) {
            if total >= points {
                break;
            }
            let (paper, squares, frequencies) =
                (PaperCost::new(&comparison), LeastSquares::new(&comparison), PaperCost::frequencies_only(&comparison));
            let inner: &dyn Objective = match name {
                "paper" => &paper,
                "frequencies" => &frequencies,
                _ => &squares,
            };
            let checked = Checked { inner, tolerance, tally: Mutex::default() };
            let spec: OptimizerSpec = retune::yaml::read(method).map_err(|p| format!("{p:?}"))?.0;
            let start = paper.scaling().x(&starting_point(&model));
            let optimum = spec.as_dyn().minimize(&start, &mut Run::new(&checked).seed(seed).budget(20_000))?;
            let tally = checked.tally.into_inner()?;
            total += tally.points;
            kernel += optimum.paths.batch;
            wrong += tally.wrong.len();
            worst = worst.max(tally.worst);
            println!(
                "seed {seed}, {name}, {method}: {} points to cost {:.6e}, worst difference {:.1e}, {} wrong; {total} in all",
                tally.points,
                optimum.cost,
                tally.worst,
                tally.wrong.len()
            );
            for (x, cost, reference) in tally.wrong.iter().take(3) {
                println!("  {cost:e} against {reference:e} at {:?}", x.as_slice());
            }
        }
        if total >= points {
            break;
        }
    }
    println!(
        "{total} points, {kernel} of them by the kernel: {wrong} differ by more than {tolerance:e}, worst {worst:.1e}"
    );
    if wrong > 0 { Err("wrong costs".into()) } else { Ok(()) }
}
