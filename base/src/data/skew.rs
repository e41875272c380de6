//! Sensors that stand askew and are exported as several components.
//!
//! ```text
//! h_i = d_i h,   d_i real and the same in all lines and references,   Σ d_i² = 1
//! ```
//!
//! Programs turn the signal of one skew transducer into global axes. The components say nothing that the signal does not say, and count
//! several times as if they did. Components of several transducers differ by noise and by modes; those of one differ by digits alone.

use super::{Channel, FrfSet, ModalSet, ShapeChannel};
use retune_linalg::{Complex, DVector};
use std::collections::BTreeMap;

/// Largest difference of two components of one signal, of their norm: the rounding of files with four or more digits.
const SAME_SIGNAL: f64 = 1e-4;
/// Fewest values that tell a fixed ratio from chance.
const FEWEST_VALUES: usize = 8;
/// The same for entries of shapes, which are fewer and have no noise that is common to them.
const FEWEST_MODES: usize = 3;

/// A sum of rows that replaces them: the row that stays, and each row with its factor.
struct Combination {
    keep: usize,
    parts: Vec<(usize, f64)>,
    direction: [f64; 3],
}

/// The factors d of rows that are one signal, if they are.
fn one_signal(rows: &[Vec<Complex<f64>>], fewest: usize) -> Option<Vec<f64>> {
    let energy: Vec<f64> = rows.iter().map(|r| r.iter().map(Complex::norm_sqr).sum()).collect();
    let largest = (0..rows.len()).max_by(|a, b| energy[*a].total_cmp(&energy[*b]))?;
    let base = &rows[largest];
    let is_whole = rows.iter().all(|r| r.len() == base.len() && r.iter().all(|v| v.is_finite()));
    if base.len() < fewest || !is_whole || energy[largest] <= 0.0 || !energy[largest].is_finite() {
        return None;
    }
    let mut ratios = Vec::with_capacity(rows.len());
    for (row, energy_of_row) in rows.iter().zip(&energy) {
        let ratio = base.iter().zip(row).map(|(b, v)| (b.conj() * v).re).sum::<f64>() / energy[largest];
        let rest: f64 = base.iter().zip(row).map(|(b, v)| (v - b * ratio).norm_sqr()).sum();
        if rest > SAME_SIGNAL * SAME_SIGNAL * energy_of_row {
            return None;
        }
        ratios.push(ratio);
    }
    // One component and zeros beside it is a sensor along an axis.
    let filled = ratios.iter().filter(|r| r.abs() > SAME_SIGNAL).count();
    let length = ratios.iter().map(|r| r * r).sum::<f64>().sqrt();
    (filled > 1).then(|| ratios.iter().map(|r| r / length).collect())
}

/// What the rows of points combine to; `rows` gives the values of one.
fn combinations<'a>(
    channels: impl Iterator<Item = (usize, &'a str, [f64; 3])>,
    rows: impl Fn(usize) -> Vec<Complex<f64>>,
    fewest: usize,
) -> Vec<(String, Combination)> {
    let mut points: BTreeMap<&str, Vec<(usize, [f64; 3])>> = BTreeMap::new();
    for (at, name, direction) in channels {
        points.entry(name).or_default().push((at, direction));
    }
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
    let mut found = Vec::new();
    for (name, list) in points.iter().filter(|(_, list)| (2..=3).contains(&list.len())) {
        let is_square = (0..list.len()).all(|i| (0..i).all(|j| dot(list[i].1, list[j].1).abs() < 1e-6));
        let values: Vec<Vec<Complex<f64>>> =
            if is_square { list.iter().map(|(at, _)| rows(*at)).collect() } else { continue };
        let Some(factors) = one_signal(&values, fewest) else { continue };
        let parts: Vec<(usize, f64)> = list.iter().map(|(at, _)| *at).zip(factors).collect();
        let mut direction = [0.0; 3];
        for ((_, own), (_, factor)) in list.iter().zip(&parts) {
            (0..3).for_each(|i| direction[i] += factor * own[i]);
        }
        let keep = list.iter().map(|(at, _)| *at).min().unwrap_or_default();
        found.push(((*name).to_string(), Combination { keep, parts, direction }));
    }
    found
}

/// What was combined, in words.
fn told(list: &[(String, Combination)]) -> Option<String> {
    /// Most points that a note names.
    const NAMED: usize = 8;
    let (_, first) = list.first()?;
    let names: Vec<&str> = list.iter().take(NAMED).map(|(name, _)| name.as_str()).collect();
    let more = if list.len() > NAMED { ", ..." } else { "" };
    let d = first.direction;
    Some(format!(
        "the components at {} {} ({}{more}) are one signal in a fixed ratio: they were combined to one skew sensor each, the first along ({:.4}, {:.4}, {:.4})",
        list.len(),
        if list.len() == 1 { "point" } else { "points" },
        names.join(", "),
        d[0],
        d[1],
        d[2]
    ))
}

/// Combines responses that are components of one skew sensor, and says so.
pub(in crate::data) fn combine_functions(set: &mut FrfSet) -> Option<String> {
    let (n_references, n_lines) = (set.references.len(), set.n_lines());
    let rows = |response: usize| -> Vec<Complex<f64>> {
        let cells = (0..n_lines).flat_map(|line| (0..n_references).map(move |a| (line, a)));
        let values = cells.map(|(line, a)| set.at(line, a, response));
        // A reference that none of the components has was not measured.
        values.filter(|v| !(v.re.is_nan() && v.im.is_nan())).collect()
    };
    let known = set.responses.iter().enumerate().filter_map(|(i, c)| Some((i, c.name.as_str(), c.direction?)));
    let list = combinations(known, rows, FEWEST_VALUES);
    let told = told(&list)?;
    let width = set.responses.len();
    let mut keep = vec![true; width];
    for (name, combination) in &list {
        for (at, _) in &combination.parts {
            keep[*at] = *at == combination.keep;
        }
        set.responses[combination.keep] = Channel { name: name.clone(), direction: Some(combination.direction) };
    }
    for line in set.h.chunks_exact_mut(width) {
        for (_, c) in &list {
            line[c.keep] = c.parts.iter().map(|(at, factor)| line[*at] * *factor).sum();
        }
    }
    retain(&mut set.h, &keep);
    if let Some(coherence) = &mut set.coherence {
        retain(coherence, &keep);
    }
    retain(&mut set.responses, &keep);
    Some(told)
}

/// Keeps the columns of a list by rows.
fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut columns = keep.iter().cycle();
    list.retain(|_| columns.next().is_some_and(|k| *k));
}

/// Combines rows of shapes that are components of one skew sensor, and says so.
pub(in crate::data) fn combine_modes(set: &mut ModalSet) -> Option<String> {
    let rows = |at: usize| set.modes.iter().map(|m| m.shape[at]).filter(|v| !v.re.is_nan()).collect();
    let moved = set.channels.iter().enumerate().filter(|(_, c)| !c.dof.is_rotation());
    let list = combinations(moved.map(|(i, c)| (i, c.point.as_str(), c.direction)), rows, FEWEST_MODES);
    let told = told(&list)?;
    let mut keep = vec![true; set.channels.len()];
    for (_, c) in &list {
        for (at, _) in &c.parts {
            keep[*at] = *at == c.keep;
        }
        let own: &mut ShapeChannel = &mut set.channels[c.keep];
        own.direction = c.direction;
    }
    for mode in &mut set.modes {
        let mut shape = mode.shape.clone();
        for (_, c) in &list {
            shape[c.keep] = c.parts.iter().map(|(at, factor)| mode.shape[*at] * *factor).sum();
        }
        let left: Vec<Complex<f64>> = shape.iter().zip(&keep).filter(|(_, k)| **k).map(|(v, _)| *v).collect();
        mode.shape = DVector::from_vec(left);
    }
    retain(&mut set.channels, &keep);
    Some(told)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{FrfQuantity, ModeRecord};
    use crate::dof::Dof;

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    fn functions(second: impl Fn(usize, Complex<f64>) -> Complex<f64>) -> FrfSet {
        let channel = |name: &str, d| Channel { name: name.to_owned(), direction: Some(d) };
        let n = 20;
        let signal = |k: usize| Complex::new((k as f64).sin(), (0.3 * k as f64).cos());
        FrfSet {
            quantity: FrfQuantity::Mobility,
            frequencies_hz: (0..n).map(|k| k as f64).collect(),
            references: vec![channel("1", Z)],
            responses: vec![channel("1", X), channel("2", Z), channel("1", Z)],
            h: (0..n).flat_map(|k| [signal(k) * 0.6, signal(k + 7), second(k, signal(k))]).collect(),
            coherence: Some((0..3 * n).map(|k| k as f64).collect()),
            n_averages: None,
        }
    }

    #[test]
    fn components_in_a_fixed_ratio_are_one_sensor() {
        let mut set = functions(|_, s| s * -0.8 * (1.0 + 1e-6));
        let told = combine_functions(&mut set).unwrap();
        assert!(told.contains("1 point (1)"), "{told}");
        assert_eq!((set.responses.len(), set.h.len(), set.coherence.as_ref().map(Vec::len)), (2, 40, Some(40)));
        let d = set.responses[0].direction.unwrap();
        // The sign of a signal is free: the direction and the values turn together.
        let sign = d[0].signum();
        assert!((sign * d[0] - 0.6).abs() < 1e-5 && (sign * d[2] + 0.8).abs() < 1e-5, "{d:?}");
        let first = Complex::new(3.0_f64.sin(), 0.9_f64.cos());
        assert!((set.at(3, 0, 0) * sign - first).norm() < 1e-5);
    }

    #[test]
    fn components_with_noise_or_a_delay_of_their_own_are_several_sensors() {
        assert!(combine_functions(&mut functions(|k, s| s * 0.8 + 0.002 * (k as f64 * 1.7).sin())).is_none());
        assert!(combine_functions(&mut functions(|k, s| s * Complex::from_polar(0.8, 0.01 * k as f64))).is_none());
        // A second component of zeros is a sensor along an axis.
        assert!(combine_functions(&mut functions(|_, s| s * 0.0)).is_none());
    }

    #[test]
    fn shapes_need_three_modes() {
        let channel = |dof: Dof, direction| ShapeChannel { point: "4".to_owned(), dof, direction };
        let mode = |hz: f64, v: f64| {
            let shape = [0.6 * v, 0.8 * v].map(|v| Complex::new(v, 0.0));
            ModeRecord::new(None, hz, DVector::from_column_slice(&shape))
        };
        let channels = vec![channel(Dof::Ux, X), channel(Dof::Uz, Z)];
        let mut two = ModalSet { channels, modes: vec![mode(1.0, 1.0), mode(2.0, -0.3)] };
        assert!(combine_modes(&mut two).is_none());
        two.modes.push(mode(3.0, 0.5));
        assert!(combine_modes(&mut two).is_some());
        assert_eq!((two.channels.len(), two.modes[1].shape.len()), (1, 1));
        let sign = two.channels[0].direction[0].signum();
        assert!((sign * two.modes[1].shape[0].re + 0.3).abs() < 1e-12);
    }
}
