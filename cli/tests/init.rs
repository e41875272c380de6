//! `retune init`: what it writes is sound, what it prints as next steps runs, and nothing is ever overwritten.

use crate::common::run;
use std::fs;
use std::path::Path;

const DECK: &str = "\
SOL 103
CEND
SPC = 1
BEGIN BULK
MAT1    1       7.+10           .33     2700.
PBAR    7       1       1.-3    4.-8    9.-8    1.-7
GRID    1               0.      0.      0.
GRID    2               .5      0.      0.
GRID    3               1.      0.      0.
CBAR    11      7       1       2       0.      0.      1.
CBAR    12      7       2       3       0.      0.      1.
CONM2   21      3               2.
SPC1    1       123456  1
ENDDATA
";

fn files(folder: &Path) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = [folder.to_path_buf(), folder.join("schemas")]
        .iter()
        .flat_map(|f| fs::read_dir(f).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .map(|path| (path.display().to_string(), fs::read_to_string(&path).unwrap()))
        .collect();
    all.sort();
    all
}

/// Every file is sound and names its schema, and the commands that are printed run.
fn is_ready_to_work(line: &str, finds: &[&str]) {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::write(folder.join("strut.bdf"), DECK).unwrap();
    let (code, out, err) = run(folder, &format!("{line} -o project"));
    assert_eq!((code, err.as_str()), (0, ""), "{line}: {out}");
    let project = folder.join("project");
    for name in ["model.yaml", "test.yaml", "objective.yaml"] {
        let (code, out, err) = run(&project, &format!("check {name}"));
        assert!(code == 0 && out.contains(": 0 errors, "), "{line}, {name}: {out}{err}");
        let text = fs::read_to_string(project.join(name)).unwrap();
        let schema = text.lines().next().unwrap().strip_prefix("# yaml-language-server: $schema=").unwrap();
        let schema: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(project.join(schema)).unwrap()).unwrap();
        let keys = text.lines().filter(|l| l.starts_with(char::is_alphabetic)).filter_map(|l| l.split(':').next());
        for key in keys {
            assert!(schema["properties"].get(key).is_some(), "{line}, {name}: the schema does not know `{key}`");
        }
    }
    let next: Vec<&str> = out.split("Next:\n").nth(1).unwrap().lines().map(str::trim).collect();
    assert_eq!(next[0], "cd project");
    assert!(next.len() > 4, "{next:?}");
    for step in &next[1..] {
        let step = step.strip_prefix("retune ").unwrap();
        // A few effects are enough to see that a diagnosis runs.
        let effects = if step.starts_with("diagnose") { " --effects point-mass,root-flexibility" } else { "" };
        let (code, out, err) = run(&project, &format!("{step}{effects}"));
        assert_eq!(code, 0, "{line}: retune {step}: {out}{err}");
        if step.starts_with("update") {
            for value in finds {
                assert!(out.contains(value), "{line}: no `{value}` in {out}");
            }
        }
    }
    // Whatever is there stays.
    let before = files(&project);
    let (code, _, err) = run(folder, "init frame -o project");
    assert!(code == 2 && err.contains("`init` overwrites nothing"), "{err}");
    assert_eq!(files(&project), before);
}

/// The tests were computed with 67 GPa and 85 g: within three standard deviations.
#[test]
fn a_beam_is_ready_to_work() {
    is_ready_to_work("init beam", &["67.0", "84."]);
}

/// 198 GPa and 0.9 MN m/rad.
#[test]
fn a_frame_is_ready_to_work() {
    is_ready_to_work("init frame", &["198.", "0.88"]);
}

/// 1110 N m², 880 N m² and 2.6 kN m/rad.
#[test]
fn an_aircraft_is_ready_to_work() {
    is_ready_to_work("init aircraft", &["1113", "879.", "2.58"]);
}

/// Its test is one of the model as it is.
#[test]
fn a_deck_is_ready_to_work() {
    is_ready_to_work("init --deck strut.bdf --units si", &["pbar_7_stiffness"]);
}

#[test]
fn one_file_that_is_there_keeps_all_others_from_being_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("objective.yaml"), "mine").unwrap();
    let (code, _, err) = run(folder.path(), "init beam");
    assert!(code == 2 && err.contains("objective.yaml is there already"), "{err}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["objective.yaml"]);
}

#[test]
fn units_of_a_deck_are_asked_for_and_a_structure_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("strut.bdf"), DECK).unwrap();
    let (code, out, _) = run(folder.path(), "init --deck strut.bdf");
    assert!(code == 2 && out.contains("--units") && !folder.path().join("model.yaml").exists(), "{out}");
    let (code, _, err) = run(folder.path(), "init");
    assert!(code == 2 && err.contains("STRUCTURE"), "{err}");
    let (code, _, err) = run(folder.path(), "init submarine");
    assert!(code == 2 && err.contains("beam, frame, aircraft"), "{err}");
}

/// `-o FILE` keeps what `--json` prints, beside the text, and overwrites nothing unasked.
#[test]
fn results_are_kept_as_json() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    run(folder, "init beam");
    run(folder, "export model.yaml --matrices -o beam");
    for (i, line) in [
        "check model.yaml",
        "check test.yaml",
        "modes model.yaml -n 3",
        "compare model.yaml test.yaml",
        "health test.yaml",
        "sensitivity model.yaml test.yaml",
        "matrices beam_K.mtx beam_M.mtx beam_dofs.csv",
        "benchmark diagnosis --structure cantilever --null 1 --effects 0 --faults 0 --outside 0",
    ]
    .iter()
    .enumerate()
    {
        let file = format!("{i}.json");
        let (code, text, _) = run(folder, &format!("{line} -o {file}"));
        let (_, printed, _) = run(folder, &format!("{line} --json"));
        assert!(code == 0 && !text.is_empty() && !text.starts_with('{'), "{line}: {text}");
        let mut kept: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.join(&file)).unwrap()).unwrap();
        let mut printed: serde_json::Value = serde_json::from_str(&printed).unwrap();
        for value in [&mut kept, &mut printed] {
            // How long it took is not part of the result.
            if let Some(object) = value.as_object_mut() {
                object.retain(|key, _| !key.contains("second"));
            }
        }
        assert_eq!(kept, printed, "{line}");
        let (code, _, err) = run(folder, &format!("{line} -o {file}"));
        assert!(code == 2 && err.contains("--force"), "{line}: {err}");
    }
    let (code, out, _) = run(folder, "pretest model.yaml -n 3 --by auto-mac -o plan.yaml");
    assert!(code == 0 && out.contains("written: plan.yaml"), "{out}");
    let (code, out, err) = run(folder, "compare model.yaml plan.yaml");
    assert!(code == 0 && out.contains("+0.00 %"), "{out}{err}");
}
