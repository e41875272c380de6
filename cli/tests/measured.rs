//! The verbs on measurements as a user meets them: `twin`, `identify`, `health`, `map`, with every kind of file.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A cantilever of six bays, 0.6 m, with its first four bending modes below 1,000 Hz.
const MODEL: &str = "\
retune: 1
name: strip
active_dofs: [uz, ry]
parameters:
  EI: {value: 20 N m2, bounds: [5 N m2, 40 N m2]}
nodes: {n0: [0, 0, 0], n1: [0.1, 0, 0], n2: [0.2, 0, 0], n3: [0.3, 0, 0], n4: [0.4, 0, 0], n5: [0.5, 0, 0], n6: [0.6, 0, 0]}
beams: {strip: {chain: [n0, n1, n2, n3, n4, n5, n6], properties: {EIy: EI, mass_per_length: 0.8 kg/m}}}
supports: {clamp: {node: n0}}
";

/// Sensors along the strip; p3 above its node and p6 beyond the tip by rigid arms, p5 inside an element. A file of functions
/// holds positions, no arms: all of these have their own place as the nearest one, so that `map` finds them again.
const SENSORS: &str = "\
retune_test: 1
name: sensors
sources: {}
sensors:
  p1: {node: n1, direction: +z}
  p2: {node: n2, direction: +z}
  p3: {node: n3, offset: [0 m, 0 m, 20 mm], direction: +z}
  p4: {node: n4, direction: +z}
  p5: {element: strip.5, fraction: 0.5, direction: +z}
  p6: {node: n6, offset: [30 mm, 0 m, 0 m], direction: -z}
";

struct Folder(PathBuf);

#[derive(Debug)]
struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("retune-measured-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("model.yaml"), MODEL).unwrap();
        fs::write(path.join("sensors.yaml"), SENSORS).unwrap();
        Self(path)
    }

    fn run(&self, line: &str) -> Said {
        self.words(&line.split_whitespace().collect::<Vec<_>>())
    }

    fn words(&self, words: &[&str]) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_retune"));
        command.current_dir(&self.0).args(words).stdin(Stdio::null()).env("COLUMNS", "80");
        let output = command.output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let said =
            Said { code: output.status.code().unwrap_or(-1), out: text(&output.stdout), err: text(&output.stderr) };
        assert!(!said.err.contains("panicked") && said.code != 70, "{words:?}: {said:?}");
        said
    }

    fn done(&self, line: &str) -> Said {
        let said = self.run(line);
        assert_eq!(said.code, 0, "{line}: {said:?}");
        said
    }

    fn json(&self, line: &str) -> Value {
        let said = self.run(line);
        serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{line}: {e}\n{}{}", said.out, said.err))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Functions of the strip over 10 to 600 Hz with 0.5 % noise, and what the model says of its modes.
    fn functions(&self, file: &str) -> Vec<f64> {
        self.done(&format!(
            "twin model.yaml --sensors sensors.yaml --frf {file} --exciter p6 --band 10 600 --lines 2049 --noise-response 0.5% --seed 3"
        ));
        let modes = self.json("modes model.yaml -n 8 --json");
        let all = modes["modes"].as_array().unwrap().iter().map(|m| m["frequency_hz"].as_f64().unwrap());
        all.filter(|f| (10.0..600.0).contains(f)).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn frequencies(json: &Value) -> Vec<f64> {
    json["modes"].as_array().unwrap().iter().map(|m| m["frequency_hz"].as_f64().unwrap()).collect()
}

fn codes(json: &Value) -> Vec<String> {
    json["findings"].as_array().unwrap().iter().map(|f| f["code"].as_str().unwrap().to_string()).collect()
}

fn data(folder: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let path = std::env::var_os("RETUNE_DATA").map_or(beside, PathBuf::from).join(folder);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there; set RETUNE_DATA to the folder of the real data", path.display());
    None
}

#[test]
fn every_method_finds_the_modes_of_the_twin() {
    let folder = Folder::new("methods");
    let truth = folder.functions("f.unv");
    for method in ["plscf", "quadrature", "circle"] {
        let json = folder.json(&format!("identify f.unv --method {method} --json"));
        let found = frequencies(&json);
        assert_eq!(found.len(), truth.len(), "{method}: {found:?} for {truth:?}");
        for (f, t) in found.iter().zip(&truth) {
            assert!((f / t - 1.0).abs() < 1e-3, "{method}: {found:?} for {truth:?}");
        }
        assert_eq!(json["is_synthetic"], true);
        let said = folder.done(&format!("identify f.unv --method {method} -o {method}.yaml --force"));
        assert!(said.out.lines().all(|l| l.chars().count() <= 80), "{}", said.out);
        let test = folder.read(&format!("{method}.yaml"));
        assert!(test.contains("kind: synthetic") && !test.contains("kind: measured"), "{test}");
        // Sensors of an identification stand where the geometry has them; places come from the map.
        folder.done(&format!("map model.yaml {method}.yaml -o {method}_placed.yaml"));
        let pairs = folder.json(&format!("compare model.yaml {method}_placed.yaml --json"));
        assert_eq!(pairs["pairs"].as_array().unwrap().len(), truth.len(), "{method}: {pairs}");
        for p in pairs["pairs"].as_array().unwrap() {
            assert!(p["mac"].as_f64().unwrap() > 0.999, "{method}: {p}");
        }
    }
}

#[test]
fn tables_and_universal_files_say_the_same() {
    let folder = Folder::new("formats");
    folder.functions("f.unv");
    folder.functions("f.csv");
    let (a, b) = (folder.json("identify f.unv --json"), folder.json("identify f.csv --json"));
    for (x, y) in frequencies(&a).iter().zip(&frequencies(&b)) {
        assert!((x / y - 1.0).abs() < 1e-9, "{x} {y}");
    }
    assert_eq!(b["is_synthetic"], true);
}

/// An array of doubles as NumPy writes it, version 1.
fn npy(kind: &str, shape: &str, values: &[f64]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// A real matrix as MATLAB version 5 holds it, uncompressed: (name, rows, columns, values by columns).
fn mat(variables: &[(&str, usize, usize, Vec<f64>)]) -> Vec<u8> {
    let mut bytes = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    bytes.extend([0, 1, b'I', b'M']);
    let element = |kind: u32, data: Vec<u8>| {
        let mut out = kind.to_le_bytes().to_vec();
        out.extend(u32::try_from(data.len()).unwrap().to_le_bytes());
        let padded = data.len().div_ceil(8) * 8;
        out.extend(data);
        out.resize(8 + padded, 0);
        out
    };
    for (name, rows, columns, values) in variables {
        let mut body = element(6, [6_u32.to_le_bytes(), 0_u32.to_le_bytes()].concat());
        let dims = [*rows, *columns].map(|n| u32::try_from(n).unwrap().to_le_bytes()).concat();
        body.extend(element(5, dims));
        body.extend(element(1, name.as_bytes().to_vec()));
        body.extend(element(9, values.iter().flat_map(|v| v.to_le_bytes()).collect()));
        bytes.extend(element(14, body));
    }
    bytes
}

#[test]
fn arrays_are_read_when_their_questions_are_answered() {
    let folder = Folder::new("arrays");
    // One oscillator of 1 kg, 20 Hz, 1 %, seen in three channels.
    let f: Vec<f64> = (1..=800).map(|k| 0.1 * f64::from(k)).collect();
    let h: Vec<f64> = f
        .iter()
        .flat_map(|f| {
            let (w, w0) = (std::f64::consts::TAU * f, std::f64::consts::TAU * 20.0);
            let (re, im) = (w0 * w0 - w * w, 0.02 * w0 * w);
            let scale = -w * w / (re * re + im * im);
            [1.0, 0.5, -0.3].into_iter().flat_map(move |c| [c * scale * re, -c * scale * im])
        })
        .collect();
    folder.write("f.npy", npy("<f8", "(800,)", &f));
    folder.write("h.npy", npy("<c16", "(800, 3)", &h));
    let said = folder.run("identify f.npy h.npy");
    assert!(said.code == 2 && said.err.contains("`--units`"), "{said:?}");
    let said = folder.run("identify f.npy h.npy --units SI");
    assert!(said.code == 2 && said.err.contains("`--quantity`"), "{said:?}");
    let line = "identify f.npy h.npy --units SI --quantity accelerance --direction +z";
    let found = folder.json(&format!("{line} --json"));
    let modes = frequencies(&found);
    assert!(modes.len() == 1 && (modes[0] / 20.0 - 1.0).abs() < 1e-6, "{modes:?}");
    folder.done(&format!("{line} -o test.yaml"));
    assert!(folder.read("test.yaml").contains("kind: measured"));
}

#[test]
fn shapes_of_matlab_and_of_tables_go_through_health_identify_and_map() {
    let folder = Folder::new("shapes");
    let shape = |k: f64| -> Vec<f64> { (1..=9).map(|i| (k * f64::from(i) / 9.0).sin()).collect() };
    folder.write("a.mat", mat(&[("freq", 1, 1, vec![5.0]), ("phi", 9, 1, shape(1.5))]));
    folder.write("b.mat", mat(&[("freq", 1, 1, vec![12.0]), ("phi", 9, 1, shape(4.6))]));
    let said = folder.run("health a.mat b.mat");
    assert!(said.code == 2 && said.err.contains("`--direction`"), "{said:?}");
    folder.done("health a.mat b.mat --direction +z");
    folder.done("identify a.mat b.mat --direction +z -o test.yaml");
    assert_eq!(folder.read("test.yaml").matches("frequency:").count(), 2);
    folder.write("short.mat", mat(&[("freq", 1, 1, vec![5.0]), ("phi", 3, 1, vec![1.0, 2.0, 3.0])]));
    let said = folder.run("health a.mat short.mat --direction +z");
    assert!(said.code == 2 && said.err.contains("3 points, the other files have 9"), "{said:?}");
    // Sets of modes, in one file, with damping; a scalar beside a vector is none.
    let both = [shape(1.5), shape(4.6)].concat();
    let set = [("freqExp", 2, 1, vec![5.0, 12.0]), ("psiExp_m", 9, 2, both), ("dampExp", 1, 2, vec![0.01, 0.02])];
    folder.write("set.mat", mat(&set));
    folder.done("identify set.mat --direction +z -o set.yaml");
    let text = folder.read("set.yaml");
    assert!(text.contains("frequency: 12.0 Hz") && text.contains("damping: 0.02"), "{text}");
    folder.write("pair.mat", mat(&[("nrb", 1, 1, vec![6.0]), ("selist", 1, 2, vec![0.0, 100.0])]));
    let said = folder.run("identify pair.mat --direction +z");
    assert!(said.code == 2 && said.err.contains("nrb (1 x 1), selist (1 x 2)"), "{said:?}");
    folder.write("named.mat", mat(&[("x", 1, 1, vec![31.4159]), ("V", 9, 1, shape(1.5))]));
    let line = "identify named.mat --direction +z --variables frequency=x,shapes=V";
    let said = folder.run(line);
    assert!(said.code == 2 && said.err.contains("`--frequency-unit`"), "{said:?}");
    folder.done(&format!("{line} --frequency-unit rad/s -o named.yaml"));
    assert!(folder.read("named.yaml").contains("frequency: 4.9999"), "{}", folder.read("named.yaml"));
    folder.write("odd.mat", mat(&[("a", 2, 2, vec![1.0; 4])]));
    let said = folder.run("health odd.mat --direction +z");
    assert!(said.code == 2 && said.err.contains("a (2 x 2)") && said.err.contains("`--variables`"), "{said:?}");

    let rows: Vec<String> = (1..=6).map(|i| format!("{i},{i}00,0,0,+z,{},{}\n", i * i, 3 - i)).collect();
    let rows = rows.concat();
    folder.write("shapes.csv", format!("point,x_mm,y_mm,z_mm,direction,first 5 Hz,second 12.5 Hz\n{rows}"));
    folder.done("health shapes.csv");
    folder.done("identify shapes.csv --model model.yaml -o placed.yaml");
    assert_eq!(folder.read("placed.yaml").matches("node: n").count(), 6);
    folder.done("health placed.yaml");
    // The same points in a frame of their own: x towards the root, origin at the tip.
    folder.words(&[
        "identify",
        "shapes.csv",
        "--model",
        "model.yaml",
        "-o",
        "turned.yaml",
        "--frame",
        "{origin: [0.7 m, 0 m, 0 m], x: -x, z: +z}",
    ]);
    let turned = folder.read("turned.yaml");
    assert!(turned.find("node: n6").unwrap() < turned.find("node: n1").unwrap(), "{turned}");
    let said = folder.words(&["health", "shapes.csv", "--frame", "{x: +x}"]);
    assert!(said.code == 2 && said.err.contains("--frame"), "{said:?}");
}

#[test]
fn a_spectrum_without_force_gives_its_peaks() {
    let folder = Folder::new("lvm");
    let line = |k: i32| {
        let f = 0.5 * f64::from(k);
        let peak = |at: f64| 1.0 / (1.0 + ((f - at) / 0.4).powi(2));
        format!("{f}\t{:.4}\n", 20.0 * (0.001 + peak(12.0) + 0.3 * peak(75.0)).log10())
    };
    let head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tMulti\n***End_of_Header***\t\n\t\nChannels\t1\t\nY_Unit_Label\tdB(g)\t\nX_Dimension\tFrequency\t\nX0\t0\t\nDelta_X\t0.5\t\n***End_of_Header***\t\t\nX_Value\ttip\tComment\n";
    folder.write("s.lvm", format!("{head}{}", (0..400).map(line).collect::<String>()));
    let json = folder.json("identify s.lvm --json");
    let peaks = json["spectra"][0]["peaks"].as_array().unwrap();
    let at: Vec<f64> = peaks.iter().map(|p| p["frequency_hz"].as_f64().unwrap()).collect();
    assert!(at.len() == 2 && (at[0] - 12.0).abs() < 0.1 && (at[1] - 75.0).abs() < 0.1, "{at:?}");
    let one = folder.json("identify s.lvm --json --peak-height 50");
    assert_eq!(one["spectra"][0]["peaks"].as_array().unwrap().len(), 1, "{one}");
    folder.done("identify s.lvm -o peaks.yaml");
    assert_eq!(folder.read("peaks.yaml").matches("frequency:").count(), 2);
    let said = folder.run("health s.lvm");
    assert!(said.code == 2 && said.err.contains("no force was measured"), "{said:?}");
    folder.write("t.lvm", format!("{}{}", head.replace("Frequency", "Time"), (0..400).map(line).collect::<String>()));
    let said = folder.run("identify t.lvm");
    assert!(said.code == 2 && said.err.contains("record over time"), "{said:?}");
}

#[test]
fn a_twin_knows_parameters_patches_faults_and_seeds() {
    let folder = Folder::new("twin");
    let twin = |extra: &str| {
        folder.done(&format!("twin model.yaml --sensors sensors.yaml -o t.yaml --force --modes 3 {extra}"));
        folder.read("t.yaml")
    };
    let base = twin("");
    assert!(base.contains("SYNTHETIC") && base.contains("kind: synthetic"));
    // Without noise a seed changes its own mention and no number.
    assert_eq!(base.replace("seed 0", "seed 7"), twin("--seed 7"));
    assert_ne!(twin("--noise-frequency 1% --seed 1"), twin("--noise-frequency 1% --seed 2"));
    assert_eq!(twin("--noise-frequency 1% --seed 1"), twin("--noise-frequency 1% --seed 1"));
    let first = |text: &str| {
        let at = text.find("frequency:").unwrap() + 10;
        text[at..].split_whitespace().next().unwrap().parse::<f64>().unwrap()
    };
    // Twice the stiffness is √2 in frequency; a mass at the tip lowers it.
    assert!((first(&twin("--set EI=40N*m2")) / first(&base) - 2.0_f64.sqrt()).abs() < 1e-9);
    // A plain number is in the unit of the file, and what was understood is said; in another unit it is converted.
    let said = folder.run("twin model.yaml --sensors sensors.yaml -o t.yaml --force --modes 3 --set EI=40");
    assert!(said.code == 0 && said.err.contains("note: --set EI=40: read as 40.00 N m2"), "{said:?}");
    let plain = first(&folder.read("t.yaml"));
    folder.write(
        "kilo.yaml",
        MODEL.replace(
            "value: 20 N m2, bounds: [5 N m2, 40 N m2]",
            "value: 0.02 kN m2, bounds: [0.005 kN m2, 0.04 kN m2]",
        ),
    );
    let said = folder.run("twin kilo.yaml --sensors sensors.yaml -o t.yaml --force --modes 3 --set EI=0.04");
    assert!(said.code == 0 && said.err.contains("read as 0.04000 kN m2"), "{said:?}");
    assert!((first(&folder.read("t.yaml")) / plain - 1.0).abs() < 1e-9);
    folder.write("hidden.yaml", "masses: {ballast: {node: n6, mass: 50 g}}\n");
    let patched = twin("--patch hidden.yaml");
    assert!(first(&patched) < 0.9 * first(&base) && patched.contains("hidden.yaml"));
    assert!(twin("--fault sensor-sign@p2").contains("sensor-sign@p2"));
    for (extra, word) in [
        ("--set EJ=1", "did you mean `EI`?"),
        ("--set EI", "parameter=value"),
        ("--set EI=40000", "40000 N m2 is outside the bounds of `EI`, 5.000 N m2 to 40.00 N m2"),
        ("--set EI=4N*mm2", "is outside the bounds of `EI`"),
        ("--set EI=4GPa", "EI"),
        ("--fault sensor-sign@q2", "did you mean `p2`?"),
        ("--fault sensor-loud@p2", "there is no fault `sensor-loud`"),
        ("--patch nowhere.yaml", "nowhere.yaml"),
        ("--noise-shape 2kg", "--noise-shape"),
        ("--band 5 1", "--band"),
    ] {
        let said = folder.run(&format!("twin model.yaml --sensors sensors.yaml -o u.yaml {extra}"));
        assert!(said.code == 2 && said.err.contains(word), "{extra}: {said:?}");
        assert!(!folder.path("u.yaml").exists(), "{extra}");
    }
    assert_eq!(folder.run("twin model.yaml").code, 2);
    assert!(folder.run("twin model.yaml --frf f.unv").err.contains("--band"));
}

#[test]
fn faults_of_sensors_are_found_and_exit_with_1() {
    let folder = Folder::new("faults");
    let twin = |extra: &str| {
        folder.done(&format!(
            "twin model.yaml --sensors sensors.yaml --frf f.unv --force --exciter p6 --band 10 600 --lines 2049 --noise-response 0.5% {extra}"
        ));
    };
    twin("");
    let healthy = folder.json("health f.unv --json");
    assert_eq!(healthy["ok"], true, "{healthy}");
    assert_eq!(folder.run("health f.unv").code, 0);
    twin("--fault sensor-dead@p2");
    assert!(codes(&folder.json("health f.unv --json")).contains(&"sensor-dead".to_string()));
    assert_eq!(folder.run("health f.unv").code, 1);
    assert_eq!(folder.run("identify f.unv -o t.yaml").code, 1);
    assert!(folder.path("t.yaml").exists());
    twin("--fault sensor-sign@p6");
    assert!(codes(&folder.json("health f.unv --json")).contains(&"driving-point-reversed".to_string()));
    twin("");
    folder.done("twin model.yaml --sensors sensors.yaml --frf g.unv --exciter p6 --band 10 600 --lines 2049 --noise-response 0.5% --set EI=20.4N*m2 --seed 9");
    let runs = codes(&folder.json("health f.unv --against g.unv --json"));
    assert!(runs.contains(&"frequency-drift".to_string()), "{runs:?}");
}

#[test]
fn masses_of_sensors_load_the_model_when_asked() {
    let folder = Folder::new("masses");
    let sensors = folder
        .read("sensors.yaml")
        .replace("{node: n6, offset: [30 mm, 0 m, 0 m], direction: -z}", "{node: n6, direction: -z, mass: 20 g}");
    assert!(sensors.contains("20 g"));
    folder.write("sensors.yaml", &sensors);
    // The structure as it was tested carries the sensor; the model does not.
    folder.write("hidden.yaml", "masses: {transducer: {node: n6, mass: 20 g}}\n");
    folder.done("twin model.yaml --sensors sensors.yaml -o t.yaml --modes 3 --patch hidden.yaml");
    let bare = folder.run("compare model.yaml t.yaml");
    assert!(bare.code == 0 && bare.err.contains("20.0 g") && bare.err.contains("--sensor-masses"), "{bare:?}");
    let error = |json: &Value| json["pairs"][0]["error_percent"].as_f64().unwrap();
    assert!(error(&folder.json("compare model.yaml t.yaml --json")) > 1.0);
    assert!(error(&folder.json("compare model.yaml t.yaml --json --sensor-masses")).abs() < 1e-6);
    folder.done("update model.yaml t.yaml --sensor-masses -o u.yaml");
    assert!(!folder.read("u.yaml").contains("sensor p6"));
    folder.write(
        "light.yaml",
        folder.read("t.yaml").lines().filter(|l| !l.contains("mass:")).fold(String::new(), |a, l| a + l + "\n"),
    );
    let said = folder.run("compare model.yaml light.yaml --sensor-masses");
    assert!(said.code == 2 && said.err.contains("no sensor"), "{said:?}");
}

#[test]
fn no_output_is_overwritten_unasked() {
    let folder = Folder::new("overwrite");
    folder.functions("f.unv");
    folder.write("kept.yaml", "mine");
    for line in [
        "identify f.unv -o kept.yaml",
        "twin model.yaml -o kept.yaml",
        "twin model.yaml --band 10 600 --frf kept.yaml",
        "map model.yaml sensors.yaml -o kept.yaml",
    ] {
        let said = folder.run(line);
        assert!(said.code == 2 && said.err.contains("--force"), "{line}: {said:?}");
        assert_eq!(folder.read("kept.yaml"), "mine");
    }
    assert_eq!(folder.run("identify f.unv -o nowhere/t.yaml").code, 2);
}

#[test]
fn wrong_files_and_options_are_explained() {
    let folder = Folder::new("wrong");
    folder.functions("f.unv");
    folder.write("text.txt", "hello\n");
    folder.write("empty.csv", "");
    folder.write("cut.unv", &folder.read("f.unv")[..20_000]);
    folder.write("bad.csv", "frequency_hz,1/1:re,1/1:im\nHz,m/s2/N,m/s2/N\n1,2,3\n2,x,4\n");
    folder.write("nounit.csv", "frequency_hz,1/1:re,1/1:im\n1,2,3\n2,2,4\n");
    for (line, word) in [
        ("identify nowhere.unv", "nowhere.unv"),
        ("identify text.txt", "not a universal file"),
        ("identify empty.csv", "empty.csv"),
        ("identify bad.csv", "line 4, column 2"),
        ("identify nounit.csv", "unit"),
        ("identify f.unv --units furlong", "in-lbf-s"),
        ("identify f.unv --direction up", "--direction"),
        ("identify f.unv --band 9 3", "--band"),
        ("identify f.unv --band 10 10.5", "lines"),
        ("identify f.unv --geometry text.txt", "text.txt"),
        ("identify f.unv --method guess", "quadrature"),
        ("health text.txt", "not a universal file"),
        ("health f.unv f.unv", "duplicates"),
        ("map model.yaml sensors.yaml", "position"),
        ("map model.yaml f.unv --tolerance 5kg", "--tolerance"),
        ("map model.yaml f.unv --tolerance -5mm", "zero or above"),
        ("map model.yaml f.unv -o out.yaml", "test file"),
        ("map model.yaml text.txt", "not a universal file"),
    ] {
        let said = folder.run(line);
        assert!(said.code == 2 && said.err.contains(word), "{line}: {said:?}");
    }
    // A file that ends early is read as far as it goes, or refused; never more.
    assert!(matches!(folder.run("identify cut.unv").code, 0..=2));
    let mapped = folder.json("map model.yaml f.unv --json");
    assert_eq!(mapped["points"].as_array().unwrap().len(), 6, "{mapped}");
    // The file of functions brings its points: p6 beyond the tip and p3 above its node, p5 inside an element.
    let kind = |name: &str| {
        let points = mapped["points"].as_array().unwrap();
        points.iter().find(|p| p["name"] == name || p["point"] == name).map(|p| p["kind"].clone()).unwrap()
    };
    let kinds = ["p1", "p2", "p3", "p4", "p5", "p6"].map(kind);
    assert_eq!(kinds, ["on node", "on node", "arm from node", "on node", "on element", "arm from node"]);
    // With shorter arms the points off the strip have no place.
    let far = folder.run("map model.yaml f.unv --reach 1mm");
    assert_eq!(far.code, 1, "{far:?}");
    assert!(["p3", "p6"].iter().all(|p| far.out.contains(&format!("no place: point {p}"))), "{far:?}");
}

/// The clamped wing, by commands alone: nine modes, six pairs with MAC of at least 0.91, the wrong driving point.
#[test]
fn the_measured_wing_by_commands() {
    let Some(wing) = data("cruise_missile_wing/frf_csv") else { return };
    let folder = Folder::new("wing");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/cruise_missile_wing.yaml");
    let (wing, model) = (wing.display().to_string(), model.display().to_string());
    // Rows of points begin at the tip and run to the root; the middle of each row lies on the model's middle line.
    let frame = "{origin: [219.1 mm, 1781.2 mm, 0 mm], y: [2.5, -60, 0], z: +z}";
    let said = folder.words(&[
        "identify",
        &wing,
        "--units",
        "SI",
        "--geometry-units",
        "in-lbf-s",
        "--frame",
        frame,
        "--model",
        &model,
        "-o",
        "wing.yaml",
        "--json",
    ]);
    assert_eq!(said.code, 1, "{said:?}");
    let json: Value = serde_json::from_str(&said.out).unwrap();
    // The published frequencies are lines of the analyser, 0.3125 Hz apart.
    let published = [13.4, 51.9, 125.0, 167.8, 228.1, 328.5, 362.2, 496.3, 681.9];
    let found = frequencies(&json);
    assert_eq!(found.len(), published.len(), "{found:?}");
    for (f, p) in found.iter().zip(&published) {
        let line = (p / 0.312_52_f64).round() * 0.312_52;
        assert!((line - p).abs() < 0.05 + 1e-9, "{p} Hz is not a line");
        assert!((f - line).abs() < 0.3126, "{f} for {p} Hz");
    }
    assert!(codes(&json).contains(&"driving-point-sign".to_string()));
    let pairs = folder.words(&["compare", &model, "wing.yaml", "--frequency-window", "1", "--json"]);
    let pairs: Value = serde_json::from_str(&pairs.out).unwrap();
    let pairs: Vec<&Value> =
        pairs["pairs"].as_array().unwrap().iter().filter(|p| p["test_hz"].as_f64().unwrap() < 350.0).collect();
    assert_eq!(pairs.len(), 6);
    assert!(pairs.iter().all(|p| p["mac"].as_f64().unwrap() >= 0.91), "{pairs:?}");
    let model_modes: Vec<i64> = pairs.iter().map(|p| p["model_mode"].as_i64().unwrap()).collect();
    assert_eq!(model_modes, [1, 2, 4, 3, 6, 5]);
    for torsion in [3, 5] {
        let error = pairs[torsion]["error_percent"].as_f64().unwrap();
        assert!((-45.0..-35.0).contains(&error), "{error}");
    }
}

/// Geri's point 10 reads nothing, by the table of its points and shapes and by the MATLAB files.
#[test]
fn the_dead_point_of_geri_by_commands() {
    let Some(geri) = data("maewing1_geri") else { return };
    let folder = Folder::new("geri");
    let table = geri.join("gvt_points_and_shapes.csv");
    let rows: String = fs::read_to_string(&table)
        .unwrap()
        .lines()
        .skip(1)
        .map(|l| l.split(',').take(3).collect::<Vec<_>>().join(",") + ",0\n")
        .collect();
    folder.write("points.csv", format!("point,x,y,z\n{rows}"));
    let table = table.display().to_string();
    let mut files: Vec<String> = ["fsb", "modex", "fst", "fab"]
        .iter()
        .map(|n| geri.join(format!("gvt_mode_shapes/{n}.mat")).display().to_string())
        .collect();
    files.extend(["--geometry", "points.csv", "--geometry-units", "in-lbf-s"].map(String::from));
    for files in [vec![table], files] {
        let mut words = vec!["health", "--direction", "+z", "--json"];
        words.extend(files.iter().map(String::as_str));
        let said = folder.words(&words);
        assert_eq!(said.code, 1, "{said:?}");
        let json: Value = serde_json::from_str(&said.out).unwrap();
        let dead: Vec<&Value> =
            json["findings"].as_array().unwrap().iter().filter(|f| f["code"] == "sensor-dead").collect();
        assert!(dead.len() == 1 && dead[0]["subject"] == "10", "{json}");
    }
}

/// Every sample of other programs gives modes, peaks, or a sentence that says what it holds instead.
#[test]
fn every_sample_is_read_or_explained() {
    let Some(samples) = data("uff_samples") else { return };
    let folder = Folder::new("samples");
    for entry in fs::read_dir(samples).unwrap() {
        let path = entry.unwrap().path().display().to_string();
        let said = folder.words(&["identify", &path]);
        assert!(said.code == 0 || said.code == 2 && said.err.len() > 40, "{path}: {said:?}");
    }
}

/// Four complex modes with their conjugates are four modes; a pole that grows is a finding, and the file that is written can be read.
#[test]
fn conjugate_and_growing_poles_become_a_test_that_can_be_read() {
    let folder = Folder::new("poles");
    let mode = |re: f64, im: f64, number: usize| {
        let head = format!(
            "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n         1         3         2         8         5         3\n         2         6         1{number:10}\n"
        );
        let mut text = format!("{head}{re:13.5E}{im:13.5E}{0:13.5E}{0:13.5E}{0:13.5E}{0:13.5E}\n", 0.0);
        for node in 1..=5_u32 {
            let x = f64::from(node) * (number.div_ceil(2) as f64);
            let (a, b) = (x.sin(), 0.01 * x.cos() * im.signum());
            text += &format!("{node:10}\n{0:13.5E}{0:13.5E}{0:13.5E}{0:13.5E}{a:13.5E}{b:13.5E}\n", 0.0);
        }
        text + "    -1\n"
    };
    let file = |first: f64| {
        [(first, 219.6), (-6.0, 632.0), (-9.0, 969.0)]
            .iter()
            .enumerate()
            .map(|(k, (re, im))| mode(*re, *im, 2 * k + 1) + &mode(*re, -im, 2 * k + 2))
            .collect::<String>()
    };
    folder.write("modes.unv", file(-2.2));
    let json = folder.json("health modes.unv --json");
    assert!(!codes(&json).contains(&"double-mode".to_string()), "{json}");
    let said = folder.done("identify modes.unv -o t.yaml");
    assert!(said.out.contains("3 modes") && said.err.contains("conjugate"), "{said:?}");
    folder.write("grows.unv", file(2.2));
    assert!(codes(&folder.json("health grows.unv --json")).contains(&"growing-mode".to_string()));
    folder.done("identify grows.unv -o grows.yaml");
    let test = folder.read("grows.yaml");
    assert_eq!(test.matches("damping:").count(), 2, "{test}");
    folder.done("health grows.yaml");
}

/// A hammer that hits six points past one accelerometer, as a table: the test file has the six as sensors, and the same shapes as the test the other
/// way round.
#[test]
fn a_roving_hammer_gives_a_test_with_the_points_that_were_hit() {
    let folder = Folder::new("roving");
    folder.done(
        "twin model.yaml --sensors sensors.yaml --frf all.csv --exciter p1 p2 p3 p4 p5 p6 --band 10 600 --lines 2049 --noise-response 0.2%",
    );
    let text: String = folder
        .read("all.csv")
        .lines()
        .filter(|l| !l.starts_with('#'))
        .flat_map(|l| [l.to_owned(), "\n".into()])
        .collect();
    let is_kept = |name: &str| name == "frequency_hz" || name.starts_with("p6.");
    let keep: Vec<usize> =
        text.lines().next().unwrap().split(',').enumerate().filter(|(_, n)| is_kept(n)).map(|c| c.0).collect();
    assert!(keep.len() > 12, "{:?}", text.lines().next());
    let rows: Vec<String> = text
        .lines()
        .map(|l| {
            let cells: Vec<&str> = l.split(',').collect();
            keep.iter().map(|&k| cells[k]).collect::<Vec<_>>().join(",")
        })
        .collect();
    folder.write("roving.csv", &(rows.join("\n") + "\n"));
    let said = folder.done("identify roving.csv -o t.yaml --no-health");
    assert!(said.err.contains("by reciprocity") && said.out.contains("6 responses"), "{said:?}");
    let test = folder.read("t.yaml");
    for name in ["p1", "p2", "p3", "p4", "p5", "p6"] {
        assert!(test.contains(&format!("{name}:")), "{test}");
    }
    let direct = folder.json("identify all.csv --json --no-health");
    let roving = folder.json("identify roving.csv --json --no-health");
    assert_eq!(frequencies(&direct).len(), frequencies(&roving).len());
    for (a, b) in frequencies(&direct).iter().zip(frequencies(&roving)) {
        assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
    }
}

/// With a model the sensor that is turned over is named, the good ones are not, and the advice can be followed to its end.
#[test]
fn health_with_a_model_names_the_turned_sensor() {
    let folder = Folder::new("by-model");
    let twin = |extra: &str| {
        folder.done(&format!(
            "twin model.yaml --sensors sensors.yaml -o t.yaml --force --modes 4 --noise-shape 1% --noise-frequency 0.1% --set EI=23N*m2 {extra}"
        ));
    };
    let warned = |line: &str| -> Vec<(String, String)> {
        let json = folder.json(line);
        let all = json["findings"].as_array().unwrap().iter().filter(|f| f["level"] != "info");
        all.map(|f| (f["code"].as_str().unwrap().to_string(), f["subject"].as_str().unwrap().to_string())).collect()
    };
    twin("");
    assert!(warned("health t.yaml --model model.yaml --json").is_empty());
    twin("--fault sensor-sign@p3");
    let expected = [("sensor-sign".to_string(), "p3".to_string())];
    assert_eq!(warned("health t.yaml --model model.yaml --json"), expected);
    let said = folder.done("health t.yaml --model model.yaml");
    assert!(said.out.contains("reverse the direction") && !said.out.contains("give the model"), "{}", said.out);
    // What it says to do, done: nothing is left to say.
    let test = folder.read("t.yaml");
    let (before, sensor) = test.split_once("  p3:").unwrap();
    let turned = format!("{before}  p3:{}", sensor.replacen("+z", "-z", 1));
    assert_ne!(test, turned, "{test}");
    folder.write("t.yaml", &turned);
    assert!(warned("health t.yaml --model model.yaml --json").is_empty());
    let said = folder.run("health t.yaml --model nowhere.yaml");
    assert!(said.code == 2 && said.err.contains("nowhere.yaml"), "{said:?}");
}
