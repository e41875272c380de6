//! Modes that are not of the structure: a suspension, a shaker, a neighbour, a spurious pole.

use super::Plan;
use super::hidden::rng;
use crate::result::Diagnosis;
use retune::data::{Measured, Origin, Standing, TestData, TestMode};
use retune::linalg::{Complex, DVector};
use retune::optim::Draw;

/// How far beyond the band of the test such a mode may lie, as a factor.
const BEYOND: f64 = 1.3;

/// A mode of any frequency in and about the band of a test, and any shape.
///
/// * `frequency_noise`, `shape_noise` - that it states, relative; of the shape to its largest entry
pub fn foreign_mode(test: &TestData, rng: &mut impl Draw, frequency_noise: f64, shape_noise: f64) -> TestMode {
    let hz = || test.modes.iter().map(|m| m.frequency_hz.value);
    let (low, high) = (hz().fold(f64::INFINITY, f64::min) / BEYOND, BEYOND * hz().fold(0.0, f64::max));
    let f = low * (high / low).powf(rng.unit());
    let shape: Vec<f64> = test.sensors.iter().map(|_| rng.normal()).collect();
    let largest = shape.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let origin = Origin::Synthetic("a mode of no structure".into());
    TestMode {
        label: None,
        frequency_hz: Measured { value: f, sd: frequency_noise * f, sd_is_default: false },
        damping_ratio: None,
        origin: origin.clone(),
        shape: Some(DVector::from_iterator(shape.len(), shape.iter().map(|v| Complex::new(v / largest, 0.0)))),
        shape_sd: Some(DVector::from_element(shape.len(), shape_noise)),
        shape_origin: Some(origin),
        components: Vec::new(),
        standing: Standing::Open,
        space: None,
    }
}

/// The test with the plan's number of modes more, sorted by frequency, and which they are.
pub(super) fn with_foreign(test: &TestData, plan: &Plan, seed: u64) -> (TestData, Vec<usize>) {
    let mut rng = rng(seed, 9);
    let mut out = test.clone();
    let mut added: Vec<f64> = Vec::new();
    for _ in 0..plan.foreign {
        let mode = foreign_mode(test, &mut rng, plan.frequency_noise, plan.shape_noise);
        let f = mode.frequency_hz.value;
        let at = out.modes.partition_point(|m| m.frequency_hz.value < f);
        out.modes.insert(at, mode);
        added.push(f);
    }
    let is_added = |m: &TestMode| added.contains(&m.frequency_hz.value);
    let which = (0..out.modes.len()).filter(|&m| is_added(&out.modes[m])).collect();
    (out, which)
}

/// Of the modes that are not of the structure, how many were named and how many there are; the same of those that are, which were lost.
pub(super) fn named_and_lost(diagnosis: &Diagnosis, added: &[usize], modes: usize) -> [[usize; 2]; 2] {
    let named: Vec<usize> = diagnosis.foreign_modes.iter().map(|f| f.mode - 1).collect();
    let right = added.iter().filter(|m| named.contains(m)).count();
    let lost = named.iter().filter(|m| !added.contains(m)).count();
    [[right, added.len()], [lost, modes - added.len()]]
}
