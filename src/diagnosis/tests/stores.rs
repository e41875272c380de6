//! What could have made a mode that looks foreign, and what slopes hide.

use super::*;
use crate::data::Standing;
use crate::diagnosis::problem::scene::Scene;
use crate::diagnosis::screen::stage::{placed, stage};
use crate::diagnosis::search::board::Board;
use crate::diagnosis::search::one_cause::{OneCause, one_cause_of};
use crate::diagnosis::thresholds::MISREAD;
use crate::effect::{Context, Effects, Structure};
use crate::update::node_sensors;

/// A body on a spring brings a mode whose shape shows its place: it is among what could have made the mode, and hardly anything else at few dofs is.
#[test]
fn the_shape_of_a_store_shows_its_place() {
    let base = model(include_str!("../../../models/garteur.yaml"));
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

/// A mass of a third of the structure moves modes far from where its slope points: among the effects by their slopes it stands behind hundreds,
/// by what it leaves at the best of its sizes in front.
#[test]
fn a_look_at_sizes_finds_what_slopes_hide() {
    let base = model(include_str!("../../../models/garteur.yaml"));
    let id = "point-mass@r3";
    let heavy = Effects::builtin().candidate(&Structure::new(&base, Context::nothing()), id).unwrap();
    let patched = heavy.build(&base, &Registry::builtin()).unwrap();
    let size = 10.0 * heavy.typical()[0];
    let test = twin_modes(
        &patched.model,
        &patched.theta(&middle(&base), &[size]),
        &node_sensors(&base),
        &noise(8, 3),
        "twin of a story",
    );
    let settings = Settings::default();
    // As models of more than 300 dofs are solved.
    let scene = Scene::new(&base, &[&test.unwrap()]).unwrap().large_from(0).unwrap();
    let stage = stage(scene, &[], 1.0, &settings, None).unwrap();
    let board = Board::new(&stage, 12, false).unwrap();
    let place = |ids: Vec<String>| ids.iter().position(|i| i == id).unwrap();
    let by_slope = place(stage.effects.iter().map(|s| stage.id(s)).collect());
    let by_size = place(board.by_size().iter().map(|s| stage.id(s)).collect());
    assert!(by_size < 12 && by_size < by_slope, "{by_size} {by_slope}");
}
