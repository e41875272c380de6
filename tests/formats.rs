//! Files that a version of retune read are read by every later one, with the same meaning.
//!
//! `formats/1` holds files of version 1 of the formats as retune 0.1.0 read them. They are never changed: a change of a format that they do not
//! survive is a new version of it, with a step that makes new files of old ones, and a folder of its own here.

use retune::correlation::parse_profiles;
use retune::data::{read_test, write_test};
use retune::modal::SolveOptions;
use retune::model::{ParametricModel, Registry, load, load_configuration, solve_modes};
use retune::update::ObjectiveSpec;
use std::fs;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/1")
}

fn text(name: &str) -> String {
    fs::read_to_string(folder().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// `frequencies.txt` has a line for each model and configuration: its elastic frequencies in Hz, as 0.1.0 computed them.
#[test]
fn snapshot_models_of_version_1_keep_their_frequencies() {
    let mut n = 0;
    for line in text("frequencies.txt").lines().filter(|l| !l.starts_with('#')) {
        let mut words = line.split_whitespace();
        let (file, configuration) = (words.next().unwrap(), words.next().unwrap());
        let expected: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
        let loaded = match configuration {
            "-" => load(&text(file), &Registry::builtin()),
            name => load_configuration(&text(file), Some(name), &Registry::builtin()),
        };
        let (model, warnings, _) = loaded.unwrap_or_else(|p| panic!("{line}: {p:?}"));
        // A configuration may take away what a parameter is about.
        assert!(configuration != "-" || warnings.is_empty(), "{line}: {warnings:?}");
        let options = SolveOptions { n_elastic: expected.len(), shift: None };
        let modes = solve_modes(&model, &model.parameters().nominal(), options).unwrap();
        for (i, f) in expected.iter().enumerate() {
            let found = modes.frequencies_hz()[modes.n_rigid + i];
            assert!((found / f - 1.0).abs() < 1e-6, "{file}, {configuration}, mode {}: {found} Hz, not {f}", i + 1);
        }
        n += expected.len();
    }
    assert!(n >= 20, "only {n} frequencies");
}

/// Every number of a test comes back, modes by ascending frequency, also through the file that this version writes.
#[test]
fn tests_of_version_1_are_read_and_written() {
    for (file, n_sensors, n_modes, first_hz) in
        [("bridge_test.yaml", 4, 2, 4.7), ("aircraft_test.yaml", 14, 8, 5.83937), ("frame_test.yaml", 9, 6, 2.80809)]
    {
        let (data, _) = read_test(&text(file)).unwrap_or_else(|p| panic!("{file}: {p:?}"));
        assert_eq!((data.sensors.len(), data.modes.len()), (n_sensors, n_modes), "{file}");
        assert!((data.modes[0].frequency_hz.value - first_hz).abs() < 1e-12, "{file}");
        let (again, _) = read_test(&write_test(&data)).unwrap();
        assert_eq!(write_test(&again), write_test(&data), "{file}");
    }
}

#[test]
fn objectives_and_profiles_of_version_1_are_read() {
    let objective = ObjectiveSpec::read(&text("objective.yaml")).unwrap();
    assert_eq!(objective.terms.len(), 2);
    let profiles = parse_profiles(&text("profiles.yaml")).unwrap();
    assert!(profiles.len() >= 3 && profiles[0].name == "common-practice");
}
