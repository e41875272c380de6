//! Edits of text: what the user sees in the file.

use super::super::*;
use crate::model::{Registry, load};
use crate::yaml;

const TEXT: &str = "# A wing\nretune: 1\nname: w\nactive_dofs: [uz, rx, ry]\n\nparameters:\n  m_tip: {value: 50 g, bounds: [0 g, 200 g]} # weighed\n\n# Where things are\nnodes:\n  a: [0, 0, 0]\n  b: [0, 1, 0] # tip\n\nbeams:\n  w:\n    chain: [a, b]\n    properties: {EIy: 10, GJ: 5, mass_per_length: 1}\nmasses: {tip: {node: b, mass: m_tip}}\n\nsupports:\n  root: {node: a}\n# the end\n";

fn add(text: &str, id: &str) -> String {
    let (model, _, _) = load(text, &Registry::builtin()).unwrap();
    let context = Context::default();
    let structure = Structure::new(&model, &context);
    let candidate = Effects::builtin().candidate(&structure, id).unwrap();
    candidate.patch.add_to_text(text, id, "").unwrap()
}

#[test]
fn the_smallest_readable_edit() {
    let edited = add(TEXT, "point-mass@b");
    let expected = TEXT
        .replace(
            "# weighed\n",
            "# weighed\n  point_mass.b.mass: {value: 0 kg, bounds: [0 kg, 0.525 kg], description: mass missing at b}\n",
        )
        .replace("mass: m_tip}}", "mass: m_tip}, point_mass.b: {node: b, mass: point_mass.b.mass}}")
        .replace(
            "  root: {node: a}\n",
            "  root: {node: a}\n\nhistory:\n  - {add: point-mass@b, inserted: [parameters.point_mass.b.mass, masses.point_mass.b]}\n",
        );
    assert_eq!(edited, expected);
}

#[test]
fn a_hidden_offset_in_the_file_of_the_flying_wing() {
    let text = include_str!("../../../models/bff.yaml");
    let edited = add(text, "mass-offset@left_wing+right_wing.y_all");
    let new: Vec<&str> = edited.lines().filter(|l| !text.lines().any(|t| t == *l)).collect();
    let stem = "mass_offset.left_wing_and_right_wing.y_all";
    let expected = format!(
        "  {stem}.offset:
    value: 0 m
    bounds: [-0.318 m, 0.318 m]
    description: \"centres of gravity beside the axis of left_wing+right_wing, along [0.93, 0.37, 0.0] of left_wing\"
overrides:
  {stem}.1:
    of: [left_wing]
    add: {{mass_offset_y: {stem}.offset}}
  {stem}.1.lumps:
    of: [inboard_flaps.1, mid_flaps.1, outboard_flaps.1, winglets.1]
    add: {{offset_x: 0.927183854567*{stem}.offset, offset_y: 0.374606593416*{stem}.offset}}
  {stem}.2:
    of: [right_wing]
    add: {{mass_offset_y: -{stem}.offset}}
  {stem}.2.lumps:
    of: [inboard_flaps.2, mid_flaps.2, outboard_flaps.2, winglets.2]
    add: {{offset_x: 0.927183854567*{stem}.offset, offset_y: -0.374606593416*{stem}.offset}}
history:
  - add: mass-offset@left_wing+right_wing.y_all
    inserted: [parameters.{stem}.offset, overrides.{stem}.1, overrides.{stem}.1.lumps, overrides.{stem}.2, overrides.{stem}.2.lumps]"
    );
    assert_eq!(new.join("\n"), expected);
}

#[test]
fn undo_takes_back_what_was_added_in_any_file() {
    let variants = [
        TEXT.to_string(),
        TEXT.replace('\n', "\r\n"),
        TEXT.trim_end().to_string(),
        TEXT.trim_end().trim_end_matches("# the end").trim_end().to_string(),
        TEXT.replace("\n\n", "\n"),
        TEXT.replace("# the end\n", "overrides: {}\n"),
        TEXT.replace("# the end\n", "overrides: {w: {mass: 1.1},}\nhistory: []\n"),
        TEXT.replace("  a: [", "      a: [").replace("  b: [", "      b: ["),
    ];
    for text in variants {
        for id in
            ["point-mass@b", "mass-offset@w.y_all", "sprung-mass@b.uz", "stiffness-change@w.1", "ground-spring@b.uz"]
        {
            let (model, _, _) = load(&text, &Registry::builtin()).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
            let context = Context::default();
            let structure = Structure::new(&model, &context);
            let Ok(candidate) = Effects::builtin().candidate(&structure, id) else { continue };
            let edited =
                candidate.patch.add_to_text(&text, id, "because").unwrap_or_else(|e| panic!("{id}: {e}\n{text}"));
            assert_eq!(text.contains('\r'), edited.contains('\r'));
            assert!(!edited.replace("\r\n", "").contains('\n') || !text.contains('\r'), "mixed line ends");
            let undone = undo(&edited).unwrap_or_else(|e| panic!("{id}: {e}\n{edited}"));
            assert_eq!(undone.text, text, "{id}\n{edited}");
            assert_eq!(undone.entry.add, id);
        }
    }
}

#[test]
fn two_effects_are_undone_one_after_the_other_with_the_users_changes_kept() {
    let first = add(TEXT, "point-mass@b");
    let both = add(&first, "ground-spring@b.uz");
    // The user fits the size and adds a comment and a node of their own.
    let changed = both
        .replace("description: stiffness to ground", "description: bungee")
        .replace("  b: [0, 1, 0] # tip\n", "  b: [0, 1, 0] # tip\n  mine: [0, 2, 0]\n");
    let once = undo(&changed).unwrap();
    assert_eq!(once.text, first.replace("  b: [0, 1, 0] # tip\n", "  b: [0, 1, 0] # tip\n  mine: [0, 2, 0]\n"));
    let twice = undo(&once.text).unwrap();
    assert_eq!(twice.text, TEXT.replace("  b: [0, 1, 0] # tip\n", "  b: [0, 1, 0] # tip\n  mine: [0, 2, 0]\n"));
    assert_eq!(undo(&twice.text).unwrap_err(), PatchError::NoHistory);
}

#[test]
fn undo_refuses_what_something_relies_on_and_reports_what_is_gone() {
    let edited = add(TEXT, "point-mass@b");
    let used = edited.replace("  root: {node: a}\n", "  root: {node: a}\ngroups: {g: [w, point_mass.b]}\n");
    assert_eq!(
        undo(&used).unwrap_err().to_string(),
        "cannot undo `point-mass@b`: `groups.g[1]` relies on `point_mass.b`, which it brought; change that first"
    );
    let gone = edited.replace(", point_mass.b: {node: b, mass: point_mass.b.mass}", "");
    let undone = undo(&gone).unwrap();
    assert_eq!(undone.missing, ["masses.point_mass.b"]);
    assert_eq!(undone.text, TEXT);
}

#[test]
fn adding_twice_is_refused() {
    let (model, _, _) = load(TEXT, &Registry::builtin()).unwrap();
    let context = Context::default();
    let structure = Structure::new(&model, &context);
    let candidate = Effects::builtin().candidate(&structure, "point-mass@b").unwrap();
    let once = candidate.patch.apply_to_text(TEXT).unwrap();
    assert!(!once.contains("history"));
    let e = candidate.patch.apply_to_text(&once).unwrap_err();
    assert!(e.to_string().starts_with("`parameters.point_mass.b.mass` is in the file already"), "{e}");
}

#[test]
fn wrong_words_get_the_nearest_right_one() {
    let (model, _, _) = load(TEXT, &Registry::builtin()).unwrap();
    let context = Context::default();
    let structure = Structure::new(&model, &context);
    let error = |id: &str| Effects::builtin().candidate(&structure, id).unwrap_err().to_string();
    assert_eq!(
        error("point-maas@b"),
        "unknown effect `point-maas`; did you mean `point-mass`? (see `retune list effects`)"
    );
    // Of one letter every other is a neighbour.
    assert_eq!(error("point-mass@q"), "the effect `point-mass` cannot act at `q`; its places here are `b`");
    assert!(error("asymmetry@w").ends_with("this structure has no place for it"));
}

#[test]
fn new_values_are_written_in_the_units_of_the_file() {
    let text = TEXT.replace(
        "parameters:\n",
        "parameters:\n  E:\n    value: \"70 GPa\" # book\n    bounds: [60 GPa, 80 GPa]\n  q: {value: 0.5}\n",
    );
    let out = set_parameter_values(&text, &[("m_tip", 0.0731), ("E", 71.25e9), ("q", 1.0 / 3.0)]).unwrap();
    let expected = text
        .replace("{value: 50 g,", "{value: 73.1 g,")
        .replace("\"70 GPa\" # book", "\"71.25 GPa\" # book")
        .replace("{value: 0.5}", "{value: 0.333333333333333}");
    assert_eq!(out, expected);
    let e = set_parameter_values(&text, &[("m_tp", 1.0)]).unwrap_err().to_string();
    assert_eq!(e, "the file has no parameter `m_tp`; did you mean `m_tip`?");
    assert!(set_parameter_values(&text, &[("E", f64::NAN)]).is_err());
}

#[test]
fn values_change_and_comments_stay() {
    let text = "retune: 1 # one\nname: x\nparameters:\n  E: {value: 40 GPa, bounds: [1 GPa, 2 GPa]} # steel\n  m:\n    # mass\n    value: 2\nnodes: {a: [0, 0, 0]}\n";
    let new = set_parameter_values(text, &[("m", 0.1 + 0.2), ("E", 56.25e9)]).unwrap();
    assert_eq!(new, text.replace("40 GPa", "56.25 GPa").replace("value: 2\n", "value: 0.3\n"));
    assert!(set_parameter_values(text, &[("z", 1.0)]).is_err());
}

/// Paths of a mesh and of matrices are written as they are seen from another folder; names that are not files stay.
#[test]
fn paths_follow_a_file_that_moves() {
    let text = "retune: 1 # one\nname: x\nmesh:\n  file: plate.msh # of May\n  units: mm\n  parts: {k: {section: s}}\nsuperelements:\n  wing: {k: 'wing K.mtx', m: {file: all.op4, matrix: MAAX}, dofs: gone.csv, attach: {k: k}}\n";
    let is_there = |name: &str| ["plate.msh", "wing K.mtx", "all.op4", "MAAX", "k"].contains(&name);
    let to = |name: &str| is_there(name).then(|| format!("../old/{name}"));
    let moved = crate::effect::move_files(text, &|name| to(name).filter(|_| name != "MAAX")).unwrap();
    let expected = text
        .replace("plate.msh #", "\"../old/plate.msh\" #")
        .replace("'wing K.mtx'", "\"../old/wing K.mtx\"")
        .replace("all.op4", "\"../old/all.op4\"");
    assert_eq!(moved, expected);
    assert_eq!(crate::effect::move_files(text, &|_| None).unwrap(), text);
}

proptest::proptest! {
    /// Any number comes back within 1e-15, in any unit.
    #[test]
    fn written_values_read_back(mantissa in -10.0f64..10.0, exponent in -12i32..12) {
        let si = mantissa * 10f64.powi(exponent);
        for unit in ["g", "lb", "kg", "oz", "slug"] {
            let text = TEXT.replace("50 g,", &format!("50 {unit},")).replace(", bounds: [0 g, 200 g]", "");
            let out = set_parameter_values(&text, &[("m_tip", si)]).unwrap();
            let (spec, _) = yaml::read::<crate::model::ModelSpec>(&out).unwrap();
            let back: f64 = spec.parameters["m_tip"].value.constant_in("kg").unwrap();
            proptest::prop_assert!((back - si).abs() <= 1e-15 * si.abs(), "{} {back:e} {si:e}", spec.parameters["m_tip"].value);
        }
    }
}
