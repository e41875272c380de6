//! Checks of identified modes.

use super::super::band::median;
use super::super::identification::Identification;
use super::super::mode::{IdentifiedMode, driving_points};
use super::super::stabilisation::mac;
use super::codes;
use super::driving_point::{Cause, weigh};
use super::{Finding, Level};
use crate::catalogue::counted;
use crate::data::{FrfSet, ModeRecord};
use retune_linalg::{Complex, DVector};

/// Standard deviations from which the sign of a residue counts.
const SIGNIFICANT: f64 = 3.0;

/// Checks an identification: channels, driving points, double modes, modes that the sensors cannot tell apart.
pub fn check_modes(frfs: &FrfSet, identification: &Identification) -> Vec<Finding> {
    let mut findings = channels(frfs, identification);
    for (o, i, sign) in driving_points(frfs) {
        findings.extend(driving_point(frfs, &identification.modes, o, i, sign));
    }
    let shapes: Vec<Shape<'_>> = identification
        .modes
        .iter()
        .map(|m| Shape { hz: m.frequency_hz.value, zeta: m.damping_ratio.value, shape: &m.shape })
        .collect();
    let directions: Vec<Option<[f64; 3]>> = frfs.responses.iter().map(|c| c.direction).collect();
    findings.extend(pairs(&shapes, &directions));
    findings
}

/// Noise of each channel, over all pieces with a mode.
///
/// ```text
/// ν_k = Σ 2σ_k² / Σ rms_k²     share of the channel's power that no mode explains
/// n_k = Σ 2σ_k²                that power itself
/// ```
/// Healthy channels share either the floor of their amplifiers (n alike: a channel near a clamp then has a large ν) or noise
/// that grows with the signal, from the force or the averaging (ν alike: a channel that moves much then has a large n).
/// Noisy is a channel that neither explains: ν above 0.01, and both ln ν and ln n above their medians by 3.5 robust
/// standard deviations (a chance of 2e-4 for a normal number) and by a factor of 10. Dead: ν above 0.8 while the median
/// channel has it below 0.4.
fn channels(frfs: &FrfSet, identification: &Identification) -> Vec<Finding> {
    let largest =
        identification.segments.iter().flat_map(|s| &s.rms).copied().filter(|x| x.is_finite()).fold(0.0, f64::max);
    let (shares, powers): (Vec<f64>, Vec<f64>) = (0..frfs.responses.len())
        .map(|o| {
            let (mut noise, mut power) = (0.0, 0.0);
            for s in &identification.segments {
                if s.noise_sd.get(o).is_some_and(|x| x.is_finite()) {
                    noise += 2.0 * (s.noise_sd[o] / largest).powi(2);
                    power += (s.rms[o] / largest).powi(2);
                }
            }
            if power > 0.0 { (noise / power, noise) } else { (f64::NAN, f64::NAN) }
        })
        .unzip();
    let (Some((middle, limit)), Some((_, power_limit))) = (typical(&shares), typical(&powers)) else {
        return Vec::new();
    };
    let mut findings = Vec::new();
    for (o, &nu) in shares.iter().enumerate() {
        let name = &frfs.responses[o].name;
        let evidence = vec![("share of power without a mode", nu), ("median of all channels", middle.exp())];
        if nu > 0.8 && middle.exp() < 0.4 {
            findings.push(Finding {
                level: Level::Fault,
                code: codes::SENSOR_DEAD,
                subject: name.clone(),
                evidence,
                text: format!("channel {name} shows no resonance: {:.0} % of its power is explained by no mode", 100.0 * nu.min(1.0)),
                remedy: "check sensor and cable; if the point is clamped or on a node line of every mode, say so in the test file",
            });
        } else if nu > 0.01 && nu.ln() > limit && powers[o].ln() > power_limit {
            findings.push(Finding {
                level: Level::Warning,
                code: codes::SENSOR_NOISY,
                subject: name.clone(),
                evidence,
                text: format!(
                    "channel {name} is noisier than the others: {:.1} % of its power is explained by no mode, the median is {:.2} %",
                    100.0 * nu,
                    100.0 * middle.exp()
                ),
                remedy: "check mounting and range of the sensor; its shape entries already carry a larger standard deviation",
            });
        }
    }
    findings
}

/// Median logarithm and the limit above it; nothing for fewer than four channels.
fn typical(list: &[f64]) -> Option<(f64, f64)> {
    let mut logs: Vec<f64> = list.iter().filter(|x| x.is_finite()).map(|x| x.max(1e-300).ln()).collect();
    if logs.len() < 4 {
        return None;
    }
    let middle = median(&mut logs);
    let scatter = 1.4826 * median(&mut logs.iter().map(|x| (x - middle).abs()).collect::<Vec<_>>());
    Some((middle, middle + (3.5 * scatter).max(10.0_f64.ln())))
}

/// Signs of the modal constants at a driving point: with 2iω_d R = φ_d² all are positive.
fn driving_point(frfs: &FrfSet, modes: &[IdentifiedMode], o: usize, i: usize, sign: f64) -> Option<Finding> {
    let (positive, negative) = signs(modes, o, i, sign);
    if negative == 0 {
        return None;
    }
    let name = &frfs.responses[o].name;
    let count = positive + negative;
    // Random signs of m modes agree with probability 2^(1-m).
    let chance = 2.0_f64.powi(1 - count as i32);
    let evidence = vec![
        ("modes with positive residue", positive as f64),
        ("modes with negative residue", negative as f64),
        ("chance that random signs agree", chance),
    ];
    // The residues are those of the quantity that is stated; where another one or the conjugate explains the function, they mean nothing.
    let weighed = weigh(frfs, o, i, sign);
    let fitting = weighed.fitting();
    if let [cause @ (Cause::Conjugate | Cause::Quantity(_) | Cause::Delay(_))] = fitting[..] {
        return Some(Finding {
            level: Level::Fault,
            code: cause.code(),
            subject: name.clone(),
            evidence: [
                evidence,
                vec![("misfit as stated", weighed.as_stated), (cause.evidence(), weighed.causes[0].1)],
            ]
            .concat(),
            text: format!(
                "{negative} of {count} modes have a negative residue at the driving point {name}: {}",
                cause.text()
            ),
            remedy: cause.remedy(),
        });
    }
    if positive == 0 {
        let is_certain = count >= 3;
        let others: Vec<String> = fitting.iter().filter(|c| **c != Cause::Sign).map(|c| c.text()).collect();
        let or = if others.is_empty() { String::new() } else { format!("; or {}", others.join("; or ")) };
        return Some(Finding {
            level: if is_certain { Level::Fault } else { Level::Warning },
            code: "driving-point-reversed",
            subject: name.clone(),
            evidence,
            text: format!(
                "all {negative} modes have a negative residue at the driving point {name}: its sensor or the force is reversed{or}"
            ),
            remedy: "reverse the sign of the sensor or of the force in the test file, unless the set-up says that another cause named is the one",
        });
    }
    // Which points could be the driving point: one sign in every mode, most modes first.
    let mut others: Vec<(usize, usize, bool)> = (0..frfs.responses.len())
        .filter_map(|k| {
            let (p, n) = signs(modes, k, i, 1.0);
            (p.min(n) == 0 && p + n >= count.saturating_sub(2).max(3)).then_some((p + n, k, n > 0))
        })
        .collect();
    others.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    let hint = if others.is_empty() {
        "no measured point has one sign in all modes".to_owned()
    } else {
        let names: Vec<String> = others
            .iter()
            .take(4)
            .map(|(m, k, reversed)| {
                let with = if *reversed { " with reversed sign" } else { "" };
                format!("{}{with} ({})", frfs.responses[*k].name, counted(*m, "mode"))
            })
            .collect();
        format!("one sign in all modes: {}", names.join(", "))
    };
    Some(Finding {
        level: Level::Fault,
        code: "driving-point-sign",
        subject: name.clone(),
        evidence,
        text: format!(
            "{name} cannot be the driving point: {positive} modes have a positive residue there and {negative} a negative one; {hint}"
        ),
        remedy: "correct the point of excitation; until then no shape can be scaled by mass",
    })
}

/// Numbers of modes whose modal constant is significantly positive and negative.
fn signs(modes: &[IdentifiedMode], o: usize, i: usize, sign: f64) -> (usize, usize) {
    let (mut positive, mut negative) = (0, 0);
    for m in modes {
        let constant = sign * m.modal_constant(o, i).re;
        let sd = m.residue_sd[(o, i)] * 2.0 * m.pole.im;
        if constant > SIGNIFICANT * sd {
            positive += 1;
        } else if constant < -SIGNIFICANT * sd {
            negative += 1;
        }
    }
    (positive, negative)
}

/// What the comparison of two shapes needs of a mode.
pub(super) struct Shape<'a> {
    pub(super) hz: f64,
    /// Damping ratio, NaN when unknown.
    pub(super) zeta: f64,
    pub(super) shape: &'a DVector<Complex<f64>>,
}

/// tr(T_m T_n) of two shapes with T = Σ |φ_k|² d_k d_kᵀ/Σ |φ_k|², 0 where they move in perpendicular directions and 1 where both move in
/// one; none where a channel that moves has no direction.
fn common_direction(m: &Shape<'_>, n: &Shape<'_>, directions: &[Option<[f64; 3]>]) -> Option<f64> {
    let tensor = |shape: &DVector<Complex<f64>>| {
        let mut t = [[0.0; 3]; 3];
        let mut sum = 0.0;
        for (v, d) in shape.iter().zip(directions).filter(|(v, _)| v.is_finite() && v.norm_sqr() > 0.0) {
            let d = (*d)?;
            sum += v.norm_sqr();
            for (i, row) in t.iter_mut().enumerate() {
                row.iter_mut().zip(d).for_each(|(t, dj)| *t += v.norm_sqr() * d[i] * dj);
            }
        }
        Some(t.map(|row| row.map(|v| v / sum)))
    };
    let (a, b) = (tensor(m.shape)?, tensor(n.shape)?);
    Some(a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| x * y).sum())
}

/// Pairs of modes with nearly the same shape, and pairs that share one: seen by other channels each, which is no wonder where they move in
/// perpendicular directions, as the two planes of a beam do.
///
/// * `directions` - of the channels, where known
pub(super) fn pairs(modes: &[Shape<'_>], directions: &[Option<[f64; 3]>]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (b, m) in modes.iter().enumerate() {
        for n in &modes[..b] {
            let (x, y): (Vec<_>, Vec<_>) = m
                .shape
                .iter()
                .zip(n.shape.iter())
                .filter(|(x, y)| x.is_finite() && y.is_finite())
                .map(|(x, y)| (*x, *y))
                .unzip();
            if x.len() < 2 {
                continue;
            }
            let mac = mac(&x, &y);
            let gap = m.hz / n.hz - 1.0;
            let subject = format!("{:.2} Hz and {:.2} Hz", n.hz, m.hz);
            let bandwidths = (m.hz - n.hz) / (m.hz * m.zeta + n.hz * n.zeta);
            let mut evidence = vec![("MAC", mac), ("relative gap", gap)];
            evidence.extend(bandwidths.is_finite().then_some(("gap in half bandwidths", bandwidths)));
            let overlap: f64 = x.iter().zip(&y).map(|(x, y)| x.norm() * y.norm()).sum();
            let size = |v: &[Complex<f64>]| v.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
            let overlap = overlap / (size(&x) * size(&y));
            let is_split = || common_direction(m, n, directions).is_none_or(|c| c > 0.3);
            if overlap < 0.3 && gap < 0.05 && is_split() {
                findings.push(Finding {
                    level: Level::Warning,
                    code: "split-mode",
                    text: format!("the modes at {subject} are seen by different channels: probably one mode that moved between two runs"),
                    subject,
                    evidence: [vec![("overlap of the moduli", overlap)], evidence].concat(),
                    remedy: "identify the runs one by one; if all channels were measured at once, the parts of the structure move on their own",
                });
            } else if mac > 0.9 && gap < 0.05 {
                findings.push(Finding {
                    level: Level::Warning,
                    code: "double-mode",
                    text: format!("the modes at {subject} have the same shape (MAC {mac:.2}): probably one mode, measured twice"),
                    subject,
                    evidence,
                    remedy: "look for functions from runs with different sensor or shaker masses, or a drift between runs; \
                             otherwise add sensors that tell the two apart",
                });
            } else if mac > 0.5 {
                findings.push(Finding {
                    level: if mac > 0.9 { Level::Warning } else { Level::Info },
                    code: "auto-mac",
                    text: format!("at these sensors the modes at {subject} look alike (MAC {mac:.2})"),
                    subject,
                    evidence,
                    remedy: "add sensors where the two shapes differ; pair them with care",
                });
            }
        }
    }
    findings
}

/// Checks the damping of modes that a file holds: a passive structure has no negative one, and a mode that vibrates none from 1 on.
///
/// The frequency and the shape of such a mode remain; its damping says nothing and is left out of a test file.
pub fn check_damping(modes: &[ModeRecord]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for m in modes {
        let Some(zeta) = m.damping_ratio.filter(|z| !(0.0..1.0).contains(z)) else { continue };
        let subject = format!("{:.2} Hz", m.frequency_hz);
        let evidence = vec![("damping ratio", zeta)];
        let is_growing = zeta < 0.0;
        findings.push(Finding {
            level: Level::Warning,
            code: if is_growing { "growing-mode" } else { "overdamped-mode" },
            text: if is_growing {
                format!(
                    "the mode at {subject} has a negative damping ratio ({:.3} %): its pole has a positive real part, and the vibration of \
                     a passive structure does not grow; its damping is left out",
                    100.0 * zeta
                )
            } else {
                format!("the mode at {subject} has a damping ratio of {zeta:.3}, and a motion that vibrates has one below 1; its damping is left out")
            },
            subject,
            evidence,
            remedy: "leave the mode out of the test file if it is a pole that fits noise; frequency and shape can be used where the program \
                     that wrote the file shows it in a stable column",
        });
    }
    findings
}

/// Checks that the suspension is soft enough.
///
/// A suspension whose rigid-body modes lie at f_s raises an elastic mode at f by about ½ (f_s/f)² of its frequency when all
/// of its modal mass hangs on it: 0.5 % at a ratio of 1/10, 2 % at 1/5, 5.6 % at 1/3.
///
/// * `suspension_hz` - frequencies of the rigid-body modes on the suspension
/// * `elastic_hz` - frequencies of the elastic modes
pub fn check_suspension(suspension_hz: &[f64], elastic_hz: &[f64]) -> Vec<Finding> {
    let highest = suspension_hz.iter().copied().filter(|x| x.is_finite()).fold(0.0, f64::max);
    let lowest = elastic_hz.iter().copied().filter(|x| x.is_finite() && *x > 0.0).fold(f64::INFINITY, f64::min);
    let ratio = highest / lowest;
    if ratio <= 0.1 {
        return Vec::new();
    }
    vec![Finding {
        level: if ratio > 1.0 / 3.0 {
            Level::Fault
        } else if ratio > 0.2 {
            Level::Warning
        } else {
            Level::Info
        },
        code: "suspension",
        subject: format!("{highest:.3} Hz"),
        evidence: vec![("ratio to the first elastic mode", ratio), ("possible relative shift", 0.5 * ratio * ratio)],
        text: format!(
            "the highest suspension mode, {highest:.3} Hz, is {:.0} % of the first elastic one, {lowest:.3} Hz, and may raise it by {:.1} %",
            100.0 * ratio,
            50.0 * ratio * ratio
        ),
        remedy: "soften the suspension, or put its stiffness into the model",
    }]
}
