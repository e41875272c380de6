//! Several tests of one structure as one list of modes and one list of sensors.

use super::{Sensor, TestData, TestMode};
use retune_linalg::{Complex, DVector};

/// Several tests as one.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// Modes one test after the other, shapes not measured at the sensors of the others. Of a single test it is the test without
    /// frequency responses, mass properties and static tests.
    pub test: TestData,
    /// Of each test, the number of its first mode.
    pub first_mode: Vec<usize>,
    /// Of each test, the numbers of its sensors.
    pub sensors: Vec<Vec<usize>>,
}

/// Joins tests: a sensor of the same name, place and direction in several tests is one sensor.
///
/// Of several tests, modes are called `label, test`, and a sensor whose name means another sensor in an earlier test
/// `name(test)`.
pub fn joined(tests: &[&TestData]) -> Joined {
    let several = tests.len() > 1;
    let mut all: Vec<Sensor> = Vec::new();
    let mut sensors = Vec::with_capacity(tests.len());
    for (k, test) in tests.iter().enumerate() {
        let before = if k == 0 { 0 } else { all.len() };
        let number = |sensor: &Sensor, all: &mut Vec<Sensor>| {
            if let Some(same) = all[..before].iter().position(|s| s == sensor) {
                return same;
            }
            let mut own = sensor.clone();
            if several && all.iter().any(|s| s.name == own.name) {
                own.name = format!("{}({})", own.name, test.name);
            }
            all.push(own);
            all.len() - 1
        };
        sensors.push(test.sensors.iter().map(|s| number(s, &mut all)).collect::<Vec<usize>>());
    }
    let mut modes = Vec::new();
    let mut first_mode = Vec::with_capacity(tests.len());
    for (test, at) in tests.iter().zip(&sensors) {
        first_mode.push(modes.len());
        for (k, mode) in test.modes.iter().enumerate() {
            let mut own: TestMode = mode.clone();
            if several {
                let label = mode.label.clone().unwrap_or_else(|| (k + 1).to_string());
                own.label = Some(format!("{label}, {}", test.name));
                own.components = mode.components.iter().filter_map(|c| c.renumbered(|k| Some(at[k]))).collect();
                own.shape = mode.shape.as_ref().map(|shape| {
                    let mut wide = DVector::from_element(all.len(), Complex::new(f64::NAN, f64::NAN));
                    at.iter().enumerate().for_each(|(i, &s)| wide[s] = shape[i]);
                    wide
                });
                own.shape_sd = mode.shape_sd.as_ref().map(|sd| {
                    let mut wide = DVector::from_element(all.len(), 1.0);
                    at.iter().enumerate().for_each(|(i, &s)| wide[s] = sd[i]);
                    wide
                });
            }
            modes.push(own);
        }
    }
    let name = tests.iter().map(|t| t.name.as_str()).collect::<Vec<_>>().join(" + ");
    let date = tests.iter().filter_map(|t| t.date).min();
    Joined { test: TestData { name, date, sensors: all, modes, ..TestData::default() }, first_mode, sensors }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::read_test;

    fn test(name: &str, sensors: &str, shape: &str) -> TestData {
        let text = format!(
            "retune_test: 1\nname: {name}\nsources: {{s: {{kind: synthetic, text: made up}}}}\n\
             sensors: {sensors}\nmodes:\n  - {{frequency: 3 Hz, shape: {{source: s, real: {shape}}}, source: s}}\n"
        );
        read_test(&text).unwrap().0
    }

    #[test]
    fn one_test_stays_itself() {
        let a = test("a", "{p1: {node: n1, direction: +z}, p2: {node: n1, direction: +z}}", "[1, 2]");
        let j = joined(&[&a]);
        assert_eq!((j.test.sensors, j.test.modes), (a.sensors.clone(), a.modes.clone()));
        assert_eq!(j.sensors, [[0, 1]]);
    }

    #[test]
    fn the_same_sensor_is_one_and_another_of_its_name_gets_a_longer_name() {
        let a = test("a", "{p1: {node: n1, direction: +z}, p2: {node: n2, direction: +z}}", "[1, 2]");
        let b = test("b", "{p2: {node: n2, direction: +z}, p1: {node: n1, direction: +x}}", "[3, 4]");
        let j = joined(&[&a, &b]);
        assert_eq!(j.sensors, [vec![0, 1], vec![1, 2]]);
        assert_eq!(j.test.sensors[2].name, "p1(b)");
        assert_eq!(j.first_mode, [0, 1]);
        let shape = j.test.modes[1].shape.as_ref().unwrap();
        assert!(shape[0].re.is_nan());
        assert_eq!((shape[1].re, shape[2].re), (3.0, 4.0));
    }
}
