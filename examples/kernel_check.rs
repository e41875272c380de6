//! Compares the batch kernel with the reference path on many random candidates, and times it.
//!
//! `cargo run --release --example kernel_check -- [wing nodes] [candidates] [mirror|whole] [modes]`
#![allow(missing_docs, clippy::print_stdout)]

#[path = "../benches/grillage/mod.rs"]
mod grillage;

use std::time::Instant;

use retune::linalg::DMatrix;
use retune::linalg::batch::{AffineEntry, AffinePencil, BatchModel, BatchOptions, Mirror, Workspace};

fn entries(terms: &[grillage::Term]) -> Vec<AffineEntry> {
    terms.iter().map(|&(row, col, parameter, coefficient)| AffineEntry { row, col, parameter, coefficient }).collect()
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (wing, count, n_modes) = (number(0, 5), number(1, 1024), number(3, 9));
    let mirrored = arguments.get(2).is_none_or(|a| a == "mirror");
    let data = grillage::grillage(wing);
    let pencil = AffinePencil {
        n: data.n,
        n_parameters: data.bounds.len(),
        stiffness: entries(&data.stiffness),
        mass: entries(&data.mass),
    };
    let options = BatchOptions {
        n_modes,
        rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
        mirror: mirrored.then(|| Mirror { permutation: data.mirror.0.clone(), signs: data.mirror.1.clone() }),
        sensors: None,
    };
    let model = BatchModel::new(pencil, &grillage::nominal(&data), options).expect("the grillage is sound");
    let mut workspace = Workspace::new(&model, 256);
    if std::env::var("TIME").is_ok() {
        let thetas = grillage::candidates(&data, 256, 1);
        let slices: Vec<&[f64]> = thetas.iter().map(Vec::as_slice).collect();
        let mut best = f64::INFINITY;
        for _ in 0..count {
            let begin = Instant::now();
            model.solve(&slices, &mut workspace).expect("sizes fit");
            best = best.min(begin.elapsed().as_secs_f64() * 1e6 / 256.0);
        }
        println!("n = {}: best {best:.2} us", data.n);
        return;
    }
    let mut worst = [0.0_f64; 3];
    let (mut wrong, mut redone) = (0, 0);
    let mut microseconds = Vec::new();
    let mut seed = 1;
    let mut done = 0;
    while done < count {
        let thetas = grillage::candidates(&data, 256.min(count - done), seed);
        let slices: Vec<&[f64]> = thetas.iter().map(Vec::as_slice).collect();
        let begin = Instant::now();
        let modes = model.solve(&slices, &mut workspace).expect("sizes fit");
        microseconds.push(begin.elapsed().as_secs_f64() * 1e6 / slices.len() as f64);
        redone += modes.n_redone();
        for (c, theta) in slices.iter().enumerate() {
            let (values, _) = model.reference(theta).expect("the grillage is sound");
            let error = values.iter().zip(modes.values(c)).map(|(a, b)| (b / a - 1.0).abs() / 2.0).fold(0.0, f64::max);
            if std::env::var("DBG").is_ok() && c < 4 { println!("{:?}\n{:?}\n{:?}", modes.outcome(c), values, modes.values(c)); }
            // A comparison that NaN fails.
            if !(error < 1e-9) {
                wrong += 1;
                println!("wrong: {error:.1e} at seed {seed} candidate {c}: {:?}", modes.outcome(c));
            }
            worst[0] = worst[0].max(error);
            let (k, m) = model.pencil().assemble(theta);
            let phi = DMatrix::from_fn(data.n, n_modes, |i, j| modes.shape(c, j)[i]);
            let mphi = &m * &phi;
            let gram = (phi.transpose() * &mphi - DMatrix::identity(n_modes, n_modes)).abs().max();
            worst[1] = worst[1].max(gram);
            for j in 0..n_modes {
                let r = (&k * phi.column(j) - mphi.column(j) * modes.values(c)[j]).abs().max();
                worst[2] = worst[2].max(r / (k.abs().max() * phi.column(j).abs().max()));
            }
        }
        done += slices.len();
        seed += 1;
    }
    microseconds.sort_by(f64::total_cmp);
    println!(
        "n = {}, {done} candidates: {:.2} us each (median; best {:.2}), {wrong} wrong, {redone} redone, \
         worst frequency error {:.1e}, orthogonality {:.1e}, residual {:.1e}",
        data.n,
        microseconds[microseconds.len() / 2],
        microseconds[0],
        worst[0],
        worst[1],
        worst[2]
    );
}
