//! Quantiles of the gamma and the chi-squared distribution.

use statrs::function::gamma::{gamma_lr, gamma_ur, ln_gamma};

/// x with P(X ≤ x) = `level` for a gamma distributed X of unit scale; level in (0, 1), finite shape ≥ ½.
///
/// ```text
/// start:  x = a (1 - 1/(9 a) + z/(3 √a))³                            z: the normal quantile, Wilson and Hilferty
/// then:   Newton's method for ln P(X ≤ x) over ln x below the median, for ln P(X > x) over x above it
/// ```
///
/// Both logarithms are concave or convex, so the iteration ends from any start; two or three steps do.
///
/// # Source
/// E. B. Wilson, M. M. Hilferty, The distribution of chi-square, Proc. Natl. Acad. Sci. 17 (1931) 684-688.
fn gamma_quantile(shape: f64, level: f64, z: f64) -> f64 {
    const STEPS: usize = 100;
    let cube = 1.0 - 1.0 / (9.0 * shape) + z / (3.0 * shape.sqrt());
    // Far down, where the cube is of no use: P ≈ x^a/Γ(a + 1).
    let low = || ((level.ln() + ln_gamma(shape + 1.0)) / shape).exp();
    let mut x = if cube > 0.2 { shape * cube.powi(3) } else { low() };
    let constant = ln_gamma(shape);
    for _ in 0..STEPS {
        let density = ((shape - 1.0) * x.ln() - x - constant).exp();
        let next = if level < 0.5 {
            let below = gamma_lr(shape, x);
            x * ((level / below).ln() * below / (x * density)).exp()
        } else {
            let beyond = gamma_ur(shape, x);
            x + (beyond / (1.0 - level)).ln() * beyond / density
        };
        let next = if next.is_finite() { next.clamp(0.1 * x, 10.0 * x) } else { 0.5 * x };
        let change = (next - x).abs();
        x = next;
        // Newton's method doubles the digits.
        if change <= 1e-8 * x {
            break;
        }
    }
    x
}

/// The value that a gamma distributed number with this mean and variance exceeds with probability 0.05.
///
/// * `mean` - positive
/// * `variance` - positive, at most 2 mean²: half a degree of freedom of chi-squared or more
pub(super) fn gamma_95(mean: f64, variance: f64) -> f64 {
    variance / mean * gamma_quantile(mean * mean / variance, 0.95, 1.6448536269514722)
}

/// The range that holds 95 of 100 values of χ²(n), n ≥ 1: as many below it as above.
pub(super) fn chi_squared_range(n: usize) -> (f64, f64) {
    const Z: f64 = 1.959963984540054;
    let shape = 0.5 * n as f64;
    (2.0 * gamma_quantile(shape, 0.025, -Z), 2.0 * gamma_quantile(shape, 0.975, Z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    /// Chi-squared with two degrees is exponential: -2 ln(1 - p). With one it is a squared normal number.
    #[test]
    fn closed_forms() {
        let (low, high) = chi_squared_range(2);
        assert!(
            (low / (-2.0 * 0.975f64.ln()) - 1.0).abs() < 1e-13 && (high / (-2.0 * 0.025f64.ln()) - 1.0).abs() < 1e-13
        );
        let (low, high) = chi_squared_range(1);
        assert!((low / 0.03133798202142663f64.powi(2) - 1.0).abs() < 1e-12, "{low}");
        assert!((high / 2.241402727604947f64.powi(2) - 1.0).abs() < 1e-12, "{high}");
        assert!((gamma_95(3.0, 9.0) / (-3.0 * 0.05f64.ln()) - 1.0).abs() < 1e-13);
    }

    /// The quantile is where the distribution function has the level.
    #[test]
    fn the_distribution_function_comes_back() {
        for n in (1..60).chain([100, 1000, 30_000]) {
            let exact = ChiSquared::new(n as f64).unwrap();
            let (low, high) = chi_squared_range(n);
            assert!((exact.cdf(low) / 0.025 - 1.0).abs() < 1e-10, "{n}: {low}");
            assert!((exact.sf(high) / 0.025 - 1.0).abs() < 1e-10, "{n}: {high}");
            let q = gamma_95(7.0 * n as f64, 98.0 * n as f64) / 7.0;
            assert!((exact.sf(q) / 0.05 - 1.0).abs() < 1e-10, "{n}: {q}");
        }
    }
}
