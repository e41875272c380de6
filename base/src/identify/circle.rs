//! Cross-checks of one mode in one function: circle fit and half-power damping.
//!
//! Both work on mobility, where they are exact for one viscously damped mode.

use super::IdentifyError;
use super::layout::check_layout;
use crate::data::FrfSet;
use retune_linalg::{Complex, DMatrix, DVector, thin_qr};
use std::f64::consts::TAU;

/// Result of a circle fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleFit {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Its standard deviation from the scatter of the angles, Hz.
    pub frequency_sd: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Its standard deviation.
    pub damping_sd: f64,
    /// Modal constant A of receptance A/(ω_r² - ω² + 2iζω_rω), 1/kg; complex for a complex mode.
    pub modal_constant: Complex<f64>,
    /// Centre of the circle of mobility, m/(N s): what the other modes add is in it.
    pub centre: Complex<f64>,
    /// Radius, m/(N s).
    pub radius: f64,
    /// Root-mean-square distance of the points from the circle over the radius: above a few percent the mode is not alone.
    pub misfit: f64,
    /// Number of lines used.
    pub n_lines: usize,
}

/// Result of the half-power method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPower {
    /// Frequency of the peak of mobility, Hz.
    pub frequency_hz: f64,
    /// Damping ratio (f_b - f_a)/(2 f).
    pub damping_ratio: f64,
    /// Lower and upper frequency of half the power, Hz.
    pub half_power_hz: (f64, f64),
}

/// Mobility of one function at the lines inside a band.
fn mobility(
    frfs: &FrfSet,
    reference: usize,
    response: usize,
    band_hz: (f64, f64),
) -> Result<(Vec<f64>, Vec<Complex<f64>>), IdentifyError> {
    check_layout(frfs)?;
    for (what, index, found) in [
        ("the list of references", reference, frfs.references.len()),
        ("the list of responses", response, frfs.responses.len()),
    ] {
        if index >= found {
            return Err(IdentifyError::Length { what, expected: index + 1, found });
        }
    }
    let (mut omega, mut y) = (Vec::new(), Vec::new());
    for (l, &f) in frfs.frequencies_hz.iter().enumerate() {
        let h = frfs.at(l, reference, response);
        if f > 0.0 && f >= band_hz.0 && f <= band_hz.1 && h.is_finite() {
            omega.push(TAU * f);
            y.push(h * Complex::new(0.0, TAU * f).powi(1 - frfs.quantity.order()));
        }
    }
    Ok((omega, y))
}

/// Fits a circle to the mobility of one function around one resonance.
///
/// ```text
/// Y(ω) = iω A/(ω_r² - ω² + 2iζω_rω) + constant:  a circle of diameter |A|/(2ζω_r), passed at the angle
/// α(ω) = α_0 - 2 atan((ω² - ω_r²)/(2ζω_rω))
/// ```
/// The circle by algebraic least squares (Kåsa), then ω_r, ζ, α_0 by Gauss-Newton on the angles, each line weighted alike.
///
/// * `band_hz` - lines to use: about the half-power points, at least 5 lines
///
/// # Errors
/// Fewer than 5 lines, or points that do not turn about a centre.
///
/// # Source
/// D. J. Ewins, Modal Testing: Theory, Practice and Application, 2nd ed., 2000, section 4.3.
pub fn circle_fit(
    frfs: &FrfSet,
    reference: usize,
    response: usize,
    band_hz: (f64, f64),
) -> Result<CircleFit, IdentifyError> {
    let (omega, y) = mobility(frfs, reference, response, band_hz)?;
    let n = omega.len();
    if n < 5 {
        return Err(IdentifyError::TooFewLines { found: n, needed: 5 });
    }
    let singular = || IdentifyError::Singular { what: "equations of the circle" };
    // x² + y² = 2 a x + 2 b y + c, on points scaled to unit size about their mean.
    let mean = y.iter().sum::<Complex<f64>>() / n as f64;
    let size = y.iter().map(|p| (p - mean).norm()).fold(0.0, f64::max);
    if size <= 0.0 {
        return Err(singular());
    }
    let p: Vec<Complex<f64>> = y.iter().map(|z| (z - mean) / size).collect();
    let a = DMatrix::from_fn(n, 3, |k, j| [2.0 * p[k].re, 2.0 * p[k].im, 1.0][j]);
    let b = DVector::from_fn(n, |k, _| p[k].norm_sqr());
    let qr = thin_qr(&a)?;
    let c = qr.solve(&b).filter(|_| qr.diagonal_ratio() > 1e-9).ok_or_else(singular)?;
    let centre = Complex::new(c[0], c[1]);
    let radius = (c[2] + centre.norm_sqr()).max(0.0).sqrt();
    if radius.is_nan() || radius <= 0.0 {
        return Err(singular());
    }
    let misfit = (p.iter().map(|z| ((z - centre).norm() - radius).powi(2)).sum::<f64>() / n as f64).sqrt() / radius;
    // Angles, unwrapped.
    let mut alpha: Vec<f64> = p.iter().map(|z| (z - centre).arg()).collect();
    for k in 1..n {
        alpha[k] -= ((alpha[k] - alpha[k - 1]) / TAU).round() * TAU;
    }
    // Start: the fastest turn is the resonance, where dα/dω = -2/(ζω_r).
    let sweep = |k: usize| (alpha[k - 1] - alpha[k + 1]) / (omega[k + 1] - omega[k - 1]);
    let fastest = (1..n - 1).max_by(|&i, &j| sweep(i).total_cmp(&sweep(j))).ok_or_else(singular)?;
    if sweep(fastest).is_nan() || sweep(fastest) <= 0.0 {
        return Err(singular());
    }
    let mut x = [omega[fastest], (2.0 / (sweep(fastest) * omega[fastest])).min(0.5), alpha[fastest]];
    let angle = |x: &[f64; 3], w: f64| x[2] - 2.0 * ((w * w - x[0] * x[0]) / (2.0 * x[1] * x[0] * w)).atan();
    let cost = |x: &[f64; 3]| omega.iter().zip(&alpha).map(|(w, a)| (a - angle(x, *w)).powi(2)).sum::<f64>();
    let (mut value, mut damping) = (cost(&x), 1e-6);
    let mut normal = DMatrix::zeros(3, 3);
    for _ in 0..100 {
        let mut gradient = DVector::zeros(3);
        normal.fill(0.0);
        for (w, a) in omega.iter().zip(&alpha) {
            let u = (w * w - x[0] * x[0]) / (2.0 * x[1] * x[0] * w);
            let slope = -2.0 / (1.0 + u * u);
            // Relative unknowns: d/d ln ω_r, d/d ln ζ, d/dα_0.
            let j =
                DVector::from_vec(vec![slope * (-(w * w + x[0] * x[0]) / (2.0 * x[1] * x[0] * w)), -slope * u, 1.0]);
            gradient += &j * (a - angle(&x, *w));
            normal += &j * j.transpose();
        }
        let mut damped = normal.clone();
        for k in 0..3 {
            damped[(k, k)] *= 1.0 + damping;
        }
        let step = damped.cholesky().ok_or_else(singular)?.solve(&gradient);
        let trial = [x[0] * step[0].clamp(-0.2, 0.2).exp(), x[1] * step[1].clamp(-1.0, 1.0).exp(), x[2] + step[2]];
        let next = cost(&trial);
        if next <= value {
            (x, value, damping) = (trial, next, damping * 0.1);
            if step.amax() < 1e-12 {
                break;
            }
        } else {
            damping = f64::max(damping, 1e-6) * 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    let covariance = normal.cholesky().ok_or_else(singular)?.inverse() * (value / (n - 3) as f64);
    // At resonance the point stands at centre + radius e^iα_0, and the mode alone is the diameter in that direction.
    let constant = Complex::from_polar(2.0 * radius * size * 2.0 * x[1] * x[0], x[2]);
    Ok(CircleFit {
        frequency_hz: x[0] / TAU,
        frequency_sd: x[0] / TAU * covariance[(0, 0)].sqrt(),
        damping_ratio: x[1],
        damping_sd: x[1] * covariance[(1, 1)].sqrt(),
        modal_constant: constant,
        centre: centre * size + mean,
        radius: radius * size,
        misfit,
        n_lines: n,
    })
}

/// Damping from the two frequencies at which mobility has half the power of its peak.
///
/// ```text
/// ζ = (f_b - f_a)/(2 f_peak)      exact on mobility for one viscous mode, for any damping
/// ```
/// The peak and the crossings are interpolated in |Y|⁻², which is a parabola near a resonance. `None` when |Y|² does
/// not fall to half on both sides inside the band: the mode is not separated.
///
/// * `band_hz` - where to look for the peak
pub fn half_power_damping(
    frfs: &FrfSet,
    reference: usize,
    response: usize,
    band_hz: (f64, f64),
) -> Result<Option<HalfPower>, IdentifyError> {
    let (omega, y) = mobility(frfs, reference, response, band_hz)?;
    // 1/|Y|², so that the peak is a minimum and the crossings lie at twice it.
    let g: Vec<f64> = y.iter().map(|z| 1.0 / z.norm_sqr()).collect();
    let n = g.len();
    let Some(k) = (0..n).min_by(|&a, &b| g[a].total_cmp(&g[b])) else { return Ok(None) };
    if k == 0 || k + 1 >= n || !g[k].is_finite() {
        return Ok(None);
    }
    let (peak, lowest) = vertex([omega[k - 1], omega[k], omega[k + 1]], [g[k - 1], g[k], g[k + 1]]);
    let level = 2.0 * lowest;
    let below = (0..k).rev().find(|&l| g[l] >= level);
    let above = (k + 1..n).find(|&l| g[l] >= level);
    let (Some(a), Some(b)) = (below, above) else { return Ok(None) };
    let at =
        |i: usize, j: usize| omega[i] + (omega[j] - omega[i]) * crossing(level - lowest, g[i] - lowest, g[j] - lowest);
    let (wa, wb) = (at(a + 1, a), at(b - 1, b));
    Ok(Some(HalfPower {
        frequency_hz: peak / TAU,
        damping_ratio: (wb - wa) / (2.0 * peak),
        half_power_hz: (wa / TAU, wb / TAU),
    }))
}

/// Where a parabola √ rises from g0 to g1 through `level`: linear in the square root, the distance from the peak.
fn crossing(level: f64, g0: f64, g1: f64) -> f64 {
    let root = |x: f64| x.max(0.0).sqrt();
    let span = root(g1) - root(g0);
    if span > 0.0 { ((root(level) - root(g0)) / span).clamp(0.0, 1.0) } else { 0.5 }
}

/// Place and value of the extremum of the parabola through three points; the middle point if they are on a line.
pub(super) fn vertex(x: [f64; 3], y: [f64; 3]) -> (f64, f64) {
    let (h0, h1) = (x[0] - x[1], x[2] - x[1]);
    let (d0, d1) = ((y[0] - y[1]) / h0, (y[2] - y[1]) / h1);
    let curvature = (d1 - d0) / (h1 - h0);
    if curvature == 0.0 || !curvature.is_finite() {
        return (x[1], y[1]);
    }
    let slope = d0 - curvature * h0;
    let t = (-slope / (2.0 * curvature)).clamp(h0.min(h1), h0.max(h1));
    (x[1] + t, y[1] + slope * t + curvature * t * t)
}
