//! Stories of what a drawing has rigid: a pump on a bracket that gives, a tailplane that rolls on a swept fin about an axis which is none of the fin's. The
//! truth has springs of its own between nodes at one place.

use super::frame::told;
use super::*;

/// A portal with a pump on its girder.
fn portal(pump: &str) -> Model {
    model(&format!(
        "retune: 1\nname: portal\nparameters:\n  E: {{value: 205 GPa, bounds: [185 GPa, 225 GPa]}}\n\
         nodes: {{l0: [0, 0, 0], l1: [0, 0, 1.1], l2: [0, 0, 2], g: [0.8, 0, 2], p: [0.8, 0, 2], r2: [2, 0, 2], r1: [2, 0, 1.1], r0: [2, 0, 0]}}\n\
         sections:\n  bar: {{E: E, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 80 mm, height: 50 mm}}}}}}\n\
         beams:\n  left: {{chain: [l0, l1, l2], section: bar, orientation: [1, 0, 0], subdivide: 2}}\n  \
         girder: {{chain: [l2, g, r2], section: bar, orientation: [0, 0, 1], subdivide: 2}}\n  \
         right: {{chain: [r2, r1, r0], section: bar, orientation: [1, 0, 0], subdivide: 2}}\n\
         masses: {{pump: {{node: p, mass: 25 kg}}}}\nsupports: {{feet: {{nodes: [l0, r0]}}}}\n{pump}"
    ))
}

/// Eight modes of a truth at all nodes of a portal but that of its pump.
fn measured_beside_the_pump(base: &Model, truth: &Model, seed: u64) -> TestData {
    let sensors: Vec<_> =
        retune::update::node_sensors(base).into_iter().filter(|s| !s.name.starts_with("p.")).collect();
    let mut test = twin_modes(truth, &[205e9], &sensors, &noise(8, seed), "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    test
}

/// Of the size whose name ends so.
fn interval_of(h: &HypothesisResult, name: &str) -> [f64; 2] {
    h.estimates.iter().find(|e| e.parameter.ends_with(name)).unwrap().interval
}

#[test]
fn a_pump_on_a_bracket_that_gives_is_found() {
    let base = portal("rigid_links: {bracket: {master: g, slaves: [p]}}\n");
    // 36 Hz alone.
    let truth = portal(
        "rigid_links: {bracket: {master: g, slaves: [p], dofs: [ux, uy, rx, ry, rz]}}\nsprings: {bracket: {nodes: [g, p], k: {uz: 1.28e6}}}\n",
    );
    for &seed in first(1, &[1, 2, 3]) {
        let d = told(&base, &measured_beside_the_pump(&base, &truth, seed));
        let first = &d.hypotheses[0];
        assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "flexible-mount@pump.uz"), "{seed}");
        let estimate = |name: &str| interval_of(first, name);
        let [low, high] = estimate("stiffness");
        assert!((1.28e6 - 0.5 * (low + high)).abs() < high - low, "{seed}: {low} {high}");
        assert!(estimate("share")[1] > 0.98, "{seed}");
    }
}

#[test]
fn a_pump_on_isolators_that_give_in_two_directions_is_found() {
    let base = portal("rigid_links: {isolators: {master: g, slaves: [p]}}\n");
    // 12 Hz and 36 Hz alone.
    let truth = portal(
        "rigid_links: {isolators: {master: g, slaves: [p], dofs: [uy, rx, ry, rz]}}\n\
         springs: {isolators: {nodes: [g, p], k: {ux: 1.42e5, uz: 1.28e6}}}\n",
    );
    for &seed in first(1, &[1, 2, 3]) {
        let d = told(&base, &measured_beside_the_pump(&base, &truth, seed));
        let first = &d.hypotheses[0];
        assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "flexible-mount@pump.all_axes"), "{seed}");
        let estimate = |name: &str| interval_of(first, name);
        for (name, known) in [("stiffness_ux", 1.42e5), ("stiffness_uz", 1.28e6)] {
            let [low, high] = estimate(name);
            assert!((known - 0.5 * (low + high)).abs() < high - low, "{seed}: {name} {low} {high}");
        }
    }
}

/// A swept fin with a tailplane on top.
fn tail(top: &str, joint: &str) -> Model {
    model(&format!(
        "retune: 1\nname: tail\nparameters:\n  E: {{value: 70 GPa, bounds: [63 GPa, 77 GPa]}}\n\
         nodes: {{f0: [0, 0, 0], f1: [0.3, 0, 0.6], f2: [0.6, 0, 1.2], {top}l: [0.7, -0.9, 1.2], r: [0.7, 0.9, 1.2], m: [0.65, 0.45, 1.2], n: [0.65, -0.45, 1.2]}}\n\
         sections:\n  fin: {{E: E, nu: 0.33, density: 2700 kg/m3, shape: {{rectangle: {{width: 120 mm, height: 30 mm}}}}}}\n  \
         plane: {{E: 70 GPa, nu: 0.33, density: 2700 kg/m3, shape: {{rectangle: {{width: 90 mm, height: 20 mm}}}}}}\n\
         beams:\n  fin: {{chain: [f0, f1, f2], section: fin, orientation: [0, 1, 0], subdivide: 2}}\n  \
         right: {{chain: [TOP, m, r], section: plane, orientation: [0, 0, 1], subdivide: 2}}\n  \
         left: {{chain: [TOP, n, l], section: plane, orientation: [0, 0, 1], subdivide: 2}}\n\
         supports: {{hull: {{node: f0}}}}\n{joint}"
    ).replace("TOP", if top.is_empty() { "f2" } else { "t" }))
}

#[test]
fn a_joint_about_an_axis_that_is_none_of_the_members_is_found() {
    let base = tail("", "");
    let truth = tail(
        "t: [0.6, 0, 1.2], ",
        "rigid_links: {joint: {master: f2, slaves: [t], dofs: [ux, uy, uz, ry, rz]}}\nsprings: {joint: {nodes: [f2, t], k: {rx: 6000}}}\n",
    );
    for &seed in first(1, &[1, 2, 3]) {
        let sensors = retune::update::node_sensors(&base);
        let mut test = twin_modes(&truth, &[70e9], &sensors, &noise(8, seed), "twin of a story").unwrap();
        test.modes.iter_mut().for_each(|m| m.label = None);
        let d = told(&base, &test);
        let first = &d.hypotheses[0];
        assert_eq!(
            (d.verdict, first.id.as_str()),
            (Verdict::MissingEffect, "joint-flexibility@fin.2:f2.about_x"),
            "{seed}"
        );
        let [low, high] = first.interval.unwrap();
        assert!((1.0 / 6000.0 - 0.5 * (low + high)).abs() < high - low, "{seed}: {low} {high}");
    }
}
