//! Polynomials of elements, and the powers that they are made of.

use super::Monomial;
use super::powers::{by_powers, lagrange};

/// Every power is found as it went in.
#[test]
fn a_cubic_comes_back_by_powers() {
    for nodes in [[0.0_f64, 1.0, 2.0, 3.0], [0.0, 5e-4, 1e-3, 1.5e-3], [0.0, -2e6, -4e6, -6e6]] {
        let size = nodes[3].abs();
        let exact = [0.7, -1.3 / size, 0.0, 2.1 / size.powi(3)];
        let value = |t: f64| exact.iter().rev().fold(0.0, |sum, c| sum * t + c);
        let found = by_powers(&nodes);
        for (power, c) in exact.iter().enumerate() {
            let sum: f64 = nodes.iter().enumerate().map(|(k, &t)| value(t) * found[k][power]).sum();
            assert!((sum - c).abs() * size.powi(power as i32) < 1e-13, "{power}: {sum} {c}");
        }
        let sum: f64 = lagrange(&nodes, 0.9 * size).iter().zip(nodes).map(|(w, t)| w * value(t)).sum();
        assert!((sum - value(0.9 * size)).abs() < 1e-12);
    }
}

#[test]
fn a_monomial_and_its_derivative() {
    let m = Monomial { powers: vec![(0, 1), (2, 3)] };
    let theta = [2.0, 9.0, -1.5];
    assert_eq!(m.at(&theta), 2.0 * -3.375);
    assert_eq!(m.derivative(&theta, 0), -3.375);
    assert_eq!(m.derivative(&theta, 1), 0.0);
    assert_eq!(m.derivative(&theta, 2), 2.0 * 3.0 * 2.25);
    assert_eq!(Monomial::default().at(&theta), 1.0);
}
