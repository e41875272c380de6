//! Shifts of frequency between runs of one test.

use super::super::mode::IdentifiedMode;
use super::super::stabilisation::mac;
use super::{Finding, Level};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Chance below which a difference counts.
const SIGNIFICANCE: f64 = 0.01;

/// Compares two runs of one test, mode by mode.
///
/// With δ_r the relative change of frequency of mode r and s_r its standard deviation, three explanations are tried:
///
/// ```text
/// none           χ² = Σ (δ_r/s_r)²                           m degrees of freedom
/// drift          δ_r = δ            (temperature, tension)   m - 1
/// mass loading   δ_r = -½ Δm φ_r(o)²  (a mass at sensor o)   m - 1, needs mass-normalised shapes
/// ```
/// A common shift that explains the differences is a drift; a mass that does so better by 10 in χ² is named with its place;
/// else the modes moved on their own. Modes are paired by frequency within 5 % and MAC above 0.6.
///
/// * `names` - of the responses, in the order of the shapes
pub fn compare_runs(first: &[IdentifiedMode], second: &[IdentifiedMode], names: &[String]) -> Vec<Finding> {
    let mut pairs: Vec<(&IdentifiedMode, f64, f64)> = Vec::new();
    for a in first {
        let gap = |b: &IdentifiedMode| (b.frequency_hz.value / a.frequency_hz.value - 1.0).abs();
        let partner = second
            .iter()
            .filter(|b| {
                b.shape.len() == a.shape.len() && gap(b) < 0.05 && mac(a.shape.as_slice(), b.shape.as_slice()) > 0.6
            })
            .min_by(|x, y| gap(x).total_cmp(&gap(y)));
        if let Some(b) = partner {
            let delta = b.frequency_hz.value / a.frequency_hz.value - 1.0;
            pairs.push((a, delta, a.frequency_hz.sd.hypot(b.frequency_hz.sd) / a.frequency_hz.value));
        }
    }
    let m = pairs.len();
    let chi2 = |model: &dyn Fn(&IdentifiedMode) -> f64| {
        pairs.iter().map(|(a, d, s)| ((d - model(a)) / s).powi(2)).sum::<f64>()
    };
    let none = chi2(&|_| 0.0);
    if m == 0 || tail(none, m) > SIGNIFICANCE {
        return Vec::new();
    }
    let weight: f64 = pairs.iter().map(|(_, _, s)| 1.0 / (s * s)).sum();
    let common = pairs.iter().map(|(_, d, s)| d / (s * s)).sum::<f64>() / weight;
    let drift = chi2(&|_| common);
    let mut mass: Option<(usize, f64, f64)> = None;
    for o in 0..names.len() {
        let effect = |a: &IdentifiedMode| a.mass_normalised.as_ref().map_or(f64::NAN, |n| -0.5 * n.shape[o].powi(2));
        let (mut top, mut bottom) = (0.0, 0.0);
        for (a, d, s) in &pairs {
            top += d * effect(a) / (s * s);
            bottom += effect(a).powi(2) / (s * s);
        }
        let added = top / bottom;
        let left = chi2(&|a| added * effect(a));
        if added.is_finite() && left.is_finite() && mass.is_none_or(|(_, _, best)| left < best) {
            mass = Some((o, added, left));
        }
    }
    let evidence = vec![
        ("paired modes", m as f64),
        ("chi-squared without a shift", none),
        ("chi-squared with a common shift", drift),
        ("common relative shift", common),
        ("chi-squared with a mass", mass.map_or(f64::NAN, |x| x.2)),
        ("added mass, kg", mass.map_or(f64::NAN, |x| x.1)),
    ];
    let finding = |code, subject: String, text| Finding {
        level: Level::Warning,
        code,
        subject,
        evidence,
        text,
        remedy: "do not mix functions of these runs in one identification; identify each run on its own",
    };
    vec![match mass {
        // One mode always fits both explanations: only a drift can be named then.
        Some((o, added, left)) if m >= 3 && left + 10.0 < drift => finding(
            "mass-loading",
            names[o].clone(),
            format!(
                "the frequencies of the second run fit {:+.1} g at sensor {} more than in the first",
                1000.0 * added,
                names[o]
            ),
        ),
        _ if m >= 2 && tail(drift, m - 1) > SIGNIFICANCE => finding(
            "frequency-drift",
            "all modes".to_owned(),
            format!("all frequencies of the second run are shifted by {:+.2} %", 100.0 * common),
        ),
        _ => finding(
            "frequency-shift",
            format!("{m} modes"),
            format!(
                "frequencies differ between the runs by more than their scatter ({:+.2} % on average)",
                100.0 * common
            ),
        ),
    }]
}

/// P(χ² > x) with `dof` degrees of freedom.
fn tail(x: f64, dof: usize) -> f64 {
    ChiSquared::new(dof as f64).map_or(1.0, |d| 1.0 - d.cdf(x))
}
