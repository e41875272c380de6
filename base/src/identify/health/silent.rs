//! Channels that read nothing in some modes.

use super::{Finding, Level};
use crate::data::{Origin, Sensor, TestMode};
use retune_linalg::Complex;
use std::f64::consts::TAU;

/// An entry this improbable under the noise that its shape states counts, whatever the motion there is.
const EACH: f64 = 0.05;
/// Chance of a false alarm in one test.
const ALPHA: f64 = 1e-3;
/// A channel that moves in no mode as much as this share of the rms has its own finding: it is dead.
const MOVES: f64 = 0.1;

/// Channels whose entries are nearer to zero than the stated noise would allow: a cable that was off, a file filled with zeros.
///
/// An entry y with the standard deviation s has, whatever the motion at its place,
///
/// ```text
/// P(|y| ≤ t) ≤ 2 t/(s √2π)
/// ```
/// The modes in which this is below 0.05 count together, with the number of ways to choose them and of channels. Shapes that were computed are
/// left out: symmetry makes their zeros exact.
pub fn check_silent(sensors: &[Sensor], modes: &[TestMode]) -> Vec<Finding> {
    (0..sensors.len()).filter_map(|k| silent(k, sensors, modes)).collect()
}

fn silent(k: usize, sensors: &[Sensor], modes: &[TestMode]) -> Option<Finding> {
    let (mut ln_p, mut which, mut n, mut most) = (0.0, Vec::new(), 0_u32, 0.0_f64);
    for (m, mode) in modes.iter().enumerate() {
        let (Some(shape), Some(sd)) = (&mode.shape, &mode.shape_sd) else { continue };
        let is_measured = matches!(mode.shape_origin, Some(Origin::Measured(_)));
        if !is_measured || !shape[k].is_finite() {
            continue;
        }
        n += 1;
        let squares: f64 = shape.iter().filter(|v| v.is_finite()).map(Complex::norm_sqr).sum();
        let rms = (squares / shape.len() as f64).sqrt();
        most = most.max(shape[k].norm() / rms);
        let p = 2.0 * shape[k].norm() / (sd[k] * TAU.sqrt());
        if p < EACH {
            ln_p += p.max(1e-12).ln();
            which.push(m);
        }
    }
    let ways = statrs::function::factorial::binomial(u64::from(n), which.len() as u64);
    let is_chance = which.len() < 2 || ln_p + ways.ln() + (sensors.len() as f64).ln() > ALPHA.ln();
    if is_chance || most < MOVES {
        return None;
    }
    let named: Vec<String> = which.iter().map(|m| format!("{:.2} Hz", modes[*m].frequency_hz.value)).collect();
    let name = &sensors[k].name;
    Some(Finding {
        level: Level::Warning,
        code: "silent-in-modes",
        subject: name.clone(),
        evidence: vec![("modes", which.len() as f64), ("of modes", f64::from(n))],
        text: format!(
            "{name} reads nothing in the modes at {}, nearer to zero than its noise would allow",
            named.join(", ")
        ),
        remedy: "look at its cable and at the functions of these modes; leave its entries out of these shapes (`null`) until they are measured",
    })
}
