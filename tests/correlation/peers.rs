//! The same numbers through other people's programs: sdypy-EMA (MAC, MSF), pymodal (CSAC, FDAC), vibrationtesting (Guyan,
//! SEREP).
//!
//! Needs `python3` (or what `RETUNE_PYTHON` names) with these packages; without them the test is skipped with a message,
//! unless `RETUNE_PEERS=1` demands them. COMAC, CSF and IRS are in none of them in working order; they are held to hand
//! calculations beside their code.

use retune::correlation::{fdac, mac_matrix, modal_scale_factor, signatures};
use retune::data::{Channel, FrfQuantity, FrfSet};
use retune::linalg::{Complex, DMatrix};
use retune::modal::reduction::{guyan, selection, serep};
use retune::modal::{SolveOptions, solve};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

fn python(argument: &str) -> std::io::Result<Output> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/correlation.py");
    let program = std::env::var("RETUNE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    Command::new(program).arg(script).arg(argument).output()
}

fn complex_rows(m: &DMatrix<Complex<f64>>) -> Value {
    let rows = |of: &dyn Fn(Complex<f64>) -> f64| -> Vec<Vec<f64>> {
        m.row_iter().map(|r| r.iter().map(|v| of(*v)).collect()).collect()
    };
    json!({"re": rows(&|v| v.re), "im": rows(&|v| v.im)})
}

fn rows(m: &DMatrix<f64>) -> Value {
    json!(m.row_iter().map(|r| r.iter().copied().collect::<Vec<f64>>()).collect::<Vec<_>>())
}

/// One reference, responses of a row a line.
fn set(h: &DMatrix<Complex<f64>>) -> FrfSet {
    let channel = |name: String| Channel { name, direction: None };
    FrfSet {
        quantity: FrfQuantity::Receptance,
        frequencies_hz: (0..h.nrows()).map(|l| 1.0 + l as f64).collect(),
        references: vec![channel("force".into())],
        responses: (0..h.ncols()).map(|c| channel(c.to_string())).collect(),
        h: h.transpose().iter().copied().collect(),
        coherence: None,
        n_averages: None,
    }
}

fn close(what: &str, own: f64, other: &Value) {
    let other = other.as_f64().unwrap();
    assert!((own - other).abs() < 1e-9 * (1.0 + other.abs()), "{what}: {own}, the peer {other}");
}

#[test]
fn other_programs_give_the_same_numbers() {
    let answer = python("probe");
    if !answer.as_ref().is_ok_and(|o| o.status.success()) {
        assert!(
            std::env::var("RETUNE_PEERS").as_deref() != Ok("1"),
            "RETUNE_PEERS=1, but the packages of tests/peers/correlation.py do not run: {answer:?}"
        );
        eprintln!("skipped: python3 with sdypy-EMA, pymodal and vibrationtesting is not there");
        return;
    }
    let wave = |i: usize, j: usize, seed: f64| {
        let t = seed + 0.9 * i as f64 + 1.7 * j as f64;
        Complex::new((1.3 * t).sin() + 0.2, (0.7 * t).cos())
    };
    let phi_a = DMatrix::from_fn(7, 3, |i, j| wave(i, j, 0.0));
    let phi_x = DMatrix::from_fn(7, 3, |i, j| wave(i, j, 0.4));
    let h_a = DMatrix::from_fn(6, 4, |i, j| wave(i, j, 2.0));
    let h_x = DMatrix::from_fn(6, 4, |i, j| wave(i, j, 2.3));
    // A chain of five, fixed at one end.
    let stiffness = DMatrix::from_fn(5, 5, |i, j| match i.abs_diff(j) {
        0 if i == 4 => 140.0,
        0 => 100.0 + 10.0 * i as f64 + 100.0 + 10.0 * (i + 1) as f64,
        1 => -(100.0 + 10.0 * i.max(j) as f64),
        _ => 0.0,
    });
    let mass = DMatrix::from_fn(5, 5, |i, j| if i == j { 1.0 + 0.2 * i as f64 } else { 0.0 });
    // vibrationtesting wants the masters first.
    let masters = [0, 1, 2];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("correlation_peers");
    std::fs::create_dir_all(&folder).unwrap();
    let cases = json!({
        "phi_a": complex_rows(&phi_a), "phi_x": complex_rows(&phi_x),
        "h_a": complex_rows(&h_a), "h_x": complex_rows(&h_x),
        "stiffness": rows(&stiffness), "mass": rows(&mass), "masters": masters,
    });
    std::fs::write(folder.join("cases.json"), cases.to_string()).unwrap();
    let output = python(folder.to_str().unwrap()).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let peer: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("answers.json")).unwrap()).unwrap();

    let mac = mac_matrix(&phi_a, &phi_x);
    for i in 0..3 {
        for j in 0..3 {
            close("MAC", mac[(i, j)], &peer["mac"][i][j]);
        }
        // The peer's factors are real; it is given the real parts.
        let real = |m: &DMatrix<Complex<f64>>| m.column(i).iter().map(|v| v.re).collect::<Vec<f64>>();
        close("MSF", modal_scale_factor(&real(&phi_a), &real(&phi_x)), &peer["msf"][i]);
    }
    let lines = signatures(&set(&h_a), &set(&h_x)).unwrap();
    let all = fdac(&set(&h_a), &set(&h_x), 0).unwrap();
    for l in 0..6 {
        close("CSAC", lines[l].shape.unwrap(), &peer["csac"][l]);
        for x in 0..6 {
            close("FDAC", all[(l, x)], &peer["fdac"][l][x]);
        }
    }
    let s = selection(5, &masters).unwrap();
    let fixed = guyan(&stiffness, &mass, &s).unwrap();
    for i in 0..3 {
        for j in 0..3 {
            close("Guyan mass", fixed.mass[(i, j)], &peer["guyan_mass"][i][j]);
            close("Guyan stiffness", fixed.stiffness[(i, j)], &peer["guyan_stiffness"][i][j]);
        }
    }
    let modes = solve(&stiffness, &mass, &DMatrix::zeros(5, 6), SolveOptions { n_elastic: 3, shift: None }).unwrap();
    let reduced = serep(&stiffness, &mass, &s, &modes.shapes.columns(0, 3).into_owned()).unwrap();
    let own =
        solve(&reduced.stiffness, &reduced.mass, &DMatrix::zeros(3, 6), SolveOptions { n_elastic: 3, shift: None });
    for (k, lambda) in own.unwrap().lambda.iter().enumerate() {
        close("SEREP", *lambda, &peer["serep_lambda"][k]);
    }
}
