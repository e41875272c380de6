//! Several references, roving hammers, weights, cross-checks, indicators, spectra, hostile input.

use super::super::*;
use super::synthetic::{TrueMode, add_noise, channels, lines, mac, normal_pair, string_shape, synthesise};
use super::wing::data_folder;
use crate::data::{FrfQuantity, FrfSet};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune_linalg::Complex;

fn modes(references: &[usize], n: usize, f: &[(f64, f64)]) -> Vec<TrueMode> {
    f.iter()
        .enumerate()
        .map(|(k, &(f, z))| {
            let phi = string_shape(k + 1, n);
            TrueMode::real(f, z, &phi, &references.iter().map(|&r| phi[r]).collect::<Vec<_>>())
        })
        .collect()
}

/// Two modes at 20 Hz, a tenth of their bandwidth apart: only several references can tell.
#[test]
fn a_double_root_is_resolved_by_two_references() {
    let truth = modes(&[1, 6], 10, &[(20.0, 0.01), (20.02, 0.012), (41.0, 0.01)]);
    let mut frfs = synthesise(&truth, FrfQuantity::Accelerance, &lines(0.0, 64.0, 1025));
    add_noise(&mut frfs, 0.01, 5);
    let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
    assert_eq!(found.modes.len(), 3);
    for t in &truth {
        let best = found.modes.iter().map(|m| mac(m.shape.as_slice(), &t.psi)).fold(0.0, f64::max);
        assert!(best > 0.99, "{best}");
    }
    let indicator = cmif(&frfs).unwrap();
    let at = indicator.frequencies_hz.iter().position(|f| *f >= 20.0).unwrap();
    // The second value peaks at the double root and not at the single one.
    let second = |l: usize| indicator.values[(l, 1)];
    let other = indicator.frequencies_hz.iter().position(|f| *f >= 41.0).unwrap();
    assert!(second(at) > 20.0 * second(at - 100) && second(other) < 0.2 * indicator.values[(other, 0)]);
}

#[test]
fn three_references_give_mass_normalised_shapes_and_participation() {
    let truth = modes(&[1, 4, 6], 9, &[(12.0, 0.01), (25.0, 0.015), (26.0, 0.01), (50.0, 0.01)]);
    let mut frfs = synthesise(&truth, FrfQuantity::Mobility, &lines(0.0, 64.0, 1025));
    add_noise(&mut frfs, 0.01, 6);
    for (i, p) in [2, 5, 7].iter().enumerate() {
        frfs.references[i].name = format!("p{p}");
    }
    let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
    assert_eq!(found.modes.len(), 4);
    for (k, m) in found.modes.iter().enumerate() {
        let phi = string_shape(k + 1, 9);
        let scaled = m.mass_normalised.as_ref().unwrap();
        for o in 0..9 {
            assert!((scaled.shape[o].abs() - phi[o].abs()).abs() < 0.01, "mode {k} point {o}");
        }
        let at: Vec<Complex<f64>> = [1, 4, 6].iter().map(|&r| Complex::new(phi[r], 0.0)).collect();
        assert!(mac(m.participation.as_slice(), &at) > 0.999);
        assert!(m.participation_sd.iter().all(|s| s.is_finite()));
    }
}

/// One sensor, nine hammer points: the shape stands in the participation.
#[test]
fn a_roving_hammer_is_turned_around() {
    let truth = modes(&[0, 1, 2, 3, 4, 5, 6, 7, 8], 9, &[(12.0, 0.01), (25.0, 0.015), (50.0, 0.01)]);
    let mut frfs = synthesise(&truth, FrfQuantity::Accelerance, &lines(0.0, 64.0, 1025));
    let keep = 3;
    frfs.h = (0..frfs.n_lines()).flat_map(|l| (0..9).map(move |i| (l, i))).map(|(l, i)| frfs.at(l, i, keep)).collect();
    frfs.responses = vec![frfs.responses[keep].clone()];
    add_noise(&mut frfs, 0.01, 6);
    let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
    assert_eq!(found.modes.len(), 3);
    for (k, m) in found.modes.iter().enumerate() {
        let phi: Vec<Complex<f64>> = string_shape(k + 1, 9).iter().map(|x| Complex::new(*x, 0.0)).collect();
        assert!(mac(m.participation.as_slice(), &phi) > 0.999);
        assert_eq!(m.shape.len(), 1);
        assert!(m.mass_normalised.is_some());
    }
}

/// Noise of every line drawn from its coherence: weights by coherence bring the frequencies closer than equal weights.
#[test]
fn coherence_weights_pay() {
    let truth = modes(&[1], 6, &[(12.0, 0.02), (25.0, 0.015), (50.0, 0.02)]);
    let (mut weighted, mut equal) = (0.0, 0.0);
    for seed in 0..5 {
        let mut frfs = synthesise(&truth, FrfQuantity::Accelerance, &lines(0.0, 64.0, 513));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let n_avg = 10.0;
        let mut coherence = vec![1.0; frfs.h.len()];
        for l in 0..frfs.n_lines() {
            // A disturbance around 24 Hz and hum everywhere.
            let f = frfs.frequencies_hz[l];
            let sd = 0.002 + 0.5 * (-((f - 24.0) / 1.0).powi(2)).exp();
            for o in 0..6 {
                let at = frfs.index(l, 0, o);
                let power = frfs.h[at].norm_sqr();
                // var = |H|² (1-γ²)/(2γ² n) per part.
                let ratio = 2.0 * n_avg * sd * sd / power.max(1e-30);
                coherence[at] = 1.0 / (1.0 + ratio);
                frfs.h[at] += normal_pair(&mut rng) * sd;
            }
        }
        frfs.coherence = Some(coherence);
        frfs.n_averages = Some(10);
        for (weighting, sum) in [(Weighting::Coherence, &mut weighted), (Weighting::Equal, &mut equal)] {
            let found = identify(&frfs, &IdentifyOptions { weighting, ..IdentifyOptions::default() }).unwrap();
            let nearest = found.modes.iter().map(|m| (m.frequency_hz.value - 25.0).abs()).fold(f64::INFINITY, f64::min);
            *sum += nearest.min(1.0);
        }
    }
    eprintln!("mean error at 25 Hz: {:.2e} weighted, {:.2e} equal", weighted / 5.0, equal / 5.0);
    assert!(weighted < equal);
}

#[test]
fn an_unmeasured_function_leaves_a_nan_and_nothing_else() {
    let truth = modes(&[1], 6, &[(12.0, 0.02), (25.0, 0.015)]);
    let mut frfs = synthesise(&truth, FrfQuantity::Accelerance, &lines(0.0, 40.0, 513));
    for l in 0..frfs.n_lines() {
        let at = frfs.index(l, 0, 4);
        frfs.h[at] = Complex::new(f64::NAN, f64::NAN);
    }
    let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
    assert_eq!(found.modes.len(), 2);
    assert!(found.modes.iter().all(|m| m.shape[4].re.is_nan() && m.shape[3].re.is_finite()));
}

#[test]
fn the_fitted_model_reproduces_the_functions() {
    let truth = modes(&[1], 6, &[(12.0, 0.02), (25.0, 0.015)]);
    for quantity in [FrfQuantity::Receptance, FrfQuantity::Accelerance] {
        let frfs = synthesise(&truth, quantity, &lines(0.0, 50.0, 801));
        let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
        let model = found.synthesise(&frfs.frequencies_hz[1..], 1, 6);
        let rms = (frfs.h.iter().map(Complex::norm_sqr).sum::<f64>() / frfs.h.len() as f64).sqrt();
        let worst = frfs.h[6..].iter().zip(&model).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-4 * rms, "{worst} of {rms}");
    }
}

#[test]
fn circle_fit_and_half_power_are_exact_for_one_mode() {
    let truth = modes(&[1], 4, &[(20.0, 0.03)]);
    for quantity in [FrfQuantity::Receptance, FrfQuantity::Mobility, FrfQuantity::Accelerance] {
        let frfs = synthesise(&truth, quantity, &lines(0.0, 40.0, 1601));
        let circle = circle_fit(&frfs, 0, 0, (19.0, 21.0)).unwrap();
        assert!((circle.frequency_hz - 20.0).abs() < 1e-9 && (circle.damping_ratio - 0.03).abs() < 1e-10);
        let phi = string_shape(1, 4);
        assert!((circle.modal_constant - Complex::new(phi[0] * phi[1], 0.0)).norm() < 1e-8);
        assert!(circle.misfit < 1e-9);
        let half = half_power_damping(&frfs, 0, 0, (15.0, 25.0)).unwrap().unwrap();
        // Interpolation over lines a twentieth of the bandwidth apart.
        assert!((half.damping_ratio / 0.03 - 1.0).abs() < 2e-3, "{}", half.damping_ratio);
        assert!((half.frequency_hz - 20.0).abs() < 1e-3);
    }
    let frfs = synthesise(&truth, FrfQuantity::Mobility, &lines(0.0, 40.0, 1601));
    assert!(half_power_damping(&frfs, 0, 0, (19.9, 20.1)).unwrap().is_none());
    assert!(matches!(circle_fit(&frfs, 0, 0, (20.0, 20.05)), Err(IdentifyError::TooFewLines { .. })));
}

/// A steel cantilever, 759 x 50.66 x 5.14 mm, one averaged spectrum of an impulse test.
#[test]
fn the_peaks_of_a_cantilever_spectrum_are_its_bending_modes() {
    let Some(folder) = data_folder("cantilever_chowdhury") else { return };
    let text = std::fs::read_to_string(folder.join("FFT_data.lvm")).unwrap();
    let rows = text.lines().skip_while(|l| !l.starts_with("X_Value")).skip(1).filter_map(|l| {
        let mut words = l.split('\t');
        Some((words.next()?.trim().parse::<f64>().ok()?, words.next()?.trim().parse::<f64>().ok()?))
    });
    let (f, db): (Vec<f64>, Vec<f64>) = rows.unzip();
    let amplitude: Vec<f64> = db.iter().map(|x| 10.0_f64.powf(x / 20.0)).collect();
    let peaks = spectrum_peaks(&f, &amplitude, &PeakOptions::resonances((3.0, 1000.0))).unwrap();
    eprintln!("{:?}", peaks.iter().map(|p| (p.frequency_hz, p.height_db)).collect::<Vec<_>>());
    // Ratios to the first mode are those of a uniform cantilever: (β_k/β_1)². Clamp and accelerometer move single modes by
    // a few percent; the absolute frequencies by a tenth (6.6 Hz for 7.2 Hz of an ideal clamp).
    let beta: [f64; 7] = [1.875_104, 4.694_091, 7.854_757, 10.995_541, 14.137_168, 17.278_760, 20.420_352];
    let first = peaks.iter().find(|p| (6.0..7.5).contains(&p.frequency_hz)).map(|p| p.frequency_hz).unwrap();
    let hits = beta
        .iter()
        .filter(|b| {
            let expected = first * (**b / beta[0]).powi(2);
            peaks.iter().any(|p| (p.frequency_hz / expected - 1.0).abs() < 0.03)
        })
        .count();
    assert_eq!(hits, 7);
}

#[test]
fn noise_has_no_modes_and_no_peaks() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut alarms = 0;
    for _ in 0..10 {
        let n = 513;
        let frfs = FrfSet {
            quantity: FrfQuantity::Accelerance,
            frequencies_hz: lines(0.0, 64.0, n),
            references: channels("p", 1),
            responses: channels("p", 8),
            h: (0..n * 8).map(|_| normal_pair(&mut rng)).collect(),
            coherence: None,
            n_averages: None,
        };
        alarms += identify(&frfs, &IdentifyOptions::default()).unwrap().modes.len();
        let amplitude: Vec<f64> = (0..4096).map(|_| normal_pair(&mut rng).norm()).collect();
        alarms += spectrum_peaks(
            &lines(0.0, 100.0, 4096),
            &amplitude,
            &PeakOptions { min_height_db: 0.0, ..PeakOptions::resonances((1.0, 100.0)) },
        )
        .unwrap()
        .len();
    }
    assert_eq!(alarms, 0);
}

#[test]
fn hostile_sets_give_errors_and_no_panic() {
    let truth = modes(&[1], 3, &[(12.0, 0.02)]);
    let good = synthesise(&truth, FrfQuantity::Accelerance, &lines(0.0, 40.0, 201));
    let options = IdentifyOptions::default();
    let mut short = good.clone();
    short.h.pop();
    assert!(matches!(identify(&short, &options), Err(IdentifyError::Layout { .. })));
    let mut backwards = good.clone();
    backwards.frequencies_hz.reverse();
    assert!(matches!(identify(&backwards, &options), Err(IdentifyError::Lines { .. })));
    let mut empty = good.clone();
    (empty.h, empty.frequencies_hz) = (Vec::new(), Vec::new());
    assert!(matches!(identify(&empty, &options), Err(IdentifyError::TooFewLines { .. })));
    let mut nan = good.clone();
    nan.h.fill(Complex::new(f64::NAN, 0.0));
    assert!(matches!(identify(&nan, &options), Err(IdentifyError::NoCompleteFunction { .. })));
    for value in [0.0, 1.0, 1e300, 1e-300] {
        let mut flat = good.clone();
        flat.h.fill(Complex::new(value, 0.0));
        let _ = identify(&flat, &options).map(|x| x.modes.len());
        let _ = health::check_functions(&flat);
        let _ = cmif(&flat);
    }
    for max_order in [0, 3, 401, usize::MAX] {
        let e = identify(&good, &IdentifyOptions { max_order, ..IdentifyOptions::default() });
        assert!(matches!(e, Err(IdentifyError::Option { name: "max_order", .. })));
    }
    for band_hz in [(5.0, 4.0), (f64::NAN, 4.0), (1000.0, 2000.0), (5.0, 5.5)] {
        assert!(identify(&good, &IdentifyOptions { band_hz: Some(band_hz), ..IdentifyOptions::default() }).is_err());
    }
    assert!(quadrature_shapes(&good, 0, &[100.0], &[0.01], QuadratureForm::Raw).is_err());
    assert!(quadrature_shapes(&good, 7, &[10.0], &[0.01], QuadratureForm::Raw).is_err());
    assert!(circle_fit(&good, 0, 9, (1.0, 20.0)).is_err());
}
