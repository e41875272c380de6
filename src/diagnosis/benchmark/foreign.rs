//! Modes that are not of the structure: a suspension, a shaker, a neighbour, a spurious pole.

use super::Plan;
use super::case::Outcome;
use super::hidden::rng;
use crate::data::{Measured, Origin, TestData, TestMode};
use crate::diagnosis::Diagnosis;
use crate::linalg::{Complex, DVector};
use crate::optim::Draw;

/// How far beyond the band of the test such a mode may lie, as a factor.
const BEYOND: f64 = 1.3;

/// The test with the plan's number of modes more, sorted by frequency, and which they are.
pub(super) fn with_foreign(test: &TestData, plan: &Plan, seed: u64) -> (TestData, Vec<usize>) {
    let mut rng = rng(seed, 9);
    let hz = || test.modes.iter().map(|m| m.frequency_hz.value);
    let (low, high) = (hz().fold(f64::INFINITY, f64::min) / BEYOND, hz().fold(0.0, f64::max) * BEYOND);
    let mut out = test.clone();
    let mut added: Vec<f64> = Vec::new();
    for _ in 0..plan.foreign {
        let f = low * (high / low).powf(rng.unit());
        let shape: Vec<f64> = test.sensors.iter().map(|_| rng.normal()).collect();
        let largest = shape.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let origin = Origin::Synthetic("a mode of no structure".into());
        let mode = TestMode {
            label: None,
            frequency_hz: Measured { value: f, sd: plan.frequency_noise * f, sd_is_default: false },
            damping_ratio: None,
            origin: origin.clone(),
            shape: Some(DVector::from_iterator(shape.len(), shape.iter().map(|v| Complex::new(v / largest, 0.0)))),
            shape_sd: Some(DVector::from_element(shape.len(), plan.shape_noise)),
            shape_origin: Some(origin),
            standing: crate::data::Standing::Open,
        };
        let at = out.modes.partition_point(|m| m.frequency_hz.value < f);
        out.modes.insert(at, mode);
        added.push(f);
    }
    let is_added = |m: &TestMode| added.contains(&m.frequency_hz.value);
    let which = (0..out.modes.len()).filter(|&m| is_added(&out.modes[m])).collect();
    (out, which)
}

/// Notes which of them were named, and which true modes were.
pub(super) fn compare(out: &mut Outcome, diagnosis: &Diagnosis, added: &[usize], modes: usize) {
    let named: Vec<usize> = diagnosis.foreign_modes.iter().map(|f| f.mode - 1).collect();
    out.foreign_named = [added.iter().filter(|m| named.contains(m)).count(), added.len()];
    out.true_lost = [named.iter().filter(|m| !added.contains(m)).count(), modes - added.len()];
}
