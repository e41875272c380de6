//! Properties of ends mean the ends of members.

use super::{Model, ParametricModel, Registry, load};
use crate::linalg::DMatrix;

fn built(beams: &str, more: &str) -> Model {
    let text = format!(
        "retune: 1\nname: e\nnodes: {{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0], d: [3, 0, 0]}}\n\
         sections: {{s: {{EA: 1e6 N, GJ: 60 N m2, EIy: 100 N m2, EIz: 100 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 1 kg m}}}}\n\
         beams: {{{beams}}}\nsupports: {{p: {{node: a}}}}\n{more}"
    );
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0].render("f"))).0
}

fn stiffness(model: &Model) -> DMatrix<f64> {
    model.assemble(&[]).unwrap().stiffness
}

/// Elements that have a flexible end.
fn hinged(model: &Model) -> Vec<&str> {
    let has = |e: &&super::PlacedElement| {
        let ends = e.kind.properties().iter().zip(e.values.iter());
        ends.filter(|(p, _)| p.name.starts_with("end")).any(|(_, v)| v.is_some())
    };
    model.elements().iter().filter(has).map(|e| e.name.as_str()).collect()
}

const HINGE: &str = "properties: {end1_compliance_ry: 1 rad/(N m), end2_compliance_rz: 2 rad/(N m)}";

#[test]
fn the_end_of_a_chain_is_that_of_its_first_and_last_element() {
    for (parts, ends) in [(1, ["m.1", "m.3"]), (4, ["m.1/0..0.25", "m.3/0.75..1"])] {
        let of_chain = built(&format!("m: {{chain: [a, b, c, d], section: s, {HINGE}, subdivide: {parts}}}"), "");
        assert_eq!(hinged(&of_chain), ends);
        let plain = format!("m: {{chain: [a, b, c, d], section: s, subdivide: {parts}}}");
        let by_element = "overrides: {m.1: {set: {end1_compliance_ry: 1}}, m.3: {set: {end2_compliance_rz: 2}}}\n";
        assert_eq!(stiffness(&of_chain), stiffness(&built(&plain, by_element)));
        // The same of the chain by its name, and by a group that holds it.
        for more in [
            "overrides: {m: {set: {end1_compliance_ry: 1, end2_compliance_rz: 2}}}\n",
            "groups: {g: [m]}\noverrides: {x: {of: [g], add: {end1_compliance_ry: 1, end2_compliance_rz: 2}}}\n",
        ] {
            assert_eq!(stiffness(&of_chain), stiffness(&built(&plain, more)), "{more}");
        }
    }
}

#[test]
fn every_pair_and_every_single_member_has_its_own_ends() {
    let pairs = built(&format!("m: {{pairs: [[a, b], [b, c], [c, d]], section: s, {HINGE}, subdivide: 2}}"), "");
    assert_eq!(hinged(&pairs), ["m.1/0..0.5", "m.1/0.5..1", "m.2/0..0.5", "m.2/0.5..1", "m.3/0..0.5", "m.3/0.5..1"]);
    let single = built(
        &format!("m: {{nodes: [a, d], section: s, {HINGE}, subdivide: 3}}, n: {{chain: [b, c], section: s}}"),
        "",
    );
    assert_eq!(hinged(&single), ["m/0..0.3333", "m/0.6667..1"]);
}

/// A released end is a hinge: ω of a beam clamped at one end and pinned at the other, tan β = tanh β, R. D. Blevins, Formulas for Natural
/// Frequency and Mode Shape, 1979, table 8-1. What is released twice, or where nothing could be, is refused with its place.
#[test]
fn releases_are_hinges() {
    let text = |releases: &str| {
        format!(
            "retune: 1\nname: hinge\nactive_dofs: [uz, ry]\nnodes: {{a: [0, 0, 0], b: [1 m, 0, 0]}}\nbeams:\n  w: {{nodes: [a, b], subdivide: 10, \
             properties: {{EIy: 10 N m2, mass_per_length: 2 kg/m}}{releases}}}\nsupports: {{walls: {{nodes: [a, b]}}}}\n"
        )
    };
    let model = crate::model::load(&text(", releases: {end2: [ry]}"), &Registry::builtin()).unwrap().0;
    let system = model.assemble(&[]).unwrap();
    let options = crate::modal::SolveOptions { n_elastic: 1, shift: None };
    let modes =
        crate::modal::solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
    let beta: f64 = 3.926_602;
    let right = beta * beta * 5.0_f64.sqrt();
    assert!((modes.lambda[0].sqrt() / right - 1.0).abs() < 1e-4, "{} {right}", modes.lambda[0].sqrt());
    for (releases, expected) in [
        (", releases: {end2: [ry, ry]}", "ry is released, and `end2_compliance_ry` is given too"),
        (", releases: {end3: [ry]}", "end3"),
    ] {
        let problems = crate::model::load(&text(releases), &Registry::builtin()).unwrap_err();
        assert!(problems.iter().any(|p| p.to_string().contains(expected)), "{problems:?}");
    }
}
