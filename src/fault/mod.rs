//! Faults of a measurement: what may be wrong with a test while the model is right.
//!
//! A [`Fault`] knows where it could be in the tests of a structure ([`Fault::places`]) and how to take it out of a test: of
//! what the sensors read ([`Fault::shape`]), of where they are ([`Fault::sensors`]), of the list of modes ([`Fault::modes`]), of
//! static tests ([`Fault::static_factor`]) or of the frequency responses ([`Fault::functions`]). So a fault has an exact counterpart, the test without it, and a diagnosis compares it with effects
//! of the structure by evidence. The same edit, inverted, puts the fault into a synthetic test.
//!
//! A reading t = g φ with gain g has residual (g c φ - t)/σ, which is the residual of t/g with σ/g: a gain is a changed test too.
//!
//! To add one: a file with a unit struct and `impl Fault`, `mod` and a line in [`FAULTS`]; the tests of this module hold every member to
//! the contract. A fault of your own crate is passed by [`Faults::with`].

mod at;
mod bench;
mod driving_point;
mod function_gain;
mod mode_frequency;
mod mode_order;
mod modes_mixed;
mod placed;
mod sensor_axis;
mod sensor_dead;
mod sensor_gain;
mod sensor_noisy;
mod sensor_position;
mod sensor_sign;
mod sensor_swap;
mod sensor_tilted;
mod sensor_turned;
mod sensor_unit;
mod static_load;
mod static_reading;
#[cfg(test)]
mod tests;

pub use at::At;
pub use bench::response_of;
pub use bench::{Bench, SingleTest, Tests};
pub use modes_mixed::{MIXED_WITHIN, mixture_sd};
pub use placed::LOOSE;
pub use placed::{FaultError, PlacedFault};

use crate::catalogue::catalogue;
use crate::data::{Correction, Sensor, TestData, TestMode};
use crate::linalg::Complex;
use std::fmt;

catalogue! {
    /// Every built-in fault, those of a sensor first.
    FAULTS: dyn Fault;
    sensor_sign::SensorSign,
    sensor_gain::SensorGain,
    sensor_unit::SensorUnit,
    sensor_dead::SensorDead,
    sensor_noisy::SensorNoisy,
    sensor_swap::SensorSwap,
    sensor_axis::SensorAxis,
    sensor_turned::SensorTurned,
    sensor_tilted::SensorTilted,
    sensor_position::SensorPosition,
    mode_order::ModeOrder,
    mode_frequency::ModeFrequency,
    modes_mixed::ModesMixed,
    function_gain::FunctionGain,
    driving_point::DrivingPoint,
    static_load::StaticLoad,
    static_reading::StaticReading,
}

/// Something that may be wrong with a measurement: stateless; where it could be, and how it is taken out of a test.
///
/// Without a [number](Self::number) a fault is taken to be its own inverse, as a sensor that is turned over twice; with one, the fault of the
/// [inverse number](Number::inverse) undoes it. One that is neither says how it is put into a shape ([`Self::put_into_shape`]).
pub trait Fault: fmt::Debug + Send + Sync {
    /// Its name, `kebab-case`: "sensor-sign".
    fn name(&self) -> &'static str;

    /// What it is, and how it shows.
    fn about(&self) -> AboutFault;

    /// Where these tests could show it, in the order of sensors and modes.
    fn places(&self, bench: &Bench<'_>) -> Vec<At>;

    /// What to do about it, as an order to the engineer.
    fn remedy(&self, tests: &dyn Tests, at: &At) -> String;

    /// What it is in a sentence, where nothing is wrong with the measurement: "a mixture of close modes".
    fn noun(&self) -> Option<&'static str> {
        None
    }

    /// The number that is estimated with it.
    fn number(&self) -> Number {
        Number::None
    }

    /// ln of its odds against those of other kinds.
    fn ln_odds(&self) -> f64 {
        0.0
    }

    /// Takes it out of a shape, and out of the standard deviations of its entries where these are known.
    fn shape(&self, at: &At, number: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        let _ = (at, number, shape, sd);
    }

    /// Puts it into a shape: the inverse of [`Self::shape`], for synthetic tests.
    fn put_into_shape(&self, at: &At, number: f64, shape: &mut [Complex<f64>]) {
        self.shape(at, self.number().inverse(number), shape, None);
    }

    /// Puts the sensors where, or along what, they are in truth.
    fn sensors(&self, at: &At, number: f64, sensors: &mut [Sensor]) {
        let _ = (at, number, sensors);
    }

    /// Takes it out of the list of modes.
    fn modes(&self, at: &At, number: f64, modes: &mut [TestMode]) {
        let _ = (at, number, modes);
    }

    /// What it multiplies a reading of a static test by.
    ///
    /// * `of`, `reading` - number of the static test and of its reading, from 0
    fn static_factor(&self, at: &At, number: f64, of: usize, reading: usize) -> f64 {
        let _ = (at, number, of, reading);
        1.0
    }

    /// What has to be done to frequency responses, those of the test and those that are read beside it.
    ///
    /// * `test` - with the fault
    fn functions(&self, at: &At, number: f64, test: &TestData) -> Vec<Correction> {
        let _ = (at, number, test);
        Vec::new()
    }
}

/// What is known of a fault, for `list`, `explain` and the reference page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AboutFault {
    /// What is wrong.
    pub summary: &'static str,
    /// How it shows.
    pub signature: &'static str,
}

/// The number of a fault, and what is thought of it beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    /// None: the fault is there, or it is not.
    None,
    /// A factor g on readings, ln |g| ~ N(0, sd²); it may be negative.
    Factor {
        /// Standard deviation of ln |g|.
        sd: f64,
    },
    /// An angle, rad, ~ N(0, sd²).
    Angle {
        /// Its standard deviation, rad.
        sd: f64,
    },
    /// A factor on a frequency, ln g ~ N(0, sd²); the frequency that is left is that of the model.
    Frequency {
        /// Standard deviation of ln g.
        sd: f64,
    },
    /// A factor κ > 1 on the standard deviations of the readings, ln κ half-normal with a standard deviation of 1: the fault is in the noise, not in the
    /// readings.
    Scatter,
    /// None: the readings are noise about zero, whatever the structure does.
    Silence,
    /// The coupling of close modes, over their λ, which mixes their shapes by angles that are each ~ N(0, s²) of [`mixture_sd`]: the model's shapes
    /// are turned to the measured ones, so that the angles follow from every fit.
    Mixture,
}

impl Number {
    /// Its value where there is no fault.
    pub fn neutral(self) -> f64 {
        if matches!(self, Number::Angle { .. } | Number::Mixture) { 0.0 } else { 1.0 }
    }

    /// The number of the fault that undoes this one.
    pub fn inverse(self, number: f64) -> f64 {
        match self {
            Number::Angle { .. } | Number::Mixture => -number,
            Number::Factor { .. } | Number::Frequency { .. } | Number::Scatter => number.recip(),
            Number::None | Number::Silence => number,
        }
    }
}

/// The faults to try: the built-in ones and a user's own.
///
/// ```
/// use retune::fault::{Fault, Faults};
/// assert!(Faults::builtin().find("sensor-sign").is_some());
/// assert_eq!(Faults::none().iter().count(), 0);
/// ```
#[derive(Debug, Clone)]
pub struct Faults {
    faults: Vec<&'static dyn Fault>,
}

impl Faults {
    /// The built-in ones.
    pub fn builtin() -> Self {
        Self { faults: FAULTS.to_vec() }
    }

    /// None; to be filled by [`Self::with`].
    pub fn none() -> Self {
        Self { faults: Vec::new() }
    }

    /// With one more; a fault of the same name replaces the built-in one.
    #[must_use]
    pub fn with(mut self, fault: &'static dyn Fault) -> Self {
        self.faults.retain(|f| f.name() != fault.name());
        self.faults.push(fault);
        self
    }

    /// The fault of a name.
    pub fn find(&self, name: &str) -> Option<&'static dyn Fault> {
        self.faults.iter().copied().find(|f| f.name() == name)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &'static dyn Fault> + '_ {
        self.faults.iter().copied()
    }

    /// Every fault at every place where these tests could show it; what several tests could have, then in each of them alone: cables are
    /// plugged anew for each test.
    pub fn placed(&self, bench: &Bench<'_>) -> Vec<PlacedFault> {
        let of = |fault: &'static dyn Fault| {
            fault.places(bench).into_iter().map(move |at| PlacedFault { fault, at, only: None })
        };
        let mut out: Vec<PlacedFault> = self.iter().flat_map(of).collect();
        let alone: Vec<PlacedFault> = out.iter().flat_map(|placed| placed.in_one_test(bench.tests)).collect();
        out.extend(alone);
        out
    }
}

impl Default for Faults {
    fn default() -> Self {
        Self::builtin()
    }
}
