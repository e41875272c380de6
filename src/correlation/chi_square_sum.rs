//! The distribution of a weighted sum of chi-squares: what a quadratic form of normal noise has.

use super::gamma_quantile::gamma_95;
use statrs::distribution::{ContinuousCDF, Gamma, Normal};

/// Σ λ_i χ²_1 with positive weights.
#[derive(Debug, Clone)]
pub(super) struct ChiSquareSum {
    /// Over the largest: squares of them are numbers, whatever the unit.
    weights: Vec<f64>,
    largest: f64,
}

impl ChiSquareSum {
    /// Weights that are not positive are left out, and so are those that cannot be seen beside the largest.
    pub(super) fn new(mut weights: Vec<f64>) -> Self {
        let largest = weights.iter().copied().filter(|w| w.is_finite()).fold(0.0, f64::max);
        weights.retain(|w| *w > 1e-12 * largest && w.is_finite());
        for w in &mut weights {
            *w /= largest;
        }
        Self { weights, largest }
    }

    pub(super) fn mean(&self) -> f64 {
        self.largest * self.relative_mean()
    }

    pub(super) fn standard_deviation(&self) -> f64 {
        self.largest * self.relative_sd()
    }

    fn relative_mean(&self) -> f64 {
        self.weights.iter().sum()
    }

    fn relative_sd(&self) -> f64 {
        (2.0 * self.weights.iter().map(|w| w * w).sum::<f64>()).sqrt()
    }

    /// P(X ≥ value).
    ///
    /// ```text
    /// κ(t) = -½ Σ ln(1 - 2 λ t),   κ'(t) = value at t = ŝ,   w = sign(ŝ) √(2 (ŝ value - κ)),  v = ŝ √κ''
    /// P = 1 - Φ(w + ln(v/w)/w)
    /// ```
    ///
    /// In the far tail it is too large by the error of Stirling's formula for Γ(m/2), m the number of weights equal to the
    /// largest: 17 % for one, 8 % for two, 3 % for five.
    ///
    /// # Source
    /// D. Kuonen, Biometrika 86 (1999) 929-935; the form of O. E. Barndorff-Nielsen, 1990.
    pub(super) fn tail(&self, value: f64) -> f64 {
        if self.weights.is_empty() {
            return if value > 0.0 { 0.0 } else { 1.0 };
        }
        if value <= 0.0 {
            return 1.0;
        }
        let value = value / self.largest;
        if value == f64::INFINITY {
            return 0.0;
        }
        let (mean, sd) = (self.relative_mean(), self.relative_sd());
        // The formula is 0/0 at the mean; the gamma distribution of equal moments is right there.
        if (value - mean).abs() < 0.02 * sd {
            return Gamma::new(mean * mean / (sd * sd), mean / (sd * sd)).map_or(0.5, |g| g.sf(value));
        }
        let t = self.relative_tilt(value);
        let kappa = -0.5 * self.weights.iter().map(|w| (-2.0 * w * t).ln_1p()).sum::<f64>();
        let curvature = 2.0 * self.weights.iter().map(|w| (w / (1.0 - 2.0 * w * t)).powi(2)).sum::<f64>();
        let w = t.signum() * (2.0 * (t * value - kappa)).max(0.0).sqrt();
        let v = t * curvature.sqrt();
        let z = w + (v / w).ln() / w;
        Normal::standard().sf(z).clamp(0.0, 1.0)
    }

    /// t with κ'(t) = value: the exponential tilt under which the mean is `value`, below 1/(2 λ_max).
    pub(super) fn tilt(&self, value: f64) -> f64 {
        if self.weights.is_empty() { 0.0 } else { self.relative_tilt(value / self.largest) / self.largest }
    }

    /// The tilt of the sum whose largest weight is one.
    fn relative_tilt(&self, value: f64) -> f64 {
        // κ'(t), which rises from 0 at -∞ to ∞ at 1/(2 λ_max), and κ''(t).
        let slopes = |t: f64| {
            let terms = self.weights.iter().map(|w| w / (1.0 - 2.0 * w * t));
            terms.fold((0.0, 0.0), |(slope, curvature), v| (slope + v, curvature + 2.0 * v * v))
        };
        let (mut low, mut high) = if value > self.relative_mean() {
            (0.0, 0.5)
        } else {
            let mut low = -1.0;
            while slopes(low).0 > value && low > f64::MIN {
                low *= 2.0;
            }
            (low, 0.0)
        };
        // Newton's method for 1/κ', which is nearly straight, kept inside the bracket.
        let mut t = 0.5 * (low + high);
        for _ in 0..100 {
            let (now, curvature) = slopes(t);
            if now < value {
                low = t;
            } else {
                high = t;
            }
            let next = t + now * (1.0 - now / value) / curvature;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - t).abs() <= 1e-15 * t.abs() || next <= low || next >= high {
                break;
            }
            t = next;
        }
        t
    }

    /// The value that is exceeded with probability 0.05, of the gamma distribution with these moments: a few per cent from
    /// the exact one.
    ///
    /// # Source
    /// F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110-114.
    pub(super) fn quantile_95(&self) -> f64 {
        let (mean, sd) = (self.relative_mean(), self.relative_sd());
        if sd > 0.0 { self.largest * gamma_95(mean, sd * sd) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::ChiSquared;

    /// Equal weights are a chi-squared distribution, whose tail is known; Stirling's error of Γ(n/2) is 1/(6 n).
    #[test]
    fn equal_weights_are_chi_squared() {
        for n in [1, 2, 5, 30] {
            let sum = ChiSquareSum::new(vec![3.0; n]);
            let exact = ChiSquared::new(n as f64).unwrap();
            for p in [0.9, 0.5, 0.1, 1e-3, 1e-8] {
                let x = 3.0 * exact.inverse_cdf(1.0 - p);
                let tolerance = 1.0 / (6.0 * n as f64) + 1e-3;
                assert!((sum.tail(x) / exact.sf(x / 3.0) - 1.0).abs() < tolerance, "{n} {p} {}", sum.tail(x));
            }
            assert!((sum.quantile_95() / (3.0 * exact.inverse_cdf(0.95)) - 1.0).abs() < 0.02, "{n}");
        }
    }

    /// The unit does not count: weights of any size have the tail of their shares, and no square of them is too large for a number.
    #[test]
    fn weights_may_have_any_size() {
        let shares = [1.0, 0.4, 0.4, 1e-3];
        let known = ChiSquareSum::new(shares.to_vec());
        for scale in [1e-250, 1e-90, 1e90, 1e160, 1e250] {
            let sum = ChiSquareSum::new(shares.iter().map(|w| w * scale).collect());
            for x in [0.01, 1.801, 5.0, 40.0] {
                assert!((sum.tail(x * scale) - known.tail(x)).abs() < 1e-9, "{scale} {x}");
            }
            assert!((sum.quantile_95() / scale / known.quantile_95() - 1.0).abs() < 1e-9, "{scale}");
            assert!((sum.tilt(5.0 * scale) * scale / known.tilt(5.0) - 1.0).abs() < 1e-9, "{scale}");
        }
        let sum = ChiSquareSum::new(vec![1.0, f64::INFINITY]);
        assert_eq!((sum.tail(f64::INFINITY), sum.tail(1e308)), (0.0, 0.0));
    }

    /// Two weights each taken twice: 2 λ times exponentials, P = Σ λ_i/(λ_i - λ_j) e^(-x/2λ_i) in closed form.
    #[test]
    fn pairs_of_weights_are_sums_of_exponentials() {
        let (a, b) = (1.0, 0.3);
        let sum = ChiSquareSum::new(vec![a, a, b, b, 0.0, -1e-18]);
        for x in [0.5, 2.0, 6.0, 20.0, 60.0] {
            let exact: f64 = (a * (-x / (2.0 * a)).exp() - b * (-x / (2.0 * b)).exp()) / (a - b);
            assert!((sum.tail(x) / exact - 1.0).abs() < 1.0 / 12.0, "{x}: {} {exact}", sum.tail(x));
        }
        assert_eq!((ChiSquareSum::new(vec![]).tail(1.0), ChiSquareSum::new(vec![]).tail(0.0)), (0.0, 1.0));
    }
}
