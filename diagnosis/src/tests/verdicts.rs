//! Stories of answers that must not be believed: noise that is not noise, faults that explain the data away, several things at once; and that
//! probabilities, Bayes factors and verdicts agree.

#![allow(clippy::format_collect, reason = "texts of a few lines, where reading matters more than one allocation")]

use super::frame::told;
use super::*;
use crate::benchmark::{Plan, benchmark};
use retune::data::Correction;
use retune::effect::Candidate;

const FRAME: &str = retune::samples::FRAME;

/// What is stated alone: what stands beside one of two that are named has its Bayes factor against that one.
fn alone(d: &Diagnosis) -> impl Iterator<Item = &HypothesisResult> {
    let named: &[String] = d.together.as_ref().map_or(&[], |t| &t.ids);
    d.hypotheses.iter().filter(|h| !named.contains(&h.id) && h.misfit_before == d.misfit)
}

/// Largest departure of ln P from ln odds + ln B, up to what is common to all that is compared, of what is stated alone.
fn departure(d: &Diagnosis) -> f64 {
    let mut terms = vec![
        (d.probability_none, d.ln_odds_none + d.ln_bayes_none),
        (d.probability_other, d.ln_odds_other + d.ln_bayes_other),
    ];
    terms.extend(d.together.iter().map(|t| (t.probability, t.ln_odds + t.ln_bayes)));
    terms.extend(alone(d).map(|h| (h.probability, h.ln_odds + h.ln_bayes)));
    let top = terms.iter().map(|t| t.1).fold(f64::NEG_INFINITY, f64::max);
    let of_top = terms.iter().find(|t| t.1 == top).map_or(0.0, |t| t.0);
    terms.iter().map(|(p, ln)| (p - of_top * (ln - top).exp()).abs()).fold(0.0, f64::max)
}

/// A coupling of bending and twist changes two modes of the flying wing so much that at the base they look foreign, with probabilities up to
/// 0.996, and the others name the coupling. With it in the model both have partners: then all modes are explained, and none is called foreign.
#[test]
fn what_is_named_gives_modes_their_partners() {
    let plan = Plan {
        structures: vec!["flying-wing".to_string()],
        null: 2,
        seed: 26,
        only: Some("bend-twist".to_string()),
        ..Plan::default()
    };
    let outcomes = benchmark(&plan, &Settings::default(), &|_, _| {}).unwrap().outcomes;
    let [outcome] = &outcomes[..] else { panic!("one case, found {}", outcomes.len()) };
    assert!(outcome.right && outcome.removed > 0.99, "{outcome:?}");
    assert_eq!(outcome.true_lost, [0, 8]);
    let d = outcome.diagnosis.as_ref().unwrap();
    assert!(d.foreign_modes.is_empty() && !d.sentence.contains("foreign"), "{}", d.sentence);
    // Two modes more are data, and they determine the coupling better.
    assert!(d.hypotheses[0].misfit_after < 1.3 * d.degrees_of_freedom);
}

/// On twins with nothing hidden, an effect, a fault and a change outside the catalogue, every stated probability is its prior odds times its
/// stated Bayes factor, over one sum; and no verdict names what is less probable than all else.
#[test]
fn probabilities_are_odds_times_bayes_factors() {
    let mut outcomes = Vec::new();
    for only in ["nothing", "mass", "sensor-s", "scattered-stiffness"] {
        let plan = Plan {
            structures: vec!["cantilever".to_string()],
            null: 2,
            seed: 26,
            only: Some(only.to_string()),
            ..Plan::default()
        };
        outcomes.extend(benchmark(&plan, &Settings::default(), &|_, _| {}).unwrap().outcomes);
    }
    let all: Vec<(&str, &Diagnosis)> =
        outcomes.iter().filter_map(|o| Some((o.id.as_str(), o.diagnosis.as_ref()?))).collect();
    assert!(
        ["nothing", "scattered-", "sensor-sign", "mass-offset"].iter().all(|w| all.iter().any(|c| c.0.contains(w))),
        "{:?}",
        all.iter().map(|c| c.0).collect::<Vec<_>>()
    );
    for (id, d) in all {
        assert!(departure(d) < 1e-9, "{id}: {} {d:#?}", departure(d));
        let together = d.together.as_ref().map_or(0.0, |t| t.probability);
        let alone: f64 = alone(d).map(|h| h.probability).sum();
        let sum = alone + together + d.probability_none + d.probability_other;
        assert!(sum < 1.0 + 1e-9, "{id}: {alone} + {together} + {} + {}", d.probability_none, d.probability_other);
        match d.verdict {
            Verdict::MissingEffect | Verdict::MeasurementFault | Verdict::SeveralEffects => {
                assert!(d.probability_none < 0.5 && d.probability_only_other < 0.5, "{id}: {}", d.sentence);
            }
            Verdict::Unexplained | Verdict::Adequate | Verdict::NoiseOrModel => {}
        }
    }
}

/// A test of the portal frame by one of these texts, at a sensor on every node.
fn of_frame(truth: &str, seed: u64) -> (Model, TestData) {
    let (base, truth) = (model(FRAME), model(truth));
    let sensors = retune::update::node_sensors(&base);
    let mut test = twin_modes(&truth, &middle(&truth), &sensors, &noise(7, seed), "twin of a story").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    (base, test)
}

/// Standard deviations stated so many times too small.
fn understated(test: &mut TestData, factor: f64) {
    for mode in &mut test.modes {
        mode.frequency_hz.sd /= factor;
        mode.shape_sd.iter_mut().for_each(|sd| *sd /= factor);
    }
}

/// Noise somewhat larger than stated is noise; far larger, the stated noise or the model is wrong, and both numbers are told.
#[test]
fn noise_far_beyond_the_stated_one_is_no_explanation() {
    let cases = [(1.6, Verdict::Adequate), (8.0, Verdict::NoiseOrModel), (4.0, Verdict::NoiseOrModel)];
    for &(factor, verdict) in first(2, &cases) {
        let (base, mut test) = of_frame(FRAME, 3);
        understated(&mut test, factor);
        let d = told(&base, &test);
        assert_eq!(d.verdict, verdict, "{factor}: {}", d.sentence);
        assert!((d.noise_factor / factor - 1.0).abs() < 0.25, "{factor}: {}", d.noise_factor);
        if verdict == Verdict::NoiseOrModel {
            let words =
                ["the stated noise or the model is wrong", "times as large as stated", "has a MAC of", "or more"];
            assert!(words.iter().all(|w| d.sentence.contains(w)), "{}", d.sentence);
            assert!(d.sentence.contains(&format!("{:.1} times", d.noise_factor)), "{}", d.sentence);
        }
        assert!(departure(&d) < 1e-9);
    }
}

/// The MAC that noise leaves is that of shapes with the noise: a pair that agrees less is found, one that agrees as well is not.
#[test]
fn a_shape_that_agrees_less_than_noise_lets_it_is_found() {
    use crate::screen::noise::worst_shape;
    let (base, mut test) = of_frame(FRAME, 5);
    let fit = |test: &TestData| stage(Scene::new(&base, &[test]).unwrap(), &[], 1.0, &Settings::default()).unwrap().fit;
    let right = worst_shape(&fit(&test), 1.0, 1).unwrap();
    assert!(right.p_value > 0.01 && right.mac > right.least, "{right:?}");
    let shape = test.modes[4].shape.as_mut().unwrap();
    let size = shape.camax();
    shape.iter_mut().enumerate().for_each(|(k, v)| v.re += 0.15 * size * if k % 2 == 0 { 1.0 } else { -1.0 });
    let wrong = worst_shape(&fit(&test), 1.0, 1).unwrap();
    assert!(wrong.mode == 4 && wrong.p_value < 0.001 && wrong.mac < wrong.least, "{wrong:?}");
    // Noise of that size would leave as little.
    let larger = worst_shape(&fit(&test), 0.1, 1).unwrap();
    assert!(larger.p_value > 0.01, "{larger:?}");
}

/// A chain of springs stands for a tower of eighteen storeys that bends: three frequencies of a cantilever, 1 : 6.27 : 17.55, where a chain
/// has 1 : 3 : 5. No slip of a frequency is the answer.
#[test]
fn a_wrong_form_of_the_model_is_no_slip_of_frequencies() {
    let storeys = 18;
    let nodes: String = (0..=storeys).map(|i| format!("  n{i}: [0, 0, {}]\n", 3 * i)).collect();
    let springs: String =
        (1..=storeys).map(|i| format!("  s{i}: {{nodes: [n{}, n{i}], k: {{ux: k}}}}\n", i - 1)).collect();
    let masses: String = (1..=storeys).map(|i| format!("  m{i}: {{node: n{i}, mass: m}}\n")).collect();
    let text = |m: &str| {
        format!(
            "retune: 1\nname: chain\nactive_dofs: [ux]\nparameters:\n  k: {{value: 4e8 N/m, bounds: [1e8 N/m, 1.6e9 N/m]}}\n  \
             m: {{value: 2e5 kg{m}}}\nnodes:\n{nodes}springs:\n{springs}masses:\n{masses}supports:\n  ground: {{node: n0}}\n"
        )
    };
    // (β_n L)² of a clamped and free beam.
    let ratios = [1.0, 6.26689, 17.5475];
    for bounds in ["", ", bounds: [1.5e5 kg, 2.5e5 kg]"] {
        let base = model(&text(bounds));
        for &lowest in first(1, &[0.35, 0.6]) {
            let modes: String = ratios
                .iter()
                .map(|r| format!("  - {{frequency: {} Hz, frequency_sd: 0.5 %, source: s}}\n", lowest * r))
                .collect();
            let test = read_test(&format!(
                "retune_test: 1\nname: tower\nsources: {{s: {{kind: synthetic, text: closed form}}}}\nmodes:\n{modes}"
            ));
            let test = test.unwrap().0;
            let d = told(&base, &test);
            assert!(d.verdict != Verdict::Adequate);
            for h in d.hypotheses.iter().filter(|h| h.name == "mode-frequency") {
                assert!(h.probability < 0.5, "{} {}", h.id, h.probability);
            }
            let slips = |s: &Step| s.corrected.as_ref().is_some_and(|id| id.starts_with("mode-frequency"));
            let learned = learn(&base, &test, &Settings::default(), true, 3).unwrap();
            assert!(!learned.steps.iter().any(slips), "{:?}", learned.steps.last().map(|s| &s.diagnosis.sentence));
        }
    }
}

/// A clamp that gives, a mass and a sensor that is upside down, at once: the answer says that several things are wrong and names one of them
/// first, nothing is said of the mesh, and learning finds all three.
#[test]
fn three_things_that_are_wrong_are_told_and_learnt() {
    let hidden = FRAME.replace("\nmasses:\n", "\nmasses:\n  hidden: {node: quarter_right, mass: 1.5 kg}\n")
        + "overrides:\n  root: {of: [left_column.1], set: {end1_compliance_rz: 2e-5}}\n";
    let (base, mut test) = of_frame(&hidden, 3);
    let turned = test.sensors.iter().position(|s| s.name == "corner_right.ux").unwrap();
    test.modes.iter_mut().filter_map(|m| m.shape.as_mut()).for_each(|shape| shape[turned] = -shape[turned]);
    let right =
        ["point-mass@quarter_right", "root-flexibility@left_column.1:foot_left.rz", "sensor-sign@corner_right.ux"];
    let d = told(&base, &test);
    assert_eq!(d.verdict, Verdict::SeveralEffects, "{}", d.sentence);
    assert!(right.contains(&d.hypotheses[0].id.as_str()), "{}", d.hypotheses[0].id);
    assert!(d.sentence.starts_with("several things are wrong; first ") && d.sentence.contains("`retune learn`"));
    assert!(!d.sentence.contains("mesh"), "{}", d.sentence);
    assert!(departure(&d) < 1e-9);
    let learned = learn(&base, &test, &Settings::default(), false, 6).unwrap();
    let steps = &learned.steps;
    let mut found: Vec<String> =
        steps.iter().filter_map(|s| s.added.as_ref().map(Candidate::id).or_else(|| s.corrected.clone())).collect();
    found.sort();
    let last = steps.last().unwrap();
    assert_eq!(found, right, "{}", last.diagnosis.sentence);
    assert_eq!((last.diagnosis.verdict, &learned.attempt), (Verdict::Adequate, &None));
    // What has been taken out of the readings is kept for functions that are read beside them.
    assert_eq!(learned.tests[0].corrections, [Correction::factor("corner_right.ux", -1.0)]);
}

/// Faults as they are taken out of a test are taken out of functions that are read beside it, after the test has been written and read.
#[test]
fn functions_beside_a_corrected_test_are_corrected_too() {
    use retune::data::{corrected_functions, write_test};
    use retune::fault::{At, PlacedFault, SensorAxis, SensorGain, SensorSign, SensorSwap};
    let clean = of_strip(true);
    let (set, mut test) = (clean.frfs.clone().unwrap(), TestData { frfs: None, frf_fit: None, ..clean.clone() });
    test.sensors[0].direction = [1.0, 0.0, 0.0];
    let faults = [
        (PlacedFault::new(&SensorSign, At::Sensor(1)), 1.0),
        (PlacedFault::new(&SensorGain, At::Sensor(2)), 1.25),
        (PlacedFault::new(&SensorSwap, At::Sensors(2, 3)), 1.0),
        (PlacedFault::new(&SensorAxis, At::Axis(0, 2)), 1.0),
    ];
    // The functions as those faults make them, from the last to the first.
    let mut spoiled = set.clone();
    for line in 0..set.n_lines() {
        let at = |k: usize| set.index(line, 0, k);
        spoiled.h.swap(at(2), at(3));
        spoiled.h[at(2)] *= 1.25;
        spoiled.h[at(1)] = -spoiled.h[at(1)];
    }
    spoiled.responses[0].direction = Some([1.0, 0.0, 0.0]);
    for (fault, number) in &faults {
        test = fault.taken_out_of(&test, *number);
    }
    let read = read_test(&write_test(&test)).unwrap().0;
    assert_eq!(read.corrections, test.corrections);
    let found = corrected_functions(spoiled, &read.sensors, &read.corrections);
    let error = found.h.iter().zip(&set.h).map(|(a, b)| (a - b).norm() / b.norm()).fold(0.0, f64::max);
    assert!(error < 1e-12, "{error}");
    assert_eq!(found.responses[0].direction, Some([0.0, 0.0, 1.0]));
}
