use super::*;
use crate::correlation::statistics::Gaussian;
use crate::data::Channel;

fn channel(name: &str, direction: Option<[f64; 3]>) -> Channel {
    Channel { name: name.to_owned(), direction }
}

/// A set of one reference from a function of (ω, response).
fn set(omegas: &[f64], n_responses: usize, h: impl Fn(f64, usize) -> Complex<f64>) -> FrfSet {
    FrfSet {
        quantity: FrfQuantity::Receptance,
        frequencies_hz: omegas.iter().map(|w| w / std::f64::consts::TAU).collect(),
        references: vec![channel("p0", Some([0.0, 0.0, 1.0]))],
        responses: (0..n_responses).map(|s| channel(&format!("p{s}"), Some([0.0, 0.0, -1.0]))).collect(),
        h: omegas.iter().flat_map(|w| (0..n_responses).map(|s| h(*w, s)).collect::<Vec<_>>()).collect(),
        coherence: None,
        n_averages: None,
    }
}

/// 1/(ω_n² - ω² + 2 i ζ ω ω_n).
fn resonance(w: f64, natural: f64, zeta: f64) -> Complex<f64> {
    Complex::new(natural * natural - w * w, 2.0 * zeta * w * natural).inv()
}

/// Two modes at two responses, with a model that differs in everything.
fn pair() -> (FrfSet, FrfSet) {
    let omegas: Vec<f64> = (0..20).map(|i| 1.0 + 9.0 * f64::from(i) / 19.0).collect();
    let sign = |s: usize| if s == 0 { 1.0 } else { -1.0 };
    let a = set(&omegas, 2, |w, s| resonance(w, 4.0, 0.02) + resonance(w, 7.0, 0.03) * 0.5 * sign(s));
    let x = set(&omegas, 2, |w, s| {
        let (first, second) = if s == 0 { (1.0, 0.4) } else { (1.1, -0.5) };
        resonance(w, 4.2, 0.02) * first + resonance(w, 7.1, 0.02) * second
    });
    (a, x)
}

/// sdynpy 0.23.0, `sdynpy_correlation.frac`, on the same numbers.
#[test]
fn peer_gives_the_same_frac() {
    let (a, x) = pair();
    let values = frac(&a, &x).unwrap();
    for (value, expected) in values.iter().zip([0.6184056198651562, 0.632664520682082]) {
        assert!((value.unwrap() - expected).abs() < 1e-13);
    }
}

/// By hand: H_x = (1, i), H_a = (2, 2i): same pattern, CSAC 1, CSF = 2·4/(2 + 8) = 0.8. With H_a = (2, -2i): both 0.
#[test]
fn signatures_by_hand() {
    let i = Complex::new(0.0, 1.0);
    let one = Complex::new(1.0, 0.0);
    let x = set(&[1.0, 2.0], 2, |_, s| if s == 0 { one } else { i });
    let a = set(&[1.0, 2.0], 2, |w, s| if s == 0 { one * 2.0 } else { i * if w < 1.5 { 2.0 } else { -2.0 } });
    let lines = signatures(&a, &x).unwrap();
    assert!((lines[0].shape.unwrap() - 1.0).abs() < 1e-15 && (lines[0].scale.unwrap() - 0.8).abs() < 1e-15);
    assert_eq!((lines[1].shape, lines[1].scale), (Some(0.0), Some(0.0)));
    let amplitude = local_amplitude(&a, &x).unwrap();
    assert!((amplitude[1].unwrap() - 0.8).abs() < 1e-15);
}

#[test]
fn quantities_convert_back_and_forth() {
    let (a, _) = pair();
    let accelerance = to_quantity(&a, FrfQuantity::Accelerance);
    // -ω² times the receptance.
    let w = std::f64::consts::TAU * a.frequencies_hz[7];
    assert!((accelerance.at(7, 0, 1) + a.at(7, 0, 1) * w * w).norm() < 1e-14 * accelerance.at(7, 0, 1).norm());
    let mobility = to_quantity(&accelerance, FrfQuantity::Mobility);
    assert!((mobility.at(7, 0, 1) - a.at(7, 0, 1) * Complex::new(0.0, w)).norm() < 1e-14);
    let back = to_quantity(&mobility, FrfQuantity::Receptance);
    assert!(back.h.iter().zip(&a.h).all(|(b, a)| (b - a).norm() < 1e-14 * a.norm()));
    assert_eq!(to_quantity(&a, FrfQuantity::Receptance), a);
    assert!(matches!(frac(&accelerance, &a), Err(CorrelationError::DifferentQuantity { .. })));
}

#[test]
fn a_stretched_frequency_axis_is_found() {
    let omegas: Vec<f64> = (0..400).map(|i| 2.0 + 0.02 * f64::from(i)).collect();
    let shape = |s: usize, r: usize| ((s + 1) as f64 * (r + 1) as f64 * 0.6).sin();
    let model = |w: f64, s: usize| (0..3).map(|r| resonance(w, [3.0, 5.0, 7.5][r], 0.01) * shape(s, r)).sum();
    let x = set(&omegas, 4, model);
    let a = set(&omegas, 4, |w, s| model(w / 1.05, s));
    let shift = frequency_shift(&a, &x, 0, 0.1).unwrap();
    assert!((shift.ratio - 1.05).abs() < 1.5e-3, "{}", shift.ratio);
    // Near a peak the pattern is that of one mode on either side, so an unshifted axis loses only one per cent.
    assert!(1.0 - shift.fdac < 1e-4 && 1.0 - shift.fdac_unshifted > 5e-3);
    let values = fdac(&x, &x, 0).unwrap();
    assert!((0..400).all(|k| (values[(k, k)] - 1.0).abs() < 1e-14));
    assert!(fdac(&a, &x, 1).is_err());
    assert!(frequency_shift(&a, &x, 0, 2.0).is_err());
}

#[test]
fn unmeasured_values_and_driving_points() {
    let (a, mut x) = pair();
    for line in 0..20 {
        let index = x.index(line, 0, 1);
        x.h[index] = Complex::new(f64::NAN, 0.0);
    }
    let values = frac(&a, &x).unwrap();
    assert!(values[0].is_some() && values[1].is_none());
    assert!(signatures(&a, &x).unwrap().iter().all(|s| (s.shape.unwrap() - 1.0).abs() < 1e-14)); // one channel left
    assert!(is_driving_point(&x, 0, 0) && !is_driving_point(&x, 0, 1));
    let mut short = a.clone();
    short.frequencies_hz[3] *= 1.01;
    assert!(matches!(frac(&short, &x), Err(CorrelationError::Shape { .. })));
    short.h.pop();
    assert!(frac(&short, &x).is_err());
    short.responses.pop();
    assert!(frac(&short, &x).is_err());
}

/// The model is the test times 2 at 90 degrees in the upper band.
#[test]
fn bands_say_where_amplitude_and_phase_differ() {
    let (_, x) = pair();
    let mut a = x.clone();
    for line in 10..20 {
        for s in 0..2 {
            let index = a.index(line, 0, s);
            a.h[index] *= Complex::new(0.0, 2.0);
        }
    }
    let middle = 0.5 * (x.frequencies_hz[9] + x.frequencies_hz[10]);
    let bands = band_residuals(&a, &x, &[[0.0, middle], [middle, 10.0]], 0.1).unwrap();
    let BandResiduals { bands, channels } = bands;
    assert_eq!((bands.len(), channels.len()), (2, 2));
    assert_eq!((bands[0].amplitude_db, bands[0].misfit.chi_squared), (0.0, 0.0));
    assert!((bands[1].amplitude_db - 20.0 * 2f64.log10()).abs() < 1e-12);
    assert!((bands[1].phase_deg - 90.0).abs() < 1e-12 && (bands[1].phase_rms_deg - 90.0).abs() < 1e-12);
    // |2i - 1|² = 5 at a variance of 0.01, ten lines, two functions.
    assert_eq!((bands[1].n_values, bands[1].misfit.n_data), (20, 40));
    assert!((bands[1].misfit.chi_squared - 10000.0).abs() < 1e-8);
    // Half of each function: its mean amplitude is half as far off in dB.
    assert!(channels.iter().all(|c| (c.misfit.chi_squared - 5000.0).abs() < 1e-8 && c.n_values == 20));
    assert!(channels.iter().all(|c| (c.amplitude_db - 10.0 * 2f64.log10()).abs() < 1e-12));
    assert!(band_residuals(&a, &x, &[[0.0, 1.0]], 0.0).is_err());
}

/// Noise of the variance that coherence and averages state gives a chi-squared in its expected range.
#[test]
fn coherence_states_the_noise() {
    let (a, _) = pair();
    let (coherence, n) = (0.8, 10);
    let variance = (1.0 - coherence) / (2.0 * f64::from(n) * coherence);
    let mut gaussian = Gaussian::new(5);
    let mut x = a.clone();
    for h in &mut x.h {
        *h *= Complex::new(1.0, 0.0) + Complex::new(gaussian.next(), gaussian.next()) * f64::sqrt(variance);
    }
    (x.coherence, x.n_averages) = (Some(vec![coherence; x.h.len()]), Some(n as usize));
    let all = band_residuals(&a, &x, &[[0.0, 10.0]], 1e-6).unwrap().bands[0].misfit;
    // |H_x|² varies with the noise itself by √(2 variance), 16 %: allow for it beside the 95 % range.
    assert!(all.chi_squared > 0.8 * all.expected.0 && all.chi_squared < 1.25 * all.expected.1, "{all:?}");
}
