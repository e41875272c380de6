//! Identification of 34 channels x 4,096 lines, six modes, 1 % noise. Run: `cargo bench --bench identify`.

use retune::data::{Channel, FrfQuantity, FrfSet};
use retune::identify::{IdentifyOptions, Segments, identify};
use retune::linalg::Complex;
use std::f64::consts::TAU;

fn main() {
    divan::main();
}

/// Six modes of a free-free beam at 34 points, accelerance over point 12; the same recipe as `peers/sdypy_ema.py`.
fn functions(lines: usize) -> FrfSet {
    let (n, reference) = (34, 11);
    let modes = [(5.67, 0.0155), (8.37, 0.0106), (18.34, 0.0206), (19.82, 0.0233), (23.17, 0.0285), (28.6, 0.0255)];
    let shape = |k: usize, o: usize| ((k + 1) as f64 * 0.7 * (o as f64 + 1.3) / 5.0 + k as f64).cos();
    // A linear congruential generator: the noise must be the same everywhere, its quality does not matter.
    let mut state = 12345_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let frequencies_hz: Vec<f64> = (0..lines).map(|l| 3.0 + 32.0 * l as f64 / (lines - 1) as f64).collect();
    let mut h = Vec::with_capacity(lines * n);
    for f in &frequencies_hz {
        let w = TAU * f;
        for o in 0..n {
            let mut sum = Complex::new(0.0, 0.0);
            for (k, (fr, z)) in modes.iter().enumerate() {
                let wr = TAU * fr;
                sum += -w * w * shape(k, o) * shape(k, reference) / Complex::new(wr * wr - w * w, 2.0 * z * wr * w);
            }
            let noise = Complex::new(uniform() - 0.5, uniform() - 0.5) * 0.1;
            h.push(sum + noise);
        }
    }
    let channel = |k: usize| Channel { name: (k + 1).to_string(), direction: None };
    FrfSet {
        quantity: FrfQuantity::Accelerance,
        frequencies_hz,
        references: vec![channel(reference)],
        responses: (0..n).map(channel).collect(),
        h,
        coherence: None,
        n_averages: None,
    }
}

/// 20 model orders (2, 4, ... 40), poles, residues, refinement, uncertainties.
#[divan::bench(args = [1025, 4096])]
fn twenty_orders_34_channels(bencher: divan::Bencher<'_, '_>, lines: usize) {
    let frfs = functions(lines);
    bencher.bench(|| identify(&frfs, &IdentifyOptions::default()));
}

/// The same in one piece.
#[divan::bench(args = [4096])]
fn in_one_piece(bencher: divan::Bencher<'_, '_>, lines: usize) {
    let frfs = functions(lines);
    let options = IdentifyOptions { segments: Segments::Whole, ..IdentifyOptions::default() };
    bencher.bench(|| identify(&frfs, &options));
}
