//! Stories of plates on meshes. All tests in them are synthetic, of a mesh twice as fine as the model's, on which what is hidden has its real form: a slit is a slit.

use super::*;
use crate::data::Place;
use crate::effect::Patch;
use crate::fault::Faults;
use crate::model::load_in;
use crate::model::written_mesh::Written;
use crate::update::{Controls, Settings as UpdateSettings, update};

/// A model file with the mesh beside it.
struct Meshed {
    mesh: String,
    text: String,
}

impl Meshed {
    fn model(&self) -> Model {
        self.of(&self.text)
    }

    fn of(&self, text: &str) -> Model {
        let mut files = |_: &str| Ok(self.mesh.clone().into_bytes());
        load_in(text, None, &Registry::builtin(), &mut files).unwrap_or_else(|p| panic!("{p:#?}")).0
    }

    /// Root mean square of the errors of frequencies after an update, %: of the file as it is, and with what was found, as `add` writes it.
    fn errors(&self, found: &HypothesisResult, test: &TestData) -> [f64; 2] {
        let added = Patch::from_yaml(&found.patch).unwrap().apply_to_text(&self.text).unwrap();
        let errors = [&self.text, &added].map(|text| {
            let updated = update(&self.of(text), test, &UpdateSettings::default(), Controls::default()).unwrap();
            let pairs = updated.after.pairs;
            (pairs.iter().map(|p| p.error_percent.powi(2)).sum::<f64>() / pairs.len() as f64).sqrt()
        });
        eprintln!("  {} leaves {errors:.2?} %", found.id);
        errors
    }
}

/// From the square to a wing of 0.6 m, swept and tapered: along its span and from its leading edge to its trailing edge.
fn place([u, v, _]: [f64; 3]) -> [f64; 3] {
    [0.15 * u + (0.2 - 0.08 * u) * v, 0.6 * u, 0.0]
}

/// A wing, its mesh so many times as fine as that of the model; where it is slit from the leading edge, to the middle of the chord.
fn wing(times: usize, slit: Option<f64>, parameters: &str, section: &str) -> Meshed {
    let mut mesh = Written::new();
    let ny = 6 * times;
    mesh.sheet("skin", [0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [24 * times, ny]);
    if let Some(at) = slit {
        mesh.cut(|[u, v, _]| (u - at).abs() < 1e-9 && v < 0.5 - 1e-9, |[u, ..]| u > at);
    }
    mesh.moved(place);
    let root: Vec<String> = (1..=ny + 1).map(|n| format!("n{n}")).collect();
    let text = format!(
        "retune: 1\nname: wing\nmesh: {{file: a.msh, units: m, patches: 12, parts: {{skin: {{section: sheet}}}}}}\nparameters:\n  {parameters}\n\
         sections:\n  sheet: {{{section}}}\nsupports: {{clamp: {{nodes: [{}]}}}}\n",
        root.join(", ")
    );
    Meshed { mesh: mesh.text(), text }
}

fn sensor(name: String, part: &str, at: [f64; 3]) -> Sensor {
    Sensor {
        name,
        place: Place::Element { element: part.into(), fraction: 0.0, position: Some(at) },
        offset: None,
        direction: [0.0, 0.0, 1.0],
        is_rotation: false,
        mass: None,
    }
}

/// Five stations of three sensors.
fn on_wing() -> Vec<Sensor> {
    let at = |k: usize| {
        let [u, v] = [0.2 * (1 + k / 3) as f64, 0.5 * (k % 3) as f64];
        sensor(format!("s{k}"), "skin", place([u, v, 0.0]))
    };
    (0..15).map(at).collect()
}

/// What is said where this is the truth, of changes of stiffness, thickness, fibres and members: a finer mesh moves frequencies by half a per cent, and so much is uncertain.
fn told(base: &Meshed, truth: &Meshed, sensors: &[Sensor], seed: u64) -> (Diagnosis, TestData) {
    let truth = truth.model();
    let options = TwinOptions { frequency_noise: 0.01, shape_noise: 0.03, ..noise(5, seed) };
    let test = twin_modes(&truth, &middle(&truth), sensors, &options, "twin of a story").unwrap();
    let names = ["absent-member", "bending-stiffness-change", "fibre-angle", "stiffness-change", "thickness-change"];
    let all = Effects::builtin();
    let effects = names.iter().fold(Effects::none(), |some, name| some.with(all.find(name).unwrap()));
    let settings = Settings { effects, faults: Faults::none(), ..Settings::default() };
    let d = diagnose(&base.model(), &test, &settings).unwrap();
    eprintln!("{:?}: {} ({:.0} for {:.0})", d.verdict, d.sentence, d.misfit, d.degrees_of_freedom);
    for h in d.hypotheses.iter().take(8) {
        let found = (h.probability, h.ln_bayes, h.misfit_after, h.estimate, h.interval);
        eprintln!("  {} {found:?} {:?}", h.id, h.tied_with);
    }
    (d, test)
}

/// A saw cut from the leading edge to the middle of the chord, at five twelfths of the span: the run of elements beside it from the edge to there is soft.
#[test]
fn a_saw_cut_is_found_where_it_is() {
    let at = 5.0 / 12.0;
    let of = |times, slit| {
        let section = "E: E, nu: 0.33, density: 2700 kg/m3, thickness: 4 mm";
        wing(times, slit, "E: {value: 70 GPa, bounds: [60 GPa, 80 GPa]}", section)
    };
    let base = of(1, None);
    let (d, test) = told(&base, &of(2, Some(at)), &on_wing(), 21);
    let first = &d.hypotheses[0];
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    // The three elements of the row before the cut, and of that behind it.
    let beside = ["stiffness-change@e55..e57", "stiffness-change@e61..e63"];
    assert!(beside.iter().any(|id| first.id == *id || first.tied_with.iter().any(|t| t == id)), "{}", first.id);
    let errors = base.errors(first, &test);
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
}

/// Plies that were laid five degrees off.
#[test]
fn plies_at_another_angle_are_found() {
    let of = |times, angle: f64| {
        let section = format!(
            "shape: {{laminate: {{symmetric: true, materials: {{ud: {{E1: E1, E2: 9 GPa, G12: 5 GPa, G13: 5 GPa, G23: 3 GPa, nu12: 0.3, \
             density: 1550 kg/m3}}}}, plies: [{{angle: {angle} deg, thickness: 0.6 mm}}, {{angle: {} deg, thickness: 0.2 mm}}]}}}}",
            angle + 60.0
        );
        wing(times, None, "E1: {value: 130 GPa, bounds: [110 GPa, 150 GPa]}", &section)
    };
    let base = of(1, 65.0);
    let (d, test) = told(&base, &of(2, 70.0), &on_wing(), 22);
    let first = &d.hypotheses[0];
    assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "fibre-angle@skin"), "{}", d.sentence);
    let [low, high] = first.interval.unwrap();
    let truth = 5.0_f64.to_radians();
    assert!((truth - 0.5 * (low + high)).abs() < high - low, "{low} {high}");
    let errors = base.errors(first, &test);
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
}

/// Two sheets with six spot welds between them, `w0` to `w5`, some of which are not there.
fn panel(times: usize, missing: Option<usize>) -> Meshed {
    let mut mesh = Written::new();
    let (n, m) = ([12 * times, 4 * times], [10 * times, 2 * times]);
    mesh.sheet("skin", [0.0; 3], [[0.48, 0.0, 0.0], [0.0, 0.2, 0.0]], n);
    let own = mesh.nodes.len();
    mesh.sheet("strip", [0.04, 0.075, 0.004], [[0.4, 0.0, 0.0], [0.0, 0.05, 0.0]], m);
    let mut welds = String::new();
    for k in (0..6).filter(|k| Some(*k) != missing) {
        let below = 1 + (1 + 2 * k) * times * (n[1] + 1) + 2 * times;
        let above = own + 1 + 2 * k * times * (m[1] + 1) + times;
        welds += &format!(
            "  w{k}: {{nodes: [n{below}, n{above}], k: {{ux: 5e7 N/m, uy: 5e7 N/m, uz: 5e7 N/m, rx: 200 N m/rad, ry: 200 N m/rad, rz: 200 N m/rad}}}}\n"
        );
    }
    let left: Vec<String> = (1..=n[1] + 1).map(|n| format!("n{n}")).collect();
    let text = format!(
        "retune: 1\nname: panel\nmesh: {{file: a.msh, units: m, patches: 0, parts: {{skin: {{section: sheet}}, strip: {{section: sheet}}}}}}\n\
         parameters:\n  E: {{value: 70 GPa, bounds: [60 GPa, 80 GPa]}}\n\
         sections: {{sheet: {{E: E, nu: 0.33, density: 2700 kg/m3, thickness: 2 mm}}}}\n\
         bushings:\n{welds}supports: {{clamp: {{nodes: [{}]}}}}\n",
        left.join(", ")
    );
    Meshed { mesh: mesh.text(), text }
}

#[test]
fn a_spot_weld_that_is_missing_is_found() {
    let base = panel(1, None);
    let on_skin =
        (0..12).map(|k| sensor(format!("s{k}"), "skin", [0.12 * f64::from(1 + k / 3), 0.1 * f64::from(k % 3), 0.0]));
    let on_strip = (0..5).map(|k| sensor(format!("t{k}"), "strip", [0.08 + 0.08 * f64::from(k), 0.1, 0.004]));
    let (d, test) = told(&base, &panel(2, Some(2)), &on_skin.chain(on_strip).collect::<Vec<_>>(), 23);
    let first = &d.hypotheses[0];
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert!(first.id.ends_with("@w2"), "{}", first.id);
    let errors = base.errors(first, &test);
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
}
