//! What every fault has to keep, built-in or not.

use super::{At, Bench, FAULTS, Faults, Number, PlacedFault, SingleTest, Tests};
use crate::data::{
    Channel, FrfFit, FrfQuantity, FrfSet, Joined, Measured, Origin, Place, Sensor, Standing, StaticReading, StaticTest,
    TestData, TestMode, joined,
};
use crate::linalg::{Complex, DVector};
use std::collections::BTreeSet;
use std::ops::Range;

/// A triaxial accelerometer, and single ones on arms.
fn sensors() -> Vec<Sensor> {
    let one = |name: &str, node: &str, direction: [f64; 3], offset: Option<[f64; 3]>| Sensor {
        name: name.to_string(),
        place: Place::Node { node: node.to_string(), position: None },
        direction,
        offset,
        is_rotation: false,
        mass: None,
    };
    vec![
        one("a.x", "n1", [1.0, 0.0, 0.0], None),
        one("a.y", "n1", [0.0, 1.0, 0.0], None),
        one("b", "n2", [0.0, 0.0, 1.0], Some([0.0, 0.1, 0.0])),
        one("c", "n3", [0.0, 0.0, 1.0], Some([0.0, -0.1, 0.0])),
    ]
}

const NODES: [(&str, [f64; 3]); 3] = [("n1", [0.0; 3]), ("n2", [1.0, 0.0, 0.0]), ("n3", [2.0, 0.0, 0.0])];

fn mode(k: usize, n: usize) -> TestMode {
    TestMode {
        label: None,
        frequency_hz: Measured { value: [3.0, 5.0, 7.0, 7.2][k], sd: 0.01, sd_is_default: false },
        damping_ratio: None,
        origin: Origin::Synthetic("for a test".to_string()),
        shape: Some(DVector::from_fn(n, |i, _| Complex::new((1.3 * (i + 1) as f64 + 2.1 * k as f64).sin(), 0.1))),
        shape_sd: Some(DVector::from_fn(n, |i, _| 0.01 * (i + 1) as f64)),
        shape_origin: None,
        components: Vec::new(),
        standing: Standing::Open,
        space: None,
    }
}

/// Four modes, the last two close, and functions of a force at the first sensor.
fn test(name: &str, sensors: Vec<Sensor>) -> TestData {
    let n = sensors.len();
    let channel = |s: &Sensor| Channel { name: s.name.clone(), direction: Some(s.direction) };
    let frequencies_hz = vec![1.0, 2.0, 3.0];
    let set = FrfSet {
        quantity: FrfQuantity::Accelerance,
        references: vec![channel(&sensors[0])],
        responses: sensors.iter().map(channel).collect(),
        h: (0..3 * n).map(|k| Complex::new(1.0 + k as f64, -0.5)).collect(),
        frequencies_hz,
        coherence: None,
        n_averages: None,
    };
    let reading = |sensor: usize| StaticReading {
        sensor,
        measured: Measured { value: 0.01 * (sensor + 1) as f64, sd: 1e-4, sd_is_default: false },
    };
    let pull = StaticTest {
        name: "pull".to_string(),
        loads: Vec::new(),
        readings: vec![reading(0), reading(2)],
        origin: Origin::Synthetic("for a test".to_string()),
    };
    TestData {
        static_tests: vec![pull],
        name: name.to_string(),
        modes: (0..4).map(|k| mode(k, n)).collect(),
        sensors,
        frfs: Some(set),
        frf_fit: Some(FrfFit { relative_sd: 0.05, ..FrfFit::default() }),
        ..TestData::default()
    }
}

fn bench(tests: &dyn Tests) -> Bench<'_> {
    let place = |s: &Sensor| {
        let Place::Node { node, .. } = &s.place else { unreachable!("all stand on nodes") };
        let at = NODES.iter().find(|(name, _)| name == node).unwrap().1;
        let offset = s.offset.unwrap_or_default();
        [0, 1, 2].map(|k| at[k] + offset[k])
    };
    let positions = Some(tests.all().sensors.iter().map(place).collect());
    Bench { tests, positions, nodes: NODES.iter().map(|(name, at)| ((*name).to_string(), *at)).collect() }
}

/// A number that is not a neutral one.
fn some(number: Number) -> f64 {
    match number {
        Number::None | Number::Silence => number.neutral(),
        Number::Angle { .. } | Number::Mixture => 0.2,
        _ => 1.5,
    }
}

#[test]
fn names_are_unique_and_words_are_said() {
    let names: BTreeSet<&str> = FAULTS.iter().map(|f| f.name()).collect();
    assert_eq!(names.len(), FAULTS.len());
    for fault in FAULTS {
        let is_kebab = fault.name().chars().all(|c| c.is_ascii_lowercase() || c == '-');
        assert!(is_kebab && fault.name().contains('-'), "{}", fault.name());
        let about = fault.about();
        assert!(about.summary.ends_with('.') && about.signature.ends_with('.'), "{}", fault.name());
    }
}

/// Every fault has a place in a full test, says what to do about it, and is read back from its id, of two in either order.
#[test]
fn every_fault_has_its_places_and_is_read_from_its_id() {
    let test = test("bench", sensors());
    let tests = SingleTest::new(&test);
    let bench = bench(&tests);
    let all = Faults::builtin();
    for fault in FAULTS {
        let placed = Faults::none().with(*fault).placed(&bench);
        assert!(!placed.is_empty(), "{}", fault.name());
        for p in &placed {
            let id = p.id(&tests);
            assert_eq!(PlacedFault::of_id(&id, &all, &bench).as_ref(), Ok(p), "{id}");
            assert!(!p.remedy(&tests).is_empty(), "{id}");
        }
    }
    let swapped = PlacedFault::of_id("sensor-swap@c+b", &all, &bench).unwrap();
    assert_eq!(swapped.at, At::Sensors(2, 3));
    let wrong = PlacedFault::of_id("sensor-swop@b+c", &all, &bench).unwrap_err().to_string();
    assert!(wrong.contains("did you mean `sensor-swap`?"), "{wrong}");
}

/// What has been put into a test is taken out of it: readings, deviations, frequencies, directions.
#[test]
fn a_fault_that_is_put_in_is_taken_out() {
    let clean = test("bench", sensors());
    let tests = SingleTest::new(&clean);
    for placed in Faults::builtin().placed(&bench(&tests)) {
        let (id, number) = (placed.id(&tests), some(placed.number()));
        let mut spoiled = clean.clone();
        placed.put_into(&mut spoiled, number);
        let mended = placed.taken_out_of(&spoiled, number);
        let silent = placed.number() == Number::Silence;
        let mut changes = spoiled != clean;
        for (m, (found, right)) in mended.modes.iter().zip(&clean.modes).enumerate() {
            let f = found.frequency_hz.value;
            assert!((f / right.frequency_hz.value - 1.0).abs() < 1e-12, "{id}: mode {m} at {f}");
            let (found, right) = (found.shape.as_ref().unwrap(), right.shape.as_ref().unwrap());
            let is_known = |s: &usize| !(silent && placed.is_of_channel(*s));
            for s in (0..right.len()).filter(is_known) {
                assert!((found[s] - right[s]).norm() < 1e-12, "{id}: mode {m}, sensor {s}");
            }
        }
        for (found, right) in mended.static_tests.iter().zip(&clean.static_tests) {
            for (found, right) in found.readings.iter().zip(&right.readings) {
                assert!((found.measured.value / right.measured.value - 1.0).abs() < 1e-12, "{id}");
            }
        }
        let there = placed.sensors_in_truth(&clean.sensors, number);
        changes |= there != clean.sensors || mended.frfs != clean.frfs;
        // One that is in the noise changes no reading.
        assert!(changes || matches!(placed.number(), Number::Scatter | Number::Mixture), "{id} changes nothing");
        if let Number::Angle { .. } = placed.number() {
            let back = placed.sensors_in_truth(&there, -number);
            for (found, right) in back.iter().zip(&clean.sensors) {
                let error = (0..3).map(|k| (found.direction[k] - right.direction[k]).abs()).fold(0.0, f64::max);
                assert!(error < 1e-12, "{id}: {error}");
            }
        }
    }
}

/// Tests of one structure, joined.
struct Several {
    each: Vec<TestData>,
    joined: Joined,
}

impl Tests for Several {
    fn all(&self) -> &TestData {
        &self.joined.test
    }

    fn count(&self) -> usize {
        self.each.len()
    }

    fn test(&self, test: usize) -> &TestData {
        &self.each[test]
    }

    fn modes_of(&self, test: usize) -> Range<usize> {
        let first = self.joined.first_mode[test];
        first..first + self.each[test].modes.len()
    }

    fn sensors_of(&self, test: usize) -> &[usize] {
        &self.joined.sensors[test]
    }
}

/// A sensor of two tests may be wrong in both or in one of them; a fault of a mode is of its test, in the numbers of that test.
#[test]
fn faults_of_several_tests_stay_with_their_tests() {
    let mut own = sensors();
    own.remove(0);
    own.push(Sensor { name: "d".to_string(), ..sensors()[2].clone() });
    let each = vec![test("first", sensors()), test("second", own)];
    let joined = joined(&each.iter().collect::<Vec<_>>());
    let several = Several { each, joined };
    let all = Faults::builtin().placed(&bench(&several));
    let ids: BTreeSet<String> = all.iter().map(|p| p.id(&several)).collect();
    assert_eq!(ids.len(), all.len(), "each is there once");
    for id in ["sensor-sign@b", "sensor-sign@b of first", "sensor-sign@b of second", "sensor-sign@d"] {
        assert!(ids.contains(id), "{id}: {ids:?}");
    }
    // The first sensor is in one test alone, and the two at the ends of the list are in none together.
    assert!(!ids.contains("sensor-sign@a.x of first") && !ids.contains("sensor-swap@a.x+d"));
    for placed in &all {
        let within: Vec<PlacedFault> = (0..2).filter_map(|k| placed.within(&several, k)).collect();
        assert!(!within.is_empty(), "{}", placed.id(&several));
        for (k, inner) in (0..2).filter_map(|k| Some((k, placed.within(&several, k)?))) {
            let test = several.test(k);
            assert!(inner.at.sensors().iter().all(|s| *s < test.sensors.len()), "{}", placed.id(&several));
            assert!(inner.at.modes().iter().all(|m| *m < test.modes.len()), "{}", placed.id(&several));
        }
    }
    let misread = all.iter().find(|p| p.id(&several) == "mode-frequency@mode 2 of second").unwrap();
    assert_eq!((misread.at.clone(), misread.within(&several, 1).unwrap().at), (At::Mode(5), At::Mode(1)));
    assert_eq!(misread.within(&several, 0), None);
}
