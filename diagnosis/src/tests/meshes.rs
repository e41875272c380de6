//! Stories of plates on meshes. Their tests are synthetic, of a mesh twice as fine as the model's where nothing else is said; a slit is one there: its sides
//! are apart.

use super::*;
use retune::data::Place;
use retune::effect::{Effects, Patch};
use retune::model::{ModalSolver, ReducedOptions, StandIn, load_in};
use retune::update::{Controls, Settings as UpdateSettings, update};
use std::collections::HashMap;
use written_mesh::Written;

/// What writes the meshes of the tests of models.
#[path = "../../../src/model/written_mesh.rs"]
mod written_mesh;

impl Written {
    /// Nodes get new places.
    pub(crate) fn moved(&mut self, to: impl Fn([f64; 3]) -> [f64; 3]) -> &mut Self {
        self.nodes.iter_mut().for_each(|p| *p = to(*p));
        self
    }

    /// A slit: some nodes stand twice, and the cells whose middle is on one side have the second ones.
    pub(crate) fn cut(
        &mut self,
        is_on_it: impl Fn([f64; 3]) -> bool,
        is_beyond: impl Fn([f64; 3]) -> bool,
    ) -> &mut Self {
        let mut second = HashMap::new();
        for n in 1..=self.nodes.len() {
            let at = self.nodes[n - 1];
            if is_on_it(at) {
                second.insert(n, self.node(at));
            }
        }
        let nodes = &self.nodes;
        for cell in self.groups.iter_mut().flat_map(|g| &mut g.2) {
            let share = 1.0 / cell.len() as f64;
            let middle = std::array::from_fn(|i| cell.iter().map(|n| share * nodes[n - 1][i]).sum());
            if is_beyond(middle) {
                for n in cell {
                    *n = second.get(n).copied().unwrap_or(*n);
                }
            }
        }
        self
    }
}

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
    let sheet = "{E: E, nu: 0.33, density: 2700 kg/m3, thickness: 4 mm}";
    wing_of([24 * times, 8 * times], slit, ["E: {value: 70 GPa, bounds: [60 GPa, 80 GPa]}", sheet])
}

/// * `[parameter, section]` - entries of the file
fn wing_of([nx, ny]: [usize; 2], slit: Option<f64>, [parameter, section]: [&str; 2]) -> Meshed {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [nx, ny]);
    if let Some(at) = slit {
        mesh.cut(|[u, v, _]| (u - at).abs() < 1e-9 && v < 0.5 - 1e-9, |[u, ..]| u > at);
    }
    mesh.moved(place);
    let root: Vec<String> = (1..=ny + 1).map(|n| format!("n{n}")).collect();
    let text = format!(
        "retune: 1\nname: wing\nmesh: {{file: a.msh, units: m, parts: {{skin: {{section: sheet}}}}}}\n\
         parameters: {{{parameter}}}\nsections: {{sheet: {section}}}\nsupports: {{clamp: {{nodes: [{}]}}}}\n",
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

/// A clamp that is next to open along fourteen of its seventeen nodes: a stand-in that is made for such a size has the frequencies of the model there, and one that is
/// made for the clamp as it should be does not.
#[test]
fn a_stand_in_is_right_near_the_sizes_that_it_is_made_for() {
    let base = wing(2, None);
    let nodes = |of: std::ops::RangeInclusive<usize>| of.map(|n| format!("n{n}")).collect::<Vec<_>>().join(", ");
    let all = format!("supports: {{clamp: {{nodes: [{}]}}}}\n", nodes(1..=17));
    assert!(base.text.contains(&all), "{}", base.text);
    let compliance = "ux: c, uy: c, uz: c, rx: 20 rad/m2 * c, ry: 20 rad/m2 * c, rz: 20 rad/m2 * c";
    let open = format!(
        "supports:\n  clamp: {{nodes: [{}]}}\n  open: {{nodes: [{}], compliance: {{{compliance}}}}}\n",
        nodes(1..=3),
        nodes(4..=17)
    );
    let text = base.text.replace(&all, &open);
    let text = text.replace("parameters: {", "parameters: {c: {value: 0 m/N, bounds: [0 m/N, 1 m/N]}, ");
    let model = std::sync::Arc::new(base.of(&text));
    let mut theta: Vec<f64> = model.parameters().nominal();
    theta[model.parameters().index_of("c").unwrap()] = 0.3;
    let frequencies = |m: &dyn ParametricModel| -> Vec<f64> {
        let (_, modes) = ModalSolver::new(m, &theta, 8).unwrap().solve(m, &theta, 8).unwrap();
        modes.elastic().map(|i| modes.frequency_hz(i)).take(6).collect()
    };
    let options = ReducedOptions { n_modes: 8, ..ReducedOptions::default() };
    let worst = |held: &[(String, f64)]| {
        let own = frequencies(&StandIn::reduced(&model, options, None, held, None).unwrap());
        own.iter().zip(frequencies(&*model)).map(|(own, full)| (own / full - 1.0).abs()).fold(0.0, f64::max)
    };
    let (held, neutral) = (worst(&[("c".into(), 0.2)]), worst(&[]));
    assert!(held < 1e-4 && neutral > 1e-3, "{held:e} {neutral:e}");
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
    let is_cut = |id: &str| ["cut@e73..e76", "cut@e81..e84"].contains(&id);
    // A patch of some shells about it that are next to gone is nearly the same.
    assert!(is_cut(&first.id) || first.tied_with.iter().any(|id| is_cut(id)), "{}", d.sentence);
    let cut = d.hypotheses.iter().find(|h| is_cut(&h.id)).unwrap();
    let added = Patch::from_yaml(&cut.patch).unwrap().apply_to_text(&base.text).unwrap();
    let [before, after] = [&base.text, &added].map(|text| base.left(text, &test));
    assert!(after < 0.3 * before, "{before} {after}");
}

/// A corroded field of three by five shells, of which half of the thickness is gone: it is named with its shape, but for a few shells along its edge, and with its size.
#[test]
fn a_thin_field_is_found_with_its_shape() {
    let wing = wing(1, None);
    let base = wing.of(&wing.text);
    // Eight along the chord: rows six to ten, columns three to five.
    let field: Vec<String> = (6..=10).flat_map(|row| (3..=5).map(move |k| format!("e{}", 8 * row + k))).collect();
    let thinner =
        format!("{}overrides: {{field: {{of: [{}], scale: {{thickness: 0.5}}}}}}\n", wing.text, field.join(", "));
    let options = TwinOptions { frequency_noise: 0.0005, shape_noise: 0.005, ..noise(8, 3) };
    let test = twin_modes(&wing.of(&thinner), &[70e9], &sensors(), &options, "twin of a story").unwrap();
    let all = Effects::builtin();
    let some = ["stiffness-change", "point-mass", "thickness-change"].map(|name| all.find(name).unwrap());
    let settings = Settings { effects: some.into_iter().fold(Effects::none(), Effects::with), ..Settings::default() };
    let d = diagnose(&base, &test, &settings).unwrap();
    let first = &d.hypotheses[0];
    assert!(first.id.starts_with("thickness-change@"), "{}", d.sentence);
    assert!(first.estimate.is_some_and(|v| (v + 0.5).abs() < 0.1), "{first:?}");
    let patch = Patch::from_yaml(&first.patch).unwrap();
    let named: Vec<String> = patch
        .edits
        .iter()
        .find_map(|e| match e {
            retune::effect::Edit::AddOverride { entry, .. } => Some(entry.of.clone()),
            _ => None,
        })
        .unwrap();
    let common = named.iter().filter(|e| field.contains(e)).count();
    assert!(common >= 11 && named.len() - common <= 5, "{named:?}");
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

/// A wing of six plies, all turned by 5° against the model, on a mesh twice as fine: the turn is named with its size, and added makes the errors fall.
#[test]
fn plies_that_lie_at_another_angle_are_found() {
    let layered = |times: usize, off: f64| {
        let ply = |angle: f64| format!("{{angle: {} deg, thickness: 0.5 mm}}", angle + off);
        let plies = [120.0, 120.0, 78.0].map(ply).join(", ");
        let ud = "{E1: E1, E2: 9 GPa, G12: 5 GPa, G13: 5 GPa, G23: 3 GPa, nu12: 0.3, density: 1550 kg/m3}";
        let section =
            format!("{{shape: {{laminate: {{materials: {{ud: {ud}}}, plies: [{plies}], symmetric: true}}}}}}");
        wing_of([12 * times, 4 * times], None, ["E1: {value: 130 GPa, bounds: [115 GPa, 145 GPa]}", &section])
    };
    let (base, real) = (layered(1, 0.0), layered(2, 5.0));
    let options = TwinOptions { frequency_noise: 0.01, shape_noise: 0.03, ..noise(5, 5) };
    let test = twin_modes(&real.of(&real.text), &[130e9], &sensors(), &options, "twin of a story").unwrap();
    let all = Effects::builtin();
    let some =
        ["fibre-angle", "stiffness-change", "thickness-change", "point-mass"].map(|name| all.find(name).unwrap());
    let settings = Settings { effects: some.into_iter().fold(Effects::none(), Effects::with), ..Settings::default() };
    let d = diagnose(&base.of(&base.text), &test, &settings).unwrap();
    let first = &d.hypotheses[0];
    assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "fibre-angle@skin"), "{}", d.sentence);
    let turn = 5_f64.to_radians();
    assert!(first.interval.is_some_and(|[l, u]| l < turn && turn < u && u - l < 0.3 * turn), "{first:?}");
    let added = Patch::from_yaml(&first.patch).unwrap().apply_to_text(&base.text).unwrap();
    let [before, after] = [&base.text, &added].map(|text| base.left(text, &test));
    assert!(after < 0.3 * before, "{before} {after}");
}

/// A panel with a stiffener of T section on five spot welds, of which the real one, on the same mesh, lacks the third: that weld is named as one that
/// does not hold, and added makes the errors fall.
#[test]
fn a_missing_spot_weld_is_found() {
    let mut mesh = Written::new();
    mesh.sheet("panel", [0.0; 3], [[0.5, 0.0, 0.0], [0.0, 0.3, 0.0]], [10, 6]);
    mesh.sheet("strip", [0.0, 0.135, 0.002], [[0.5, 0.0, 0.0], [0.0, 0.03, 0.0]], [10, 2]);
    mesh.sheet("web", [0.0, 0.15, 0.002], [[0.5, 0.0, 0.0], [0.0, 0.0, 0.025]], [10, 2]);
    mesh.merged();
    let file = |missing: Option<usize>| {
        let weld = |k: usize| {
            let k_of = "{ux: 3e7 N/m, uy: 3e7 N/m, uz: 1e8 N/m, rx: 1e3 N m/rad, ry: 1e3 N m/rad, rz: 1e3 N m/rad}";
            format!("  weld_{k}: {{nodes: [w{k}], to: [panel], within: 3 mm, k: {k_of}}}\n")
        };
        let ties: String = (1..=5).filter(|k| Some(*k) != missing).map(weld).collect();
        let node = |k: usize| format!("  w{k}: {{nearest: [{} m, 0.15 m, 2 mm]}}\n", 0.05 + 0.1 * (k - 1) as f64);
        let nodes: String = (1..=5).map(node).collect();
        let root: Vec<String> = (1..=7).map(|n| format!("n{n}")).collect();
        let parts = ["panel", "strip", "web"].map(|p| format!("{p}: {{section: sheet}}")).join(", ");
        format!(
            "retune: 1\nname: panel\nmesh: {{file: a.msh, units: m, parts: {{{parts}}}}}\n\
             parameters: {{E: {{value: 70 GPa, bounds: [60 GPa, 80 GPa]}}}}\n\
             sections: {{sheet: {{E: E, nu: 0.33, density: 2700 kg/m3, thickness: 1.5 mm}}}}\n\
             nodes:\n{nodes}ties:\n{ties}supports: {{clamp: {{nodes: [{}]}}}}\n",
            root.join(", ")
        )
    };
    let panel = Meshed { mesh: mesh.text(), text: file(None) };
    let sensor = |k: usize| Sensor {
        name: format!("s{k}"),
        place: Place::Element {
            element: "panel".into(),
            fraction: 0.0,
            position: Some([0.1 * (1 + k / 5) as f64, 0.075 * (k % 5) as f64, 0.0]),
        },
        offset: None,
        direction: [0.0, 0.0, 1.0],
        is_rotation: false,
        mass: None,
    };
    let sensors: Vec<Sensor> = (0..25).map(sensor).collect();
    let options = TwinOptions { frequency_noise: 0.003, shape_noise: 0.02, ..noise(7, 5) };
    let test = twin_modes(&panel.of(&file(Some(3))), &[70e9], &sensors, &options, "twin of a story").unwrap();
    let all = Effects::builtin();
    let some =
        ["stiffness-change", "absent-member", "point-mass", "thickness-change"].map(|name| all.find(name).unwrap());
    let settings = Settings { effects: some.into_iter().fold(Effects::none(), Effects::with), ..Settings::default() };
    let base = panel.of(&panel.text);
    // What hangs on the springs of its ties hangs together.
    let sound = retune::model::lint(&base).unwrap();
    assert!(sound.errors.iter().chain(&sound.warnings).all(|p| !p.message.contains("hangs on nothing")));
    let d = diagnose(&base, &test, &settings).unwrap();
    let first = &d.hypotheses[0];
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert!(first.id.ends_with("@weld_3"), "{}", d.sentence);
    assert!(first.estimate.is_some_and(|v| v.abs() > 0.9), "{first:?}");
    let added = Patch::from_yaml(&first.patch).unwrap().apply_to_text(&panel.text).unwrap();
    let [before, after] = [&panel.text, &added].map(|text| panel.left(text, &test));
    assert!(after < 0.3 * before, "{before} {after}");
}
