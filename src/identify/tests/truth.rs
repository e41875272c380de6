//! Known modes come back; intervals cover the truth.

use super::super::{IdentifyOptions, identify};
use super::synthetic::{TrueMode, add_noise, lines, mac, string_shape, synthesise};
use crate::data::FrfQuantity;

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
        for m in &found.modes { eprintln!("{:?} {} {} {} sd {:e} {:e} infl {} {:?}", quantity, m.frequency_hz.value, m.damping_ratio.value, m.n_orders, m.frequency_hz.sd, m.damping_ratio.sd, m.sd_inflation, m.mass_normalised.as_ref().map(|x| x.scale_sd)); }
        for s in &found.segments { eprintln!("{:?} {:?} {:?}", s.core_hz, s.residual_terms, s.discarded); }
        assert_eq!(found.modes.len(), 5);
        for (m, t) in found.modes.iter().zip(&modes) {
            assert!((m.frequency_hz.value / t.f - 1.0).abs() < 1e-6, "{}", m.frequency_hz.value);
            assert!((m.damping_ratio.value / t.zeta - 1.0).abs() < 1e-4);
            assert!(mac(m.shape.as_slice(), &t.psi) > 1.0 - 1e-8);
        }
    }
}
#[test]
fn noisy_functions() {
    for eps in [0.01, 0.05, 0.1] {
        let modes = five_modes(12);
        let mut frfs = synthesise(&modes, FrfQuantity::Accelerance, &lines(0.0, 100.0, 1601));
        add_noise(&mut frfs, eps, 1);
        let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
        for (m, t) in found.modes.iter().zip(&modes) { eprintln!("{} {} {} {} sd {:e} {:e} infl {} mac {}", eps, m.frequency_hz.value, m.damping_ratio.value, m.n_orders, m.frequency_hz.sd, m.damping_ratio.sd, m.sd_inflation, 1.0-mac(m.shape.as_slice(), &t.psi)); }
        for s in &found.segments { eprintln!("{:?} {:?} {:?}", s.core_hz, s.residual_terms, s.discarded); }
        assert_eq!(found.modes.len(), 5);
    }
}
