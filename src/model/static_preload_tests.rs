//! Static preloads against closed forms: strings, columns, blades that spin, what hangs.

use super::{Model, ParametricModel, Registry, load, solve_modes};
use crate::modal::SolveOptions;
use crate::yaml::Problem;
use std::f64::consts::PI;
use std::fmt::Write;

fn read(text: &str) -> Result<Model, Vec<Problem>> {
    load(text, &Registry::builtin()).map(|(model, ..)| model)
}

fn model(text: &str) -> Model {
    read(text).unwrap_or_else(|p| panic!("{p:#?}"))
}

/// ω² of the lowest modes.
fn lambdas(model: &Model, n: usize) -> Vec<f64> {
    let modes = solve_modes(model, &model.parameters().nominal(), SolveOptions { n_elastic: n, shift: None }).unwrap();
    modes.lambda.iter().copied().collect()
}

const L: f64 = 1.0;
const B: f64 = 0.05;
const E: f64 = 70e9;
const RHO: f64 = 2700.0;

/// A strip of shells along x, one across: `n_I_0`, `n_I_1`.
fn strip(n: usize, thickness: f64) -> String {
    let mut text = String::from("retune: 1\nname: strip\nnodes:\n");
    for i in 0..=n {
        let x = L * i as f64 / n as f64;
        writeln!(text, "  n_{i}_0: [{x}, 0, 0]\n  n_{i}_1: [{x}, {B}, 0]").unwrap();
    }
    writeln!(text, "sections: {{s: {{E: {E}, nu: 0, density: {RHO}, thickness: {thickness}}}}}\nelements:").unwrap();
    for i in 0..n {
        let j = i + 1;
        writeln!(text, "  e{i}: {{type: shell4, nodes: [n_{i}_0, n_{j}_0, n_{j}_1, n_{i}_1], section: s}}").unwrap();
    }
    text
}

/// A bar of bricks along x, one across: `n_I_J`, J round the section.
fn bar(n: usize, side: f64) -> String {
    let mut text = String::from("retune: 1\nname: bar\nnodes:\n");
    for i in 0..=n {
        let x = L * i as f64 / n as f64;
        for (j, [y, z]) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into_iter().enumerate() {
            writeln!(text, "  n_{i}_{j}: [{x}, {}, {}]", side * (y - 0.5), side * (z - 0.5)).unwrap();
        }
    }
    writeln!(text, "sections: {{s: {{E: {E}, nu: 0, density: {RHO}}}}}\nelements:").unwrap();
    for i in 0..n {
        let j = i + 1;
        // Lower face z = -½: (x0,y0) (x1,y0) (x1,y1) (x0,y1).
        writeln!(text, "  e{i}: {{type: hex8, nodes: [n_{i}_0, n_{j}_0, n_{j}_1, n_{i}_1, n_{i}_3, n_{j}_3, n_{j}_2, n_{i}_2], section: s}}").unwrap();
    }
    let held: Vec<String> = (0..4).map(|j| format!("n_0_{j}")).collect();
    text + &format!("supports: {{clamp: {{nodes: [{}]}}}}\n", held.join(", "))
}

/// ω² = N k²/m + D k⁴/m, k = π/L: a strip that is pulled at its end is a string with some bending of its own. The string of elements of length h is
/// (k h)²/12 too high in ω², the bending part (k h)²/4: with 24 elements 0.14 % and 0.4 %.
#[test]
fn a_strip_that_is_pulled_is_a_string() {
    let (t, pull) = (1e-3, 500.0);
    let held = "supports:\n  left: {nodes: [n_0_0, n_0_1], fixed: [ux, uy, uz, rx]}\n  right: {nodes: [n_24_0, n_24_1], fixed: [uy, uz, rx]}\n";
    let loaded = format!(
        "{}{held}preloads: {{pull: {{forces: {{end: {{nodes: [n_24_0, n_24_1], force: [{pull} N, 0, 0]}}}}}}}}\n",
        strip(24, t)
    );
    let k = PI / L;
    let of = |tension: f64| (tension / B * k.powi(2) + E * t.powi(3) / 12.0 * k.powi(4)) / (RHO * t);
    let (without, with) = (lambdas(&model(&(strip(24, t) + held)), 1)[0], lambdas(&model(&loaded), 1)[0]);
    assert!((without / of(0.0) - 1.0).abs() < 5e-3, "{without} {}", of(0.0));
    assert!((with / of(pull) - 1.0).abs() < 2e-3, "{with} {}", of(pull));
    assert!(of(pull) > 20.0 * of(0.0));
    // The tension itself is that of statics.
    let n11 = |m: &Model| {
        let e = &m.elements()[11];
        let at = e.kind.properties().iter().position(|p| p.name == "N11").unwrap();
        e.values_at(&[])[at].unwrap()
    };
    assert!((n11(&model(&loaded)) / (pull / B) - 1.0).abs() < 1e-9);
}

/// Euler's load of a clamped column of bricks, π² EI/4 L². The curved part of its form has (k h)²/12 more stiffness, k = π/2 L: 0.08 % with 16.
#[test]
fn a_column_of_bricks_has_eulers_load() {
    let side: f64 = 0.02;
    let euler = PI * PI * E * side.powi(4) / 12.0 / (4.0 * L * L);
    let ends: Vec<String> = (0..4).map(|j| format!("n_16_{j}")).collect();
    let pressed = |share: f64| {
        format!(
            "{}preloads: {{weight: {{forces: {{top: {{nodes: [{}], force: [{} N, 0, 0]}}}}}}}}\n",
            bar(16, side),
            ends.join(", "),
            -share * euler
        )
    };
    let m = model(&pressed(0.5));
    let critical = m.critical_preload(&[]).unwrap().unwrap();
    assert!((critical.factor / 2.0 - 1.0).abs() < 3e-3, "{}", critical.factor);
    // Southwell's theorem: ω² is not below ω0² (1 - P/P_cr), and near it, for the form of buckling is nearly that of the mode.
    let ratio = lambdas(&m, 1)[0] / lambdas(&model(&bar(16, side)), 1)[0];
    assert!((0.5..0.53).contains(&ratio), "{ratio}");
    let buckled = solve_modes(&model(&pressed(1.1)), &[], SolveOptions { n_elastic: 1, shift: None });
    assert!(buckled.unwrap_err().to_string().contains("buckles"));
}

/// Southwell's ω² = ω0² + φ Ω² of a cantilever whose root is on the axis: 1.193 for bending along the axis, 0.193 for bending in the plane of rotation (R.
/// Southwell, F. Gough, The free transverse vibration of airscrew blades, ARC R & M 766, 1921), for beams, shells and bricks.
#[test]
fn a_blade_that_spins_has_southwells_coefficients() {
    // φ = ∫ T w'² dx / ∫ m w² dx with T = ½ m Ω² (L² - x²) and the first mode of a cantilever.
    let root = 1.875_104_07_f64;
    let sigma = (root.cosh() + root.cos()) / (root.sinh() + root.sin());
    let (mut pull, mut mass) = (0.0, 0.0);
    for i in 0..2000 {
        let x = (f64::from(i) + 0.5) / 2000.0;
        let (b, c) = (root * x, 1.0 - x * x);
        let w = b.cosh() - b.cos() - sigma * (b.sinh() - b.sin());
        let slope = root * (b.sinh() + b.sin() - sigma * (b.cosh() - b.cos()));
        pull += 0.5 * c * slope * slope;
        mass += w * w;
    }
    let phi = pull / mass;
    assert!((phi - 1.193).abs() < 1e-3, "{phi}");
    let spin = |speed: f64| format!("preloads: {{turn: {{spin: {{speed: {speed} rad/s, axis: [0, 0, 1]}}}}}}\n");
    let beam = "retune: 1\nname: blade\nnodes: {a: [0, 0, 0], b: [1, 0, 0]}\n\
                sections: {s: {E: 70e9, G: 26e9, density: 2700, shape: {rectangle: {width: 20 mm, height: 10 mm}}}}\n\
                beams: {ab: {nodes: [a, b], section: s, subdivide: 16}}\nsupports: {root: {node: a}}\n";
    let shells = strip(24, 0.01) + "supports: {clamp: {nodes: [n_0_0, n_0_1]}}\n";
    for (name, text) in [("beam", beam.to_string()), ("shell4", shells), ("hex8", bar(24, 0.02))] {
        let still = model(&text);
        let theta = still.parameters().nominal();
        let options = SolveOptions { n_elastic: 6, shift: None };
        let modes = solve_modes(&still, &theta, options).unwrap();
        // The first mode along z and the first along y.
        let moves = |m: &crate::modal::Modes, i: usize, axis: usize| {
            let rows = still.dof_map().rows().iter().enumerate();
            rows.filter(|(_, (_, d))| *d as usize == axis).map(|(r, _)| m.shapes[(r, i)].powi(2)).sum::<f64>()
        };
        let first = |m: &crate::modal::Modes, axis: usize| {
            (0..m.len()).find(|&i| moves(m, i, axis) > 10.0 * moves(m, i, 3 - axis)).unwrap()
        };
        let speed = 0.2 * modes.lambda[0].sqrt();
        // A square section has both at one frequency: the spin parts them.
        let turning = solve_modes(&model(&(text.clone() + &spin(speed))), &theta, options).unwrap();
        let slow = solve_modes(&model(&(text + &spin(0.02 * speed))), &theta, options).unwrap();
        for (axis, expected) in [(2, phi), (1, phi - 1.0)] {
            let (a, b) = (first(&slow, axis), first(&turning, axis));
            let found = (turning.lambda[b] - slow.lambda[a]) / (speed * speed * (1.0 - 4e-4));
            assert!((found - expected).abs() < 0.02, "{name} along {axis}: {found} against {expected}");
        }
    }
}

/// What hangs is pulled by what hangs below it: ρ A g (L - x), in the middle of each element; and a parameter says how much of it acts.
#[test]
fn what_hangs_is_pulled_by_its_weight() {
    let text = "retune: 1\nname: rope\nparameters: {share: {value: 0.5, bounds: [0, 1]}}\nnodes: {a: [0, 0, 0], b: [0, 0, -2]}\n\
                sections: {s: {E: 70e9, G: 26e9, density: 2700, shape: {rectangle: {width: 20 mm, height: 10 mm}}}}\n\
                beams: {ab: {nodes: [a, b], section: s, subdivide: 8, orientation: [0, 1, 0]}}\nsupports: {root: {node: a}}\n\
                preloads: {own: {gravity: [0, 0, -9.81 m/s2], factor: 2*share}}\n";
    let m = model(text);
    for (i, e) in m.elements().iter().enumerate() {
        let at = e.kind.properties().iter().position(|p| p.name == "axial_force").unwrap();
        let below = 2.0 * (1.0 - (i as f64 + 0.5) / 8.0);
        let exact = 2700.0 * 2e-4 * 9.81 * below;
        let found = e.values_at(&[0.5])[at].unwrap();
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
        assert!((e.values_at(&[0.0])[at].unwrap()).abs() < 1e-12);
    }
    assert!(m.affine().is_some());
    let (half, slope) = (m.assemble(&[0.5]).unwrap(), m.assemble_derivative(&[0.5], 0).unwrap());
    let change = m.assemble(&[0.75]).unwrap().stiffness - half.stiffness;
    assert!((change - slope.stiffness * 0.25).amax() < 1e-9 * m.assemble(&[0.5]).unwrap().stiffness.amax());
}

#[test]
fn mistakes_in_preloads_have_their_places() {
    let base = strip(4, 1e-3);
    let held = "supports: {clamp: {nodes: [n_0_0, n_0_1]}}\n";
    for (supports, entry, path, expected) in [
        (held, "{}", "preloads.p", "it has no load"),
        (held, "{forces: {f: {nodes: [n_9_9], force: [1 N, 0, 0]}}}", "preloads.p.forces.f.nodes", "n_9_9"),
        (held, "{forces: {f: {nodes: [n_4_0]}}}", "preloads.p.forces.f", "give its `force`"),
        (held, "{forces: {f: {nodes: [], force: [1 N, 0, 0]}}}", "preloads.p.forces.f.nodes", "needs the nodes"),
        (held, "{gravity: [0, 0, 9.81 m]}", "preloads.p.gravity[2]", "unit"),
        (held, "{gravity: [0, 0, 9.81], factor: g}", "preloads.p.factor", "`g`"),
        (held, "{spin: {speed: 10 rpm, axis: [0, 0, 0]}}", "preloads.p.spin.axis", "direction"),
        (held, "{forces: {f: {nodes: [n_0_0], force: [1 N, 0, 0]}}}", "preloads.p", "nothing that moves"),
        ("", "{gravity: [9.81, 0, 0]}", "preloads.p", "no equilibrium"),
    ] {
        let problems = read(&format!("{base}{supports}preloads: {{p: {entry}}}\n")).unwrap_err();
        let found = problems.iter().any(|p| p.path == path && p.message.contains(expected));
        assert!(found, "{entry}: {problems:#?}");
    }
}
