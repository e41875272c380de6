//! Stories on a small frame with seven sensors: what neither of two effects shows alone.

use super::*;
use retune::effect::{Context, Structure};

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

const READ: [&str; 7] = ["c2.ux", "c4.ux", "a2.uz", "a3.uz", "c2.uy", "c4.uy", "a3.uy"];

/// Six modes at these sensors, with 0.3 % and 2.5 % noise, of the frame with effects of these sizes.
fn measured_frame(hidden: &[(&str, &[f64])], read: &[&str], seed: u64) -> (Model, TestData) {
    let mut truth = model(&frame(", subdivide: 3"));
    let mut theta = vec![73.5e9, 0.185, 0.115];
    for (id, sizes) in hidden {
        let context = Context::default();
        let candidate = Effects::builtin().candidate(&Structure::new(&truth, &context), id).unwrap();
        truth = candidate.build(&truth, &Registry::builtin()).unwrap().model;
        theta.extend(*sizes);
    }
    let base = model(&frame(""));
    let mut sensors = retune::update::node_sensors(&base);
    sensors.retain(|s| read.contains(&s.name.as_str()));
    assert_eq!(sensors.len(), read.len());
    let options = TwinOptions { shape_noise: 0.025, ..noise(6, seed) };
    let mut test = twin_modes(&truth, &theta, &sensors, &options, "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    (base, test)
}

fn frame_with(hidden: &[(&str, &[f64])], seed: u64) -> Diagnosis {
    let (base, test) = measured_frame(hidden, &READ, seed);
    told(&base, &test)
}

pub(super) fn told(base: &Model, test: &TestData) -> Diagnosis {
    let d = diagnose(base, test, &Settings::default()).unwrap();
    eprintln!("{:?}: {} (misfit {:.0} for {:.0})", d.verdict, d.sentence, d.misfit, d.degrees_of_freedom);
    for h in d.hypotheses.iter().take(4) {
        eprintln!("  {:50} p {:.3} lnB {:7.1} misfit {:.0}", h.id, h.probability, h.ln_bayes, h.misfit_after);
    }
    d
}

/// A strut from the column to the arm that the file does not have.
#[test]
fn a_strut_that_the_model_lacks_is_found_and_sized() {
    let id = "connection@c2:a2";
    let d = frame_with(&[(id, &[4e4])], 11);
    assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id));
    let [lower, upper] = d.hypotheses[0].interval.unwrap();
    assert!(lower < 4e4 && 4e4 < upper && upper < 1.6 * lower, "{lower} {upper}");
}

/// A portal whose file has two nodes at one corner, and nothing between them.
#[test]
fn nodes_that_were_not_merged_are_found() {
    let portal = |corner: &str, more: &str| {
        model(&format!(
            "retune: 1\nname: portal\nnodes:\n  l0: [0, 0, 0]\n  l1: [0, 0, 0.2]\n  l2: [0, 0, 0.4]\n  b1: [0.2, 0, 0.4]\n  r2: [0.4, 0, 0.4]\n{more}  \
             r1: [0.4, 0, 0.2]\n  r0: [0.4, 0, 0]\nsections:\n  bar: {{E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {{rectangle: {{width: 20 mm, height: 8 mm}}}}}}\n\
             beams:\n  left: {{chain: [l0, l1, l2], section: bar, orientation: [1, 0, 0]}}\n  beam: {{chain: [l2, b1, r2], section: bar, orientation: [0, 0, 1]}}\n  \
             right: {{chain: [{corner}, r1, r0], section: bar, orientation: [1, 0, 0]}}\nsupports:\n  left: {{node: l0}}\n  right: {{node: r0}}\n"
        ))
    };
    let (truth, base) = (portal("r2", ""), portal("r3", "  r3: [0.4, 0, 0.4]\n"));
    let sensors = retune::update::node_sensors(&truth);
    let mut test = twin_modes(&truth, &[], &sensors, &noise(6, 3), "twin of a portal").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    let d = told(&base, &test);
    assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, "rigid-link@r2:r3"));
}

/// The best alone is neither of the two.
#[test]
fn two_that_are_not_the_best_alone_are_found() {
    let hidden = [("root-flexibility@column.1:c0.ry", &[2.5e-4][..]), ("point-mass@a1", &[0.06])];
    for &seed in first(1, &[1, 2, 3]) {
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
    for &seed in first(1, &[1, 2, 3]) {
        let d = frame_with(&[(id, &[2.5e-4, 8e-5])], seed);
        assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id), "{seed}");
    }
}

/// Modes may be more than sensors, and there may be no shapes at all.
#[test]
fn few_sensors_and_frequencies_alone_are_enough_for_a_diagnosis() {
    let (base, few) = measured_frame(&[], &["c4.ux", "a3.uz", "a3.uy"], 1);
    assert_eq!(told(&base, &few).verdict, Verdict::Adequate);
    let mut alone = few;
    alone.sensors.clear();
    alone.modes.iter_mut().for_each(|m| (m.shape, m.shape_sd) = (None, None));
    assert_eq!(told(&base, &alone).verdict, Verdict::Adequate);
    let [(_, one), (_, other)] = [2, 3].map(|seed| measured_frame(&[], &READ, seed));
    let together = diagnose_tests(&base, &[&one, &other], &Settings::default()).unwrap();
    assert_eq!(together.verdict, Verdict::Adequate);
}

/// A frequency that is 4 % off belongs to the list and not to the structure: 34 sensors tell so, seven leave it tied with softer elements.
#[test]
fn a_frequency_that_is_mistyped_is_told_from_physics() {
    let of_frame = |seed: u64| measured_frame(&[], &READ, seed);
    let of_wing = |seed: u64| (model(&wing()), measured(&truth(&[]), seed));
    for (is_first, seed, mode) in first(2, &[(true, 1, 2), (false, 2, 4), (true, 2, 4), (false, 1, 2)]).iter().copied()
    {
        let (base, mut test) = if is_first { of_wing(seed) } else { of_frame(seed) };
        let known = test.modes[mode].frequency_hz.value;
        test.modes[mode].frequency_hz.value *= 1.04;
        let d = told(&base, &test);
        let id = format!("mode-frequency@mode {}", mode + 1);
        let found = d.hypotheses.iter().find(|h| h.id == id).unwrap();
        assert!(d.hypotheses[0].id == id || !is_first && d.hypotheses[0].tied_with.contains(&id), "{seed}");
        assert!((found.estimate.unwrap() / known - 1.0).abs() < 0.02, "{seed}: {:?} {known}", found.estimate);
    }
}

/// A rod on a fixed bearing and on one that slides.
fn shaft(mesh: &str) -> String {
    format!(
        "retune: 1\nname: shaft\nactive_dofs: [ux, uz, ry]\nparameters:\n  E: {{value: 205 GPa, bounds: [180 GPa, 230 GPa]}}\n\
         nodes:\n  b0: [0, 0, 0]\n  b1: [0.25, 0, 0]\n  b2: [0.5, 0, 0]\n  b3: [0.75, 0, 0]\n  b4: [1.0, 0, 0]\n  b5: [1.25, 0, 0]\n\
         sections:\n  rod: {{E: E, G: 80 GPa, A: 7.07e-4 m2, Iy: 3.98e-8 m4, Iz: 3.98e-8 m4, J: 7.95e-8 m4, density: 7850 kg/m3}}\n\
         beams:\n  rod: {{chain: [b0, b1, b2, b3, b4, b5], section: rod, orientation: [0, 0, 1], subdivide: {mesh}}}\n\
         supports:\n  fixed: {{nodes: [b0], fixed: [ux, uz]}}\n  loose: {{nodes: [b4], fixed: [uz]}}\n"
    )
}

/// Five modes at four sensors, with 0.3 % and 2 % noise.
fn measured_shaft(base: &Model, truth: &Model, theta: &[f64]) -> TestData {
    let mut sensors = retune::update::node_sensors(base);
    sensors.retain(|s| ["b1.uz", "b2.uz", "b3.uz", "b5.uz"].contains(&s.name.as_str()));
    let options = TwinOptions { shape_noise: 0.02, ..noise(5, 4) };
    let mut test = twin_modes(truth, theta, &sensors, &options, "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    test
}

/// A bearing that holds the slope of a shaft: a support that is stiffer than the model has it.
#[test]
fn a_bearing_that_holds_the_slope_is_found() {
    let id = "ground-spring@b0.ry";
    let (base, fine) = (model(&shaft("2")), model(&shaft("4")));
    let context = Context::default();
    let candidate = Effects::builtin().candidate(&Structure::new(&fine, &context), id).unwrap();
    let truth = candidate.build(&fine, &Registry::builtin()).unwrap().model;
    // Twice EI/L of the whole.
    let test = measured_shaft(&base, &truth, &[205e9, 1.3e4]);
    let d = told(&base, &test);
    assert_eq!((d.verdict, d.hypotheses[0].id.as_str()), (Verdict::MissingEffect, id));
    let [lower, upper] = d.hypotheses[0].interval.unwrap();
    assert!((1.3e4 - 0.5 * (lower + upper)).abs() < upper - lower, "{lower} {upper}");
}

/// A bearing in the middle of a rod that the file has as good as rigid gives by orders of magnitude more.
#[test]
fn a_stiff_spring_that_gives_is_found() {
    let with_spring = |mesh: &str, k: &str| {
        let rigid = shaft(mesh);
        let text = rigid[..rigid.find("  loose:").unwrap()].to_string();
        model(&format!("{text}springs:\n  bearing: {{node: b4, k: {{uz: {k} N/m}}}}\n"))
    };
    let (base, truth) = (with_spring("2", "1e9"), with_spring("4", "2e6"));
    let test = measured_shaft(&base, &truth, &[205e9]);
    let d = told(&base, &test);
    let first = &d.hypotheses[0];
    assert_eq!(first.id, "stiffness-change@bearing");
    assert!(((1.0 + first.estimate.unwrap()) / 2e-3 - 1.0).abs() < 0.2, "{:?}", first.estimate);
}

/// A pier of a beam that goes on over it, with the bearing on the pier beside the axis of the beam: what gives is the support, not an end.
#[test]
fn a_pier_that_gives_is_found() {
    let bridge = |mesh: &str, pier: &str| {
        let text = shaft(mesh).replace("  b5: [1.25, 0, 0]\n", "  b5: [1.25, 0, 0]\n  p: [0.52, 0, -0.03]\n");
        let text = text.replace("beams:\n", "rigid_links:\n  bearing: {master: b2, slaves: [p]}\nbeams:\n");
        let text = text.replace("  loose: {nodes: [b4], fixed: [uz]}\n", "  loose: {nodes: [b5], fixed: [uz]}\n");
        model(&format!("{text}{pier}"))
    };
    let base = bridge("4", "  pier: {node: p, fixed: [uz]}\n");
    let truth = bridge("6", "springs:\n  pier: {node: p, k: {uz: 2e6 N/m}}\n");
    for &seed in first(1, &[1, 2, 3]) {
        let mut sensors = retune::update::node_sensors(&base);
        sensors.retain(|s| ["b1.uz", "b2.uz", "b3.uz", "b4.uz"].contains(&s.name.as_str()));
        let options = TwinOptions { shape_noise: 0.02, ..noise(5, seed) };
        let test = twin_modes(&truth, &[205e9], &sensors, &options, "twin of a story").unwrap();
        let d = told(&base, &test);
        let first = &d.hypotheses[0];
        assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "root-flexibility@p.uz"), "{seed}");
        let [lower, upper] = first.interval.unwrap();
        assert!((0.4e-6..0.6e-6).contains(&first.estimate.unwrap()), "{seed}: {lower} {upper}");
    }
}

/// Spoils three tests of the frame by an angle between c4.ux and c4.uy, and looks for the fault that it is.
///
/// * `spoil` - test, rows of both sensors, sine and cosine
fn check_angles(
    fault: &str,
    angles: [(u64, f64); 3],
    within: f64,
    spoil: impl Fn(&mut TestData, [usize; 2], (f64, f64)),
) {
    for (seed, angle) in angles {
        let (base, mut test) = measured_frame(&[], &READ, seed);
        let at = |name: &str| test.sensors.iter().position(|s| s.name == name).unwrap();
        let both = ["c4.ux", "c4.uy"].map(at);
        spoil(&mut test, both, angle.to_radians().sin_cos());
        let d = told(&base, &test);
        let first = &d.hypotheses[0];
        assert_eq!((d.verdict, first.id.as_str()), (Verdict::MeasurementFault, fault), "{seed}");
        assert!((first.estimate.unwrap() - angle).abs() < within, "{seed}: {:?} {:?}", first.estimate, first.interval);
    }
}

/// A triaxial accelerometer that was put on askew.
#[test]
fn sensors_that_are_turned_in_their_plane_are_found() {
    let angles = [(1, 20.0), (2, -20.0), (3, 35.0)];
    check_angles("sensor-turned@c4.ux+c4.uy", angles, 4.0, |test, [x, y], (sin, cos)| {
        for shape in test.modes.iter_mut().filter_map(|m| m.shape.as_mut()) {
            (shape[x], shape[y]) = (shape[x] * cos + shape[y] * sin, shape[y] * cos - shape[x] * sin);
        }
    });
}

/// One uniaxial sensor on a surface that is not square to the axis it is meant for.
#[test]
fn a_sensor_that_is_tilted_is_found() {
    let angles = [(1, 25.0), (2, -25.0), (3, 35.0)];
    check_angles("sensor-tilted@c4.ux.y", angles, 6.0, |test, [x, y], (sin, cos)| {
        for mode in &mut test.modes {
            let shape = mode.shape.as_mut().unwrap();
            shape[x] = shape[x] * cos + shape[y] * sin;
            *shape = shape.clone().remove_row(y);
            mode.shape_sd = mode.shape_sd.take().map(|sd| sd.remove_row(y));
        }
        test.sensors.remove(y);
    });
}
