//! Superelements: matrices in files are the structure that they were made from, wherever they stand and whatever they are joined to.

use retune::data::{Place, TestData};
use retune::effect::{Context, Effects, conformance};
use retune::matrices::{MatrixFormat, write};
use retune::modal::SolveOptions;
use retune::model::{
    ExportReduction, MatrixExport, Model, ModelSpec, ParametricModel, Registry, export_matrices, load, load_in,
    solve_modes,
};
use retune::update::{TwinOptions, node_sensors, twin_modes};
use retune::yaml::{self, Problem};
use retune_diagnosis::{Settings, Verdict, diagnose};
use std::collections::BTreeMap;
use std::io;

/// Files by name, as they would stand beside the model file.
type Files = BTreeMap<String, Vec<u8>>;

fn try_with(text: &str, files: &Files) -> Result<(Model, Vec<Problem>), Vec<Problem>> {
    let mut read = |name: &str| files.get(name).cloned().ok_or_else(|| io::Error::from(io::ErrorKind::NotFound));
    load_in(text, None, &Registry::builtin(), &mut read).map(|(model, warnings, _)| (model, warnings))
}

fn with(text: &str, files: &Files) -> Model {
    match try_with(text, files) {
        Ok((model, _)) => model,
        Err(problems) => panic!("{}", problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")),
    }
}

fn plain(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0])).0
}

fn elastic(model: &Model, theta: &[f64], n: usize) -> Vec<f64> {
    let modes = solve_modes(model, theta, SolveOptions { n_elastic: n, shift: None }).unwrap();
    modes.elastic().take(n).map(|i| modes.frequency_hz(i)).collect()
}

fn assert_same(found: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f / e - 1.0).abs() < relative, "mode {}: {f} for {e}, off by {:.1e}", i + 1, (f / e - 1.0).abs());
    }
}

fn files_of(export: &MatrixExport, stem: &str, format: MatrixFormat) -> Files {
    let mut files: Files = write(stem, &export.matrices, &export.dofs, format).unwrap().into_iter().collect();
    if let Some(r) = &export.recovery {
        let own = write(&format!("{stem}_r"), std::slice::from_ref(r), &export.recovered, MatrixFormat::MatrixMarket);
        files.extend(own.unwrap());
    }
    files
}

fn exported(model: &Model, stem: &str) -> Files {
    let export = export_matrices(model, &model.parameters().nominal(), None).unwrap();
    files_of(&export, stem, MatrixFormat::MatrixMarket)
}

/// The entry of [`exported`] files.
fn entry(stem: &str) -> String {
    format!("k: {stem}_K.mtx, m: {stem}_M.mtx, dofs: {stem}_dofs.csv")
}

/// Part of a model file: some of its beams and what hangs on them.
fn part(text: &str, keep: impl Fn(&str) -> bool) -> ModelSpec {
    let (mut spec, _) = yaml::read::<ModelSpec>(text).unwrap();
    spec.beams.retain(|name, _| keep(name));
    spec.groups.clear();
    spec
}

const GARTEUR: &str = include_str!("../models/garteur.yaml");

/// The right half of the aeroplane as matrices, the left half and the body as beams.
fn halves() -> (Model, Model) {
    let mut right = part(GARTEUR, |name| name.starts_with("right"));
    right.rigid_links.clear();
    right.masses.clear();
    let right = Model::new(right, &Registry::builtin()).unwrap().0;
    let files = exported(&right, "right");
    let rest = yaml::write(&part(GARTEUR, |name| !name.starts_with("right")));
    let text = format!("{rest}superelements:\n  right: {{{}, attach_within: 1 mm}}\n", entry("right"));
    (with(&text, &files), plain(GARTEUR))
}

#[test]
fn half_an_aeroplane_of_matrices_is_the_whole() {
    let (joined, whole) = halves();
    let theta = whole.parameters().nominal();
    assert_eq!(joined.dof_map().n_dof(), whole.dof_map().n_dof());
    let (found, expected) = (elastic(&joined, &theta, 20), elastic(&whole, &theta, 20));
    assert_same(&found, &expected, 1e-10);
    let masses = [&joined, &whole].map(|m| m.mass_properties(&theta).unwrap().unwrap());
    assert!((masses[0].mass - masses[1].mass).abs() < 1e-12 * masses[1].mass);
    assert!((masses[0].inertia[0][0] - masses[1].inertia[0][0]).abs() < 1e-11 * masses[1].inertia[0][0]);
    let soundness = retune::model::lint(&joined).unwrap();
    assert_eq!((soundness.n_rigid_body_modes, soundness.n_mechanisms, soundness.errors.len()), (6, 0, 0));
}

#[test]
fn a_model_of_matrices_alone_is_the_model() {
    let whole = plain(GARTEUR);
    let theta = whole.parameters().nominal();
    let export = export_matrices(&whole, &theta, None).unwrap();
    let expected = elastic(&whole, &theta, 16);
    for (format, entry, tolerance) in [
        (MatrixFormat::MatrixMarket, "k: g_K.mtx, m: g_M.mtx, dofs: g_dofs.csv", 1e-11),
        (MatrixFormat::Npz, "k: g_K.npz, m: g_M.npz, dofs: g_dofs.csv", 1e-11),
        (MatrixFormat::Output4, "k: {file: g.op4, matrix: K}, m: {file: g.op4, matrix: M}, dofs: g_dofs.csv", 1e-11),
        (
            MatrixFormat::Output4Binary,
            "k: {file: g.op4, matrix: K}, m: {file: g.op4, matrix: M}, dofs: g_dofs.csv",
            1e-11,
        ),
        // Ten digits of entries that cancel in rigid motions.
        (MatrixFormat::Dmig, "k: {file: g.pch, matrix: K}, m: {file: g.pch, matrix: M}, free: true", 2e-5),
    ] {
        let files = files_of(&export, "g", format);
        let text = format!("retune: 1\nname: matrices\nsuperelements:\n  g: {{{entry}}}\n");
        let model = with(&text, &files);
        assert_same(&elastic(&model, &[], 16), &expected, tolerance);
        assert_eq!(retune::model::lint(&model).unwrap().n_rigid_body_modes, 6, "{format:?}");
        // Nodes that follow from others come back by their matrix.
        let text = text.replace("}\n", ", recovery: {matrix: g_r_R.mtx, dofs: g_r_dofs.csv}}\n");
        if format == MatrixFormat::MatrixMarket {
            let model = with(&text, &files);
            let modes = solve_modes(&model, &[], SolveOptions { n_elastic: 6, shift: None }).unwrap();
            let at = |name: &str| model.dof_map().node(name).unwrap();
            let lateral = modes.elastic().map(|i| {
                let shape = model.dof_map().expand(&modes.shapes.column(i).into_owned());
                // The root of the fin follows the tail, 75 mm below it.
                let (root, tail) = (shape.row(at("g.fin_root")), shape.row(at("g.tail")));
                assert!((root[1] - (tail[1] - 0.075 * tail[3])).abs() < 1e-12);
                root[1].abs()
            });
            assert!(lateral.fold(0.0, f64::max) > 0.01);
        }
    }
}

#[test]
fn what_is_written_is_read_and_written_to_the_same_bytes() {
    let whole = plain(GARTEUR);
    let export = export_matrices(&whole, &whole.parameters().nominal(), None).unwrap();
    for format in [
        MatrixFormat::MatrixMarket,
        MatrixFormat::Npz,
        MatrixFormat::Output4,
        MatrixFormat::Output4Binary,
        MatrixFormat::Dmig,
    ] {
        let first = files_of(&export, "g", format);
        let mut again = export.clone();
        let read: Vec<_> = first.iter().map(|(name, bytes)| retune::matrices::read(name, bytes).unwrap()).collect();
        for matrix in &mut again.matrices {
            let found = read.iter().flat_map(|c| &c.matrices).find(|m| {
                m.name.trim_start_matches("g_") == matrix.name
                    && m.n_rows == matrix.n_rows
                    && m.n_columns == matrix.n_columns
            });
            let symmetric = found.unwrap().symmetric(false).unwrap();
            let labels = if found.unwrap().rows.is_empty() { matrix.rows.clone() } else { found.unwrap().rows.clone() };
            if format == MatrixFormat::Dmig {
                let key = |m: &retune::matrices::Matrix, i: u32| m.rows[i as usize].clone();
                assert_eq!(symmetric.lower.len(), matrix.entries.len());
                assert!(key(found.unwrap(), 0).dof.is_some());
            } else {
                assert_eq!(symmetric.lower, matrix.entries, "{format:?}");
            }
            *matrix = symmetric.matrix(&matrix.name, labels);
        }
        if format != MatrixFormat::Dmig {
            assert_eq!(files_of(&again, "g", format), first, "{format:?}");
        }
    }
}

/// A bent arm of tubes with a mass at its end, from the origin; `turned` is where its points stand.
fn arm(turned: impl Fn([f64; 3]) -> [f64; 3], prefix: &str) -> (String, String, String) {
    let nodes = [("a", [0.0, 0.0, 0.0]), ("b", [0.4, 0.1, 0.0]), ("c", [0.6, 0.3, 0.25]), ("d", [0.5, 0.7, 0.3])];
    let text = nodes.map(|(name, p)| {
        let [x, y, z] = turned(p);
        format!("  {prefix}{name}: [{x:?}, {y:?}, {z:?}]\n")
    });
    let orientation = |v: [f64; 3]| {
        let (origin, end) = (turned([0.0; 3]), turned(v));
        let [x, y, z] = std::array::from_fn(|i| end[i] - origin[i]);
        format!("[{x:?}, {y:?}, {z:?}]")
    };
    let beams = format!(
        "  {prefix}ab: {{nodes: [{prefix}a, {prefix}b], section: tube, orientation: {o}}}\n  {prefix}bc: {{nodes: [{prefix}b, {prefix}c], section: tube, orientation: {o}}}\n  {prefix}cd: {{nodes: [{prefix}c, {prefix}d], section: tube, orientation: {o}}}\n",
        o = orientation([0.1, 0.2, 1.0])
    );
    let masses = format!("  {prefix}m: {{node: {prefix}d, mass: 0.3 kg}}\n");
    (text.concat(), beams, masses)
}

const TUBE: &str =
    "sections:\n  tube: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {tube: {diameter: 30 mm, wall: 2 mm}}}\n";

/// One arm exported once and placed four times, turned and mirrored, on a hub: as if it had been built four times.
#[test]
fn one_superelement_stands_in_many_places() {
    let (nodes, beams, masses) = arm(|p| p, "");
    let text = format!("retune: 1\nname: arm\n{TUBE}nodes:\n{nodes}beams:\n{beams}masses:\n{masses}");
    let files = exported(&plain(&text), "arm");
    let angle = |degrees: f64| degrees.to_radians().sin_cos();
    let ((s, c), (t, d)) = (angle(40.0), angle(25.0));
    let turn = |[x, y, z]: [f64; 3]| {
        // About x by 25 degrees, then about z by 40.
        let (y, z) = (d * y - t * z, t * y + d * z);
        [c * x - s * y, s * x + c * y, z]
    };
    let moved = |[x, y, z]: [f64; 3]| [x + 0.2, y - 0.1, z + 0.05];
    let mirrored = |axis: usize, mut p: [f64; 3]| {
        p[axis] = -p[axis];
        p
    };
    let mut whole = [String::new(), String::new(), String::new()];
    for (prefix, turned) in [
        ("p_", Box::new(|p| p) as Box<dyn Fn([f64; 3]) -> [f64; 3]>),
        ("q_", Box::new(move |p| mirrored(0, p))),
        ("r_", Box::new(move |p| moved(turn(p)))),
        ("s_", Box::new(move |p| moved(turn(mirrored(1, p))))),
    ] {
        let (nodes, beams, masses) = arm(turned, prefix);
        whole = [whole[0].clone() + &nodes, whole[1].clone() + &beams, whole[2].clone() + &masses];
    }
    let rest = "nodes:\n  hub: [0, 0, 0]\n  tip: [0.2, -0.1, 0.05]\n";
    let middle = "beams:\n  middle: {nodes: [hub, tip], section: tube}\n";
    let links =
        "rigid_links:\n  at_hub: {master: hub, slaves: [p_a, q_a]}\n  at_tip: {master: tip, slaves: [r_a, s_a]}\n";
    let frames = "frames:\n  f: {origin: [0.2, -0.1, 0.05], rotate: {x: 25 deg, z: 40 deg}}\n";
    let beams_text = format!(
        "retune: 1\nname: arms\n{frames}{TUBE}{rest}{}{middle}{}{links}masses:\n{}",
        whole[0], whole[1], whole[2]
    );
    let e = entry("arm");
    let matrices_text = format!(
        "retune: 1\nname: arms\n{frames}{TUBE}{rest}{middle}superelements:\n  p: {{{e}, attach: {{hub: a}}}}\n  q: {{{e}, mirror: x, attach: {{hub: a}}}}\n  r: {{{e}, frame: f, attach: {{tip: a}}}}\n  s: {{{e}, frame: f, mirror: y, attach_within: 0.1 mm}}\n"
    );
    let (joined, built) = (with(&matrices_text, &files), plain(&beams_text));
    assert_same(&elastic(&joined, &[], 18), &elastic(&built, &[], 18), 1e-9);
    let masses = [&joined, &built].map(|m| m.mass_properties(&[]).unwrap().unwrap());
    for axis in 0..3 {
        assert!((masses[0].cg[axis] - masses[1].cg[axis]).abs() < 1e-12, "{masses:?}");
        for other in 0..3 {
            assert!((masses[0].inertia[axis][other] - masses[1].inertia[axis][other]).abs() < 1e-10, "{masses:?}");
        }
    }
    assert!(joined.geometry().node("s.d").is_some() && joined.geometry().node("s.a").is_none());
}

/// A planform grid has one displacement and two rotations a node; turned into no global direction it still has.
#[test]
fn dofs_that_are_missing_do_not_move_where_a_superelement_is_turned() {
    let text = "retune: 1\nname: g\nactive_dofs: [uz, rx, ry]\nnodes: {a: [0, 0, 0], b: [0.5, 0, 0], c: [0.5, 0.4, 0]}\n\
                beams: {ab: {nodes: [a, b], properties: {EIy: 100, GJ: 80, mass_per_length: 1}, subdivide: 3}, bc: {nodes: [b, c], properties: {EIy: 60, GJ: 50, mass_per_length: 0.7}}}\n";
    let plane = plain(text);
    let files = exported(&plane, "g");
    let turned = format!(
        "retune: 1\nname: t\nframes: {{f: {{rotate: {{x: 33 deg, y: 20 deg}}}}}}\nsuperelements: {{g: {{{}, frame: f}}}}\n",
        entry("g")
    );
    let turned = with(&turned, &files);
    assert_eq!(turned.dof_map().n_dof(), plane.dof_map().n_dof());
    assert_same(&elastic(&turned, &[], 6), &elastic(&plane, &[], 6), 1e-9);
}

/// A strip whose thickness acts in the third power on its stiffness and in the first on its mass.
fn strip(t: f64) -> Model {
    let ei = 5.0 * (t / 2e-3).powi(3);
    let mu = 0.4 * (t / 2e-3);
    plain(&format!(
        "retune: 1\nname: strip\nactive_dofs: [uz, ry]\nnodes: {{a: [0, 0, 0], b: [0.5, 0, 0]}}\nbeams: {{ab: {{nodes: [a, b], properties: {{EIy: {ei:?}, mass_per_length: {mu:?}}}, subdivide: 6}}}}\n"
    ))
}

fn strips() -> Files {
    let mut files = Files::new();
    for t in [2, 3, 4] {
        files.extend(exported(&strip(f64::from(t) * 1e-3), &format!("t{t}")));
    }
    files
}

const STRIP: &str = "
retune: 1
name: strip of matrices
parameters: {t: {value: 2.7 mm, bounds: [1 mm, 5 mm]}, E_rel: {value: 1.1, bounds: [0.5, 2]}}
nodes: {root: [0, 0, 0]}
superelements:
  s:
    k: t2_K.mtx
    m: t2_M.mtx
    dofs: t2_dofs.csv
    attach: {root: a}
    terms:
      bending: {parameter: t, at: 2 mm, power: 3, exports: [{at: 3 mm, k: t3_K.mtx}, {at: 4 mm, k: t4_K.mtx}]}
      mass: {parameter: t, at: 2 mm, exports: [{at: 3 mm, m: t3_M.mtx}]}
supports: {clamp: {node: root}}
";

#[test]
fn two_exports_give_the_matrices_of_a_third_and_exact_derivatives() {
    let files = strips();
    let (model, warnings) = try_with(STRIP, &files).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    for t in [1.3e-3, 2e-3, 2.7e-3, 4.4e-3] {
        let direct = strip(t);
        let clamped = plain(&format!("{}supports: {{c: {{node: a}}}}\n", yaml::write(direct.spec())));
        assert_same(&elastic(&model, &[t, 1.1], 4), &elastic(&clamped, &[], 4), 1e-9);
    }
    let theta = [2.7e-3, 1.1];
    let slope = model.assemble_derivative(&theta, 0).unwrap();
    let at = |t: f64| model.assemble(&[t, 1.1]).unwrap();
    // A cubic by five points is exact up to rounding.
    let h = 1e-4;
    let of = |k: fn(&retune::model::System) -> &retune::linalg::DMatrix<f64>| {
        (k(&at(theta[0] - 2.0 * h)) - k(&at(theta[0] + 2.0 * h)) + (k(&at(theta[0] + h)) - k(&at(theta[0] - h))) * 8.0)
            / (12.0 * h)
    };
    let (k, m) = (of(|s| &s.stiffness), of(|s| &s.mass));
    assert!((&slope.stiffness - &k).amax() < 1e-10 * k.amax());
    assert!((&slope.mass - &m).amax() < 1e-10 * m.amax());
    // With the wrong power the third export says how far it is off.
    let (_, warnings) = try_with(&STRIP.replace("power: 3", "power: 1"), &files).unwrap();
    assert!(
        warnings.iter().any(|w| w.message.contains("do not go with the power 1") && w.message.contains('%')),
        "{warnings:?}"
    );
}

/// Two powers in one term: a plate of membrane and bending. Two strips, of which one is stiff in proportion to its thickness.
#[test]
fn exports_tell_several_powers_apart() {
    let mixed = |t: f64| {
        let (ei, gj, mu) = (5.0 * (t / 2e-3).powi(3), 3.0 * (t / 2e-3), 0.4 * (t / 2e-3));
        plain(&format!(
            "retune: 1\nname: strip\nactive_dofs: [uz, rx, ry]\nnodes: {{a: [0, 0, 0], b: [0.5, 0, 0]}}\nbeams: {{ab: {{nodes: [a, b], properties: {{EIy: {ei:?}, GJ: {gj:?}, mass_per_length: {mu:?}, polar_inertia_per_length: 1e-4}}, subdivide: 6}}}}\n"
        ))
    };
    let mut files = Files::new();
    for t in [2, 3, 4, 5] {
        files.extend(exported(&mixed(f64::from(t) * 1e-3), &format!("t{t}")));
    }
    let one = |t: u32| format!("{{at: {t} mm, k: t{t}_K.mtx, m: t{t}_M.mtx}}");
    let text = STRIP.replace(
        "bending: {parameter: t, at: 2 mm, power: 3, exports: [{at: 3 mm, k: t3_K.mtx}, {at: 4 mm, k: t4_K.mtx}]}\n      mass: {parameter: t, at: 2 mm, exports: [{at: 3 mm, m: t3_M.mtx}]}",
        &format!("t: {{powers: [1, 3], at: 2 mm, exports: [{}, {}, {}]}}\n    checks: [{{at: {{t: 5 mm}}, k: t5_K.mtx}}]", one(3), one(4), one(5)),
    );
    let (model, warnings) = try_with(&text, &files).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    for t in [1.3e-3, 2.7e-3, 4.4e-3] {
        let clamped = plain(&format!("{}supports: {{c: {{node: a}}}}\n", yaml::write(mixed(t).spec())));
        assert_same(&elastic(&model, &[t, 1.1], 6), &elastic(&clamped, &[], 6), 1e-9);
    }
    // Without the first power the third export and the check say that something is left.
    let (_, warnings) = try_with(&text.replace("powers: [1, 3]", "power: 3"), &files).unwrap();
    for told in ["do not go with the power 3 of `t`", "the terms do not add up"] {
        assert!(warnings.iter().any(|w| w.message.contains(told)), "{told}: {warnings:?}");
    }
    for (wrong, told) in [
        ("power: 1, powers: [1, 3]", "`power` and `powers` say the same"),
        ("powers: [1, 2, 3, 4]", "4 powers need 4 exports at other values, and 3 are given"),
        ("powers: [3, 3]", "a power stands here twice"),
        ("powers: [1, 7]", "a power must be 1 to 6"),
    ] {
        let problems = try_with(&text.replace("powers: [1, 3]", wrong), &files).unwrap_err();
        assert!(problems.iter().any(|p| p.message.contains(told)), "{wrong}: {problems:?}");
    }
}

/// A part given alone, included in the whole or not, and changed by an override.
#[test]
fn a_term_scales_with_its_parameter_and_with_overrides() {
    let files = strips();
    let base = "retune: 1\nname: s\nparameters: {E_rel: {value: 1.1, bounds: [0.5, 2]}}\nsuperelements:\n  s: {k: t2_K.mtx, m: t2_M.mtx, dofs: t2_dofs.csv, terms: {E_rel: TERM}}\n";
    let plain_k = strip(2e-3).assemble(&[]).unwrap().stiffness;
    let k = |term: &str, more: &str, theta: f64| {
        with(&(base.replace("TERM", term) + more), &files).assemble(&[theta]).unwrap()
    };
    let scaled = |system: &retune::model::System| system.stiffness[(0, 0)] / plain_k[(0, 0)];
    assert!((scaled(&k("{k: t2_K.mtx}", "", 0.7)) - 1.7).abs() < 1e-14);
    assert!((scaled(&k("{k: t2_K.mtx, at: 2}", "", 0.7)) - 1.35).abs() < 1e-14);
    assert!((scaled(&k("{k: t2_K.mtx, at: 1, included: true}", "", 0.7)) - 0.7).abs() < 1e-14);
    assert!((scaled(&k("{k: t2_K.mtx, at: 1, power: 2, included: true}", "", 0.7)) - 0.49).abs() < 1e-14);
    let changed = "overrides: {s.E_rel: {stiffness: 1.5}, soft: {of: [s], stiffness_damping: 1 ms}}\n";
    let system = k("{k: t2_K.mtx, at: 1, included: true}", changed, 0.7);
    assert!((scaled(&system) - 1.5 * 0.7).abs() < 1e-14);
    let damping = system.damping.unwrap();
    assert!((damping - system.stiffness * 1e-3).amax() < 1e-12 * plain_k.amax());
}

#[test]
fn units_of_files_are_what_the_entry_says() {
    let model = plain(GARTEUR);
    let theta = model.parameters().nominal();
    let export = export_matrices(&model, &theta, None).unwrap();
    let mut scaled = export.clone();
    // From m, N, kg to mm, N, t.
    for matrix in &mut scaled.matrices {
        for e in &mut matrix.entries {
            let by = |i: u32| if export.dofs[i as usize].label.dof.unwrap().is_rotation() { 1.0 } else { 1e-3 };
            // N m is 1e3 N mm, and kg m² is 1e3 t mm².
            e.value *= 1e3 * by(e.row) * by(e.column);
        }
    }
    for row in &mut scaled.dofs {
        row.position = row.position.map(|p| p.map(|c| 1e3 * c));
    }
    scaled.recovery = None;
    let files = files_of(&scaled, "g", MatrixFormat::MatrixMarket);
    let text =
        format!("retune: 1\nname: mm\nsuperelements: {{g: {{{}, units: {{length: mm, force: N}}}}}}\n", entry("g"));
    let in_mm = with(&text, &files);
    assert_same(&elastic(&in_mm, &[], 12), &elastic(&model, &theta, 12), 1e-9);
    let masses = [&in_mm, &model].map(|m| m.mass_properties(&m.parameters().nominal()).unwrap().unwrap().mass);
    assert!((masses[0] / masses[1] - 1.0).abs() < 1e-12, "{masses:?}");
}

/// Reduced to the joint with the body, with ten modes and the tips recovered.
#[test]
fn a_craig_bampton_wing_flies_on_the_body() {
    let mut right = part(GARTEUR, |name| name.starts_with("right_wing") || name == "right_drum");
    right.rigid_links.clear();
    right.masses.clear();
    let wing = Model::new(right, &Registry::builtin()).unwrap().0;
    let theta = wing.parameters().nominal();
    let root = wing.geometry().node("wing_root").unwrap();
    let export = export_matrices(&wing, &theta, Some((&[root], ExportReduction::CraigBampton(16)))).unwrap();
    assert_eq!(export.dofs.len(), 6 + 16);
    let files = files_of(&export, "w", MatrixFormat::Npz);
    let rest = yaml::write(&part(GARTEUR, |name| !name.starts_with("right_wing") && name != "right_drum"));
    let text = format!(
        "{rest}superelements:\n  w: {{k: w_K.npz, m: w_M.npz, dofs: w_dofs.csv, attach: {{wing_root: wing_root}}, recovery: {{matrix: w_r_R.mtx, dofs: w_r_dofs.csv}}}}\n"
    );
    let (reduced, whole) = (with(&text, &files), plain(GARTEUR));
    assert_same(&elastic(&reduced, &theta, 8), &elastic(&whole, &theta, 8), 2e-4);
    let options = SolveOptions { n_elastic: 2, shift: None };
    let [a, b] = [(&reduced, "w.r4"), (&whole, "r4")].map(|(model, tip)| {
        let modes = solve_modes(model, &theta, options).unwrap();
        assert_eq!(modes.n_rigid, 6);
        let shape = model.dof_map().expand(&modes.shapes.column(6).into_owned());
        let at = |name: &str| shape[(model.dof_map().node(name).unwrap(), 2)];
        at(tip) / at("l4")
    });
    assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    // Rigid motions are kept exactly.
    let masses = [&reduced, &whole].map(|m| m.mass_properties(&theta).unwrap().unwrap());
    assert!((masses[0].mass / masses[1].mass - 1.0).abs() < 1e-11);
    assert!((masses[0].inertia[2][2] / masses[1].inertia[2][2] - 1.0).abs() < 1e-11);
}

/// A support that gives below a superelement is the one below the beams that it was made from, and so are its derivatives.
#[test]
fn supports_give_below_matrices_as_below_beams() {
    let beams = "retune: 1\nname: b\nparameters: {c: {value: 2e-5 rad/(N m), bounds: [0 rad/(N m), 1e-3 rad/(N m)]}}\nnodes: {a: [0, 0, 0], b: [0.5, 0, 0.1]}\nbeams: {ab: {nodes: [a, b], properties: {E: 70e9, nu: 0.3, A: 1e-4, Iy: 1e-9, Iz: 2e-9, J: 1e-9, density: 2700}, subdivide: 4}}\n";
    let support = "supports: {s: {node: NODE, compliance: {ry: c, uz: 1e-6 m/N}}}\n";
    let built = plain(&(beams.to_string() + &support.replace("NODE", "a")));
    let files = exported(&plain(beams), "b");
    let head = beams.split("nodes:").next().unwrap();
    let text = format!("{head}superelements: {{b: {{{}}}}}\n{}", entry("b"), support.replace("NODE", "b.a"));
    let matrices = with(&text, &files);
    for c in [0.0, 2e-5, 9e-4] {
        assert_same(&elastic(&matrices, &[c], 6), &elastic(&built, &[c], 6), 1e-9);
        let slopes = [&matrices, &built].map(|m| m.assemble_derivative(&[c], 0).unwrap().stiffness);
        assert!((&slopes[0] - &slopes[1]).amax() < 1e-6 * slopes[1].amax(), "{c}");
    }
}

/// A preload that is half of the critical one lowers the first mode by √½, and twice of it buckles.
#[test]
fn an_exported_preload_softens_and_buckles() {
    // A pinned beam of EI = 1, length 1: the critical load is π².
    let beam = |load: f64| {
        plain(&format!(
            "retune: 1\nname: b\nactive_dofs: [uz, ry]\nnodes: {{a: [0, 0, 0], b: [1, 0, 0]}}\nbeams: {{ab: {{nodes: [a, b], properties: {{EIy: 1, mass_per_length: 1, axial_force: {load:?}}}, subdivide: 10}}}}\n"
        ))
    };
    let mut files = exported(&beam(0.0), "b");
    let critical = std::f64::consts::PI.powi(2);
    let (mut soft, stiff) =
        (export_matrices(&beam(-critical), &[], None).unwrap(), export_matrices(&beam(0.0), &[], None).unwrap());
    let loaded = soft.matrices[0].clone();
    soft.matrices[0]
        .entries
        .extend(stiff.matrices[0].entries.iter().map(|e| retune::matrices::Entry { value: -e.value, ..*e }));
    assert!(loaded.entries.len() > 10);
    files.extend(files_of(&soft, "p", MatrixFormat::MatrixMarket));
    let text = format!(
        "retune: 1\nname: p\nactive_dofs: [uz, ry]\nparameters: {{P: {{value: 0.5, bounds: [0, 3]}}}}\nsuperelements: {{b: {{{}, preload: {{k: p_K.mtx, factor: P}}}}}}\nsupports: {{ends: {{nodes: [b.a, b.b], fixed: [uz]}}}}\n",
        entry("b")
    );
    let model = with(&text, &files);
    let free = elastic(&model, &[0.0], 1)[0];
    assert!((elastic(&model, &[0.5], 1)[0] / free - 0.5_f64.sqrt()).abs() < 1e-4);
    let error = solve_modes(&model, &[2.0], SolveOptions { n_elastic: 1, shift: None }).unwrap_err();
    assert!(error.to_string().contains("buckles"), "{error}");
    let bears = model.critical_preload(&[2.0]).unwrap().unwrap().factor;
    assert!((bears - 0.5).abs() < 1e-3, "{bears}");
}

#[test]
fn what_does_not_fit_is_said_with_its_place() {
    let files = strips();
    let model = |entry: &str| format!("retune: 1\nname: s\nsuperelements:\n  s: {{{entry}}}\n");
    let said = |text: &str| {
        let problems = try_with(text, &files).unwrap_err();
        problems.iter().map(|p| format!("{}: {}", p.path, p.message)).collect::<Vec<_>>().join("\n")
    };
    for (entry, path, words) in [
        ("k: t9_K.mtx, dofs: t2_dofs.csv", "superelements.s.k", "cannot be read"),
        ("k: t2_dofs.csv, dofs: t2_dofs.csv", "superelements.s.k", "holds no matrix"),
        (
            "k: {file: t2_K.mtx, matrix: KK}, dofs: t2_dofs.csv",
            "superelements.s.k",
            "holds no matrix `KK`; it holds `t2_K`",
        ),
        ("k: t2_K.mtx", "superelements.s", "give the table of dofs"),
        ("m: t2_M.mtx, dofs: t2_K.mtx", "superelements.s.dofs", "holds no table of dofs"),
        ("dofs: t2_dofs.csv", "superelements.s", "needs a stiffness matrix"),
        ("k: t2_K.mtx, dofs: t2_dofs.csv, frame: f", "superelements.s.frame", "is not defined"),
        ("k: t2_K.mtx, dofs: t2_dofs.csv, units: {length: kg, force: N}", "superelements.s.units.length", "kg"),
        ("k: t2_K.mtx, dofs: t2_dofs.csv, units: {length: mm}", "superelements.s.units", "`force` or `mass`"),
        ("k: t2_K.mtx, dofs: t2_dofs.csv, terms: {E: {k: t2_K.mtx}}", "superelements.s.terms.E", "is not defined"),
        ("k: t2_K.mtx, dofs: t2_dofs.csv, attach: {hub: a}", "superelements.s.attach.hub", "is not defined"),
        ("k: t2_K.mtx, dofs: t2_dofs.csv, effect_nodes: [bb]", "superelements.s.effect_nodes[0]", "has no node `bb`"),
    ] {
        let text = said(&model(entry));
        assert!(text.contains(&format!("{path}: ")) && text.contains(words), "{entry}\n{text}");
    }
    // What is held is not made free.
    let pinned = "k: t2_K.mtx, m: t2_M.mtx, dofs: t2_dofs.csv, free: true";
    assert!(try_with(&model(pinned), &files).is_ok());
    let mut held = files.clone();
    let text = String::from_utf8(files["t2_K.mtx"].clone()).unwrap();
    let line = text.lines().find(|l| l.starts_with("1 1 ")).unwrap();
    held.insert(
        "t2_K.mtx".into(),
        text.replace(line, &format!("1 1 {:e}", 2.0 * line[4..].parse::<f64>().unwrap())).into_bytes(),
    );
    let problems = try_with(&model(pinned), &held).unwrap_err();
    assert!(problems[0].message.contains("it is held"), "{problems:?}");
    // Without a folder there are no files.
    let problems = load(&model("k: t2_K.mtx, dofs: t2_dofs.csv"), &Registry::builtin()).unwrap_err();
    assert!(problems[0].message.contains("no folder is known"), "{problems:?}");
}

/// A mast as matrices, with a boom of beams at the middle of it: every effect keeps its contract there.
fn mast() -> (String, Files) {
    let built = "retune: 1\nname: mast\nsections:\n  pole: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {tube: {diameter: 50 mm, wall: 3 mm}}}\nnodes: {m0: [0, 0, 0], m1: [0, 0, 0.5], m2: [0.05, 0, 1], m3: [0.1, 0, 1.5], m4: [0.15, 0, 2]}\nbeams: {mast: {chain: [m0, m1, m2, m3, m4], section: pole, orientation: [0, 1, 0]}}\n";
    let files = exported(&plain(built), "mast");
    let text = format!(
        "retune: 1\nname: mast with a boom\nsections:\n  pole: {{E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {{tube: {{diameter: 30 mm, wall: 2 mm}}}}}}\nnodes:\n  foot: [0, 0, 0]\n  joint: [0.1, 0, 1.5]\n  b1: [0.5, 0, 1.6]\n  b2: [0.9, 0.1, 1.7]\nbeams:\n  boom: {{chain: [joint, b1, b2], section: pole}}\nsuperelements:\n  mast: {{{}, attach: {{foot: m0, joint: m3}}}}\nsupports:\n  ground: {{node: foot}}\n",
        entry("mast")
    );
    (text, files)
}

/// A node of the table without a position, and rows that bear the name of others, are inner coordinates where the entry says so.
#[test]
fn inner_nodes_are_coordinates_where_the_entry_says_so() {
    let built = plain(
        "retune: 1\nname: bar\nsections: {s: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {rectangle: {width: 20 mm, height: 10 mm}}}}\nnodes: {a: [0, 0, 0], b: [0.3, 0, 0], c: [0.6, 0, 0]}\nbeams: {bar: {chain: [a, b, c], section: s}}\n",
    );
    let mut files = exported(&built, "bar");
    let clamped = plain(&format!("{}supports: {{clamp: {{node: a}}}}\n", yaml::write(built.spec())));
    let expected = elastic(&clamped, &[], 8);
    let table = String::from_utf8(files["bar_dofs.csv"].clone()).unwrap();
    let head = table.lines().next().unwrap();
    assert_eq!(head, "node,dof,x,y,z");
    // The node in the middle loses its place, and takes the numbers of the one at the tip.
    let named = |from: &str, to: &str| -> String {
        table
            .lines()
            .map(|l| {
                if l.starts_with(from) {
                    format!("{to}{},,,\n", &l[1..l.match_indices(',').nth(1).unwrap().0])
                } else {
                    format!("{l}\n")
                }
            })
            .collect()
    };
    let text = |more: &str| {
        format!(
            "retune: 1\nname: bar\nnodes: {{root: [0, 0, 0]}}\nsuperelements: {{s: {{k: bar_K.mtx, m: bar_M.mtx, dofs: bar_dofs.csv, attach: {{root: a}}{more}}}}}\nsupports: {{clamp: {{node: root}}}}\n"
        )
    };
    files.insert("bar_dofs.csv".into(), named("b,", "b").into_bytes());
    let problems = try_with(&text(""), &files).unwrap_err();
    assert!(problems[0].to_string().contains("node `b` has no position"), "{}", problems[0]);
    assert!(problems[0].to_string().contains("inner: true"), "{}", problems[0]);
    assert_same(&elastic(&with(&text(", inner: true"), &files), &[], 8), &expected, 1e-10);
    files.insert("bar_dofs.csv".into(), named("b,", "a").into_bytes());
    let problems = try_with(&text(""), &files).unwrap_err();
    assert!(problems[0].to_string().contains("twice"), "{}", problems[0]);
    assert_same(&elastic(&with(&text(", inner: true"), &files), &[], 8), &expected, 1e-10);
}

#[test]
fn effects_keep_their_contract_at_nodes_and_terms_of_superelements() {
    let (text, files) = mast();
    let model = with(&text, &files);
    let failures = conformance::check_on(&Effects::builtin(), &model, &text, &Registry::builtin(), &Context::default());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    let context = Context::default();
    let ids: Vec<String> = retune::effect::candidates(&model, &Effects::builtin(), &context)
        .iter()
        .map(retune::effect::Candidate::id)
        .collect();
    for wanted in [
        "point-mass@mast.m2",
        "ground-spring@mast.m4.ux",
        "sprung-mass@mast.m4.ux",
        "stiffness-change@mast",
        "mass-change@mast",
        "stiffness-damping@mast",
        "joint-flexibility@boom.1:joint.ry",
        "softening@whole",
    ] {
        assert!(ids.iter().any(|id| id == wanted), "{wanted} is not among {ids:?}");
    }
    let (text, files) = (STRIP.to_string(), strips());
    let model = with(&text, &files);
    let failures = conformance::check_on(&Effects::builtin(), &model, &text, &Registry::builtin(), &Context::default());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    let ids: Vec<String> = retune::effect::candidates(&model, &Effects::builtin(), &context)
        .iter()
        .map(retune::effect::Candidate::id)
        .collect();
    assert!(ids.iter().any(|id| id == "stiffness-change@s.bending"), "{ids:?}");
}

/// A synthetic test of a truth, with 0.3 % noise of frequencies and 2 % of shapes.
fn measured(truth: &Model, base: &Model) -> TestData {
    let sensors = node_sensors(base);
    let options = TwinOptions {
        n_modes: 8,
        damping: Some(0.0),
        frequency_noise: 0.003,
        shape_noise: 0.02,
        seed: 4,
        ..TwinOptions::default()
    };
    let mut test = twin_modes(truth, &truth.parameters().nominal(), &sensors, &options, "twin").unwrap();
    test.modes.iter_mut().for_each(|m| m.label = None);
    assert!(test.sensors.iter().any(|s| matches!(&s.place, Place::Node { node, .. } if node == "mast.m2")));
    test
}

#[test]
fn a_hidden_mass_a_joint_and_a_flipped_sensor_are_found_at_superelements() {
    let (text, files) = mast();
    let base = with(&text, &files);
    let hidden = format!("{text}masses:\n  hidden: {{node: mast.m2, mass: 250 g}}\n");
    let d = diagnose(&base, &measured(&with(&hidden, &files), &base), &Settings::default()).unwrap();
    assert_eq!(
        (d.verdict, d.hypotheses[0].id.as_str()),
        (Verdict::MissingEffect, "point-mass@mast.m2"),
        "{}",
        d.sentence
    );
    let loose = text.replace(
        "[joint, b1, b2], section: pole",
        "[joint, b1, b2], section: pole, properties: {end1_compliance_ry: 2e-4 rad/(N m)}",
    );
    let d = diagnose(&base, &measured(&with(&loose, &files), &base), &Settings::default()).unwrap();
    assert_eq!(d.verdict, Verdict::MissingEffect, "{}", d.sentence);
    assert!(d.hypotheses[0].id.starts_with("joint-flexibility@boom.1:joint"), "{}", d.sentence);
    let mut test = measured(&base, &base);
    let at = test.sensors.iter().position(|s| s.name == "mast.m2.ux").unwrap();
    for mode in &mut test.modes {
        let shape = mode.shape.as_mut().unwrap();
        shape[at] = -shape[at];
    }
    let d = diagnose(&base, &test, &Settings::default()).unwrap();
    assert_eq!(
        (d.verdict, d.hypotheses[0].id.as_str()),
        (Verdict::MeasurementFault, "sensor-sign@mast.m2.ux"),
        "{}",
        d.sentence
    );
}

/// A patch over a model keeps what its files hold.
#[test]
fn an_overlay_keeps_the_matrices() {
    let (text, files) = mast();
    let base = with(&text, &files);
    let patched = base.spec().overlaid("masses: {more: {node: mast.m1, mass: 1 kg}}").unwrap();
    let heavier = Model::new(patched, &Registry::builtin()).unwrap().0;
    let masses = [&heavier, &base].map(|m| m.mass_properties(&[]).unwrap().unwrap().mass);
    assert!((masses[0] - masses[1] - 1.0).abs() < 1e-12);
}

/// K and M of a published wing, in a file of MATLAB that holds the frequencies of its authors too.
#[test]
fn matrices_of_a_published_wing_have_the_frequencies_of_its_authors() {
    let beside = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let root = std::env::var_os("RETUNE_DATA").map_or(beside, std::path::PathBuf::from);
    let Ok(bytes) = std::fs::read(root.join("cruise_missile_wing/fe_beam/WingBeamforMAC.mat")) else {
        eprintln!("skipped: the wing is not there; set RETUNE_DATA to the folder of the real data");
        return;
    };
    let held = retune::arrays::mat::read(&bytes).unwrap();
    let (_, value) = held.variables.iter().find(|(name, _)| name == "fs").unwrap();
    let retune::arrays::mat::Value::Real { values, .. } = value else { panic!("{value:?}") };
    // What its 75 rows are is not in the file.
    let rows: Vec<String> = (1..=75).map(|i| format!("r{i},modal\n")).collect();
    let files = Files::from([
        ("wing.mat".to_string(), bytes),
        ("dofs.csv".to_string(), format!("node,dof\n{}", rows.concat()).into_bytes()),
    ]);
    let text = "retune: 1\nname: wing\nsuperelements: {w: {k: {file: wing.mat, matrix: Kr}, m: {file: wing.mat, matrix: Mr}, dofs: dofs.csv}}\n";
    let found = elastic(&with(text, &files), &[], 12);
    let mut expected = values.clone();
    expected.sort_by(f64::total_cmp);
    assert_same(&found, &expected[..12], 1e-8);
}
