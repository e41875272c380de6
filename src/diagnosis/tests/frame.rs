//! Stories on a small frame with seven sensors: what neither of two effects shows alone.

use super::*;
use crate::effect::{Context, Structure};

/// An L of two bars of aluminium, clamped at its foot.
fn frame(mesh: &str) -> String {
    format!(
        "retune: 1\nname: frame\nparameters:\n  E: {{value: 70 GPa, bounds: [58 GPa, 82 GPa]}}\n  \
         m_tip: {{value: 0.2 kg, bounds: [0.1 kg, 0.3 kg]}}\n  m_corner: {{value: 0.1 kg, bounds: [0.05 kg, 0.2 kg]}}\n\
         nodes:\n  c0: [0, 0, 0]\n  c1: [0, 0, 0.1]\n  c2: [0, 0, 0.2]\n  c3: [0, 0, 0.3]\n  c4: [0, 0, 0.4]\n  \
         a1: [0.1, 0, 0.4]\n  a2: [0.2, 0, 0.4]\n  a3: [0.3, 0, 0.4]\n\
         sections:\n  bar: {{E: E, G: 0.376*E, A: 2.4e-4 m2, Iy: 1.28e-9 m4, Iz: 1.8e-8 m4, J: 4.26e-9 m4, density: 2700 kg/m3}}\n\
         beams:\n  column: {{chain: [c0, c1, c2, c3, c4], section: bar, orientation: [1, 0, 0]{mesh}}}\n  \
         arm: {{chain: [c4, a1, a2, a3], section: bar, orientation: [0, 0, 1]{mesh}}}\n\
         masses:\n  tip: {{node: a3, mass: m_tip, inertia: {{xx: 4e-5 kg m2, yy: 4e-5 kg m2, zz: 4e-5 kg m2}}}}\n  \
         corner: {{node: c4, mass: m_corner}}\nsupports:\n  clamp: {{nodes: [c0]}}\n"
    )
}

/// Six modes at seven sensors, with 0.3 % and 2.5 % noise, of the frame with effects of these sizes.
fn frame_with(hidden: &[(&str, &[f64])], seed: u64) -> Diagnosis {
    let mut truth = model(&frame(", subdivide: 3"));
    let mut theta = vec![73.5e9, 0.185, 0.115];
    for (id, sizes) in hidden {
        let context = Context::default();
        let candidate = Effects::builtin().candidate(&Structure::new(&truth, &context), id).unwrap();
        truth = candidate.build(&truth, &Registry::builtin()).unwrap().model;
        theta.extend(*sizes);
    }
    let read = ["c2.ux", "c4.ux", "a2.uz", "a3.uz", "c2.uy", "c4.uy", "a3.uy"];
    let base = model(&frame(""));
    let mut sensors = crate::update::node_sensors(&base);
    sensors.retain(|s| read.contains(&s.name.as_str()));
    assert_eq!(sensors.len(), read.len());
    let options = TwinOptions { shape_noise: 0.025, ..noise(6, seed) };
    let mut test = twin_modes(&truth, &theta, &sensors, &options, "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    eprintln!("{:?}: {} (misfit {:.0} for {:.0})", d.verdict, d.sentence, d.misfit, d.degrees_of_freedom);
    for h in d.hypotheses.iter().take(4) {
        eprintln!("  {:50} p {:.3} lnB {:7.1} misfit {:.0}", h.id, h.probability, h.ln_bayes, h.misfit_after);
    }
    d
}

/// The best alone is neither of the two.
#[test]
fn two_that_are_not_the_best_alone_are_found() {
    let hidden = [("root-flexibility@column.1:c0.ry", &[2.5e-4][..]), ("point-mass@a1", &[0.06])];
    for seed in 1..4 {
        let d = frame_with(&hidden, seed);
        assert_eq!(d.verdict, Verdict::SeveralEffects, "{seed}");
        for (id, sizes) in hidden {
            let found = d.hypotheses[..2].iter().find(|h| h.id == id).unwrap_or_else(|| panic!("{seed}: {id}"));
            let [lower, upper] = found.interval.unwrap();
            let middle = 0.5 * (lower + upper);
            // Twice the interval of 90 %: 3.3 standard deviations.
            assert!((sizes[0] - middle).abs() < upper - lower, "{seed}: {id} {lower} {upper}");
        }
    }
}

/// A body on a spring splits a mode in two and imitates much: the test would have seen the other of the two.
#[test]
fn a_mode_that_the_test_must_have_overlooked_is_no_explanation() {
    let id = "root-flexibility@column.1:c0.bending";
    for seed in 1..4 {
        let d = frame_with(&[(id, &[2.5e-4, 8e-5])], seed);
        assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id), "{seed}");
    }
}
