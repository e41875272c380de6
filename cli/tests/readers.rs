//! Files as other programs write them, through `identify` and `map`: universal files and tables with their dialects.
//!
//! `files/strip.unv` holds four accelerances of a strip with modes at 34.96, 100.66, 154.22 and 189.18 Hz; the tests rewrite it as other
//! programs would have written it.

use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

const STRIP: &str = include_str!("files/strip.unv");
const MODES_HZ: [f64; 4] = [34.9583, 100.658, 154.218, 189.176];

struct Folder(PathBuf);

#[derive(Debug)]
struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("retune-readers-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn with(name: &str, file: &str, content: impl AsRef<[u8]>) -> Self {
        let folder = Self::new(name);
        fs::write(folder.0.join(file), content).unwrap();
        folder
    }

    fn run(&self, line: &str) -> Said {
        self.words(&line.split_whitespace().collect::<Vec<_>>())
    }

    fn words(&self, words: &[&str]) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_retune"));
        command.current_dir(&self.0).args(words).stdin(Stdio::null()).env("COLUMNS", "80");
        let output = command.output().unwrap();
        Said {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// The modes that `identify` finds, and what it says beside them.
    fn modes(&self, line: &str) -> (Vec<f64>, Said) {
        let said = self.run(&format!("identify {line} --json --no-health"));
        assert!(said.code == 0, "{said:?}");
        let json: Value = serde_json::from_str(&said.out).unwrap();
        let modes = json["modes"].as_array().unwrap();
        (modes.iter().map(|m| m["frequency_hz"].as_f64().unwrap()).collect(), said)
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The directions of the sensors of a test file, in its order: `+z`, or `[a, b, c]`.
fn directions(test: &str) -> Vec<String> {
    let rest = test.lines().skip_while(|l| !l.starts_with("sensors:")).skip(1);
    let own: Vec<&str> = rest.take_while(|l| l.starts_with(' ')).map(str::trim).collect();
    let mut found = Vec::new();
    for (k, line) in own.iter().enumerate() {
        let Some(word) = line.strip_prefix("direction:") else { continue };
        let list = || own[k + 1..].iter().map_while(|l| l.strip_prefix("- ")).collect::<Vec<_>>().join(", ");
        found.push(if word.is_empty() { format!("[{}]", list()) } else { word.trim().to_owned() });
    }
    found
}

#[track_caller]
fn close(found: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?} against {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a / b - 1.0).abs() < relative, "{found:?} against {expected:?}");
    }
}

#[test]
fn the_strip_itself_gives_its_modes() {
    let folder = Folder::with("strip", "f.unv", STRIP);
    let (modes, said) = folder.modes("f.unv");
    close(&modes, &MODES_HZ, 1e-3);
    assert!(!said.err.contains("converted") && !said.err.contains("system"), "{said:?}");
}

#[test]
fn a_system_that_no_dataset_defines_is_the_global_one() {
    let triaxial = STRIP.replace("         0         0        11\n", "         1         1        11\n");
    assert_ne!(triaxial, STRIP);
    let triaxial = triaxial.replace(" NONE               2   3 ", " NONE               2  -1 ");
    let triaxial = triaxial.replace(" NONE               3   3 ", " NONE               3   2 ");
    let folder = Folder::with("system", "f.unv", triaxial);
    for option in ["", "--direction +y"] {
        let said = folder.run(&format!("identify f.unv -o t.yaml --force --no-health {option}"));
        assert_eq!(said.code, 0, "{said:?}");
        assert_eq!(said.err.matches("no dataset defines").count(), 1, "{said:?}");
        let found = directions(&folder.read("t.yaml"));
        assert_eq!(found, ["+z", "-x", "+y", "+z"], "{option}");
    }
    // A channel without an axis takes the option.
    let scalar = STRIP.replace(" NONE               2   3 ", " NONE               2   0 ");
    let folder = Folder::with("scalar", "f.unv", scalar);
    let said = folder.run("identify f.unv -o t.yaml --no-health --direction -y");
    assert_eq!(said.code, 0, "{said:?}");
    assert_eq!(directions(&folder.read("t.yaml")), ["+z", "-y", "+z", "+z"]);
}

#[test]
fn local_axes_of_test_lab_are_columns_and_the_components_of_one_sensor_are_one() {
    let folder = Folder::with("axes", "local.unv", include_str!("files/sloped_local.unv"));
    fs::write(folder.0.join("global.unv"), include_str!("files/sloped_global.unv")).unwrap();
    let skew = |test: &str| -> Vec<[f64; 3]> {
        let vector = |d: &String| -> Option<[f64; 3]> {
            let list: Vec<f64> = d.trim_matches(['[', ']']).split(',').filter_map(|v| v.trim().parse().ok()).collect();
            list.try_into().ok()
        };
        directions(test).iter().filter_map(vector).collect()
    };
    for (file, option) in [("local.unv", ""), ("global.unv", ""), ("local.unv", "--local-axes columns")] {
        let said = folder.run(&format!("identify {file} -o t.yaml --force --no-health {option}"));
        assert_eq!(said.code, 0, "{said:?}");
        let found = skew(&folder.read("t.yaml"));
        assert_eq!(found.len(), 4, "{file}: {found:?}");
        for d in found {
            assert!((d[0] - 0.4226).abs() < 1e-4 && d[1].abs() < 1e-9 && (d[2] - 0.9063).abs() < 1e-4, "{file}: {d:?}");
        }
        assert_eq!(said.err.contains("`--local-axes rows`"), file == "local.unv" && option.is_empty(), "{said:?}");
    }
    let said = folder.run("identify local.unv -o t.yaml --force --no-health --local-axes rows");
    assert!(said.err.contains("speak for columns"), "{said:?}");
    assert!(skew(&folder.read("t.yaml")).iter().all(|d| (d[0] + 0.4226).abs() < 1e-4), "{said:?}");
    // Another program: rows, and the geometry objects.
    let other = include_str!("files/sloped_local.unv").replace("LMS Test.Lab", "Another one");
    fs::write(folder.0.join("other.unv"), other).unwrap();
    let said = folder.run("identify other.unv -o t.yaml --force --no-health");
    assert!(said.err.contains("the rows of their matrices") && said.err.contains("`--local-axes columns`"), "{said:?}");
}

#[test]
fn what_stands_behind_numbers_of_datasets_and_nodes_is_a_comment() {
    let folder = Folder::with("comments", "m.unv", include_str!("files/commented_modes.unv"));
    let (modes, _) = folder.modes("m.unv --direction +z");
    close(&modes, &MODES_HZ, 1e-5);
    let functions =
        STRIP.replace("\n    58\n", "\n    58   %REPONSE 12\n").replace("\n  2411\n", "\n  2411 % NOEUDS\n");
    let functions =
        functions.replace("         0         0        11\n", "         0         0        11   %NOEUD N1\n");
    let folder = Folder::with("commented", "f.unv", functions);
    let (modes, said) = folder.modes("f.unv");
    close(&modes, &MODES_HZ, 1e-3);
    assert!(said.err.contains("it is a comment"), "{said:?}");
}

#[test]
fn lines_that_no_function_has_are_left_out() {
    let nan = STRIP.replace("  0.00000E+00  0.00000E+00  5.2", "          NAN          NAN  5.2");
    assert_ne!(nan, STRIP);
    let all: String = STRIP
        .lines()
        .scan(false, |is_first, line| {
            let own = *is_first;
            *is_first = line.starts_with("         0    0    0    0 NONE");
            Some(if own { format!("          NAN          NAN{}\n", &line[26..]) } else { format!("{line}\n") })
        })
        .collect();
    for (name, text) in [("one", nan), ("all", all)] {
        let folder = Folder::with(name, "f.unv", text);
        let (modes, said) = folder.modes("f.unv");
        close(&modes, &MODES_HZ, 1e-3);
        assert!(said.err.contains("not every function has a value at 0 Hz; this line is left out"), "{said:?}");
    }
}

/// The strip for exp(-iωt), with its driving point and without: the modes are those of the strip, and a finding says so.
#[test]
fn the_sign_of_time_is_found_without_a_driving_point() {
    // The numbers of records 13 on: real and imaginary parts, 13 columns each.
    let mut is_data = 0;
    let conjugate: String = STRIP
        .lines()
        .map(|line| {
            is_data = match (line.trim(), is_data) {
                ("58", _) => 1,
                ("-1", _) | (_, 0) => 0,
                (_, n) => n + 1,
            };
            if is_data <= 12 {
                return format!("{line}\n");
            }
            let fields: Vec<&str> = line.split_whitespace().collect();
            let turned = fields.iter().enumerate().map(|(k, f)| match (k % 2, f.strip_prefix('-')) {
                (0, _) => format!("{f:>13}"),
                (_, Some(rest)) => format!("{rest:>13}"),
                (_, None) => format!("{:>13}", format!("-{f}")),
            });
            turned.collect::<String>() + "\n"
        })
        .collect();
    // The force at a point that no sensor has.
    let elsewhere = conjugate.replace(" NONE               1   3\n", " NONE               9   3\n");
    for text in [&conjugate, &elsewhere] {
        let folder = Folder::with("conjugate", "f.unv", text);
        let (modes, said) = folder.modes("f.unv");
        close(&modes, &MODES_HZ, 1e-3);
        assert!(said.err.contains("exp(-iωt)"), "{said:?}");
        let said = folder.run("health f.unv --json");
        assert!(said.out.contains("functions-conjugate"), "{said:?}");
    }
}

#[test]
fn frequencies_in_other_units_are_converted_or_asked_about() {
    let scaled = |step: &str, unit: &str| {
        STRIP
            .replace(
                "  0.00000E+00  1.00000E+00  0.00000E+00\n        18",
                &format!("  0.00000E+00  {step}  0.00000E+00\n        18"),
            )
            .replace("Frequency            Hz   ", &format!("Frequency            {unit:<5}"))
    };
    for (step, unit) in
        [("6.2831853E+00", "rad/s"), ("3.60000E+02", "deg/s"), ("6.00000E+01", "rpm"), ("1.00000E-03", "kHz")]
    {
        let folder = Folder::with("units", "f.unv", scaled(step, unit));
        let (modes, said) = folder.modes("f.unv");
        close(&modes, &MODES_HZ, 1e-3);
        assert!(said.err.contains("they were converted to Hz"), "{said:?}");
    }
    let folder = Folder::with("asked", "f.unv", scaled("6.2831853E+00", "1/s"));
    let said = folder.run("identify f.unv");
    assert!(said.code == 2 && said.err.contains("`1/s`") && said.err.contains("frequency-unit"), "{said:?}");
    close(&folder.modes("f.unv --frequency-unit rad/s").0, &MODES_HZ, 1e-3);
    let said = folder.run("identify f.unv --frequency-unit furlongs");
    assert!(said.code == 2 && said.err.contains("such as Hz"), "{said:?}");
}

#[test]
fn an_option_that_contradicts_the_file_is_refused_with_both() {
    let folder = Folder::with("quantity", "f.unv", STRIP);
    let said = folder.run("identify f.unv --quantity receptance");
    assert!(said.code == 2, "{said:?}");
    for word in ["says receptance", "says accelerance", "`m/s^2`", "--units SI --quantity receptance"] {
        assert!(said.err.replace('\n', " ").contains(word), "{word}: {said:?}");
    }
    // Who states the units too knows that the file is wrong.
    let (_, said) = folder.modes("f.unv --units SI --quantity receptance");
    assert!(said.err.contains("read as receptance"), "{said:?}");
    close(&folder.modes("f.unv --quantity accelerance").0, &MODES_HZ, 1e-3);
}

#[test]
fn one_number_in_two_components_is_two_points() {
    let mut named = STRIP.to_owned();
    for (node, name, own) in [(1, "wing", 1), (2, "wing", 2), (3, "tail", 1), (4, "tail", 2)] {
        let old = format!(" NONE               {node}   3 NONE               1   3");
        named = named.replace(&old, &format!(" {name}               {own}   3 wing               1   3"));
    }
    let folder = Folder::with("components", "f.unv", named);
    let said = folder.run("identify f.unv -o t.yaml --no-health");
    assert_eq!(said.code, 0, "{said:?}");
    let test = folder.read("t.yaml");
    for name in ["wing.1", "wing.2", "tail.1", "tail.2"] {
        assert!(test.contains(&format!("{name}:")), "{name}: {test}");
    }
    assert_eq!(directions(&test).len(), 4);
    // Names that say what a signal is do not tear a driving point apart.
    let signals = STRIP.replace("   3 NONE               1   3", "   3 Force              1   3");
    let signals = signals.replace("         0 NONE     ", "         0 Acc      ");
    let folder = Folder::with("signals", "f.unv", signals);
    assert_eq!(folder.run("identify f.unv -o t.yaml --no-health").code, 0);
    assert!(!folder.read("t.yaml").contains("Acc"), "{}", folder.read("t.yaml"));
}

/// The strip as a table, by what makes a line of a frequency and four values.
fn table(head: &str, row: impl Fn(f64, &[(f64, f64)]) -> String) -> String {
    let blocks: Vec<Vec<f64>> = STRIP
        .split("         0    0    0    0 NONE                 NONE                \n")
        .skip(1)
        .map(|b| {
            b.lines()
                .take_while(|l| *l != "    -1")
                .flat_map(str::split_whitespace)
                .map(|v| v.parse().unwrap())
                .collect()
        })
        .collect();
    let lines = blocks[0].len() / 2;
    let values = |k: usize| blocks.iter().map(|b| (b[2 * k], b[2 * k + 1])).collect::<Vec<_>>();
    head.to_owned() + &(1..lines).map(|k| row(k as f64, &values(k))).collect::<String>()
}

#[test]
fn tables_of_spreadsheets_are_read() {
    let names: Vec<String> = (1..=4).map(|k| format!("{k}+z/1+z:re,{k}+z/1+z:im")).collect();
    let cells = |v: &[(f64, f64)]| v.iter().map(|(a, b)| format!("{a},{b}")).collect::<Vec<_>>().join(",");
    let head = format!("frequency_hz,{},\nHz{},\n", names.join(","), ",m/s2/N".repeat(8));
    let plain = table(&head, |f, v| format!("{f},{},\n", cells(v)));
    let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain(plain.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    // Decimal commas, quoted where the comma separates, and a line that says how.
    let quoted = table(&head.replace('\n', "\r\n"), |f, v| {
        let cells: Vec<String> = v.iter().map(|(a, b)| format!("\"{a:.8}\",\"{b:.8}\"").replace('.', ",")).collect();
        format!("{f},{},\r\n", cells.join(","))
    });
    let german = format!("sep=;\n{}", plain.replace(',', ";").replace('.', ","));
    let polar_names: Vec<String> =
        (1..=4).map(|k| format!("{k}.+z/1.+z amplitude [mm/s2/N];{k}.+z/1.+z phase [deg]")).collect();
    let polar = table(&format!("Frequency [rad/s];{}\n", polar_names.join(";")), |f, v| {
        let cells: Vec<String> =
            v.iter().map(|(a, b)| format!("{};{}", 1e3 * a.hypot(*b), b.atan2(*a).to_degrees())).collect();
        format!("{};{}\n", std::f64::consts::TAU * f, cells.join(";")).replace('.', ",")
    });
    let of = |text: String| text.into_bytes();
    for (name, bytes) in
        [("trailing", of(plain)), ("utf16", wide), ("quoted", of(quoted)), ("german", of(german)), ("polar", of(polar))]
    {
        let folder = Folder::with(name, "f.csv", bytes);
        let (modes, _) = folder.modes("f.csv");
        close(&modes, &MODES_HZ, 1e-3);
        let said = folder.run("identify f.csv -o t.yaml --no-health");
        assert_eq!(said.code, 0, "{name}: {said:?}");
        assert_eq!(directions(&folder.read("t.yaml")), ["+z"; 4], "{name}");
    }
    let folder = Folder::with("encodings", "f.csv", b"point;x;y;z;gro\xdf 5 Hz\n1;0;0;0;1\n");
    let said = folder.run("identify f.csv --direction +z");
    assert!(said.code == 2 && said.err.contains("Windows-1252"), "{said:?}");
}

#[test]
fn a_decimal_comma_in_a_header_is_one() {
    let text =
        "point;x_mm;y_mm;z_mm;bending 7,9 Hz;second 49,1 Hz\n1;0;0;0;0;0\n2;100;0;0;0,1;-0,4\n3;200;0;0;0,4;-0,9\n";
    let folder = Folder::with("comma", "s.csv", text);
    assert_eq!(folder.modes("s.csv --direction +z").0, [7.9, 49.1]);
    let folder = Folder::with("thousands", "s.csv", text.replace("7,9", "1'007.9"));
    let said = folder.run("identify s.csv --direction +z");
    assert!(said.code == 2 && said.err.contains("separators of thousands"), "{said:?}");
}

#[test]
fn a_point_that_is_there_twice_is_told() {
    let model = "retune: 1\nname: bar\nactive_dofs: [uz, ry]\nnodes: {a: [0, 0, 0], b: [1, 0, 0]}\n\
                 beams: {ab: {nodes: [a, b], properties: {EIy: 10, mass_per_length: 1}}}\nsupports: {c: {node: a}}\n";
    let folder = Folder::with("twice", "model.yaml", model);
    fs::write(folder.0.join("points.csv"), "point,x,y,z\n1,0,0,0\n1,1,0,0\n").unwrap();
    let said = folder.run("map model.yaml points.csv --geometry-units SI");
    assert!(said.err.contains("1 point whose name was there before: `1` in line 3; the last one counts"), "{said:?}");
    fs::write(folder.0.join("f.unv"), STRIP).unwrap();
    let said = folder.run("identify f.unv --geometry points.csv --geometry-units SI --no-health");
    assert!(said.code == 0 && said.err.contains("was there before"), "{said:?}");
}

#[test]
fn the_damping_of_an_exponential_window_is_taken_out() {
    // Two modes of 1 % seen through a window of 3 1/s: H(s + σ).
    let (tau, rate, zeta) = (std::f64::consts::TAU, 3.0, 0.01);
    let value = |f: f64| -> (f64, f64) {
        let (mut re, mut im) = (0.0, 0.0);
        for (hz, r) in [(20.0, 1.0), (61.0, 1.4)] {
            let omega = tau * hz;
            // 1 / (s² + 2 ζ ω s + ω²) at s = σ + i 2π f.
            let (a, b) = (rate, tau * f);
            let (p, q) = (a * a - b * b + 2.0 * zeta * omega * a + omega * omega, 2.0 * a * b + 2.0 * zeta * omega * b);
            let d = p * p + q * q;
            re += r * p / d;
            im -= r * q / d;
        }
        (re, im)
    };
    let mut rows = String::new();
    for f in (1..400).map(|k| 0.25 * f64::from(k)) {
        let (re, im) = value(f);
        rows += &format!("{f},{re:e},{im:e}\n");
    }
    let folder = Folder::with("window", "f.csv", format!("frequency_hz,1.+z/1.+z:re,1.+z/1.+z:im\nHz,m/N,m/N\n{rows}"));
    let damping = |option: &[&str]| -> (Vec<f64>, Said) {
        let said = folder.words(&[&["identify", "f.csv", "--json", "--no-health"], option].concat());
        let json: Value = serde_json::from_str(&said.out).unwrap();
        let modes = json["modes"].as_array().unwrap().iter();
        (modes.map(|m| m["damping"].as_f64().unwrap_or(f64::NAN)).collect(), said)
    };
    let expected = |hz: f64| zeta + rate / (tau * hz);
    close(&damping(&[]).0, &[expected(20.0), expected(61.0)], 1e-2);
    close(&damping(&["--exponential-window", "3 1/s"]).0, &[zeta; 2], 2e-3);
    close(&damping(&["--exponential-window", "0.3333333333 s"]).0, &[zeta; 2], 2e-3);
    let (lost, said) = damping(&["--exponential-window", "5 1/s"]);
    assert!(lost[0].is_nan() && lost[1] > 0.0 && said.err.contains("damping ratio is left out"), "{said:?}");
    let said = folder.words(&["identify", "f.csv", "--exponential-window", "3"]);
    assert!(said.code == 2 && said.err.contains("it has no unit"), "{said:?}");
    let said = folder.words(&["identify", "f.csv", "--exponential-window", "2 Hz"]);
    assert!(said.code == 2 && said.err.contains("it is a frequency"), "{said:?}");

    // The same from dataset 1858 of a universal file.
    let lines: Vec<f64> = (1..400).map(|k| value(0.25 * f64::from(k))).flat_map(|(a, b)| [a, b]).collect();
    let mut values = String::new();
    for line in lines.chunks(4) {
        for v in line {
            values += &format!("{v:>20.12E}");
        }
        values.push('\n');
    }
    let wide = |v: f64| format!("{v:>15.7E}");
    let zeros = |n: usize| wide(0.0).repeat(n);
    let whole = |v: i32, n: usize| format!("{v:>6}").repeat(n);
    let qualifiers = [
        "    -1\n  1858".to_owned(),
        format!("{:>12}", 1).repeat(6),
        [whole(0, 1), whole(4, 1), whole(0, 10)].concat(),
        zeros(5),
        zeros(4) + &wide(rate),
        zeros(5),
        "NONE  NONE\nNONE\n    -1\n".to_owned(),
    ]
    .join("\n");
    let axis = |t: i32| format!("{t:>10}    0    0    0 NONE                 NONE\n");
    let unv = format!(
        "    -1\n   164\n         1SI                           1\n  1.0D+00  1.0D+00  1.0D+00\n  2.7D+02\n    -1\n{qualifiers}\
         \x20   -1\n    58\nf\nNONE\nNONE\nNONE\nNONE\n    4         0    0         0 NONE               1   3 NONE               1   3\n\
         \x20        6       399         1  2.50000E-01  2.50000E-01  0.00000E+00\n{}{}{}{}{values}    -1\n",
        axis(18),
        axis(8),
        axis(13),
        axis(0)
    );
    fs::write(folder.0.join("f.unv"), unv).unwrap();
    let modes = |option: &[&str]| -> (Vec<f64>, Said) {
        let said = folder.words(&[&["identify", "f.unv", "--json", "--no-health"], option].concat());
        let json: Value = serde_json::from_str(&said.out).unwrap();
        (json["modes"].as_array().unwrap().iter().map(|m| m["damping"].as_f64().unwrap()).collect(), said)
    };
    let (found, said) = modes(&[]);
    close(&found, &[zeta; 2], 2e-3);
    assert!(said.err.contains("dataset 1858"), "{said:?}");
    close(&modes(&["--exponential-window", "none"]).0, &[expected(20.0), expected(61.0)], 1e-2);
}

#[test]
fn a_device_that_never_ends_is_refused() {
    if !std::path::Path::new("/dev/zero").exists() {
        return;
    }
    let folder = Folder::new("endless");
    for line in ["identify /dev/zero", "check /dev/zero"] {
        let said = folder.run(line);
        assert!(said.code == 2 && said.err.contains("no more are read"), "{line}: {said:?}");
    }
}
