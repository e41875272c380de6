//! Makes functions with known modes.

use crate::data::{Channel, FrfQuantity, FrfSet};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use retune_linalg::Complex;
use std::f64::consts::TAU;

/// A mode of receptance: residue ψ lᵀ.
#[derive(Clone)]
pub(in crate::identify) struct TrueMode {
    pub(in crate::identify) f: f64,
    pub(in crate::identify) zeta: f64,
    pub(in crate::identify) psi: Vec<Complex<f64>>,
    pub(in crate::identify) l: Vec<Complex<f64>>,
}

impl TrueMode {
    /// Proportionally damped: φ real, residue φ_o φ_i/(2iω_d).
    pub(in crate::identify) fn real(f: f64, zeta: f64, phi: &[f64], at: &[f64]) -> Self {
        let omega_d = TAU * f * (1.0 - zeta * zeta).sqrt();
        let psi = phi.iter().map(|x| Complex::new(0.0, -0.5 * x / omega_d)).collect();
        Self { f, zeta, psi, l: at.iter().map(|x| Complex::new(*x, 0.0)).collect() }
    }

    pub(in crate::identify) fn pole(&self) -> Complex<f64> {
        Complex::new(-self.zeta, (1.0 - self.zeta * self.zeta).sqrt()) * TAU * self.f
    }
}

pub(in crate::identify) fn channels(prefix: &str, n: usize) -> Vec<Channel> {
    (0..n).map(|k| Channel { name: format!("{prefix}{}", k + 1), direction: None }).collect()
}

/// The exact functions of a set of modes.
pub(in crate::identify) fn synthesise(modes: &[TrueMode], quantity: FrfQuantity, lines: &[f64]) -> FrfSet {
    let (n_ref, n_res) = (modes[0].l.len(), modes[0].psi.len());
    let mut h = Vec::with_capacity(lines.len() * n_ref * n_res);
    let poles: Vec<_> = modes.iter().map(TrueMode::pole).collect();
    for f in lines {
        let s = Complex::new(0.0, TAU * f);
        let front = s.powi(quantity.order());
        for i in 0..n_ref {
            for o in 0..n_res {
                let mut sum = Complex::new(0.0, 0.0);
                for (m, p) in modes.iter().zip(&poles) {
                    let r = m.psi[o] * m.l[i];
                    sum += r / (s - p) + r.conj() / (s - p.conj());
                }
                h.push(front * sum);
            }
        }
    }
    FrfSet {
        quantity,
        frequencies_hz: lines.to_vec(),
        references: channels("p", n_ref),
        responses: channels("p", n_res),
        h,
        coherence: None,
        n_averages: None,
    }
}

/// Two independent standard normal numbers (Box and Muller).
pub(in crate::identify) fn normal_pair(rng: &mut ChaCha8Rng) -> Complex<f64> {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    Complex::from_polar((-2.0 * (1.0 - u).ln()).sqrt(), TAU * v)
}

/// Adds eps times the rms of each function as circular noise: H + eps rms (n1 + i n2)/√2.
pub(in crate::identify) fn add_noise(frfs: &mut FrfSet, eps: f64, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (n_ref, n_res) = (frfs.references.len(), frfs.responses.len());
    for i in 0..n_ref {
        for o in 0..n_res {
            let n = frfs.n_lines();
            let rms = ((0..n).map(|l| frfs.at(l, i, o).norm_sqr()).sum::<f64>() / n as f64).sqrt();
            for l in 0..n {
                let at = frfs.index(l, i, o);
                frfs.h[at] += normal_pair(&mut rng) * (eps * rms / 2.0_f64.sqrt());
            }
        }
    }
}

/// Evenly spaced lines.
pub(in crate::identify) fn lines(from: f64, to: f64, n: usize) -> Vec<f64> {
    (0..n).map(|k| from + (to - from) * k as f64 / (n - 1) as f64).collect()
}

/// Shapes sin(k π x) of a string at `n` points.
pub(in crate::identify) fn string_shape(k: usize, n: usize) -> Vec<f64> {
    (0..n).map(|j| (k as f64 * std::f64::consts::PI * (j as f64 + 0.7) / n as f64).sin()).collect()
}

pub(in crate::identify) fn mac(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
    super::super::stabilisation::mac(a, b)
}

pub(in crate::identify) fn mac_real(a: &[f64], b: &[f64]) -> f64 {
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    dot(a, b).powi(2) / (dot(a, a) * dot(b, b))
}
