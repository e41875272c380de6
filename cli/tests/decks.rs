//! The way of a deck through the command: import, proof, update by hand, export, import once more.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

const DECK: &str = "\
SOL 103
CEND
TITLE = a cantilever with a tip mass
SPC = 1
BEGIN BULK
INCLUDE 'bars.dat'
$ tip mass
CONM2   3       2               2.
SPC1    1       123456  1
ENDDATA
";
const BARS: &str = "\
MAT1    1       2.+11   8.+10
GRID    1               0.      0.      0.
GRID    2               1.      0.      0.
CBAR    5       7       1       2       0.      0.      1.
PBAR    7       1       1.-3    4.-8    9.-8    1.-7
";

fn run(folder: &Path, line: &str) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_retune"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
}

/// A page of printed output with f = √(3EI/(m L³))/2π in both planes; SYNTHETIC, by the closed form.
fn page(i1: f64) -> String {
    let lambda = |i: f64| 3.0 * 2e11 * i / 2.0;
    let row = |n: i32, i: f64| {
        let (l, w) = (lambda(i), lambda(i).sqrt());
        format!(
            "{n:>9}{n:>10}        {l:.6E}        {w:.6E}        {:.6E}        1.000000E+00        {l:.6E}\n",
            w / TAU
        )
    };
    format!(
        "1    PAGE 1\n          R E A L   E I G E N V A L U E S\n   MODE    EXTRACTION      EIGENVALUE\n{}{}",
        row(1, i1),
        row(2, 9e-8)
    )
}

#[test]
fn a_deck_goes_in_is_proved_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("wing.bdf"), DECK).unwrap();
    fs::write(at("BARS.DAT"), BARS).unwrap();
    fs::write(at("wing.f06"), page(4e-8)).unwrap();
    // Units are not guessed.
    let (code, out, _) = run(folder.path(), "import wing.bdf -o wing.yaml");
    assert!(code == 2 && out.contains("in-lbf-s") && out.contains("are not guessed"), "{out}");
    assert!(!at("wing.yaml").exists());
    let (code, out, err) = run(folder.path(), "import wing.bdf --units si -o wing.yaml");
    assert!(code == 0 && out.contains("1 CBAR"), "{out}{err}");
    let (code, out, err) = run(folder.path(), "check wing.yaml --against wing.f06");
    assert!(code == 0 && out.contains("the same model"), "{out}{err}");
    let text = fs::read_to_string(at("wing.yaml")).unwrap();
    assert!(text.contains("# tip mass") && text.contains("conm2_3: {node: n2, mass: 2 kg}"), "{text}");
    fs::write(at("updated.yaml"), text.replace("Iz: 4e-8 m4", "Iz: 5e-8 m4")).unwrap();
    let (code, out, _) = run(folder.path(), "check updated.yaml --against wing.f06");
    assert!(code == 1 && out.contains("not the same model"), "{out}");
    fs::create_dir(at("new")).unwrap();
    let (code, out, err) = run(folder.path(), "export updated.yaml --into wing.bdf -o new/wing.bdf");
    assert!(code == 0 && out.contains("I1: 4.-8 -> 5.-8"), "{out}{err}");
    assert_eq!(fs::read_to_string(at("new/wing.bdf")).unwrap(), DECK);
    assert_eq!(fs::read_to_string(at("new/BARS.DAT")).unwrap(), BARS.replace("4.-8", "5.-8"));
    fs::write(at("new/wing.f06"), page(5e-8)).unwrap();
    assert_eq!(run(folder.path(), "import new/wing.bdf --units si -o new/wing.yaml").0, 0);
    let (code, out, err) = run(folder.path(), "check new/wing.yaml --against new/wing.f06");
    assert!(code == 0, "{out}{err}");
}

#[test]
fn a_card_that_cannot_be_read_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("wing.bdf"), DECK).unwrap();
    fs::write(at("bars.dat"), format!("{BARS}CBEND   9       7       1       2\nCBAAR   8\n")).unwrap();
    let (code, _, err) = run(folder.path(), "import wing.bdf --units si -o wing.yaml");
    assert!(
        code == 2 && err.contains("bars.dat:6: CBEND 9: curved beams") && err.contains("did you mean `CBAR`?"),
        "{err}"
    );
    assert!(!at("wing.yaml").exists());
}
