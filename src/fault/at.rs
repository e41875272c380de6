//! Where a fault is.

use super::Tests;
use crate::data::Place;
use crate::model::AXES;

/// Where a fault is, by the numbers of sensors and modes through all tests of a structure, from 0.
#[derive(Debug, Clone, PartialEq)]
pub enum At {
    /// A sensor.
    Sensor(usize),
    /// Two sensors.
    Sensors(usize, usize),
    /// A sensor and a global axis: 0, 1, 2.
    Axis(usize, usize),
    /// A sensor and another place for it.
    Place {
        /// The sensor.
        sensor: usize,
        /// Where it is instead.
        place: Place,
        /// Its offset there, m.
        offset: Option<[f64; 3]>,
        /// The place in words.
        name: String,
    },
    /// A mode.
    Mode(usize),
    /// Two modes.
    Modes(usize, usize),
    /// Groups of close modes of a test.
    Spaces {
        /// The test, from 0.
        test: usize,
        /// The modes of each group.
        spaces: Vec<Vec<usize>>,
    },
    /// A sensor as a response of the functions of a test.
    Response {
        /// The sensor.
        sensor: usize,
        /// The test, from 0.
        test: usize,
    },
    /// A reference of the functions of a test, and the sensor where the force acted instead.
    Reference {
        /// The sensor.
        sensor: usize,
        /// The test, from 0.
        test: usize,
        /// The reference, from 0.
        reference: usize,
    },
    /// The loads of a static test.
    Load {
        /// The test, from 0.
        test: usize,
        /// The static test in it, from 0.
        of: usize,
    },
    /// A reading of a static test.
    StaticReading {
        /// The sensor.
        sensor: usize,
        /// The test, from 0.
        test: usize,
        /// The static test in it, from 0.
        of: usize,
        /// The reading in that, from 0.
        reading: usize,
    },
}

impl At {
    /// The sensors that it is about.
    pub fn sensors(&self) -> Vec<usize> {
        match *self {
            At::Sensor(s) | At::Axis(s, _) | At::Place { sensor: s, .. } => vec![s],
            At::Response { sensor, .. } | At::Reference { sensor, .. } | At::StaticReading { sensor, .. } => {
                vec![sensor]
            }
            At::Sensors(a, b) => vec![a, b],
            At::Mode(_) | At::Modes(..) | At::Spaces { .. } | At::Load { .. } => Vec::new(),
        }
    }

    /// The sensor that it is about, the first of two; 0 where it is about modes.
    pub fn sensor(&self) -> usize {
        self.sensors().first().copied().unwrap_or(0)
    }

    /// The modes that it is about.
    pub fn modes(&self) -> Vec<usize> {
        match self {
            At::Mode(m) => vec![*m],
            At::Modes(a, b) => vec![*a, *b],
            At::Spaces { spaces, .. } => spaces.concat(),
            _ => Vec::new(),
        }
    }

    /// Whether it is about static tests.
    pub fn is_of_statics(&self) -> bool {
        matches!(self, At::Load { .. } | At::StaticReading { .. })
    }

    /// Whether it is about the channels of a sensor: what it reads, where, and along what.
    pub fn is_of_channels(&self) -> bool {
        matches!(self, At::Sensor(_) | At::Sensors(..) | At::Axis(..) | At::Place { .. })
    }

    /// The only test that can have it, where the place says so.
    pub fn test(&self) -> Option<usize> {
        match *self {
            At::Response { test, .. }
            | At::Reference { test, .. }
            | At::Spaces { test, .. }
            | At::Load { test, .. }
            | At::StaticReading { test, .. } => Some(test),
            _ => None,
        }
    }

    /// The same in other numbers; none where one of them has none.
    pub fn renumbered(
        &self,
        sensor: impl Fn(usize) -> Option<usize>,
        mode: impl Fn(usize) -> Option<usize>,
    ) -> Option<Self> {
        Some(match self.clone() {
            At::Sensor(s) => At::Sensor(sensor(s)?),
            At::Sensors(a, b) => At::Sensors(sensor(a)?, sensor(b)?),
            At::Axis(s, axis) => At::Axis(sensor(s)?, axis),
            At::Place { sensor: s, place, offset, name } => At::Place { sensor: sensor(s)?, place, offset, name },
            At::Mode(m) => At::Mode(mode(m)?),
            At::Modes(a, b) => At::Modes(mode(a)?, mode(b)?),
            At::Spaces { test, spaces } => {
                let of = |space: Vec<usize>| space.into_iter().map(&mode).collect::<Option<Vec<_>>>();
                At::Spaces { test, spaces: spaces.into_iter().map(of).collect::<Option<_>>()? }
            }
            At::Response { sensor: s, test } => At::Response { sensor: sensor(s)?, test },
            At::Reference { sensor: s, test, reference } => At::Reference { sensor: sensor(s)?, test, reference },
            At::Load { test, of } => At::Load { test, of },
            At::StaticReading { sensor: s, test, of, reading } => {
                At::StaticReading { sensor: sensor(s)?, test, of, reading }
            }
        })
    }

    /// In words of the tests: `p11`, `p3+p4`, `p7.z`, `p2:n5`, `mode 3`.
    pub fn words(&self, tests: &dyn Tests) -> String {
        let name = |s: usize| tests.sensor(s);
        match self {
            At::Sensor(s) => name(*s).to_string(),
            At::Response { sensor, test } => tests.with_test(name(*sensor), *test),
            At::Sensors(a, b) => format!("{}+{}", name(*a), name(*b)),
            At::Axis(s, axis) => format!("{}.{}", name(*s), AXES[*axis]),
            At::Place { sensor, name: place, .. } => format!("{}:{place}", name(*sensor)),
            At::Mode(m) => tests.mode(*m),
            At::Modes(a, b) => format!("{}+{}", tests.mode(*a), tests.mode(*b)),
            At::Spaces { spaces, .. } => {
                let of = |space: &Vec<usize>| space.iter().map(|&m| tests.mode(m)).collect::<Vec<_>>().join("+");
                spaces.iter().map(of).collect::<Vec<_>>().join(", ")
            }
            At::Reference { sensor, test, reference } => {
                format!("{}:{}", tests.reference(*test, *reference), name(*sensor))
            }
            At::Load { test, of } => tests.with_test(&tests.test(*test).static_tests[*of].name, *test),
            At::StaticReading { sensor, test, of, .. } => {
                tests.with_test(&format!("{}:{}", tests.test(*test).static_tests[*of].name, name(*sensor)), *test)
            }
        }
    }
}
