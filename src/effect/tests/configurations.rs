//! Effects that act in one configuration of a structure only.

use super::super::*;
use crate::linalg::DMatrix;
use crate::model::{Model, ParametricModel, Registry, load, load_configuration};

const TEXT: &str = include_str!("../../../models/bff.yaml");

fn models() -> (Model, Model) {
    let load = |name| load_configuration(TEXT, name, &Registry::builtin()).unwrap().0;
    (load(None), load(Some("bench")))
}

fn placed() -> Vec<Candidate> {
    let (base, bench) = models();
    let context = Context::default();
    let tested = [
        Configured { name: None, model: &base, context: &context },
        Configured { name: Some("bench"), model: &bench, context: &context },
    ];
    candidates_in(&tested, &Effects::builtin())
}

/// K at the estimates, with the parameters that an effect brings at their typical sizes.
fn stiffness(text: &str, configuration: Option<&str>, candidate: &Candidate) -> DMatrix<f64> {
    let (model, _, _) = load_configuration(text, configuration, &Registry::builtin()).unwrap();
    let mut theta = model.parameters().nominal();
    for p in &candidate.parameters {
        theta[model.parameters().index_of(&p.name).unwrap()] = p.typical;
    }
    model.assemble(&theta).unwrap().stiffness
}

#[test]
fn what_belongs_to_the_structure_stands_once_and_what_belongs_to_a_rig_in_each() {
    let all = placed();
    let count = |id: &str| all.iter().filter(|c| c.id() == id).count();
    assert_eq!(count("point-mass@n8"), 1);
    assert_eq!(count("ground-spring@n8.uz"), 1);
    assert_eq!(count("ground-spring@base/n8.uz"), 1);
    assert_eq!(count("ground-spring@bench/n8.uz"), 1);
    // The right wing is held on the bench.
    assert_eq!(count("ground-spring@bench/n12.uz"), 0);
    let roots: Vec<String> = all.iter().filter(|c| c.effect.name() == "root-flexibility").map(Candidate::id).collect();
    assert!(roots.contains(&"root-flexibility@bench/left_wing.2:n5.ry".to_string()), "{roots:?}");
    assert!(roots.iter().all(|id| id.contains("@bench/")), "{roots:?}");
}

#[test]
fn an_effect_of_one_configuration_changes_no_other_and_can_be_taken_out_again() {
    for id in [
        "root-flexibility@bench/left_wing.2:n5.ry",
        "ground-spring@bench/n8.uz",
        "ground-spring@base/n8.uz",
        "ground-spring@base/n8+n13.uz",
    ] {
        let candidate = placed().into_iter().find(|c| c.id() == id).unwrap();
        let edited = candidate.patch.add_to_text(TEXT, id, "a test").unwrap();
        let (model, _, _) = load(&edited, &Registry::builtin()).unwrap();
        // As `add` finds it by its id in the file as it was.
        let (base, _) = models();
        let context = Context::default();
        let found = Effects::builtin().candidate(&Structure::new(&base, &context), id).unwrap();
        assert_eq!(found.patch, candidate.patch, "{id}");
        assert_eq!(model.spec().history.last().unwrap().add, id);
        let changed = |c: Option<&str>| stiffness(&edited, c, &candidate) != stiffness(&edited, c, &still(&candidate));
        let in_base = id.contains("@base/");
        assert_eq!((changed(None), changed(Some("bench"))), (in_base, !in_base), "{id}");
        assert_eq!(undo(&edited).unwrap().text, TEXT, "{id}");
    }
}

/// The same at its neutral values.
fn still(candidate: &Candidate) -> Candidate {
    let mut out = candidate.clone();
    out.parameters.iter_mut().for_each(|p| p.typical = p.neutral);
    out
}

#[test]
fn two_effects_of_one_configuration_are_undone_one_after_the_other() {
    let all = placed();
    let find = |id: &str| all.iter().find(|c| c.id() == id).unwrap();
    let first = "root-flexibility@bench/left_wing.2:n5.ry";
    let second = "root-flexibility@bench/left_wing.2:n5.rx";
    let one = find(first).patch.add_to_text(TEXT, first, "").unwrap();
    let two = find(second).patch.add_to_text(&one, second, "").unwrap();
    assert_eq!(undo(&two).unwrap().text, one);
    assert_eq!(undo(&one).unwrap().text, TEXT);
}

#[test]
fn an_unknown_configuration_is_named() {
    let (base, _) = models();
    let context = Context::default();
    let wrong = Effects::builtin().candidate(&Structure::new(&base, &context), "ground-spring@bensh/n8.uz");
    assert!(
        matches!(&wrong, Err(PatchError::UnknownConfiguration { suggestion, .. }) if suggestion.contains("bench")),
        "{wrong:?}"
    );
}

/// A mass that one configuration brings is changed there, lighter or heavier; one of the structure is not.
#[test]
fn a_mass_of_one_configuration_is_changed_there() {
    let text = "retune: 1\nname: t\nactive_dofs: [uz, ry]\nnodes: {a: [0, 0, 0], b: [1, 0, 0]}\nbeams: {s: {nodes: [a, b], subdivide: 4, properties: {EIy: 10, mass_per_length: 1}}}\n\
                masses: {motor: {node: b, mass: 0.2 kg}}\nsupports: {root: {node: a}}\nconfigurations:\n  tipped: {masses: {weight: {node: b, mass: 0.5 kg}}}\n";
    let registry = Registry::builtin();
    let of = |name| load_configuration(text, name, &registry).unwrap().0;
    let (base, tipped) = (of(None), of(Some("tipped")));
    let contexts = [Context::default(), Context { own_masses: vec!["weight".to_string()], ..Context::default() }];
    let tested = [
        Configured { name: None, model: &base, context: &contexts[0] },
        Configured { name: Some("tipped"), model: &tipped, context: &contexts[1] },
    ];
    let all = candidates_in(&tested, &Effects::builtin());
    let ids: Vec<String> = all.iter().filter(|c| c.effect.name() == "mass-change").map(Candidate::id).collect();
    assert_eq!(ids, ["mass-change@tipped/weight"]);
    let candidate = all.iter().find(|c| c.id() == "mass-change@tipped/weight").unwrap();
    // As `add` finds it.
    let found = Effects::builtin().candidate(&Structure::new(&base, &contexts[0]), &candidate.id()).unwrap();
    assert_eq!(found.patch, candidate.patch);
    assert!(found.parameters[0].bounds[0] < 0.0 && found.parameters[0].bounds[1] > 1.0);
    let edited = found.patch.add_to_text(text, &candidate.id(), "").unwrap();
    let mass = |configuration| {
        let (model, _, _) = load_configuration(&edited, configuration, &registry).unwrap();
        let mut theta = model.parameters().nominal();
        theta[0] = 0.3;
        model.mass_properties(&theta).unwrap().unwrap().mass
    };
    assert!((mass(None) - 1.2).abs() < 1e-12 && (mass(Some("tipped")) - 1.85).abs() < 1e-12);
    assert_eq!(undo(&edited).unwrap().text, text);
}
