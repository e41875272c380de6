//! Stories of a tower that carries a body, and of a portal that stands on short stubs: places that are wide, supports that are soft, basins that
//! are wrong.

use super::frame::told;
use super::*;
use crate::problem::fit::evaluate;
use crate::problem::scene::Scene;
use crate::screen::stage::stage;
use crate::search::basin::lower_basin;
use crate::search::singles::refit;
use retune::effect::{Context, Structure};
use retune::linalg::DVector;

/// A clamped tube with a nacelle on it.
fn tower(mesh: usize) -> String {
    format!(
        "retune: 1\nname: tower\nparameters:\n  E: {{value: 205 GPa, bounds: [180 GPa, 230 GPa]}}\n  \
         m: {{value: 3000 kg, bounds: [2000 kg, 4500 kg]}}\n\
         nodes: {{t0: [0, 0, 0], t1: [0, 0, 6], t2: [0, 0, 12], t3: [0, 0, 18], t4: [0, 0, 24], t5: [0, 0, 30]}}\n\
         sections:\n  tube: {{E: E, nu: 0.3, density: 7850 kg/m3, shape: {{tube: {{diameter: 1.6 m, wall: 14 mm}}}}}}\n\
         beams: {{tower: {{chain: [t0, t1, t2, t3, t4, t5], section: tube, subdivide: {mesh}}}}}\n\
         masses: {{nacelle: {{node: t5, mass: m}}}}\nsupports: {{clamp: {{node: t0}}}}\n"
    )
}

/// A portal in its plane; its columns end in stubs of a tenth of a metre.
fn portal(mesh: usize) -> String {
    format!(
        "retune: 1\nname: portal\nactive_dofs: [ux, uz, ry]\nparameters:\n  E: {{value: 205 GPa, bounds: [180 GPa, 230 GPa]}}\n  \
         m: {{value: 300 kg, bounds: [200 kg, 400 kg]}}\n\
         nodes: {{l0: [0, 0, 0], l1: [0, 0, 0.1], l2: [0, 0, 1.5], l3: [0, 0, 3], g1: [1.5, 0, 3], g2: [3, 0, 3], r3: [4, 0, 3], \
         r2: [4, 0, 1.5], r1: [4, 0, 0.1], r0: [4, 0, 0]}}\n\
         sections:\n  bar: {{E: E, nu: 0.3, A: 3e-3 m2, Iy: 1e-5 m4, Iz: 1e-5 m4, J: 1e-5 m4, density: 7850 kg/m3}}\n\
         beams:\n  stub_left: {{nodes: [l0, l1], section: bar}}\n  left: {{chain: [l1, l2, l3], section: bar, subdivide: {mesh}}}\n  \
         girder: {{chain: [l3, g1, g2, r3], section: bar, subdivide: {mesh}}}\n  \
         right: {{chain: [r3, r2, r1], section: bar, subdivide: {mesh}}}\n  stub_right: {{nodes: [r1, r0], section: bar}}\n\
         masses: {{trolley: {{node: g1, mass: m}}}}\nsupports: {{feet: {{nodes: [l0, r0], fixed: [ux, uz]}}}}\n"
    )
}

/// Modes of the finer mesh with an effect, with 0.3 % and 2 % noise.
fn measured_with(
    text: impl Fn(usize) -> String,
    theta: &[f64],
    hidden: Option<(&str, &[f64])>,
    seed: u64,
) -> (Model, TestData) {
    let (base, mut truth) = (model(&text(2)), model(&text(6)));
    let mut theta = theta.to_vec();
    if let Some((id, sizes)) = hidden {
        let context = Context::default();
        let candidate = Effects::builtin().candidate(&Structure::new(&truth, &context), id).unwrap();
        truth = candidate.build(&truth, &Registry::builtin()).unwrap().model;
        theta.extend(sizes);
    }
    let sensors = retune::update::node_sensors(&model(&text(1)));
    let mut test = twin_modes(&truth, &theta, &sensors, &noise(7, seed), "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    (base, test)
}

/// A body that lacks inertia about two axes is one effect, neither one of each nor something else twice.
#[test]
fn a_body_lacks_inertia_about_two_axes() {
    let id = "point-rotary-inertia@t5.all_axes";
    for &seed in first(1, &[1, 2, 3]) {
        let (base, test) = measured_with(tower, &[210e9, 3200.0], Some((id, &[9000.0, 16000.0, 0.0])), seed);
        let d = told(&base, &test);
        assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id), "{seed}");
        for (e, truth) in d.hypotheses[0].estimates.iter().zip([9000.0, 16000.0]) {
            let [lower, upper] = e.interval;
            // Twice the interval of 90 %: 3.3 standard deviations.
            assert!((truth - 0.5 * (lower + upper)).abs() < upper - lower, "{seed}: {e:?}");
        }
    }
}

/// What a support stands on may be far softer than the stub that ends there.
#[test]
fn a_support_under_a_short_stub_gives() {
    let id = "root-flexibility@stub_left:l0.ux";
    for &seed in first(1, &[1, 2, 3]) {
        let (base, test) = measured_with(portal, &[200e9, 310.0], Some((id, &[3e-7])), seed);
        let d = told(&base, &test);
        assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id), "{seed}");
        let [lower, upper] = d.hypotheses[0].interval.unwrap();
        assert!((3e-7 - 0.5 * (lower + upper)).abs() < upper - lower, "{seed}: {lower} {upper}");
    }
}

/// A base that has not reached its optimum goes to where the hypotheses have brought its parameters; one that has stays.
#[test]
fn a_base_leaves_a_wrong_valley() {
    let (base, test) = measured_with(tower, &[210e9, 3200.0], None, 1);
    let settings = Settings::default();
    let right = stage(Scene::new(&base, &[&test]).unwrap(), &[], 1.0, &settings).unwrap();
    let refits = refit(&right, false).unwrap();
    assert!(lower_basin(&right, &refits, &settings).unwrap().is_none());
    let aside = DVector::from_element(2, 0.9);
    let mut wrong = right.clone();
    wrong.fit = evaluate(&wrong.scene, aside, 1.0).unwrap();
    wrong.q = wrong.fit.basis().unwrap();
    let found = lower_basin(&wrong, &refits, &settings).unwrap().unwrap();
    assert!((found - right.fit.x).amax() < 1e-3);
}
