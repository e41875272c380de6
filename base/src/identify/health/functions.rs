//! Checks of the functions themselves, before any identification.

use super::super::IdentifyError;
use super::super::gaps::lines_text;
use super::super::layout::{check_layout, in_units};
use super::super::mode::driving_points;
use super::codes;
use super::driving_point::{noise, weigh};
use super::{Finding, Level};
use crate::data::FrfSet;
use retune_linalg::Complex;

/// Share of negative power at a driving point that noise explains: with 10 % noise of the rms it stays below 0.02.
const NEGATIVE_SHARE: f64 = 0.1;

/// Difference of reciprocal functions, relative to their mean, that is taken without a word: calibrations are good to 5 %.
const RECIPROCITY: f64 = 0.1;

/// Checks functions for missing values, dead channels, driving points that feed energy back, and reciprocity.
///
/// **Driving point.** A passive structure takes up power at every frequency: Re Y(ω) >= 0 for its driving-point mobility Y.
/// The share of negative power is q = Σ_(P<0) P² / Σ P², with P = Re(i^(1-n) H) of the measured quantity. A driving point has q near 0. Where it has not,
/// four causes are weighed by the data (see `driving_point`): a reversed sign, the conjugate, another quantity, a delay; none of them: another point.
///
/// **Reciprocity.** H_ij = H_ji for pairs measured both ways, when both signs are taken into account:
/// δ = |H_ij - H_ji| / ½(|H_ij| + |H_ji|) in 2-norms over lines, less the noise that neighbouring lines show. Where a factor of one of the
/// two leaves no difference, the finding states it.
///
/// # Errors
/// A set whose lengths disagree.
pub fn check_functions(frfs: &FrfSet) -> Result<Vec<Finding>, IdentifyError> {
    check_layout(frfs)?;
    // Every measure is a ratio; in these units no square leaves the range of numbers.
    let frfs = &in_units(frfs);
    let mut findings = Vec::new();
    for (o, response) in frfs.responses.iter().enumerate() {
        for (i, reference) in frfs.references.iter().enumerate() {
            let values = || (0..frfs.n_lines()).map(|l| frfs.at(l, i, o));
            let lost: Vec<f64> =
                frfs.frequencies_hz.iter().zip(values()).filter(|(_, h)| !h.is_finite()).map(|(f, _)| *f).collect();
            let missing = lost.len();
            let subject = || format!("{} / {}", response.name, reference.name);
            if missing > 0 && missing < frfs.n_lines() {
                findings.push(Finding {
                    level: Level::Warning,
                    code: "missing-lines",
                    subject: subject(),
                    evidence: vec![("lines missing", missing as f64), ("lines", frfs.n_lines() as f64)],
                    text: format!("function {} lacks {}", subject(), lines_text(&lost, frfs.n_lines())),
                    remedy: "restrict the band to lines that every channel has, or leave the channel out",
                });
            }
            if missing == 0 && frfs.n_lines() > 0 && values().all(|h| h == Complex::ZERO) {
                findings.push(Finding {
                    level: Level::Fault,
                    code: codes::SENSOR_DEAD,
                    subject: response.name.clone(),
                    evidence: vec![("rms", 0.0)],
                    text: format!("function {} is zero in every line", subject()),
                    remedy: "check the cable and the channel assignment; leave the channel out",
                });
            }
        }
    }
    for (o, i, sign) in driving_points(frfs) {
        findings.extend(driving_point(frfs, o, i, sign));
    }
    findings.extend(reciprocity(frfs));
    Ok(findings)
}

fn driving_point(frfs: &FrfSet, o: usize, i: usize, sign: f64) -> Option<Finding> {
    let (mut negative, mut total) = (0.0, 0.0);
    for l in (0..frfs.n_lines()).filter(|&l| frfs.frequencies_hz[l] > 0.0) {
        let h = frfs.at(l, i, o);
        if h.is_finite() {
            // i^(1-n) H has the sign of Re Y and, unlike Y, the noise of the measurement.
            let power = sign * (h * Complex::<f64>::i().powi(1 - frfs.quantity.order())).re;
            total += power * power;
            negative += if power < 0.0 { power * power } else { 0.0 };
        }
    }
    let share = if total > 0.0 { negative / total } else { return None };
    if share <= NEGATIVE_SHARE {
        return None;
    }
    let name = &frfs.responses[o].name;
    let weighed = weigh(frfs, o, i, sign);
    let fitting = weighed.fitting();
    let mut evidence = vec![("share of negative power", share), ("misfit as stated", weighed.as_stated)];
    evidence.extend(weighed.causes.iter().map(|(cause, misfit)| (cause.evidence(), *misfit)));
    let (code, text, remedy) = match &fitting[..] {
        [] => (
            "driving-point-not-passive",
            format!(
                "{name} feeds energy back, and neither another sign nor the conjugate, another quantity or a delay makes it a passive point, so \
                 it cannot be the driving point"
            ),
            "correct the point of excitation; until then no shape can be scaled by mass",
        ),
        [cause] => {
            (cause.code(), format!("the driving point {name} feeds energy back: {}", cause.text()), cause.remedy())
        }
        several => {
            let list: Vec<String> = several.iter().map(|c| c.text()).collect();
            (
                "driving-point-undecided",
                format!(
                    "the driving point {name} feeds energy back, and the data fit each of these causes: {}",
                    list.join("; or ")
                ),
                "find out which it is from the set-up (signs of the channels, quantity and convention of the export, trigger), correct that one \
                 and no other, and read the functions again",
            )
        }
    };
    Some(Finding { level: Level::Fault, code, subject: name.clone(), evidence, text, remedy })
}

fn reciprocity(frfs: &FrfSet) -> Vec<Finding> {
    let points = driving_points(frfs);
    let mut findings = Vec::new();
    for (a, &(oa, ia, sa)) in points.iter().enumerate() {
        for &(ob, ib, sb) in &points[..a] {
            if ia == ib {
                continue;
            }
            let lines: Vec<(Complex<f64>, Complex<f64>)> = (0..frfs.n_lines())
                .map(|l| (frfs.at(l, ib, oa) * (sa * sb), frfs.at(l, ia, ob)))
                .filter(|(p, q)| p.is_finite() && q.is_finite())
                .collect();
            let (p, q): (Vec<_>, Vec<_>) = lines.iter().copied().unzip();
            let size = |v: &[Complex<f64>]| v.iter().map(Complex::norm_sqr).sum::<f64>();
            let mean = 0.5 * (size(&p).sqrt() + size(&q).sqrt());
            if mean <= 0.0 {
                continue;
            }
            // What the noise from line to line leaves of a difference is not a difference of the structure.
            let power = |h: &[Complex<f64>]| noise(h).iter().map(|s| 2.0 * s * s).sum::<f64>();
            let (noise_p, noise_q) = (power(&p), power(&q));
            let apart = |gain: f64| {
                let total: f64 = lines.iter().map(|(p, q)| (p - q * gain).norm_sqr()).sum();
                (total - noise_p - gain * gain * noise_q).max(0.0).sqrt() / mean
            };
            let delta = apart(1.0);
            if delta <= RECIPROCITY {
                continue;
            }
            let together: f64 = lines.iter().map(|(p, q)| (q.conj() * p).re).sum();
            let mut gain = together.signum() * (size(&p) - noise_p).max(0.0).sqrt()
                / (size(&q) - noise_q).max(f64::MIN_POSITIVE).sqrt();
            let (opposite, scaled) = (apart(-1.0), apart(gain));
            let (mut na, mut nb) = (&frfs.responses[oa].name, &frfs.responses[ob].name);
            // Said of the larger one over the smaller one.
            if gain.abs() < 1.0 && gain != 0.0 {
                gain = 1.0 / gain;
                (na, nb) = (nb, na);
            }
            let both = format!("the functions {na} over {nb} and {nb} over {na}");
            let is_opposite = opposite <= RECIPROCITY;
            let is_gain = !is_opposite && scaled <= RECIPROCITY.min(0.5 * delta);
            let (text, remedy) = if is_opposite {
                (
                    format!("{both} are equal but of opposite sign"),
                    "reverse one of the two forces or sensors: the driving points say which, since each must take up power",
                )
            } else if is_gain {
                (
                    format!(
                        "{both} differ by {:.0} % of their mean, and a gain explains it: their ratio is {gain:.3}",
                        100.0 * delta
                    ),
                    "compare the sensitivities of both force channels and of both sensors with their calibration, and correct the one that is off \
                     by this ratio",
                )
            } else {
                (
                    format!("{both} differ by {:.0} % of their mean, and no gain explains it", 100.0 * delta),
                    "look for a wrong point or direction, a frequency that moved between the two runs, or a nonlinearity (two levels of force); \
                     if none is found, identify from one reference alone",
                )
            };
            findings.push(Finding {
                level: if is_opposite { Level::Fault } else { Level::Warning },
                code: if is_opposite { "reciprocity-sign" } else { "reciprocity" },
                subject: format!("{na} / {nb}"),
                evidence: vec![
                    ("relative difference", delta),
                    ("difference with opposite sign", opposite),
                    ("ratio", gain),
                    ("difference beside that ratio", scaled),
                ],
                text,
                remedy,
            });
        }
    }
    findings
}
