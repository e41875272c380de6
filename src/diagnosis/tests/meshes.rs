//! Stories of plates on meshes. All tests in them are synthetic, of a mesh twice as fine as the model's, on which what is hidden has its real form: a slit is a slit.

use super::*;
use crate::data::Place;
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

/// What is said where this is the truth.
fn told(base: &Model, truth: &Model, sensors: &[Sensor], n_modes: usize, seed: u64) -> Diagnosis {
    let test = twin_modes(truth, &middle(truth), sensors, &noise(n_modes, seed), "twin of a story").unwrap();
    let d = diagnose(base, &test, &Settings::default()).unwrap();
    eprintln!("{:?}: {} ({:.0} for {:.0})", d.verdict, d.sentence, d.misfit, d.degrees_of_freedom);
    for h in d.hypotheses.iter().take(5) {
        eprintln!("  {} {:.3} {:.1} -> {:.0} {:?} {:?}", h.id, h.probability, h.ln_bayes, h.misfit_after, h.estimate, h.tied_with);
    }
    d
}
