//! Matrices of CalculiX, scikit-fem, OpenSees and pyyeti have the frequencies that those programs give them, and what retune writes is read by
//! SciPy, pyyeti and pyNastran.
//!
//! Needs `python3` (or what `RETUNE_PYTHON` names) with the packages, and `ccx` (or what `RETUNE_CCX` names); what is not there is skipped with
//! a message, unless `RETUNE_MATRIX_PEERS=1` demands all of it. `RETUNE_PYNASTRAN` names the folder of the test files `pyNastran/op4/test`.

use retune::matrices::{MatrixFormat, read, write};
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, export_matrices, load, load_in, solve_modes};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn python(arguments: &[&str]) -> std::io::Result<Output> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/matrices.py");
    let program = std::env::var("RETUNE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    Command::new(program).arg(script).args(arguments).output()
}

fn peer_is_there(name: &str) -> bool {
    let answer = python(&["probe", name]);
    if answer.as_ref().is_ok_and(|o| o.status.success()) {
        return true;
    }
    assert!(
        std::env::var("RETUNE_MATRIX_PEERS").as_deref() != Ok("1"),
        "RETUNE_MATRIX_PEERS=1, but {name} does not run: {answer:?}"
    );
    eprintln!("skipped: {name} is not there");
    false
}

fn run(arguments: &[&str]) {
    let output = python(arguments).unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("matrices").join(name);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn model(folder: &Path, text: &str) -> Model {
    let mut read = |file: &str| std::fs::read(folder.join(file));
    let loaded = load_in(text, None, &Registry::builtin(), &mut read);
    loaded.unwrap_or_else(|p| panic!("{}", p.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))).0
}

/// Frequencies of the peer's matrices against those of the peer, to a relative error; `file` stands for `F` in its model.
fn compare(folder: &Path, file: &str, relative: f64) {
    let text = std::fs::read_to_string(folder.join("model.yaml")).unwrap().replace("file: F", &format!("file: {file}"));
    let expected: Vec<f64> =
        serde_json::from_str(&std::fs::read_to_string(folder.join("frequencies.json")).unwrap()).unwrap();
    let model = model(folder, &text);
    let modes = solve_modes(&model, &[], SolveOptions { n_elastic: expected.len(), shift: None }).unwrap();
    let found: Vec<f64> = modes.elastic().take(expected.len()).map(|i| modes.frequency_hz(i)).collect();
    assert_eq!(found.len(), expected.len());
    let off = found.iter().zip(&expected).map(|(f, e)| (f / e - 1.0).abs()).fold(0.0, f64::max);
    eprintln!("{}: {} modes, largest relative difference {off:.1e}", folder.display(), found.len());
    assert!(off < relative, "{found:?} for {expected:?}");
}

fn make_and_compare(name: &str, relative: f64) {
    if !peer_is_there(name) {
        return;
    }
    let folder = folder(name);
    run(&["make", name, folder.to_str().unwrap()]);
    compare(&folder, "", relative);
}

#[test]
fn calculix() {
    make_and_compare("ccx", 1e-8);
}

/// 19 623 dofs, most of them of inner nodes. Shells that are thin solids have a stiffness of which fourteen digits in the files leave seven of the
/// first frequency: SciPy has those of retune from the same files to 2e-9, and differs from CalculiX as retune does.
#[test]
fn shells_of_calculix() {
    make_and_compare("ccx_shells", 1e-7);
}

/// A free bar of hexahedra that supports of the model file clamp.
#[test]
fn kratos() {
    make_and_compare("kratos", 1e-8);
}

#[test]
fn scikit_fem() {
    make_and_compare("skfem", 1e-8);
}

#[test]
fn opensees() {
    make_and_compare("opensees", 1e-8);
}

/// A free structure reduced by Craig-Bampton, in every layout of OUTPUT4 that pyyeti writes.
#[test]
fn pyyeti() {
    if !peer_is_there("pyyeti") {
        return;
    }
    let folder = folder("pyyeti");
    run(&["make", "pyyeti", folder.to_str().unwrap()]);
    for place in ["b", "t"] {
        for layout in ["dense", "bigmat", "nonbigmat"] {
            compare(&folder, &format!("{place}_{layout}.op4"), 1e-10);
        }
    }
    let text = std::fs::read_to_string(folder.join("model.yaml")).unwrap().replace("file: F", "file: b_dense.op4");
    let reduced = model(&folder, &text);
    let motions = reduced.dof_map().rigid_motions();
    let inner = reduced.dof_map().node("s.c").unwrap();
    // The point inside moves with the rigid motion of the ends.
    let at: f64 =
        reduced.dof_map().express(inner, retune::element::Dof::Ux).iter().map(|&(r, f)| f * motions[(r, 0)]).sum();
    assert!((at - 1.0).abs() < 1e-12, "{at}");
}

#[test]
fn what_is_written_is_read_by_others() {
    if !peer_is_there("check") {
        return;
    }
    let folder = folder("written");
    let whole = load(include_str!("../models/garteur.yaml"), &Registry::builtin()).unwrap().0;
    let export = export_matrices(&whole, &whole.parameters().nominal(), None).unwrap();
    for (stem, format) in [
        ("g", MatrixFormat::MatrixMarket),
        ("g", MatrixFormat::Npz),
        ("t", MatrixFormat::Output4),
        ("b", MatrixFormat::Output4Binary),
    ] {
        for (name, bytes) in write(stem, &export.matrices, &export.dofs, format).unwrap() {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }
    let expected: Map<String, Value> = export
        .matrices
        .iter()
        .map(|m| {
            (m.name.clone(), json!(m.entries.iter().map(|e| json!([e.row, e.column, e.value])).collect::<Vec<_>>()))
        })
        .collect();
    std::fs::write(folder.join("expected.json"), Value::Object(expected).to_string()).unwrap();
    run(&["check", folder.to_str().unwrap()]);
}

/// One set of matrices in six files: text and binary, dense, sparse and BIGMAT.
#[test]
fn the_test_files_of_pynastran_hold_the_same_matrices() {
    let Some(folder) = std::env::var_os("RETUNE_PYNASTRAN").map(PathBuf::from) else {
        eprintln!("skipped: RETUNE_PYNASTRAN does not name the folder of pyNastran's OUTPUT4 files");
        return;
    };
    let all = ["mat_t_dn", "mat_t_s1", "mat_t_s2", "mat_b_dn", "mat_b_s1", "mat_b_s2"].map(|name| {
        let name = format!("{name}.op4");
        let contents = read(&name, &std::fs::read(folder.join(&name)).unwrap()).unwrap();
        assert_eq!((contents.matrices.len(), contents.notes.len()), (6, 3), "{name}");
        contents.matrices
    });
    for name in ["EYE10", "LOW", "NULL", "STRINGS", "RND1RD", "RND1RS"] {
        let of = |matrices: &[retune::matrices::Matrix]| {
            let m = matrices.iter().find(|m| m.name == name).unwrap_or_else(|| panic!("{name}"));
            (m.n_rows, m.n_columns, m.full())
        };
        let first = of(&all[0]);
        for matrices in &all[1..] {
            let other = of(matrices);
            assert_eq!((first.0, first.1, first.2.len()), (other.0, other.1, other.2.len()), "{name}");
            for (a, b) in first.2.iter().zip(&other.2) {
                // Of single precision seven digits are written.
                let tolerance = if name == "RND1RS" { 1e-6 } else { 0.0 };
                assert!(
                    (a.row, a.column) == (b.row, b.column) && (a.value - b.value).abs() <= tolerance,
                    "{name}: {a:?} {b:?}"
                );
            }
        }
    }
    let kgg = ["testplate_kgg.op4", "testplate_kgg_ascii.op4"].map(|name| {
        read(name, &std::fs::read(folder.join(name)).unwrap()).unwrap().matrices.remove(0).symmetric(false).unwrap()
    });
    assert_eq!((kgg[0].n, kgg[0].lower.len()), (726, kgg[1].lower.len()));
    let largest = kgg[0].lower.iter().map(|e| e.value.abs()).fold(0.0, f64::max);
    assert!(kgg[0].lower.iter().zip(&kgg[1].lower).all(|(a, b)| (a.value - b.value).abs() < 1e-9 * largest));
}
