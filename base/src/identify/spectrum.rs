//! Peaks of a response spectrum, when no force was measured.

use super::IdentifyError;
use super::band::median;
use super::circle::vertex;

/// Standard deviation of a normal number from the median modulus of the difference of two.
const STEP_TO_SD: f64 = 1.4826 * std::f64::consts::FRAC_1_SQRT_2;

/// A peak of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumPeak {
    /// Frequency, Hz, interpolated between lines.
    pub frequency_hz: f64,
    /// Standard deviation, Hz: the resolution as a uniform distribution over one line, Δf/√12.
    pub frequency_sd: f64,
    /// Prominence: height over the higher of the valleys beside it, dB.
    pub height_db: f64,
    /// Half-power bandwidth over twice the frequency; an upper bound, for the window widens the peak. Absent when it is
    /// not resolved.
    pub damping_ratio: Option<f64>,
}

/// Which local maxima are peaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakOptions {
    /// Limits of the band, Hz.
    pub band_hz: (f64, f64),
    /// Least prominence in units of the scatter from line to line: noise.
    pub threshold: f64,
    /// Least prominence, dB: what a smooth spectrum calls a resonance. Below 3 dB no half-power bandwidth can be read.
    pub min_height_db: f64,
    /// A peak is the highest line within this share of its frequency to both sides.
    pub min_distance: f64,
}

impl PeakOptions {
    /// Resonances: five scatters, 6 dB (twice the amplitude of the valleys), none within 1 % of a higher one.
    pub fn resonances(band_hz: (f64, f64)) -> Self {
        Self { band_hz, threshold: 5.0, min_height_db: 6.0, min_distance: 0.01 }
    }
}

/// Peaks of an amplitude spectrum that stand out of the valleys around them: of a response spectrum, or of singular values.
///
/// A peak must pass two tests, of noise and of shape, on its prominence: the height over the higher of the two valleys on its
/// sides, each the lowest running median (9 lines) before the spectrum rises above the peak again or a quarter of the
/// frequency (at least 100 lines) away.
///
/// **Noise.** The spectrum in dB has a scatter, the median step from line to line times 1.4826/√2, which no slope or flank
/// disturbs; the prominence must exceed `threshold` times that. One Rayleigh-distributed amplitude, the worst case, scatters by
/// 5 dB in this sense; among 40,000 such lines the highest stands 12 dB above the median and the lowest running median 7 dB
/// below it, so a threshold of 5 keeps noise out. Singular values of many functions scatter less, in the same proportion.
///
/// **Shape.** Functions measured with little noise have a scatter near zero, and every ripple between two antiresonances would
/// pass. The prominence must be at least `min_height_db`.
///
/// * `amplitude` - at ascending, evenly spaced `frequencies_hz`; linear, any unit
///
/// # Errors
/// Lists of different length, frequencies that do not ascend.
pub fn spectrum_peaks(
    frequencies_hz: &[f64],
    amplitude: &[f64],
    options: &PeakOptions,
) -> Result<Vec<SpectrumPeak>, IdentifyError> {
    let &PeakOptions { band_hz, threshold, min_height_db, min_distance } = options;
    let (f, n) = (frequencies_hz, frequencies_hz.len());
    if amplitude.len() != n {
        return Err(IdentifyError::Length { what: "the spectrum", expected: n, found: amplitude.len() });
    }
    if let Some(line) = (0..n).find(|&l| !f[l].is_finite() || (l > 0 && f[l] <= f[l - 1])) {
        return Err(IdentifyError::Lines { line, value: f[line] });
    }
    let db: Vec<f64> = amplitude
        .iter()
        .map(|a| if a.is_finite() { 20.0 * a.abs().max(f64::MIN_POSITIVE).log10() } else { f64::NEG_INFINITY })
        .collect();
    let smooth: Vec<f64> = (0..n).map(|l| median(&mut db[l.saturating_sub(4)..(l + 5).min(n)].to_vec())).collect();
    let candidates: Vec<usize> = (1..n.saturating_sub(1))
        .filter(|&l| f[l] >= band_hz.0 && f[l] <= band_hz.1 && db[l] > db[l - 1] && db[l] >= db[l + 1])
        .collect();
    let mut found: Vec<(usize, SpectrumPeak)> = Vec::new();
    for l in candidates {
        let reach = |x: f64| (f[l] - x).abs() <= min_distance * f[l];
        let from = f.partition_point(|x| *x < f[l] && !reach(*x));
        let to = f.partition_point(|x| *x <= f[l] || reach(*x));
        if db[from..to].iter().any(|x| *x > db[l]) {
            continue;
        }
        let low = f.partition_point(|x| *x < 0.75 * f[l]).min(l.saturating_sub(100));
        let high = f.partition_point(|x| *x <= 1.25 * f[l]).max(l + 101).min(n);
        let scatter =
            STEP_TO_SD * median(&mut db[low..high].windows(2).map(|w| (w[1] - w[0]).abs()).collect::<Vec<_>>());
        let valley = |lines: &mut dyn Iterator<Item = usize>| {
            lines.take_while(|&k| db[k] <= db[l]).map(|k| smooth[k]).fold(db[l], f64::min)
        };
        let height = db[l] - valley(&mut (low..l).rev()).max(valley(&mut (l + 1..high)));
        if height.is_nan() || height <= threshold * scatter || height < min_height_db {
            continue;
        }
        let (at, _) = vertex([f[l - 1], f[l], f[l + 1]], [db[l - 1], db[l], db[l + 1]]);
        found.push((
            l,
            SpectrumPeak {
                frequency_hz: at,
                frequency_sd: 0.5 * (f[l + 1] - f[l - 1]) / 12.0_f64.sqrt(),
                height_db: height,
                damping_ratio: bandwidth(f, &db, l).filter(|_| height > 6.0).map(|b| b / (2.0 * at)),
            },
        ));
    }
    Ok(found.into_iter().map(|(_, p)| p).collect())
}

/// Width between the points 3.01 dB below line `l`, Hz; nothing when narrower than two lines.
fn bandwidth(f: &[f64], db: &[f64], l: usize) -> Option<f64> {
    let level = db[l] - 10.0 * 2.0_f64.log10();
    let a = (0..l).rev().find(|&k| db[k] <= level)?;
    let b = (l + 1..f.len()).find(|&k| db[k] <= level)?;
    let cross = |i: usize, j: usize| f[i] + (f[j] - f[i]) * (level - db[i]) / (db[j] - db[i]);
    let width = cross(b - 1, b) - cross(a + 1, a);
    (b - a > 3 && width.is_finite()).then_some(width)
}
