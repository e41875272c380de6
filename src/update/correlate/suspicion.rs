//! Slips of units and configurations that a comparison shows.

use crate::correlation::{ModePair, PairBy, PairingOptions};
use crate::data::{StaticReading, StaticTest, TestData};
use crate::model::ParametricModel;
use crate::objective::{Comparison, starting_point, static_readings};
use crate::units::{GRAVITY, four_digits};
use crate::update::{UpdateError, assess};
use std::f64::consts::TAU;

/// Factors between the numbers of two units of frequency, and what was probably done.
const SLIPS: [(f64, &str); 6] = [
    (TAU, "are they rad/s, written as Hz?"),
    (1.0 / TAU, "were they divided by 2π twice?"),
    (60.0, "are they revolutions a minute, written as Hz?"),
    (1.0 / 60.0, "were they divided by 60?"),
    (1000.0, "is there a unit missing, or a mass of the model in g that was read as kg?"),
    (0.001, "are they kHz, written as Hz?"),
];
/// The same of one mode among others that have none.
const SLIPS_OF_ONE: [(f64, &str); 6] = [
    (TAU, "is it rad/s, written as Hz?"),
    (1.0 / TAU, "was it divided by 2π twice?"),
    (60.0, "is it revolutions a minute, written as Hz?"),
    (1.0 / 60.0, "was it divided by 60?"),
    (1000.0, "is a decimal point missing, or is it mHz, written as Hz?"),
    (0.001, "is it kHz, written as Hz?"),
];
/// Factors between static displacements in two units, or under loads in two, and what was probably done; with the readings that must agree
/// before a factor that a wrong stiffness may also have is named.
const SLIPS_OF_DISPLACEMENTS: [(f64, usize, &str); 10] = [
    (1000.0, 1, "are they mm, written as m, or is a load in kN, written as N?"),
    (0.001, 1, "are they m, written as mm, or is a load in N, written as kN?"),
    (1e6, 1, "are they um, written as m?"),
    (25.4, 1, "are they mm, written as in?"),
    (1.0 / 25.4, 1, "are they in, written as mm?"),
    (1.0 / 0.0254, 1, "are they in, written as m?"),
    (0.0254, 1, "are they m, written as in?"),
    (GRAVITY, 2, "is a load in kgf, written as N?"),
    (1.0 / GRAVITY, 2, "is a load in N, written as kgf?"),
    (4.448_22, 2, "is a load in lbf, written as N?"),
];
/// The same of rotations.
const SLIPS_OF_ROTATIONS: [(f64, usize, &str); 4] = [
    (360.0 / TAU, 1, "are they degrees, written as rad?"),
    (TAU / 360.0, 1, "are they rad, written as degrees?"),
    (1000.0, 1, "are they mrad, written as rad?"),
    (0.001, 1, "are they rad, written as mrad?"),
];
/// How far a factor of readings may be from a slip: 25.4 and 39.4 are not confused.
const NEAR_READING: f64 = 1.2;

/// MAC of pairs that are certain.
const CERTAIN: f64 = 0.9;
/// How far a common factor may be from a slip, and the pairs from each other.
const NEAR: f64 = 1.3;
/// How much further from its partner than the other modes from theirs a mode may be whose unit has slipped: 2 %.
const SPARE: f64 = 1.02;
/// Pairs that make a common factor more than chance.
const ENOUGH: usize = 3;

/// Of the test modes that pair with certainty by their shapes: the mode, its frequency and that of its partner, Hz.
fn certain_pairs(model: &dyn ParametricModel, test: &TestData) -> Result<Vec<(usize, [f64; 2])>, UpdateError> {
    let pairing =
        PairingOptions { by: PairBy::Mac, min_mac: CERTAIN, frequency_window: f64::INFINITY, same_family_only: true };
    // Of the modes alone: functions need dense matrices.
    let test = &test.without_functions();
    let comparison = Comparison::new(model, test, pairing)?;
    if !comparison.has_shapes() {
        return Ok(Vec::new());
    }
    let prediction = comparison.predict(&starting_point(model)).map_err(UpdateError::Start)?;
    let with_shape = prediction.pairs.pairs.iter().filter(|p| test.modes[p.experimental].shape.is_some());
    let hz = |p: &ModePair| [test.modes[p.experimental].frequency_hz.value, prediction.frequencies_hz[p.analytical]];
    Ok(with_shape.map(|p| (p.experimental, hz(p))).collect())
}

/// A common factor between the frequencies of a test and those of a model, in words, where it is one of two units.
///
/// # Errors
/// The sensors have no place on the model; it cannot be solved.
pub fn slip_of_unit(model: &dyn ParametricModel, test: &TestData) -> Result<Option<String>, UpdateError> {
    let ratios: Vec<f64> = certain_pairs(model, test)?.into_iter().map(|(_, [test, model])| test / model).collect();
    let n = ratios.len();
    let mean = (ratios.iter().map(|r| r.ln()).sum::<f64>() / n.max(1) as f64).exp();
    let agree = ratios.iter().all(|r| (r / mean).ln().abs() < NEAR.ln());
    let slip = SLIPS.iter().find(|(factor, _)| (mean / factor).ln().abs() < NEAR.ln());
    Ok(slip.filter(|_| n >= ENOUGH && agree).map(|(_, question)| {
        format!("the frequencies of the test are {mean:.3} times the model's in all {n} certain pairs: {question}")
    }))
}

/// Single frequencies that are a factor of two units off, in words, while those of the other certain pairs, three or more, are near the model's.
///
/// A slip leaves a mode as near to its partner as the other modes are to theirs: with `r` the ratios of test to model of the others, the ratio of the slipped one lies within
/// `min r` and `max r` times the factor, with a margin of two per cent on both sides. A mode that is not of the structure, and looks like one of its modes to a few sensors, seldom does.
///
/// # Errors
/// The sensors have no place on the model; it cannot be solved.
pub fn slips_of_modes(model: &dyn ParametricModel, test: &TestData) -> Result<Vec<String>, UpdateError> {
    let is_near = |ratio: f64, factor: f64| (ratio / factor).ln().abs() < NEAR.ln();
    let pairs = certain_pairs(model, test)?;
    let (right, wrong): (Vec<_>, Vec<_>) = pairs.into_iter().partition(|(_, [test, model])| is_near(test / model, 1.0));
    if right.len() < ENOUGH || right.len() <= wrong.len() {
        return Ok(Vec::new());
    }
    let ratios = || right.iter().map(|(_, [test, model])| test / model);
    let (least, most) = (ratios().fold(1.0, f64::min) / SPARE, ratios().fold(1.0, f64::max) * SPARE);
    let told = wrong.into_iter().filter_map(|(mode, [test, model])| {
        let is_slip = |factor: f64| (least..=most).contains(&(test / model / factor));
        let (_, question) = SLIPS_OF_ONE.iter().find(|(factor, _)| is_slip(*factor))?;
        let mode = mode + 1;
        let [test, model] = [test, model].map(four_digits);
        Some(format!(
            "mode {mode} has the shape of a mode of the model at {model} Hz and a frequency of {test} Hz: {question}"
        ))
    });
    Ok(told.collect())
}

/// Factors between the static readings of a test and those of a model, in words, where all readings of a kind in one static test have one that
/// lies between two units.
///
/// # Errors
/// The sensors have no place on the model; it cannot be solved.
pub fn slips_of_readings(model: &dyn ParametricModel, test: &TestData) -> Result<Vec<String>, UpdateError> {
    if test.static_tests.is_empty() {
        return Ok(Vec::new());
    }
    let comparison = Comparison::new(model, test, PairingOptions::default())?;
    let prediction = comparison.predict(&starting_point(model)).map_err(UpdateError::Start)?;
    let predicted = static_readings(&comparison, &prediction);
    let measured = test.static_tests.iter().flat_map(|t| t.readings.iter().map(move |r| (t, r)));
    let all: Vec<(&StaticTest, &StaticReading, f64)> =
        measured.zip(predicted).map(|((t, r), model)| (t, r, r.measured.value / model)).collect();
    let mut found = Vec::new();
    for t in &test.static_tests {
        for (is_rotation, what) in [(false, "displacements"), (true, "rotations")] {
            let ratios: Vec<f64> = all
                .iter()
                .filter(|(of, r, _)| std::ptr::eq(*of, t) && test.sensors[r.sensor].is_rotation == is_rotation)
                .map(|(.., ratio)| *ratio)
                .collect();
            let slips = if is_rotation { &SLIPS_OF_ROTATIONS[..] } else { &SLIPS_OF_DISPLACEMENTS[..] };
            let is_near = |factor: f64| ratios.iter().all(|r| *r > 0.0 && (r / factor).ln().abs() < NEAR_READING.ln());
            let slip = slips.iter().find(|(factor, enough, _)| ratios.len() >= *enough && is_near(*factor));
            if let Some((_, _, question)) = slip {
                let mean = (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp();
                found.push(format!(
                    "the {what} of the static test `{}` are {} times the model's: {question}",
                    t.name,
                    plain(mean)
                ));
            }
        }
    }
    Ok(found)
}

/// Three significant digits.
fn plain(factor: f64) -> String {
    let decimals = (2.0 - factor.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{factor:.decimals$}")
}

/// How a model agrees with a test before any update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstLook {
    /// Pairs of modes.
    pub n_pairs: usize,
    /// Their mean MAC.
    pub mean_mac: f64,
    /// Σ ((model - test)/σ)² of what is compared.
    pub chi_squared: f64,
}

impl FirstLook {
    /// At the estimates, paired by MAC.
    ///
    /// # Errors
    /// The sensors have no place on the model; it cannot be solved.
    pub fn new(model: &dyn ParametricModel, test: &TestData) -> Result<Self, UpdateError> {
        let by_mac = PairingOptions { by: PairBy::Mac, ..PairingOptions::default() };
        let comparison = Comparison::new(model, test, by_mac)?;
        let found = assess(&comparison, &starting_point(model))?;
        let macs: Vec<f64> = found.pairs.iter().filter_map(|p| p.mac).collect();
        Ok(Self {
            n_pairs: found.pairs.len(),
            mean_mac: macs.iter().sum::<f64>() / macs.len().max(1) as f64,
            chi_squared: found.misfit.chi_squared,
        })
    }

    /// Whether this is the better model of the test in every respect, and in the misfit by more than a factor: one that pairs less
    /// compares less.
    pub fn is_far_better(&self, than: &Self, factor: f64) -> bool {
        self.n_pairs >= than.n_pairs && self.mean_mac >= than.mean_mac && factor * self.chi_squared < than.chi_squared
    }
}
