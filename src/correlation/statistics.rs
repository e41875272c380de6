//! Misfits with what noise alone would give, and the probability of passing a threshold.
//!
//! Residuals are (model - test)/σ, so that noise alone makes each of them a standard normal number and their squared sum
//! chi-squared. A misfit is always stated with the range that noise would give and with a probability in words.

use super::gamma_quantile::chi_squared_range;
use super::{CorrelationError, ShapeScalar, modal_scale_factor};
use crate::linalg::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use std::fmt;

/// A sum of squared standardised residuals and how it compares with noise.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Misfit {
    /// Σ r², 1.
    pub chi_squared: f64,
    /// Number of independent data behind it: residuals less fitted quantities.
    pub n_data: usize,
    /// Range that 95 of 100 noisy tests of a right model would give.
    pub expected: (f64, f64),
    /// Probability that noise alone gives this much or more; small: the model cannot explain the data.
    pub p_value: f64,
    /// Probability that noise alone gives this much or less; small: the stated σ are too large.
    pub p_lower: f64,
}

impl Misfit {
    /// The misfit of a squared sum.
    ///
    /// ```text
    /// p_value = P(χ²(n_data) ≥ chi_squared)
    /// ```
    ///
    /// * `chi_squared` - Σ ((model - test)/σ)², not negative
    /// * `n_data` - residuals less quantities fitted to them; with none the probabilities are 1
    ///
    /// Exact for independent normal noise of the stated σ. The upper tail keeps its relative accuracy down to 1e-300;
    /// below that it is 0.
    pub fn new(chi_squared: f64, n_data: usize) -> Result<Self, CorrelationError> {
        if !(chi_squared >= 0.0 && chi_squared.is_finite()) {
            let expected = "finite and not negative; look for data without a value or with zero standard deviation";
            return Err(CorrelationError::Range { what: "chi-squared", value: chi_squared, expected });
        }
        let Some(noise) = (n_data > 0).then(|| ChiSquared::new(n_data as f64).ok()).flatten() else {
            return Ok(Self { chi_squared, n_data, expected: (0.0, 0.0), p_value: 1.0, p_lower: 1.0 });
        };
        let expected = chi_squared_range(n_data);
        let p_value = noise.sf(chi_squared);
        Ok(Self { chi_squared, n_data, expected, p_value, p_lower: noise.cdf(chi_squared) })
    }

    /// The misfit of standardised residuals; entries that are not measured (NaN) do not count.
    pub fn of_residuals<'a>(residuals: impl IntoIterator<Item = &'a f64>) -> Result<Self, CorrelationError> {
        let measured = residuals.into_iter().filter(|r| !r.is_nan());
        let (sum, count) = measured.fold((0.0, 0), |(sum, count), r| (sum + r * r, count + 1));
        Self::new(sum, count)
    }

    /// Several independent misfits together, less `n_fitted` parameters that were fitted to all of them.
    pub fn combine<'a>(parts: impl IntoIterator<Item = &'a Misfit>, n_fitted: usize) -> Result<Self, CorrelationError> {
        let (sum, count) = parts.into_iter().fold((0.0, 0usize), |(s, n), m| (s + m.chi_squared, n + m.n_data));
        Self::new(sum, count.saturating_sub(n_fitted))
    }
}

impl fmt::Display for Misfit {
    /// "chi-squared 412 for 190 data: noise alone gives this in 1 of 10^17".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.n_data == 0 {
            return f.write_str("nothing was compared");
        }
        write!(f, "chi-squared {:.*} for {} data: ", digits(self.chi_squared), self.chi_squared, self.n_data)?;
        if self.p_lower < 0.01 {
            write!(
                f,
                "noise alone leaves so little in {}; the standard deviations may be too large",
                odds(self.p_lower)
            )
        } else {
            write!(f, "noise alone gives this in {}", odds(self.p_value))
        }
    }
}

/// Decimals that leave about three figures.
fn digits(value: f64) -> usize {
    if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    }
}

/// A probability in words: "37 of 100", "1 of 350", "1 of 10^9"; powers of ten are rounded towards the more probable.
pub fn odds(probability: f64) -> String {
    if probability >= 0.0095 {
        format!("{:.0} of 100", (100.0 * probability).min(100.0))
    } else if probability > 1e-4 {
        // Two digits: a share of draws is known no better.
        let digit = 10_f64.powf((-probability.log10()).floor() - 1.0);
        format!("1 of {:.0}", (1.0 / probability / digit).round() * digit)
    } else if probability > 0.0 {
        format!("1 of 10^{:.0}", (-probability.log10()).floor())
    } else {
        "less than 1 of 10^300".to_owned()
    }
}

/// The difference of two shapes with the free scale taken out.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeResidual<T: ShapeScalar> {
    /// Factor on the analytical shape that fits best, in the metric of the noise.
    pub scale: T,
    /// (scale φ_a - φ_x)/σ at every sensor; NaN where not measured.
    pub residuals: DVector<T>,
    /// Variance of each residual under noise, 1 - h: the scale takes a little from every sensor.
    pub variances: DVector<f64>,
    /// Real numbers in a residual: 2 for complex shapes, 1 when all imaginary parts are zero.
    pub parts: usize,
    /// Squared sum and what noise alone gives.
    pub misfit: Misfit,
}

/// Residuals of a measured shape with its own scale, real or complex, eliminated.
///
/// ```text
/// a = φ_a/σ,  b = φ_x/σ,   scale = aᴴb / aᴴa,   r = scale a - b   in the complement of a
/// Σ|r|² ~ χ²(parts (n - 1)),    Var r_i = 1 - |a_i|²/aᴴa   for each part
/// ```
///
/// * `phi_a` - analytical shape at the sensors, any scale
/// * `phi_x` - experimental shape; NaN where not measured
/// * `sd` - standard deviation of each entry of φ_x, of the real and of the imaginary part each, positive
///
/// Shapes whose imaginary parts are all exactly zero count as real: one number a sensor. A complex shape of the test
/// against a real model spends its imaginary part as misfit, which is right when damping is claimed to be light.
/// An analytical shape of zero leaves the test shape itself, with one degree of freedom more.
///
/// # Source
/// Linear least squares with one free coefficient; e.g. G. A. F. Seber, A. J. Lee, Linear Regression Analysis, 2003.
pub fn shape_residual<T: ShapeScalar>(
    phi_a: &[T],
    phi_x: &[T],
    sd: &[f64],
) -> Result<ShapeResidual<T>, CorrelationError> {
    let n = phi_a.len();
    for (what, length) in [("experimental shape", phi_x.len()), ("standard deviations", sd.len())] {
        if length != n {
            let expected = format!("{n} entries, one a sensor");
            return Err(CorrelationError::Shape { what, rows: length, columns: 1, expected });
        }
    }
    let is_used = |i: usize| phi_a[i].is_measured() && phi_x[i].is_measured();
    if let Some(i) = (0..n).find(|&i| is_used(i) && !(sd[i] > 0.0 && sd[i].is_finite())) {
        let what = "standard deviation of a shape entry";
        return Err(CorrelationError::Range { what, value: sd[i], expected: "positive and finite" });
    }
    let missing = T::from_real(f64::NAN);
    let whiten =
        |phi: &[T]| -> Vec<T> { (0..n).map(|i| if is_used(i) { phi[i].unscale(sd[i]) } else { missing }).collect() };
    let (a, b) = (whiten(phi_a), whiten(phi_x));
    let used: Vec<usize> = (0..n).filter(|&i| is_used(i)).collect();
    let norm: f64 = used.iter().map(|&i| a[i].modulus_squared()).sum();
    let scale = modal_scale_factor(&a, &b);
    let residuals = DVector::from_fn(n, |i, _| scale * a[i] - b[i]);
    let leverage = |i: usize| if norm > 0.0 { a[i].modulus_squared() / norm } else { 0.0 };
    let variances = DVector::from_fn(n, |i, _| if is_used(i) { 1.0 - leverage(i) } else { f64::NAN });
    let is_real = used.iter().all(|&i| a[i].imaginary() == 0.0 && b[i].imaginary() == 0.0);
    let parts = if is_real { 1 } else { 2 };
    let n_data = parts * (used.len() - usize::from(norm > 0.0).min(used.len()));
    let misfit = Misfit::new(used.iter().map(|&i| residuals[i].modulus_squared()).sum(), n_data)?;
    Ok(ShapeResidual { scale, residuals, variances, parts, misfit })
}

/// Misfit of every sensor over several modes.
///
/// ```text
/// Σ_modes |r_i|² / (1 - h_i)  ~  χ²(Σ parts)
/// ```
///
/// Exact for one sensor; the misfits of different sensors are slightly correlated through the scales. A sensor that alone
/// determines the scale of a mode (h = 1) has no residual there and does not count.
///
/// # Panics
/// If the residuals have different lengths.
pub fn sensor_misfits<T: ShapeScalar>(modes: &[ShapeResidual<T>]) -> Result<Vec<Misfit>, CorrelationError> {
    let n = modes.first().map_or(0, |m| m.residuals.len());
    (0..n)
        .map(|i| {
            let (mut sum, mut count) = (0.0, 0);
            for mode in modes {
                // Below 1e-9 the residual is rounding noise over rounding noise.
                if mode.residuals[i].is_measured() && mode.variances[i] > 1e-9 {
                    sum += mode.residuals[i].modulus_squared() / mode.variances[i];
                    count += mode.parts;
                }
            }
            Misfit::new(sum, count)
        })
        .collect()
}

/// Misfits of modes added up in frequency bands.
///
/// * `frequencies_hz` - one frequency a misfit
/// * `edges_hz` - ascending band edges; a frequency on an edge belongs to the band above; n edges make n - 1 bands
pub fn band_misfits(
    misfits: &[Misfit],
    frequencies_hz: &[f64],
    edges_hz: &[f64],
) -> Result<Vec<Misfit>, CorrelationError> {
    edges_hz
        .windows(2)
        .map(|edge| {
            let inside = misfits.iter().zip(frequencies_hz).filter(|(_, f)| **f >= edge[0] && **f < edge[1]);
            Misfit::combine(inside.map(|(m, _)| m), 0)
        })
        .collect()
}

/// Probability that a true frequency error lies within a tolerance, given normal uncertainties of both frequencies.
///
/// ```text
/// P(|f_a - f_x| ≤ t f_x) = P(f_a - (1 + t) f_x ≤ 0) - P(f_a - (1 - t) f_x < 0),   f_a, f_x independent and normal
/// ```
///
/// * `analytical`, `experimental` - (value, standard deviation), Hz
/// * `tolerance` - t, relative
///
/// Exact as long as f_x is surely positive. Without any uncertainty the answer is 0 or 1.
pub fn probability_of_frequency(analytical: (f64, f64), experimental: (f64, f64), tolerance: f64) -> f64 {
    let below = |factor: f64| {
        let mean = analytical.0 - factor * experimental.0;
        let sd = analytical.1.hypot(factor * experimental.1);
        match Normal::new(0.0, sd) {
            Ok(normal) => normal.cdf(-mean),
            Err(_) if mean <= 0.0 => 1.0,
            Err(_) => 0.0,
        }
    };
    (below(1.0 + tolerance) - below(1.0 - tolerance)).clamp(0.0, 1.0)
}

/// Confidence that the MAC of the noise-free shapes reaches a threshold.
///
/// ```text
/// P(MAC(φ_a, φ_t + noise) ≤ MAC observed)    φ_t: a test shape whose true MAC is exactly the threshold,
///                                            of the observed length, off φ_a in the observed direction
/// ```
///
/// * `phi_a`, `phi_x` - shapes at the same sensors; NaN where not measured
/// * `sd` - standard deviation of each entry of φ_x, real and imaginary part each; none where not positive
/// * `n_samples` - Monte Carlo samples; the result has a standard error of at most 1/(2 √n_samples)
/// * `seed` - same seed, same result
///
/// A test at the threshold (significance level), not a resampling of the noisy shape: adding noise a second time would
/// make every MAC look worse than it is. At a true MAC equal to the threshold the result is uniform on [0, 1]. Without
/// noise it is 0 or 1.
///
/// # Source
/// Confidence distribution by inversion of a test; e.g. A. C. Davison, D. V. Hinkley, Bootstrap Methods and their
/// Application, 1997, section 5.5.
pub fn probability_of_mac<T: ShapeScalar>(
    phi_a: &[T],
    phi_x: &[T],
    sd: &[f64],
    threshold: f64,
    n_samples: usize,
    seed: u64,
) -> f64 {
    confidence(phi_a, phi_x, sd, None, threshold, n_samples, seed)
}

/// Confidence that the modulus of the cross-orthogonality of the noise-free shapes reaches a threshold.
///
/// As [`probability_of_mac`], with lengths and angles measured by the mass: XOR² = |φ_aᴴ M φ_x|²/(φ_aᴴ M φ_a · φ_xᴴ M φ_x). The
/// mass is taken as it is.
///
/// * `mass` - mass at the sensors, symmetric and not negative, (n_sensor x n_sensor)
/// * `threshold` - of the modulus
///
/// Shapes must be complete at these sensors.
pub fn probability_of_cross_orthogonality<T: ShapeScalar>(
    phi_a: &[T],
    phi_x: &[T],
    sd: &[f64],
    mass: &DMatrix<f64>,
    threshold: f64,
    n_samples: usize,
    seed: u64,
) -> f64 {
    confidence(phi_a, phi_x, sd, Some(mass), threshold * threshold, n_samples, seed)
}

fn confidence<T: ShapeScalar>(
    phi_a: &[T],
    phi_x: &[T],
    sd: &[f64],
    mass: Option<&DMatrix<f64>>,
    threshold: f64,
    n_samples: usize,
    seed: u64,
) -> f64 {
    let used: Vec<usize> = (0..phi_a.len().min(phi_x.len()).min(sd.len()))
        .filter(|&i| phi_a[i].is_measured() && phi_x[i].is_measured())
        .collect();
    let a: Vec<T> = used.iter().map(|&i| phi_a[i]).collect();
    let x: Vec<T> = used.iter().map(|&i| phi_x[i]).collect();
    let is_real = a.iter().chain(&x).all(|v| v.imaginary() == 0.0);
    // vᴴ W w with W = M, or I.
    let weighted = |v: &[T]| -> Vec<T> {
        let row =
            |m: &DMatrix<f64>, i: usize| used.iter().zip(v).fold(T::zero(), |s, (&j, &v)| s + v.scale(m[(used[i], j)]));
        mass.map_or_else(|| v.to_vec(), |m| (0..v.len()).map(|i| row(m, i)).collect())
    };
    let dot = |v: &[T], w: &[T]| v.iter().zip(w).fold(T::zero(), |s, (&v, &w)| s + v.conjugate() * w);
    let norm = |v: &[T]| dot(v, &weighted(v)).real().max(0.0).sqrt();
    let (weighted_a, norm_a) = (weighted(&a), norm(&a));
    let mac = |x: &[T]| {
        let norm_x = norm(x);
        if norm_a > 0.0 && norm_x > 0.0 { (dot(&weighted_a, x).modulus() / norm_a / norm_x).powi(2) } else { 0.0 }
    };
    let observed = mac(&x);
    let scale = if norm_a > 0.0 { dot(&weighted_a, &x).unscale(norm_a * norm_a) } else { T::zero() };
    let parallel: Vec<T> = a.iter().map(|&a| scale * a).collect();
    let across: Vec<T> = x.iter().zip(&parallel).map(|(&x, &p)| x - p).collect();
    let (along, off, length) = (norm(&parallel), norm(&across), norm(&x));
    let is_silent = used.iter().all(|&i| sd[i].is_nan() || sd[i] <= 0.0);
    if n_samples == 0 || is_silent || along == 0.0 || off == 0.0 {
        return f64::from(u8::from(observed >= threshold));
    }
    let threshold = threshold.clamp(0.0, 1.0);
    let (on, out) = (threshold.sqrt() * length / along, (1.0 - threshold).sqrt() * length / off);
    let boundary: Vec<T> = parallel.iter().zip(&across).map(|(&p, &q)| p.scale(on) + q.scale(out)).collect();
    let mut gaussian = Gaussian::new(seed);
    let mut sample = boundary.clone();
    let mut count = 0usize;
    for _ in 0..n_samples {
        for (k, &i) in used.iter().enumerate() {
            let real = sd[i].max(0.0) * gaussian.next();
            let noise =
                if is_real { T::from_real(real) } else { complex_noise(real, sd[i].max(0.0) * gaussian.next()) };
            sample[k] = boundary[k] + noise;
        }
        count += usize::from(mac(&sample) <= observed);
    }
    count as f64 / n_samples as f64
}

/// real + i imaginary in a complex type, real alone in a real one.
fn complex_noise<T: ShapeScalar>(real: f64, imaginary: f64) -> T {
    let i = T::from_real(-1.0).try_sqrt().unwrap_or_else(T::zero);
    T::from_real(real) + i.scale(imaginary)
}

/// Standard normal numbers from a seeded stream, by Box and Muller (Annals of Mathematical Statistics 29, 1958, 610).
pub(super) struct Gaussian {
    rng: ChaCha8Rng,
    spare: Option<f64>,
}

/// 2⁻⁵³: the spacing of random numbers.
const UNIT: f64 = 1.0 / (1u64 << 53) as f64;

impl Gaussian {
    pub(super) fn new(seed: u64) -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(seed), spare: None }
    }

    /// A number in (0, 1], evenly spread.
    pub(super) fn uniform(&mut self) -> f64 {
        ((self.rng.next_u64() >> 11) + 1) as f64 * UNIT
    }

    pub(super) fn next(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        // 53 random bits, in (0, 1] for the logarithm and in [0, 1) for the angle.
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let angle = std::f64::consts::TAU * ((self.rng.next_u64() >> 11) as f64 * UNIT);
        self.spare = Some(radius * angle.sin());
        radius * angle.cos()
    }
}

#[cfg(test)]
mod tests;
