//! Stories on the flying wing, whose hidden effects are known: nothing missing, an effect, a fault.

use super::*;
use crate::data::{Sensor, read_test};
use crate::model::{ParametricModel, Registry, load};
use crate::update::{TwinOptions, twin_modes};

/// Properties of the real aircraft that a twin need not have.
fn without_targets(text: &str) -> String {
    text[..text.find("\ntargets:").unwrap()].to_string() + "\n"
}

fn wing() -> String {
    without_targets(include_str!("../../models/bff.yaml"))
}

fn model(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap().0
}

fn sensors() -> Vec<Sensor> {
    read_test(include_str!("../../models/bff_gvt.yaml")).unwrap().0.sensors
}

/// A little off the middle of every interval, where no bound interferes.
fn middle(model: &Model) -> Vec<f64> {
    let share = |i: usize| 0.4 + 0.2 * ((7 * i) % 10) as f64 / 9.0;
    model
        .parameters()
        .iter()
        .enumerate()
        .map(|(i, p)| p.bounds.map_or(p.value, |[l, u]| l + share(i) * (u - l)))
        .collect()
}

/// The wing with an edit of its text, on a mesh three times as fine.
fn truth(edits: &[(&str, &str)]) -> Model {
    let mut text = wing().replace("section: wing}", "section: wing, subdivide: 3}");
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    // Sensors name elements of the coarse mesh; those of the fine one keep the names of the file.
    model(&text)
}

/// A synthetic test of the truth: six modes with 0.3 % noise of frequencies and 2 % of shapes, without names.
fn measured(truth: &Model, seed: u64) -> TestData {
    let options = TwinOptions {
        n_modes: 6,
        damping: 0.0,
        frequency_noise: 0.003,
        shape_noise: 0.02,
        seed,
        ..TwinOptions::default()
    };
    let mut test = twin_modes(truth, &middle(truth), &sensors(), &options, "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    test
}

fn story(name: &str, truth: &Model, spoil: impl Fn(&mut TestData), seed: u64) -> Diagnosis {
    let base = model(&wing());
    let mut test = measured(truth, seed);
    spoil(&mut test);
    let start = std::time::Instant::now();
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    eprintln!(
        "{name}: {:?} in {:.1} s, p {:.4}, misfit {:.0} for {:.0}, none {:.3}, other {:.3}, {} effects ({} visible), {} faults, noise {:.2}",
        d.verdict,
        start.elapsed().as_secs_f64(),
        d.p_value,
        d.misfit,
        d.degrees_of_freedom,
        d.probability_none,
        d.probability_other,
        d.screened_effects,
        d.visible_effects,
        d.screened_faults,
        d.noise_factor,
    );
    eprintln!("  {}", d.sentence);
    for h in d.hypotheses.iter().take(6) {
        eprintln!(
            "  {:50} p {:.3} lnB {:7.1} misfit {:.0} held out {:.0} -> {:.0} estimate {:?} {:?} ties {}",
            h.id,
            h.probability,
            h.ln_bayes,
            h.misfit_after,
            h.held_out_before,
            h.held_out_after,
            h.estimate,
            h.interval,
            h.tied_with.len()
        );
    }
    for n in d.next_measurements.iter().take(2) {
        eprintln!("  next: {} ({:.1})", n.what, n.expected_ln_bayes);
    }
    d
}

#[test]
fn nothing_is_missing() {
    let d = story("null", &truth(&[]), |_| {}, 1);
    assert_eq!(d.verdict, Verdict::Adequate);
    assert!(d.probability_none > 0.5);
}

#[test]
fn a_mass_offset_behind_the_spar_is_found() {
    let edits = [
        ("inertia: {yy: Ix5_10}}", "inertia: {yy: Ix5_10}, offset: [0.05 m, 0 m, 0 m]}"),
        ("inertia: {yy: Ix6_11}}", "inertia: {yy: Ix6_11}, offset: [0.05 m, 0 m, 0 m]}"),
        ("inertia: {yy: Ix7_12}}", "inertia: {yy: Ix7_12}, offset: [0.05 m, 0 m, 0 m]}"),
        ("inertia: {yy: Ix8_13}}", "inertia: {yy: Ix8_13}, offset: [0.08 m, 0 m, 0 m]}"),
    ];
    let d = story("mass offset", &truth(&edits), |_| {}, 2);
    assert_eq!(d.hypotheses[0].name, "mass-offset");
    assert!(matches!(d.verdict, Verdict::MissingEffect | Verdict::SeveralEffects));
}

#[test]
fn a_mass_at_one_winglet_is_found_there() {
    let extra = ("  winglets: {nodes", "  hidden: {node: n13, mass: 0.06 kg}\n  winglets: {nodes");
    let d = story("point mass", &truth(&[extra]), |_| {}, 3);
    assert_eq!(d.verdict, Verdict::MissingEffect);
    assert_eq!(d.hypotheses[0].name, "point-mass");
    assert_eq!(d.hypotheses[0].location, "n13");
}

#[test]
fn a_sensor_upside_down_wins_alone() {
    let flip = |t: &mut TestData| {
        for m in &mut t.modes {
            let s = m.shape.as_mut().unwrap();
            s[10] = -s[10];
        }
    };
    let d = story("sensor 11 flipped", &truth(&[]), flip, 4);
    assert_eq!(d.verdict, Verdict::MeasurementFault);
    assert_eq!(d.hypotheses[0].id, "sensor-sign@p11");
    assert!(d.hypotheses[0].tied_with.is_empty());
}
