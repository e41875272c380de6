//! The tests of a structure as faults see them.

use crate::data::{FrfSet, Sensor, TestData, channel_sensor};
use crate::model::{dot, minus};
use std::ops::Range;

/// Places nearer to each other than this are one, m.
pub(super) const ONE_PLACE: f64 = 1e-9;
/// A sensor is along a direction if the cosine between them is more.
pub(super) const ALONG: f64 = 0.9;
/// Fewest sensors of which one may be wrong.
const FEWEST_SENSORS: usize = 3;

/// Tests of one structure: the sensors of all in one list, and the modes of all in another.
pub trait Tests {
    /// The modes and sensors of all tests.
    fn all(&self) -> &TestData;

    /// How many tests there are.
    fn count(&self) -> usize;

    /// A test, from 0.
    fn test(&self, test: usize) -> &TestData;

    /// Where its modes stand among all.
    fn modes_of(&self, test: usize) -> Range<usize>;

    /// Where its sensors stand among all, in its own order.
    fn sensors_of(&self, test: usize) -> &[usize];

    /// The name of a sensor.
    fn sensor(&self, sensor: usize) -> &str {
        &self.all().sensors[sensor].name
    }

    /// `mode 3`, of several tests `mode 3 of bench test`.
    fn mode(&self, mode: usize) -> String {
        let test = (0..self.count()).find(|&t| self.modes_of(t).contains(&mode)).unwrap_or(0);
        self.with_test(&format!("mode {}", mode - self.modes_of(test).start + 1), test)
    }

    /// The name of a reference of a test's functions.
    fn reference(&self, test: usize, reference: usize) -> &str {
        self.test(test).frfs.as_ref().map_or("", |set| set.references[reference].name.as_str())
    }

    /// Whether two sensors stand in one test.
    fn are_together(&self, a: usize, b: usize) -> bool {
        (0..self.count()).map(|t| self.sensors_of(t)).any(|own| own.contains(&a) && own.contains(&b))
    }

    /// Words with the name of a test behind them, if there are several.
    fn with_test(&self, words: &str, test: usize) -> String {
        if self.count() > 1 { format!("{words} of {}", self.test(test).name) } else { words.to_string() }
    }
}

/// A single test.
#[derive(Debug, Clone)]
pub struct SingleTest<'a> {
    test: &'a TestData,
    sensors: Vec<usize>,
}

impl<'a> SingleTest<'a> {
    /// A test with its own numbers.
    pub fn new(test: &'a TestData) -> Self {
        Self { test, sensors: (0..test.sensors.len()).collect() }
    }
}

impl Tests for SingleTest<'_> {
    fn all(&self) -> &TestData {
        self.test
    }

    fn count(&self) -> usize {
        1
    }

    fn test(&self, _: usize) -> &TestData {
        self.test
    }

    fn modes_of(&self, _: usize) -> Range<usize> {
        0..self.test.modes.len()
    }

    fn sensors_of(&self, _: usize) -> &[usize] {
        &self.sensors
    }
}

/// Tests, and where things stand in them.
#[derive(Clone)]
pub struct Bench<'a> {
    /// The tests.
    pub tests: &'a dyn Tests,
    /// Where each sensor stands, m; none where that is unknown.
    pub positions: Option<Vec<[f64; 3]>>,
    /// Names and places of the nodes of the model file, m.
    pub nodes: Vec<(String, [f64; 3])>,
}

impl Bench<'_> {
    /// All sensors.
    pub fn sensors(&self) -> &[Sensor] {
        &self.tests.all().sensors
    }

    /// The sensors of which one may be wrong: none where there are too few to tell, or no shapes.
    pub fn channels(&self) -> Range<usize> {
        let n = self.sensors().len();
        let reads = self.tests.all().modes.iter().any(|m| m.shape.is_some());
        0..if reads && n >= FEWEST_SENSORS { n } else { 0 }
    }

    /// Pairs of sensors of one test, the first before the second.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let n = self.channels().end;
        (0..n).flat_map(move |a| (a + 1..n).map(move |b| (a, b))).filter(|&(a, b)| self.are_together(a, b))
    }

    /// Whether two sensors stand in one test.
    pub fn are_together(&self, a: usize, b: usize) -> bool {
        self.tests.are_together(a, b)
    }

    /// Whether two sensors of one test read the same kind of motion at one place.
    pub fn share_a_place(&self, a: usize, b: usize) -> bool {
        let Some(at) = &self.positions else { return false };
        let is_rotation = |s: usize| self.sensors()[s].is_rotation;
        self.are_together(a, b) && is_rotation(a) == is_rotation(b) && distance(at[a], at[b]) < ONE_PLACE
    }

    /// The functions of a test that enter a fit.
    pub(super) fn fitted_functions(&self, test: usize) -> Option<&FrfSet> {
        let test = self.tests.test(test);
        test.frfs.as_ref().filter(|_| test.frf_fit.is_some())
    }
}

/// The distance of two places, m.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = minus(a, b);
    dot(d, d).sqrt()
}

/// Whether more than half of all readings are left when one of those that count is taken out.
///
/// What takes a reading out of the data must leave most of them: a dead sensor among sensors of which more than half read, a mistyped frequency
/// among frequencies of which more than half are right. With more such faults the data say nothing that a model could be wrong about.
pub(super) fn leaves_most(counting: usize, all: usize) -> bool {
    2 * (counting - counting.min(1)) > all
}

/// The response that is a sensor of a test.
pub fn response_of(set: &FrfSet, sensors: &[Sensor], sensor: usize) -> Option<usize> {
    let name = &sensors.get(sensor)?.name;
    set.responses.iter().position(|c| channel_sensor(c, sensors).is_some_and(|s| s.name == *name))
}
