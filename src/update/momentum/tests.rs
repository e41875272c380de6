//! Planted faults of sensors on free structures are found without a fit, and healthy tests stay quiet.

use super::*;
use crate::data::read_test;
use crate::model::{Registry, load};
use crate::update::{TwinFault, TwinOptions, node_sensors, twin_modes};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn text(file: &str) -> String {
    std::fs::read_to_string(format!("{}/models/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn model(file: &str) -> Model {
    load(&text(file), &Registry::builtin()).unwrap_or_else(|e| panic!("{e:?}")).0
}

/// A free model with the sensors of a plausible test: those of its test file, or one per node along the axes that move.
fn structure(kind: usize) -> (Model, Vec<Sensor>) {
    match kind {
        0 => (model("bff.yaml"), read_test(&text("bff_gvt.yaml")).unwrap().0.sensors),
        1 => {
            let m = model("garteur.yaml");
            let is_used = |s: &Sensor| s.name.ends_with("uz") || (s.name.starts_with('f') && s.name.ends_with("uy"));
            let sensors = node_sensors(&m).into_iter().filter(is_used).collect();
            (m, sensors)
        }
        _ => {
            let m = model("free_beam.yaml");
            let sensors = node_sensors(&m).into_iter().filter(|s| !s.name.ends_with("ux")).collect();
            (m, sensors)
        }
    }
}

/// The shapes of a truth whose free parameters are drawn within ±15 % (and the bounds), with 2 % noise and 0.2 % of the frequencies.
fn measured(m: &Model, sensors: &[Sensor], faults: Vec<TwinFault>, seed: u64) -> Vec<TestMode> {
    measured_of(m, 0.15, sensors, faults, seed)
}

/// The same with another spread of the parameters.
fn measured_of(m: &Model, spread: f64, sensors: &[Sensor], faults: Vec<TwinFault>, seed: u64) -> Vec<TestMode> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let theta: Vec<f64> = m
        .parameters()
        .nominal()
        .iter()
        .zip(m.parameters().iter())
        .map(|(v, p)| {
            let drawn = v * (1.0 + spread * rng.random_range(-1.0..1.0));
            p.bounds.map_or(*v, |[low, high]| drawn.clamp(low, high))
        })
        .collect();
    let options =
        TwinOptions { n_modes: 6, shape_noise: 0.02, frequency_noise: 0.002, faults, seed, ..TwinOptions::default() };
    twin_modes(m, &theta, sensors, &options, "test").unwrap().modes
}

fn check(m: &Model, sensors: &[Sensor], modes: &[TestMode]) -> SensorCheck {
    check_sensors_by_model(m, &m.parameters().nominal(), sensors, modes, 0).unwrap()
}

/// Counts over seeds: faults named, faults at sensors that the check says it cannot decide, wrong accusations.
#[derive(Debug, Default)]
struct Count {
    named: u32,
    undecided: u32,
    wrong: u32,
    momentum: u32,
}

fn study(kind: usize, fault: &str, seeds: std::ops::Range<u64>) -> Count {
    let (m, sensors) = structure(kind);
    let mut count = Count::default();
    for seed in seeds {
        let mut rng = ChaCha8Rng::seed_from_u64(7000 + seed);
        let (a, b) = (rng.random_range(0..sensors.len()), rng.random_range(0..sensors.len()));
        let name = |k: usize| sensors[k].name.clone();
        if fault == "swap" && a == b {
            continue;
        }
        let (faults, touched) = match fault {
            "sign" => (vec![TwinFault::new(&format!("sensor-sign@{}", name(a)))], vec![a]),
            "swap" => (vec![TwinFault::new(&format!("sensor-swap@{}+{}", name(a), name(b)))], vec![a, b]),
            "dead" => (vec![TwinFault::new(&format!("sensor-dead@{}", name(a)))], vec![a]),
            _ => (Vec::new(), Vec::new()),
        };
        let spread = if fault == "exact" { 0.0 } else { 0.15 };
        let found = check(&m, &sensors, &measured_of(&m, spread, &sensors, faults, seed));
        let said: Vec<usize> = found.changes.iter().flat_map(|(c, _)| c.touches()).collect();
        let is_named = !touched.is_empty() && touched.iter().all(|k| said.contains(k));
        count.named += u32::from(is_named);
        count.undecided += u32::from(!is_named && touched.iter().any(|k| found.undecided.contains(k)));
        count.wrong += u32::from(said.iter().any(|k| !touched.contains(k)));
        count.momentum += u32::from(found.chance[0] < MOMENTUM_LEVEL);
    }
    count
}

/// Ten seeds for each structure and fault; with `RETUNE_SLOW=1` 200, the table of docs/identification.md.
#[test]
fn planted_faults_on_free_structures_are_named() {
    let n = crate::tests::seeds(10, 200);
    for (kind, name) in ["bff", "garteur", "free_beam"].iter().enumerate() {
        for fault in ["exact", "none", "sign", "swap", "dead"] {
            let count = study(kind, fault, 0..n);
            eprintln!("{name} {fault}: {count:?} of {n}");
            let share = |c: u32| f64::from(c) / n as f64;
            match fault {
                // Momentum is against the masses of the model: where these are right, there is none.
                "exact" => assert!(share(count.wrong) <= 0.02 && share(count.momentum) <= 0.02, "{name}: {count:?}"),
                "sign" => {
                    assert!(
                        share(count.named + count.undecided) >= 0.8 && share(count.wrong) <= 0.1,
                        "{name}: {count:?}"
                    );
                }
                _ => assert!(share(count.wrong) <= 0.1, "{name} {fault}: {count:?}"),
            }
        }
    }
}

/// A mass that the model lacks at a sensor's node moves the shape there, and no sensor is accused of it.
#[test]
fn a_mass_that_the_model_lacks_accuses_no_sensor() {
    let n = crate::tests::seeds(12, 100);
    for (file, kind, mass) in [("garteur.yaml", 1, 1.5), ("free_beam.yaml", 2, 0.25), ("frame.yaml", 3, 6.0)] {
        let (m, sensors) = if kind < 3 { structure(kind) } else { (model(file), node_sensors(&model(file))) };
        let mut wrong = Vec::new();
        for seed in 0..n {
            let mut rng = ChaCha8Rng::seed_from_u64(9000 + seed);
            let at = &sensors[rng.random_range(0..sensors.len())];
            let Place::Node { node, .. } = &at.place else { panic!("sensors of nodes") };
            let heavier =
                text(file).replace("\nmasses:\n", &format!("\nmasses:\n  hidden: {{node: {node}, mass: {mass} kg}}\n"));
            let truth = load(&heavier, &Registry::builtin()).unwrap_or_else(|e| panic!("{e:?}")).0;
            let modes = measured_of(&truth, 0.05, &sensors, Vec::new(), seed);
            let found = check(&m, &sensors, &modes);
            if !found.contradicted().is_empty() {
                wrong.push((node.clone(), found.findings[0].text.clone()));
            }
        }
        eprintln!("{file}: {} of {n}: {wrong:?}", wrong.len());
        assert!(wrong.len() as f64 <= 0.05 * n as f64, "{file}: {wrong:?}");
    }
}

/// The momentum of an exact elastic shape is zero, and a sensor turned over gives it one.
#[test]
fn an_elastic_shape_has_no_momentum() {
    let (m, sensors) = structure(2);
    let exact = |faults: Vec<TwinFault>| {
        let options = TwinOptions { n_modes: 5, faults, ..TwinOptions::default() };
        twin_modes(&m, &m.parameters().nominal(), &sensors, &options, "test").unwrap().modes
    };
    let clean = check(&m, &sensors, &exact(Vec::new()));
    assert_eq!(clean.momentum.len(), 5);
    assert!(clean.changes.is_empty() && clean.chance[0] > 0.5, "{clean:?}");
    assert!(clean.momentum.iter().all(|s| s.share < 1e-6), "{:?}", clean.momentum);
    let tip = sensors.iter().find(|s| s.name.starts_with("b4") && s.name.ends_with("uz")).unwrap();
    let turned = check(&m, &sensors, &exact(vec![TwinFault::new(&format!("sensor-sign@{}", tip.name))]));
    assert_eq!(turned.findings[0].code, "sensor-sign");
    assert_eq!(turned.findings[0].subject, tip.name);
    assert!(turned.chance[0] < 1e-6 && turned.chance[1] > 0.5, "{:?}", turned.chance);
}

/// All sensors of one wing turned over, as by a cable loom: one group, one finding.
#[test]
fn a_body_turned_over_is_one_fault() {
    let (m, sensors) = structure(2);
    let on_right: Vec<&Sensor> = sensors.iter().filter(|s| s.name.starts_with('b')).collect();
    let faults = on_right.iter().map(|s| TwinFault::new(&format!("sensor-sign@{}", s.name))).collect();
    let found = check(&m, &sensors, &measured(&m, &sensors, faults, 5));
    let codes: Vec<&str> = found.findings.iter().map(|f| f.code).collect();
    assert_eq!(codes.first(), Some(&"group-flipped"), "{:?}", found.findings);
}

/// A supported structure has no momentum to conserve, and its sensors are judged all the same.
#[test]
fn sensors_of_a_supported_structure_are_judged_too() {
    let m = model("frame.yaml");
    let sensors = node_sensors(&m);
    let modes = measured(&m, &sensors, vec![TwinFault::new(&format!("sensor-sign@{}", sensors[3].name))], 3);
    let found = check(&m, &sensors, &modes);
    assert!(found.momentum.is_empty());
    assert_eq!(found.findings[0].subject, sensors[3].name, "{:?}", found.findings);
}

/// Entries that were not measured, shapes of nothing, a shape that is not of the structure: no accusation.
#[test]
fn gaps_and_foreign_shapes_accuse_nobody() {
    let (m, sensors) = structure(2);
    let mut modes = measured(&m, &sensors, Vec::new(), 11);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for mode in &mut modes {
        let shape = mode.shape.as_mut().unwrap();
        shape[rng.random_range(0..sensors.len())].re = f64::NAN;
    }
    let mut foreign = modes[0].clone();
    foreign.frequency_hz.value *= 1.3;
    foreign.shape =
        Some(DVector::from_fn(sensors.len(), |_, _| crate::linalg::Complex::new(rng.random_range(-1.0..1.0), 0.0)));
    modes.insert(1, foreign);
    let found = check(&m, &sensors, &modes);
    assert!(found.changes.is_empty(), "{:?}", found.findings);
    assert_eq!(found.foreign, [1]);
    for mode in &mut modes {
        mode.shape = Some(DVector::from_element(sensors.len(), crate::linalg::Complex::new(0.0, 0.0)));
    }
    assert!(check(&m, &sensors, &modes).momentum.is_empty());
}
