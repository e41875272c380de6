//! The command as a user meets it: exit codes, JSON fields, files that are never lost, quiet pipes, clean stops.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const MODEL: &str = "\
# comments stay
retune: 1
name: cantilever
active_dofs: [uz, ry]
parameters:
  EI: {value: 20 N m2, bounds: [5 N m2, 40 N m2]} # the guess
  lump: {value: 100 g, bounds: [0 g, 300 g]}
nodes: {root: [0 m, 0 m, 0 m], middle: [0.5 m, 0 m, 0 m], tip: [1 m, 0 m, 0 m]}
beams: {strip: {chain: [root, middle, tip], properties: {EIy: EI, mass_per_length: 0.8 kg/m}}}
masses: {tip_mass: {node: tip, mass: lump}}
supports: {clamp: {node: root}}
";

const TEST: &str = "\
retune_test: 1
name: made up
sources: {made: {kind: synthetic, text: by hand}}
sensors:
  middle: {node: middle, direction: +z}
  tip: {node: tip, direction: +z}
defaults: {frequency_sd: 0.5 %, shape_sd: 3 %}
modes:
  - {frequency: 2.2 Hz, source: made, shape: {real: [0.33, 1.0]}}
  - {frequency: 14.9 Hz, source: made, shape: {real: [1.0, -0.7]}}
";

/// A folder of its own for every test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("retune-cli-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("model.yaml"), MODEL).unwrap();
        fs::write(path.join("test.yaml"), TEST).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> &Self {
        fs::write(self.0.join(name), text).unwrap();
        self
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_retune"));
        command.current_dir(&self.0).args(line.split_whitespace()).stdin(Stdio::null()).env_remove("COLUMNS");
        command
    }

    fn run(&self, line: &str) -> Said {
        Said::of(line, &self.command(line).output().unwrap())
    }

    fn json(&self, line: &str) -> Value {
        let said = self.run(line);
        serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{line}: {e}\n{}{}", said.out, said.err))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[derive(Debug)]
struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Said {
    fn of(line: &str, output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let said =
            Self { code: output.status.code().unwrap_or(-1), out: text(&output.stdout), err: text(&output.stderr) };
        assert!(!said.out.contains('\u{1b}') && !said.err.contains('\u{1b}'), "{line}: escapes in a pipe: {said:?}");
        assert!(!said.err.contains("panicked") && said.code != 70, "{line}: {said:?}");
        said
    }
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn assert_has(value: &Value, names: &[&str]) {
    for name in names {
        assert!(keys(value).contains(name), "`{name}` is not among {:?}", keys(value));
    }
}

#[test]
fn a_sound_model_is_done_and_described() {
    let folder = Folder::new("check");
    let said = folder.run("check model.yaml");
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("sound") && said.out.contains("0.9"), "{said:?}");
    let json = folder.json("check model.yaml --json");
    let fields =
        ["ok", "errors", "warnings", "mass_kg", "cg_m", "inertia_kg_m2", "n_dof", "n_rigid_body_modes", "axes"];
    assert_has(&json, &fields);
    // The axes of the sections, with where they come from.
    let first = &json["axes"][0];
    assert_eq!((&first["element"], &first["is_default"]), (&"strip.1".into(), &true.into()), "{json}");
    assert_eq!(first["z"].to_string(), "[0.0,0.0,1.0]", "{json}");
    assert!(said.out.contains("z of the section +z (default), y +y: strip"), "{said:?}");
    assert_eq!((&json["ok"], &json["n_dof"], &json["n_rigid_body_modes"]), (&true.into(), &4.into(), &0.into()));
    assert!((json["mass_kg"].as_f64().unwrap() - 0.9).abs() < 1e-12);
    // The fields are there for a wrong model too.
    folder.write("wrong.yaml", MODEL.replace("[root, middle, tip]", "[root, midle, tip]"));
    let json = folder.json("check wrong.yaml --json");
    assert_has(&json, &fields);
    assert_eq!(json["ok"], Value::Bool(false));
    assert!(json["errors"][0].to_string().contains("did you mean `middle`?"), "{json}");
}

/// A wing on nothing is an error that says so; doubts without an error are not called sound.
#[test]
fn a_broken_structure_is_not_sound() {
    let folder = Folder::new("broken");
    let body = "retune: 1\nname: b\nsections:\n  s: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {circle: {diameter: 20 mm}}}\n";
    let nodes = "nodes: {a: [0, 0, 0], b: [1 m, 0, 0], r: [1 m, 0, 0], t: [1 m, 1 m, 0]}\n";
    let beams =
        "beams: {body: {nodes: [a, b], section: s}, wing: {nodes: [r, t], section: s}}\nsupports: {root: {node: a}}\n";
    folder.write("wing.yaml", format!("{body}{nodes}{beams}"));
    let said = folder.run("check wing.yaml");
    assert!(
        said.code == 2 && said.err.contains("a part hangs on nothing") && said.out.contains("not usable"),
        "{said:?}"
    );
    folder.write("joined.yaml", format!("{body}{nodes}{beams}rigid_links: {{joint: {{master: b, slaves: [r]}}}}\n"));
    let said = folder.run("check joined.yaml");
    assert!(said.code == 0 && said.out.contains("sound: 0 errors, 0 warnings"), "{said:?}");
    folder.write(
        "far.yaml",
        format!(
            "{body}{}{beams}rigid_links: {{joint: {{master: b, slaves: [r]}}}}\n",
            nodes.replace("t: [1 m, 1 m, 0]", "t: [1 m, 600, 0]")
        ),
    );
    let said = folder.run("check far.yaml");
    assert!(
        said.out.contains("usable, with doubts") && said.err.contains("`t` lies 600 m away from the others"),
        "{said:?}"
    );
}

#[test]
fn wrong_input_is_2_with_file_line_and_column() {
    let folder = Folder::new("wrong");
    folder.write("wrong.yaml", MODEL.replace("[root, middle, tip]", "[root, midle, tip]"));
    for line in ["check wrong.yaml", "modes wrong.yaml", "compare wrong.yaml test.yaml", "update wrong.yaml test.yaml"]
    {
        let said = folder.run(line);
        assert_eq!(said.code, 2, "{line}: {said:?}");
        let place = "wrong.yaml:9:31: error: beams.strip.chain[1]: node `midle` is not defined; did you mean `middle`?";
        assert!(said.err.contains(place), "{line}: {said:?}");
    }
    folder.write("wrong_test.yaml", TEST.replace("node: tip", "node: tipp"));
    for line in ["compare model.yaml wrong_test.yaml", "update model.yaml wrong_test.yaml"] {
        let said = folder.run(line);
        assert_eq!(said.code, 2, "{line}: {said:?}");
        let place = "wrong_test.yaml:6:9: error: sensors.tip.node: the model has no node `tipp`; did you mean `tip`?";
        assert!(said.err.contains(place), "{line}: {said:?}");
    }
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = Folder::new("unreadable");
    folder.write("binary.yaml", [0x66, 0xff, 0xfe, 0x00]).write("latin.yaml", [0x66, 0xff, 0xfe, 0x66]);
    folder.write("empty.yaml", "");
    let wide: Vec<u8> = MODEL.encode_utf16().flat_map(u16::to_le_bytes).collect();
    folder.write("wide.yaml", [&[0xff, 0xfe], &wide[..]].concat()).write("bare.yaml", wide);
    for (line, word) in [
        ("check nowhere.yaml", "nowhere.yaml"),
        ("check .", "cannot read ."),
        ("check binary.yaml", "it is a binary file, not text"),
        ("check latin.yaml", "not UTF-8 text (byte 1, line 1) but perhaps"),
        ("check wide.yaml", "it is UTF-16 (little endian), not UTF-8; save it as UTF-8"),
        ("check bare.yaml", "it is UTF-16 (little endian) without a byte order mark, not UTF-8"),
        ("check empty.yaml", "empty"),
        ("compare model.yaml nowhere.yaml", "nowhere.yaml"),
        ("modes test.yaml", "this is a test file"),
        ("compare model.yaml model.yaml", "this is a model file"),
        ("explain baem", "did you mean `beam`?"),
        ("update model.yaml test.yaml --optimizer nelder-maed", "did you mean `nelder-mead`?"),
        ("update model.yaml test.yaml --budget many", "invalid value 'many'"),
        ("compare model.yaml test.yaml --min-mac NaN", "--min-mac"),
        ("chekc model.yaml", "check"),
        ("", "Usage"),
    ] {
        let said = folder.run(line);
        assert_eq!(said.code, 2, "{line}: {said:?}");
        assert!(said.err.contains(word), "{line}: {said:?}");
        assert!(said.out.is_empty(), "{line}: {said:?}");
    }
}

#[test]
fn modes_and_compare_have_their_json_fields() {
    let folder = Folder::new("json");
    let json = folder.json("modes model.yaml -n 3 --json");
    assert_eq!(json["modes"].as_array().unwrap().len(), 3);
    assert_has(&json["modes"][0], &["frequency_hz", "label"]);
    let json = folder.json("compare model.yaml test.yaml --json");
    assert_has(&json, &["pairs", "unpaired_test", "unpaired_model", "cost"]);
    assert_has(&json["pairs"][0], &["test_hz", "model_hz", "error_percent", "mac"]);
    let pair = &json["pairs"][0];
    let (test, model) = (pair["test_hz"].as_f64().unwrap(), pair["model_hz"].as_f64().unwrap());
    assert!((pair["error_percent"].as_f64().unwrap() - 100.0 * (model - test) / test).abs() < 1e-9);
}

#[test]
fn update_writes_only_what_changed_and_never_over_a_file() {
    let folder = Folder::new("update");
    let line = "update model.yaml test.yaml -o out.yaml --json";
    let json = folder.json(line);
    assert_has(&json, &["cost_before", "cost_after", "evaluations", "termination", "parameters", "pairs"]);
    assert_has(&json["parameters"][0], &["name", "unit", "before", "after", "lower", "upper", "at_bound"]);
    assert_has(&json["parameters"][0], &["sd", "interval", "interval_method", "correlations", "held"]);
    assert_has(&json, &["unidentifiable", "rank", "remarks", "tests"]);
    assert!(json["cost_after"].as_f64().unwrap() < json["cost_before"].as_f64().unwrap());
    let written = folder.read("out.yaml");
    let differ: Vec<&str> = MODEL.lines().zip(written.lines()).filter(|(a, b)| a != b).map(|(_, b)| b).collect();
    assert_eq!(differ.len(), 2, "{written}");
    assert!(written.starts_with("# comments stay\n") && differ[0].ends_with("} # the guess"), "{written}");
    assert_eq!(folder.run("check out.yaml").code, 0);

    let said = folder.run(line);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("out.yaml exists; give --force"), "{said:?}");
    assert_eq!(folder.read("out.yaml"), written);
    assert_eq!(folder.run(&format!("{line} --force --seed 0")).code, 0);
    assert_eq!(folder.read("out.yaml"), written, "same seed, same bits");
    // Nothing is left beside it.
    let mut names: Vec<String> =
        fs::read_dir(&folder.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["model.yaml", "out.yaml", "test.yaml"]);
    let said = folder.run("update model.yaml test.yaml -o nowhere/out.yaml");
    assert_eq!(said.code, 2);
    assert!(said.err.contains("cannot write nowhere/out.yaml"), "{said:?}");
}

/// A model that is written into another folder finds its mesh from there.
#[test]
fn a_model_in_another_folder_keeps_its_mesh() {
    let folder = Folder::new("moved");
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    for name in ["plate_wing.yaml", "plate_wing.msh"] {
        fs::copy(models.join(name), folder.0.join(name)).unwrap();
    }
    fs::create_dir_all(folder.0.join("new/deep")).unwrap();
    let said = folder.run("add plate_wing.yaml point-mass@trailing -o new/deep/heavier.yaml");
    assert_eq!(said.code, 0, "{said:?}");
    let written = folder.read("new/deep/heavier.yaml");
    assert!(written.contains("file: \"../../plate_wing.msh\""), "{written}");
    // And back beside it, and in the folder itself, where nothing changes.
    let said = folder.run("add new/deep/heavier.yaml point-mass@leading -o back.yaml");
    assert_eq!(said.code, 0, "{said:?}");
    assert!(folder.read("back.yaml").contains("file: \"plate_wing.msh\""), "{}", folder.read("back.yaml"));
    let said = folder.run("add plate_wing.yaml point-mass@leading -o beside.yaml");
    assert_eq!(said.code, 0, "{said:?}");
    assert!(folder.read("beside.yaml").contains("  file: plate_wing.msh\n"));
}

#[test]
fn a_fit_that_falls_short_is_1() {
    let folder = Folder::new("short");
    // Three modes of a model with two: one stays without a partner.
    let third = "  - {frequency: 40 Hz, source: made, shape: {real: [0.5, 0.5]}}\n";
    let more: String = [third; 4].concat();
    folder.write("more.yaml", format!("{TEST}{more}"));
    let said = folder.run("update model.yaml more.yaml --budget 200 --json");
    assert_eq!(said.code, 1, "{said:?}");
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert!(!json["unpaired_test"].as_array().unwrap().is_empty());
}

/// A test says in which configuration of the model it was made: here with a heavier tip.
#[test]
fn a_test_names_its_configuration() {
    let folder = Folder::new("configuration");
    let more = "configurations: {loaded: {masses: {ballast: {node: tip, mass: 1 kg}}}}\n";
    folder.write("model.yaml", format!("{MODEL}{more}"));
    folder.write("loaded.yaml", TEST.replace("name: made up", "name: made up\nconfiguration: loaded"));
    folder.write("laoded.yaml", TEST.replace("name: made up", "name: made up\nconfiguration: laoded"));
    let hz = |test: &str| {
        folder.json(&format!("compare model.yaml {test} --frequency-window 9 --json"))["pairs"][0]["model_hz"]
            .as_f64()
            .unwrap()
    };
    assert!(hz("loaded.yaml") < 0.8 * hz("test.yaml"));
    let said = folder.run("compare model.yaml laoded.yaml");
    assert_eq!(said.code, 2);
    assert!(
        said.err.contains(
            "laoded.yaml:3:1: error: configuration: the model has no configuration `laoded` (it has: loaded); did you mean `loaded`?"
        ),
        "{said:?}"
    );
}

/// Two tests of one model, in two configurations, fitted at once; an objective file; samples of the posterior.
#[test]
fn several_tests_an_objective_and_a_posterior() {
    let folder = Folder::new("several");
    let more = "configurations: {loaded: {masses: {ballast: {node: tip, mass: 1 kg}}}}\n";
    folder.write("model.yaml", format!("{MODEL}{more}"));
    folder.write("loaded.yaml", TEST.replace("name: made up", "name: with ballast\nconfiguration: loaded"));
    let json = folder.json("compare model.yaml test.yaml loaded.yaml --frequency-window 9 --json");
    assert_eq!(json["tests"].as_array().unwrap().len(), 2);
    let json = folder.json("update model.yaml test.yaml loaded.yaml --json");
    assert_eq!(json["tests"][1]["configuration"], "loaded");
    assert_eq!(folder.json("update model.yaml test.yaml --json")["tests"].as_array().unwrap().len(), 1);
    let said = folder.run("update model.yaml test.yaml loaded.yaml");
    assert!(said.out.contains("after: with ballast") && said.out.contains("90 % interval"), "{said:?}");

    folder.write("objective.yaml", "terms: {frequency: 1}\nloss: {huber: 2}\nregularization: {weight: 0.5}\n");
    let json = folder.json("update model.yaml test.yaml --objective objective.yaml --json");
    assert_eq!(json["regularization_weight"], 0.5);
    folder.write("objective.yaml", "terms: {frequenzy: 1}\n");
    let said = folder.run("update model.yaml test.yaml --objective objective.yaml");
    assert_eq!(said.code, 2);
    assert!(
        said.err.contains("objective.yaml:1:9: error: terms.frequenzy") && said.err.contains("`frequency`"),
        "{said:?}"
    );

    let json = folder.json("sample model.yaml test.yaml --samples 100 -o samples.csv --json");
    assert_has(&json, &["parameters", "log_evidence", "log_evidence_se", "samples"]);
    let rows = folder.read("samples.csv");
    assert_eq!(rows.lines().count(), 101);
    assert!(rows.lines().next().unwrap().ends_with(",cost"));
}

/// What is tried can be narrowed, a search can be cut short, and then says so.
#[test]
fn a_diagnosis_can_be_narrowed_and_cut_short() {
    let folder = Folder::new("narrowed");
    let twin = "twin model.yaml -o t.yaml --modes 4 --noise-frequency 0.3% --noise-shape 2% --set lump=250g";
    assert_eq!(folder.run(twin).code, 0);
    folder.write(
        "light.yaml",
        MODEL
            .replace("masses: {tip_mass: {node: tip, mass: lump}}\n", "")
            .replace("  lump: {value: 100 g, bounds: [0 g, 300 g]}\n", ""),
    );
    let narrow =
        folder.json("diagnose light.yaml t.yaml --no-faults --effects point-mass --places tip --json -o d.json");
    assert_eq!((&narrow["screened_effects"], &narrow["screened_faults"]), (&1.into(), &0.into()));
    assert_eq!(narrow["hypotheses"][0]["id"], "point-mass@tip", "{narrow}");
    let kept: Value = serde_json::from_str(&folder.read("d.json")).unwrap();
    assert_eq!(kept, narrow);
    assert!(narrow["is_partial"].is_null());
    let cut = folder.run("diagnose light.yaml t.yaml --budget 1ms --trace");
    assert!(
        cut.code == 1
            && cut.out.contains("stopped before its end")
            && cut.out.contains("nothing that was tried by then"),
        "{cut:?}"
    );
    for (options, word) in [
        ("--effects point-mas", "did you mean `point-mass`?"),
        ("--places tipp", "did you mean `tip`?"),
        ("--budget 0s", "a time above zero"),
        ("--budget 3kg", "--budget"),
    ] {
        let said = folder.run(&format!("diagnose light.yaml t.yaml {options}"));
        assert!(said.code == 2 && said.err.contains(word), "{options}: {said:?}");
    }
}

/// Synthetic functions of a stiffer beam: with modes, alone, and with channels that are nowhere.
#[test]
fn functions_of_a_test_enter_the_fit() {
    let folder = Folder::new("functions");
    let twin = "twin model.yaml --sensors test.yaml -o t.yaml --frf f.csv --band 1 40 --lines 40 --modes 2 --set EI=26";
    assert_eq!(folder.run(twin).code, 0);
    let (modes, functions) = (folder.read("t.yaml"), folder.read("f.csv"));
    folder.write("fit.yaml", modes.clone() + "frfs: {files: [f.csv], sd: 5 %}\n");
    let ei = |u: &Value| u["parameters"][0]["after"].as_f64().unwrap();
    let u = folder.json("update model.yaml fit.yaml --json");
    assert!((ei(&u) - 26.0).abs() < 0.1, "{u:#}");
    assert_eq!(u["tests"][0]["functions_of_fit"]["values"], 80);
    let said = folder.run("compare model.yaml fit.yaml");
    assert!(said.err.contains("twice the median of the measured damping ratios"), "{}", said.err);
    assert!(said.out.contains("functions: 80 amplitudes, ") && said.out.contains("mean CSAC"), "{}", said.out);

    let head = modes.split("modes:").next().unwrap();
    folder.write("alone.yaml", format!("{head}frfs: {{files: [f.csv], sd: 5 %, loss_factor: 0.02}}\n"));
    let u = folder.json("update model.yaml alone.yaml --json");
    assert!((ei(&u) - 26.0).abs() < 0.1, "{u:#}");
    // The functions are data enough for a diagnosis; there are no modes to pair.
    let told = folder.run("diagnose model.yaml alone.yaml");
    assert!(told.code == 0 && told.out.contains("adequate") && !told.out.contains("pairs of"), "{told:?}");

    for (from, to, code, text) in [
        (
            "tip.+z",
            "top.+z",
            2,
            "`top`, which is neither a sensor of the test nor a node of the model; did you mean `tip`?",
        ),
        ("tip.+z", "tip.+y", 0, "channel `tip` along +y reads no motion of the model; it is left out"),
        ("tip.+z", "tip.+x", 0, "channel `tip` along +x reads no motion"),
        ("f.csv", "g.csv", 2, "cannot read `g.csv`"),
    ] {
        folder.write("f.csv", functions.replace(from, to));
        folder.write("wrong.yaml", (modes.clone() + "frfs: {files: [f.csv], sd: 5 %}\n").replace(from, to));
        let said = folder.run("compare model.yaml wrong.yaml");
        let line = format!("wrong.yaml:{}:", modes.lines().count() + 1);
        assert!(said.err.contains(text) && said.err.contains(&line), "{to}: {}", said.err);
        assert_eq!(said.code, code, "{to}");
    }

    // Of functions without a unit, with a gap, without a line.
    let rows: Vec<&str> = functions.lines().filter(|l| !l.starts_with('#')).collect();
    let [names, units, first, others @ ..] = rows.as_slice() else { panic!("{functions}") };
    let gap: Vec<&str> = first.split(',').enumerate().map(|(i, cell)| if i == 1 { "" } else { cell }).collect();
    let unit = units.split(',').nth(1).unwrap();
    for (table, frfs, code, text) in [
        (vec![*names, first], "", 2, "does not state the unit of its functions (option `unit`"),
        (vec![*names, first], "unit: kg, ", 2, "`kg` is not a unit of response over force"),
        (vec![*names, first], &format!("unit: {unit}, "), 0, "functions: "),
        (vec![*names, first], "units: feet, ", 2, "`feet` is not a system of units; there are SI"),
        (vec![*names, *units, &gap.join(","), others[0]], "", 0, "values left out: empty or no numbers"),
        (vec![*names, *units], "", 2, "these functions have no line"),
        (
            vec![*names, *units, first],
            "bands: [[900 Hz, 990 Hz]], ",
            2,
            "no line of the functions lies in 900 Hz to 990 Hz",
        ),
    ] {
        folder.write("f.csv", table.join("\n"));
        folder.write("open.yaml", format!("{modes}frfs: {{files: [f.csv], {frfs}sd: 5 %}}\n"));
        let said = folder.run("compare model.yaml open.yaml");
        assert!(said.err.contains(text) || said.out.contains(text), "{frfs}: {} {}", said.err, said.out);
        assert_eq!(said.code, code, "{frfs}: {}", said.err);
    }
    assert!(folder.run("compare model.yaml f.csv").err.contains("f.csv is not a test file: `retune identify f.csv"));
    assert!(folder.run("update model.yaml t.yaml ./t.yaml").err.contains("given twice"));
}

#[test]
fn a_configuration_that_a_test_forgets_is_named() {
    let folder = Folder::new("forgotten");
    folder.write(
        "two.yaml",
        MODEL.to_string() + "configurations: {loaded: {masses: {weight: {node: tip, mass: 300 g}}}}\n",
    );
    assert_eq!(folder.run("twin two.yaml --configuration loaded --sensors test.yaml --modes 2 -o t.yaml").code, 0);
    let twin = folder.read("t.yaml");
    let said = folder.run("compare two.yaml t.yaml");
    assert!(!said.err.contains("names no configuration"), "{}", said.err);
    let forgotten: Vec<&str> = twin.lines().filter(|l| !l.starts_with("configuration:")).collect();
    let forgotten = forgotten.join("\n");
    assert!(twin.contains("\nconfiguration: loaded\n"), "{twin}");
    folder.write("t.yaml", forgotten);
    let said = folder.run("compare two.yaml t.yaml");
    assert!(said.err.contains("is `configuration: loaded` missing?"), "{}", said.err);
}

#[test]
fn an_edit_overwrites_no_other_file() {
    let folder = Folder::new("edit");
    let said = folder.run("add model.yaml point-mass@tip -o test.yaml");
    assert!(said.code == 2 && said.err.contains("give --force"), "{said:?}");
    assert_eq!(folder.read("test.yaml"), TEST);
    assert_eq!(folder.run("add model.yaml point-mass@tip -o model.yaml").code, 0);
    assert_eq!(folder.run("undo model.yaml -o test.yaml").code, 2);
    assert_eq!(folder.run("undo model.yaml").code, 0);
    assert_eq!(folder.read("model.yaml"), MODEL);
}

#[test]
fn nothing_free_is_said() {
    let folder = Folder::new("fixed");
    folder.write("fixed.yaml", MODEL.replace(", bounds: [5 N m2, 40 N m2]", "").replace(", bounds: [0 g, 300 g]", ""));
    let said = folder.run("update fixed.yaml test.yaml");
    assert_eq!(said.code, 2);
    assert!(said.err.contains("no parameter of the model has bounds"), "{said:?}");
}

#[test]
fn help_has_examples_and_exit_codes() {
    let folder = Folder::new("help");
    let said = folder.run("--help");
    assert_eq!(said.code, 0);
    assert!(said.out.contains("Exit codes: 0 done") && said.out.contains("Examples:"), "{said:?}");
    for command in ["check", "modes", "compare", "update", "sample", "schema", "list", "explain", "completions"] {
        let said = folder.run(&format!("{command} --help"));
        assert_eq!(said.code, 0);
        assert!(said.out.contains("Example") && said.out.contains(&format!("retune {command}")), "{command}: {said:?}");
    }
    assert!(folder.run("--version").out.starts_with("retune "));
}

#[test]
fn lists_explanations_schemas_and_completions_are_printed() {
    let folder = Folder::new("lists");
    for list in ["elements", "residuals", "optimizers"] {
        let json = folder.json(&format!("list {list} --json"));
        for member in json["members"].as_array().unwrap() {
            let name = member["name"].as_str().unwrap();
            let said = folder.run(&format!("explain {name}"));
            assert_eq!(said.code, 0, "{name}: {said:?}");
            assert!(said.out.starts_with(name) && !said.out.contains('…'), "{name}: {said:?}");
        }
    }
    for (which, word) in [("model", "beams"), ("test", "sensors")] {
        let schema = folder.json(&format!("schema {which}"));
        assert!(schema["properties"][word].is_object(), "{which}");
    }
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let said = folder.run(&format!("completions {shell}"));
        assert_eq!(said.code, 0);
        assert!(said.out.contains("retune") && said.out.contains("compare"), "{shell}");
    }
}

/// `Said::of` refuses escapes in pipes; here colour is asked for as loudly as the environment can.
#[test]
fn pipes_and_no_color_have_no_escapes() {
    let folder = Folder::new("color");
    folder.write("wrong.yaml", MODEL.replace("[root, middle, tip]", "[root, midle, tip]"));
    for line in ["check model.yaml", "check wrong.yaml", "compare model.yaml test.yaml", "modes model.yaml", "--help"] {
        for (variable, value) in [("NO_COLOR", "1"), ("TERM", "xterm-256color")] {
            Said::of(line, &folder.command(line).env(variable, value).output().unwrap());
        }
    }
}

/// A reader that goes away, as `| head -1`: no panic, no message.
#[cfg(unix)]
#[test]
fn a_closed_pipe_ends_quietly() {
    let folder = Folder::new("pipe");
    let mut child = folder.command("schema model").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_ne!(output.status.code(), Some(70));
}

/// Ctrl-C: the search stops, the best point so far is written, and the exit code is that of a finished run.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_best_point() {
    let folder = Folder::new("interrupt");
    let line = "update model.yaml test.yaml -o out.yaml --json --cost paper --optimizer";
    let endless =
        "{differential-evolution: {strategy: classic, population: 100000, generations: 1000000000, tolerance: 0}}";
    let child = folder.command(line).arg(endless).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signal.success());
    let output = child.wait_with_output().unwrap();
    let said = Said::of(line, &output);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.err.contains("stopping"), "{said:?}");
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert!(json["cost_after"].as_f64().unwrap() < json["cost_before"].as_f64().unwrap());
    assert!(json["termination"].as_str().unwrap().contains("stopped"), "{}", json["termination"]);
    assert!(Path::new(&folder.0.join("out.yaml")).exists());
    assert_eq!(folder.run("check out.yaml").code, 0);
}

/// Bytes of a checkpoint that hold records: behind them stand zeros.
#[cfg(unix)]
fn recorded(path: &Path) -> usize {
    fs::read(path).map_or(0, |bytes| bytes.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1))
}

/// SIGKILL at random moments, again and again, and `--resume` after each: the same final file and the same report as in a run
/// that nothing disturbed. The search asks for batches, and the killed ones run on one thread and on two in turn.
#[cfg(unix)]
#[test]
fn killed_and_resumed_runs_end_with_the_same_file() {
    let folder = Folder::new("killed");
    let line = |name: &str| {
        format!("update model.yaml test.yaml -o {name}.yaml --json --seed 7 --cost paper --checkpoint {name}.state")
    };
    let method = "[{differential-evolution: {strategy: classic, population: 200, generations: 1500, tolerance: 0}}, nelder-mead]";
    let start = |name: &str, more: &[&str], threads: &str| {
        let mut command = folder.command(&line(name));
        command.arg("--optimizer").arg(method).args(more).env("RAYON_NUM_THREADS", threads);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let whole = Said::of("undisturbed", &start("whole", &[], "2").wait_with_output().unwrap());
    assert_eq!(whole.code, 0, "{whole:?}");
    let size = recorded(&folder.0.join("whole.state"));

    let state = folder.0.join("killed.state");
    let resume = |exists: bool| -> &[&str] { if exists { &["--resume"] } else { &[] } };
    let mut kills = 0;
    // Any sequence does: the moment is as random as the scheduler makes it.
    let mut random = std::process::id() as usize;
    for round in 0..6 {
        let mut child = start("killed", resume(state.exists()), if round % 2 == 0 { "1" } else { "2" });
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let progress = recorded(&state) + (random >> 33) % (size / 4);
        while recorded(&state) < progress && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1 + (random as u64 >> 40) % 7));
        }
        let is_running = child.try_wait().unwrap().is_none();
        child.kill().unwrap();
        child.wait().unwrap();
        if !is_running {
            break;
        }
        kills += 1;
        assert!(!folder.0.join("killed.yaml").exists() || recorded(&state) == size, "an output before the end");
    }
    assert!(kills >= 2, "{kills} kills");
    let done = folder.0.join("killed.yaml").exists();
    if !done {
        let last = Said::of("resumed", &start("killed", resume(true), "2").wait_with_output().unwrap());
        assert_eq!(last.code, 0, "{last:?}");
        let json = |said: &Said| {
            let mut value: Value = serde_json::from_str(&said.out).unwrap();
            value.as_object_mut().unwrap().retain(|key, _| !["seconds", "output", "written"].contains(&key.as_str()));
            value
        };
        assert_eq!(json(&last), json(&whole));
    }
    assert_eq!(folder.read("killed.yaml"), folder.read("whole.yaml"));
    assert_eq!(fs::read(&state).unwrap(), fs::read(folder.0.join("whole.state")).unwrap());
}

const SPRINGS: &str = "\
retune: 1
name: Two masses on springs
active_dofs: [uz]
parameters:
  k1: {value: 3000 N/m, bounds: [1000 N/m, 9000 N/m]}
  k2: {value: 900 N/m, bounds: [100 N/m, 3000 N/m]}
nodes: {a: [0, 0, 0], b: [1 m, 0, 0]}
springs: {g: {node: a, k: {uz: k1}}, ab: {nodes: [a, b], k: {uz: k2}}}
masses: {ma: {node: a, mass: 1 kg}, mb: {node: b, mass: 1 kg}}
";

const TWO_FREQUENCIES: &str = "\
retune_test: 1
name: t
sources: {a: {kind: measured, text: an example}}
modes:
  - {frequency: 4.398934 Hz, frequency_sd: 0.5 %, source: a}
  - {frequency: 11.516560 Hz, frequency_sd: 0.5 %, source: a}
";

/// (4000, 1000) and (2000, 2000) N/m give the same two frequencies.
#[test]
fn both_sets_of_parameters_are_told() {
    let folder = Folder::new("both-sets");
    folder.write("springs.yaml", SPRINGS).write("two.yaml", TWO_FREQUENCIES);
    let said = folder.run("update springs.yaml two.yaml");
    assert!(said.out.contains("another set of parameters fits as well") && said.err.is_empty(), "{said:?}");
    assert!(said.out.contains("one with the same cost"), "{said:?}");
    // Without stiffness there are no modes: the data say nothing there, which is not that any value fits.
    let open = SPRINGS
        .replace(
            "k1: {value: 3000 N/m, bounds: [1000 N/m, 9000 N/m]}",
            "k1: {value: 1e9 N/m, bounds: [0 N/m, 1e12 N/m]}",
        )
        .replace(
            "k2: {value: 900 N/m, bounds: [100 N/m, 3000 N/m]}",
            "k2: {value: 1e9 N/m, bounds: [0 N/m, 1e12 N/m]}",
        );
    folder.write("open.yaml", &open);
    let said = folder.run("update open.yaml two.yaml --optimizer levenberg-marquardt");
    let flat = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains("but near these values they set no limit inside the bounds of: k1, k2"), "{said:?}");
    let json = folder.json("update springs.yaml two.yaml --json");
    let other = &json["alternatives"][0];
    let values = [&json["parameters"][0]["after"], &other["parameters"][0]["after"]].map(|v| v.as_f64().unwrap());
    assert!((values[0] - values[1]).abs() > 1900.0 && other["parameters"][1]["interval"][0].is_number(), "{json:#}");
    let said = folder.run("sample springs.yaml two.yaml");
    assert!(said.out.contains("the posterior has 2 peaks") && said.out.contains("(standard error)"), "{said:?}");
}

/// E and I act through their product: no standard deviation, and null in place of a correlation.
#[test]
fn what_is_not_seen_alone_has_no_correlation() {
    let folder = Folder::new("not-alone");
    let product = "E: {value: 2e9 Pa, bounds: [1e9 Pa, 4e9 Pa]}\n  I: {value: 1e-8 m4, bounds: [0.5e-8 m4, 2e-8 m4]}";
    let model = MODEL.replace("EI: {value: 20 N m2, bounds: [5 N m2, 40 N m2]}", product);
    folder.write("product.yaml", model.replace("EIy: EI", "E: E, Iy: I"));
    let json = folder.json("update product.yaml test.yaml --json");
    let e = &json["parameters"][0];
    assert!(e["correlations"]["I"].is_null() && keys(&e["correlations"]).contains(&"I"), "{e}");
    assert!(e["sd"].is_null() && e["why_no_sd"] == "not seen alone", "{e}");
    let said = folder.run("update product.yaml test.yaml");
    let line = "no standard deviation and no correlation: E (not seen alone), I (not seen alone)";
    assert!(said.out.contains(line), "{said:?}");
}

/// What a verb says of one test it says of each, and a sensor that two tests have is one.
#[test]
fn verbs_that_read_a_test_read_several() {
    let folder = Folder::new("each-test");
    let more = "configurations: {loaded: {masses: {ballast: {node: tip, mass: 1 kg}}}}\n";
    folder.write("model.yaml", format!("{MODEL}{more}"));
    folder.write("loaded.yaml", TEST.replace("name: made up", "name: with ballast\nconfiguration: loaded"));
    let one = folder.json("sensitivity model.yaml test.yaml --json");
    let both = folder.json("sensitivity model.yaml test.yaml loaded.yaml --json");
    let hz = |of: &Value| of["modes"][0]["frequency_hz"].as_f64().unwrap();
    assert_eq!(both["tests"][0], one);
    // 1 kg at the tip: the first frequency of the configuration is lower.
    assert!(hz(&both["tests"][1]) < 0.9 * hz(&one), "{both}");
    let said = folder.run("sensitivity model.yaml test.yaml loaded.yaml");
    assert!(said.code == 0 && said.out.contains("test   with ballast"), "{said:?}");

    let page = folder.json("report model.yaml test.yaml loaded.yaml --json");
    let warnings = page["meta"]["warnings"].to_string();
    assert!(warnings.contains("2 tests together (made up, with ballast)"), "{warnings}");
    assert_eq!(page["meta"]["files"].as_array().unwrap().len(), 3);
    let said = folder.run("report model.yaml test.yaml test.yaml");
    assert!(said.code == 2 && said.err.contains("given twice"), "{said:?}");

    let said = folder.run("pretest model.yaml -n 2 --sensors 2 --test test.yaml loaded.yaml");
    assert!(said.code == 0 && said.out.contains("the 2 sensors given"), "{said:?}");
}

/// `--json` prints, whatever the verb, and what it prints is JSON alone.
#[test]
fn json_means_one_thing() {
    let folder = Folder::new("json");
    let printed = folder.json("report model.yaml test.yaml --json --data page.json");
    let kept: Value = serde_json::from_str(&folder.read("page.json")).unwrap();
    assert_eq!(printed["comparison"], kept["comparison"]);
    assert!(printed["comparison"].is_object() && printed["schema"].is_number(), "{printed}");
    let said = folder.run("report model.yaml test.yaml -o page.html --json");
    assert!(
        said.code == 0 && serde_json::from_str::<Value>(&said.out).is_ok() && folder.read("page.html").len() > 1000
    );
}

/// A sensor of `identify` without a model, a unit as it is often written, a patch with a mistake: what to do is said.
#[test]
fn a_way_out_is_told() {
    let folder = Folder::new("ways-out");
    let unplaced = TEST.replace("{node: tip, direction", "{node: p1, position: [1 m, 0 m, 0 m], direction");
    folder.write("gvt.yaml", unplaced);
    let said = folder.run("compare model.yaml gvt.yaml");
    assert!(
        said.code == 2 && said.err.contains("hint: ") && said.err.contains("retune map model.yaml gvt.yaml"),
        "{said:?}"
    );
    folder.write("hidden.yaml", "masses:\n  more: {node: tip, mas: 1 kg}\n");
    let said = folder.run("twin model.yaml -o t.yaml --patch hidden.yaml");
    assert!(said.code == 2 && said.err.contains("hidden.yaml:2:") && said.err.contains("`mass`"), "{said:?}");
    folder.write("hidden.yaml", "supports:\n  clamp: {node: root, compliance: {ry: 2e-5 rad/Nm}}\n");
    let said = folder.run("twin model.yaml -o t.yaml --patch hidden.yaml");
    assert!(said.code == 2 && said.err.contains("hidden.yaml:2:") && said.err.contains("write `/(N m)`"), "{said:?}");
    // Of many mistakes the first are enough.
    let sensors: Vec<String> = (0..40).map(|i| format!("  s{i}: {{node: n{i}, direction: +z}}\n")).collect();
    let placed = "  there: {node: tip, direction: +z}\n";
    let sensors = sensors.concat() + placed;
    folder.write("many.yaml", format!("retune_test: 1\nname: t\nsources: {{s: {{kind: synthetic, text: a}}}}\nsensors:\n{sensors}modes: [{{frequency: 3 Hz, source: s}}]\n"));
    let said = folder.run("compare model.yaml many.yaml");
    assert!(said.code == 2 && said.err.contains("... and 20 more\n40 errors"), "{said:?}");
    assert!(!said.err.contains("hint:"), "{said:?}");
}
