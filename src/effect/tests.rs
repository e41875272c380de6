//! The contract over the catalogue on every model of the project.

mod closed_forms;
mod configurations;
mod cuts;
mod files;
mod finer;
mod groups;
mod lines;
mod own_elements;
mod positions;
mod symmetry;

use super::*;
use crate::model::{Registry, lint, load};

fn models() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/models");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect();
    files.sort();
    let texts = files.into_iter().filter(|p| p.extension().is_some_and(|e| e == "yaml"));
    texts
        .map(|p| (p.display().to_string(), std::fs::read_to_string(&p).unwrap()))
        // Models of matrices or of a mesh read other files too.
        .filter(|(_, text)| text.contains("\nnodes:") && !text.contains("\nmesh:"))
        .collect()
}

fn context(text: &str) -> Context {
    let (model, _, _) = load(text, &Registry::builtin()).unwrap();
    // Every other mass is one that a configuration brings.
    let own_masses = model.spec().masses.keys().step_by(2).cloned().collect();
    Context {
        own_masses,
        sensors: model.spec().nodes.keys().take(3).map(|n| SensorLoad::on(n)).collect(),
        ..Context::default()
    }
}

/// Two cantilevers whose tips are at one place and not joined.
const NOT_MERGED: &str = "retune: 1
name: not merged
nodes: {a0: [0, 0, 0], a1: [0.5, 0, 0], b0: [1, 0, 0], b1: [0.5, 0, 0]}
sections: {bar: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {rectangle: {width: 20 mm, height: 10 mm}}}}
beams:
  a: {chain: [a0, a1], section: bar, orientation: [0, 0, 1]}
  b: {chain: [b0, b1], section: bar, orientation: [0, 0, 1]}
supports: {walls: {nodes: [a0, b0]}}
";

/// A skin of two shells of fibres, one of them along its nodes and one of plies, and a bar at its edge.
const SKIN: &str = "retune: 1
name: skin
nodes: {a: [0, 0, 0], b: [0.3, 0, 0], c: [0.6, 0, 0], d: [0, 0.2, 0], e: [0.3, 0.2, 0], f: [0.6, 0.2, 0]}
sections:
  ply: {E1: 130 GPa, E2: 9 GPa, nu12: 0.3, G12: 5 GPa, G13: 5 GPa, G23: 3 GPa, density: 1600, thickness: 2 mm}
  plies: {shape: {laminate: {materials: {ud: {E1: 130 GPa, E2: 9 GPa, nu12: 0.3, G12: 5 GPa, density: 1600}}, plies: [{angle: 0, thickness: 1 mm}, {angle: 30 deg, thickness: 1 mm}]}}}
  bar: {E: 70 GPa, G: 27 GPa, density: 2700, A: 20 mm2, Iy: 200 mm4, Iz: 100 mm4, J: 150 mm4, polar_inertia_per_length: 1e-6 kg m, shear_centre_z: -5 mm}
beams: {stringer: {chain: [d, e, f], section: bar}}
elements:
  left: {type: shell4, nodes: [a, b, e, d], section: ply}
  right: {type: shell4, nodes: [b, c, f, e], section: plies}
supports: {wall: {nodes: [a, d]}}
groups: {skin: [left, right]}
";

#[test]
fn every_effect_keeps_the_contract_on_every_model() {
    let effects = Effects::builtin();
    let mut counts = vec![0; EFFECTS.len()];
    let skin = ("a skin".to_string(), SKIN.to_string());
    let not_merged = ("two nodes at one place".to_string(), NOT_MERGED.to_string());
    for (name, text) in models().into_iter().chain([not_merged, skin]) {
        let context = context(&text);
        let (model, _, _) = load(&text, &Registry::builtin()).unwrap();
        let of_each = crate::tests::seeds(4, usize::MAX);
        let failures = conformance::check_some(&effects, (&model, &text), &Registry::builtin(), &context, of_each);
        assert!(
            failures.is_empty(),
            "{name}: {} failures:\n{}",
            failures.len(),
            failures[..failures.len().min(25)].join("\n")
        );
        let all = candidates(&model, &effects, &context);
        for (count, effect) in counts.iter_mut().zip(EFFECTS) {
            *count += all.iter().filter(|c| c.effect.name() == effect.name()).count();
        }
        eprintln!("{name}: {} candidates", all.len());
    }
    // What acts where places are wider alone.
    let (strip, context) = (cuts::strip(false), Context::default());
    let on_strip = Configured { name: None, model: &strip, context: &context };
    let wider = candidates_on_wider_places(&[on_strip], &effects, None);
    for (count, effect) in counts.iter_mut().zip(EFFECTS) {
        *count += wider.iter().filter(|c| c.effect.name() == effect.name()).count();
    }
    for (count, effect) in counts.iter().zip(EFFECTS) {
        eprintln!("{}: {count}", effect.name());
        assert!(*count > 0, "{} acts on no model", effect.name());
    }
}

#[test]
fn effects_stand_in_alphabetical_order_and_every_file_is_listed() {
    let names: Vec<&str> = EFFECTS.iter().map(|e| e.name()).collect();
    assert!(names.is_sorted(), "{names:?}");
}

#[test]
fn the_whole_catalogue_is_placed_and_applied_to_the_aeroplane_in_time() {
    let text = include_str!("../../models/bff.yaml");
    let (model, _, _) = load(text, &Registry::builtin()).unwrap();
    let start = std::time::Instant::now();
    let all = candidates(&model, &Effects::builtin(), &Context::default());
    let placed = start.elapsed();
    for candidate in &all {
        candidate.build(&model, &Registry::builtin()).unwrap();
    }
    eprintln!("{} candidates, placed in {placed:?}, all built in {:?}", all.len(), start.elapsed());
    assert!(all.len() >= 300);
}

#[test]
fn the_models_of_the_project_are_sound() {
    // The flagship's files carry a note on their effective G, which a test of theirs holds.
    for (name, text) in models().into_iter().filter(|(name, _)| !name.contains("/bff")) {
        let (model, warnings, _) = load(&text, &Registry::builtin()).unwrap_or_else(|e| panic!("{name}: {e:?}"));
        let s = lint(&model).unwrap();
        assert!(
            s.errors.is_empty() && s.warnings.is_empty() && warnings.is_empty(),
            "{name}: {:?} {:?} {warnings:?}",
            s.errors,
            s.warnings
        );
        assert_eq!(s.n_mechanisms, 0, "{name}");
    }
}
