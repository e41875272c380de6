//! Measurement faults as hypotheses on the data: the model stays, the reading of a channel changes.
//!
//! ```text
//! sensor-sign       t -> -t                                            no free number
//! sensor-swap       t_i <-> t_j                                        no free number
//! sensor-gain       t -> t/g, σ -> σ/g, functions too                  ln g ~ N(0, 0.3²)
//! function-gain     its functions alone -> H/g                         the same
//! sensor-dead       reads noise only: its cost is ½ Σ (t/σ)²           no free number
//! sensor-noisy      σ -> κ σ, with m ln κ for its m entries            ln κ > 0, half-normal of sd 1
//! sensor-axis       reads another global axis at its place             no free number
//! sensor-turned     two perpendicular ones at one place, turned by α    α ~ N(0, (0.3 rad)²)
//! sensor-tilted     alone at its place, tilted by α towards a global axis    α ~ N(0, (0.3 rad)²)
//! sensor-position   sits at a neighbour's place, at the nearest node, or on the other side of its own    no free number
//! mode-order        frequencies of two neighbouring modes exchanged    no free number
//! driving-point     the force of the responses acts at another sensor  no free number
//! ```
//!
//! Each has an exact counterpart as a changed test ([`Fault::apply`]), which the ordinary fit then sees. A reading t = g φ with gain g
//! has residual (g c φ - t)/σ, which is the residual of t/g with σ/g: so a gain is a changed test too.

use super::scene::{Case, Scene};
use crate::correlation::{channel_sensor, corrected_functions};
use crate::data::{Channel, Correction, FrfSet, Place, Sensor, TestData};
use crate::linalg::Complex;
use crate::model::{GLOBAL, plus, unit};

/// A fault of the measurement, for `retune list faults` and `retune explain`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultKind {
    /// As in the ids of hypotheses.
    pub name: &'static str,
    /// What is wrong.
    pub summary: &'static str,
    /// How it shows.
    pub signature: &'static str,
}

/// Every fault that a diagnosis tries.
pub const FAULTS: &[FaultKind] = &[
    FaultKind {
        name: "sensor-sign",
        summary: "A sensor is upside down, or its polarity is wrong.",
        signature: "Its reading has the wrong sign in every mode.",
    },
    FaultKind {
        name: "sensor-swap",
        summary: "The channels of two sensors are exchanged.",
        signature: "Each reads what the model has at the other, in every mode.",
    },
    FaultKind {
        name: "sensor-gain",
        summary: "The sensitivity of a sensor is wrong.",
        signature: "Its reading is off by one factor in every mode; ln of the factor ~ N(0, 0.3²), and it may be negative.",
    },
    FaultKind {
        name: "function-gain",
        summary: "The frequency responses of a sensor are off by one factor, its shapes are not: another calibration, or another charge amplifier.",
        signature: "All lines of its functions are off by one factor; ln of the factor ~ N(0, 0.3²).",
    },
    FaultKind {
        name: "sensor-dead",
        summary: "A sensor reads nothing but noise.",
        signature: "Its reading is zero within its standard deviation in every mode.",
    },
    FaultKind {
        name: "sensor-noisy",
        summary: "A sensor scatters more than the test says.",
        signature: "Its residuals are large without an order; a factor on its standard deviation is estimated.",
    },
    FaultKind {
        name: "sensor-axis",
        summary: "A sensor reads along another global axis than the test says.",
        signature: "It reads what the model has at its place along that axis.",
    },
    FaultKind {
        name: "sensor-turned",
        summary: "Two perpendicular sensors at one place are turned in their plane, as a triaxial accelerometer that was put on askew.",
        signature: "Each reads a part of what the other should; the angle is estimated, N(0, (0.3 rad)²).",
    },
    FaultKind {
        name: "sensor-tilted",
        summary: "A sensor is tilted towards a global axis, as on a surface that is not square to it.",
        signature: "It reads a part of the motion along that axis; the angle is estimated, N(0, (0.3 rad)²).",
    },
    FaultKind {
        name: "sensor-position",
        summary: "A sensor sits at another place than the test says: where one of its neighbours sits, on the nearest node, or on the other side of its own.",
        signature: "It reads what the model has there.",
    },
    FaultKind {
        name: "mode-order",
        summary: "The frequencies of two neighbouring modes are exchanged in the list, their shapes are not.",
        signature: "Both shapes fit at the frequency of the other.",
    },
    FaultKind {
        name: "mode-frequency",
        summary: "The frequency of one mode is misread or mistyped.",
        signature: "It alone is off, its shape and all other modes fit; ln of the factor ~ N(0, 0.2²), and one of twenty such tests has it.",
    },
    FaultKind {
        name: "driving-point",
        summary: "The force of the frequency responses acted at another sensor than the test says.",
        signature: "The functions fit with the force there; shapes do not change.",
    },
];

/// Names of the global axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
/// Standard deviation of ln gain.
pub(super) const GAIN_SD: f64 = 0.3;
/// Standard deviation of the angle by which sensors are turned, rad.
pub(super) const TURN_SD: f64 = 0.3;
/// Standard deviation of ln of the factor on a frequency.
pub(super) const FREQUENCY_SD: f64 = 0.2;
/// ln of the odds of a frequency that is wrong, against those of a kind: one number can be off in every test, and most that is missing shows
/// in one mode more than in others.
pub(super) const LN_SLIP: f64 = -3.0;
/// Factor on the standard deviation of a frequency that counts no more.
pub(super) const LOOSE: f64 = 1e3;

/// What is wrong.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Change {
    Sign,
    Swap(usize),
    Gain,
    /// Of the functions alone.
    FunctionGain,
    Dead,
    Noisy,
    Axis(usize),
    /// With the sensor that is perpendicular to it.
    Turned(usize),
    /// Towards a global axis.
    Tilted(usize),
    Position {
        place: Place,
        offset: Option<[f64; 3]>,
        name: String,
    },
    Order(usize, usize),
    /// The frequency of a mode.
    Frequency(usize),
    /// A reference of the frequency responses of a test: the force acted at the sensor of the fault.
    DrivingPoint {
        case: usize,
        reference: usize,
    },
}

/// A fault of one sensor (or of the list of modes).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    /// Sensor, or first mode.
    pub(super) sensor: usize,
    pub(super) change: Change,
    /// The only test that has it; without, all that have the sensor.
    pub(super) only: Option<usize>,
}

impl Fault {
    /// In all tests that have the sensor.
    pub(super) fn of(sensor: usize, change: Change) -> Self {
        Self { sensor, change, only: None }
    }

    /// Whether it is about a test, by its number.
    pub(super) fn is_in(&self, case: usize) -> bool {
        self.only.is_none_or(|only| only == case)
    }

    /// The tests that it is about.
    pub(super) fn cases<'s>(&self, scene: &'s Scene) -> impl Iterator<Item = &'s Case> {
        scene.cases.iter().enumerate().filter(|(k, _)| self.is_in(*k)).map(|(_, case)| case)
    }

    /// The modes of these tests.
    pub(super) fn modes(&self, scene: &Scene) -> impl Iterator<Item = usize> {
        self.cases(scene).flat_map(Case::modes)
    }

    /// Name in the catalogue.
    pub(super) fn name(&self) -> &'static str {
        match self.change {
            Change::Sign => "sensor-sign",
            Change::Swap(_) => "sensor-swap",
            Change::Gain => "sensor-gain",
            Change::FunctionGain => "function-gain",
            Change::Dead => "sensor-dead",
            Change::Noisy => "sensor-noisy",
            Change::Axis(_) => "sensor-axis",
            Change::Turned(_) => "sensor-turned",
            Change::Tilted(_) => "sensor-tilted",
            Change::Position { .. } => "sensor-position",
            Change::Order(..) => "mode-order",
            Change::Frequency(_) => "mode-frequency",
            Change::DrivingPoint { .. } => "driving-point",
        }
    }

    /// Sensors or modes, in words of the tests.
    pub(super) fn location(&self, scene: &Scene) -> String {
        let name = |i: usize| scene.test.sensors[i].name.clone();
        let place = match &self.change {
            Change::Swap(other) | Change::Turned(other) => format!("{}+{}", name(self.sensor), name(*other)),
            Change::Axis(axis) | Change::Tilted(axis) => format!("{}.{}", name(self.sensor), AXES[*axis]),
            Change::Position { name: place, .. } => format!("{}:{place}", name(self.sensor)),
            Change::Order(a, b) => format!("{}+{}", scene.mode_name(*a), scene.mode_name(*b)),
            Change::Frequency(m) => scene.mode_name(*m),
            Change::DrivingPoint { case, reference } => {
                format!("{}:{}", scene.reference(*case, *reference), name(self.sensor))
            }
            _ => name(self.sensor),
        };
        match self.only {
            Some(case) => format!("{place} of {}", scene.cases[case].test.name),
            None => place,
        }
    }

    /// `sensor-sign@p11`, of one test alone `sensor-sign@p11 of bench test`.
    pub(super) fn id(&self, scene: &Scene) -> String {
        format!("{}@{}", self.name(), self.location(scene))
    }

    /// What it means for the engineer.
    pub(super) fn remedy(&self, scene: &Scene) -> String {
        let name = |i: usize| scene.test.sensors[i].name.as_str();
        let s = self.sensor;
        let what = match &self.change {
            Change::Sign => format!("turn the sign of sensor {} (it is upside down)", name(s)),
            Change::Swap(other) => format!("exchange the channels of sensors {} and {}", name(s), name(*other)),
            Change::Turned(other) => {
                format!("sensors {} and {} are turned in their plane: correct their directions", name(s), name(*other))
            }
            Change::Tilted(axis) => {
                format!("sensor {} is tilted towards {}: correct its direction", name(s), AXES[*axis])
            }
            Change::Gain => format!("correct the sensitivity of sensor {}", name(s)),
            Change::FunctionGain => format!("correct the calibration of the functions of sensor {}", name(s)),
            Change::Dead => format!("leave out sensor {}: it reads noise only", name(s)),
            Change::Noisy => format!("check sensor {}: it scatters more than stated", name(s)),
            Change::Axis(axis) => format!("sensor {} reads along {}", name(s), AXES[*axis]),
            Change::Position { name: place, .. } => match place.strip_prefix("mirrored ") {
                Some(axis) => format!("sensor {} sits on the other side of its node along {axis}", name(s)),
                None => format!("sensor {} sits at {place}", name(s)),
            },
            Change::DrivingPoint { case, reference } => {
                let stated = scene.reference(*case, *reference);
                format!("the force of the frequency responses acted at {}, not at {stated}", name(s))
            }
            Change::Order(a, b) => {
                format!("exchange the frequencies of {} and {}", scene.mode_name(*a), scene.mode_name(*b))
            }
            Change::Frequency(m) => format!("look up the frequency of {}", scene.mode_name(*m)),
        };
        match self.only {
            Some(case) => format!("in {}: {what}", scene.cases[case].test.name),
            None => what,
        }
    }

    /// The test as it would be without the fault. `number` is the gain, κ, an angle, or the factor on a frequency, which then counts no more.
    pub(super) fn apply(&self, test: &TestData, number: f64) -> TestData {
        let mut out = test.clone();
        let s = self.sensor;
        match &self.change {
            Change::Order(a, b) => {
                let f = out.modes[*a].frequency_hz;
                out.modes[*a].frequency_hz = out.modes[*b].frequency_hz;
                out.modes[*b].frequency_hz = f;
                return out;
            }
            Change::Frequency(m) => {
                let f = &mut out.modes[*m].frequency_hz;
                f.value /= number;
                f.sd *= LOOSE;
                return out;
            }
            Change::Axis(_) | Change::Position { .. } => out.sensors[s] = self.sensor(&test.sensors),
            Change::Turned(_) | Change::Tilted(_) => {
                let (sin, cos) = number.sin_cos();
                let (d, e) = (test.sensors[s].direction, self.sensor(&test.sensors).direction);
                out.sensors[s].direction = [0, 1, 2].map(|k| cos * d[k] + sin * e[k]);
                if let Change::Turned(other) = self.change {
                    out.sensors[other].direction = [0, 1, 2].map(|k| cos * e[k] - sin * d[k]);
                }
            }
            _ => {}
        }
        let corrections = self.corrections(test, number);
        out.frfs = out.frfs.take().map(|set| corrected_functions(set, &out.sensors, &corrections));
        if let (Change::DrivingPoint { reference, .. }, Some(set)) = (&self.change, &mut out.frfs) {
            let Sensor { name, direction, .. } = test.sensors[s].clone();
            set.references[*reference] = Channel { name, direction: Some(direction) };
        }
        out.corrections.extend(corrections);
        if self.is_of_functions_alone() || !self.changes_shapes() {
            return out;
        }
        for mode in &mut out.modes {
            let Some(shape) = &mut mode.shape else { continue };
            match &self.change {
                Change::Sign => shape[s] = -shape[s],
                Change::Swap(other) => {
                    shape.swap_rows(s, *other);
                    if let Some(sd) = &mut mode.shape_sd {
                        sd.swap_rows(s, *other);
                    }
                }
                Change::Gain => {
                    shape[s] /= number;
                    if let Some(sd) = &mut mode.shape_sd {
                        sd[s] /= number.abs();
                    }
                }
                Change::Dead => shape[s] = Complex::new(f64::NAN, f64::NAN),
                _ => {
                    if let Some(sd) = &mut mode.shape_sd {
                        sd[s] *= number;
                    }
                }
            }
        }
        out
    }
}

impl Fault {
    /// The sensor as it is in truth, for a wrong axis or place; one along the direction towards which it is turned or tilted.
    pub(super) fn sensor(&self, sensors: &[Sensor]) -> Sensor {
        let mut out = sensors[self.sensor].clone();
        match &self.change {
            Change::Axis(axis) => out.direction = GLOBAL[*axis],
            Change::Turned(other) => out.direction = sensors[*other].direction,
            Change::Tilted(axis) => out.direction = across(out.direction, *axis),
            Change::Position { place, offset, .. } => {
                out.place.clone_from(place);
                out.offset = *offset;
            }
            _ => {}
        }
        out
    }

    /// Whether it is about a sensor: its own, or one of two that are exchanged.
    pub(super) fn is_of_sensor(&self, sensor: usize) -> bool {
        match self.change {
            Change::Order(..) | Change::Frequency(_) | Change::DrivingPoint { .. } => false,
            Change::Swap(other) | Change::Turned(other) => self.sensor == sensor || other == sensor,
            _ => self.sensor == sensor,
        }
    }

    /// Its number where there is no fault.
    pub(super) fn neutral(&self) -> f64 {
        if self.is_angle() { 0.0 } else { 1.0 }
    }

    /// Whether its number is an angle.
    pub(super) fn is_angle(&self) -> bool {
        matches!(self.change, Change::Turned(_) | Change::Tilted(_))
    }

    /// Whether a number scales its readings.
    pub(super) fn is_gain(&self) -> bool {
        matches!(self.change, Change::Gain | Change::FunctionGain)
    }

    fn is_of_functions_alone(&self) -> bool {
        matches!(self.change, Change::FunctionGain | Change::DrivingPoint { .. })
    }

    fn changes_shapes(&self) -> bool {
        matches!(self.change, Change::Sign | Change::Swap(_) | Change::Gain | Change::Dead | Change::Noisy)
    }

    /// What has to be done to functions for it, those of the test and those that are read beside it.
    fn corrections(&self, test: &TestData, number: f64) -> Vec<Correction> {
        let name = |s: usize| test.sensors[s].name.clone();
        let of = |s: usize| Correction { sensor: name(s), ..Correction::default() };
        let turned = |s: usize| Correction { stated: Some(test.sensors[s].direction), ..of(s) };
        let s = self.sensor;
        match &self.change {
            Change::Sign => vec![Correction::factor(&name(s), -1.0)],
            Change::Gain | Change::FunctionGain => vec![Correction::factor(&name(s), number)],
            Change::Dead => vec![Correction { reads_nothing: true, ..of(s) }],
            Change::Swap(other) => vec![Correction { exchanged_with: Some(name(*other)), ..of(s) }],
            Change::Axis(_) | Change::Tilted(_) => vec![turned(s)],
            Change::Turned(other) => vec![turned(s), turned(*other)],
            Change::DrivingPoint { reference, .. } => {
                let stated =
                    test.frfs.as_ref().and_then(|set| channel_sensor(&set.references[*reference], &test.sensors));
                let one = |stated: Sensor| Correction {
                    sensor: stated.name,
                    acted_at: Some(name(s)),
                    ..Correction::default()
                };
                stated.map(one).into_iter().collect()
            }
            Change::Position { .. } | Change::Noisy | Change::Order(..) | Change::Frequency(_) => Vec::new(),
        }
    }
}

/// The response that is a sensor.
pub(super) fn response_of(set: &FrfSet, sensors: &[Sensor], sensor: usize) -> Option<usize> {
    let name = &sensors.get(sensor)?.name;
    set.responses.iter().position(|c| channel_sensor(c, sensors).is_some_and(|s| s.name == *name))
}

/// The direction nearest to a global axis that is perpendicular to a direction; itself along that axis, where there is none.
pub(super) fn across(direction: [f64; 3], axis: usize) -> [f64; 3] {
    unit(plus(GLOBAL[axis], -direction[axis], direction)).unwrap_or(direction)
}
