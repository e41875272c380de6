//! What entries of `overrides` do to elements.

use super::{Model, ParametricModel, Registry, load};

/// A rod of two elements in torsion, GJ/l = 10 and 30 N m/rad, ι l = 2 and 6 kg m².
fn rod(overrides: &str) -> Result<Model, String> {
    let text = format!(
        "retune: 1\nname: t\nactive_dofs: [rx]\nparameters:\n  p: {{value: 0.5, bounds: [-0.9, 0.9]}}\nnodes:\n  a: [0, 0, 0]\n  b: [1, 0, 0]\n  c: [4, 0, 0]\n\
         beams:\n  rod: {{chain: [a, b, c], properties: {{GJ: 10, polar_inertia_per_length: 2}}}}\nmasses:\n  m: {{node: c, inertia: {{xx: 1}}}}\n\
         supports:\n  s: {{node: a}}\noverrides:\n{overrides}"
    );
    load(&text, &Registry::builtin()).map(|(model, _, _)| model).map_err(|p| p[0].render("f"))
}

fn diagonal(model: &Model, theta: f64) -> ([f64; 2], [f64; 2]) {
    let s = model.assemble(&[theta]).unwrap();
    ([s.stiffness[(0, 0)], s.stiffness[(1, 1)]], [s.mass[(0, 0)], s.mass[(1, 1)]])
}

#[test]
fn one_entry_changes_several_names_and_entries_compose() {
    let model = rod(
        "  x: {of: [rod.1, rod.2], stiffness: 1 + p}\n  rod.2: {scale: {GJ: 2}, add: {polar_inertia_per_length: p}}\n",
    )
    .unwrap();
    let (k, m) = diagonal(&model, 0.5);
    // K: 10 and 2 x 10/3, both times 1.5. M: ι l/3 of 2 x 1 and 2.5 x 3, and the end.
    assert!((k[0] - 1.5 * (10.0 + 20.0 / 3.0)).abs() < 1e-12 && (k[1] - 1.5 * 20.0 / 3.0).abs() < 1e-12, "{k:?}");
    assert!((m[0] - (2.0 + 7.5) / 3.0).abs() < 1e-12 && (m[1] - (7.5 / 3.0 + 1.0)).abs() < 1e-12, "{m:?}");
}

#[test]
fn a_taper_follows_the_length_of_a_chain() {
    let model = rod("  t: {of: [rod], taper: {GJ: p, mass: 0.2}}\n").unwrap();
    // Middles at 0.5 and 2.5 of 4: s = -0.75 and 0.25.
    let (k, m) = diagonal(&model, 0.4);
    assert!((k[1] - 10.0 / 3.0 * 1.1).abs() < 1e-12 && (k[0] - (7.0 + 10.0 / 3.0 * 1.1)).abs() < 1e-12, "{k:?}");
    assert!((m[0] - (2.0 * 0.85 + 6.0 * 1.05) / 3.0).abs() < 1e-12, "{m:?}");
}

#[test]
fn damping_in_proportion_to_stiffness_and_mass() {
    let model = rod("  rod: {stiffness_damping: 3 ms, mass_damping: 2 1/s}\n").unwrap_or_else(|e| panic!("{e}"));
    let s = model.assemble(&[0.0]).unwrap();
    let c = s.damping.unwrap();
    let (k, m) = (s.stiffness[(0, 1)], s.mass[(0, 1)]);
    assert!((c[(0, 1)] - (3e-3 * k + 2.0 * m)).abs() < 1e-12);
    // The mass at the end is not part of the rod.
    assert!((c[(1, 1)] - (3e-3 * s.stiffness[(1, 1)] + 2.0 * (s.mass[(1, 1)] - 1.0))).abs() < 1e-12);
}

#[test]
fn wrong_overrides_say_where_and_what() {
    for (text, expected) in [
        (
            "  everything: {stiffness: 2}\n",
            "f:17:3: error: overrides.everything: `everything` is not an element, chain, mass or group; or name what it changes with `of: [...]`",
        ),
        (
            "  x: {of: [rot], mass: 2}\n",
            "f:17:12: error: overrides.x.of[0]: `rot` is not an element, chain, mass or group; did you mean `rod`?",
        ),
        ("  m: {taper: {mass: p}}\n", "f:17:15: error: overrides.m.taper.mass: a taper needs a chain of beams or bars"),
        (
            "  rod: {add: {GJJ: 1}}\n",
            "f:17:15: error: overrides.rod.add.GJJ: these elements have no property `GJJ`; did you mean `GJ`?",
        ),
        (
            "  rod: {taper: {GJ: 1 kg}}\n",
            "f:17:17: error: overrides.rod.taper.GJ: the unit of `1 kg` does not fit: expected a pure number or `%`",
        ),
        (
            "  rod: {taper: {EIy: p}}\n",
            "f:17:17: error: overrides.rod.taper.EIy: element `rod.1` has no `EIy` to taper",
        ),
    ] {
        assert_eq!(rod(text).unwrap_err(), expected);
    }
}
