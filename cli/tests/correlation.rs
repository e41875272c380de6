//! `compare`, `pretest` and `sensitivity` as a user meets them: exit codes, widths, JSON keys, profiles.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models")
}

fn run(line: &str, columns: &str, folder: &Path) -> (i32, String, String) {
    let output: Output = Command::new(env!("CARGO_BIN_EXE_retune"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .env("COLUMNS", columns)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |b: &[u8]| String::from_utf8(b.to_vec()).unwrap();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(!err.contains("panicked") && output.status.code() != Some(70), "{line}: {err}");
    (output.status.code().unwrap_or(-1), out, err)
}

fn said(line: &str) -> (i32, String, String) {
    run(line, "100", &models())
}

fn json(line: &str) -> Value {
    let (_, out, err) = said(line);
    serde_json::from_str(&out).unwrap_or_else(|e| panic!("{line}: {e}\n{out}{err}"))
}

fn scratch(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&path).unwrap();
    path
}

#[test]
fn the_short_answer_fits_a_terminal_and_names_what_is_wrong() {
    for columns in ["80", "120"] {
        let (code, out, _) = run("compare bff.yaml bff_gvt.yaml", columns, &models());
        assert_eq!(code, 0);
        let width: usize = columns.parse().unwrap();
        let long: Vec<&str> = out.lines().filter(|l| l.chars().count() > width).collect();
        assert!(long.is_empty(), "{long:#?}");
        assert!(out.lines().count() <= 40, "{out}");
    }
    let (_, out, _) = said("compare bff.yaml bff_gvt.yaml");
    for word in ["8 act only through 4 numbers", "swapped", "sensors", "mass", "places", "--all"] {
        assert!(out.contains(word), "{word}: {out}");
    }
    // Frequencies decide between two shapes that are alike.
    assert!(out.contains("probability above 0.999") && !out.contains("ambiguous"), "{out}");
    let (_, out, _) = said("compare bff.yaml bff_gvt.yaml --all");
    for word in ["Sensors", "Orthogonality", "Places", "Parameters", "these 8 parameters act only through 4 numbers"] {
        assert!(out.contains(word), "{word}: {out}");
    }
}

#[test]
fn json_has_every_part_whatever_the_flags() {
    let found = json("compare bff_updated.yaml bff_gvt.yaml --json");
    let keys = found.as_object().unwrap();
    for key in [
        "pairs",
        "unpaired_test",
        "unpaired_model",
        "swapped",
        "misfit",
        "p_value",
        "modes",
        "sensors",
        "orthogonality",
        "localization",
        "parameters",
        "functions",
        "profile",
    ] {
        assert!(keys.contains_key(key), "{key}");
    }
    assert_eq!(found["sensors"]["sensors"].as_array().unwrap().len(), 34);
    assert!(found["sensors"]["sensors"][0]["comac"].as_f64().unwrap() <= 1.0);
    assert_eq!(found["orthogonality"]["cross"].as_array().unwrap().len(), 6);
    assert_eq!(found["parameters"]["identifiability"]["rank"], 14);
    assert_eq!(found["parameters"]["with_mass_known"]["rank"], 15);
    assert!(found["localization"]["by_element"]["places"][0]["name"].as_str().unwrap().contains("_wing."));
    assert!(found["modes"][2]["misfit"]["p_value"].as_f64().is_some());
}

#[test]
fn a_profile_decides_the_exit_code() {
    let (code, out, _) = said("compare bff_truth.yaml bff_gvt.yaml --profile common-practice");
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("✓ passes"), "{out}");
    let (code, out, _) = said("compare bff.yaml bff_gvt.yaml --profile common-practice");
    assert_eq!(code, 1, "{out}");
    assert!(out.contains("✕ fails") && out.contains("probability"), "{out}");
    // A profile of one's own: a copy of a built-in one, edited.
    let folder = scratch("profiles");
    let (code, text, _) = said("explain common-practice");
    assert_eq!(code, 0);
    let mine = text.replace("common-practice", "mine").replace("0.05", "0.6").replace("0.9", "0.01");
    std::fs::write(folder.join("mine.yaml"), mine).unwrap();
    let file = folder.join("mine.yaml").display().to_string();
    let (code, out, err) = said(&format!("compare bff_updated.yaml bff_gvt.yaml --profile {file}"));
    assert_eq!(code, 0, "{out}{err}");
    let (code, _, err) = said(&format!("compare bff.yaml bff_gvt.yaml --profile {file}:mines"));
    assert!(code == 2 && err.contains("did you mean `mine`?"), "{err}");
    let (code, _, err) = said("compare bff.yaml bff_gvt.yaml --profile nasa-std-5003");
    assert!(code == 2 && err.contains("did you mean `nasa-std-5002`?"), "{err}");
    let (code, out, _) = said("list profiles");
    assert!(code == 0 && out.contains("ecss-e-st-32-11"), "{out}");
}

#[test]
fn functions_are_compared_by_band() {
    let folder = scratch("functions");
    let models = models().display().to_string();
    let (code, _, err) = run(
        &format!(
            "twin {models}/bff_truth.yaml --frf f.csv --sensors {models}/bff_gvt.yaml --exciter p12 --band 3 35 --lines 321 --damping 2.3% --force"
        ),
        "100",
        &folder,
    );
    assert_eq!(code, 0, "{err}");
    let line = format!("compare {models}/bff_truth.yaml {models}/bff_gvt.yaml --frf f.csv");
    let (code, out, err) = run(&line, "100", &folder);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("CSAC") && out.contains("driving point p12"), "{out}");
    let (_, out, _) = run(&format!("{line} --json"), "100", &folder);
    let found: Value = serde_json::from_str(&out).unwrap();
    let bands = found["functions"]["bands"].as_array().unwrap();
    // The same aircraft but for its damping: patterns agree.
    assert!(bands.len() == 6 && bands.iter().all(|b| b["csac"].as_f64().unwrap() > 0.99), "{bands:?}");
    let (_, out, _) = run(&format!("{line} --bands 3 10 20 35 --json"), "100", &folder);
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(found["functions"]["bands"].as_array().unwrap().len(), 3);
    let (code, _, err) = run(&format!("{line} --bands 10 3"), "100", &folder);
    assert!(code == 2 && err.contains("ascending"), "{err}");
}

#[test]
fn wrong_questions_are_refused() {
    let (code, _, err) = said("compare frame.yaml bff_gvt.yaml");
    assert!(code == 2 && err.contains("none of the 34 sensors"), "{err}");
    let (code, _, err) = said("pretest frame.yaml --sensors 2");
    assert!(code == 2 && err.contains("number of sensors to keep"), "{err}");
    let (code, _, err) = said("pretest frame.yaml --noise-shape 0%");
    assert!(code == 2 && err.contains("above zero"), "{err}");
    let (code, _, err) = said("compare bff.yaml bff_gvt.yaml --reduction guyan");
    assert!(code == 2 && err.contains("Guyan") && err.contains("sensor"), "{err}");
}

#[test]
fn a_plan_and_its_json() {
    let (code, out, err) = run("pretest bff.yaml -n 6 --test bff_gvt.yaml", "80", &models());
    assert_eq!(code, 0, "{err}");
    for word in ["Target modes", "effective independence", "autoMAC", "kinetic energy", "Exciter", "One more sensor"] {
        assert!(out.contains(word), "{word}: {out}");
    }
    assert!(out.lines().all(|l| l.chars().count() <= 80), "{out}");
    let plan = json("pretest frame.yaml -n 4 --sensors 6 --by auto-mac --json");
    assert_eq!(plan["sensors"]["autoMAC"]["sensors"].as_array().unwrap().len(), 6);
    assert!(plan["modes"][0]["effective_mass"][0].as_f64().unwrap() > 0.7);
    assert!(plan["next"][0]["nats"].as_f64().unwrap() > 0.0);
}

/// Eight places: the default of twelve sensors does not fit, four places not even six modes. What is asked for is refused in numbers.
#[test]
fn the_defaults_of_a_plan_fit_the_model() {
    let folder = std::env::temp_dir().join(format!("retune-plan-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let text = "retune: 1\nname: cantilever\nactive_dofs: [uz, ry]\nparameters: {E: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}}\n\
sections: {s: {E: E, density: 2700 kg/m3, shape: {rectangle: {width: 40 mm, height: 10 mm}}}}\n\
nodes: {n0: [0, 0, 0], n1: [0.2 m, 0, 0], n2: [0.4 m, 0, 0], n3: [0.6 m, 0, 0], n4: [0.8 m, 0, 0]}\n\
beams: {ab: {chain: [n0, n1, n2, n3, n4], section: s, subdivide: 2}}\nsupports: {c: {node: n0}}\n";
    std::fs::write(folder.join("eight.yaml"), text).unwrap();
    std::fs::write(folder.join("four.yaml"), text.replace(", subdivide: 2", "")).unwrap();
    for (name, modes, sensors) in [("eight", 6, 8), ("four", 4, 4)] {
        let (code, out, err) = run(&format!("pretest {name}.yaml --json"), "80", &folder);
        assert_eq!(code, 0, "{err}");
        let plan: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(plan["modes"].as_array().unwrap().len(), modes);
        assert_eq!(plan["sensors"]["autoMAC"]["sensors"].as_array().unwrap().len(), sensors);
    }
    let (code, _, err) = run("pretest eight.yaml --sensors 12", "80", &folder);
    let right = "number of sensors to keep is 12; it must be at least 6, as there are target modes, and at most 8, as there are places";
    assert!(code == 2 && err.contains(right), "{err}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn sensitivities_as_table_and_json() {
    let (code, out, err) = said("sensitivity frame.yaml");
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("E_columns") && out.contains("Shapes") && out.contains("mass kg"), "{out}");
    let found = json("sensitivity bff.yaml bff_gvt.yaml --json");
    assert_eq!(found["parameters"].as_array().unwrap().len(), 19);
    let spar = found["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "E_wing").unwrap();
    assert!(spar["modes"][0]["percent_per_interval"].as_f64().unwrap() > 10.0);
    assert_eq!(spar["functions_percent_per_interval"].as_array().unwrap().len(), 201);
    assert_eq!(found["test"]["with_mass_known"]["groups"][0]["acts_through"].as_array().unwrap().len(), 4);
}
