//! Stories of members that are built otherwise than they are drawn: a brace that is bolted at both ends, a footing that settles and rocks, a column that is
//! turned about its axis. The truth has hinges, springs and axes of its own, not the changes of the effects.

use super::frame::told;
use super::*;

/// A mast with an arm and a brace, of one size all over.
fn mast(mesh: usize, nodes: &str, brace: &str, more: &str) -> Model {
    model(&format!(
        "retune: 1\nname: mast\nparameters:\n  E: {{value: 205 GPa, bounds: [185 GPa, 225 GPa]}}\n\
         nodes: {{n0: [0, 0, 0], n1: [0, 0, 1], n2: [0, 0, 2], n3: [1, 0, 2], b: [0.5, 0, 1.5]{nodes}}}\n\
         sections:\n  bar: {{E: E, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 60 mm, height: 40 mm}}}}}}\n  \
         rod: {{E: 205 GPa, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 30 mm, height: 20 mm}}}}}}\n\
         beams:\n  column: {{chain: [n0, n1, n2], section: bar, orientation: [1, 0, 0], subdivide: {mesh}}}\n  \
         arm: {{chain: [n2, n3], section: bar, orientation: [0, 0, 1], subdivide: {mesh}}}\n  \
         brace: {{chain: [{brace}], section: rod, orientation: [0, 1, 0], subdivide: {mesh}}}\n\
         masses: {{tip: {{node: n3, mass: 4 kg}}}}\n{more}supports: {{clamp: {{node: n0}}}}\n"
    ))
}

#[test]
fn a_brace_that_is_bolted_at_both_ends_is_found() {
    let base = mast(3, "", "n1, b, n3", "");
    let hinges = "rigid_links:\n  pin1: {master: n1, slaves: [p1], dofs: [ux, uy, uz, rx, rz]}\n  \
                  pin3: {master: n3, slaves: [p3], dofs: [ux, uy, uz, rx, rz]}\n";
    let truth = mast(3, ", p1: [0, 0, 1], p3: [1, 0, 2]", "p1, b, p3", hinges);
    for &seed in first(1, &[1, 2, 3]) {
        let sensors = retune::update::node_sensors(&base);
        let mut test = twin_modes(&truth, &[205e9], &sensors, &noise(7, seed), "twin of a story").unwrap();
        test.modes.iter_mut().for_each(|m| m.label = None);
        let d = told(&base, &test);
        let named = &d.hypotheses[0].id;
        assert!(
            d.verdict == Verdict::MissingEffect && named.starts_with("joint-flexibility@brace.1:n1+brace.2:n3."),
            "{seed}: {named}"
        );
        assert!(d.hypotheses[0].misfit_after < 1.3 * d.degrees_of_freedom, "{seed}");
    }
}

/// A portal on two feet.
fn portal(foot: &str) -> Model {
    turned_portal("[1, 0, 0]", foot)
}

/// * `right` - near what the z axis of its right column is
fn turned_portal(right: &str, foot: &str) -> Model {
    model(&format!(
        "retune: 1\nname: portal\nparameters:\n  E: {{value: 205 GPa, bounds: [185 GPa, 225 GPa]}}\n\
         nodes: {{l0: [0, 0, 0], l1: [0, 0, 1.1], l2: [0, 0, 2], g: [0.8, 0, 2], r2: [2, 0, 2], r1: [2, 0, 1.1], r0: [2, 0, 0]}}\n\
         sections:\n  bar: {{E: E, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 80 mm, height: 50 mm}}}}}}\n\
         beams:\n  left: {{chain: [l0, l1, l2], section: bar, orientation: [1, 0, 0], subdivide: 2}}\n  \
         girder: {{chain: [l2, g, r2], section: bar, orientation: [0, 0, 1], subdivide: 2}}\n  \
         right: {{chain: [r2, r1, r0], section: bar, orientation: {right}, subdivide: 2}}\n\
         masses: {{pump: {{node: g, mass: 25 kg}}}}\n{foot}"
    ))
}

#[test]
fn a_footing_that_settles_and_rocks_is_found() {
    let base = portal("supports: {feet: {nodes: [l0, r0]}}\n");
    let truth = portal(
        "springs: {soil: {node: r0, k: {ux: 1e12, uy: 1e12, uz: 4e6, rx: 1.2e5, ry: 1.5e5, rz: 1e12}}}\nsupports: {feet: {nodes: [l0]}}\n",
    );
    for &seed in first(1, &[1, 2, 3]) {
        let sensors = retune::update::node_sensors(&base);
        let mut test = twin_modes(&truth, &[205e9], &sensors, &noise(8, seed), "twin of a story").unwrap();
        test.modes.iter_mut().for_each(|m| m.label = None);
        let d = told(&base, &test);
        let id = "root-flexibility@right.2:r0.all_axes";
        assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id), "{seed}");
        // Along the member's own axis it settles by 1/4e6 m/N.
        let settles = d.hypotheses[0].estimates.iter().find(|e| e.parameter.ends_with("compliance_ux")).unwrap();
        let [lower, upper] = settles.interval;
        let middle = 0.5 * (lower + upper);
        // Twice the interval of 90 %: 3.3 standard deviations.
        assert!((2.5e-7 - middle).abs() < upper - lower, "{seed}: {lower} {upper}");
    }
}

#[test]
fn a_column_that_is_turned_is_found() {
    const FEET: &str = "supports: {feet: {nodes: [l0, r0]}}\n";
    let (base, truth) = (portal(FEET), turned_portal("[0, 1, 0]", FEET));
    for &seed in first(1, &[1, 2, 3]) {
        let sensors = retune::update::node_sensors(&base);
        let mut test = twin_modes(&truth, &[205e9], &sensors, &noise(8, seed), "twin of a story").unwrap();
        test.modes.iter_mut().for_each(|m| m.label = None);
        let d = told(&base, &test);
        assert_eq!(
            (d.verdict, d.hypotheses[0].id.as_str()),
            (Verdict::MissingEffect, "turned-section@right"),
            "{seed}"
        );
        assert!(d.hypotheses[0].interval.unwrap()[1] > 0.99, "{seed}");
    }
}

/// A frame of two storeys.
///
/// * `ends` - of its beams: left and right of the lower, then of the upper
fn storeys(nodes: &str, [a, b, c, d]: [&str; 4], more: &str) -> Model {
    model(&format!(
        "retune: 1\nname: storeys\nparameters:\n  E: {{value: 205 GPa, bounds: [185 GPa, 225 GPa]}}\n\
         nodes: {{l0: [0, 0, 0], l1: [0, 0, 1], l2: [0, 0, 2], r0: [1.5, 0, 0], r1: [1.5, 0, 1], r2: [1.5, 0, 2], m1: [0.7, 0, 1], m2: [0.7, 0, 2]{nodes}}}\n\
         sections:\n  column: {{E: E, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 70 mm, height: 50 mm}}}}}}\n  \
         beam: {{E: 205 GPa, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 40 mm, height: 60 mm}}}}}}\n\
         beams:\n  left: {{chain: [l0, l1, l2], section: column, orientation: [1, 0, 0], subdivide: 2}}\n  \
         right: {{chain: [r0, r1, r2], section: column, orientation: [1, 0, 0], subdivide: 2}}\n  \
         lower: {{chain: [{a}, m1, {b}], section: beam, orientation: [0, 0, 1], subdivide: 2}}\n  \
         upper: {{chain: [{c}, m2, {d}], section: beam, orientation: [0, 0, 1], subdivide: 2}}\n\
         masses: {{load: {{node: m1, mass: 20 kg}}}}\n{more}supports: {{feet: {{nodes: [l0, r0]}}}}\n"
    ))
}

#[test]
fn beams_that_are_bolted_at_all_their_ends_are_found() {
    let base = storeys("", ["l1", "r1", "l2", "r2"], "");
    let (mut nodes, mut links, mut springs) = (String::new(), String::new(), String::new());
    for (bolted, node, x, z) in [("a", "l1", 0.0, 1), ("b", "r1", 1.5, 1), ("c", "l2", 0.0, 2), ("d", "r2", 1.5, 2)] {
        nodes += &format!(", {bolted}: [{x}, 0, {z}]");
        links += &format!("  {bolted}: {{master: {node}, slaves: [{bolted}], dofs: [ux, uy, uz, rx, rz]}}\n");
        springs += &format!("  {bolted}: {{nodes: [{node}, {bolted}], k: {{ry: 2.5e5}}}}\n");
    }
    let truth = storeys(&nodes, ["a", "b", "c", "d"], &format!("rigid_links:\n{links}springs:\n{springs}"));
    for &seed in first(1, &[1, 2, 3]) {
        let sensors = retune::update::node_sensors(&base);
        let mut test = twin_modes(&truth, &[205e9], &sensors, &noise(8, seed), "twin of a story").unwrap();
        test.modes.iter_mut().for_each(|m| m.label = None);
        let d = told(&base, &test);
        let first = &d.hypotheses[0];
        let id = "joint-flexibility@beam.all.ry";
        assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, id), "{seed}");
        let [low, high] = first.interval.unwrap();
        assert!((1.0 / 2.5e5 - 0.5 * (low + high)).abs() < high - low, "{seed}: {low} {high}");
    }
}
