//! Peaks of a response spectrum, when no force was measured.

use super::IdentifyError;
use super::band::median;
use super::circle::vertex;

/// A peak of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumPeak {
    /// Frequency, Hz, interpolated between lines.
    pub frequency_hz: f64,
    /// Standard deviation, Hz: the resolution as a uniform distribution over one line, Δf/√12.
    pub frequency_sd: f64,
    /// Height over the floor around it, dB.
    pub height_db: f64,
    /// Half-power bandwidth over twice the frequency; an upper bound, for the window widens the peak. Absent when it is
    /// not resolved.
    pub damping_ratio: Option<f64>,
}

/// Peaks of an amplitude spectrum that stand out of the floor around them.
///
/// The floor at a line is the median, over the lines within a quarter of its frequency (at least 200), in dB; the scatter of
/// the floor is 1.4826 times the median deviation from it below it, where no flank of a peak counts. A peak is the highest line within its own half-power width
/// and `min_distance_hz`, and stands above the floor by more than `threshold` times the scatter. A Rayleigh-distributed
/// amplitude, the worst case of one average, has 4.9 dB scatter in this sense and exceeds its median by 13 dB once in 1e6
/// lines: the default threshold 4 keeps noise out with more averages too.
///
/// * `amplitude` - at ascending, evenly spaced `frequencies_hz`; linear, any unit
///
/// # Errors
/// Lists of different length, frequencies that do not ascend.
pub fn spectrum_peaks(
    frequencies_hz: &[f64],
    amplitude: &[f64],
    band_hz: (f64, f64),
    threshold: f64,
    min_distance_hz: f64,
) -> Result<Vec<SpectrumPeak>, IdentifyError> {
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
    let candidates: Vec<usize> = (1..n.saturating_sub(1))
        .filter(|&l| f[l] >= band_hz.0 && f[l] <= band_hz.1 && db[l] > db[l - 1] && db[l] >= db[l + 1])
        .collect();
    let mut found: Vec<(usize, SpectrumPeak)> = Vec::new();
    for l in candidates {
        let reach = |x: f64| (f[l] - x).abs() <= min_distance_hz;
        let from = f.partition_point(|x| *x < f[l] && !reach(*x));
        let to = f.partition_point(|x| *x <= f[l] || reach(*x));
        if db[from..to].iter().any(|x| *x > db[l]) {
            continue;
        }
        let low = f.partition_point(|x| *x < 0.75 * f[l]).min(l.saturating_sub(100));
        let high = f.partition_point(|x| *x <= 1.25 * f[l]).max(l + 101).min(n);
        let floor = median(&mut db[low..high].to_vec());
        let below = db[low..high].iter().filter(|x| **x <= floor).map(|x| floor - x);
        let scatter = 1.4826 * median(&mut below.collect::<Vec<_>>());
        let height = db[l] - floor;
        if height.is_nan() || height <= threshold * scatter {
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
