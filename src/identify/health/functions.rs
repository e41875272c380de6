//! Checks of the functions themselves, before any identification.

use super::super::IdentifyError;
use super::super::band::check_layout;
use super::super::mode::driving_points;
use super::{Finding, Level};
use crate::data::FrfSet;
use crate::linalg::Complex;

/// Share of negative power at a driving point that noise explains: with 10 % noise of the rms it stays below 0.02.
const NEGATIVE_SHARE: f64 = 0.1;

/// Relative difference of reciprocal functions that is taken without a word: sensor calibration is good to 5 %.
const RECIPROCITY: f64 = 0.1;

/// Checks functions for missing values, dead channels, driving points that feed energy back, and reciprocity.
///
/// **Driving point.** A passive structure takes up power at every frequency: Re Y(ω) >= 0 for its driving-point mobility Y.
/// The share of negative power is q = Σ_(P<0) P² / Σ P², with P = Re(i^(1-n) H) of the measured quantity. A driving point has q near 0, one with a
/// reversed sensor or force q near 1, another point something between.
///
/// **Reciprocity.** H_ij = H_ji for pairs measured both ways, when both signs are taken into account:
/// δ = |H_ij - H_ji| / (|H_ij| + |H_ji|) in 2-norms over lines.
///
/// # Errors
/// A set whose lengths disagree.
pub fn check_functions(frfs: &FrfSet) -> Result<Vec<Finding>, IdentifyError> {
    check_layout(frfs)?;
    let mut findings = Vec::new();
    for (o, response) in frfs.responses.iter().enumerate() {
        for (i, reference) in frfs.references.iter().enumerate() {
            let values = || (0..frfs.n_lines()).map(|l| frfs.at(l, i, o));
            let missing = values().filter(|h| !h.is_finite()).count();
            let subject = || format!("{} / {}", response.name, reference.name);
            if missing > 0 && missing < frfs.n_lines() {
                findings.push(Finding {
                    level: Level::Warning,
                    code: "missing-lines",
                    subject: subject(),
                    evidence: vec![("lines missing", missing as f64), ("lines", frfs.n_lines() as f64)],
                    text: format!("function {} lacks {missing} of {} lines", subject(), frfs.n_lines()),
                    remedy: "restrict the band to lines that every channel has, or leave the channel out",
                });
            }
            if missing == 0 && frfs.n_lines() > 0 && values().all(|h| h.norm_sqr() == 0.0) {
                findings.push(Finding {
                    level: Level::Fault,
                    code: "dead-channel",
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
    let is_reversed = share >= 1.0 - NEGATIVE_SHARE;
    Some(Finding {
        level: Level::Fault,
        code: if is_reversed { "driving-point-reversed" } else { "driving-point-not-passive" },
        subject: name.clone(),
        evidence: vec![("share of negative power", share)],
        text: if is_reversed {
            format!(
                "the driving point {name} feeds energy back at nearly every resonance: its sensor or the force is reversed"
            )
        } else {
            format!(
                "{name} feeds energy back at some resonances and takes it up at others, so it cannot be the driving point"
            )
        },
        remedy: if is_reversed {
            "reverse the sign of the sensor or of the force in the test file"
        } else {
            "correct the point of excitation; until then no shape can be scaled by mass"
        },
    })
}

fn reciprocity(frfs: &FrfSet) -> Vec<Finding> {
    let points = driving_points(frfs);
    let mut findings = Vec::new();
    for (a, &(oa, ia, sa)) in points.iter().enumerate() {
        for &(ob, ib, sb) in &points[..a] {
            if ia == ib {
                continue;
            }
            let sign = sa * sb;
            let (mut difference, mut sum, mut x, mut y) = (0.0, 0.0, 0.0_f64, 0.0_f64);
            for l in 0..frfs.n_lines() {
                let (p, q) = (frfs.at(l, ib, oa) * sign, frfs.at(l, ia, ob));
                if p.is_finite() && q.is_finite() {
                    difference += (p - q).norm_sqr();
                    sum += (p + q).norm_sqr();
                    x += p.norm_sqr();
                    y += q.norm_sqr();
                }
            }
            let scale = x.sqrt() + y.sqrt();
            if scale <= 0.0 || difference.sqrt() <= RECIPROCITY * scale {
                continue;
            }
            let (delta, opposite, gain) = (difference.sqrt() / scale, sum.sqrt() / scale, (x / y).sqrt());
            let (na, nb) = (&frfs.responses[oa].name, &frfs.responses[ob].name);
            let is_opposite = opposite <= RECIPROCITY;
            findings.push(Finding {
                level: if is_opposite { Level::Fault } else { Level::Warning },
                code: if is_opposite { "reciprocity-sign" } else { "reciprocity" },
                subject: format!("{na} / {nb}"),
                evidence: vec![("relative difference", delta), ("difference with opposite sign", opposite), ("ratio of rms", gain)],
                text: if is_opposite {
                    format!("the functions {na} over {nb} and {nb} over {na} are equal but of opposite sign")
                } else {
                    format!("the functions {na} over {nb} and {nb} over {na} differ by {:.0} %", 100.0 * delta)
                },
                remedy: "check signs and calibration of both force channels and both sensors; a ratio of rms far from 1 is a gain, \
                         a ratio near 1 a shift of frequency, a wrong point or a nonlinearity",
            });
        }
    }
    findings
}
