//! Stories of what is wrong inside of a member that the file has as one element.

use super::*;
use retune::data::Place;

/// A blade that is clamped and bends in its plane, in so many elements, with a line more.
fn blade(mesh: usize, more: &str) -> Model {
    model(&format!(
        "retune: 1\nname: blade\nactive_dofs: [ux, uz, ry]\nparameters:\n  E: {{value: 205 GPa, bounds: [180 GPa, 230 GPa]}}\n\
         nodes: {{root: [0, 0, 0], tip: [1 m, 0, 0]}}\n\
         sections:\n  strip: {{E: E, nu: 0.3, density: 7850 kg/m3, shape: {{rectangle: {{width: 40 mm, height: 8 mm}}}}}}\n\
         beams: {{blade: {{nodes: [root, tip], section: strip, subdivide: {mesh}}}}}\nsupports: {{clamp: {{node: root}}}}\n{more}"
    ))
}

/// What is named where a blade of a finer mesh has this in it.
fn named(more: &str, seed: u64) -> (Diagnosis, Vec<String>) {
    let (base, truth) = (blade(10, ""), blade(30, more));
    let at = |k: u32| Sensor {
        name: format!("z{k}"),
        place: Place::Element { element: "blade".into(), fraction: f64::from(k) / 8.0, position: None },
        offset: None,
        direction: [0.0, 0.0, 1.0],
        is_rotation: false,
        mass: None,
    };
    let sensors: Vec<Sensor> = (1..=8).map(at).collect();
    let test = twin_modes(&truth, &middle(&truth), &sensors, &noise(5, seed), "twin of a story").unwrap();
    let found = diagnose(&base, &test, &Settings::default()).unwrap();
    let first = found.hypotheses.first().map(|h| h.tied_with.clone()).unwrap_or_default();
    (found, first)
}

#[test]
fn a_mass_within_a_member_is_found_where_it_is() {
    let (found, _) = named("masses: {box: {node: blade/0.6, mass: 0.15 kg}}\n", 11);
    assert_eq!(found.verdict, Verdict::MissingEffect, "{}", found.sentence);
    let first = &found.hypotheses[0];
    assert_eq!(first.id, "point-mass@blade/0.6");
    let [low, high] = first.interval.unwrap();
    assert!(low < 0.15 && 0.15 < high && high - low < 0.06, "{low} {high}");
}

#[test]
fn a_cut_within_a_member_is_found_where_it_is() {
    let (found, tied) = named("overrides: {cut: {of: [blade/0.3..0.4], stiffness: 0.5}}\n", 12);
    assert_eq!(found.verdict, Verdict::MissingEffect, "{}", found.sentence);
    let first = &found.hypotheses[0];
    // In a plane the stiffness of a stretch is that of its bending.
    let place = "blade/0.3..0.4";
    assert!(first.location.starts_with(place), "{} {tied:?}", first.id);
    assert!((first.estimate.unwrap() + 0.5).abs() < 0.1, "{:?}", first.estimate);
}
