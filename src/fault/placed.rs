//! A fault at a place.

use super::{At, Bench, Fault, Faults, Number, SensorDead, Tests};
use crate::catalogue::did_you_mean;
use crate::data::{Measured, Sensor, TestData, corrected_functions};
use crate::linalg::{Complex, DVector};

/// Factor on the standard deviation of a frequency that counts no more.
pub const LOOSE: f64 = 1e3;

/// A fault at a place, in all tests that have its sensors or in one of them alone.
#[derive(Debug, Clone)]
pub struct PlacedFault {
    /// Its kind.
    pub fault: &'static dyn Fault,
    /// Where.
    pub at: At,
    /// The only test that has it, from 0.
    pub only: Option<usize>,
}

impl PartialEq for PlacedFault {
    fn eq(&self, other: &Self) -> bool {
        (self.name(), &self.at, self.only) == (other.name(), &other.at, other.only)
    }
}

/// Why a fault in words is none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FaultError {
    /// No fault of this name.
    #[error("there is no fault `{name}`{suggestion} (`retune list faults` has them all)")]
    Name {
        /// The name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// Not at this place.
    #[error("`{fault}` cannot be at `{place}`; {places}{suggestion}")]
    Place {
        /// The fault.
        fault: &'static str,
        /// The place.
        place: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
        /// Where it can be.
        places: String,
    },
}

impl PlacedFault {
    /// In all tests that have its sensors.
    pub fn new(fault: &'static dyn Fault, at: At) -> Self {
        Self { fault, at, only: None }
    }

    /// A sensor without its readings.
    pub fn silenced(sensor: usize) -> Self {
        Self::new(&SensorDead, At::Sensor(sensor))
    }

    /// The fault of an id such as `sensor-swap@p3+p4`.
    ///
    /// # Errors
    /// No fault of this name, or not at this place, with the nearest right word.
    pub fn of_id(id: &str, faults: &Faults, bench: &Bench<'_>) -> Result<Self, FaultError> {
        let (name, place) = id.split_once('@').unwrap_or((id, ""));
        let Some(fault) = faults.find(name) else {
            let suggestion = did_you_mean(name, faults.iter().map(Fault::name));
            return Err(FaultError::Name { name: name.to_string(), suggestion });
        };
        let only = Faults::none().with(fault);
        let known = only.placed(bench);
        // Two sensors, or two modes, in either order.
        let turned = place.split_once('+').map(|(a, b)| format!("{b}+{a}"));
        let is_there = |p: &&Self| {
            let at = p.location(bench.tests);
            at == place || turned.as_ref() == Some(&at)
        };
        if let Some(found) = known.iter().find(is_there) {
            return Ok(found.clone());
        }
        let places: Vec<String> = known.iter().map(|p| p.location(bench.tests)).collect();
        let suggestion = did_you_mean(place, places.iter().map(String::as_str));
        let places = match places.len() {
            0 => "the test could show it nowhere".to_string(),
            n if n <= MOST_TOLD => format!("it can be at {}", places.join(", ")),
            n => format!("it can be at {} and {} more places", places[..MOST_TOLD].join(", "), n - MOST_TOLD),
        };
        Err(FaultError::Place { fault: fault.name(), place: place.to_string(), suggestion, places })
    }

    /// Name in the catalogue.
    pub fn name(&self) -> &'static str {
        self.fault.name()
    }

    /// Its number.
    pub fn number(&self) -> Number {
        self.fault.number()
    }

    /// Sensors or modes, in words of the tests.
    pub fn location(&self, tests: &dyn Tests) -> String {
        let place = self.at.words(tests);
        self.only.map_or_else(|| place.clone(), |test| tests.with_test(&place, test))
    }

    /// `sensor-sign@p11`, of one test alone `sensor-sign@p11 of bench test`.
    pub fn id(&self, tests: &dyn Tests) -> String {
        format!("{}@{}", self.name(), self.location(tests))
    }

    /// What it means for the engineer.
    pub fn remedy(&self, tests: &dyn Tests) -> String {
        let what = self.fault.remedy(tests, &self.at);
        self.only.map_or_else(|| what.clone(), |test| format!("in {}: {what}", tests.test(test).name))
    }

    /// Whether it is in a test, by its number.
    pub fn is_in(&self, test: usize) -> bool {
        self.only.or(self.at.test()).is_none_or(|only| only == test)
    }

    /// Whether it is about the channels of a sensor, its own or one of two.
    pub fn is_of_channel(&self, sensor: usize) -> bool {
        (self.at.is_of_channels() || matches!(self.at, At::Response { .. })) && self.at.sensors().contains(&sensor)
    }

    /// The same fault in one test alone, where several tests have its channels.
    pub(super) fn in_one_test(&self, tests: &dyn Tests) -> Vec<Self> {
        let own = self.at.sensors();
        let has = |test: &usize| own.iter().all(|s| tests.sensors_of(*test).contains(s));
        let having: Vec<usize> = (0..tests.count()).filter(has).collect();
        if !self.at.is_of_channels() || having.len() < 2 {
            return Vec::new();
        }
        having.into_iter().map(|test| Self { only: Some(test), ..self.clone() }).collect()
    }

    /// In the numbers of one test; none where it is about sensors or modes of other tests.
    pub fn within(&self, tests: &dyn Tests, test: usize) -> Option<Self> {
        if !self.is_in(test) {
            return None;
        }
        let sensor = |s: usize| tests.sensors_of(test).iter().position(|&k| k == s);
        let modes = tests.modes_of(test);
        let mode = |m: usize| modes.contains(&m).then(|| m - modes.start);
        Some(Self::new(self.fault, self.at.renumbered(sensor, mode)?))
    }

    /// Where the sensors are in truth.
    pub fn sensors_in_truth(&self, sensors: &[Sensor], number: f64) -> Vec<Sensor> {
        let mut out = sensors.to_vec();
        self.fault.sensors(&self.at, number, &mut out);
        out
    }

    /// The test as it would be without the fault, in the numbers of that test.
    ///
    /// * `number` - that of the fault: a gain, an angle, a factor on a frequency, which then counts no more, or on standard deviations
    pub fn taken_out_of(&self, test: &TestData, number: f64) -> TestData {
        let mut out = test.clone();
        self.fault.sensors(&self.at, number, &mut out.sensors);
        let corrections = self.fault.functions(&self.at, number, test);
        out.frfs = out.frfs.take().map(|set| corrected_functions(set, &out.sensors, &corrections));
        out.corrections.extend(corrections);
        self.fault.modes(&self.at, number, &mut out.modes);
        self.in_static_readings(&mut out, number, |reading, factor| {
            reading.value /= factor;
            reading.sd /= factor.abs();
        });
        in_shapes(&mut out, |shape, sd| self.fault.shape(&self.at, number, shape, sd));
        if let Number::Frequency { .. } = self.number() {
            self.at.modes().into_iter().for_each(|m| out.modes[m].frequency_hz.sd *= LOOSE);
        }
        out
    }

    /// Puts the fault into the readings and the list of modes of a test. Standard deviations stay as stated: who states them does not know of
    /// the fault. The sensors stay where the test says they are: the readings of one that is elsewhere [in
    /// truth](Self::sensors_in_truth) have to be measured there.
    pub fn put_into(&self, test: &mut TestData, number: f64) {
        self.fault.modes(&self.at, self.number().inverse(number), &mut test.modes);
        self.in_static_readings(test, self.number().inverse(number), |reading, factor| reading.value /= factor);
        in_shapes(test, |shape, _| self.fault.put_into_shape(&self.at, number, shape));
    }

    /// Changes every reading of a static test by what the fault multiplies it by.
    fn in_static_readings(&self, test: &mut TestData, number: f64, change: impl Fn(&mut Measured, f64)) {
        for (of, t) in test.static_tests.iter_mut().enumerate() {
            for (k, reading) in t.readings.iter_mut().enumerate() {
                change(&mut reading.measured, self.fault.static_factor(&self.at, number, of, k));
            }
        }
    }

    /// Puts the fault into what sensors read of one motion.
    pub fn put_into_readings(&self, readings: &mut [Complex<f64>], number: f64) {
        self.fault.put_into_shape(&self.at, number, readings);
    }
}

/// Changes every shape of a test, and the standard deviations of its entries.
fn in_shapes(test: &mut TestData, change: impl Fn(&mut [Complex<f64>], Option<&mut [f64]>)) {
    for mode in &mut test.modes {
        let Some(shape) = &mut mode.shape else { continue };
        change(shape.as_mut_slice(), mode.shape_sd.as_mut().map(DVector::as_mut_slice));
    }
}

/// Places that a message lists.
const MOST_TOLD: usize = 8;
