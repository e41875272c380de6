//! Reports from the command line: pages, data, figures, the terminal at any width, and files that are never lost.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder of its own for every test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("retune-report-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
        for file in ["bff_updated.yaml", "bff.yaml", "bff_gvt.yaml", "cantilever.yaml"] {
            fs::copy(models.join(file), path.join(file)).unwrap();
        }
        Self(path)
    }

    fn run(&self, line: &str, columns: usize) -> Output {
        Command::new(env!("CARGO_BIN_EXE_retune"))
            .current_dir(&self.0)
            .args(line.split_whitespace())
            .env("COLUMNS", columns.to_string())
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn out(o: &Output) -> String {
    String::from_utf8_lossy(&o.stdout).into_owned()
}

fn err(o: &Output) -> String {
    String::from_utf8_lossy(&o.stderr).into_owned()
}

/// The data inside a page.
fn data_of(page: &str) -> Value {
    let start = page.find("id=\"report-data\">").unwrap() + "id=\"report-data\">".len();
    serde_json::from_str(&page[start..start + page[start..].find("</script>").unwrap()]).unwrap()
}

#[test]
fn a_report_writes_page_data_figures_and_paraview_files_and_overwrites_nothing() {
    let f = Folder::new("all");
    let line =
        "report bff_updated.yaml bff_gvt.yaml --history bff.yaml -o r.html --data r.json --svg figures --vtk vtk";
    let o = f.run(line, 100);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    for word in ["written: r.html", "written: r.json", "files in figures", "files in vtk"] {
        assert!(out(&o).contains(word), "{word}: {}", out(&o));
    }
    let (page, json) = (data_of(&f.read("r.html")), f.json("r.json"));
    assert_eq!(page["comparison"]["pairs"], json["comparison"]["pairs"]);
    assert_eq!(json["steps"]["steps"].as_array().unwrap().len(), 2);
    assert_eq!(json["steps"]["steps"][0]["name"], "bff");
    let files = json["meta"]["files"].as_array().unwrap();
    assert_eq!(files.len(), 3);
    assert!(files.iter().all(|x| x["sha256"].as_str().unwrap().len() == 64));
    assert_eq!(json["meta"]["commands"][0], format!("retune {line}"));
    assert!(f.0.join("figures/mac-before.svg").exists() && f.0.join("figures/error-falling.svg").exists());
    assert!(fs::read_dir(f.0.join("vtk")).unwrap().any(|e| e.unwrap().path().extension().is_some_and(|x| x == "pvd")));
    let again = f.run(line, 100);
    assert_eq!(again.status.code(), Some(2));
    assert!(err(&again).contains("r.html exists; give --force"), "{}", err(&again));
}

/// FIPS 180-4: SHA-256 of "abc".
#[test]
fn hashes_are_those_of_the_files() {
    let f = Folder::new("hash");
    fs::write(f.0.join("abc.txt"), "abc").unwrap();
    let o = f.run("report bff.yaml bff_gvt.yaml --data r.json", 100);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    let hash = f.json("r.json")["meta"]["files"][0]["sha256"].as_str().unwrap().to_string();
    let Ok(sum) = Command::new("sha256sum").arg(f.0.join("bff.yaml")).output() else {
        eprintln!("skipped: no sha256sum here");
        return;
    };
    assert!(String::from_utf8_lossy(&sum.stdout).starts_with(&hash), "{hash}");
}

#[test]
fn without_an_output_the_report_is_read_on_the_terminal() {
    let f = Folder::new("terminal");
    let o = f.run("report bff_updated.yaml bff_gvt.yaml", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    for word in ["Pairs", "Where model and test disagree"] {
        assert!(out(&o).contains(word), "{}", out(&o));
    }
}

#[test]
fn a_diagnosis_fits_the_terminal_names_are_whole_and_the_page_says_the_same() {
    let f = Folder::new("diagnose");
    let o = f.run("diagnose bff_updated.yaml bff_gvt.yaml --report d.html", 80);
    assert_eq!(o.status.code(), Some(1), "{}", err(&o));
    let text = out(&o);
    assert!(text.contains("mass-offset@left_wing+right_wing.y_lumps\n"), "{text}");
    for line in text.lines().skip(4) {
        assert!(line.chars().count() <= 80, "{line}");
    }
    let d = data_of(&f.read("d.html"));
    let best = &d["diagnosis"]["hypotheses"][0];
    assert_eq!(best["id"], "mass-offset@left_wing+right_wing.y_lumps");
    assert_eq!(best["place"]["elements"].as_array().unwrap().len(), 8);
    assert_eq!(d["meta"]["seeds"][0]["text"], "0");
    // What the page shows is what the JSON output says.
    let json: Value = serde_json::from_str(&out(&f.run("diagnose bff_updated.yaml bff_gvt.yaml --json", 80))).unwrap();
    assert_eq!(json["hypotheses"][0]["misfit_after"], best["misfit_after"]);
    assert_eq!(json["hypotheses"][0]["probability"], best["probability"]);
}

#[test]
fn a_history_of_learning_becomes_a_page_from_the_verb_the_json_and_the_versions() {
    let f = Folder::new("learn");
    let o = f.run("learn bff_updated.yaml bff_gvt.yaml --report l.html -o versions.yaml --json", 80);
    assert!(matches!(o.status.code(), Some(0 | 1)), "{}", err(&o));
    fs::write(f.0.join("l.json"), out(&o)).unwrap();
    let direct = data_of(&f.read("l.html"));
    let names: Vec<&str> =
        direct["steps"]["steps"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(names[..3], ["initial", "refitted", "+ mass-offset@left_wing+right_wing.y_lumps"]);

    let o = f.run("report bff_updated.yaml bff_gvt.yaml --learn l.json --data r.json", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    assert_eq!(f.json("r.json")["steps"], direct["steps"]);

    fs::create_dir(f.0.join("v")).unwrap();
    for k in 0..2 {
        fs::rename(f.0.join(format!("versions.{k}.yaml")), f.0.join(format!("v/learned.{k}.yaml"))).unwrap();
    }
    let o = f.run("report bff_updated.yaml bff_gvt.yaml --learn v --data v.json", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    assert_eq!(f.json("v.json")["steps"]["steps"].as_array().unwrap().len(), 3);

    let o = f.run("report bff.yaml bff_gvt.yaml --learn bff.yaml --data x.json", 80);
    assert_eq!(o.status.code(), Some(2));
    assert!(err(&o).contains("is not an output of `retune learn --json`"), "{}", err(&o));
}

/// Also of a step that comes late: nothing is written then.
#[test]
fn learn_checks_every_output_before_the_work() {
    let f = Folder::new("outputs");
    let o = f.run("learn bff_updated.yaml bff_gvt.yaml -o none/l.yaml", 80);
    assert_eq!(o.status.code(), Some(2));
    assert!(err(&o).contains("cannot write none/l.0.yaml"), "{}", err(&o));
    fs::write(f.0.join("l.3.yaml"), "mine").unwrap();
    let o = f.run("learn bff_updated.yaml bff_gvt.yaml -o l.yaml", 80);
    assert_eq!(o.status.code(), Some(2));
    assert!(err(&o).contains("l.3.yaml exists; give --force"), "{}", err(&o));
    assert_eq!((f.read("l.3.yaml").as_str(), f.0.join("l.0.yaml").exists()), ("mine", false));
}

#[test]
fn functions_of_a_twin_stand_beside_those_of_the_model() {
    let f = Folder::new("frf");
    let o =
        f.run("twin bff_updated.yaml --frf twin.csv --sensors bff_gvt.yaml --exciter p12 --band 3 35 --lines 200", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    let o = f.run("report bff_updated.yaml bff_gvt.yaml --history bff.yaml --frf twin.csv --data r.json", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    let frfs = &f.json("r.json")["frfs"];
    assert_eq!(frfs["origin"], "synthetic");
    assert_eq!(frfs["channels"].as_array().unwrap().len(), 34);
    // Functions of the same model, but for the damping, against those of the initial one.
    let mean = |key: &str| {
        let all = frfs["channels"].as_array().unwrap().iter().flat_map(|c| c[key].as_array().unwrap());
        let known: Vec<f64> = all.filter_map(Value::as_f64).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    assert!(mean("frac") > mean("frac_before") + 0.2, "{} against {}", mean("frac"), mean("frac_before"));
    assert!(frfs["fdac_before"].as_array().is_some_and(|l| l.len() == 1));
}

/// The pages of poles and of a posterior hold what the terminal and the answer say.
#[test]
fn identify_and_sample_write_their_pages() {
    let f = Folder::new("pages");
    let o = f.run("twin cantilever.yaml -o t.yaml --frf t.unv --band 5 400 --modes 3 --lines 800 --noise-response 1% --noise-shape 2% --noise-frequency 0.5%", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    let o = f.run("identify t.unv --report i.html --json", 80);
    assert!(matches!(o.status.code(), Some(0 | 1)), "{}", err(&o));
    let (page, answer) = (data_of(&f.read("i.html")), serde_json::from_str::<Value>(&out(&o)).unwrap());
    let found = &page["identification"];
    let (modes, told) = (found["modes"].as_array().unwrap(), answer["modes"].as_array().unwrap());
    assert!(!modes.is_empty() && modes.len() == told.len(), "{} and {}", modes.len(), told.len());
    for (m, t) in modes.iter().zip(told) {
        assert_eq!(m["hz"], t["frequency_hz"], "{t}");
    }
    let diagram = &found["diagrams"][0];
    let n = diagram["order"].as_array().unwrap().len();
    assert!(n > modes.len() && diagram["mark"].as_array().unwrap().len() == n);
    assert!(page["live"].is_null() && page["modes"]["test"].as_array().unwrap().len() == modes.len());
    let o = f.run("identify t.unv --report i.html", 80);
    assert_eq!(o.status.code(), Some(2), "nothing is overwritten");
    let o = f.run("identify t.yaml --report j.html", 80);
    assert_eq!(o.status.code(), Some(2), "{}", out(&o));

    let o = f.run("sample cantilever.yaml t.yaml --samples 200 --report s.html --json", 80);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    let (page, answer) = (data_of(&f.read("s.html")), serde_json::from_str::<Value>(&out(&o)).unwrap());
    let (all, told) = (page["posterior"]["parameters"].as_array().unwrap(), answer["parameters"].as_array().unwrap());
    assert_eq!((all.len(), page["posterior"]["samples"].as_u64()), (told.len(), Some(200)));
    for (p, t) in all.iter().zip(told) {
        assert_eq!((&p["name"], &p["mean"]), (&t["name"], &t["mean"]));
        // Four bytes a sample, base64.
        assert_eq!(p["values"].as_str().unwrap().len(), (200_usize * 4).div_ceil(3) * 4);
    }
}

#[test]
fn an_update_writes_its_page() {
    let f = Folder::new("update");
    let o = f.run("update bff.yaml bff_gvt.yaml --budget 400 --report u.html", 100);
    assert!(matches!(o.status.code(), Some(0 | 1)), "{}", err(&o));
    let d = data_of(&f.read("u.html"));
    assert_eq!(d["meta"]["title"], "BFF ground vibration test");
    assert!(d["meta"]["verdict"]["number"].as_str().unwrap().contains(" → "));
    let o = f.run("update bff.yaml bff_gvt.yaml --budget 400 --report u.html", 100);
    assert_eq!(o.status.code(), Some(2), "an existing page is kept");
}

/// A strip clamped and free. More mass along it than the model has shows in both tests.
#[test]
fn what_two_configurations_of_a_structure_lack_is_learnt_from_both_tests() {
    let f = Folder::new("two-tests");
    let strip = "retune: 1\nname: strip\nactive_dofs: [uz, ry]\n\
        parameters:\n  tip: {value: 60 g, bounds: [20 g, 200 g]}\n  E: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}\n\
        nodes: {n0: [0, 0, 0], n1: [0.25, 0, 0], n2: [0.5, 0, 0], n3: [0.75, 0, 0], n4: [1, 0, 0]}\n\
        beams:\n  strip: {chain: [n0, n1, n2, n3, n4], properties: {E: E, Iy: 8e-10 m4, mass_per_length: 0.8 kg/m}, subdivide: 2}\n\
        masses: {tip: {node: n4, mass: tip}}\n\
        supports: {clamp: {node: n0}}\n\
        configurations: {free: {without: [clamp]}}\n";
    fs::write(f.0.join("strip.yaml"), strip).unwrap();
    fs::write(f.0.join("hidden.yaml"), "masses: {pod: {node: n2, mass: 50 g}}\n").unwrap();
    for (name, configuration) in [("a.yaml", ""), ("b.yaml", "--configuration free")] {
        let line = format!(
            "twin strip.yaml -o {name} --modes 4 --noise-frequency 0.3% --noise-shape 2% --patch hidden.yaml --seed 4 {configuration}"
        );
        let o = f.run(&line, 100);
        assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    }
    let o = f.run("learn strip.yaml a.yaml b.yaml -o v.yaml --take-best --report l.html", 100);
    assert_eq!(o.status.code(), Some(0), "{}{}", out(&o), err(&o));
    assert!(out(&o).contains("configuration free") && out(&o).contains("point-mass@n2"), "{}", out(&o));
    let page = data_of(&f.read("l.html"));
    let warnings = page["meta"]["warnings"].to_string();
    assert!(warnings.contains("rests on 2 tests"), "{warnings}");
    assert_eq!(page["steps"]["mode_labels"].as_array().map(Vec::len), Some(8));
    // The learnt model holds in both configurations.
    for test in ["a.yaml", "b.yaml"] {
        let o = f.run(&format!("compare v.1.yaml {test} --json"), 100);
        let json: Value = serde_json::from_str(&out(&o)).unwrap();
        assert!(json["p_value"].as_f64().is_none_or(|p| p > 1e-3), "{test}: {json}");
    }
    // A foundation spring of the free test is one of the free configuration.
    let o = f.run("add strip.yaml ground-spring@free/n2.uz -o soft.yaml", 100);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    assert!(
        f.read("soft.yaml").contains("configurations: {free: {without: [clamp], springs: {"),
        "{}",
        f.read("soft.yaml")
    );
    let o = f.run("undo soft.yaml", 100);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    assert_eq!(f.read("soft.yaml"), strip);
}
