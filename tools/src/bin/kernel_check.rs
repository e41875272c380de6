//! Looks for wrong values of the batch kernel: compares it with the reference path on random candidates and on those that
//! an optimiser visits, which is where rare errors are found and exploited.
//!
//! `cargo run --release -p retune-tools --bin kernel_check -- [wing nodes] [candidates] [halves|whole] [modes]`
#![allow(missing_docs, clippy::print_stdout)]

#[path = "../../../benches/grillage/mod.rs"]
mod grillage;

use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use retune::linalg::DMatrix;
use retune::linalg::batch::{AffineEntry, AffinePencil, BatchModel, BatchModes, BatchOptions, Mirror, Workspace};

/// Relative frequency difference above which a value counts as wrong.
const WRONG: f64 = 1e-9;
const POPULATION: usize = 64;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (wing, count, n_modes) = (number(0, 5), number(1, 4096), number(3, 9));
    let halves = arguments.get(2).is_none_or(|a| a == "halves");
    let data = grillage::grillage(wing);
    let model = compile(&data, n_modes, halves);
    let mut workspace = Workspace::new(&model, POPULATION);
    let mut check = Check::default();
    let mut seed = 0;
    while check.candidates < count {
        seed += 1;
        check.batch(&model, &grillage::candidates(&data, POPULATION, seed), &mut workspace);
        // Every 32nd round an optimiser starts; it visits as many points as were drawn at random in between.
        if seed % 32 == 0 {
            evolve(&data, &model, seed, &mut check, &mut workspace);
        }
    }
    check.microseconds.sort_by(f64::total_cmp);
    println!(
        "n = {}, {} candidates, {n_modes} modes: {:.2} us each (median; best {:.2}), {} wrong, {} redone, \
         worst frequency difference {:.1e}; λ_n/λ_1 up to {:.0e}, M-orthogonality {:.1e} (dense reference {:.1e}), residual {:.1e} ({:.1e})",
        data.n,
        check.candidates,
        check.microseconds[check.microseconds.len() / 2],
        check.microseconds[0],
        check.wrong,
        check.redone,
        check.frequency,
        check.spread,
        check.kernel.orthogonality,
        check.reference.orthogonality,
        check.kernel.residual,
        check.reference.residual
    );
}

fn compile(data: &grillage::Grillage, n_modes: usize, halves: bool) -> BatchModel {
    let entry = |&(row, col, parameter, coefficient): &grillage::Term| AffineEntry { row, col, parameter, coefficient };
    let pencil = AffinePencil {
        n: data.n,
        n_parameters: data.bounds.len(),
        stiffness: data.stiffness.iter().map(entry).collect(),
        mass: data.mass.iter().map(entry).collect(),
    };
    let options = BatchOptions {
        n_modes,
        rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
        mirror: halves.then(|| Mirror { permutation: data.mirror.0.clone(), signs: data.mirror.1.clone() }),
        sensors: None,
        references: None,
        shapes: true,
    };
    BatchModel::new(pencil, &grillage::nominal(data), options).expect("the grillage is sound")
}

/// What was found so far.
#[derive(Default)]
struct Check {
    candidates: usize,
    wrong: usize,
    redone: usize,
    frequency: f64,
    /// Largest ratio of the last wanted λ to the first.
    spread: f64,
    kernel: Quality,
    reference: Quality,
    microseconds: Vec<f64>,
}

impl Check {
    /// Solves a batch and compares it.
    fn batch<'w>(&mut self, model: &BatchModel, thetas: &[Vec<f64>], workspace: &'w mut Workspace) -> &'w BatchModes {
        let slices: Vec<&[f64]> = thetas.iter().map(Vec::as_slice).collect();
        let begin = Instant::now();
        let modes = model.solve(&slices, workspace).expect("sizes fit");
        self.microseconds.push(begin.elapsed().as_secs_f64() * 1e6 / slices.len() as f64);
        self.redone += modes.n_redone();
        for (c, theta) in slices.iter().enumerate() {
            let (values, shapes) = model.reference(theta).expect("the grillage is sound");
            let pairs = values.iter().zip(modes.values(c));
            let worst = pairs.map(|(a, b)| ((b / a).sqrt() - 1.0).abs()).fold(0.0, f64::max);
            // A NaN must count as wrong, so the comparison is this way round.
            if worst < WRONG {
                self.frequency = self.frequency.max(worst);
            } else {
                self.wrong += 1;
                println!("wrong by {worst:.1e} ({:?}): {theta:?}", modes.outcome(c));
            }
            // The products cost more than the solution: a sample is enough.
            if c == 0 {
                let kernel = DMatrix::from_fn(shapes.nrows(), values.len(), |i, j| modes.shape(0, j)[i]);
                self.kernel.add(model, theta, modes.values(0), &kernel);
                self.reference.add(model, theta, &values, &shapes);
                self.spread = self.spread.max(values[values.len() - 1] / values[0]);
            }
        }
        self.candidates += slices.len();
        modes
    }
}

/// The worst M-orthogonality, and the worst residual over max|K| max|φ|, of one way to solve.
#[derive(Default)]
struct Quality {
    orthogonality: f64,
    residual: f64,
}

impl Quality {
    fn add(&mut self, model: &BatchModel, theta: &[f64], values: &[f64], phi: &DMatrix<f64>) {
        let (k, m) = model.pencil().assemble(theta);
        let m_phi = &m * phi;
        let gram = (phi.transpose() * &m_phi - DMatrix::identity(values.len(), values.len())).abs().max();
        self.orthogonality = self.orthogonality.max(gram);
        for (j, lambda) in values.iter().enumerate() {
            let r = (&k * phi.column(j) - m_phi.column(j) * *lambda).abs().max();
            self.residual = self.residual.max(r / (k.abs().max() * phi.column(j).abs().max()));
        }
    }
}

/// Differential evolution (rand/1/bin) towards the frequencies of a random target.
fn evolve(data: &grillage::Grillage, model: &BatchModel, seed: u64, check: &mut Check, workspace: &mut Workspace) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let target = check.batch(model, &grillage::candidates(data, 1, seed + 1_000_000), workspace).values(0).to_vec();
    let cost = |values: &[f64]| -> f64 { values.iter().zip(&target).map(|(v, t)| (v / t - 1.0).powi(2)).sum() };
    let mut population = grillage::candidates(data, POPULATION, seed + 2_000_000);
    let modes = check.batch(model, &population, workspace);
    let mut costs: Vec<f64> = (0..POPULATION).map(|c| cost(modes.values(c))).collect();
    for _ in 0..30 {
        let trials: Vec<Vec<f64>> = (0..POPULATION)
            .map(|c| {
                let [a, b, d] = std::array::from_fn(|_| rng.random_range(0..POPULATION));
                let forced = rng.random_range(0..data.bounds.len());
                let mutate = |(j, &(low, high)): (usize, &(f64, f64))| {
                    let value = population[a][j] + 0.5 * (population[b][j] - population[d][j]);
                    let crossed = j == forced || rng.random::<f64>() < 0.9;
                    if crossed { value.clamp(low, high) } else { population[c][j] }
                };
                data.bounds.iter().enumerate().map(mutate).collect()
            })
            .collect();
        let modes = check.batch(model, &trials, workspace);
        for (c, trial) in trials.into_iter().enumerate() {
            let new = cost(modes.values(c));
            if new <= costs[c] {
                (costs[c], population[c]) = (new, trial);
            }
        }
    }
}
