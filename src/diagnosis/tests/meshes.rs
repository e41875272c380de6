//! Stories of plates on meshes. All tests in them are synthetic, of a mesh twice as fine as the model's, on which what is hidden has its real form: a slit is a slit.

use super::*;
use crate::data::Place;
use crate::fault::Faults;
use crate::model::load_in;
use crate::model::written_mesh::Written;

fn on_mesh(mesh: &Written, text: &str) -> Model {
    let bytes = mesh.text();
    let mut files = |_: &str| Ok(bytes.clone().into_bytes());
    load_in(text, None, &Registry::builtin(), &mut files).unwrap_or_else(|p| panic!("{p:#?}")).0
}

/// From the square to a wing of 0.6 m, swept and tapered: along its span and from its leading edge to its trailing edge.
fn place([u, v, _]: [f64; 3]) -> [f64; 3] {
    [0.15 * u + (0.2 - 0.08 * u) * v, 0.6 * u, 0.0]
}

/// A wing of so many cells along its span and across it; where it is slit from the leading edge, to the middle of the chord.
fn wing([nx, ny]: [usize; 2], slit: Option<f64>, parameters: &str, section: &str) -> Model {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [nx, ny]);
    if let Some(at) = slit {
        mesh.cut(|[u, v, _]| (u - at).abs() < 1e-9 && v < 0.5 - 1e-9, |[u, ..]| u > at);
    }
    mesh.moved(place);
    let root: Vec<String> = (1..=ny + 1).map(|n| format!("n{n}")).collect();
    on_mesh(
        &mesh,
        &format!(
            "retune: 1\nname: wing\nmesh: {{file: a.msh, units: m, parts: {{skin: {{section: sheet}}}}}}\nparameters: {{{parameters}}}\n\
             sections:\n  sheet: {{{section}}}\nsupports: {{clamp: {{nodes: [{}]}}}}\n",
            root.join(", ")
        ),
    )
}

const ALUMINIUM: [&str; 2] = [
    "E: {value: 70 GPa, bounds: [60 GPa, 80 GPa]}",
    "E: E, nu: 0.33, density: 2700 kg/m3, thickness: 4 mm, lumping: 1",
];

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
fn told(base: &Model, truth: &Model, sensors: &[Sensor], seed: u64) -> Diagnosis {
    let options = TwinOptions { frequency_noise: 0.01, shape_noise: 0.03, ..noise(5, seed) };
    let test = twin_modes(truth, &middle(truth), sensors, &options, "twin of a story").unwrap();
    let names = ["absent-member", "bending-stiffness-change", "fibre-angle", "stiffness-change", "thickness-change"];
    let all = Effects::builtin();
    let effects = names.iter().fold(Effects::none(), |some, name| some.with(all.find(name).unwrap()));
    let settings = Settings { effects, faults: Faults::none(), ..Settings::default() };
    let d = diagnose(base, &test, &settings).unwrap();
    eprintln!("{:?}: {} ({:.0} for {:.0})", d.verdict, d.sentence, d.misfit, d.degrees_of_freedom);
    for h in d.hypotheses.iter().take(5) {
        let found = (h.probability, h.ln_bayes, h.misfit_after, h.estimate, h.interval);
        eprintln!("  {} {found:?} {:?}", h.id, h.tied_with);
    }
    d
}

/// A saw cut from the leading edge to the middle of the chord, at five twelfths of the span: the patch with the cut in it bends too easily.
#[test]
fn a_saw_cut_is_found_where_it_is() {
    let [parameters, section] = ALUMINIUM;
    let at = 5.0 / 12.0;
    let (base, truth) = (wing([12, 4], None, parameters, section), wing([24, 8], Some(at), parameters, section));
    let d = told(&base, &truth, &on_wing(), 21);
    let first = &d.hypotheses[0];
    assert!(
        first.id.starts_with("bending-stiffness-change@") || first.id.starts_with("stiffness-change@"),
        "{}",
        first.id
    );
    assert!(first.estimate.unwrap() < -0.2 && first.misfit_after < 0.5 * d.misfit, "{:?}", first.estimate);
    // An element of the patch touches the cut.
    let beside = |&e: &usize| {
        let nodes = &base.elements()[e].nodes;
        nodes.iter().any(|&n| {
            let [x, y, _] = base.geometry().positions[n];
            let u = y / 0.6;
            (u - at).abs() < 1e-6 && (x - 0.15 * u) / (0.2 - 0.08 * u) < 0.5 + 1e-6
        })
    };
    assert!(base.element_set(&first.location).unwrap().iter().any(beside), "{}", first.location);
}

/// Plies that were laid five degrees off.
#[test]
fn plies_at_another_angle_are_found() {
    let parameters = "E1: {value: 130 GPa, bounds: [110 GPa, 150 GPa]}";
    let of = |angle: f64| {
        format!(
            "lumping: 1, shape: {{laminate: {{symmetric: true, materials: {{ud: {{E1: E1, E2: 9 GPa, G12: 5 GPa, G13: 5 GPa, G23: 3 GPa, nu12: 0.3, \
             density: 1550 kg/m3}}}}, plies: [{{angle: {angle} deg, thickness: 0.6 mm}}, {{angle: {} deg, thickness: 0.2 mm}}]}}}}",
            angle + 60.0
        )
    };
    let (base, truth) = (wing([12, 4], None, parameters, &of(65.0)), wing([24, 8], None, parameters, &of(70.0)));
    let d = told(&base, &truth, &on_wing(), 22);
    let first = &d.hypotheses[0];
    assert_eq!((d.verdict, first.id.as_str()), (Verdict::MissingEffect, "fibre-angle@skin"), "{}", d.sentence);
    let [low, high] = first.interval.unwrap();
    let truth = 5.0_f64.to_radians();
    assert!((truth - 0.5 * (low + high)).abs() < high - low, "{low} {high}");
}

/// Two sheets with six spot welds between them, `w0` to `w5`, some of which are not there.
fn panel(times: usize, missing: Option<usize>) -> Model {
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
    on_mesh(
        &mesh,
        &format!(
            "retune: 1\nname: panel\nmesh: {{file: a.msh, units: m, patches: 0, parts: {{skin: {{section: sheet}}, strip: {{section: sheet}}}}}}\n\
             parameters: {{E: {{value: 70 GPa, bounds: [60 GPa, 80 GPa]}}}}\n\
             sections: {{sheet: {{E: E, nu: 0.33, density: 2700 kg/m3, thickness: 2 mm, lumping: 1}}}}\n\
             bushings:\n{welds}supports: {{clamp: {{nodes: [{}]}}}}\n",
            left.join(", ")
        ),
    )
}

#[test]
fn a_spot_weld_that_is_missing_is_found() {
    let (base, truth) = (panel(1, None), panel(2, Some(2)));
    let on_skin =
        (0..12).map(|k| sensor(format!("s{k}"), "skin", [0.12 * (1 + k / 3) as f64, 0.1 * (k % 3) as f64, 0.0]));
    let on_strip = (0..5).map(|k| sensor(format!("t{k}"), "strip", [0.08 + 0.08 * k as f64, 0.1, 0.004]));
    let d = told(&base, &truth, &on_skin.chain(on_strip).collect::<Vec<_>>(), 23);
    let first = &d.hypotheses[0];
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert!(first.id.ends_with("@w2"), "{}", first.id);
    assert!(first.misfit_after < 0.5 * d.misfit);
}
