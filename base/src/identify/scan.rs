//! A matched filter for resonances that the stabilisation diagram missed: weak and sharp ones, a few lines wide.
//!
//! What the known modes leave, e, is compared with one resonance b at every line and at half bandwidths of 1/2, 1 and 2 lines:
//!
//! ```text
//! b_l = 1/(iω_l - λ) - mean,   T(λ) = Σ_(o,i) |Σ_l b*_l e_l|² / (σ²_oi Σ_l |b_l|²)      over ±8 half bandwidths
//! ```
//! In white noise T is chi-squared with 2 degrees of freedom per function. Real remainders are neither white nor of known
//! level, so T of each bandwidth is divided by its own median over lines, in units of the chi-squared median, when that is
//! above one. A line is a candidate when T is a local maximum with a chance below 1e-3 anywhere in the scan.
//!
//! A candidate of the scan has no column of poles to speak for it. Beside passing the fit like any other, it must show three
//! things before it is called a mode:
//!
//! - its shape is nearly in phase (MPC at least [`LEAST_MPC`]: across the line less than 30 % of along it). Lightly damped modes
//!   are; 6, 10 and 18 channels of noise reach it with a chance of 5e-2, 5e-3 and 5e-5.
//! - it stands for at least [`LEAST_CONTRIBUTION`] of the power at its own resonance. Below that the flanks of other modes
//!   hold nine tenths, and a misfit of a few percent of theirs makes a resonance of its own.
//! - it is not a copy: no stronger mode within 5 % of its frequency has the same shape (MAC above 0.9, six channels at least).
//!   A structure that shifts between hits, or a hit that rebounds, leaves satellites with the shape of the true mode.
//!
//! Candidates that fail are listed with the reason.
//!
//! Sources: S. M. Kay, Fundamentals of Statistical Signal Processing II: Detection Theory, 1998, section 7.5;
//! B. Devlin, K. Roeder, Genomic control for association studies, Biometrics 55, 1999, for the scaling by the median.

use super::band::{Band, median};
use super::plscf::Pole;
use retune_linalg::Complex;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Probability of one false candidate in a scan of pure noise.
pub(super) const FALSE_ALARM: f64 = 1e-3;

/// Least modal phase collinearity of a mode found by the scan.
pub(super) const LEAST_MPC: f64 = 0.7;

/// Least share of the power at its resonance that a mode found by the scan stands for.
pub(super) const LEAST_CONTRIBUTION: f64 = 0.1;

/// Half bandwidths in lines.
const WIDTHS: [f64; 3] = [0.5, 1.0, 2.0];

/// Lines over which the level and the slow part of the remainder are taken.
const BACKGROUND: usize = 64;

/// The smallest value that a chi-squared number of `dof` exceeds in `trials` trials with probability [`FALSE_ALARM`].
pub(super) fn threshold(dof: f64, trials: f64) -> f64 {
    ChiSquared::new(dof).map_or(f64::INFINITY, |d| d.inverse_cdf(1.0 - FALSE_ALARM / trials.max(1.0)))
}

/// Candidates in what a fit leaves of some functions, strongest first.
pub(super) fn scan(remainder: &Band, functions: &Band) -> Vec<Pole> {
    let (n_l, n_i, n_o) = (remainder.n_lines(), remainder.n_inputs(), remainder.n_outputs());
    if n_l < 2 * BACKGROUND {
        return Vec::new();
    }
    // Every function freed of its slow part and scaled to unit noise.
    let mut e: Vec<Vec<Complex<f64>>> = Vec::with_capacity(n_i * n_o);
    for o in 0..n_o {
        for i in 0..n_i {
            let flat = without_slow_part(remainder.function(o, i));
            let half = BACKGROUND;
            let squares: Vec<f64> = flat.iter().map(Complex::norm_sqr).collect();
            // What is left below 1e-5 of the function (100 dB) is the arithmetic of synthetic data, not a measurement.
            let floor = 1e-10 * functions.function(o, i).iter().map(Complex::norm_sqr).sum::<f64>() / n_l as f64;
            let level: Vec<f64> = (0..n_l)
                .step_by(half / 2)
                .map(|l| {
                    let mut window = squares[l.saturating_sub(half)..(l + half).min(n_l)].to_vec();
                    // |e|² is exponential with mean 2σ².
                    (median(&mut window) / (2.0 * std::f64::consts::LN_2)).max(floor)
                })
                .collect();
            e.push(
                flat.iter()
                    .enumerate()
                    .map(|(l, x)| {
                        let variance = level[l / (half / 2)];
                        if variance > 0.0 { x / variance.sqrt() } else { Complex::new(0.0, 0.0) }
                    })
                    .collect(),
            );
        }
    }
    let dof = 2.0 * (n_o * n_i) as f64;
    let step = (remainder.omega[n_l - 1] - remainder.omega[0]) / (n_l - 1) as f64;
    let limit = threshold(dof, (n_l * WIDTHS.len()) as f64);
    let chi_median = ChiSquared::new(dof).map_or(dof, |d| d.inverse_cdf(0.5));
    let statistics: Vec<Vec<f64>> = WIDTHS
        .iter()
        .map(|width| {
            let reach = (8.0 * width).ceil().max(6.0) as usize;
            let t: Vec<f64> = (0..n_l).map(|k| statistic(remainder, &e, k, reach, width * step)).collect();
            let scale = (median(&mut t.clone()) / chi_median).max(1.0);
            t.into_iter().map(|x| x / scale).collect()
        })
        .collect();
    let best: Vec<(f64, usize)> = (0..n_l)
        .map(|l| {
            let w = (0..WIDTHS.len()).max_by(|&a, &b| statistics[a][l].total_cmp(&statistics[b][l])).unwrap_or(0);
            (statistics[w][l], w)
        })
        .collect();
    let mut found: Vec<(f64, Pole)> = (0..n_l)
        .filter(|&l| {
            let reach = (2.0 * WIDTHS[best[l].1]).ceil() as usize + 1;
            let around = l.saturating_sub(reach)..(l + reach + 1).min(n_l);
            best[l].0 > limit && best[around].iter().all(|b| b.0 <= best[l].0)
        })
        .map(|l| {
            let value = Complex::new(-WIDTHS[best[l].1] * step, remainder.omega[l]);
            (best[l].0, Pole { value, participation: participation(remainder, l) })
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|x| x.1).collect()
}

/// A function less its moving average over [`BACKGROUND`] lines.
fn without_slow_part(h: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let half = BACKGROUND / 2;
    let mut sums = vec![Complex::new(0.0, 0.0)];
    for x in h {
        sums.push(sums[sums.len() - 1] + x);
    }
    (0..h.len())
        .map(|l| {
            let (a, b) = (l.saturating_sub(half), (l + half + 1).min(h.len()));
            h[l] - (sums[b] - sums[a]) / (b - a) as f64
        })
        .collect()
}

fn statistic(band: &Band, e: &[Vec<Complex<f64>>], line: usize, reach: usize, decay: f64) -> f64 {
    let range = line.saturating_sub(reach)..(line + reach + 1).min(band.n_lines());
    let centre = band.omega[line];
    let mut b: Vec<Complex<f64>> =
        band.omega[range.clone()].iter().map(|w| Complex::new(decay, -(w - centre)).inv()).collect();
    let mean = b.iter().sum::<Complex<f64>>() / b.len() as f64;
    for x in &mut b {
        *x -= mean;
    }
    let power: f64 = b.iter().map(Complex::norm_sqr).sum();
    // Above, b is already the conjugate of 1/(iω - λ).
    let fit =
        |e: &Vec<Complex<f64>>| b.iter().zip(&e[range.clone()]).map(|(b, e)| b * e).sum::<Complex<f64>>().norm_sqr();
    e.iter().map(fit).sum::<f64>() / power
}

/// Participation from the remainder at one line: its strongest output, seen from all inputs.
pub(super) fn participation(band: &Band, line: usize) -> Vec<Complex<f64>> {
    let row = |o: usize| (0..band.n_inputs()).map(|i| band.function(o, i)[line]).collect::<Vec<_>>();
    let size = |o: &usize| row(*o).iter().map(Complex::norm_sqr).sum::<f64>() / band.roughness[*o].powi(2);
    let strongest = (0..band.n_outputs()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
    let l = row(strongest);
    let pivot = l.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    l.iter().map(|x| if pivot.norm() > 0.0 { x / pivot } else { Complex::new(1.0, 0.0) }).collect()
}
