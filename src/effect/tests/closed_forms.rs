//! Effects against closed forms, by their own candidates on small models.

use super::super::*;
use crate::element::Dof;
use crate::linalg::DMatrix;
use crate::modal::{SolveOptions, solve};
use crate::model::{Model, ParametricModel, Registry, System, load};

/// EI = 10 N m², μ = 2 kg/m, GJ = 6 N m², ι = 0.003 kg m, L = 1 m in ten elements.
fn beam(active: &str, supports: &str, more: &str) -> String {
    let nodes: Vec<String> = (0..=10).map(|i| format!("  n{i}: [{} m, 0, 0]", f64::from(i) / 10.0)).collect();
    let nodes = nodes.join("\n");
    let chain: Vec<String> = (0..=10).map(|i| format!("n{i}")).collect();
    format!(
        "retune: 1\nname: test\nactive_dofs: [{active}]\nnodes:\n{nodes}\nbeams:\n  b:\n    chain: [{}]\n    properties: \
         {{EIy: 10 N m2, GJ: 6 N m2, mass_per_length: 2 kg/m, polar_inertia_per_length: 0.003 kg m}}\nsupports: {{{supports}}}\n{more}",
        chain.join(", ")
    )
}

const CLAMPED: &str = "root: {node: n0}";
const PINNED: &str = "a: {node: n0, fixed: [uz]}, b: {node: n10, fixed: [uz]}";

/// The model with an effect at these sizes of its parameters: K, M, C and the angular frequencies of elastic modes.
fn with(text: &str, id: &str, sizes: &[f64]) -> (Model, System, Vec<f64>) {
    let registry = Registry::builtin();
    let (model, _, _) = load(text, &registry).unwrap();
    let context = Context { sensors: vec![SensorLoad::on("n4"), SensorLoad::on("n10")], ..Context::default() };
    let structure = Structure::new(&model, &context);
    let candidate = Effects::builtin().candidate(&structure, id).unwrap();
    let patched = candidate.build(&model, &registry).unwrap();
    let theta = patched.theta(structure.theta(), sizes);
    let system = patched.model.assemble(&theta).unwrap();
    let motions = patched.model.dof_map().rigid_motions();
    let modes = solve(&system.stiffness, &system.mass, &motions, SolveOptions { n_elastic: 4, shift: None }).unwrap();
    let omegas = modes.elastic().map(|i| modes.lambda[i].sqrt()).collect();
    (patched.model, system, omegas)
}

/// The same without an effect.
fn without(text: &str) -> (System, Vec<f64>) {
    let (model, _, _) = load(text, &Registry::builtin()).unwrap();
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let motions = model.dof_map().rigid_motions();
    let modes = solve(&system.stiffness, &system.mass, &motions, SolveOptions { n_elastic: 4, shift: None }).unwrap();
    (system, modes.elastic().map(|i| modes.lambda[i].sqrt()).collect())
}

fn close(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual / expected - 1.0).abs() < tolerance, "{actual} is not {expected} within {tolerance:e}");
}

/// The root of f between a and b.
fn root(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    assert!(f(a) * f(b) < 0.0, "no sign change");
    for _ in 0..200 {
        let c = 0.5 * (a + b);
        if f(a) * f(c) <= 0.0 { b = c } else { a = c }
    }
    0.5 * (a + b)
}

/// ω of bending with wave number β/L.
fn bending(beta: f64) -> f64 {
    beta * beta * (10.0f64 / 2.0).sqrt()
}

/// Ten cubic elements: the first two frequencies are exact to some 1e-5.
const MESH: f64 = 3e-5;

#[test]
fn a_tip_mass_lowers_a_cantilever_by_the_known_ratio() {
    // m/(μ L) = 0.2; Blevins 1979, table 8-8.
    let equation = |b: f64| 1.0 + b.cos() * b.cosh() + 0.2 * b * (b.cos() * b.sinh() - b.sin() * b.cosh());
    let (_, _, omega) = with(&beam("uz, ry", CLAMPED, ""), "point-mass@n10", &[0.4]);
    close(omega[0], bending(root(equation, 1.0, 1.875)), MESH);
}

#[test]
fn a_tip_inertia_lowers_a_shaft_by_the_known_ratio() {
    // β tan β = ι L / J; linear elements: the error is (β h)²/24.
    let beta = root(|b| b * b.sin() - 1.5 * b.cos(), 0.1, 1.5);
    let (_, _, omega) = with(&beam("rx", CLAMPED, ""), "point-rotary-inertia@n10.rx", &[0.002]);
    close(omega[0], beta * (6.0f64 / 0.003).sqrt(), (0.1 * beta).powi(2) / 20.0);
}

/// A brace across a square bay of hinged bars, EA as good as rigid: its roof of mass m sways at ω² = k cos² 45° / m, and a spring between two masses at
/// one place gives them k (1/m₁ + 1/m₂).
#[test]
fn a_connection_holds_a_bay_and_two_faces() {
    let bay = "retune: 1\nname: bay\nactive_dofs: [ux, uz]\nnodes: {a: [0, 0, 0], b: [0, 0, 2], c: [2, 0, 2], d: [2, 0, 0]}\nbars: {posts: {pairs: [[a, b], [d, c]], properties: {EA: 1e12 N}}, beam: {nodes: [b, c], properties: {EA: 1e12 N}}}\nmasses: {left: {node: b, mass: 3 kg}, right: {node: c, mass: 5 kg}}\nsprings: {sway: {node: b, k: {ux: 100 N/m}}}\nsupports: {feet: {nodes: [a, d]}}\n";
    let (_, _, omega) = with(bay, "connection@a:c", &[5000.0]);
    close(omega[0], ((100.0 + 2500.0) / 8.0_f64).sqrt(), 1e-6);
    let faces = "retune: 1\nname: faces\nactive_dofs: [ux, uy, uz]\nnodes: {a: [0, 0, 0], b: [0, 0, 0]}\nmasses: {a: {node: a, mass: 3 kg}, b: {node: b, mass: 5 kg}}\nsprings: {hold: {node: a, k: {ux: 1 N/m, uy: 1 N/m, uz: 1 N/m}}, carry: {node: b, k: {ux: 1 N/m, uy: 1 N/m, uz: 1 N/m}}}\nsupports: {}\n";
    let (_, _, omega) = with(faces, "connection@a:b", &[1e8]);
    close(omega[3], (1e8 * (1.0 / 3.0 + 1.0 / 5.0_f64)).sqrt(), 1e-6);
}

/// Two cantilevers whose tips a stiff link joins, across a gap and at one place, are those that a rigid link of the file joins.
#[test]
fn a_rigid_link_joins_in_displacement_and_rotation() {
    for gap in ["0.02 m", "0 m"] {
        let text = |links: &str| {
            format!(
                "retune: 1\nname: two\nnodes:\n  a0: [0, 0, 0]\n  a1: [0.5 m, 0, 0]\n  a2: [1 m, 0, 0]\n  b0: [0, 0, {gap}]\n  b1: [0.5 m, 0, {gap}]\n  b2: [1 m, 0, {gap}]\nsections:\n  \
                 bar: {{E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {{rectangle: {{width: 20 mm, height: 10 mm}}}}}}\nbeams:\n  a: {{chain: [a0, a1, a2], section: bar}}\n  \
                 b: {{chain: [b0, b1, b2], section: bar}}\nsupports: {{a: {{node: a0}}, b: {{node: b0}}}}\n{links}"
            )
        };
        let (_, linked) = without(&text("rigid_links: {tips: {master: a2, slaves: [b2]}}\n"));
        let (.., stiff) = with(&text(""), "rigid-link@a2:b2", &[1e9]);
        for (own, expected) in stiff.iter().zip(&linked).take(4) {
            close(*own, *expected, 1e-3);
        }
        let (.., soft) = with(&text(""), "rigid-link@a2:b2", &[0.0]);
        let (_, apart) = without(&text(""));
        close(soft[0], apart[0], 1e-9);
    }
}

#[test]
fn mass_and_air_along_a_beam_scale_its_frequencies() {
    let text = beam("uz, ry", CLAMPED, "");
    let before = without(&text).1;
    for (id, more) in [("distributed-mass@b", 0.5), ("air-mass@b.z", 0.5), ("distributed-mass@b", -1.2)] {
        let (model, _, omega) = with(&text, id, &[more]);
        close(omega[2] / before[2], (2.0f64 / (2.0 + more)).sqrt(), 1e-10);
        let weighed = model.mass_properties(&[more]).unwrap().unwrap().mass;
        close(weighed, if id.starts_with("air") { 2.0 } else { 2.0 + more }, 1e-12);
    }
    // Nine tenths may be missing, and no more.
    let (model, _, _) = load(&text, &Registry::builtin()).unwrap();
    let structure = Structure::new(&model, Context::nothing());
    let candidate = Effects::builtin().candidate(&structure, "distributed-mass@b").unwrap();
    close(candidate.parameters[0].bounds[0], -1.8, 1e-12);
}

#[test]
fn rotary_inertia_and_shear_follow_rayleigh_and_timoshenko() {
    // Eighty elements: the error of the shear-flexible element falls with the square of its length, from 3e-3 at ten.
    let text = beam("uz, ry", PINNED, "").replace("  b:\n", "  b:\n    subdivide: 8\n");
    for (id, size, ratio) in [("section-rotary-inertia@b.ry", 0.01, 0.005), ("shear-flexibility@b.uz", 5e-4, 0.005)] {
        let (_, _, omega) = with(&text, id, &[size]);
        for n in 1..=2 {
            // ω² = ω0² / (1 + (nπ/L)² ρ²), and with EI c in place of ρ².
            let a = f64::from(n) * std::f64::consts::PI;
            close(omega[n as usize - 1], bending(a) / (1.0 + a * a * ratio).sqrt(), 3e-3 / 64.0);
        }
    }
}

#[test]
fn a_flexible_root_follows_chun() {
    // k L / EI = 10; K. R. Chun 1972.
    let equation = |b: f64| 1.0 + b.cos() * b.cosh() + b / 10.0 * (b.cos() * b.sinh() - b.sin() * b.cosh());
    let (_, _, omega) = with(&beam("uz, ry", CLAMPED, ""), "root-flexibility@b.1:n0.ry", &[0.01]);
    close(omega[0], bending(root(equation, 0.5, 1.875)), 1e-4);
}

#[test]
fn a_link_that_gives_is_a_root_that_gives() {
    let spring = "springs:\n  s: {node: far, k: {uz: 1e9, ry: 1e9}}\n";
    let text = beam("uz, ry", "", &format!("rigid_links:\n  l: {{master: far, slaves: [n0]}}\n{spring}"))
        .replace("nodes:\n", "nodes:\n  far: [-0.2 m, 0, 0]\n");
    let (_, _, linked) = with(&text, "link-flexibility@b.1:n0.ry", &[0.01]);
    let (_, _, clamped) = with(&beam("uz, ry", CLAMPED, ""), "root-flexibility@b.1:n0.ry", &[0.01]);
    close(linked[0], clamped[0], 1e-6);
}

#[test]
fn a_joint_in_the_middle_of_a_pinned_beam() {
    // Half of it, z = β/2: the slope jumps by c M, 4 cos z = c EI β/L (sin z - cos z tanh z).
    let c_ei = 0.01 * 10.0;
    let equation = |b: f64| {
        let z = 0.5 * b;
        4.0 * z.cos() - c_ei * b * (z.sin() - z.cos() * z.tanh())
    };
    let text = beam("uz, ry", PINNED, "");
    let (_, _, omega) = with(&text, "joint-flexibility@b.5:n5.ry", &[0.01]);
    close(omega[0], bending(root(equation, 2.0, std::f64::consts::PI)), 1e-4);
    // The second mode has no moment in the middle.
    close(omega[1], bending(2.0 * std::f64::consts::PI), 2e-4);
}

#[test]
fn stiffness_of_one_kind_scales_the_modes_of_that_kind() {
    let bending_only = beam("uz, ry", CLAMPED, "");
    let torsion_only = beam("rx", CLAMPED, "");
    for (id, size, bends, twists) in [
        ("stiffness-change@b", 0.21, 1.1, 1.1),
        ("bending-stiffness-change@b.ry", 0.21, 1.1, 1.0),
        ("torsion-stiffness-change@b.rx", 0.21, 1.0, 1.1),
        ("softening@whole", 0.19, 0.9, 0.9),
    ] {
        for (text, factor) in [(&bending_only, bends), (&torsion_only, twists)] {
            let registry = Registry::builtin();
            let (model, _, _) = load(text, &registry).unwrap();
            let context = Context::default();
            let structure = Structure::new(&model, &context);
            if Effects::builtin().candidate(&structure, id).is_err() {
                assert!(factor == 1.0, "{id} is not offered");
                continue;
            }
            close(with(text, id, &[size]).2[1] / without(text).1[1], factor, 1e-9);
        }
    }
}

#[test]
fn two_sides_part() {
    let text = "retune: 1\nname: t\nactive_dofs: [uz, ry]\nsymmetry: {normal: x}\nnodes:\n  a: [-1, 0, 0]\n  o: [0, 0, 0]\n  b: [1, 0, 0]\n\
        beams:\n  l: {nodes: [o, a], section: s}\n  r: {nodes: [o, b], section: s}\nsections:\n  s: {EIy: 10, mass_per_length: 2}\n\
        supports:\n  c: {node: o}\n";
    let before = without(text).1;
    let (_, _, omega) = with(text, "asymmetry@l+r.stiffness", &[0.19]);
    close(omega[0] / before[0], 0.9, 1e-9);
    close(omega[1] / before[0], 1.19f64.sqrt(), 1e-9);
}

#[test]
fn tension_stiffens_a_pinned_beam() {
    let (_, _, omega) = with(&beam("uz, ry", PINNED, ""), "axial-preload@b", &[20.0]);
    for n in 1..=2 {
        let a = f64::from(n) * std::f64::consts::PI;
        // ω² = ω0² (1 + P L² / (n²π² EI)); Blevins 1979, table 8-20.
        close(omega[n as usize - 1], bending(a) * (1.0 + 20.0 / (a * a * 10.0)).sqrt(), 2e-4);
    }
}

#[test]
fn a_taper_keeps_the_mean() {
    let text = beam("rx", "a: {node: n0}, b: {node: n10}", "");
    let (model, system, _) = with(&text, "taper@b.rx", &[0.4]);
    // Ten elements of GJ/l = 60 N m: factors 1 + 0.4 (2i - 11)/10 for i = 1..10; a row is the sum of its two elements.
    for row in 0..9 {
        let factor = |i: f64| 1.0 + 0.4 * (2.0 * i - 11.0) / 10.0;
        close(system.stiffness[(row, row)], 60.0 * (factor(row as f64 + 1.0) + factor(row as f64 + 2.0)), 1e-12);
    }
    assert_eq!(model.parameters().len(), 1);
}

const MASS_ON_SPRING: &str = "retune: 1\nname: t\nactive_dofs: [uz, ry]\nnodes:\n  n: [0, 0, 0]\n  far: [1, 0, 0]\n\
    rigid_links:\n  l: {master: n, slaves: [far]}\n\
    masses:\n  m: {node: n, mass: 2 kg, inertia: {yy: 0.3 kg m2}}\nsprings:\n  s: {node: n, k: {uz: 800 N/m, ry: 500}}\n";

/// ω² of two masses: the host on k, the store on it.
fn two_masses(k: f64, m: f64, ks: f64, ms: f64) -> [f64; 2] {
    let (a, b, c) = (m * ms, -(ks * m + (k + ks) * ms), k * ks);
    let d = (b * b - 4.0 * a * c).sqrt();
    [(-b - d) / (2.0 * a), (-b + d) / (2.0 * a)]
}

#[test]
fn stores_on_springs_split_a_mode() {
    for (id, k, m, ks, ms) in
        [("sprung-mass@n.uz", 800.0, 2.0, 90.0, 0.25), ("sprung-inertia@n.ry", 500.0, 0.3, 70.0, 0.04)]
    {
        let (_, _, omega) = with(MASS_ON_SPRING, id, &[ms, ks]);
        for expected in two_masses(k, m, ks, ms) {
            assert!(omega.iter().any(|w| (w * w / expected - 1.0).abs() < 1e-9), "{omega:?} lacks {expected}");
        }
        // Without mass the store follows: the modes are those of the host.
        let (_, _, omega) = with(MASS_ON_SPRING, id, &[0.0, ks]);
        close(omega[0], 20.0, 1e-9);
    }
}

#[test]
fn an_offset_couples_plunge_and_pitch_of_a_rigid_section() {
    let e = 0.1;
    let (_, system, omega) = with(MASS_ON_SPRING, "mass-offset@m.x", &[e]);
    close(system.mass[(0, 1)], -2.0 * e, 1e-12);
    close(system.mass[(1, 1)], 0.3 + 2.0 * e * e, 1e-12);
    // det [K - λ M] = 0.
    let det = |l: f64| (800.0 - 2.0 * l) * (500.0 - (0.3 + 2.0 * e * e) * l) - (2.0 * e * l).powi(2);
    assert!(omega.iter().all(|w| det(w * w).abs() < 1e-6 * 800.0 * 500.0), "{omega:?}");
}

#[test]
fn springs_and_dashpots_stand_on_their_dof() {
    let (_, system, omega) = with(MASS_ON_SPRING, "ground-spring@n.uz", &[450.0]);
    close(omega[0], 25.0, 1e-9);
    assert!(system.damping.is_none());
    let (_, system, _) = with(MASS_ON_SPRING, "ground-dashpot@n.uz", &[7.0]);
    assert_eq!(system.damping, Some(DMatrix::from_row_slice(2, 2, &[7.0, 0.0, 0.0, 0.0])));
    let damped = MASS_ON_SPRING.replace("ry: 500}", "ry: 500}, c: {uz: 8, ry: 2}");
    let (_, system, _) = with(&damped, "dashpot-change@s", &[-0.25]);
    assert_eq!(system.damping, Some(DMatrix::from_row_slice(2, 2, &[6.0, 0.0, 0.0, 1.5])));
}

#[test]
fn proportional_damping_is_proportional() {
    let text = beam("uz, ry", CLAMPED, "");
    let (_, s, _) = with(&text, "stiffness-damping@b", &[1e-3]);
    assert!((s.damping.unwrap() - &s.stiffness * 1e-3).amax() < 1e-12 * s.stiffness.amax());
    let (_, s, _) = with(&text, "mass-damping@b", &[0.7]);
    assert!((s.damping.unwrap() - &s.mass * 0.7).amax() < 1e-12 * s.mass.amax());
}

#[test]
fn sensors_weigh_what_point_masses_weigh() {
    let text = beam("uz, ry", CLAMPED, "");
    let (_, sensors, _) = with(&text, "sensor-mass@whole", &[0.03]);
    let base = without(&text).0;
    let added = sensors.mass - base.mass;
    close(added.trace(), 0.06, 1e-12);

    // On an arm, and shared by two nodes: m, m a² about the node, and first moments.
    let (model, _, _) = load(&text, &Registry::builtin()).unwrap();
    let on_arm = |node: &str, share| SensorLoad { node: node.to_string(), share, arm: [0.05, 0.0, 0.0] };
    let context = Context {
        sensors: vec![SensorLoad::on("n2"), SensorLoad::on("n3"), on_arm("n4", 0.25), on_arm("n10", 1.0)],
        ..Context::default()
    };
    let structure = Structure::new(&model, &context);
    let candidate = Effects::builtin().candidate(&structure, "sensor-mass@whole").unwrap();
    let patched = candidate.build(&model, &Registry::builtin()).unwrap();
    let theta = patched.theta(structure.theta(), &[0.03]);
    let added = patched.model.assemble(&theta).unwrap().mass - without(&text).0.mass;
    close(added.trace(), 0.06 + 0.0375 * (1.0 + 0.05 * 0.05), 1e-12);
    let n = added.nrows();
    close(added[(n - 1, n - 2)].abs(), 0.03 * 0.05, 1e-12);
}

/// A square frame without one of its diagonals, and by the effect with nearly nothing of it; a tree has no member to spare.
#[test]
fn an_absent_member_is_a_structure_without_it() {
    let text = "retune: 1\nname: square\nactive_dofs: [ux, uz, ry]\nnodes: {a: [0, 0, 0], b: [1, 0, 0], c: [1, 0, 1], d: [0, 0, 1]}\nsections:\n  \
        strut: {E: 70 GPa, G: 27 GPa, density: 2700 kg/m3, shape: {rectangle: {width: 10 mm, height: 10 mm}}}\nbeams:\n  \
        right: {nodes: [b, c], section: strut, subdivide: 3}\n  top: {nodes: [c, d], section: strut, subdivide: 3}\n  left: {nodes: [d, a], section: strut, subdivide: 3}\n";
    let supports = "supports: {feet: {nodes: [a, b]}}\n";
    let braced = format!("{text}  brace: {{nodes: [a, c], section: strut, subdivide: 3}}\n{supports}");
    let (_, _, omegas) = with(&braced, "absent-member@brace", &[0.999_999]);
    let (_, expected) = without(&format!("{text}{supports}"));
    close(omegas[0], expected[0], 5e-3);
    let listed = |text: &str| -> Vec<String> {
        let (model, _, _) = load(text, &Registry::builtin()).unwrap();
        let context = Context::default();
        let all = candidates(&model, &Effects::builtin(), &context);
        all.iter().filter(|c| c.effect.name() == "absent-member").map(Candidate::id).collect()
    };
    // Of a portal every member closes the loop through the ground.
    assert!(listed(&braced).contains(&"absent-member@brace".to_string()), "{:?}", listed(&braced));
    assert_eq!(listed(&beam("uz, ry", CLAMPED, "")), Vec::<String>::new());
}

/// A cantilever that is rigid over a at its clamp is a shorter one: ω grows by (L/(L - a))².
#[test]
fn a_rigid_end_in_a_clamp_shortens_a_cantilever() {
    let a = 0.03;
    let (_, _, omega) = with(&beam("uz, ry", CLAMPED, ""), "rigid-end@b.1:n0", &[a]);
    let (_, whole) = without(&beam("uz, ry", CLAMPED, ""));
    for mode in 0..3 {
        close(omega[mode] / whole[mode], (1.0 - a).powi(-2), 3.0 * MESH);
    }
}

/// M gains m (ẇ + e φ̇)² for an arm along y: m on w, m e between w and φ, m e² on φ.
#[test]
fn an_eccentric_mass_couples_displacement_with_rotation() {
    let text = beam("uz, rx, ry", CLAMPED, "");
    let (model, system, _) = with(&text, "eccentric-mass@n10.y", &[0.4, -0.05]);
    let (base, _) = without(&text);
    let row = |dof| model.dof_map().express(10, dof)[0].0;
    let (w, phi) = (row(Dof::Uz), row(Dof::Rx));
    let gained = &system.mass - &base.mass;
    close(gained[(w, w)], 0.4, 1e-12);
    close(gained[(w, phi)], -0.02, 1e-12);
    close(gained[(phi, phi)], 0.001, 1e-12);
    let (_, point, _) = with(&text, "point-mass@n10", &[0.4]);
    let (_, without_arm, _) = with(&text, "eccentric-mass@n10.y", &[0.4, 0.0]);
    assert!((&point.mass - &without_arm.mass).amax() < 1e-15);
}

/// An arm in all axes: M gains m |u̇ + θ̇ × e|², so that the masses of a body with its centre of gravity there are the same.
#[test]
fn an_eccentric_mass_may_stand_off_in_all_axes() {
    let free = "nodes: {a: [0, 0, 0], b: [1, 0, 0]}\nsections: {s: {E: 70 GPa, G: 26 GPa, density: 2700 kg/m3, \
        shape: {rectangle: {width: 20 mm, height: 10 mm}}}}\nbeams: {beam: {nodes: [a, b], section: s}}\nsupports: {clamp: {nodes: [a]}}\n";
    let text = format!("retune: 1\nname: arm\n{free}");
    let (_, found, _) = with(&text, "eccentric-mass@b.all_axes", &[0.4, 0.02, -0.05, 0.03]);
    let (expected, _) =
        without(&format!("{text}masses: {{m: {{node: b, mass: 0.4 kg, offset: [20 mm, -50 mm, 30 mm]}}}}\n"));
    assert!((&found.mass - &expected.mass).amax() < 1e-12, "{}", &found.mass - &expected.mass);
}

/// A body without a quarter of itself, and without all of it.
#[test]
fn an_absent_mass_is_a_lighter_one() {
    let text =
        beam("uz, ry", CLAMPED, "masses: {tip: {node: n10, mass: 300 g, inertia: {xx: 1e-4, yy: 1e-4, zz: 1e-4}}}\n");
    let (_, found, _) = with(&text, "absent-mass@tip", &[0.25]);
    let lighter = "masses: {tip: {node: n10, mass: 225 g, inertia: {xx: 7.5e-5, yy: 7.5e-5, zz: 7.5e-5}}}\n";
    let (expected, _) = without(&beam("uz, ry", CLAMPED, lighter));
    assert!((&found.mass - &expected.mass).amax() < 1e-12);
    let (_, none, _) = with(&text, "absent-mass@tip", &[1.0]);
    let (bare, _) = without(&beam("uz, ry", CLAMPED, ""));
    assert!((&none.mass - &bare.mass).amax() < 1e-12);
}

/// Section of 20 mm x 60 mm on a column along z, or on a girder along x.
fn stout(direction: &str, more: &str) -> String {
    let at = |i: u32| {
        let s = format!("{} m", f64::from(i) / 20.0);
        if direction == "z" { format!("[0, 0, {s}]") } else { format!("[{s}, 0, 0]") }
    };
    let nodes: Vec<String> = (0..=20).map(|i| format!("n{i}: {}", at(i))).collect();
    let chain: Vec<String> = (0..=20).map(|i| format!("n{i}")).collect();
    format!(
        "retune: 1\nname: test\nnodes: {{{}}}\nbeams:\n  b: {{chain: [{}], orientation: [0, 1, 0], properties: {{E: 70 GPa, nu: 0.3, \
         density: 2700 kg/m3, A: 1200 mm2, Iy: 4e4 mm4, Iz: 36e4 mm4, J: 1.3e5 mm4{more}}}}}\nsupports: {{root: {{node: n0}}}}\n",
        nodes.join(", "),
        chain.join(", ")
    )
}

/// A cantilever column under its own weight q per length buckles at q L³ = 7.837 EI. S. P. Timoshenko, J. M. Gere, Theory of Elastic
/// Stability, 1961, section 2.12. Hanging, it is stiffer.
#[test]
fn own_weight_buckles_a_column_at_the_known_height() {
    let text = stout("z", "");
    // EI = 70e9 * 4e-8 N m², μ = 3.24 kg/m, L = 1 m.
    let critical = 7.837 * 2800.0 / 3.24;
    let (.., upright) = without(&text);
    let (.., hanging) = with(&text, "self-weight@whole.z", &[0.5 * critical]);
    assert!(hanging[0] > 1.1 * upright[0]);
    // λ falls nearly linearly with the load, to zero at the critical one.
    let lambda = |share: f64| with(&text, "self-weight@whole.z", &[-share * critical]).2[0].powi(2);
    let (a, b) = (lambda(0.98), lambda(0.99));
    close(0.99 + 0.01 * b / (a - b), 1.0, 2e-3);
}

/// The whole of shear and rotary inertia at s = 1: the same as κ = 5/6 and ρ I written in the file.
#[test]
fn timoshenko_is_what_the_section_says() {
    let own = ", kappa_y: 0.8333333333333334, kappa_z: 0.8333333333333334, rotary_inertia_y: 1.08e-4 kg m, rotary_inertia_z: 9.72e-4 kg m";
    let (expected, _) = without(&stout("x", own));
    let (_, found, _) = with(&stout("x", ""), "timoshenko@b", &[1.0]);
    assert!((&found.stiffness - &expected.stiffness).amax() < 1e-9 * expected.stiffness.amax());
    assert!((&found.mass - &expected.mass).amax() < 1e-9 * expected.mass.amax());
}

/// A member beside its nodes is the one that stands on arms of this length.
#[test]
fn an_eccentric_member_stands_on_arms() {
    let text = |offsets: &str| {
        format!(
            "retune: 1\nname: test\nnodes: {{a: [0, 0, 0], b: [1 m, 0, 0]}}\nbeams:\n  b: {{nodes: [a, b]{offsets}, properties: {{EA: 1e6 N, \
             EIy: 10 N m2, EIz: 20 N m2, GJ: 6 N m2, mass_per_length: 2 kg/m, polar_inertia_per_length: 0.003 kg m}}}}\nsupports: {{root: {{node: a}}}}\n"
        )
    };
    let (expected, _) = without(&text(", offsets: [[0, 0, 0.05 m], [0, 0, 0.05 m]]"));
    let (_, found, _) = with(&text(""), "member-eccentricity@b.z", &[0.05]);
    assert!((&found.stiffness - &expected.stiffness).amax() < 1e-12 * expected.stiffness.amax());
    assert!((&found.mass - &expected.mass).amax() < 1e-12 * expected.mass.amax());
}

/// Partners together keep a symmetric structure symmetric: the signs of mirrored axes are right.
#[test]
fn partners_keep_the_symmetry() {
    let registry = Registry::builtin();
    for text in [
        include_str!("../../../models/bff.yaml"),
        include_str!("../../../models/garteur.yaml"),
        include_str!("../../../models/free_beam.yaml"),
    ] {
        let (model, _, _) = load(text, &registry).unwrap();
        let context = Context::default();
        let structure = Structure::new(&model, &context);
        let theta = structure.theta().to_vec();
        // Both ends of a member alone; of it and its image there are four.
        let of_one_member: Vec<Location> =
            structure.both_ends(crate::effect::structure::Joint::Member, &[Dof::Ry, Dof::Rz]);
        for candidate in candidates(&model, &Effects::builtin(), &context) {
            let at = &candidate.location;
            let is_of_one_member = at.names.len() == 2 && of_one_member.contains(at);
            if at.names.len() < 2 || is_of_one_member || candidate.effect.name() == "asymmetry" {
                continue;
            }
            let patched = candidate.build(&model, &registry).unwrap();
            let system = patched.model.assemble(&patched.theta(&theta, &patched.typical)).unwrap();
            let mirror = patched.model.mirror().unwrap();
            for (what, a) in [("K", &system.stiffness), ("M", &system.mass)] {
                let image = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| {
                    let ((r, p), (c, q)) = (mirror[i], mirror[j]);
                    p * q * a[(r, c)]
                });
                let difference = (image - a).amax();
                assert!(difference < 1e-9 * a.amax(), "{}: {what} differs by {difference:e}", candidate.id());
            }
        }
    }
}

/// A clamped bar of one element: K = EA/L, M = m L/3 consistent and m L/2 lumped, so ω² = 3 EA/(m L²) and 2 EA/(m L²).
#[test]
fn mass_may_be_at_the_nodes_or_between_them() {
    let bar = |lumping: &str| {
        format!(
            "retune: 1\nname: test\nactive_dofs: [ux]\nnodes: {{a: [0, 0, 0], b: [2 m, 0, 0]}}\nbars:\n  rod: {{nodes: [a, b], \
             properties: {{EA: 8 MN, mass_per_length: 3 kg/m{lumping}}}}}\nsupports: {{root: {{node: a}}}}\n"
        )
    };
    let omega = |factor: f64| (factor * 8e6 / (3.0 * 4.0)).sqrt();
    let (_, _, spread) = with(&bar(""), "mass-lumping@whole.lumped", &[0.0]);
    close(spread[0], omega(3.0), 1e-12);
    let (_, _, lumped) = with(&bar(""), "mass-lumping@whole.lumped", &[1.0]);
    close(lumped[0], omega(2.0), 1e-12);
    let (_, _, half) = with(&bar(", lumping: 1"), "mass-lumping@whole.consistent", &[0.5]);
    close(half[0], omega(1.0 / (0.5 / 2.0 + 0.5 / 3.0)), 1e-12);
}

/// Where a beam goes on over the node that a link carries, the link itself gives, about each axis and along it, and a written change is the screened one.
#[test]
fn a_link_under_a_beam_that_goes_on_gives_itself() {
    let text = "retune: 1\nname: saddle\n\
        nodes: {a: [0, 0, 0], m: [2, 0, 0], d: [1.5, 0, 0.3], s: [2.3, 0, 0.3], e: [3.2, 0, 0.3]}\n\
        sections: {deck: {E: 200 GPa, G: 80 GPa, A: 0.002 m2, Iy: 1e-6 m4, Iz: 1e-6 m4, J: 2e-6 m4, density: 7850 kg/m3, polar_inertia_per_length: 0.01 kg m}}\n\
        beams: {base: {nodes: [a, m], section: deck, subdivide: 4}, across: {chain: [d, s, e], section: deck, subdivide: 3}}\n\
        rigid_links: {saddle: {master: m, slaves: [s]}}\nsupports: {clamp: {node: a}}\n";
    let (model, _, _) = load(text, &Registry::builtin()).unwrap();
    let all = candidates(&model, &Effects::builtin(), &Context::default());
    let ids: Vec<String> = all.iter().map(Candidate::id).filter(|id| id.starts_with("link-flexibility@s.")).collect();
    assert_eq!(ids.len(), 6, "{ids:?}");
    let first = |c: f64| with(text, "link-flexibility@s.ry", &[c]).2[0];
    assert!(first(0.0) / first(1e-4) > 1.01);
}
