//! Comparison of measured with computed frequency response functions.
//!
//! Both sets have the same references and responses in the same order, and (except for FDAC) the same lines; the
//! analytical set is converted to the quantity of the test by [`to_quantity`] first. A value that is not finite was not
//! measured and is left out. Criteria by line look at all channels at one frequency, criteria by channel at all lines.

use super::mac::unit_scale;
use super::{CorrelationError, Misfit};
use crate::data::{FrfQuantity, FrfSet};
use crate::linalg::{Complex, DMatrix};

/// The same functions as receptance, mobility or accelerance.
///
/// ```text
/// H_to = (iω)^(order_to - order_from) H_from,   order 0, 1, 2 for receptance, mobility, accelerance
/// ```
///
/// At zero frequency a division gives a value that is not finite, which counts as not measured. Coherence and averages
/// stay as they are.
pub fn to_quantity(set: &FrfSet, quantity: FrfQuantity) -> FrfSet {
    let order = quantity.order() - set.quantity.order();
    let channels = set.references.len() * set.responses.len();
    let factor = |line: usize| Complex::new(0.0, std::f64::consts::TAU * set.frequencies_hz[line]).powi(order);
    let h = set.h.iter().enumerate().map(|(k, h)| if order == 0 { *h } else { h * factor(k / channels) }).collect();
    FrfSet { quantity, h, ..set.clone() }
}

/// Whether a function is a driving point: response and reference at the same place, in the same or opposite direction.
///
/// Directions that are not known count as the same.
pub fn is_driving_point(set: &FrfSet, reference: usize, response: usize) -> bool {
    let (r, s) = (&set.references[reference], &set.responses[response]);
    let is_parallel = match (r.direction, s.direction) {
        // Unit vectors within about 0.1 degree.
        (Some(a), Some(b)) => a.iter().zip(&b).map(|(x, y)| x * y).sum::<f64>().abs() > 1.0 - 1e-6,
        _ => true,
    };
    r.name == s.name && is_parallel
}

fn same_channels(a: &FrfSet, x: &FrfSet) -> Result<(), CorrelationError> {
    for (what, n_a, n_x) in [
        ("references of the model's functions", a.references.len(), x.references.len()),
        ("responses of the model's functions", a.responses.len(), x.responses.len()),
    ] {
        if n_a != n_x {
            let expected = format!("{n_x}, as in the test");
            return Err(CorrelationError::Shape { what, rows: n_a, columns: 1, expected });
        }
    }
    if a.quantity != x.quantity {
        return Err(CorrelationError::DifferentQuantity { analytical: a.quantity, experimental: x.quantity });
    }
    for (what, set) in [("values of the model's functions", a), ("values of the test's functions", x)] {
        let count = set.n_lines() * set.references.len() * set.responses.len();
        if set.h.len() != count || set.coherence.as_ref().is_some_and(|c| c.len() != count) {
            let expected = format!("{count} values and, if any, as many coherences");
            return Err(CorrelationError::Shape { what, rows: set.h.len(), columns: 1, expected });
        }
    }
    Ok(())
}

fn same_lines(a: &FrfSet, x: &FrfSet) -> Result<(), CorrelationError> {
    same_channels(a, x)?;
    // A millionth of the frequency: rounding of a file's increments, far below any line spacing.
    let is_same = |f: f64, g: f64| (f - g).abs() <= 1e-6 * f.abs().max(g.abs());
    let differs =
        a.n_lines() != x.n_lines() || a.frequencies_hz.iter().zip(&x.frequencies_hz).any(|(f, g)| !is_same(*f, *g));
    if differs {
        let (what, expected) = ("frequency lines of the model's functions", "the lines of the test".to_owned());
        return Err(CorrelationError::Shape { what, rows: a.n_lines(), columns: 1, expected });
    }
    Ok(())
}

/// Hermitian sums of pairs of values that are both measured, each set scaled by a power of two of its own so that squares neither
/// overflow nor vanish.
#[derive(Debug, Clone, Copy)]
struct Sums {
    cross: Complex<f64>,
    norm_a: f64,
    norm_x: f64,
    scale_a: f64,
    scale_x: f64,
}

impl Sums {
    fn over(pairs: impl Iterator<Item = (Complex<f64>, Complex<f64>)> + Clone) -> Self {
        let measured = pairs.filter(|(a, x)| a.is_finite() && x.is_finite());
        let (scale_a, scale_x) = (unit_scale(measured.clone().map(|p| p.0)), unit_scale(measured.clone().map(|p| p.1)));
        let mut sums = Self { cross: Complex::new(0.0, 0.0), norm_a: 0.0, norm_x: 0.0, scale_a, scale_x };
        for (a, x) in measured.map(|(a, x)| (a * scale_a, x * scale_x)) {
            sums.cross += x.conj() * a;
            sums.norm_a += a.norm_sqr();
            sums.norm_x += x.norm_sqr();
        }
        sums
    }

    /// |x·a|²/(|x|²|a|²).
    fn shape(&self) -> Option<f64> {
        let is_usable = self.norm_a > 0.0 && self.norm_x > 0.0;
        is_usable.then(|| (self.cross.norm() / self.norm_a.sqrt() / self.norm_x.sqrt()).powi(2).min(1.0))
    }

    /// 2|x·a|/(|x|² + |a|²).
    fn scale(&self) -> Option<f64> {
        // Both in the scale of the larger set.
        let common = match (self.norm_a > 0.0, self.norm_x > 0.0) {
            (true, true) => self.scale_a.min(self.scale_x),
            (true, false) => self.scale_a,
            _ => self.scale_x,
        };
        let (of_a, of_x) = (common / self.scale_a, common / self.scale_x);
        let sum = self.norm_a * of_a * of_a + self.norm_x * of_x * of_x;
        (sum > 0.0).then(|| (2.0 * self.cross.norm() * of_a * of_x / sum).min(1.0))
    }
}

/// One number a function, at `[reference * n_responses + response]`; `None` where nothing was measured.
pub type ByChannel = Vec<Option<f64>>;

fn by_channel(a: &FrfSet, x: &FrfSet, criterion: impl Fn(&Sums) -> Option<f64>) -> Result<ByChannel, CorrelationError> {
    same_lines(a, x)?;
    let channels = x.references.len() * x.responses.len();
    let values = |set: &FrfSet, c: usize, line: usize| set.h[line * channels + c];
    Ok((0..channels)
        .map(|c| criterion(&Sums::over((0..x.n_lines()).map(|line| (values(a, c, line), values(x, c, line))))))
        .collect())
}

/// Frequency response assurance criterion of every function.
///
/// ```text
///               |Σ_ω H_x* H_a|²
/// FRAC = ─────────────────────────────        over all lines of one function, in [0, 1]
///        (Σ_ω |H_x|²) (Σ_ω |H_a|²)
/// ```
///
/// Likeness along frequency, blind to a constant factor (so to gain and sign of a sensor). A small frequency shift of a
/// lightly damped mode ruins it, and the highest peak dominates: near 0 does not mean a bad model. `None` where nothing
/// was measured or all is zero.
///
/// # Source
/// W. Heylen, S. Lammens, FRAC: a consistent way of comparing frequency response functions, Proc. Identification in
/// Engineering Systems, Swansea, 1996, 48-57.
pub fn frac(analytical: &FrfSet, experimental: &FrfSet) -> Result<ByChannel, CorrelationError> {
    by_channel(analytical, experimental, Sums::shape)
}

/// Local amplitude criterion of every function, averaged over the lines.
///
/// ```text
/// LAC(ω) = 2 |H_x* H_a| / (|H_x|² + |H_a|²),   mean over the lines, in [0, 1]
/// ```
///
/// Likeness of amplitudes line by line: 1 only when they are equal; a factor of 2 gives 0.8, of 10 gives 0.2; blind to
/// phase. Every line counts alike.
///
/// # Source
/// C. Zang, H. Grafe, M. Imregun, Frequency-domain criteria for correlating and updating dynamic finite element models,
/// Mechanical Systems and Signal Processing 15 (2001) 139-155 (one function of their global amplitude criterion).
pub fn local_amplitude(analytical: &FrfSet, experimental: &FrfSet) -> Result<ByChannel, CorrelationError> {
    same_lines(analytical, experimental)?;
    let channels = experimental.references.len() * experimental.responses.len();
    Ok((0..channels)
        .map(|c| {
            let at = |line: usize| (analytical.h[line * channels + c], experimental.h[line * channels + c]);
            let lines: Vec<f64> =
                (0..experimental.n_lines()).filter_map(|line| Sums::over(std::iter::once(at(line))).scale()).collect();
            (!lines.is_empty()).then(|| lines.iter().sum::<f64>() / lines.len() as f64)
        })
        .collect())
}

/// Correlation of all functions at one frequency line.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Signature {
    /// The line, Hz.
    pub frequency_hz: f64,
    /// CSAC, likeness of the pattern over the channels, in [0, 1]; `None` where nothing was measured.
    pub shape: Option<f64>,
    /// CSF, likeness of pattern and amplitude, in [0, 1].
    pub scale: Option<f64>,
}

/// Cross signature assurance criterion and cross signature scale factor of every line.
///
/// ```text
///             |Σ_c H_x* H_a|²                            2 |Σ_c H_x* H_a|
/// CSAC(ω) = ───────────────────────────      CSF(ω) = ───────────────────────────     c = channels
///           (Σ_c |H_x|²) (Σ_c |H_a|²)                 Σ_c |H_x|² + Σ_c |H_a|²
/// ```
///
/// CSAC is a MAC of operating shapes: it asks whether the structure moves in the same pattern at that frequency; with one
/// channel it is 1. CSF also asks for the amplitude, is never larger than √CSAC, and so sees damping and mass errors.
/// Both are low between a measured and a shifted computed resonance, whatever the cause. Also called global shape and
/// global amplitude criterion (GSC, GAC, without square: 2|..| as here).
///
/// # Source
/// Zang, Grafe, Imregun 2001 (see [`local_amplitude`]); E. Dascotte, J. Strobbe, Updating finite element models using FRF
/// correlation functions, Proc. 17th IMAC, 1999, 1169-1174.
pub fn signatures(analytical: &FrfSet, experimental: &FrfSet) -> Result<Vec<Signature>, CorrelationError> {
    same_lines(analytical, experimental)?;
    let channels = experimental.references.len() * experimental.responses.len();
    Ok((0..experimental.n_lines())
        .map(|line| {
            let range = line * channels..(line + 1) * channels;
            let pairs = analytical.h[range.clone()].iter().copied().zip(experimental.h[range].iter().copied());
            let sums = Sums::over(pairs);
            let frequency_hz = experimental.frequencies_hz[line];
            Signature { frequency_hz, shape: sums.shape(), scale: sums.scale() }
        })
        .collect())
}

/// Frequency domain assurance criterion: operating shapes at every pair of frequencies, for one reference.
///
/// ```text
///                   |Σ_s H_x(ω_x)* H_a(ω_a)|²
/// FDAC(ω_a, ω_x) = ─────────────────────────────────────       s = responses; (lines of model x lines of test)
///                  (Σ_s |H_x(ω_x)|²) (Σ_s |H_a(ω_a)|²)
/// ```
///
/// The lines of the two sets may differ. A ridge off the diagonal is a frequency shift: see [`frequency_shift`]. Needs
/// several responses; with one it is 1 everywhere.
///
/// # Source
/// R. Pascual, J. C. Golinval, M. Razeto, A frequency domain correlation technique for model correlation and updating,
/// Proc. 15th IMAC, 1997, 587-592.
pub fn fdac(analytical: &FrfSet, experimental: &FrfSet, reference: usize) -> Result<DMatrix<f64>, CorrelationError> {
    same_channels(analytical, experimental)?;
    check_reference(experimental, reference)?;
    let row = |set: &FrfSet, line: usize| {
        let start = set.index(line, reference, 0);
        set.h[start..start + set.responses.len()].to_vec()
    };
    let rows_a: Vec<_> = (0..analytical.n_lines()).map(|line| row(analytical, line)).collect();
    let rows_x: Vec<_> = (0..experimental.n_lines()).map(|line| row(experimental, line)).collect();
    Ok(DMatrix::from_fn(rows_a.len(), rows_x.len(), |i, j| {
        Sums::over(rows_a[i].iter().copied().zip(rows_x[j].iter().copied())).shape().unwrap_or(0.0)
    }))
}

fn check_reference(set: &FrfSet, reference: usize) -> Result<(), CorrelationError> {
    if reference < set.references.len() {
        return Ok(());
    }
    let (what, value) = ("reference", reference as f64);
    Err(CorrelationError::Range { what, value, expected: "below the number of references, counted from 0" })
}

/// How the model's frequency axis has to be stretched to resemble the test.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FrequencyShift {
    /// f_a/f_x of the best common stretch: above 1, the model is too high.
    pub ratio: f64,
    /// Mean FDAC along f_a = ratio f_x, lines weighted by the square of the test's response.
    pub fdac: f64,
    /// The same along f_a = f_x.
    pub fdac_unshifted: f64,
    /// For every line of the test the model's frequency of largest FDAC inside the window, Hz, and that FDAC.
    pub ridge: Vec<(f64, f64)>,
}

/// The stretch of frequency that explains most of the difference between operating shapes.
///
/// * `reference` - which reference
/// * `window` - largest relative shift looked for, for example 0.2
///
/// The stretch is found to 1/200 of the window; one number for all modes, while stiffness errors shift each mode by
/// its own amount (the ridge shows that). A flat ridge value says that the pattern hardly changes with frequency there.
pub fn frequency_shift(
    analytical: &FrfSet,
    experimental: &FrfSet,
    reference: usize,
    window: f64,
) -> Result<FrequencyShift, CorrelationError> {
    if !(window > 0.0 && window < 1.0) {
        return Err(CorrelationError::Range {
            what: "window of the shift",
            value: window,
            expected: "between 0 and 1",
        });
    }
    let values = fdac(analytical, experimental, reference)?;
    let (f_a, f_x) = (&analytical.frequencies_hz, &experimental.frequencies_hz);
    let weights: Vec<f64> = (0..f_x.len())
        .map(|line| {
            let responses = 0..experimental.responses.len();
            let energy = responses.map(|s| experimental.at(line, reference, s).norm_sqr());
            energy.filter(|v| v.is_finite()).sum()
        })
        .collect();
    // FDAC between the model's lines by linear interpolation; `None` beyond its range.
    let at = |f: f64, line: usize| -> Option<f64> {
        let above = f_a.partition_point(|g| *g < f);
        match (above.checked_sub(1), f_a.get(above)) {
            (_, Some(g)) if *g == f => Some(values[(above, line)]),
            (Some(below), Some(g)) => {
                let t = (f - f_a[below]) / (g - f_a[below]);
                Some(values[(below, line)] * (1.0 - t) + values[(above, line)] * t)
            }
            _ => None,
        }
    };
    let mean_along = |ratio: f64| {
        let terms = (0..f_x.len()).filter_map(|line| at(ratio * f_x[line], line).map(|v| (v, weights[line])));
        let (sum, total) = terms.fold((0.0, 0.0), |(sum, total), (v, w)| (sum + v * w, total + w));
        // A stretch that leaves most of the test outside the model's band does not count.
        if total > 0.5 * weights.iter().sum::<f64>() { sum / total } else { 0.0 }
    };
    let (mut best, unshifted) = ((1.0, mean_along(1.0)), mean_along(1.0));
    for k in 1..=200 {
        for sign in [-1.0, 1.0] {
            let ratio = 1.0 + sign * window * f64::from(k) / 200.0;
            let value = mean_along(ratio);
            if value > best.1 {
                best = (ratio, value);
            }
        }
    }
    let ridge = (0..f_x.len())
        .map(|line| {
            let inside = (0..f_a.len()).filter(|&i| (f_a[i] - f_x[line]).abs() <= window * f_x[line]);
            inside.fold(
                (f_x[line], 0.0),
                |top, i| if values[(i, line)] > top.1 { (f_a[i], values[(i, line)]) } else { top },
            )
        })
        .collect();
    Ok(FrequencyShift { ratio: best.0, fdac: best.1, fdac_unshifted: unshifted, ridge })
}

/// Differences of functions inside bands.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct BandResidual {
    /// Number of values compared.
    pub n_values: usize,
    /// Mean of 20 lg(|H_a|/|H_x|), dB: plus means that the model answers more.
    pub amplitude_db: f64,
    /// Root mean square of the same, dB.
    pub amplitude_rms_db: f64,
    /// Mean of the phase difference arg(H_a/H_x), wrapped to ±180, degrees.
    pub phase_deg: f64,
    /// Root mean square of the same, degrees.
    pub phase_rms_deg: f64,
    /// Σ|H_a - H_x|²/σ² and what noise alone gives.
    pub misfit: Misfit,
}

/// [`BandResidual`]s of functions.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BandResiduals {
    /// All functions together, band by band.
    pub bands: Vec<BandResidual>,
    /// All bands together, reference by reference, response by response.
    pub channels: Vec<BandResidual>,
}

/// Amplitude, phase and misfit by band and by function.
///
/// ```text
/// σ² = |H_x|² ((1 - γ²)/(2 n_d γ²) + floor²)     for real and imaginary part each
/// ```
///
/// * `bands_hz` - from (included) and to (excluded), apart from each other
/// * `relative_sd` - floor, standard deviation of calibration and the like relative to |H_x|, for example 0.01; positive.
///   It is all there is when the test has no coherence or no number of averages
///
/// The logarithmic difference treats a factor up like a factor down. Noise of neighbouring lines is taken as independent, which
/// overlapping windows spoil a little; values without coherence (γ² = 0) count nothing.
///
/// # Source
/// Random error of an FRF: J. S. Bendat, A. G. Piersol, Random Data, 4th edition 2010, section 9.2.
pub fn band_residuals(
    analytical: &FrfSet,
    experimental: &FrfSet,
    bands_hz: &[[f64; 2]],
    relative_sd: f64,
) -> Result<BandResiduals, CorrelationError> {
    same_lines(analytical, experimental)?;
    if !(relative_sd > 0.0 && relative_sd.is_finite()) {
        let what = "relative standard deviation of the functions";
        return Err(CorrelationError::Range { what, value: relative_sd, expected: "positive and finite" });
    }
    let x = experimental;
    let mut by_band = vec![Sum::default(); bands_hz.len()];
    let mut channels = Vec::with_capacity(x.references.len() * x.responses.len());
    for reference in 0..x.references.len() {
        for response in 0..x.responses.len() {
            let mut of_channel = Sum::default();
            for ([low, high], of_band) in bands_hz.iter().zip(&mut by_band) {
                let mut sum = Sum::default();
                for line in (0..x.n_lines()).filter(|&l| x.frequencies_hz[l] >= *low && x.frequencies_hz[l] < *high) {
                    let index = x.index(line, reference, response);
                    sum.add(analytical.h[index], x.h[index], relative_variance(x, index, relative_sd));
                }
                of_band.merge(&sum);
                of_channel.merge(&sum);
            }
            channels.push(of_channel.finish()?);
        }
    }
    let bands = by_band.iter().map(Sum::finish).collect::<Result<_, _>>()?;
    Ok(BandResiduals { bands, channels })
}

/// Variance of real or imaginary part over |H|² by the random error that coherence and averages tell; zero where they are not known, infinite without
/// coherence.
pub(crate) fn random_variance(set: &FrfSet, index: usize) -> f64 {
    match (&set.coherence, set.n_averages) {
        (Some(coherence), Some(n)) if n > 0 => {
            let c = coherence[index].clamp(0.0, 1.0);
            (1.0 - c) / (2.0 * n as f64 * c)
        }
        _ => 0.0,
    }
}

/// The same with a floor.
fn relative_variance(set: &FrfSet, index: usize, floor: f64) -> f64 {
    random_variance(set, index) + floor * floor
}

#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    n: usize,
    db: f64,
    db2: f64,
    deg: f64,
    deg2: f64,
    chi_squared: f64,
}

impl Sum {
    fn add(&mut self, a: Complex<f64>, x: Complex<f64>, relative_variance: f64) {
        let is_usable = a.is_finite() && x.is_finite() && a.norm() > 0.0 && x.norm() > 0.0;
        if !(is_usable && relative_variance.is_finite()) {
            return;
        }
        let ratio = a / x;
        let (db, deg) = (20.0 * ratio.norm().log10(), ratio.arg().to_degrees());
        self.n += 1;
        self.db += db;
        self.db2 += db * db;
        self.deg += deg;
        self.deg2 += deg * deg;
        self.chi_squared += (ratio - 1.0).norm_sqr() / relative_variance;
    }

    fn merge(&mut self, other: &Self) {
        self.n += other.n;
        self.db += other.db;
        self.db2 += other.db2;
        self.deg += other.deg;
        self.deg2 += other.deg2;
        self.chi_squared += other.chi_squared;
    }

    fn finish(&self) -> Result<BandResidual, CorrelationError> {
        let n = self.n.max(1) as f64;
        Ok(BandResidual {
            n_values: self.n,
            amplitude_db: self.db / n,
            amplitude_rms_db: (self.db2 / n).sqrt(),
            phase_deg: self.deg / n,
            phase_rms_deg: (self.deg2 / n).sqrt(),
            misfit: Misfit::new(self.chi_squared, 2 * self.n)?,
        })
    }
}

#[cfg(test)]
mod tests;
