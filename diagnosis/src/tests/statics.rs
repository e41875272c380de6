//! Deflections alone, and beside modes in another test: a cantilever and a portal whose feet give.

use super::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune::data::StaticReading;
use retune::fault::{Bench, Faults, PlacedFault, SingleTest};
use retune::objective::{Comparison, static_readings};
use retune::optim::Draw;
use retune::update::{Controls, TestCase, update, update_to_tests};

const CANTILEVER: &str = "
retune: 1
name: cantilever
active_dofs: [uz, ry]
parameters:
  E: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}
nodes: {n0: [0, 0, 0], n1: [0.25 m, 0, 0], n2: [0.5 m, 0, 0], n3: [0.75 m, 0, 0], n4: [1 m, 0, 0]}
sections:
  s: {E: E, density: 2700 kg/m3, shape: {rectangle: {width: 40 mm, height: 10 mm}}}
beams: {ab: {chain: [n0, n1, n2, n3, n4], section: s, subdivide: 2}}
supports: {c: {node: n0}}
";

const ON_CANTILEVER: &str = "
retune_test: 1
name: bench
sources: {a: {kind: synthetic, text: a twin}}
sensors:
  s1: {node: n1, direction: +z}
  s2: {node: n2, direction: +z}
  s3: {node: n3, direction: +z}
  s4: {node: n4, direction: +z}
static_tests:
  end: {source: a, loads: [{sensor: s4, force: 5 N}], readings: {s1: {value: 1 mm}, s2: {value: 1 mm}, s3: {value: 1 mm}, s4: {value: 1 mm}}}
  middle: {source: a, loads: [{sensor: s2, force: 9 N}], readings: {s1: {value: 1 mm}, s2: {value: 1 mm}, s3: {value: 1 mm}, s4: {value: 1 mm}}}
";

const PORTAL: &str = "
retune: 1
name: portal
active_dofs: [ux, uz, ry]
parameters:
  E: {value: 200 GPa, bounds: [150 GPa, 250 GPa]}
nodes: {a: [0, 0, 0], b: [0, 0, 1 m], c: [0, 0, 2 m], d: [1.5 m, 0, 2 m], e: [3 m, 0, 2 m], f: [3 m, 0, 1 m], g: [3 m, 0, 0]}
sections:
  s: {E: E, density: 7800 kg/m3, shape: {rectangle: {width: 60 mm, height: 20 mm}}}
beams:
  left: {chain: [a, b, c], section: s, subdivide: 2}
  top: {chain: [c, d, e], section: s, subdivide: 2}
  right: {chain: [e, f, g], section: s, subdivide: 2}
supports: {foot_a: {node: a}, foot_g: {node: g}}
";

const ON_PORTAL: &str = "
retune_test: 1
name: bench
sources: {a: {kind: synthetic, text: a twin}}
sensors:
  bx: {node: b, direction: +x}
  cx: {node: c, direction: +x}
  dz: {node: d, direction: +z}
  ex: {node: e, direction: +x}
  fx: {node: f, direction: +x}
static_tests:
  sway: {source: a, loads: [{sensor: cx, force: 40 N}], readings: {bx: {value: 1 mm}, cx: {value: 1 mm}, dz: {value: 1 mm}, ex: {value: 1 mm}, fx: {value: 1 mm}}}
  weight: {source: a, loads: [{sensor: dz, weight: 10 kg}], readings: {bx: {value: 1 mm}, cx: {value: 1 mm}, dz: {value: 1 mm}, ex: {value: 1 mm}, fx: {value: 1 mm}}}
  push: {source: a, loads: [{sensor: bx, force: 60 N}], readings: {bx: {value: 1 mm}, cx: {value: 1 mm}, dz: {value: 1 mm}, ex: {value: 1 mm}, fx: {value: 1 mm}}}
";

/// The readings that a truth gives, with noise of 0.5 % of the largest of their static test.
fn bench(truth: &Model, text: &str, seed: u64) -> TestData {
    let mut test = read_test(text).unwrap_or_else(|p| panic!("{p:?}")).0;
    let pairing = retune::correlation::PairingOptions::default();
    let comparison = Comparison::new(truth, &test, pairing).unwrap();
    let prediction = comparison.predict(&truth.parameters().nominal()).unwrap();
    let mut values = static_readings(&comparison, &prediction).into_iter();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    drop(comparison);
    for t in &mut test.static_tests {
        let own: Vec<f64> = values.by_ref().take(t.readings.len()).collect();
        let sd = 0.005 * own.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for (r, value) in t.readings.iter_mut().zip(own) {
            let StaticReading { measured, .. } = r;
            (measured.value, measured.sd, measured.sd_is_default) = (value + sd * rng.normal(), sd, false);
        }
    }
    test
}

/// E alone, from deflections alone: within its interval of what the twin was made with.
#[test]
fn deflections_alone_give_the_modulus() {
    for (base, text, right) in [(CANTILEVER, ON_CANTILEVER, 64.0), (PORTAL, ON_PORTAL, 215.0)] {
        let from = if right < 100.0 { "E: {value: 70 GPa" } else { "E: {value: 200 GPa" };
        let truth = model(&base.replace(from, &format!("E: {{value: {right} GPa")));
        let test = bench(&truth, text, 1);
        let u = update(&model(base), &test, &retune::update::Settings::default(), Controls::default()).unwrap();
        let known = &u.uncertainty.parameters[0];
        let sd = known.sd.unwrap();
        assert!(
            (u.parameters[0].after - right).abs() < 3.0 * sd && sd < 0.01 * right,
            "{} ± {sd}",
            u.parameters[0].after
        );
        let d = diagnose(&model(base), &test, &Settings::default()).unwrap();
        assert_eq!(d.verdict, Verdict::Adequate, "{}", d.sentence);
    }
}

/// A root that gives: its rotation bends nothing, so that no change of E along the beam imitates it.
#[test]
fn a_soft_root_is_found_from_deflections_alone() {
    let soft = CANTILEVER.replace("{node: n0}", "{node: n0, compliance: {ry: 1.2e-3 rad/(N m)}}");
    let d = diagnose(&model(CANTILEVER), &bench(&model(&soft), ON_CANTILEVER, 2), &Settings::default()).unwrap();
    is_root(&d, "n0", 1.2e-3);
    let learned =
        learn(&model(CANTILEVER), &bench(&model(&soft), ON_CANTILEVER, 2), &Settings::default(), true, 2).unwrap();
    assert_eq!(learned.effects.len(), 1, "{:?}", learned.effects);
    assert_eq!(learned.steps.last().unwrap().diagnosis.verdict, Verdict::Adequate);
}

/// One foot of a portal gives: from deflections alone, and from deflections beside frequencies and shapes of another test.
#[test]
fn a_soft_foot_is_found_from_deflections_with_and_without_modes() {
    let soft = PORTAL.replace("foot_g: {node: g}", "foot_g: {node: g, compliance: {ry: 1e-3 rad/(N m)}}");
    let (truth, base) = (model(&soft), model(PORTAL));
    let test = bench(&truth, ON_PORTAL, 3);
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    is_root(&d, "g", 1e-3);
    let sensors = retune::update::node_sensors(&base);
    let modal = twin_modes(&truth, &truth.parameters().nominal(), &sensors, &noise(4, 4), "twin").unwrap();
    let both = diagnose_tests(&base, &[&modal, &test], &Settings::default()).unwrap();
    is_root(&both, "g", 1e-3);
    let cases = [TestCase { model: &base, test: &modal }, TestCase { model: &base, test: &test }];
    let u = update_to_tests(&cases, &retune::update::Settings::default(), Controls::default()).unwrap();
    assert_eq!((u.further[0].after.readings.len(), u.after.pairs.len()), (15, 4));
}

fn is_root(d: &Diagnosis, node: &str, right: f64) {
    let first = &d.hypotheses[0];
    eprintln!("{}: {} {:?} {:?} tied {:?}", d.sentence, first.id, first.estimate, first.interval, first.tied_with);
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert!(first.name == "root-flexibility" && first.id.contains(node), "{}", first.id);
    let [low, high] = first.interval.unwrap();
    assert!(low < right && right < high, "{low} {high}");
}

/// What nothing explains is named by its readings.
#[test]
fn what_remains_names_the_readings() {
    let truth = model(CANTILEVER);
    let mut test = bench(&truth, ON_CANTILEVER, 5);
    for (of, reading, factor) in [(1, 0, -4.0), (1, 2, 0.5), (0, 1, 1.7)] {
        test.static_tests[of].readings[reading].measured.value *= factor;
    }
    let d = diagnose(&truth, &test, &Settings::default()).unwrap();
    assert_ne!(d.verdict, Verdict::Adequate);
    assert!(d.remainder.contains("static deflection at s3 in middle"), "{}", d.remainder);
}

/// One dial of another scale, or one load of another weight: named with its factor, and the modulus is right without it.
#[test]
fn a_wrong_reading_and_a_wrong_load_are_found() {
    let truth = model(CANTILEVER);
    for (id, factor) in
        [("static-reading@middle:s1", 1.4), ("static-reading@end:s4", -1.0), ("static-load@middle", 0.8)]
    {
        let mut test = bench(&truth, ON_CANTILEVER, 6);
        let tests = SingleTest::new(&test);
        let fault =
            PlacedFault::of_id(id, &Faults::builtin(), &Bench { tests: &tests, positions: None, nodes: Vec::new() });
        let fault = fault.unwrap();
        fault.put_into(&mut test, factor);
        let d = diagnose(&truth, &test, &Settings::default()).unwrap();
        assert_eq!(d.verdict, Verdict::MeasurementFault, "{id}: {}", d.sentence);
        let first = &d.hypotheses[0];
        assert_eq!(first.id, id, "{}", d.sentence);
        let [low, high] = first.interval.unwrap();
        assert!(low < factor && factor < high && high - low < 0.2, "{id}: {low} {high}");
    }
}
