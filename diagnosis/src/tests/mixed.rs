//! Shapes of close modes that imperfections mix.

use super::*;
use retune::data::TestMode;
use retune::effect::{Candidate, Context, candidates};
use retune::fault::{Bench, Faults, PlacedFault, SingleTest};
use retune::update::TwinFault;

/// Coupling of close modes over λ: of 1.6 % apart it turns shapes by 15 degrees.
const COUPLING: f64 = 0.008;

/// Twelve modes with the noise of the stories, the close ones mixed where a coupling is given.
fn close(truth: &Model, theta: &[f64], coupling: Option<f64>) -> TestData {
    let made = |options: &TwinOptions| twin_modes(truth, theta, &sensors(), options, "twin of a story").unwrap();
    let options = noise(12, 4);
    let exact = made(&TwinOptions { frequency_noise: 0.0, shape_noise: 0.0, ..options.clone() });
    let tests = SingleTest::new(&exact);
    let only = Faults::none().with(Faults::builtin().find("modes-mixed").unwrap());
    let placed = only.placed(&Bench { tests: &tests, positions: None, nodes: Vec::new() });
    let faults = coupling.map(|k| TwinFault::new(&placed[0].id(&tests)).with(k)).into_iter().collect();
    let mut test = made(&TwinOptions { faults, ..options });
    test.modes.iter_mut().for_each(|m| m.label = None);
    test
}

fn is_mixed(h: &HypothesisResult) -> bool {
    h.name == "modes-mixed"
}

/// A right model of which the test has its close modes mixed: nothing is missing, and the angles are told. Without a coupling the same test is
/// adequate.
#[test]
fn mixed_modes_are_no_missing_effect() {
    let base = model(&wing());
    let d = diagnose(&base, &close(&base, &middle(&base), Some(COUPLING)), &Settings::default()).unwrap();
    assert_eq!(d.verdict, Verdict::MeasurementFault, "{}", d.sentence);
    assert!(is_mixed(&d.hypotheses[0]), "{}", d.sentence);
    assert!(d.sentence.contains("the model explains the test but for mixed shapes of close modes"), "{}", d.sentence);
    assert!(d.hypotheses[0].estimates.iter().any(|e| e.value > 10.0 && e.unit == "deg"));
    let clean = diagnose(&base, &close(&base, &middle(&base), None), &Settings::default()).unwrap();
    assert_eq!(clean.verdict, Verdict::Adequate, "{}", clean.sentence);
}

/// A mass that is missing where shapes are mixed too: both are named, and what is learnt is a model with the mass and a test that says which modes
/// are one space.
#[test]
fn an_effect_is_found_behind_mixed_modes() {
    let base = model(&wing());
    let id = "point-mass@n8";
    let all = Effects::builtin();
    let hidden = candidates(&base, &all, &Context::default());
    let hidden = hidden.into_iter().find(|c| c.id() == id).unwrap().build(&base, &Registry::builtin()).unwrap();
    let test = close(&hidden.model, &hidden.theta(&middle(&base), &[0.06]), Some(COUPLING));
    let tried = ["point-mass", "eccentric-mass", "node-position", "stiffness-change", "taper"];
    let effects = tried.iter().filter_map(|name| all.find(name)).fold(Effects::none(), Effects::with);
    let learned = learn(&base, &test, &Settings { effects, ..Settings::default() }, false, 4).unwrap();
    let d = &learned.steps[0].diagnosis;
    assert_eq!(d.verdict, Verdict::SeveralEffects, "{}", d.sentence);
    let two = &d.hypotheses[..2];
    assert!(two.iter().any(is_mixed) && two.iter().any(|h| h.id == id), "{}", d.sentence);
    let added: Vec<String> = learned.steps.iter().filter_map(|s| s.added.as_ref().map(Candidate::id)).collect();
    assert_eq!(added, [id]);
    let spaces = |m: &TestMode| m.space.is_some();
    assert!(learned.tests[0].modes.iter().any(spaces), "the test is kept with its spaces");
    assert_eq!(learned.steps.last().unwrap().diagnosis.verdict, Verdict::Adequate);
}

/// What a fault edits is in the numbers of its test: an id names the modes of one test.
#[test]
fn mixed_modes_have_an_id() {
    let base = model(&wing());
    let test = close(&base, &middle(&base), None);
    let tests = SingleTest::new(&test);
    let bench = Bench { tests: &tests, positions: None, nodes: Vec::new() };
    let placed = Faults::builtin().placed(&bench);
    let own = placed.iter().find(|p| p.name() == "modes-mixed").unwrap();
    assert_eq!(&PlacedFault::of_id(&own.id(&tests), &Faults::builtin(), &bench).unwrap(), own);
    // Those of one space already are not sought again.
    let again = own.taken_out_of(&test, 0.0);
    let tests = SingleTest::new(&again);
    let placed = Faults::builtin().placed(&Bench { tests: &tests, positions: None, nodes: Vec::new() });
    assert!(placed.iter().all(|p| p.name() != "modes-mixed"));
}
