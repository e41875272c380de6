//! Writes synthetic functions for `sdypy_ema.py` and identifies them: errors and time. Arguments: folder, lines, seeds.
//!
//! Run: `cargo run --release -p retune-tools --bin identify_accuracy -- /tmp/frfs 4096 5`, then `python benches/peers/sdypy_ema.py /tmp/frfs`.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use retune::data::{Channel, FrfQuantity, FrfSet};
use retune::identify::{IdentifyOptions, identify};
use retune::linalg::Complex;
use std::f64::consts::TAU;
use std::io::Write;

const MODES: [(f64, f64); 6] =
    [(5.67, 0.0155), (8.37, 0.0106), (18.34, 0.0206), (19.82, 0.0233), (23.17, 0.0285), (28.6, 0.0255)];

fn shape(k: usize, o: usize) -> f64 {
    ((k + 1) as f64 * 0.7 * (o as f64 + 1.3) / 5.0 + k as f64).cos()
}

fn functions(lines: usize, eps: f64, seed: u64) -> FrfSet {
    let (n, reference) = (34, 11);
    let frequencies_hz: Vec<f64> = (0..lines).map(|l| 35.0 * l as f64 / (lines - 1) as f64).collect();
    let mut h = Vec::new();
    for f in &frequencies_hz {
        let w = TAU * f;
        for o in 0..n {
            h.push(MODES.iter().enumerate().fold(Complex::new(0.0, 0.0), |sum, (k, (fr, z))| {
                let wr = TAU * fr;
                sum - w * w * shape(k, o) * shape(k, reference) / Complex::new(wr * wr - w * w, 2.0 * z * wr * w)
            }));
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for o in 0..n {
        let rms = ((0..lines).map(|l| h[l * n + o].norm_sqr()).sum::<f64>() / lines as f64).sqrt();
        for l in 0..lines {
            let (u, v): (f64, f64) = (rng.random(), rng.random());
            h[l * n + o] += Complex::from_polar(eps * rms * (-(1.0 - u).ln()).sqrt(), TAU * v);
        }
    }
    let channel = |k: usize| Channel { name: (k + 1).to_string(), direction: None };
    let (references, responses) = (vec![channel(reference)], (0..n).map(channel).collect());
    let quantity = FrfQuantity::Accelerance;
    FrfSet { quantity, frequencies_hz, references, responses, h, coherence: None, n_averages: None }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, lines, seeds] = arguments.as_slice() else { return Err("arguments: folder, lines, seeds".into()) };
    let (lines, seeds): (usize, u64) = (lines.parse()?, seeds.parse()?);
    std::fs::create_dir_all(folder)?;
    for eps in [0.01, 0.05, 0.1] {
        let (mut f2, mut z2, mut worst, mut lost, mut time) = (0.0, 0.0, 0.0_f64, 0, 0.0);
        for seed in 0..seeds {
            let frfs = functions(lines, eps, seed);
            let mut file = std::io::BufWriter::new(std::fs::File::create(format!("{folder}/frf_{eps}_{seed}.bin"))?);
            for x in &frfs.h {
                file.write_all(&x.re.to_le_bytes())?;
                file.write_all(&x.im.to_le_bytes())?;
            }
            let clock = std::time::Instant::now();
            let found = identify(&frfs, &IdentifyOptions::default())?;
            time += clock.elapsed().as_secs_f64();
            for (k, (f, z)) in MODES.iter().enumerate() {
                let Some(m) = found.modes.iter().find(|m| (m.frequency_hz.value / f - 1.0).abs() < 0.01) else {
                    lost += 1;
                    continue;
                };
                f2 += (m.frequency_hz.value / f - 1.0).powi(2);
                z2 += (m.damping_ratio.value / z - 1.0).powi(2);
                let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
                for o in 0..34 {
                    let (a, b) = (shape(k, o), m.normal_shape[o]);
                    (ab, aa, bb) = (ab + a * b, aa + a * a, bb + b * b);
                }
                worst = worst.max(1.0 - ab * ab / (aa * bb));
            }
        }
        let n = (6 * seeds) as f64 - f64::from(lost);
        println!(
            "retune   noise {eps:5}: rms error f {:.1e}, damping {:.1e}; worst 1-MAC {worst:.1e}; lost {lost}; {:.0} ms",
            (f2 / n).sqrt(),
            (z2 / n).sqrt(),
            1e3 * time / seeds as f64
        );
    }
    Ok(())
}
