//! False and missed modes against the share that a weak mode must have, over random structures that are not quite one.

use super::super::{IdentifyOptions, identify};
use super::synthetic::{TrueMode, add_noise, channels, lines};
use crate::data::{FrfQuantity, FrfSet};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use retune_linalg::Complex;
use std::f64::consts::{PI, TAU};

const CHANNELS: usize = 16;

/// Five modes and a weak sharp one (last), with the share of the power at its resonance that it stands for.
struct Case {
    modes: Vec<TrueMode>,
    share: f64,
    frfs: FrfSet,
}

/// Functions of a random structure: five modes of 20 to 380 Hz, 0.3 to 2 % of damping; a weak one of a few lines at least 12 Hz
/// from each. Every channel was measured on a structure of its own, whose frequencies differ by `shift` (standard
/// deviation, relative), as sensors that are moved from hit to hit and the temperature do; noise of 0.3 to 3 %.
fn case(seed: u64, shift: f64) -> Case {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |a: f64, b: f64| a + (b - a) * rng.random::<f64>();
    let mut frequencies: Vec<f64> = Vec::new();
    while frequencies.len() < 6 {
        let f = uniform(20.0, 380.0);
        if frequencies.iter().all(|g| (f - g).abs() > 12.0) {
            frequencies.push(f);
        }
    }
    let at = uniform(0.0, CHANNELS as f64) as usize;
    let mut modes: Vec<TrueMode> = Vec::new();
    for (k, &f) in frequencies.iter().enumerate() {
        let (waves, phase) = (uniform(0.5, 4.5), uniform(0.0, PI));
        let phi: Vec<f64> = (0..CHANNELS).map(|j| (waves * PI * j as f64 / 15.0 + phase).sin()).collect();
        let zeta = if k < 5 { 10.0_f64.powf(uniform(-2.5, -1.7)) } else { uniform(0.5, 2.0) * 0.25 / f };
        // The force is never at a node: that mode would be no mode of this test.
        let drive = if phi[at].abs() < 0.2 { 0.2 } else { phi[at] };
        modes.push(TrueMode::real(f, zeta, &phi, &[drive]));
    }
    let share = 10.0_f64.powf(uniform(-2.0, -0.1));
    // The weak mode scaled to its share at its resonance.
    let pole = modes[5].pole();
    let s = Complex::new(0.0, pole.norm());
    let power = |m: &[TrueMode]| {
        (0..CHANNELS).map(|o| m.iter().map(|m| term(m, o, s, 1.0)).sum::<Complex<f64>>().norm_sqr()).sum::<f64>()
    };
    let (own, others) = (power(&modes[5..]), power(&modes[..5]));
    let scale = (share / (1.0 - share) * others / own).sqrt();
    modes[5].l[0] *= scale;
    let f = lines(0.0, 400.0, 1601);
    let factors: Vec<f64> =
        (0..CHANNELS).map(|_| (0..12).map(|_| uniform(-0.5, 0.5)).sum::<f64>() * shift + 1.0).collect();
    let noise = 10.0_f64.powf(uniform(-2.5, -1.5));
    let h = f
        .iter()
        .flat_map(|f| {
            let s = Complex::new(0.0, TAU * f);
            let (modes, factors) = (&modes, &factors);
            (0..CHANNELS).map(move |o| s * s * modes.iter().map(|m| term(m, o, s, factors[o])).sum::<Complex<f64>>())
        })
        .collect();
    let mut frfs = FrfSet {
        quantity: FrfQuantity::Accelerance,
        frequencies_hz: f,
        references: channels("r", 1),
        responses: channels("p", CHANNELS),
        h,
        coherence: None,
        n_averages: None,
    };
    add_noise(&mut frfs, noise, seed);
    Case { modes, share, frfs }
}

fn term(m: &TrueMode, o: usize, s: Complex<f64>, factor: f64) -> Complex<f64> {
    let (r, p) = (m.psi[o] * m.l[0], m.pole() * factor);
    r / (s - p) + r.conj() / (s - p.conj())
}

/// False modes, (missed, present) weak modes with a share of 0.01 to 0.1, 0.1 to 0.3 and above, strong modes missed.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    tests: usize,
    false_modes: usize,
    /// Those of them that only the scan found: the threshold rules them.
    false_by_scan: usize,
    weak: [(usize, usize); 3],
    strong_missed: usize,
}

fn tally(seeds: std::ops::Range<u64>, shift: f64, least_contribution: f64) -> Tally {
    let each: Vec<Tally> = seeds
        .into_par_iter()
        .map(|seed| {
            let case = case(seed, shift);
            let options = IdentifyOptions { least_contribution, ..IdentifyOptions::default() };
            let modes = identify(&case.frfs, &options).unwrap().modes;
            let mut found: Vec<(f64, usize)> = modes.iter().map(|m| (m.frequency_hz.value, m.n_orders)).collect();
            let mut out = Tally { tests: 1, ..Tally::default() };
            for (k, t) in case.modes.iter().enumerate() {
                // Within two lines, two half bandwidths, or two of the shifts.
                let reach = f64::max(0.5, 2.0 * t.zeta * t.f).max(2.0 * shift * t.f);
                let nearest =
                    (0..found.len()).min_by(|&a, &b| (found[a].0 - t.f).abs().total_cmp(&(found[b].0 - t.f).abs()));
                let hit = nearest.filter(|&i| (found[i].0 - t.f).abs() < reach);
                if let Some(i) = hit {
                    found.remove(i);
                }
                if k < 5 {
                    out.strong_missed += usize::from(hit.is_none());
                } else {
                    let class = [0.1, 0.3].iter().filter(|c| case.share > **c).count();
                    out.weak[class] = (usize::from(hit.is_none()), 1);
                }
            }
            out.false_modes = found.len();
            out.false_by_scan = found.iter().filter(|f| f.1 == 0).count();
            out
        })
        .collect();
    each.into_iter().fold(Tally::default(), |a, b| Tally {
        tests: a.tests + b.tests,
        false_modes: a.false_modes + b.false_modes,
        false_by_scan: a.false_by_scan + b.false_by_scan,
        weak: std::array::from_fn(|k| (a.weak[k].0 + b.weak[k].0, a.weak[k].1 + b.weak[k].1)),
        strong_missed: a.strong_missed + b.strong_missed,
    })
}

/// Few false modes and few missed ones at the threshold in use. With `RETUNE_SLOW=1` the table from which it was chosen:
/// `RETUNE_SLOW=1 cargo test --release --lib weak -- --nocapture`.
#[test]
fn the_threshold_of_weak_modes_is_calibrated() {
    if crate::tests::is_asked() {
        for shift in [0.0, 5e-4, 1e-3] {
            for threshold in [0.0, 0.03, 0.1, 0.2, 0.3] {
                eprintln!("shift {shift}, threshold {threshold}: {:?}", tally(0..60, shift, threshold));
            }
        }
    }
    for shift in [0.0, 5e-4] {
        let t = tally(1000..1020, shift, IdentifyOptions::default().least_contribution);
        eprintln!("shift {shift}: {t:?}");
        // The scan adds a false mode to one test in twenty at most; a structure that is one has none at all.
        assert!(t.false_by_scan <= 1 && (shift > 0.0 || t.false_modes == 0), "shift {shift}: {t:?}");
        // Of weak modes with three tenths of their resonance most are found.
        assert!(3 * t.weak[2].0 <= t.weak[2].1 && t.strong_missed <= 1, "shift {shift}: {t:?}");
    }
}
