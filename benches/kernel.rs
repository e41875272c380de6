//! The batch kernel beside one candidate at a time: lowest 9 elastic modes of a swept free-free grillage.
//!
//! `cargo bench --bench kernel`; every number is the time of 64 candidates, assembly included.
//! `RETUNE_DUMP=folder cargo bench --bench kernel` writes the matrices for `benches/peers/scipy_eigh.py` instead.
#![allow(missing_docs)]

mod grillage;

use divan::{Bencher, black_box};
use retune::linalg::DMatrix;
use retune::linalg::batch::{AffineEntry, AffinePencil, BatchModel, BatchOptions, Mirror, Workspace};

const CANDIDATES: usize = 64;
const N_MODES: usize = 9;
/// Nodes a wing: n = 24, 42, 60, 120, 300.
const WINGS: [usize; 5] = [2, 5, 8, 18, 48];

fn main() {
    match std::env::var("RETUNE_DUMP") {
        Ok(folder) => WINGS.iter().for_each(|&wing| dump(wing, std::path::Path::new(&folder))),
        Err(_) => divan::main(),
    }
}

fn model(wing: usize, halves: bool) -> (BatchModel, Vec<Vec<f64>>) {
    let data = grillage::grillage(wing);
    let entry = |&(row, col, parameter, coefficient): &grillage::Term| AffineEntry { row, col, parameter, coefficient };
    let pencil = AffinePencil {
        n: data.n,
        n_parameters: data.bounds.len(),
        stiffness: data.stiffness.iter().map(entry).collect(),
        mass: data.mass.iter().map(entry).collect(),
    };
    let options = BatchOptions {
        n_modes: N_MODES,
        rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
        mirror: halves.then(|| Mirror { permutation: data.mirror.0.clone(), signs: data.mirror.1.clone() }),
        sensors: None,
        references: None,
        shapes: true,
    };
    let thetas = grillage::candidates(&data, CANDIDATES, 1);
    (BatchModel::new(pencil, &grillage::nominal(&data), options).expect("the grillage is sound"), thetas)
}

fn batch(bencher: Bencher<'_, '_>, wing: usize, halves: bool) {
    let (model, thetas) = model(wing, halves);
    let slices: Vec<&[f64]> = thetas.iter().map(Vec::as_slice).collect();
    let mut workspace = Workspace::new(&model, CANDIDATES);
    bencher
        .counter(divan::counter::ItemsCount::new(CANDIDATES))
        .bench_local(|| model.solve(black_box(&slices), &mut workspace).expect("sizes fit").values(0)[0]);
}

#[divan::bench(args = WINGS)]
fn batch_of_halves(bencher: Bencher<'_, '_>, wing: usize) {
    batch(bencher, wing, true);
}

#[divan::bench(args = WINGS)]
fn batch_of_wholes(bencher: Bencher<'_, '_>, wing: usize) {
    batch(bencher, wing, false);
}

#[divan::bench(args = WINGS, sample_size = 1, sample_count = 10)]
fn one_at_a_time(bencher: Bencher<'_, '_>, wing: usize) {
    let (model, thetas) = model(wing, false);
    bencher.counter(divan::counter::ItemsCount::new(CANDIDATES)).bench_local(|| {
        thetas.iter().map(|t| model.reference(black_box(t)).expect("the grillage is sound").0[0]).sum::<f64>()
    });
}

/// Writes K and M of all candidates as raw f64, and prints our time per candidate: `n microseconds`.
fn dump(wing: usize, folder: &std::path::Path) {
    let (model, thetas) = model(wing, true);
    let slices: Vec<&[f64]> = thetas.iter().map(Vec::as_slice).collect();
    let mut workspace = Workspace::new(&model, CANDIDATES);
    let mut best = f64::INFINITY;
    for _ in 0..100 {
        let begin = std::time::Instant::now();
        black_box(model.solve(black_box(&slices), &mut workspace).expect("sizes fit"));
        best = best.min(begin.elapsed().as_secs_f64() * 1e6 / CANDIDATES as f64);
    }
    let modes = model.solve(&slices, &mut workspace).expect("sizes fit");
    let mut bytes = Vec::new();
    for (c, theta) in thetas.iter().enumerate() {
        let (k, m) = model.pencil().assemble(theta);
        let numbers = k.iter().chain(m.iter()).chain(modes.values(c));
        bytes.extend(numbers.flat_map(|v| v.to_le_bytes()));
    }
    let n = model.pencil().n;
    std::fs::write(folder.join(format!("grillage_{n}.f64")), bytes).expect("the folder is writable");
    println!("{n} {best}");
}
