//! Symmetric partners, whether the file names the plane or not.

use super::super::*;
use crate::model::{Registry, load};

const PROPERTIES: &str = "properties: {EIy: 10 N m2, EIz: 20 N m2, GJ: 6 N m2, EA: 1 MN, mass_per_length: 2 kg/m, polar_inertia_per_length: 0.003 kg m}";

/// An aeroplane along x: two wings, a body behind, and a probe at one wing tip alone.
fn aeroplane(symmetry: &str, supports: &str, wings_at: f64) -> String {
    let y = |v: f64| v + wings_at;
    format!(
        "retune: 1\nname: test\n{symmetry}\nnodes:\n  nose: [0, {m}, 0]\n  wing: [1, {m}, 0]\n  tail: [3, {m}, 0]\n  \
         l1: [1, {l1}, 0.1]\n  l2: [1.1, {l2}, 0.2]\n  r1: [1, {r1}, 0.1]\n  r2: [1.1, {r2}, 0.2]\n  probe: [0.9, {l2}, 0.2]\n\
         beams:\n  body: {{chain: [nose, wing, tail], {PROPERTIES}}}\n  left: {{chain: [wing, l1, l2], {PROPERTIES}}}\n  \
         right: {{chain: [wing, r1, r2], {PROPERTIES}}}\n  tube: {{nodes: [l2, probe], {PROPERTIES}}}\n{supports}\n",
        m = y(0.0),
        l1 = y(-1.0),
        l2 = y(-2.0),
        r1 = y(1.0),
        r2 = y(2.0)
    )
}

fn places(text: &str) -> Vec<String> {
    let model = load(text, &Registry::builtin()).unwrap().0;
    candidates(&model, &Effects::builtin(), &Context::default()).iter().map(Candidate::id).collect()
}

#[test]
fn a_plane_that_the_file_does_not_name_is_found() {
    let of_mirrored = [
        "point-mass@l2+r2",
        "stiffness-change@left+right",
        "asymmetry@left+right.stiffness",
        "taper@left+right.ry",
        "joint-flexibility@left.1:l1+right.1:r1.ry",
    ];
    let named = places(&aeroplane("symmetry: {normal: y}", "", 0.0));
    for id in of_mirrored {
        assert!(named.iter().any(|n| n == id), "{id} of {named:#?}");
    }
    assert_eq!(named, places(&aeroplane("", "", 0.0)));
    assert_eq!(named, places(&aeroplane("", "", 7.0)), "the plane need not go through the origin");
    assert_eq!(named, places(&aeroplane("symmetry: {normal: y, at: 7 m}", "", 7.0)));
}

#[test]
fn what_is_held_on_one_side_has_no_partners() {
    let held = places(&aeroplane("", "supports: {clamp: {node: r2}}", 0.0));
    assert!(held.iter().any(|id| id == "stiffness-change@left"));
    assert!(!held.iter().any(|id| id.contains("left+right") || id.contains("l2+r2")), "{held:#?}");
}
