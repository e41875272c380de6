//! Stories on the flying wing, whose hidden effects are known: nothing missing, an effect, a fault.

mod answers;
mod as_built;
mod frame;
mod inside;
mod large;
mod meshes;
mod mixed;
mod mounts;
mod statics;
mod stores;
mod tower;
mod verdicts;

use super::screen::stage::{Stage, stage};
use super::search::run::stage_with;
use super::search::singles::refit;
use super::*;
use retune::data::{Sensor, read_test};
use retune::effect::Effects;
use retune::model::{ParametricModel, Registry, load};
use retune::update::{TwinOptions, twin_modes};

/// The first of some cases; all when the environment asks for all (`RETUNE_SLOW=1`).
fn first<T>(few: usize, all: &[T]) -> &[T] {
    let is_asked = std::env::var("RETUNE_SLOW").is_ok_and(|v| v == "1");
    &all[..if is_asked { all.len() } else { few.min(all.len()) }]
}

/// Properties of the real aircraft that a twin need not have.
fn without_targets(text: &str) -> String {
    text[..text.find("\ntargets:").unwrap()].to_string() + "\n"
}

fn wing() -> String {
    without_targets(retune::samples::FLYING_WING)
}

fn model(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap().0
}

fn sensors() -> Vec<Sensor> {
    read_test(include_str!("../../models/bff_gvt.yaml")).unwrap().0.sensors
}

/// A little off the middle of every interval, where no bound interferes.
fn middle(model: &Model) -> Vec<f64> {
    let share = |i: usize| 0.4 + 0.2 * ((7 * i) % 10) as f64 / 9.0;
    model
        .parameters()
        .iter()
        .enumerate()
        .map(|(i, p)| p.bounds.map_or(p.value, |[l, u]| l + share(i) * (u - l)))
        .collect()
}

/// The wing with an edit of its text, on a mesh three times as fine.
fn truth(edits: &[(&str, &str)]) -> Model {
    let mut text = wing().replace("section: wing}", "section: wing, subdivide: 3}");
    for (from, to) in edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    model(&text)
}

/// The noise of the stories: 0.3 % of frequencies, 2 % of shapes.
fn noise(n_modes: usize, seed: u64) -> TwinOptions {
    TwinOptions {
        n_modes,
        damping: Some(0.0),
        frequency_noise: 0.003,
        shape_noise: 0.02,
        seed,
        ..TwinOptions::default()
    }
}

/// A synthetic test of the truth: six modes with 0.3 % noise of frequencies and 2 % of shapes, without names.
fn measured(truth: &Model, seed: u64) -> TestData {
    let options = noise(6, seed);
    let mut test = twin_modes(truth, &middle(truth), &sensors(), &options, "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    test
}

fn story(name: &str, truth: &Model, spoil: impl Fn(&mut TestData), seed: u64) -> Diagnosis {
    let base = model(&wing());
    let mut test = measured(truth, seed);
    spoil(&mut test);
    let start = std::time::Instant::now();
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    eprintln!(
        "{name}: {:?} in {:.1} s, p {:.4}, misfit {:.0} for {:.0}, none {:.3}, other {:.3}, {} effects ({} visible), {} faults, noise {:.2}",
        d.verdict,
        start.elapsed().as_secs_f64(),
        d.p_value,
        d.misfit,
        d.degrees_of_freedom,
        d.probability_none,
        d.probability_other,
        d.screened_effects,
        d.visible_effects,
        d.screened_faults,
        d.noise_factor,
    );
    eprintln!("  {}", d.sentence);
    for h in d.hypotheses.iter().take(6) {
        eprintln!(
            "  {:50} p {:.3} lnB {:7.1} misfit {:.0} held out {:.0} -> {:.0} estimate {:?} {:?} ties {}",
            h.id,
            h.probability,
            h.ln_bayes,
            h.misfit_after,
            h.held_out_before,
            h.held_out_after,
            h.estimate,
            h.interval,
            h.tied_with.len()
        );
    }
    for n in d.next_measurements.iter().take(2) {
        eprintln!("  next: {} ({:.1})", n.what, n.expected_ln_bayes);
    }
    d
}

#[test]
fn nothing_is_missing() {
    let d = story("null", &truth(&[]), |_| {}, 1);
    assert_eq!(d.verdict, Verdict::Adequate);
    // Where nothing is to be explained, little is tried: 376 linearizations when this was written.
    assert!(d.work.linearizations < 450, "{:?}", d.work);
    assert!(d.probability_none > 0.5);
}

/// Nothing missing, and noise twice as large as the test says.
#[test]
fn understated_noise_is_estimated() {
    let halve = |test: &mut TestData| {
        for mode in &mut test.modes {
            mode.frequency_hz.sd *= 0.5;
            mode.shape_sd.iter_mut().for_each(|sd| *sd *= 0.5);
        }
    };
    let d = story("noise", &truth(&[]), halve, 3);
    assert_eq!(d.verdict, Verdict::Adequate);
    assert!((1.7..2.3).contains(&d.noise_factor), "{}", d.noise_factor);
}

/// A stage on top of another sees the same effects first as one that evaluates them all, to the last bit.
#[test]
fn what_another_stage_has_seen_changes_no_order() {
    let settings = Settings::default();
    let test = measured(&truth(&[("\nmasses:\n", "\nmasses:\n  hidden: {node: n8, mass: 30 g}\n")]), 5);
    let base = stage(Scene::new(&model(&wing()), &[&test]).unwrap(), &[], 1.0, &settings).unwrap();
    let hypotheses = refit(&base, false).unwrap().hypotheses;
    for r in hypotheses.iter().take(2) {
        let again = stage_with(&base, r, &settings).unwrap();
        let whole = stage(r.scene.clone(), std::slice::from_ref(&r.fit.x), 1.0, &settings).unwrap();
        assert_eq!(again.fit.x, whole.fit.x);
        let best = |s: &Stage| -> Vec<(String, f64)> { s.effects.iter().take(8).map(|e| (s.id(e), e.t)).collect() };
        assert_eq!(best(&again), best(&whole));
        assert!((again.p_value - whole.p_value).abs() < 0.05, "{} {}", again.p_value, whole.p_value);
    }
}

/// The same bits on one thread and on two, with a point mass at the tip that the model lacks.
#[test]
fn a_diagnosis_does_not_depend_on_threads() {
    let text = retune::samples::WING_ON_SPRINGS;
    let base = model(text);
    let heavier = text.replace("\nmasses:\n", "\nmasses:\n  hidden: {node: tip, mass: 40 g}\n");
    let truth = model(&heavier);
    let sensors = retune::update::node_sensors(&base);
    let test = twin_modes(&truth, &middle(&truth), &sensors, &noise(5, 8), "twin").unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        format!("{:?}", pool.install(|| diagnose(&base, &test, &Settings::default())).unwrap())
    };
    let one = on(1);
    assert!(one.contains("point-mass@tip"), "{one}");
    assert_eq!(one, on(2));
}

/// A mast in three entries of the file.
const MAST: &str = "retune: 1\nname: mast\nactive_dofs: [ux, ry]\nparameters:\n  E: {value: 205 GPa, bounds: [180 GPa, 220 GPa]}\n  \
    top: {value: 20 kg, bounds: [10 kg, 40 kg]}\nnodes: {n0: [0, 0, 0], n1: [0, 0, 1], n2: [0, 0, 2], n3: [0, 0, 3], n4: [0, 0, 4], n5: [0, 0, 5]}\n\
    sections:\n  tube: {E: E, A: 1e-3, Iy: 1e-7, Iz: 1e-7, density: 7800}\nbeams:\n  lower: {chain: [n0, n1, n2], section: tube, subdivide: 2}\n  \
    middle: {nodes: [n2, n3], section: tube, subdivide: 2}\n  upper: {chain: [n3, n4, n5], section: tube, subdivide: 2}\n\
    masses: {top: {node: n5, mass: top}}\nsupports: {ground: {node: n0}}\n";

/// The mast against a twin of what the text of its truth says.
fn of_mast(truth: &str, seed: u64) -> Diagnosis {
    let (base, truth) = (model(MAST), model(truth));
    let sensors = retune::update::node_sensors(&base);
    let test = twin_modes(&truth, &middle(&truth), &sensors, &noise(5, seed), "twin").unwrap();
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    for h in d.hypotheses.iter().take(4) {
        eprintln!("{:.3} {:.1} {} {:?}", h.probability, h.misfit_after, h.id, h.tied_with);
    }
    eprintln!("{}", d.sentence);
    d
}

/// The first of two is chosen while the second is not there, and is sought again beside it.
#[test]
fn two_effects_are_named_together() {
    let hidden = MAST.replace("masses: {", "masses: {ballast: {node: n3, mass: 2 kg}, ")
        + "overrides: {lower.1: {set: {end1_compliance_rz: 4e-5}}}\n";
    let d = of_mast(&hidden, 5);
    assert_eq!(d.verdict, Verdict::SeveralEffects);
    let mut two = [d.hypotheses[0].id.as_str(), d.hypotheses[1].id.as_str()];
    two.sort_unstable();
    assert_eq!(two, ["point-mass@n3", "root-flexibility@lower.1:n0.rz"]);
    assert!(two.iter().all(|id| d.sentence.contains(id)), "{}", d.sentence);
    // Each has the probability of being one of the two, and what it adds to the other alone.
    assert!(d.hypotheses[..2].iter().all(|h| h.probability > 0.5 && h.misfit_after < h.misfit_before));
    assert!(d.hypotheses[..2].iter().all(|h| h.misfit_before < d.misfit));
}

/// A modulus that its bounds do not allow: what a parameter on its bound leaves is not noise.
#[test]
fn what_a_bound_leaves_is_seen() {
    let d = of_mast(&MAST.replace("value: 205 GPa, bounds: [180 GPa, 220 GPa]", "value: 165 GPa"), 6);
    assert!(d.p_value < 0.01 && d.probability_none < 0.01, "{} {}", d.p_value, d.probability_none);
    let all: Vec<&String> = std::iter::once(&d.hypotheses[0].id).chain(&d.hypotheses[0].tied_with).collect();
    assert!(all.iter().any(|id| *id == "softening@whole"), "{all:?}");
    assert!(d.warnings.iter().any(|w| w == "parameter E of the fitted model sits on its bound"), "{:?}", d.warnings);
}

/// The known mass of a second test that is not what the file says.
#[test]
fn a_wrong_mass_of_one_configuration_is_found_there() {
    let with =
        |mass: &str| format!("{MAST}configurations: {{loaded: {{masses: {{weight: {{node: n3, mass: {mass}}}}}}}}}\n");
    let (base, truth) = (model(&with("3 kg")), model(&with("3.6 kg")));
    let loaded = Model::new(truth.spec().configured("loaded").unwrap(), &Registry::builtin()).unwrap().0;
    let sensors = retune::update::node_sensors(&base);
    let test = |of: &Model, seed| twin_modes(of, &middle(of), &sensors, &noise(5, seed), "twin").unwrap();
    let (bare, mut weighed) = (test(&truth, 7), test(&loaded, 8));
    weighed.configuration = Some("loaded".to_string());
    let d = diagnose_tests(&base, &[&bare, &weighed], &Settings::default()).unwrap();
    let first = &d.hypotheses[0];
    eprintln!("{} {:?} {:?}", d.sentence, first.estimate, first.interval);
    assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "mass-change@loaded/weight"));
    let [low, high] = first.interval.unwrap();
    assert!(low < 0.2 && 0.2 < high);
}

/// A bending mode that the test lacks is noted; torsion, which no sensor of a slender blade sees, is not.
#[test]
fn a_mode_that_the_test_overlooked_is_noted() {
    let blade = "retune: 1\nname: blade\nparameters: {E: {value: 70 GPa, bounds: [60 GPa, 80 GPa]}}\n\
        nodes: {n0: [0, 0, 0], n1: [0.4, 0, 0], n2: [0.8, 0, 0], n3: [1.2, 0, 0]}\n\
        sections: {flat: {E: E, G: 26 GPa, density: 2700, shape: {rectangle: {width: 60 mm, height: 12 mm}}}}\n\
        beams: {blade: {chain: [n0, n1, n2, n3], section: flat, subdivide: 4}}\nsupports: {clamp: {node: n0}}\n";
    let base = model(blade);
    let sensors: Vec<Sensor> = retune::update::node_sensors(&base)
        .into_iter()
        .filter(|s| matches!(&s.place, retune::data::Place::Node { node, .. } if node.starts_with('n')))
        .collect();
    let mut test = twin_modes(&base, &middle(&base), &sensors, &noise(7, 9), "twin").unwrap();
    let missed = test.modes.remove(3).frequency_hz.value;
    let settings = Settings {
        effects: retune::effect::Effects::none(),
        faults: retune::fault::Faults::none(),
        ..Settings::default()
    };
    let d = diagnose(&base, &test, &settings).unwrap();
    let noted: Vec<&String> = d.warnings.iter().filter(|w| w.contains("inside the tested band")).collect();
    assert_eq!(noted.len(), 1, "{:?}", d.warnings);
    let hz: Vec<f64> = noted[0].split_whitespace().filter_map(|w| w.trim_end_matches(',').parse().ok()).collect();
    assert!(hz.len() == 1 && (hz[0] / missed - 1.0).abs() < 0.02, "{hz:?} {missed}");
}

/// A stiffness that is lost from the middle of one entry of the file to the end of the next.
#[test]
fn a_change_that_goes_on_beyond_an_element_is_one_effect() {
    let d = of_mast(&format!("{MAST}overrides: {{hidden: {{of: [lower.2, middle], stiffness: 0.7}}}}\n"), 4);
    let first = &d.hypotheses[0];
    eprintln!("{}: {:?} {:?}", d.sentence, first.estimate, first.interval);
    let all: Vec<&String> = std::iter::once(&first.id).chain(&first.tied_with).collect();
    assert_eq!(d.verdict, Verdict::MissingEffect);
    assert!(all.iter().any(|id| *id == "stiffness-change@lower.2..middle"), "{all:?}");
    let [low, high] = first.interval.unwrap();
    assert!(low < -0.3 && -0.3 < high);
    // It is a place for `add`, and leaves nothing to be found.
    let base = model(MAST);
    let context = retune::effect::Context::default();
    let structure = retune::effect::Structure::new(&base, &context);
    assert!(Settings::default().effects.candidate(&structure, "stiffness-change@lower.2..middle").is_ok());
}

/// Of three effects none explains enough alone: that several are missing is said at once, and learnt one by one.
#[test]
fn three_effects_are_learnt_one_after_the_other() {
    let hidden = MAST.replace("masses: {", "masses: {ballast: {node: n2, mass: 3 kg}, ")
        + "overrides: {soft: {of: [upper.2], stiffness: 0.6}, root: {of: [lower.1], set: {end1_compliance_rz: 1e-4}}}\n";
    let (base, truth) = (model(MAST), model(&hidden));
    let test = twin_modes(&truth, &middle(&truth), &retune::update::node_sensors(&base), &noise(5, 5), "twin").unwrap();
    let learned = learn(&base, &test, &Settings::default(), true, 5).unwrap();
    let misfits: Vec<f64> = learned.steps.iter().map(|s| s.misfit).collect();
    let last = learned.steps.last().unwrap();
    eprintln!("{misfits:?} {:?} {}", learned.attempt, last.diagnosis.sentence);
    assert_eq!(learned.steps[0].diagnosis.verdict, Verdict::SeveralEffects, "{}", learned.steps[0].diagnosis.sentence);
    assert_eq!((last.diagnosis.verdict, learned.attempt), (Verdict::Adequate, None));
    let size =
        |name: &str| last.sizes.iter().find(|e| e.parameter == name).unwrap_or_else(|| panic!("{:?}", last.sizes));
    for (name, truth) in [("root_flexibility.lower.1:n0.rz.compliance", 1e-4), ("point_mass.n2.mass", 3.0)] {
        let e = size(name);
        assert!(e.interval[0] < truth && truth < e.interval[1], "{e:?}");
    }
    assert_eq!(last.sizes.len(), 3);
    assert!(last.sizes.iter().any(|e| e.parameter.contains("stiffness_change.upper.2")), "{:?}", last.sizes);
}

/// What lies outside the catalogue is not learnt: the way is tried, and taken back.
#[test]
fn what_nothing_explains_is_not_learnt() {
    let factors = ["lower.1", "lower.2", "middle", "upper.1", "upper.2"];
    let scattered: Vec<String> = factors
        .iter()
        .zip([1.6, 0.7, 1.5, 0.6, 1.4])
        .map(|(of, k)| format!("{}: {{of: [{of}], stiffness: {k}, mass: {}}}", of.replace('.', "_"), 2.0 - k))
        .collect();
    let truth = model(&format!("{MAST}overrides: {{{}}}\n", scattered.join(", ")));
    let base = model(MAST);
    let test = twin_modes(&truth, &middle(&truth), &retune::update::node_sensors(&base), &noise(5, 6), "twin").unwrap();
    let learned = learn(&base, &test, &Settings::default(), true, 3).unwrap();
    let last = learned.steps.last().unwrap();
    eprintln!("{:?} {}", learned.attempt, last.diagnosis.sentence);
    assert_eq!(last.diagnosis.verdict, Verdict::Unexplained);
    assert!(last.added.is_none() && last.tie.is_empty());
    assert_eq!(last.sizes.len(), learned.effects.len());
    if let Some(attempt) = &learned.attempt {
        assert!(!attempt.ids.is_empty() && attempt.misfit < last.misfit);
    }
}

/// A force at the top of the mast pulls at all of its members, and is found as one.
#[test]
fn a_force_through_members_end_to_end_is_one_effect() {
    let d = of_mast(
        &format!("{MAST}overrides: {{hidden: {{of: [lower, middle, upper], add: {{axial_force: 4 kN}}}}}}\n"),
        3,
    );
    let first = &d.hypotheses[0];
    eprintln!("{}: {:?} {:?}", d.sentence, first.estimate, first.interval);
    assert_eq!(d.verdict, Verdict::MissingEffect);
    assert_eq!(first.id, "axial-preload@lower..upper");
    let [low, high] = first.interval.unwrap();
    assert!(low < 4000.0 && 4000.0 < high);
}

#[test]
fn a_mass_offset_behind_the_spar_is_found() {
    let edits = [
        ("inertia: {yy: Ix5_10}}", "inertia: {yy: Ix5_10}, offset: [0.05 m, 0 m, 0 m]}"),
        ("inertia: {yy: Ix6_11}}", "inertia: {yy: Ix6_11}, offset: [0.05 m, 0 m, 0 m]}"),
        ("inertia: {yy: Ix7_12}}", "inertia: {yy: Ix7_12}, offset: [0.05 m, 0 m, 0 m]}"),
        ("inertia: {yy: Ix8_13}}", "inertia: {yy: Ix8_13}, offset: [0.08 m, 0 m, 0 m]}"),
    ];
    let d = story("mass offset", &truth(&edits), |_| {}, 2);
    assert_eq!(d.hypotheses[0].name, "mass-offset");
    assert!(matches!(d.verdict, Verdict::MissingEffect | Verdict::SeveralEffects));
}

#[test]
fn a_mass_at_one_winglet_is_found_there() {
    let extra = ("  winglets: {nodes", "  hidden: {node: n13, mass: 0.06 kg}\n  winglets: {nodes");
    let d = story("point mass", &truth(&[extra]), |_| {}, 3);
    assert_eq!(d.verdict, Verdict::MissingEffect);
    assert_eq!(d.hypotheses[0].name, "point-mass");
    assert_eq!(d.hypotheses[0].location, "n13");
    // 2 936 when this was written; each costs a solution and its derivatives.
    assert!(d.work.linearizations < 3500, "{:?}", d.work);
}

/// Stiffness that scatters over the elements is no single effect, and two effects that imitate it are not an answer.
#[test]
fn a_change_of_every_element_is_no_effect() {
    let text = retune::samples::FRAME;
    let hidden = [
        ("left_column.1", 1.3),
        ("left_column.2", 0.75),
        ("right_column.1", 1.2),
        ("right_column.2", 0.75),
        ("girder.1", 0.7),
        ("girder.2", 1.3),
        ("girder.3", 1.25),
        ("girder.4", 0.75),
    ];
    let entry = |(of, factor): &(&str, f64)| format!("  hidden.{of}: {{of: [{of}], stiffness: {factor}}}\n");
    let (base, truth) =
        (model(text), model(&format!("{text}\noverrides:\n{}", hidden.iter().map(entry).collect::<String>())));
    let sensors = retune::update::node_sensors(&base);
    let test = twin_modes(&truth, &middle(&truth), &sensors, &noise(6, 9), "twin").unwrap();
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    eprintln!("{}", d.sentence);
    assert_eq!(d.verdict, Verdict::Unexplained);
    assert!(d.probability_other > 0.5, "{}", d.probability_other);
    let spread = d.spread.unwrap();
    assert_eq!(spread.properties().into_iter().collect::<Vec<_>>(), [Property::Stiffness]);
    assert!(spread.clear().count() >= 4, "{spread}");
    for found in spread.clear() {
        let (_, factor) = hidden.iter().find(|h| h.0 == found.part).unwrap();
        assert_eq!(found.factor > 1.0, *factor > 1.0, "{found:?}");
    }
}

#[test]
fn a_sensor_upside_down_wins_alone() {
    let flip = |t: &mut TestData| {
        for m in &mut t.modes {
            let s = m.shape.as_mut().unwrap();
            s[10] = -s[10];
        }
    };
    let d = story("sensor 11 flipped", &truth(&[]), flip, 4);
    assert_eq!(d.verdict, Verdict::MeasurementFault);
    assert_eq!(d.hypotheses[0].id, "sensor-sign@p11");
    assert!(d.hypotheses[0].tied_with.is_empty());
}

/// The wing with the bench on which its left half was tested too.
fn with_bench(text: &str) -> String {
    text.to_string() + "\nconfigurations:\n  bench: {supports: {bench: {nodes: [n1, n5, n10, n11, n12, n13]}}}\n"
}

/// Synthetic tests of the truth in flight and on the bench: six modes and four modes of the wing outboard of the clamp.
fn measured_twice(truth: &Model, theta: &[f64], seed: u64) -> [TestData; 2] {
    let options = noise(6, seed);
    let mut free = twin_modes(truth, theta, &sensors(), &options, "twin of a story").unwrap();
    free.name = "in flight".to_string();
    let bench = Model::new(truth.spec().configured("bench").unwrap(), &Registry::builtin()).unwrap().0;
    let sees =
        |s: &Sensor| retune::correlation::observation_matrix(&bench, std::slice::from_ref(s)).unwrap().amax() > 0.0;
    let outboard: Vec<Sensor> = sensors().into_iter().filter(sees).collect();
    let options = noise(4, seed + 100);
    let mut held = twin_modes(&bench, theta, &outboard, &options, "twin of a story").unwrap();
    held.name = "on the bench".to_string();
    held.configuration = Some("bench".to_string());
    let mut tests = [free, held];
    tests.iter_mut().flat_map(|t| &mut t.modes).for_each(|m| m.label = None);
    tests
}

fn told_by_both(base: &Model, tests: &[TestData; 2]) -> Diagnosis {
    let d = diagnose_tests(base, &[&tests[0], &tests[1]], &Settings::default()).unwrap();
    eprintln!("{:?}: {} (misfit {:.0} for {:.0})", d.verdict, d.sentence, d.misfit, d.degrees_of_freedom);
    for h in d.hypotheses.iter().take(5) {
        eprintln!("  {:50} p {:.3} lnB {:7.1} misfit {:.0}", h.id, h.probability, h.ln_bayes, h.misfit_after);
    }
    d
}

#[test]
fn two_tests_of_a_complete_model_are_explained_together() {
    let base = model(&with_bench(&wing()));
    let truth = model(&with_bench(&wing()).replace("section: wing}", "section: wing, subdivide: 3}"));
    let tests = measured_twice(&truth, &middle(&truth), 11);
    let d = told_by_both(&base, &tests);
    assert_eq!(d.verdict, Verdict::Adequate);
}

/// A clamp that gives shows on the bench only, and is not a hinge of the wing in flight.
#[test]
fn a_clamp_that_gives_is_found_on_the_bench() {
    let base = model(&with_bench(&wing()));
    let id = "root-flexibility@bench/left_wing.2:n5.ry";
    let structure = retune::effect::Context::default();
    let candidate = Effects::builtin().candidate(&retune::effect::Structure::new(&base, &structure), id).unwrap();
    let fine = with_bench(&wing()).replace("section: wing}", "section: wing, subdivide: 3}");
    let text = candidate.patch.apply_to_text(&fine).unwrap();
    let truth = model(&text);
    let mut theta = middle(&truth);
    let last = theta.len() - 1;
    theta[last] = 2.0 * candidate.parameters[0].typical;
    // The sensor in the middle of the clamp's element reads a shape that depends on the compliance.
    for &seed in first(1, &[12, 33, 36]) {
        let d = told_by_both(&base, &measured_twice(&truth, &theta, seed));
        assert_eq!(d.verdict, Verdict::MissingEffect, "seed {seed}");
        let first = &d.hypotheses[0];
        assert!(first.id == id || first.tied_with.iter().any(|t| t == id), "{}", first.id);
        assert!(first.id.contains("@bench/"), "{}", first.id);
    }
}

/// A sensor that both tests used is upside down in both.
#[test]
fn a_fault_of_a_sensor_is_one_fault_in_both_tests() {
    let base = model(&with_bench(&wing()));
    let truth = model(&with_bench(&wing()).replace("section: wing}", "section: wing, subdivide: 3}"));
    let mut tests = measured_twice(&truth, &middle(&truth), 13);
    // One that moves most on the bench: near the clamp a sign tells nothing there.
    let reads = |s: usize| tests[1].modes.iter().filter_map(|m| m.shape.as_ref()).map(|y| y[s].norm_sqr()).sum::<f64>();
    let most = (0..tests[1].sensors.len()).max_by(|&a, &b| reads(a).total_cmp(&reads(b))).unwrap();
    let name = tests[1].sensors[most].name.clone();
    for test in &mut tests {
        let s = test.sensors.iter().position(|s| s.name == name).unwrap();
        test.modes.iter_mut().filter_map(|m| m.shape.as_mut()).for_each(|shape| shape[s] = -shape[s]);
    }
    let d = told_by_both(&base, &tests);
    assert_eq!(d.verdict, Verdict::MeasurementFault);
    assert_eq!(d.hypotheses[0].id, format!("sensor-sign@{name}"));
}

/// Two sensors that both tests used are exchanged in the second one: cables are plugged anew for each test.
#[test]
fn a_fault_in_one_of_two_tests_is_found_there() {
    let base = model(&with_bench(&wing()));
    let truth = model(&with_bench(&wing()).replace("section: wing}", "section: wing, subdivide: 3}"));
    let mut tests = measured_twice(&truth, &middle(&truth), 14);
    let bench = &mut tests[1];
    // The one that moves most in the first mode, and the one that moves least.
    let first = bench.modes[0].shape.clone().unwrap().map(|v| v.re.abs());
    let (a, b) = (first.imin().min(first.imax()), first.imin().max(first.imax()));
    bench.modes.iter_mut().filter_map(|m| m.shape.as_mut()).for_each(|shape| shape.swap_rows(a, b));
    let names = [a, b].map(|s| bench.sensors[s].name.clone()).join("+");
    let d = told_by_both(&base, &tests);
    assert_eq!(d.verdict, Verdict::MeasurementFault);
    assert_eq!(d.hypotheses[0].id, format!("sensor-swap@{names} of on the bench"));
    let said = &d.hypotheses[0].patch;
    assert!(said.starts_with("in on the bench: exchange the channels"), "{said}");
}

/// A strip with a tip mass, of known stiffness and density.
const STRIP: &str = "
retune: 1
name: strip
active_dofs: [uz, ry]
parameters: {tip: {value: 60 g, bounds: [20 g, 200 g]}}
nodes: {n0: [0, 0, 0], n1: [0.25, 0, 0], n2: [0.5, 0, 0], n3: [0.75, 0, 0], n4: [1, 0, 0]}
beams: {strip: {chain: [n0, n1, n2, n3, n4], properties: {E: 70 GPa, Iy: 8e-10 m4, mass_per_length: 0.8 kg/m}, subdivide: 2}}
masses: {tip: {node: n4, mass: tip}}
supports: {clamp: {node: n0}}
";

/// A synthetic test of the strip with more mass along it; functions from one force, if wanted.
fn of_strip(with_functions: bool) -> TestData {
    use retune::data::{FrfFit, FrfQuantity, Place};
    use retune::update::{TwinFrfOptions, twin_frfs};
    let sensor = |k: usize| Sensor {
        name: format!("p{k}"),
        place: Place::Node { node: format!("n{k}"), position: None },
        offset: None,
        direction: [0.0, 0.0, 1.0],
        is_rotation: false,
        mass: None,
    };
    let sensors: Vec<Sensor> = (1..=4).map(sensor).collect();
    let base = model(STRIP);
    let context = retune::effect::Context::default();
    let structure = retune::effect::Structure::new(&base, &context);
    let hidden = Effects::builtin().candidate(&structure, "distributed-mass@strip").unwrap();
    let truth = model(&hidden.patch.apply_to_text(&STRIP.replace("subdivide: 2", "subdivide: 6")).unwrap());
    let theta = [0.06, 0.1];
    let options = TwinOptions { damping: Some(0.01), ..noise(4, 5) };
    let mut test = twin_modes(&truth, &theta, &sensors, &options, "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| (m.label, m.damping_ratio) = (None, None));
    if with_functions {
        let functions = TwinFrfOptions {
            lines_hz: (1..=60).map(|k| 1.3 * f64::from(k)).collect(),
            exciters: vec!["p2".to_string()],
            quantity: FrfQuantity::Accelerance,
            force_noise: 0.0,
            response_noise: 0.01,
            n_averages: 10,
        };
        test.frfs = Some(twin_frfs(&truth, &theta, &sensors, &options, &functions).unwrap());
        let fit = FrfFit { relative_sd: 0.05, loss_factor: Some(0.02), ..FrfFit::default() };
        test.frf_fit = Some(fit);
    }
    test
}

/// Ratios of a strip with Rayleigh's damping, against a model without any: the law, its sizes, and no other answer on stiffness and mass.
#[test]
fn ratios_tell_the_damping_of_a_model_without_any() {
    let base = model(STRIP);
    let context = retune::effect::Context::default();
    let structure = retune::effect::Structure::new(&base, &context);
    let sensor = |k: usize| Sensor {
        name: format!("p{k}"),
        place: retune::data::Place::Node { node: format!("n{k}"), position: None },
        offset: None,
        direction: [0.0, 0.0, 1.0],
        is_rotation: false,
        mass: None,
    };
    let sensors: Vec<Sensor> = (1..=4).map(sensor).collect();
    let damped = |ids: &[(&str, f64)]| {
        let mut text = STRIP.to_string();
        for (id, size) in ids {
            let hidden = Effects::builtin().candidate(&structure, id).unwrap();
            text = hidden.patch.apply_to_text(&text).unwrap();
            let name = hidden.parameters[0].name.as_str();
            text = retune::effect::set_parameter_values(&text, &[(name, *size)]).unwrap();
        }
        let options = TwinOptions { damping: None, damping_noise: 0.02, ..noise(6, 7) };
        let truth = model(&text);
        let theta = truth.parameters().nominal();
        twin_modes(&truth, &theta, &sensors, &options, "twin of a story").unwrap()
    };
    let mut test = damped(&[("mass-damping@whole", 2.0), ("stiffness-damping@strip", 4e-5)]);
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    let found = d.damping.unwrap();
    assert_eq!(found.laws[0].id, "mass-damping@whole + stiffness-damping@strip", "{}", found.sentence);
    for (term, truth) in found.laws[0].terms.iter().zip([2.0, 4e-5]) {
        let half = 0.5 * (term.interval[1] - term.interval[0]);
        assert!((term.value - truth).abs() < 2.0 * half && half < 0.2 * truth, "{term:?}");
    }
    test.modes.iter_mut().for_each(|m| m.damping_ratio = None);
    let without = diagnose(&base, &test, &Settings::default()).unwrap();
    assert!(without.damping.is_none());
    assert_eq!((without.verdict, &without.hypotheses), (d.verdict, &d.hypotheses));
}

/// More mass everywhere and less stiffness everywhere move frequencies alike and no shape; only functions know the scale.
#[test]
fn frequency_responses_tell_mass_from_stiffness() {
    let base = model(STRIP);
    let is_stiffness = |id: &str| id.starts_with("softening") || id.starts_with("bending-stiffness-change@strip.r");
    let d = diagnose(&base, &of_strip(false), &Settings::default()).unwrap();
    let together: Vec<&String> = std::iter::once(&d.hypotheses[0].id).chain(&d.hypotheses[0].tied_with).collect();
    eprintln!("modes alone: {together:?}");
    assert!(together.iter().any(|id| id.starts_with("distributed-mass")), "{together:?}");
    assert!(together.iter().any(|id| is_stiffness(id)), "{together:?}");
    let d = diagnose(&base, &of_strip(true), &Settings::default()).unwrap();
    eprintln!("with functions: {:?} {} {:?}", d.verdict, d.sentence, d.hypotheses[0].tied_with);
    assert_eq!(d.verdict, Verdict::MissingEffect);
    let mut together: Vec<&str> =
        std::iter::once(&d.hypotheses[0].id).chain(&d.hypotheses[0].tied_with).map(String::as_str).collect();
    together.sort_unstable();
    // In a plane, air that moves with the strip is mass along it.
    assert_eq!(together, ["air-mass@strip.z", "distributed-mass@strip"]);
}

/// The force acted at p2 and the file says p4.
#[test]
fn a_wrong_driving_point_is_found_by_the_functions() {
    let mut test = of_strip(true);
    let heavier = STRIP.replace("0.8 kg/m", "0.9 kg/m");
    test.frfs.as_mut().unwrap().references[0].name = "p4".to_string();
    let d = diagnose(&model(&heavier), &test, &Settings::default()).unwrap();
    eprintln!("{:?} {} {:?}", d.verdict, d.sentence, d.hypotheses[0].tied_with);
    assert_eq!(d.verdict, Verdict::MeasurementFault);
    assert_eq!(d.hypotheses[0].id, "driving-point@p4:p2");
}

/// A factor on one sensor, in its functions alone and in its shapes too; its channel has the name of its node.
#[test]
fn a_wrong_gain_is_found_in_the_functions() {
    let base = model(&STRIP.replace("0.8 kg/m", "0.9 kg/m"));
    let mut test = of_strip(true);
    test.sensors[2].name = "n3.z".to_string();
    let set = test.frfs.as_mut().unwrap();
    set.responses[2].name = "n3".to_string();
    for line in 0..set.n_lines() {
        let at = set.index(line, 0, 2);
        set.h[at] *= 1.3;
    }
    let found = |test: &TestData| {
        let d = diagnose(&base, test, &Settings::default()).unwrap();
        eprintln!("{:?} {} {:?}", d.verdict, d.sentence, d.hypotheses[0].estimates);
        assert_eq!(d.verdict, Verdict::MeasurementFault);
        assert!((d.hypotheses[0].estimates[0].value / 1.3 - 1.0).abs() < 0.03);
        d.hypotheses[0].id.clone()
    };
    assert_eq!(found(&test), "function-gain@n3.z");
    for mode in &mut test.modes {
        mode.shape.as_mut().unwrap()[2] *= 1.3;
    }
    assert_eq!(found(&test), "sensor-gain@n3.z");
}
