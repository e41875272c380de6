//! Closed forms, published roots and convergence rates, the whole way from a model file to frequencies.
//!
//! `src/element` holds each element to its own closed forms; here the file, its units and frames, constraints,
//! assembly, condensation, eigen-solution and names of modes stand between the equation and the result.

#![allow(clippy::format_collect, reason = "texts of a few lines, where reading matters more than one allocation")]

use retune::linalg::{Complex, DMatrix};
use retune::modal::reduction::{guyan, selection};
use retune::modal::{ModalDamping, Modes, SolveOptions, solve, synthesize};
use retune::model::{Model, ParametricModel, Registry, System, load};
use retune::update::name_modes;
use std::f64::consts::{PI, TAU};

fn build(text: &str) -> Model {
    match load(text, &Registry::builtin()) {
        Ok((model, ..)) => model,
        Err(problems) => panic!("{problems:#?}\n{text}"),
    }
}

fn file(name: &str) -> String {
    let path = format!("{}/models/verification/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn solved(model: &Model, n_elastic: usize) -> (System, Modes) {
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let options = SolveOptions { n_elastic, shift: None };
    let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
    (system, modes)
}

/// Elastic ω, rad/s.
fn omegas(text: &str, n: usize) -> Vec<f64> {
    let (_, modes) = solved(&build(text), n);
    modes.lambda.iter().skip(modes.n_rigid).map(|l| l.sqrt()).collect()
}

/// The root of `f` between two places of different sign, by bisection.
fn root(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let (mut low, mut high) = (low, high);
    assert!(f(low) * f(high) < 0.0, "no change of sign between {low} and {high}");
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(low) * f(middle) <= 0.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

fn assert_close(computed: &[f64], exact: &[f64], tolerance: f64) {
    assert_eq!(computed.len(), exact.len(), "{computed:?} against {exact:?}");
    for (c, e) in computed.iter().zip(exact) {
        assert!((c / e - 1.0).abs() < tolerance, "{computed:?} against {exact:?}");
    }
}

/// A beam of unit length, rigidity and mass in the x-z plane, so that ω = β², in `n` elements; `rest` adds to the file.
fn unit_beam(n: usize, properties: &str, rest: &str) -> String {
    format!(
        "retune: 1\nname: unit beam\nactive_dofs: [uz, ry]\nnodes: {{a: [0, 0, 0], b: [1 m, 0, 0]}}\nbeams:\n  beam: {{nodes: [a, b], subdivide: {n}, properties: {{{properties}}}}}\n{rest}"
    )
}

const SLENDER: &str = "EIy: 1 N m2, mass_per_length: 1 kg/m";

/// Errors that are positive (the elements are conforming) and shrink with the given power of the element length.
fn check_rate(exact: &[f64], power: f64, meshes: [usize; 2], text: impl Fn(usize) -> String) {
    let errors = meshes.map(|n| {
        let computed = omegas(&text(n), exact.len());
        computed.iter().zip(exact).map(|(c, e)| c / e - 1.0).collect::<Vec<f64>>()
    });
    for mode in 0..exact.len() {
        let (coarse, fine) = (errors[0][mode], errors[1][mode]);
        assert!(fine > 0.0 && coarse < 0.1, "mode {}: errors {coarse:e}, {fine:e}", mode + 1);
        let rate = (coarse / fine).log2();
        assert!((rate - power).abs() < 0.1, "mode {}: rate {rate}, errors {coarse:e}, {fine:e}", mode + 1);
    }
}

fn squares(roots: &[f64]) -> Vec<f64> {
    roots.iter().map(|b| b * b).collect()
}

/// R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1: cos β cosh β = -1.
#[test]
fn blevins_cantilever_first_four_modes() {
    let exact =
        [(1.5, 2.2), (4.4, 5.0), (7.5, 8.2), (10.6, 11.4)].map(|(a, b)| root(|x: f64| x.cos() + 1.0 / x.cosh(), a, b));
    assert_close(&exact, &[1.87510407, 4.69409113, 7.85475744, 10.99554073], 1e-8);
    check_rate(&squares(&exact), 4.0, [16, 32], |n| unit_beam(n, SLENDER, "supports: {clamp: {node: a}}\n"));
}

/// Blevins, table 8-1: cos β cosh β = 1, after two rigid-body modes that are exactly zero.
#[test]
fn blevins_free_beam() {
    let exact = [(4.4, 5.0), (7.5, 8.2), (10.6, 11.4)].map(|(a, b)| root(|x: f64| x.cos() - 1.0 / x.cosh(), a, b));
    check_rate(&squares(&exact), 4.0, [16, 32], |n| unit_beam(n, SLENDER, ""));
    let (_, modes) = solved(&build(&unit_beam(8, SLENDER, "")), 3);
    assert_eq!((modes.n_rigid, modes.lambda[0], modes.lambda[1]), (2, 0.0, 0.0));
}

/// Blevins, table 8-1: β = jπ.
#[test]
fn blevins_pinned_beam() {
    let exact = [1.0, 2.0, 3.0].map(|j| j * PI);
    let pins = "supports: {pins: {nodes: [a, b], fixed: [uz]}}\n";
    check_rate(&squares(&exact), 4.0, [16, 32], |n| unit_beam(n, SLENDER, pins));
}

/// Cantilever with a tip mass of α beam masses: 1 + cos β cosh β - α β (sin β cosh β - cos β sinh β) = 0 (Blevins,
/// chapter 8).
#[test]
fn blevins_cantilever_with_tip_mass() {
    for alpha in [0.1, 1.0, 10.0] {
        let f = |b: f64| 1.0 + b.cos() * b.cosh() - alpha * b * (b.sin() * b.cosh() - b.cos() * b.sinh());
        let exact = [(0.3, 1.85), (3.0, 4.65), (6.2, 7.8)].map(|(a, b)| root(f, a, b));
        let rest = format!("supports: {{clamp: {{node: a}}}}\nmasses: {{tip: {{node: b, mass: {alpha} kg}}}}\n");
        // The first error on a finer mesh, 1e-10, would be rounding.
        check_rate(&squares(&exact), 4.0, [8, 16], |n| unit_beam(n, SLENDER, &rest));
    }
}

/// Pinned Timoshenko beam: deflection sin kx, rotation cos kx, so λ = ω² is the lower root of
/// ρI λ² - (EI k² + GA' + ρI GA' k²) λ + EI GA' k⁴ = 0 (unit mass per length). S. M. Han, H. Benaroya, T. Wei, Dynamics
/// of transversely vibrating beams using four engineering theories, J. Sound Vib. 225 (1999) 935-988.
#[test]
fn han_benaroya_wei_pinned_timoshenko_beam() {
    let (ga, rotary) = (60.0, 0.01);
    let exact = [1.0, 2.0, 3.0].map(|j| {
        let k2 = (j * PI) * (j * PI);
        let b = k2 + ga + rotary * ga * k2;
        (2.0 * ga * k2 * k2 / (b + (b * b - 4.0 * rotary * ga * k2 * k2).sqrt())).sqrt()
    });
    // Far from the slender beam's 9π²: the agreement is that of the theory.
    assert!(exact[2] < 0.6 * (3.0 * PI).powi(2));
    let properties = format!("{SLENDER}, shear_compliance_z: {:?} 1/N, rotary_inertia_y: {rotary} kg m", 1.0 / ga);
    let pins = "supports: {pins: {nodes: [a, b], fixed: [uz]}}\n";
    let at = |n| omegas(&unit_beam(n, &properties, pins), 3);
    let [coarse, fine, finest] = [32, 64, 128].map(at);
    for j in 0..3 {
        // Second order: two meshes extrapolate to fourth.
        assert!(
            (((coarse[j] - exact[j]) / (fine[j] - exact[j])).log2() - 2.0).abs() < 0.1,
            "{} {}",
            coarse[j],
            fine[j]
        );
        let extrapolated = (4.0 * finest[j] - fine[j]) / 3.0;
        assert!((extrapolated / exact[j] - 1.0).abs() < 1e-6, "{extrapolated} against {}", exact[j]);
    }
}

/// A portal of three equal members, clamped, by exact dynamic stiffness (V. Koloušek, Dynamics in Engineering
/// Structures, Butterworths 1973, chapter 3): with D = 1 - cos β cosh β and
///
/// ```text
/// s = β (sin cosh - cos sinh)/D    t = β (sinh - sin)/D    q = β² sin sinh/D    r = β³ (sin cosh + cos sinh)/D
/// symmetric: 2 s - t = 0           sway: (2 s + t)(r - β⁴/2) - q² = 0
/// ```
///
/// ω = 3.204 and 12.65 √(EI/mL⁴), as in Blevins's table of portal frames.
#[test]
fn portal_frame_by_dynamic_stiffness() {
    let parts = |b: f64| {
        let d = 1.0 - b.cos() * b.cosh();
        let s = b * (b.sin() * b.cosh() - b.cos() * b.sinh()) / d;
        let t = b * (b.sinh() - b.sin()) / d;
        let q = b * b * b.sin() * b.sinh() / d;
        let r = b.powi(3) * (b.sin() * b.cosh() + b.cos() * b.sinh()) / d;
        (s, t, q, r)
    };
    let sway = root(
        |b| {
            let (s, t, q, r) = parts(b);
            (2.0 * s + t) * (r - 0.5 * b.powi(4)) - q * q
        },
        1.0,
        2.5,
    );
    let symmetric = root(
        |b| {
            let (s, t, ..) = parts(b);
            2.0 * s - t
        },
        3.0,
        3.8,
    );
    assert!((sway * sway - 3.204).abs() < 1e-3 && (symmetric * symmetric - 12.65).abs() < 1e-2, "{sway} {symmetric}");
    let model = build(&file("portal"));
    let (_, modes) = solved(&model, 2);
    // (β/16)⁴/720 of discretisation; a share 1e-9 of stretching.
    assert_close(
        &modes.frequencies_hz().iter().map(|f| TAU * f).collect::<Vec<_>>(),
        &[sway * sway, symmetric * symmetric],
        5e-6,
    );
    let names = name_modes(&model, &[], &modes).unwrap();
    assert_eq!(names.iter().map(|n| n.family).collect::<Vec<_>>(), [Some("antisymmetric"), Some("symmetric")]);
}

/// A tripod of three massless bars with a lump on top: legs at azimuth 0°, 120°, 240° and elevation 60°. With k = EA/L
/// the stiffness is 3 k sin² along the axis and 3/2 k cos² across it, twice.
#[test]
fn tripod_of_bars() {
    let feet: String = (0..3)
        .map(|i| {
            let azimuth = TAU * f64::from(i) / 3.0;
            format!("  foot_{i}: [{:?}, {:?}, 0]\n", azimuth.cos(), azimuth.sin())
        })
        .collect();
    let text = format!(
        "retune: 1\nname: tripod\nactive_dofs: [ux, uy, uz]\nnodes:\n{feet}  top: [0, 0, {:?}]\nbars:\n  legs: {{pairs: [[foot_0, top], [foot_1, top], [foot_2, top]], properties: {{E: 70 GPa, A: 1 cm2}}}}\nmasses: {{lump: {{node: top, mass: 4 kg}}}}\nsupports: {{ground: {{nodes: [foot_0, foot_1, foot_2]}}}}\n",
        3f64.sqrt()
    );
    // Legs of 2 m: k = 3.5 MN/m; sin² = 3/4, cos² = 1/4.
    let k = 3.5e6;
    let (across, along) = ((1.5 * k * 0.25 / 4.0_f64).sqrt(), (3.0 * k * 0.75 / 4.0_f64).sqrt());
    assert_close(&omegas(&text, 3), &[across, across, along], 1e-12);
}

/// The same space frame in global axes and in a frame that is moved and turned: nothing changes but rounding.
#[test]
fn a_turned_frame_changes_nothing() {
    let frame = "{origin: [1 m, -2 m, 0.5 m], rotate: {x: 20 deg, y: -50 deg, z: 130 deg}}";
    let text = |turned: bool| {
        let node = |name: &str, p: &str| {
            if turned { format!("  {name}: {{frame: turned, at: {p}}}\n") } else { format!("  {name}: {p}\n") }
        };
        let [mass_frame, spring_frame] = if turned { [", frame: turned"; 2] } else { [""; 2] };
        format!(
            "retune: 1\nname: space frame\nframes:\n  turned: {frame}\nnodes:\n{}{}{}{}sections:\n  tube: {{E: 70 GPa, G: 26 GPa, density: 2700 kg/m3, shape: {{tube: {{diameter: 30 mm, wall: 2 mm}}}}}}\nbeams:\n  frame: {{chain: [a, b, c, d], section: tube, subdivide: 3}}\nmasses:\n  lump: {{node: d, mass: 1 kg, inertia: {{xx: 2 g m2, yy: 3 g m2, zz: 4 g m2, xy: 0.5 g m2}}, offset: [10 mm, 20 mm, 30 mm]{mass_frame}}}\nsprings:\n  post: {{node: a, k: {{ux: 1 kN/m, uy: 2 kN/m, uz: 3 kN/m, rx: 400 N m/rad, ry: 500 N m/rad, rz: 600 N m/rad}}{spring_frame}}}\n",
            node("a", "[0, 0, 0]"),
            node("b", "[0, 0, 1 m]"),
            node("c", "[1 m, 0, 1 m]"),
            node("d", "[1 m, 1 m, 1 m]"),
        )
    };
    let (here, there) = (omegas(&text(false), 10), omegas(&text(true), 10));
    // Rounding of K, ε times the largest ω² (1e5)² over the lowest (10)².
    assert_close(&there, &here, 1e-7);
}

/// Massless rotations are condensed exactly: the same frequencies as explicit static condensation of K to the dofs with
/// mass. R. J. Guyan, AIAA Journal 3 (1965) 380.
#[test]
fn massless_dofs_are_condensed_as_by_guyan() {
    let lumps: String = (1..4).map(|i| format!("  m{i}: {{node: n{i}, mass: {} kg}}\n", 0.5 * f64::from(i))).collect();
    let model = build(&format!(
        "retune: 1\nname: lumps on a massless beam\nactive_dofs: [uz, ry]\nnodes: {{n0: [0, 0, 0], n1: [0.3, 0, 0], n2: [0.7, 0, 0], n3: [1.2, 0, 0]}}\nbeams: {{beam: {{chain: [n0, n1, n2, n3], properties: {{EIy: 20 N m2}}}}}}\nmasses:\n{lumps}supports: {{clamp: {{node: n0}}}}\n"
    ));
    let (system, modes) = solved(&model, 6);
    assert_eq!(modes.len(), 3, "three masses, three modes");
    let heavy: Vec<usize> = (0..model.dof_map().n_dof()).filter(|&i| system.mass[(i, i)] > 0.0).collect();
    let reduced = guyan(&system.stiffness, &system.mass, &selection(model.dof_map().n_dof(), &heavy).unwrap()).unwrap();
    let root: Vec<f64> = (0..3).map(|i| reduced.mass[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(3, 3, |i, j| reduced.stiffness[(i, j)] / (root[i] * root[j]));
    let mut exact: Vec<f64> = scaled.symmetric_eigenvalues().iter().map(|l| l.sqrt()).collect();
    exact.sort_by(f64::total_cmp);
    assert_close(&modes.lambda.iter().map(|l| l.sqrt()).collect::<Vec<_>>(), &exact, 1e-10);
}

/// A chain of `n` masses between two walls; `more` goes into every spring.
fn chain(n: usize, more: &str) -> String {
    let nodes: String = (1..=n).map(|i| format!("  n{i}: [{i} m, 0, 0]\n")).collect();
    let masses: String = (1..=n).map(|i| format!("  m{i}: {{node: n{i}, mass: 2 kg}}\n")).collect();
    let springs: String = (1..n)
        .map(|i| {
            format!("  s{i}: {{nodes: [n{i}, n{}], k: {{axial: 800 N/m}}{}}}\n", i + 1, more.replace("ux", "axial"))
        })
        .chain([1, n].map(|i| format!("  wall_{i}: {{node: n{i}, k: {{ux: 800 N/m}}{more}}}\n")))
        .collect();
    format!("retune: 1\nname: chain\nactive_dofs: [ux]\nnodes:\n{nodes}masses:\n{masses}springs:\n{springs}")
}

/// ω_j = 2 √(k/m) sin(jπ/2(n+1)): Blevins, table 6-2.
#[test]
fn blevins_chain_between_walls() {
    let exact: Vec<f64> = (1..=7).map(|j| 40.0 * (f64::from(j) * PI / 16.0).sin()).collect();
    assert_close(&omegas(&chain(7, ""), 7), &exact, 1e-12);
}

/// Receptances by superposition of all modes equal (K - ω² M + i ω C)⁻¹, for modal damping and for dashpots whose C is
/// proportional to K, so that ζ = α ω/2.
#[test]
fn synthesis_equals_direct_inversion() {
    let alpha = 0.002;
    let dashpots = chain(5, ", c: {ux: 1.6 N s/m}");
    let cantilever = unit_beam(3, SLENDER, "supports: {clamp: {node: a}}\n");
    for text in [dashpots, cantilever] {
        let (System { stiffness: k, mass: m, damping }, modes) = solved(&build(&text), 99);
        let n = k.nrows();
        assert_eq!(modes.len(), n);
        let omega: Vec<f64> = modes.lambda.iter().map(|l| l.sqrt()).collect();
        let ratios: Vec<f64> = match damping {
            Some(_) => omega.iter().map(|w| 0.5 * alpha * w).collect(),
            None => (0..n).map(|j| 0.01 + 0.002 * j as f64).collect(),
        };
        let c = damping.unwrap_or_else(|| {
            let diagonal = DMatrix::from_fn(n, n, |i, j| if i == j { 2.0 * ratios[i] * omega[i] } else { 0.0 });
            &m * &modes.shapes * diagonal * modes.shapes.transpose() * &m
        });
        let lines: Vec<f64> = [0.1, 0.9, 1.0, 1.3, 4.0].iter().map(|x| x * omega[0] / TAU).collect();
        let rows = DMatrix::identity(n, n);
        let h = synthesize(&modes, &ModalDamping { ratios }, &rows, &rows, &lines, 0);
        for (line, f) in lines.iter().enumerate() {
            let w = TAU * f;
            let dynamic = DMatrix::from_fn(n, n, |i, j| Complex::new(k[(i, j)] - w * w * m[(i, j)], w * c[(i, j)]));
            let inverse = dynamic.try_inverse().unwrap();
            let size = inverse.iter().map(|v| v.norm()).fold(0.0, f64::max);
            for s in 0..n {
                for r in 0..n {
                    let error = (h[(line * n + s) * n + r] - inverse[(r, s)]).norm();
                    assert!(error < 1e-9 * size, "line {line}, {r} {s}: {error:e} of {size:e}");
                }
            }
        }
    }
}

/// Heave, pitch, roll, surge, sway and yaw of a rigid body on corner springs, and its mass properties.
#[test]
fn suspended_rigid_body() {
    let model = build(&file("suspended_body"));
    let (_, modes) = solved(&model, 6);
    assert_eq!((modes.n_rigid, modes.len()), (0, 6));
    let (a2, b2) = (0.16, 0.09);
    let mut exact = [
        4.0 * 200.0 / 12.0,
        4.0 * 300.0 / 12.0,
        4.0 * 1000.0 / 12.0,
        4.0 * 1000.0 * b2 / 0.3,
        4.0 * 1000.0 * a2 / 0.5,
        4.0 * (200.0 * b2 + 300.0 * a2) / 0.7,
    ];
    exact.sort_by(f64::total_cmp);
    assert_close(modes.lambda.as_slice(), &exact, 1e-12);
    let mass = model.mass_properties(&[]).unwrap().unwrap();
    assert_eq!((mass.mass, mass.cg), (12.0, [1.0, 2.0, 0.5]));
}

/// A beam that hangs on a ball joint turns about two axes, however stiff it is along its own: rounding of that stiffness is no
/// support. Blevins, table 8-1: tan β = tanh β.
#[test]
fn a_beam_on_a_ball_joint_turns_about_two_axes() {
    let beta = root(|x: f64| x.tan() - x.tanh(), 3.5, 4.2);
    assert_close(&[beta], &[3.92660231], 1e-8);
    let blade = |ea: &str, eiz: f64, gj: f64| {
        build(&format!(
            "retune: 1\nname: blade\nnodes: {{n0: [0, 0, 0], n1: [0.2, 0, 0], n2: [0.3, 0, 0], n3: [0.55, 0, 0], n4: [0.7, 0, 0], n5: [0.8, 0, 0], n6: [1, 0, 0]}}\nbeams:\n  b: {{chain: [n0, n1, n2, n3, n4, n5, n6], properties: {{EIy: 10 N m2, EIz: {eiz} N m2, GJ: {gj} N m2, EA: {ea}, mass_per_length: 2 kg/m, polar_inertia_per_length: 0.003 kg m}}}}\nsupports: {{a: {{node: n0, fixed: [ux, uy, uz, rx]}}}}\n"
        ))
    };
    for ea in ["1 N", "1 MN", "1e12 N"] {
        for eiz in [10.0, 20.0, 1e5] {
            for gj in [6.0, 3e5] {
                let (_, modes) = solved(&blade(ea, eiz, gj), 20);
                assert_eq!((modes.n_rigid, modes.n_mechanism), (2, 0), "EA = {ea}, EIz = {eiz}, GJ = {gj}");
                let expected = 5.0_f64.sqrt() * beta * beta;
                let nearest = modes.lambda.iter().map(|l| (l.sqrt() / expected - 1.0).abs()).fold(1.0, f64::min);
                assert!(nearest < 1e-3, "EA = {ea}: {nearest:e}");
            }
        }
    }
}

/// A free beam across the plane of symmetry: its modes alternate, and its names come from the shapes.
#[test]
fn modes_of_a_free_beam_are_named() {
    let model = build(
        "retune: 1\nname: free wing\nactive_dofs: [uz, rx, ry]\nsymmetry: {normal: y}\nnodes: {left: [0, -1, 0], centre: [0, 0, 0], right: [0, 1, 0]}\nbeams: {wing: {chain: [left, centre, right], subdivide: 12, properties: {EIy: 10 N m2, GJ: 30 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 0.1 kg m}}}\n",
    );
    let (_, modes) = solved(&model, 5);
    assert_eq!(modes.n_rigid, 3);
    let names = name_modes(&model, &[], &modes).unwrap();
    let elastic: Vec<(&str, f64)> = names.iter().skip(3).map(|n| (n.label.as_str(), TAU * n.frequency_hz)).collect();
    let words: Vec<&str> = elastic.iter().map(|e| e.0).collect();
    // Bending β² √(EI/μ)/L² with β = 4.730, 7.853 on 2 m: 17.7, 48.8 rad/s; torsion jπ/L √(GJ/I): 27.2, 54.4, 81.6.
    assert_eq!(
        words,
        ["Sym 1st Bending", "Anti 1st Torsion", "Anti 1st Bending", "Sym 1st Torsion", "Anti 2nd Torsion"]
    );
    let bending = |b: f64| b * b * 10f64.sqrt() / 4.0;
    let torsion = |j: f64| j * PI / 2.0 * 300f64.sqrt();
    let exact = [bending(4.730040745), torsion(1.0), bending(7.853204624), torsion(2.0), torsion(3.0)];
    // Torsion converges with the square: (jπ/24)²/24.
    assert_close(&elastic.iter().map(|e| e.1).collect::<Vec<_>>(), &exact, 7e-3);
}
