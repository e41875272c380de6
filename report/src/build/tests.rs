//! What reports say, against closed forms and against the analyses that they show.

use super::super::data::{Category, Outcome, Structure};
use super::super::html;
use super::structure::{Places, structure};
use super::*;
use retune::data::{FrfQuantity, read_test};
use retune::model::{Registry, load};
use retune::update::{TwinFrfOptions, TwinOptions, node_sensors, twin_frfs, twin_modes};
use retune_diagnosis::diagnose;

fn model(name: &str) -> Model {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../models").join(name);
    load(&std::fs::read_to_string(path).unwrap(), &Registry::builtin()).unwrap().0
}

fn gvt() -> TestData {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/bff_gvt.yaml");
    read_test(&std::fs::read_to_string(path).unwrap()).unwrap().0
}

/// A test of the model itself, SYNTHETIC, with noise of shapes.
fn own_test(model: &Model, shape_noise: f64, seed: u64) -> TestData {
    let options = TwinOptions { n_modes: 5, frequency_noise: 1e-3, shape_noise, seed, ..TwinOptions::default() };
    twin_modes(model, &model.parameters().nominal(), &node_sensors(model), &options, "a twin").unwrap()
}

/// f ∝ √E, √G, 1/√ρ by mode: a tenth of the range of E moves a bending frequency by 100 · ½ · 0.1 (u - l)/E per cent, and
/// of ρ by minus as much of its own; a uniform structure keeps its shapes.
#[test]
fn sensitivities_of_a_uniform_strip_are_those_of_its_closed_form() {
    let strip = model("cantilever.yaml");
    let test = own_test(&strip, 1e-3, 1);
    let a = assess_for_report(&strip, &strip.parameters().nominal(), &test).unwrap();
    let list = disagreement::sensitivities(Case { model: &strip, test: &test, assessment: &a });
    assert_eq!(list[0].columns, ["E", "G", "rho"]);
    assert_eq!(list.len(), 2);
    for (row, shape) in list[0].values.iter().zip(&list[1].values) {
        // Every mode is bending (E) or torsion (G), but for shear: the two shares add up to one half.
        let (e, g) = (row[0] / (0.1 * 50.0 / 205.0), row[1] / (0.1 * 30.0 / 79.0));
        assert!((e + g - 50.0).abs() < 0.01, "{row:?}");
        assert!((row[2] + 50.0 * 0.1 * 1500.0 / 7850.0).abs() < 1e-3, "{row:?}");
        assert!(shape[2] < 1e-6, "{shape:?}");
    }
}

#[test]
fn functions_of_the_same_model_agree_in_every_criterion() {
    let strip = model("cantilever.yaml");
    let sensors = node_sensors(&strip);
    // The modes have a little noise, so that they have standard deviations; the functions have none.
    let options = TwinOptions {
        n_modes: 4,
        damping: Some(0.02),
        frequency_noise: 1e-4,
        shape_noise: 1e-3,
        ..TwinOptions::default()
    };
    let theta = strip.parameters().nominal();
    let test = twin_modes(&strip, &theta, &sensors, &options, "a twin").unwrap();
    let lines = TwinFrfOptions {
        lines_hz: (1..=300).map(|k| f64::from(k) * 0.5).collect(),
        exciters: vec![sensors.last().unwrap().name.clone()],
        quantity: FrfQuantity::Mobility,
        force_noise: 0.0,
        response_noise: 0.0,
        n_averages: 1,
    };
    let set = twin_frfs(&strip, &theta, &sensors, &options, &lines).unwrap();
    let a = assess_for_report(&strip, &theta, &test).unwrap();
    let case = Case { model: &strip, test: &test, assessment: &a };
    let mut data = of_comparison(case).unwrap();
    add_responses(&mut data, case, None, &set, "synthetic").unwrap();
    data.validate().unwrap();
    let f = data.frfs.as_ref().unwrap();
    assert_eq!((f.unit.as_str(), f.channels.len(), f.origin.as_str()), ("(m/s)/N", sensors.len(), "synthetic"));
    assert!((f.bands[0].from_hz - 0.5).abs() < 1e-12 && (f.bands.last().unwrap().to_hz - 150.0).abs() < 1e-12);
    for band in f.bands.windows(2) {
        assert_eq!(band[0].to_hz, band[1].from_hz);
    }
    for band in &f.bands {
        assert!(band.csac.unwrap() > 1.0 - 1e-9 && band.csf.unwrap() > 1.0 - 1e-9, "{band:?}");
    }
    // A sensor across the plane of motion reads nothing and has no criterion.
    let known: Vec<f64> = f.channels.iter().flat_map(|c| &c.frac).flatten().copied().collect();
    assert!(known.len() > f.bands.len() && known.iter().all(|v| *v > 1.0 - 1e-9));
    let fdac = &f.fdac[0];
    assert!((0..fdac.rows.len()).all(|i| fdac.values[i][i] > 0.999) && fdac.rows.len() == 60);

    // Half the stiffness: the functions differ, and the ridge of FDAC leaves the diagonal.
    let mut soft = theta.clone();
    soft[0] *= 0.5;
    let b = assess_for_report(&strip, &soft, &test).unwrap();
    let wrong = Case { model: &strip, test: &test, assessment: &b };
    add_responses(&mut data, wrong, Some(case), &set, "synthetic").unwrap();
    let f = data.frfs.as_ref().unwrap();
    assert!(f.bands.iter().any(|b| b.csac.unwrap() < 0.9));
    assert!(f.channels.iter().any(|c| c.frac_before.iter().flatten().any(|v| *v > 0.999)));
    assert!(f.channels.iter().any(|c| c.frac.iter().flatten().any(|v| *v < 0.5)));

    // Points that the test does not know are named.
    let mut other = set.clone();
    other.responses[0].name = "nobody".into();
    add_responses(&mut data, case, None, &other, "measured").unwrap();
    assert!(data.meta.warnings.iter().any(|w| w.contains("nobody")), "{:?}", data.meta.warnings);
}

#[test]
fn a_right_model_is_explained_and_shows_shares_of_energy() {
    let frame = model("frame.yaml");
    let test = own_test(&frame, 0.01, 7);
    let a = assess_for_report(&frame, &frame.parameters().nominal(), &test).unwrap();
    let data = of_comparison(Case { model: &frame, test: &test, assessment: &a }).unwrap();
    data.validate().unwrap();
    let s = data.structure.as_ref().unwrap();
    assert_eq!(data.meta.verdict.as_ref().unwrap().level, Level::Good);
    assert!(!data.localization.as_ref().unwrap().stands_out, "{:?}", data.localization);
    let energies: Vec<_> = s.fields.iter().filter(|f| f.name.starts_with("strain energy")).collect();
    assert_eq!(energies.len(), 5);
    for f in energies {
        let sum: f32 = f.values.0.iter().filter(|v| v.is_finite()).sum();
        assert!((sum - 100.0).abs() < 1e-3, "{}: {sum}", f.name);
    }
    let sensors = s.fields.iter().find(|f| f.name == "misfit of the sensors").unwrap();
    let known: Vec<f32> = sensors.values.0.iter().copied().filter(|v| v.is_finite()).collect();
    let mean = known.iter().sum::<f32>() / known.len() as f32;
    assert!((0.5..1.7).contains(&mean), "noise alone leaves about 1, not {mean}");
}

#[test]
fn places_are_found_by_the_names_that_effects_use() {
    let bff = model("bff.yaml");
    let test = gvt();
    let places = Places::new(&bff, &test);
    let s = structure(&bff, &bff.parameters().nominal(), &test).unwrap();
    let names = |p: &super::super::data::Place| {
        let elements = p.elements.iter().map(|&e| s.elements[e].name.clone());
        elements.chain(p.nodes.iter().map(|&n| s.nodes[n].name.clone())).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(names(&places.on_structure("left_wing.3")), "left_wing.3");
    assert_eq!(
        names(&places.on_structure("left_wing+right_wing.y_lumps")),
        "left_wing.1 left_wing.2 left_wing.3 left_wing.4 right_wing.1 right_wing.2 right_wing.3 right_wing.4"
    );
    assert_eq!(names(&places.on_structure("n8+n13.ry")), "n8 n13");
    assert_eq!(names(&places.on_structure("left_wing.1:n5.ry")), "n5");
    assert_eq!(places.on_structure("whole").elements.len(), s.elements.len());
    assert_eq!(names(&places.on_structure("no such place")), "");
    let sensors = |text: &str| {
        places.on_test(text).sensors.iter().map(|&i| test.sensors[i].name.clone()).collect::<Vec<_>>().join(" ")
    };
    for text in ["p3+p4", "p3.x+p4"] {
        assert_eq!(sensors(text), "p3 p4");
    }
    assert_eq!(sensors("p11:n5"), "p11");
    assert_eq!(sensors("mode 3+mode 4"), "");
}

/// The whole story of a hidden mass: diagnosis, places, ties, evidence, patch; then learning with its waterfall.
#[test]
fn a_hidden_mass_is_told_as_it_was_found() {
    let (strip, _, test) = super::super::fixture::learned::case();
    let settings = retune_diagnosis::Settings::default();
    let found = diagnose(&strip, &test, &settings).unwrap();
    let d = diagnosis(&found, &strip, &test);
    assert_eq!(d.hypotheses.len(), found.hypotheses.len() + 2);
    let sum: f64 = d.hypotheses.iter().filter_map(|h| h.probability).sum();
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    assert_ne!(d.outcome, Outcome::Adequate);
    let best = &d.hypotheses[0];
    assert_eq!(best.id, found.hypotheses[0].id);
    for h in d.hypotheses.iter().filter(|h| h.category == Category::Effect) {
        assert!(h.place.nodes.len() + h.place.elements.len() > 0, "{} has no place", h.id);
        assert!(!h.summary.is_empty() && !h.patch.is_empty() && !h.estimates.is_empty(), "{}", h.id);
        assert!(!h.evidence_for.is_empty() || !h.evidence_against.is_empty());
    }
    assert!(best.evidence_for.iter().any(|e| e.contains("misfit falls")), "{:?}", best.evidence_for);

    let learned = super::super::fixture::learned::learned(&strip, &test);
    let data = of_learning(&[(&strip, &test)], &learned).unwrap();
    data.validate().unwrap();
    let steps = data.steps.as_ref().unwrap();
    assert_eq!(steps.steps.len(), learned.steps.len() + 1);
    assert_eq!((steps.steps[0].name.as_str(), steps.steps[1].name.as_str()), ("initial", "refitted"));
    // A fit cannot be worse than where it started.
    assert!(steps.steps[1].misfit <= steps.steps[0].misfit);
    for (shown, step) in steps.steps[1..].iter().zip(&learned.steps) {
        assert_eq!(shown.misfit, step.misfit);
        assert_eq!(shown.held_out, Some(step.held_out.iter().sum()));
        let per_mode: f64 = shown.per_mode.iter().flatten().sum();
        assert!((per_mode / step.misfit - 1.0).abs() < 0.2, "{per_mode} of {}", step.misfit);
    }
    let added = learned.steps[0].added.as_ref().unwrap();
    assert_eq!(steps.steps[2].name, format!("+ {}", added.id()));
    assert_eq!(data.earlier_diagnoses.len(), learned.steps.len() - 1);
    assert_eq!(data.earlier_diagnoses[0].title, "refitted");
    assert!(html(&data).unwrap().len() < 6_000_000);

    // What `learn --json` keeps gives the same steps again.
    let records: Vec<LearningStep> = learned.steps.iter().map(LearningStep::from).collect();
    let text = serde_json::to_string(&records).unwrap();
    let back: Vec<LearningStep> = serde_json::from_str(&text).unwrap();
    assert_eq!(back, records);
}

#[test]
fn the_report_of_an_update_is_named_after_the_test_and_its_number_is_short() {
    let strip = model("cantilever.yaml");
    let mut theta = strip.parameters().nominal();
    theta[0] *= 0.95;
    let sensors = node_sensors(&strip);
    let options = TwinOptions { n_modes: 4, frequency_noise: 1e-3, shape_noise: 0.01, ..TwinOptions::default() };
    let mut test = twin_modes(&strip, &theta, &sensors, &options, "a twin").unwrap();
    test.name = "strip in the laboratory".into();
    let settings = retune::update::Settings::default();
    let u = retune::update::update(&strip, &test, &settings, retune::update::Controls::default()).unwrap();
    let data = of_update(&strip, &test, &u).unwrap();
    data.validate().unwrap();
    assert_eq!(data.meta.title, "strip in the laboratory");
    assert!(data.meta.subtitle.contains("update of: Steel cantilever"));
    let v = data.meta.verdict.as_ref().unwrap();
    assert_eq!(v.number, format!("{} → {}", number(u.before.misfit.chi_squared), number(u.after.misfit.chi_squared)));
    assert!(v.number.chars().count() <= 22, "{}", v.number);
    // Properties are those of the optimum, not of the file.
    let modulus = |s: &Structure| {
        let first = &s.elements[0];
        let shared = first.property_set.map_or(&first.properties, |k| &s.property_sets[k].properties);
        shared.iter().find(|p| p.name == "EIy" || p.name == "E").map(|p| p.value.clone())
    };
    let e = modulus(data.structure.as_ref().unwrap());
    let initial = structure(&strip, &strip.parameters().nominal(), &test).unwrap();
    assert!(e.is_some() && e != modulus(&initial));
}
