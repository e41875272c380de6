//! A story of a plate on a mesh. The test in it is synthetic, of a mesh twice as fine as the model's, on which the slit is one: its sides are apart.

use super::*;
use crate::data::Place;
use crate::effect::{Effects, Patch};
use crate::model::load_in;
use crate::model::written_mesh::Written;
use crate::update::{Controls, Settings as UpdateSettings, update};

/// A model file with the mesh beside it.
struct Meshed {
    mesh: String,
    text: String,
}

impl Meshed {
    fn of(&self, text: &str) -> Model {
        let mut files = |_: &str| Ok(self.mesh.clone().into_bytes());
        load_in(text, None, &Registry::builtin(), &mut files).unwrap_or_else(|p| panic!("{p:#?}")).0
    }

    /// Sum of the squares of the errors of frequencies after an update of a file, %².
    fn left(&self, text: &str, test: &TestData) -> f64 {
        let updated = update(&self.of(text), test, &UpdateSettings::default(), Controls::default()).unwrap();
        updated.after.pairs.iter().map(|p| p.error_percent.powi(2)).sum::<f64>()
    }
}

/// From the square to a wing of 0.6 m, swept and tapered: along its span and from its leading edge to its trailing edge.
fn place([u, v, _]: [f64; 3]) -> [f64; 3] {
    [0.15 * u + (0.2 - 0.08 * u) * v, 0.6 * u, 0.0]
}

/// A wing, its mesh so many times as fine as that of the model; where it is slit from the leading edge, to the middle of the chord.
fn wing(times: usize, slit: Option<f64>) -> Meshed {
    let mut mesh = Written::new();
    let ny = 8 * times;
    mesh.sheet("skin", [0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [24 * times, ny]);
    if let Some(at) = slit {
        mesh.cut(|[u, v, _]| (u - at).abs() < 1e-9 && v < 0.5 - 1e-9, |[u, ..]| u > at);
    }
    mesh.moved(place);
    let root: Vec<String> = (1..=ny + 1).map(|n| format!("n{n}")).collect();
    let text = format!(
        "retune: 1\nname: wing\nmesh: {{file: a.msh, units: m, parts: {{skin: {{section: sheet}}}}}}\n\
         parameters: {{E: {{value: 70 GPa, bounds: [60 GPa, 80 GPa]}}}}\n\
         sections:\n  sheet: {{E: E, nu: 0.33, density: 2700 kg/m3, thickness: 4 mm}}\nsupports: {{clamp: {{nodes: [{}]}}}}\n",
        root.join(", ")
    );
    Meshed { mesh: mesh.text(), text }
}

/// Five stations of three sensors.
fn sensors() -> Vec<Sensor> {
    let at = |k: usize| place([0.2 * (1 + k / 3) as f64, 0.5 * (k % 3) as f64, 0.0]);
    let sensor = |k: usize| Sensor {
        name: format!("s{k}"),
        place: Place::Element { element: "skin".into(), fraction: 0.0, position: Some(at(k)) },
        offset: None,
        direction: [0.0, 0.0, 1.0],
        is_rotation: false,
        mass: None,
    };
    (0..15).map(sensor).collect()
}

/// A saw cut from the leading edge to the middle of the chord, at five twelfths of the span: it is named with its length, in the row before it or behind it,
/// and added makes the errors fall.
#[test]
fn a_saw_cut_is_found_where_it_is() {
    let base = wing(1, None);
    let cut = wing(2, Some(5.0 / 12.0));
    let truth = cut.of(&cut.text);
    let options = TwinOptions { frequency_noise: 0.01, shape_noise: 0.03, ..noise(5, 21) };
    let test = twin_modes(&truth, &[70e9], &sensors(), &options, "twin of a story").unwrap();
    let d = diagnose(&base.of(&base.text), &test, &Settings::default()).unwrap();
    let first = &d.hypotheses[0];
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert!(["cut@e73..e76", "cut@e81..e84"].contains(&first.id.as_str()), "{}", d.sentence);
    let added = Patch::from_yaml(&first.patch).unwrap().apply_to_text(&base.text).unwrap();
    let [before, after] = [&base.text, &added].map(|text| base.left(text, &test));
    assert!(after < 0.3 * before, "{before} {after}");
}

/// A mass on a node that no search tries at first is named there, with its size. A mass on an arm from a
/// neighbour is the same thing, so that it is left out here.
#[test]
fn a_mass_between_the_places_of_a_mesh_is_found() {
    let wing = wing(1, None);
    let base = wing.of(&wing.text);
    let away = |n: &usize| !base.is_site(*n) && base.geometry().positions[*n][1] > 0.4;
    let node = (0..base.n_named_nodes()).find(away).map(|n| base.geometry().names[n].clone()).unwrap();
    let heavier = format!("{}masses: {{extra: {{node: {node}, mass: 0.05 kg}}}}\n", wing.text);
    let options = TwinOptions { frequency_noise: 0.003, shape_noise: 0.02, ..noise(6, 8) };
    let test = twin_modes(&wing.of(&heavier), &[70e9], &sensors(), &options, "twin of a story").unwrap();
    let all = Effects::builtin();
    let some =
        ["point-mass", "distributed-mass", "stiffness-change", "mass-change"].map(|name| all.find(name).unwrap());
    let settings = Settings { effects: some.into_iter().fold(Effects::none(), Effects::with), ..Settings::default() };
    let d = diagnose(&base, &test, &settings).unwrap();
    let first = &d.hypotheses[0];
    let id = format!("point-mass@{node}");
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert_eq!(first.id, id, "{}", d.sentence);
    assert!(first.interval.is_some_and(|[l, u]| l < 0.05 && 0.05 < u), "{first:?}");
}
