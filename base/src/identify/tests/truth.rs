//! Known modes come back; intervals cover the truth.

use super::super::{IdentifyOptions, identify, sensors, test_modes};
use super::synthetic::{TrueMode, add_noise, lines, mac, normal_pair, string_shape, synthesise};
use crate::data::{FrfQuantity, FrfSet, Origin};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune_linalg::Complex;

fn five_modes(n: usize) -> Vec<TrueMode> {
    [(12.0, 0.01), (31.0, 0.02), (33.0, 0.015), (58.0, 0.008), (80.0, 0.03)]
        .iter()
        .enumerate()
        .map(|(k, &(f, z))| {
            let phi = string_shape(k + 1, n);
            TrueMode::real(f, z, &phi, &[phi[1]])
        })
        .collect()
}

#[test]
fn exact_functions_give_the_exact_modes() {
    for quantity in [FrfQuantity::Receptance, FrfQuantity::Mobility, FrfQuantity::Accelerance] {
        let modes = five_modes(12);
        let frfs = synthesise(&modes, quantity, &lines(0.0, 100.0, 1601));
        let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
        assert_eq!(found.modes.len(), 5);
        for (m, t) in found.modes.iter().zip(&modes) {
            assert!((m.frequency_hz.value / t.f - 1.0).abs() < 1e-6, "{}", m.frequency_hz.value);
            assert!((m.damping_ratio.value / t.zeta - 1.0).abs() < 1e-4);
            assert!(mac(m.shape.as_slice(), &t.psi) > 1.0 - 1e-8);
        }
    }
}
#[test]
fn noisy_functions_give_the_modes_within_their_deviations() {
    for eps in [0.01, 0.05, 0.1] {
        let modes = five_modes(12);
        let mut frfs = synthesise(&modes, FrfQuantity::Accelerance, &lines(0.0, 100.0, 1601));
        add_noise(&mut frfs, eps, 1);
        let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
        assert_eq!(found.modes.len(), 5);
        for (m, t) in found.modes.iter().zip(&modes) {
            // Five standard deviations: one in a million.
            assert!((m.frequency_hz.value - t.f).abs() < 5.0 * m.frequency_hz.sd);
            assert!((m.damping_ratio.value - t.zeta).abs() < 5.0 * m.damping_ratio.sd);
        }
    }
}

/// A hammer that roves over twelve points past one fixed sensor, past two: shapes are at the twelve, with the places and directions of the hits.
#[test]
fn a_roving_hammer_gives_shapes_by_reciprocity() {
    for fixed in [&[1][..], &[1, 7]] {
        let modes: Vec<TrueMode> = [(12.0, 0.01), (31.0, 0.02), (33.0, 0.015), (58.0, 0.008), (80.0, 0.03)]
            .iter()
            .enumerate()
            .map(|(k, &(f, z))| {
                let phi = string_shape(k + 1, 12);
                TrueMode::real(f, z, &fixed.iter().map(|&p| phi[p]).collect::<Vec<_>>(), &phi)
            })
            .collect();
        let mut frfs = synthesise(&modes, FrfQuantity::Accelerance, &lines(0.0, 100.0, 1601));
        add_noise(&mut frfs, 0.01, 3);
        for (i, c) in frfs.references.iter_mut().enumerate() {
            c.direction = Some([0.0, 0.0, if i == 4 { -1.0 } else { 1.0 }]);
        }
        for (c, p) in frfs.responses.iter_mut().zip(fixed) {
            (c.name, c.direction) = (format!("p{}", p + 1), Some([0.0, 0.0, 1.0]));
        }
        let turned = frfs.by_reciprocity();
        let found = identify(&turned, &IdentifyOptions::default()).unwrap();
        assert_eq!(found.modes.len(), 5);
        let test = test_modes(&found.modes, &Origin::Synthetic(String::new()));
        let sensors = sensors(&turned, None, None).unwrap();
        assert_eq!((sensors.len(), sensors[4].name.as_str(), sensors[4].direction[2]), (12, "p5", -1.0));
        for ((m, t), truth) in found.modes.iter().zip(&test).zip(&modes) {
            let shape = t.shape.as_ref().unwrap();
            assert!((m.frequency_hz.value - truth.f).abs() < 5.0 * m.frequency_hz.sd);
            assert!(mac(shape.as_slice(), &truth.l) > 0.9999, "{fixed:?}: {}", mac(shape.as_slice(), &truth.l));
            assert!(t.shape_sd.as_ref().unwrap().iter().all(|s| *s < 0.02));
            // The hit at the fixed sensor is a driving point still.
            assert!(m.mass_normalised.is_some());
        }
        // A set that is the right way round stays as it is.
        assert!(matches!(turned.by_reciprocity(), std::borrow::Cow::Borrowed(_)));
    }
}

/// How the noise of a simulated test is made.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Noise {
    /// The same on every line.
    White,
    /// Uneven, with the coherence that a test would state: a disturbance about 45 Hz, a floor elsewhere.
    Coherence,
    /// White noise averaged over five lines, as a window or an overlap leaves it.
    Smooth,
    /// Noise of each response (relative to its rms) and of the force (relative to the force), 16 averages, H1; with the coherence or without.
    Analyser { response: f64, force: f64, has_coherence: bool },
}

/// H1 and coherence of noisy records, line by line: X = H F + rms ε_x n, F_m = F + ε_f n.
fn analyse(frfs: &mut FrfSet, response: f64, force: f64, seed: u64) {
    let (n, averages) = (frfs.n_lines(), 16);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let half = 0.5_f64.sqrt();
    let mut coherence = vec![1.0; frfs.h.len()];
    for i in 0..frfs.references.len() {
        let rms: Vec<f64> = (0..frfs.responses.len())
            .map(|o| ((0..n).map(|l| frfs.at(l, i, o).norm_sqr()).sum::<f64>() / n as f64).sqrt())
            .collect();
        for l in 0..n {
            let mut cross = vec![Complex::new(0.0, 0.0); rms.len()];
            let (mut auto, mut power) = (vec![0.0; rms.len()], 0.0);
            for _ in 0..averages {
                let f = normal_pair(&mut rng) * half;
                let seen = f + normal_pair(&mut rng) * (half * force);
                power += seen.norm_sqr();
                for (o, rms) in rms.iter().enumerate() {
                    let x = frfs.at(l, i, o) * f + normal_pair(&mut rng) * (half * response * rms);
                    cross[o] += x * seen.conj();
                    auto[o] += x.norm_sqr();
                }
            }
            for o in 0..rms.len() {
                let at = frfs.index(l, i, o);
                frfs.h[at] = cross[o] / power;
                coherence[at] = cross[o].norm_sqr() / (auto[o] * power).max(f64::MIN_POSITIVE);
            }
        }
    }
    (frfs.coherence, frfs.n_averages) = (Some(coherence), Some(averages));
}

/// Adds noise of 3 % of the rms of each function.
fn disturb(frfs: &mut FrfSet, noise: Noise, seed: u64) {
    match noise {
        Noise::White => add_noise(frfs, 0.03, seed),
        Noise::Coherence => {
            let (n, averages) = (frfs.n_lines(), 16.0);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut coherence = vec![1.0; frfs.h.len()];
            for i in 0..frfs.references.len() {
                for o in 0..frfs.responses.len() {
                    let rms = ((0..n).map(|l| frfs.at(l, i, o).norm_sqr()).sum::<f64>() / n as f64).sqrt();
                    for l in 0..n {
                        let bump = 5.0 * (-((frfs.frequencies_hz[l] - 45.0) / 10.0).powi(2)).exp();
                        let sd = 0.03 * rms / 2.0_f64.sqrt() * (0.5 + bump);
                        let at = frfs.index(l, i, o);
                        // var per part = |H|² (1 - γ²) / (2 γ² n).
                        let ratio = 2.0 * averages * sd * sd / frfs.h[at].norm_sqr().max(1e-30);
                        coherence[at] = 1.0 / (1.0 + ratio);
                        frfs.h[at] += normal_pair(&mut rng) * sd;
                    }
                }
            }
            (frfs.coherence, frfs.n_averages) = (Some(coherence), Some(16));
        }
        Noise::Analyser { response, force, has_coherence } => {
            analyse(frfs, response, force, seed);
            if !has_coherence {
                (frfs.coherence, frfs.n_averages) = (None, None);
            }
        }
        Noise::Smooth => {
            let (n, half) = (frfs.n_lines(), 2_usize);
            let clean = frfs.clone();
            let mut white = frfs.clone();
            add_noise(&mut white, 0.03, seed);
            for i in 0..frfs.references.len() {
                for o in 0..frfs.responses.len() {
                    for l in 0..n {
                        let range = l.saturating_sub(half)..(l + half + 1).min(n);
                        let count = range.len() as f64;
                        let sum: Complex<f64> = range.map(|k| white.at(k, i, o) - clean.at(k, i, o)).sum();
                        // Divided by √5 the variance of each line stays what it was.
                        let at = frfs.index(l, i, o);
                        frfs.h[at] += sum / count.sqrt();
                    }
                }
            }
        }
    }
}

/// Shares of 90 % intervals that contain the truth, of frequency, damping and shape entries, over 60 seeds, and how many
/// frequencies were found: 5 modes, two of them close, 4 responses, 801 lines.
fn coverage(references: &[usize], noise: Noise) -> ([f64; 3], f64) {
    coverage_over(references, noise, 4, 60)
}

/// The same with any number of responses and seeds.
fn coverage_over(references: &[usize], noise: Noise, n: usize, seeds: u64) -> ([f64; 3], f64) {
    let modes: Vec<TrueMode> = [(12.0, 0.01), (31.0, 0.02), (33.0, 0.015), (58.0, 0.008), (80.0, 0.03)]
        .iter()
        .enumerate()
        .map(|(k, &(f, z))| {
            let phi = string_shape(k + 1, n);
            TrueMode::real(f, z, &phi, &references.iter().map(|&r| phi[r]).collect::<Vec<_>>())
        })
        .collect();
    let lines = lines(0.0, 100.0, 801);
    let z90 = 1.644_854;
    let (mut hits, mut count) = ([0.0_f64; 3], [0.0_f64; 3]);
    let options = IdentifyOptions { max_order: 24, ..IdentifyOptions::default() };
    for seed in 0..seeds {
        let mut frfs = synthesise(&modes, FrfQuantity::Accelerance, &lines);
        disturb(&mut frfs, noise, 1000 + seed);
        let found = identify(&frfs, &options).unwrap();
        for t in &modes {
            let Some(m) = found.modes.iter().find(|m| (m.frequency_hz.value / t.f - 1.0).abs() < 0.02) else {
                continue;
            };
            let cover =
                |x: crate::data::Measured, truth: f64| f64::from(u8::from((x.value - truth).abs() < z90 * x.sd));
            hits[0] += cover(m.frequency_hz, t.f);
            hits[1] += cover(m.damping_ratio, t.zeta);
            count[0] += 1.0;
            count[1] += 1.0;
            // The scale is free: fitted to the truth.
            let dot = |a: &[Complex<f64>], b: &[Complex<f64>]| {
                a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<Complex<f64>>()
            };
            let scale = dot(&t.psi, m.shape.as_slice()) / dot(&t.psi, &t.psi).re;
            for o in 0..n {
                let d = m.shape[o] - scale * t.psi[o];
                for part in [d.re, d.im] {
                    hits[2] += f64::from(u8::from(part.abs() < z90 * m.shape_sd[o]));
                    count[2] += 1.0;
                }
            }
        }
    }
    let share = std::array::from_fn(|k| hits[k] / count[k]);
    eprintln!(
        "{} references, {n} responses, {noise:?}: coverage of frequency, damping, shape {share:.3?}",
        references.len()
    );
    (share, count[0])
}

/// 90 % intervals cover the truth in 90 ± 5 % of the cases, with one reference and with two, with noise of one level and
/// with noise that the coherence tells. With 300 frequencies a share has a standard deviation of √(0.9 · 0.1 / 300) = 1.7 %: the
/// band is that of 2.9 deviations.
#[test]
fn intervals_cover_the_truth() {
    for references in [&[1][..], &[1, 3]] {
        for noise in [Noise::White, Noise::Coherence] {
            let (share, found) = coverage(references, noise);
            assert!(found > 290.0, "{found} of 300");
            assert!(share.iter().all(|s| (s - 0.9).abs() < 0.05), "{references:?} {noise:?}: {share:?}");
        }
    }
}

/// Noise of the force is common to all channels of a reference: intervals know it. 90 % intervals cover the truth in 90 ± 4 % over 240 runs each
/// (`RETUNE_SLOW=1`), frequency, damping and shape entries, with and without noise of the force, with and without the coherence; 30 runs of the
/// worst case otherwise, where a share of 150 frequencies has a standard deviation of 2.4 %.
#[test]
fn intervals_cover_the_truth_where_the_force_is_noisy() {
    let is_slow = crate::tests::is_asked();
    let cases = [(0.02, 0.005), (0.05, 0.02), (0.02, 0.0)];
    let mut wrong = Vec::new();
    for (response, force) in cases {
        for (n, has_coherence) in [(4, true), (4, false), (16, true), (16, false)] {
            if !is_slow && (n, force, has_coherence) != (16, 0.02, true) {
                continue;
            }
            let noise = Noise::Analyser { response, force, has_coherence };
            let (share, found) = coverage_over(&[1], noise, n, if is_slow { 240 } else { 30 });
            let reach = if is_slow { 0.04 } else { 0.08 };
            if share.iter().any(|s| (s - 0.9).abs() > reach) {
                wrong.push((n, noise, share, found));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Noise that is alike on neighbouring lines holds less information than its number of lines says. The lag-one correlation
/// of the residual widens the intervals; they must not fall short by more than for white noise.
#[test]
fn intervals_of_smooth_noise_do_not_promise_too_much() {
    let (share, found) = coverage(&[1], Noise::Smooth);
    assert!(found > 290.0, "{found} of 300");
    assert!(share.iter().all(|s| *s > 0.85), "{share:?}");
}

/// A mode a few percent beyond either end of the band bends no shape inside: chi-squared of shapes, frequencies and damping
/// over ten seeds stays where noise puts it, and the modes outside are named as such.
#[test]
fn modes_just_outside_the_band_bend_nothing_inside() {
    let modes = five_modes(6);
    let (mut sum, mut count) = (0.0, 0.0);
    for seed in 0..10 {
        let mut frfs = synthesise(&modes, FrfQuantity::Accelerance, &lines(13.5, 74.0, 1211));
        add_noise(&mut frfs, 0.003, 400 + seed);
        let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
        assert_eq!(found.modes.len(), 3);
        for (m, t) in found.modes.iter().zip(&modes[1..]) {
            let dot = |a: &[Complex<f64>], b: &[Complex<f64>]| {
                a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<Complex<f64>>()
            };
            let scale = dot(&t.psi, m.shape.as_slice()) / dot(&t.psi, &t.psi).re;
            let mut squares = |d: f64, sd: f64| (sum, count) = (sum + (d / sd).powi(2), count + 1.0);
            squares(m.frequency_hz.value - t.f, m.frequency_hz.sd);
            squares(m.damping_ratio.value - t.zeta, m.damping_ratio.sd);
            for o in 0..6 {
                let d = m.shape[o] - scale * t.psi[o];
                squares(d.re, m.shape_sd[o]);
                squares(d.im, m.shape_sd[o]);
            }
        }
        let outside: Vec<f64> = found
            .segments
            .iter()
            .flat_map(|s| &s.discarded)
            .filter(|d| d.reason.contains("the fit knows it"))
            .map(|d| d.frequency_hz)
            .collect();
        assert!(
            outside.iter().any(|f| (f / 12.0 - 1.0).abs() < 0.01)
                && outside.iter().any(|f| (f / 80.0 - 1.0).abs() < 0.01),
            "{outside:?}"
        );
    }
    // 420 squares of mean 1: their mean has a standard deviation of 0.07.
    eprintln!("mean square {:.2}", sum / count);
    assert!(sum / count < 1.4, "{}", sum / count);
}
