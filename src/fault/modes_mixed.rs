//! Shapes of close modes that are mixtures of one another.
//!
//! Two modes of a structure whose frequencies are close share their shapes as small imperfections have it: a coupling κ λ between them, of a
//! joint that is a little softer or a mass that is a little heavier, turns both by
//!
//! ```text
//! sin 2θ = 2 κ λ/|λ_b - λ_a| = κ f/|f_b - f_a|    of the frequencies as measured,    κ ~ N(0, 0.01²)
//! θ ~ N(0, s²),   s = 0.01 f/(2 |f_b - f_a|)
//! ```
//!
//! while their frequencies hardly move. The model of the perfect structure is right then, and its shapes disagree. With the fault taken out the
//! model's shapes are compared with the space that the measured ones span, see [`TestMode::space`].
//!
//! # Source
//! C. Pierre, Mode localization and eigenvalue loci veering phenomena in disordered structures, Journal of Sound and Vibration 126(3), 1988.

use super::{AboutFault, At, Bench, Fault, Number, Tests};
use crate::data::{TestData, TestMode};

/// Standard deviation of the coupling κ: what imperfections of a structure, as wall thickness and straightness of a tube, move λ by.
const COUPLING: f64 = 0.01;
/// Neighbouring modes of a larger relative distance are not mixed by imperfections: at this one by a tenth of a radian.
pub const MIXED_WITHIN: f64 = 0.05;
/// Most that is thought of the angle: a right angle exchanges the modes.
const MOST_SD: f64 = std::f64::consts::FRAC_PI_4;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct ModesMixed;

impl Fault for ModesMixed {
    fn name(&self) -> &'static str {
        "modes-mixed"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "Shapes of close modes, less than 5 % apart, are mixtures of those of the model, as imperfections too small for a model mix them.",
            signature: "Each shape is a sum of two of the model, which agree with the test as a space; the angles are estimated, N(0, (0.005 f/Δf)²) in radians.",
        }
    }

    /// All close modes of a test at once: what mixes one pair may mix the others.
    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let of = |test: usize| {
            let first = bench.tests.modes_of(test).start;
            let spaces = close_modes(bench.tests.test(test));
            let spaces: Vec<Vec<usize>> =
                spaces.into_iter().map(|s| s.into_iter().map(|m| first + m).collect()).collect();
            (!spaces.is_empty()).then_some(At::Spaces { test, spaces })
        };
        (0..bench.tests.count()).filter_map(of).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let At::Spaces { spaces, .. } = at else { return String::new() };
        let words = |space: &Vec<usize>| {
            let names: Vec<String> = space.iter().map(|&m| tests.mode(m)).collect();
            names.join(" and ")
        };
        let all: Vec<String> = spaces.iter().map(words).collect();
        format!(
            "the shapes of {} are mixtures, and the model need not follow them: give those modes one `space` in the test file",
            all.join(", of ")
        )
    }

    fn noun(&self) -> Option<&'static str> {
        Some("mixed shapes of close modes")
    }

    fn number(&self) -> Number {
        Number::Mixture
    }

    fn modes(&self, at: &At, _: f64, modes: &mut [TestMode]) {
        let At::Spaces { spaces, .. } = at else { return };
        for space in spaces {
            let named = space.iter().find_map(|&m| modes[m].space.clone());
            let name = named.unwrap_or_else(|| {
                let numbers: Vec<String> = space.iter().map(|m| (m + 1).to_string()).collect();
                format!("modes {}", numbers.join("+"))
            });
            for &m in space {
                modes[m].space = Some(name.clone());
            }
        }
    }
}

/// Runs of neighbouring modes with shapes that are so close that imperfections mix them, by number; those that are of one space already are not
/// among them.
fn close_modes(test: &TestData) -> Vec<Vec<usize>> {
    let mut by_frequency: Vec<usize> = (0..test.modes.len())
        .filter(|&m| test.modes[m].shape.is_some() && !test.modes[m].standing.is_aside())
        .collect();
    by_frequency.sort_by(|&a, &b| frequency(test, a).total_cmp(&frequency(test, b)));
    let is_close = |a: &usize, b: &usize| distance(test, *a, *b) < MIXED_WITHIN;
    by_frequency
        .chunk_by(is_close)
        .filter(|run| run.len() > 1)
        .map(<[usize]>::to_vec)
        .filter(|run| {
            run.iter().any(|&m| test.modes[m].space.is_none() || test.modes[m].space != test.modes[run[0]].space)
        })
        .collect()
}

fn frequency(test: &TestData, mode: usize) -> f64 {
    test.modes[mode].frequency_hz.value
}

/// Of two frequencies, relative.
fn distance(test: &TestData, a: usize, b: usize) -> f64 {
    let (f, g) = (frequency(test, a), frequency(test, b));
    2.0 * (g - f).abs() / (f + g)
}

/// s, the standard deviation of the angle between two modes of a test, rad.
pub fn mixture_sd(test: &TestData, a: usize, b: usize) -> f64 {
    (COUPLING / (2.0 * distance(test, a, b))).min(MOST_SD)
}
