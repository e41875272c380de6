//! The lines, channels and weights of a fit: what the methods see of an [`FrfSet`].

use super::gaps::{Gap, gaps};
use super::layout::{check_layout, unit_of};
use super::{IdentifyError, Weighting};
use crate::data::FrfSet;
use retune_linalg::Complex;
use std::f64::consts::TAU;

/// Lines over which the variance of a function is averaged, so that the weights do not follow the noise they weigh.
const VARIANCE_SMOOTHING: usize = 9;

/// Least noise of a function, relative to the root mean square of the strongest function of its output: 120 dB, which no channel exceeds.
///
/// A direction that an exciter does not move has functions of rounding alone, with noise and coherence of their own in synthetic data. Taken at
/// their word they would weigh 10³⁰ times as much as all others.
const LEAST_NOISE: f64 = 1e-6;

/// Selected lines of the complete functions of an FRF set.
///
/// The smaller side of the FRF matrix is the "input" side of the matrix fraction, so a test with a roving hammer is
/// turned around here (reciprocity); `is_transposed` remembers it.
#[derive(Debug, Clone)]
pub(super) struct Band {
    /// Angular frequencies of the lines, rad/s, ascending, without the line at 0.
    pub(super) omega: Vec<f64>,
    /// Time derivatives from displacement: the functions are (iω)^order times receptance.
    pub(super) order: i32,
    /// Indices of the inputs in the set (references, or responses when turned around).
    pub(super) inputs: Vec<usize>,
    /// Indices of the outputs in the set whose functions are measured for all inputs.
    pub(super) outputs: Vec<usize>,
    /// Whether inputs are the set's responses.
    pub(super) is_transposed: bool,
    /// Values, `h[(output * n_inputs + input) * n_lines + line]`.
    pub(super) h: Vec<Complex<f64>>,
    /// Noise variance per real component up to a factor per output, in the layout of `h`; absent: constant over lines.
    pub(super) variance: Option<Vec<f64>>,
    /// Noise variance over lines relative to its mean, common to all functions; absent: constant.
    pub(super) profile: Option<Vec<f64>>,
    /// Estimate of the noise sd (per real component) of each output from the roughness over lines.
    pub(super) roughness: Vec<f64>,
    /// Which functions are more than rounding, in the layout of `h` without lines; what the others leave tells nothing of the noise.
    is_alive: Vec<bool>,
    /// What `h` is divided by, see [`unit_of`]; what is given to the outside is multiplied by it.
    pub(super) scale: f64,
    /// Functions that lack lines.
    pub(super) gaps: Vec<Gap>,
}

impl Band {
    pub(super) fn n_lines(&self) -> usize {
        self.omega.len()
    }

    pub(super) fn n_inputs(&self) -> usize {
        self.inputs.len()
    }

    pub(super) fn n_outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Whether a function is more than rounding.
    pub(super) fn is_alive(&self, output: usize, input: usize) -> bool {
        self.is_alive[output * self.n_inputs() + input]
    }

    /// Functions of an output that are more than rounding, at least one.
    pub(super) fn n_alive(&self, output: usize) -> usize {
        (0..self.n_inputs()).filter(|&i| self.is_alive(output, i)).count()
    }

    /// Real values in the functions of an output that are more than rounding.
    pub(super) fn n_values(&self, output: usize) -> usize {
        2 * self.n_lines() * self.n_alive(output)
    }

    /// All lines of one function.
    pub(super) fn function(&self, output: usize, input: usize) -> &[Complex<f64>] {
        let at = (output * self.n_inputs() + input) * self.n_lines();
        &self.h[at..at + self.n_lines()]
    }

    /// The variances of one function, when they vary over lines.
    pub(super) fn variance_of(&self, output: usize, input: usize) -> Option<&[f64]> {
        let at = (output * self.n_inputs() + input) * self.n_lines();
        self.variance.as_ref().map(|v| &v[at..at + self.n_lines()])
    }

    /// Selects the lines in `band_hz` and the functions measured in full. Lines that a few functions lack are left out of all (see `gaps`).
    pub(super) fn select(
        frfs: &FrfSet,
        band_hz: Option<(f64, f64)>,
        weighting: Weighting,
    ) -> Result<Self, IdentifyError> {
        check_layout(frfs)?;
        let (low, high) = band_hz.unwrap_or((0.0, f64::INFINITY));
        if low.is_nan() || high.is_nan() || low >= high {
            return Err(IdentifyError::Band { low, high });
        }
        // The line at 0 Hz tells nothing: piezoelectric sensors do not measure it and mobility is zero there.
        let f = &frfs.frequencies_hz;
        let lines: Vec<usize> = (0..f.len()).filter(|&l| f[l] > 0.0 && f[l] >= low && f[l] <= high).collect();
        let (n_ref, n_res) = (frfs.references.len(), frfs.responses.len());
        if lines.is_empty() {
            return Err(IdentifyError::TooFewLines { found: 0, needed: 6 });
        }
        let (gaps, lines) = gaps(frfs, &lines)?;
        let is_measured = |i: usize, o: usize| lines.iter().all(|&l| frfs.at(l, i, o).is_finite());
        let is_any = |i: usize, o: usize| lines.iter().any(|&l| frfs.at(l, i, o) != Complex::ZERO);
        let measured: Vec<bool> = (0..n_ref * n_res).map(|k| is_measured(k / n_res, k % n_res)).collect();
        let is_ok = |i: usize, o: usize| measured[i * n_res + o];
        // References that no response has measured do not count; of the rest, every input must be there.
        let references: Vec<usize> = (0..n_ref).filter(|&i| (0..n_res).any(|o| is_ok(i, o) && is_any(i, o))).collect();
        let responses: Vec<usize> = (0..n_res).filter(|&o| (0..n_ref).any(|i| is_ok(i, o) && is_any(i, o))).collect();
        let is_transposed = references.len() > responses.len();
        let (inputs, candidates) = if is_transposed { (responses, references) } else { (references, responses) };
        let pair = |input: usize, output: usize| if is_transposed { (output, input) } else { (input, output) };
        let outputs: Vec<usize> = candidates
            .into_iter()
            .filter(|&o| {
                inputs.iter().all(|&i| {
                    let (r, s) = pair(i, o);
                    is_ok(r, s)
                })
            })
            .collect();
        if outputs.is_empty() {
            return Err(IdentifyError::NoCompleteFunction { references: n_ref, responses: n_res });
        }
        let n_lines = lines.len();
        let scale = unit_of(outputs.iter().flat_map(|&o| inputs.iter().map(move |&i| (i, o))).flat_map(|(i, o)| {
            let (r, s) = pair(i, o);
            lines.iter().map(move |&l| frfs.at(l, r, s))
        }));
        let mut h = Vec::with_capacity(n_lines * inputs.len() * outputs.len());
        let mut variance = Vec::new();
        let mut is_alive = Vec::with_capacity(inputs.len() * outputs.len());
        let coherence = frfs.coherence.as_ref().filter(|_| weighting == Weighting::Coherence);
        for &o in &outputs {
            let mean_square = |&i: &usize| {
                let (r, s) = pair(i, o);
                lines.iter().map(|&l| (frfs.at(l, r, s) / scale).norm_sqr()).sum::<f64>() / n_lines as f64
            };
            let floor = LEAST_NOISE.powi(2) * inputs.iter().map(mean_square).fold(0.0, f64::max);
            is_alive.extend(inputs.iter().map(|i| mean_square(i) > floor || floor == 0.0));
            for &i in &inputs {
                let (r, s) = pair(i, o);
                h.extend(lines.iter().map(|&l| frfs.at(l, r, s) / scale));
                if let Some(coherence) = coherence {
                    let raw: Vec<f64> = lines
                        .iter()
                        .map(|&l| {
                            let value = frfs.at(l, r, s) / scale;
                            variance_from_coherence(value, coherence[frfs.index(l, r, s)], frfs.n_averages)
                        })
                        .collect();
                    variance.extend(smooth_variance(&raw).into_iter().map(|v| v.max(floor)));
                }
            }
        }
        let mut band = Self {
            omega: lines.iter().map(|&l| TAU * f[l]).collect(),
            order: frfs.quantity.order(),
            inputs,
            outputs,
            is_transposed,
            h,
            variance: coherence.map(|_| variance),
            profile: None,
            roughness: Vec::new(),
            is_alive,
            scale,
            gaps,
        };
        band.roughness = (0..band.n_outputs()).map(|o| band.roughness_of(o)).collect();
        Ok(band)
    }

    /// The lines from `low` to `high`, rad/s, of all functions.
    pub(super) fn part(&self, low: f64, high: f64) -> Self {
        let from = self.omega.partition_point(|w| *w < low);
        let to = self.omega.partition_point(|w| *w <= high).max(from);
        let cut = |x: &[Complex<f64>]| x.chunks(self.n_lines()).flat_map(|f| f[from..to].to_vec()).collect();
        let mut part = Self {
            omega: self.omega[from..to].to_vec(),
            h: cut(&self.h),
            variance: self
                .variance
                .as_ref()
                .map(|v| v.chunks(self.n_lines()).flat_map(|f| f[from..to].to_vec()).collect()),
            roughness: Vec::new(),
            profile: None,
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            is_alive: self.is_alive.clone(),
            gaps: Vec::new(),
            ..*self
        };
        part.roughness = (0..part.n_outputs()).map(|o| part.roughness_of(o)).collect();
        part
    }

    /// What is left of all functions when a model, given output, input and iω, is taken away.
    pub(super) fn minus(&self, model: impl Fn(usize, usize, Complex<f64>) -> Complex<f64>) -> Self {
        let mut left = self.clone();
        for o in 0..self.n_outputs() {
            for i in 0..self.n_inputs() {
                let at = (o * self.n_inputs() + i) * self.n_lines();
                for (l, w) in self.omega.iter().enumerate() {
                    left.h[at + l] -= model(o, i, Complex::new(0.0, *w));
                }
            }
        }
        left.roughness = (0..left.n_outputs()).map(|o| left.roughness_of(o)).collect();
        left
    }

    /// The same functions with a noise profile taken from what a fit leaves over.
    ///
    /// ```text
    /// p_l = mean over functions of |e_l|²/σ², averaged over 129 lines and divided by its mean
    /// ```
    /// Real remainders grow with frequency and swell around strong modes; a fit with equal weights would serve these
    /// lines first and lose the weak modes beside them. White noise makes p differ from 1 by 1/√(129 n) only; unless its
    /// range is above ten times that, no profile is set.
    pub(super) fn with_profile(&self, remainder: &Self) -> Self {
        let (n_l, n_f) = (self.n_lines(), self.n_inputs() * self.n_outputs());
        let mut power = vec![0.0; n_l];
        for o in 0..self.n_outputs() {
            for i in 0..self.n_inputs() {
                let (e, v) = (remainder.function(o, i), self.variance_of(o, i));
                let weighted = |l: usize| e[l].norm_sqr() / v.map_or(1.0, |v| v[l]);
                let mean = (0..n_l).map(weighted).sum::<f64>() / n_l as f64;
                if mean > 0.0 {
                    for (l, p) in power.iter_mut().enumerate() {
                        *p += weighted(l) / (mean * n_f as f64);
                    }
                }
            }
        }
        let half = 64;
        let profile: Vec<f64> = (0..n_l)
            .map(|l| {
                let window = &power[l.saturating_sub(half)..(l + half + 1).min(n_l)];
                window.iter().sum::<f64>() / window.len() as f64
            })
            .collect();
        let (low, high) = profile.iter().fold((f64::MAX, 0.0), |(a, b): (f64, f64), p| (a.min(*p), b.max(*p)));
        let is_uneven = low > 0.0 && high - low > 10.0 / ((2 * half + 1) as f64 * n_f as f64).sqrt();
        Self { profile: is_uneven.then_some(profile), ..self.clone() }
    }

    /// Noise sd per real component from second differences over neighbouring lines.
    ///
    /// ```text
    /// d_l = H_(l-1) - 2 H_l + H_(l+1),   E|d|² = 6 · 2σ²,   |d|² exponential: median = ln2 · mean
    /// ```
    /// The median passes over the few lines at the peaks. It is an upper estimate: curvature adds to it.
    fn roughness_of(&self, output: usize) -> f64 {
        let mut worst: f64 = 0.0;
        for input in 0..self.n_inputs() {
            let h = self.function(output, input);
            let mut d: Vec<f64> = h.windows(3).map(|w| (w[0] - w[1] * 2.0 + w[2]).norm_sqr()).collect();
            let rms = (h.iter().map(Complex::norm_sqr).sum::<f64>() / h.len().max(1) as f64).sqrt();
            let sd = (median(&mut d) / (12.0 * std::f64::consts::LN_2)).sqrt();
            worst = worst.max(sd.max(1e-9 * rms));
        }
        worst
    }
}

/// Variance of the real (or imaginary) part of an estimated FRF.
///
/// ```text
/// var = |H|² (1 - γ²) / (2 γ² n_averages)
/// ```
/// Without a known number of averages one is taken: the level is then estimated from the residual anyway.
///
/// Source: J. S. Bendat, A. G. Piersol, Random Data, 4th ed., 2010, section 9.2.3.
fn variance_from_coherence(h: Complex<f64>, coherence: f64, n_averages: Option<usize>) -> f64 {
    // A coherence outside (0, 1) is a fault of the file or of rounding; NaN counts as no information about the line.
    let c = if coherence.is_finite() { coherence.clamp(1e-3, 1.0 - 1e-9) } else { 1e-3 };
    h.norm_sqr() * (1.0 - c) / (2.0 * c * n_averages.unwrap_or(1).max(1) as f64)
}

/// Moving average, with a floor at a thousandth of the median so that no single line can carry the fit.
fn smooth_variance(raw: &[f64]) -> Vec<f64> {
    let half = VARIANCE_SMOOTHING / 2;
    let mut sorted = raw.to_vec();
    let floor = (1e-3 * median(&mut sorted)).max(f64::MIN_POSITIVE);
    (0..raw.len())
        .map(|l| {
            let window = &raw[l.saturating_sub(half)..(l + half + 1).min(raw.len())];
            (window.iter().sum::<f64>() / window.len() as f64).max(floor)
        })
        .collect()
}

/// The median; sorts its argument. Zero for an empty slice.
pub(super) fn median(x: &mut [f64]) -> f64 {
    if x.is_empty() {
        return 0.0;
    }
    x.sort_unstable_by(f64::total_cmp);
    let n = x.len();
    if n % 2 == 1 { x[n / 2] } else { 0.5 * (x[n / 2 - 1] + x[n / 2]) }
}
