//! Nodes that stand elsewhere: what is moved, and that the model is then the one whose file says so.

use super::super::*;
use crate::modal::SolveOptions;
use crate::model::{Model, Registry, load, solve_modes};

const SECTION: &str =
    "EIy: 10 N m2, EIz: 20 N m2, GJ: 6 N m2, EA: 1 MN, mass_per_length: 2 kg/m, polar_inertia_per_length: 0.003 kg m";

fn model(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0].render("f"))).0
}

/// A portal of chains, with a mass on its lintel and a bracket.
fn portal([foot, knee]: [f64; 2], mass: f64) -> String {
    format!(
        "retune: 1\nname: portal\nsections: {{s: {{{SECTION}}}}}\nnodes:\n  a0: [0, 0, 0]\n  a1: [0, 0, 0.5]\n  a2: [0, 0, 1]\n  b1: [{mass}, 0, 1]\n  \
         b2: [1, 0, 1]\n  c2: [2, 0, 1]\n  c1: [{knee}, 0, 0.5]\n  c0: [{foot}, 0, 0]\n  d: [2.2, 0.5, 1]\nbeams:\n  \
         left: {{chain: [a0, a1, a2], section: s, orientation: [1, 0, 0]}}\n  top: {{chain: [a2, b1, b2, c2], section: s}}\n  \
         right: {{chain: [c0, c1, c2], section: s, orientation: [1, 0, 0]}}\n  arm: {{nodes: [c2, d], section: s, subdivide: 2}}\n\
         masses: {{box: {{node: b1, mass: 3 kg}}}}\nsupports: {{feet: {{nodes: [a0, c0]}}}}\n"
    )
}

/// Wings that are mirror images, swept, with a store each.
fn wings(store: f64, tip: f64) -> String {
    format!(
        "retune: 1\nname: wings\nsymmetry: {{normal: y}}\nactive_dofs: [uz, rx, ry]\nsections: {{s: {{{SECTION}}}}}\nnodes:\n  root: [0, 0, 0]\n  \
         r1: [{}, {store}, 0]\n  r2: [0.4, {tip}, 0]\n  l1: {{mirror: r1}}\n  l2: {{mirror: r2}}\nbeams:\n  \
         right: {{chain: [root, r1, r2], section: s}}\n  left: {{chain: [root, l1, l2], section: s}}\n\
         masses: {{stores: {{nodes: [r1, l1], mass: 1 kg}}}}\nsupports: {{root: {{node: root}}}}\n",
        0.4 * store
    )
}

fn places(text: &str) -> Vec<String> {
    let (model, context) = (model(text), Context::default());
    let structure = Structure::new(&model, &context);
    Effects::builtin().find("node-position").unwrap().locations(&structure).iter().map(ToString::to_string).collect()
}

/// With a size of the effect the modes are those of another file.
fn is(text: &str, id: &str, size: f64, other: &str) {
    let (base, context) = (model(text), Context::default());
    let structure = Structure::new(&base, &context);
    let candidate = Effects::builtin().candidate(&structure, id).unwrap();
    let patched = candidate.build(&base, &Registry::builtin()).unwrap();
    let options = SolveOptions { n_elastic: 6, shift: None };
    let found = solve_modes(&patched.model, &patched.theta(structure.theta(), &[size]), options).unwrap();
    let wanted = solve_modes(&model(other), &[], options).unwrap();
    assert_eq!(found.n_rigid, wanted.n_rigid, "{id}");
    for (a, b) in found.lambda.iter().zip(&wanted.lambda).skip(wanted.n_rigid) {
        assert!((a - b).abs() < 1e-7 * b, "{id}: {a} against {b}");
    }
}

#[test]
fn a_frame_is_moved_at_its_feet_corners_tips_and_masses() {
    let text = portal([2.0, 2.0], 0.4);
    let found = places(&text);
    for place in ["a0.x", "c0.x", "c0.z", "c2.x", "c2.y", "d.y", "b1.along"] {
        assert!(found.iter().any(|p| p == place), "{place}: {found:?}");
    }
    // What lies inside of a member defines nothing.
    assert!(!found.iter().any(|p| p.starts_with("b2") || p.starts_with("a1") || p.starts_with("b1.x")), "{found:?}");
    is(&text, "node-position@c0.x", 0.1, &portal([2.1, 2.05], 0.4));
    is(&text, "node-position@b1.along", -0.1, &portal([2.0, 2.0], 0.3));
}

/// A longer column with its middle where it was; across the column it is one move with and without it.
#[test]
fn a_foot_is_moved_without_what_lies_inside_of_its_column() {
    let text = portal([2.0, 2.0], 0.4);
    let lower = |c1: &str| text.replace("c0: [2, 0, 0]", "c0: [2, 0, -0.1]").replace("c1: [2, 0, 0.5]", c1);
    is(&text, "node-position@c0.z", -0.1, &lower("c1: [2, 0, 0.45]"));
    is(&text, "node-position@c0.z_alone", -0.1, &lower("c1: [2, 0, 0.5]"));
    let (model, context) = (model(&text), Context::default());
    let structure = Structure::new(&model, &context).on_wider_places();
    let wider = Effects::builtin().find("node-position").unwrap().locations(&structure);
    let found: Vec<String> = wider.iter().map(ToString::to_string).collect();
    assert!(found.iter().any(|p| p == "c0.z_alone") && !found.iter().any(|p| p == "c0.x_alone"), "{found:?}");
}

#[test]
fn mirror_images_move_together() {
    let text = wings(0.5, 1.0);
    let found = places(&text);
    assert!(found.iter().any(|p| p == "r1+l1.along"), "{found:?}");
    // The left one is the image of the right one by the file.
    assert!(!found.iter().any(|p| p == "r1.along" || p == "r2.y"), "{found:?}");
    let along = 0.05 * 1.0_f64.hypot(0.4);
    is(&text, "node-position@r1+l1.along", along, &wings(0.55, 1.0));
}

/// What shells, links and other fixed arms hold is not moved.
#[test]
fn what_is_held_by_fixed_arms_stays() {
    let text = portal([2.0, 2.0], 0.4) + "rigid_links: {l: {master: c2, slaves: [d], dofs: [ux, uy, uz]}}\n";
    let found = places(&text);
    assert!(!found.iter().any(|p| p.starts_with("c2") || p.starts_with("d.")), "{found:?}");
    assert!(found.iter().any(|p| p == "a0.x"));
}
