//! What could have made a mode that looks foreign.

use super::*;
use crate::problem::scene::Scene;
use crate::screen::stage::placed;
use crate::search::one_cause::{OneCause, one_cause_of};
use crate::thresholds::MISREAD;
use retune::data::Standing;
use retune::update::node_sensors;

/// A body on a spring brings a mode whose shape shows its place: it is among what could have made the mode, and hardly anything else at few dofs is.
#[test]
fn the_shape_of_a_store_shows_its_place() {
    let base = model(retune::samples::AEROPLANE);
    let settings = Settings::default();
    let sensors = node_sensors(&base);
    let twin = |m: &Model, theta: &[f64]| twin_modes(m, theta, &sensors, &noise(8, 3), "twin of a story").unwrap();
    let scene = |test: &TestData| Scene::new(&base, &[test]).unwrap();
    let all = placed(&scene(&twin(&base, &middle(&base))), &settings);
    let id = "sprung-mass@r4.uz".to_string();
    let store = all.iter().find(|c| c.id() == id).unwrap_or_else(|| panic!("{id}"));
    // 0.3 kg at 20 Hz.
    let patched = store.build(&base, &Registry::builtin()).unwrap();
    let test = twin(&patched.model, &patched.theta(&middle(&base), &[0.3, 4737.0]));
    let scene = scene(&test);
    let comparisons = scene.comparisons().unwrap();
    let settled = settings.pairing.settle(&comparisons, &scene.start(), MISREAD).unwrap();
    let decided = scene.with_modes(settled.tests);
    let is_foreign = |m: &usize| matches!(decided.test.modes[*m].standing, Standing::Aside { foreign: Some(_), .. });
    let foreign: Vec<usize> = (0..decided.test.modes.len()).filter(is_foreign).collect();
    assert!(!foreign.is_empty(), "{id}");
    let cause = one_cause_of(&decided, &settled.x, &foreign, &settings).unwrap();
    let OneCause::These(sought) = cause else { panic!("{id} is not told") };
    assert!(sought.shown.contains_key(&id), "{id}");
    let is_store = |id: &String| id.starts_with("sprung-mass");
    let left = sought.shown.keys().chain(&sought.possible).filter(|id| is_store(id)).count();
    let of = all.iter().filter(|c| is_store(&c.id())).count();
    assert!(3 * left < of, "{id}: {left} of {of}");
}
