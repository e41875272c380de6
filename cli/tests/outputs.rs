//! Outputs that cannot be lost: streams that are closed or full, names that collide, links and permissions, signals, endless input.

#![cfg(unix)]

use retune::hash::sha256;
use serde_json::Value;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const MODEL: &str = "\
retune: 1
name: cantilever
active_dofs: [uz, ry]
parameters:
  EI: {value: 20 N m2, bounds: [5 N m2, 40 N m2]}
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
  middle: {node: middle, direction: +z, position: [0.5 m, 0 m, 0 m]}
  tip: {node: tip, direction: +z, position: [1 m, 0 m, 0 m]}
defaults: {frequency_sd: 0.5 %, shape_sd: 3 %}
modes:
  - {frequency: 2.2 Hz, source: made, shape: {real: [0.33, 1.0]}}
  - {frequency: 14.9 Hz, source: made, shape: {real: [1.0, -0.7]}}
";

const SHAPES: &str = "point,x,y,z,bending 7.9 Hz,second 50.1 Hz\n1,0.5,0,0,0.3,1.0\n2,1.0,0,0,1.0,-0.7\n";

/// Longest that an answer to endless input may take, on a busy machine.
const SECONDS: Duration = Duration::from_secs(60);

/// A folder of its own for every test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("retune-outputs-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("model.yaml"), MODEL).unwrap();
        fs::write(path.join("test.yaml"), TEST).unwrap();
        fs::write(path.join("shapes.csv"), SHAPES).unwrap();
        Self(path)
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.join(name)
    }

    fn read(&self, name: impl AsRef<Path>) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn command<S: AsRef<OsStr>>(&self, words: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_retune"));
        command.current_dir(&self.0).args(words).stdin(Stdio::null()).env_remove("COLUMNS");
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn line(&self, line: &str) -> Command {
        self.command(line.split_whitespace())
    }

    fn run(&self, line: &str) -> Said {
        Said::of(line, &self.line(line).output().unwrap())
    }

    fn has_part(&self) -> bool {
        fs::read_dir(&self.0).unwrap().any(|e| e.unwrap().file_name().as_bytes().ends_with(b".part"))
    }

    fn fifo(&self, name: &str) -> PathBuf {
        let path = self.path(name);
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
        path
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
        let code = output.status.code().unwrap_or(-1);
        let said = Self { code, out: text(&output.stdout), err: text(&output.stderr) };
        assert!(!said.err.contains("panicked") && said.code != 70, "{line}: {said:?}");
        said
    }
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// A pipe that nobody reads.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

fn full() -> Stdio {
    File::options().write(true).open("/dev/full").unwrap().into()
}

/// Every verb with what it writes; `{}` is a prefix of the names.
const VERBS: &[(&str, &[&str])] = &[
    ("check model.yaml", &[]),
    ("check model.yaml --json", &[]),
    ("modes model.yaml", &[]),
    ("identify shapes.csv --direction +z --units SI -o {}identified.yaml", &["identified.yaml"]),
    ("health shapes.csv --direction +z --units SI", &[]),
    ("map model.yaml test.yaml -o {}mapped.yaml", &["mapped.yaml"]),
    ("twin model.yaml -o {}twin.yaml --modes 2 --frf {}twin.csv --band 1 30 --lines 20", &["twin.yaml", "twin.csv"]),
    ("compare model.yaml test.yaml", &[]),
    ("pretest model.yaml -n 2 --sensors 2", &[]),
    ("sensitivity model.yaml test.yaml -n 2", &[]),
    ("update model.yaml test.yaml -o {}updated.yaml --report {}updated.html", &["updated.yaml", "updated.html"]),
    ("update model.yaml test.yaml --json -o {}u.yaml --report {}u.html", &["u.yaml", "u.html"]),
    ("sample model.yaml test.yaml --samples 50 -o {}samples.csv", &["samples.csv"]),
    (
        "report model.yaml test.yaml -o {}r.html --data {}r.json --svg {}svg --vtk {}vtk",
        &["r.html", "r.json", "svg/mac.svg"],
    ),
    ("report model.yaml test.yaml", &[]),
    ("diagnose model.yaml test.yaml --no-faults --report {}d.html", &["d.html"]),
    ("learn model.yaml test.yaml --limit 1 -o {}learned.yaml --report {}l.html", &["learned.0.yaml", "l.html"]),
    ("add model.yaml point-mass@tip --dry-run", &[]),
    ("add model.yaml point-mass@tip -o {}added.yaml", &["added.yaml"]),
    ("undo {}added.yaml -o {}undone.yaml", &["undone.yaml"]),
    ("schema model", &[]),
    ("schema test", &[]),
    ("list effects", &[]),
    ("list effects --json", &[]),
    ("explain beam", &[]),
    ("completions bash", &[]),
    ("--help", &[]),
    ("update --help", &[]),
    ("--version", &[]),
];

/// Runs every verb four times: as usual, into closed pipes, with a full standard output, and with a full standard error.
#[test]
fn outputs_are_written_whatever_becomes_of_the_streams() {
    let f = Folder::new("streams");
    for (line, files) in VERBS {
        let usual = f.run(&line.replace("{}", "a-"));
        assert!(usual.code <= 1, "{line}: {usual:?}");
        let all = [("b-", closed(), closed()), ("c-", full(), Stdio::piped()), ("d-", Stdio::piped(), full())];
        for (prefix, out, err) in all {
            let own = line.replace("{}", prefix);
            let said = Said::of(&own, &f.line(&own).stdout(out).stderr(err).output().unwrap());
            let is_full = prefix == "c-";
            assert_eq!(said.code, if is_full { 2 } else { usual.code }, "{own}: {said:?}");
            assert_eq!(said.err.contains("cannot write to the standard output: No space left"), is_full, "{said:?}");
            for name in *files {
                let of = |prefix: &str| f.read(format!("{prefix}{name}"));
                // A page holds the command with its names.
                let length = (of(prefix).len() as i64 - of("a-").len() as i64).abs();
                assert!(of(prefix).len() > 20 && length < 20, "{own}: {name}");
            }
        }
        assert!(!f.has_part(), "{line}");
    }
}

#[test]
fn wrong_input_stays_wrong_where_nobody_reads_why() {
    let f = Folder::new("silent");
    for line in ["check nowhere.yaml", "frobnicate", "check", "compare model.yaml model.yaml", "explain nothing-such"] {
        for (out, err) in [(closed(), closed()), (full(), full())] {
            assert_eq!(f.line(line).stdout(out).stderr(err).status().unwrap().code(), Some(2), "{line}");
        }
    }
}

/// A full disk for one output: an error, and nothing else is lost for it.
#[test]
fn one_output_that_cannot_be_written_takes_no_other_along() {
    let f = Folder::new("one");
    let said = f.run("update model.yaml test.yaml -o /dev/full --report r.html");
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.err.contains("cannot write /dev/full: No space left"), "{said:?}");
    assert!(said.out.contains("written: r.html") && !said.out.contains("written: /dev/full"), "{said:?}");
    assert!(f.read("r.html").len() > 1000);
}

#[test]
fn links_are_followed_and_permissions_kept() {
    let f = Folder::new("links");
    let mode = |name: &str| fs::metadata(f.path(name)).unwrap().permissions().mode() & 0o7777;
    // A new file has the permissions of any new file.
    fs::write(f.path("any"), "").unwrap();
    assert_eq!(f.run("twin model.yaml -o new.yaml --modes 2").code, 0);
    assert_eq!(mode("new.yaml"), mode("any"));
    // One that is overwritten keeps its own, and a link stays a link.
    fs::create_dir(f.path("far")).unwrap();
    fs::write(f.path("far/real.yaml"), "old").unwrap();
    fs::set_permissions(f.path("far/real.yaml"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("far/real.yaml", f.path("second")).unwrap();
    symlink("second", f.path("first")).unwrap();
    assert!(f.run("twin model.yaml -o first --modes 2").err.contains("first exists; give --force"));
    assert_eq!(f.run("twin model.yaml -o first --modes 2 --force").code, 0);
    assert_eq!((f.read("far/real.yaml"), mode("far/real.yaml")), (f.read("new.yaml"), 0o640));
    assert!(fs::symlink_metadata(f.path("first")).unwrap().is_symlink());
    // A link that leads to nothing is a name for that place.
    symlink("far/later.yaml", f.path("dangling")).unwrap();
    assert_eq!(f.run("twin model.yaml -o dangling --modes 2").code, 0);
    assert_eq!(f.read("far/later.yaml"), f.read("new.yaml"));
    // The same for edits.
    fs::set_permissions(f.path("model.yaml"), fs::Permissions::from_mode(0o600)).unwrap();
    symlink("model.yaml", f.path("m")).unwrap();
    assert_eq!(f.run("add m point-mass@tip").code, 0);
    assert_eq!(f.run("undo model.yaml -o m").code, 0);
    assert_eq!((f.read("model.yaml").as_str(), mode("model.yaml")), (MODEL, 0o600));
    assert!(fs::symlink_metadata(f.path("m")).unwrap().is_symlink());
    // Two that lead to each other.
    symlink("b", f.path("a")).unwrap();
    symlink("a", f.path("b")).unwrap();
    assert_eq!(f.run("twin model.yaml -o a --modes 2 --force").code, 2);
}

#[test]
fn what_is_no_file_is_refused_and_pipes_and_devices_are_written_to() {
    let f = Folder::new("kinds");
    fs::create_dir(f.path("folder")).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(f.path("socket")).unwrap();
    fs::write(f.path("kept.yaml"), "mine").unwrap();
    fs::set_permissions(f.path("kept.yaml"), fs::Permissions::from_mode(0o444)).unwrap();
    for (name, word) in [
        ("folder", "it is a folder"),
        ("socket", "not a regular file"),
        ("kept.yaml", "write-protected"),
        ("none/x.yaml", "there is no folder none"),
        ("model.yaml/x.yaml", "Not a directory"),
    ] {
        for line in ["twin model.yaml --modes 2 --force -o", "update model.yaml test.yaml --force --report"] {
            let said = f.run(&format!("{line} {name}"));
            assert!(said.code == 2 && said.err.contains(word), "{line} {name}: {said:?}");
        }
    }
    assert_eq!(f.read("kept.yaml"), "mine");
    fs::set_permissions(f.path("model.yaml"), fs::Permissions::from_mode(0o444)).unwrap();
    assert!(f.run("add model.yaml point-mass@tip").err.contains("write-protected"));
    assert_eq!(f.read("model.yaml"), MODEL);
    // /dev/null stays a device, and a pipe gets the file.
    assert_eq!(f.run("twin model.yaml -o /dev/null --modes 2").code, 0);
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
    assert_eq!(f.run("twin model.yaml -o file.yaml --modes 2").code, 0);
    let pipe = f.fifo("pipe");
    let reader = std::thread::spawn(move || fs::read_to_string(pipe).unwrap());
    assert_eq!(f.run("twin model.yaml -o pipe --modes 2").code, 0);
    assert_eq!(reader.join().unwrap(), f.read("file.yaml"));
    // The standard output under its name, a pipe and a file.
    let said = f.run("twin model.yaml -o /dev/stdout --modes 2");
    assert!(said.code == 0 && said.out.starts_with(&f.read("file.yaml")), "{said:?}");
    let into = File::create(f.path("into")).unwrap();
    assert!(f.line("twin model.yaml -o /dev/stdout --modes 2").stdout(into).status().unwrap().success());
    assert_eq!(f.read("into"), said.out);
}

#[test]
fn no_output_is_an_input_or_another_output_under_any_name() {
    let f = Folder::new("names");
    symlink("model.yaml", f.path("link")).unwrap();
    symlink(".", f.path("here")).unwrap();
    fs::hard_link(f.path("test.yaml"), f.path("hard")).unwrap();
    symlink("later.yaml", f.path("dangling")).unwrap();
    fs::write(
        f.path("frfs.csv"),
        "# SYNTHETIC\nfrequency_hz,tip.+z/tip.+z:re,tip.+z/tip.+z:im\nHz,m/s2/N,m/s2/N\n1,2,3\n2,3,4\n",
    )
    .unwrap();
    fs::write(f.path("with.yaml"), format!("{TEST}frfs: {{files: [frfs.csv]}}\n")).unwrap();
    for (line, word) in [
        ("update model.yaml test.yaml --force -o model.yaml", "model.yaml"),
        ("update model.yaml test.yaml --force -o link", "link"),
        ("update link test.yaml --force -o model.yaml", "model.yaml"),
        ("update model.yaml test.yaml --force -o hard", "hard"),
        ("update model.yaml test.yaml --force --report here/test.yaml", "here/test.yaml"),
        ("update model.yaml with.yaml --force -o frfs.csv", "frfs.csv"),
        ("identify shapes.csv --direction +z --units SI --force -o shapes.csv", "shapes.csv"),
        ("map model.yaml test.yaml --force -o test.yaml", "test.yaml"),
        ("twin model.yaml --force -o model.yaml", "model.yaml"),
        ("report model.yaml test.yaml --force --data test.yaml", "test.yaml"),
        ("sample model.yaml test.yaml --force -o test.yaml", "test.yaml"),
        ("add model.yaml sensor-mass@whole --test test.yaml --force -o test.yaml", "test.yaml"),
        ("update model.yaml test.yaml -o x --report x", "one file"),
        ("update model.yaml test.yaml -o x --report here/x", "one file"),
        ("update model.yaml test.yaml -o x --report ./X", "one file"),
        ("update model.yaml test.yaml -o later.yaml --report dangling", "one file"),
        ("update model.yaml test.yaml -o x --checkpoint x", "one file"),
        ("report model.yaml test.yaml -o x --data x", "one file"),
        ("twin model.yaml -o x --frf x --band 1 30", "one file"),
    ] {
        let said = f.run(line);
        assert!(said.code == 2 && said.err.contains(word), "{line}: {said:?}");
        let kept = [("model.yaml", MODEL), ("test.yaml", TEST), ("shapes.csv", SHAPES)];
        assert!(kept.iter().all(|(name, text)| f.read(name) == *text), "{line}");
        assert!(!f.path("x").exists() && !f.path("later.yaml").exists() && !f.has_part(), "{line}");
    }
}

#[test]
fn no_part_stays_after_a_signal() {
    let f = Folder::new("parts");
    for k in 0..24 {
        let line = format!("learn model.yaml test.yaml --limit 200 -o l{k}.yaml --report l{k}.html");
        let mut child = f.line(&line).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(2 * k));
        signal(&child, if k % 2 == 0 { "-TERM" } else { "-INT" });
        let status = child.wait().unwrap();
        let by = status.signal();
        assert!(by == Some(if k % 2 == 0 { 15 } else { 2 }) || status.code().is_some_and(|c| c <= 1), "{status:?}");
        assert!(!f.has_part(), "{k}");
    }
}

/// The test comes through a pipe that is silent yet: the search has not begun.
#[test]
fn a_signal_before_the_search_says_that_nothing_was_evaluated() {
    let f = Folder::new("early");
    f.fifo("pipe");
    for (verb, name, number) in [("update", "-INT", 2), ("update", "-TERM", 15), ("sample", "-INT", 2)] {
        let child = f.line(&format!("{verb} model.yaml pipe -o out.yaml")).spawn().unwrap();
        // It opens the pipe only when it listens to signals.
        let writer = File::options().write(true).open(f.path("pipe")).unwrap();
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        drop(writer);
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.signal(), Some(number), "{err}");
        assert!(err.contains("nothing was evaluated yet"), "{err}");
        assert!(!f.path("out.yaml").exists());
    }
}

/// At whatever moment the signal comes there is a best point that is written, or word that there is none.
#[test]
fn a_signal_at_any_moment_gives_the_best_so_far_or_says_that_there_is_none() {
    let f = Folder::new("moments");
    let endless =
        "{differential-evolution: {strategy: classic, population: 400, generations: 1000000000, tolerance: 0}}";
    for k in 0..16 {
        let out = format!("out{k}.yaml");
        let line = format!("update model.yaml test.yaml -o {out} --cost paper --optimizer");
        let child = f.line(&line).arg(endless).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(3 * k * k));
        signal(&child, "-INT");
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr.clone()).unwrap();
        assert!(!err.contains("panicked"), "{err}");
        match output.status.code() {
            Some(0 | 1) => assert!(f.path(&out).exists(), "{err}"),
            Some(130) => assert!(err.contains("nothing was evaluated yet") && !f.path(&out).exists(), "{err}"),
            code => assert!((code, output.status.signal()) == (None, Some(2)) && !f.path(&out).exists(), "{err}"),
        }
        assert!(!f.has_part());
    }
}

/// From a pipe a file can be read once: what stands on the page is the hash of that.
#[test]
fn hashes_are_those_of_the_bytes_that_were_read() {
    let f = Folder::new("hashes");
    let pipes = [("model", MODEL), ("test", TEST)].map(|(name, text)| {
        let pipe = f.fifo(name);
        std::thread::spawn(move || File::options().write(true).open(pipe).unwrap().write_all(text.as_bytes()).unwrap())
    });
    let said = f.run("report model test --data r.json");
    assert_eq!(said.code, 0, "{said:?}");
    for pipe in pipes {
        pipe.join().unwrap();
    }
    let data: Value = serde_json::from_str(&f.read("r.json")).unwrap();
    let hash = |text: &str| sha256(text.as_bytes());
    let found: Vec<(&str, &str)> = data["meta"]["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| (x["path"].as_str().unwrap(), x["sha256"].as_str().unwrap()))
        .collect();
    for (name, text) in [("model", MODEL), ("test", TEST)] {
        assert!(found.contains(&(name, hash(text).as_str())), "{name}: {found:?}");
    }
    // Files that a test leads to are recorded too, and those of a folder.
    fs::write(
        f.path("f.csv"),
        "# SYNTHETIC\nfrequency_hz,tip.+z/tip.+z:re,tip.+z/tip.+z:im\nHz,m/s2/N,m/s2/N\n1,2,3\n2,3,4\n",
    )
    .unwrap();
    fs::write(f.path("with.yaml"), format!("{TEST}frfs: {{files: [f.csv]}}\n")).unwrap();
    let said = f.run("report model.yaml with.yaml --data s.json");
    assert_eq!(said.code, 0, "{said:?}");
    let data: Value = serde_json::from_str(&f.read("s.json")).unwrap();
    let names: Vec<&str> =
        data["meta"]["files"].as_array().unwrap().iter().map(|x| x["path"].as_str().unwrap()).collect();
    assert_eq!(names, ["model.yaml", "with.yaml", "f.csv"]);
}

#[test]
fn paths_that_are_not_utf_8_work_in_every_verb() {
    let f = Folder::new("bytes");
    let odd = |name: &str| {
        let mut bytes = name.as_bytes().to_vec();
        bytes.insert(1, 0xff);
        OsString::from_vec(bytes)
    };
    for (from, to) in [("model.yaml", "m.yaml"), ("test.yaml", "t.yaml"), ("shapes.csv", "s.csv")] {
        fs::copy(f.path(from), f.path(odd(to))).unwrap();
    }
    let profile = f.run("explain common-practice");
    fs::write(f.path(odd("p.yaml")), &profile.out).unwrap();
    // Words that begin with a percent sign are such names.
    for line in [
        "check %m.yaml",
        "modes %m.yaml",
        "identify %s.csv --direction +z --units SI -o %identified.yaml",
        "health %s.csv --direction +z --units SI",
        "map %m.yaml %t.yaml -o %mapped.yaml",
        "twin %m.yaml -o %twin.yaml --modes 2 --frf %twin.csv --band 1 30 --lines 20 --sensors %t.yaml",
        "compare %m.yaml %t.yaml --profile %p.yaml",
        "pretest %m.yaml -n 2 --sensors 2 --test %t.yaml",
        "sensitivity %m.yaml %t.yaml -n 2",
        "update %m.yaml %t.yaml -o %updated.yaml --report %updated.html --checkpoint %state",
        "sample %m.yaml %t.yaml --samples 50 -o %samples.csv",
        "report %m.yaml %t.yaml -o %r.html --data %r.json --svg %svg --vtk %vtk --history %updated.yaml",
        "diagnose %m.yaml %t.yaml --no-faults --report %d.html",
        "learn %m.yaml %t.yaml --limit 1 -o %learned.yaml --report %l.html",
        "add %m.yaml point-mass@tip -o %added.yaml",
        "undo %added.yaml",
    ] {
        let word = |w: &str| w.strip_prefix('%').map_or_else(|| OsString::from(w), &odd);
        let output = f.command(line.split_whitespace().map(word)).output().unwrap();
        let said = Said::of(line, &output);
        assert!(said.code <= 1, "{line}: {said:?}");
    }
    for name in [
        "identified.yaml",
        "mapped.yaml",
        "twin.yaml",
        "twin.csv",
        "updated.yaml",
        "updated.html",
        "r.html",
        "d.html",
        "l.html",
    ] {
        assert!(f.path(odd(name)).exists(), "{name}");
    }
}

#[test]
fn control_characters_in_names_are_shown_escaped() {
    let f = Folder::new("control");
    let odd = "a\u{1b}[31m\nb\u{7}.yaml";
    let is_clean = |text: &str| !text.chars().any(|c| c.is_control() && c != '\n');
    let nodes = MODEL.replace("tip_mass", "m").replace("tip", "\"t\\e[31m\\np\"");
    let wrong = nodes.replace("chain: [root, middle", "chain: [root, \"m\\e[2Jiddle\"");
    for text in
        [None, Some("not: [a model"), Some("retune_test: 1\nname: x\n"), Some(wrong.as_str()), Some(nodes.as_str())]
    {
        if let Some(text) = text {
            fs::write(f.path(odd), text).unwrap();
        }
        for words in [
            &["check", odd][..],
            &["modes", odd],
            &["compare", odd, odd],
            &["update", "model.yaml", odd],
            &["identify", odd],
            &["health", odd],
            &["twin", odd, "-o", odd],
            &["twin", "model.yaml", "--modes", "2", "--force", "-o", "c\u{1b}[31m.yaml"],
            &["explain", odd],
            &["add", "model.yaml", odd],
            &["update", "model.yaml", "test.yaml", "--optimizer", odd],
            &[odd],
        ] {
            let said = Said::of(&format!("{words:?}"), &f.command(words).output().unwrap());
            assert!(is_clean(&said.out) && is_clean(&said.err), "{words:?}: {said:?}");
        }
    }
}

#[test]
fn messages_are_cut() {
    let f = Folder::new("long");
    let long = "x".repeat(200_000);
    fs::write(f.path("long.yaml"), MODEL.replace("node: tip,", &format!("node: {long},"))).unwrap();
    fs::write(f.path("line.yaml"), format!("{{{long}")).unwrap();
    for words in
        [&["check", "long.yaml"][..], &["check", "line.yaml"], &["explain", &long[..100_000]], &[&long[..100_000]]]
    {
        let said = Said::of(words[0], &f.command(words).output().unwrap());
        assert!(said.code == 2 && said.err.len() < 8_000, "{}: {} bytes", words[0], said.err.len());
    }
}

/// The answer to a command whose input has no end.
fn of_endless(command: &mut Command) -> (Said, Duration) {
    let begun = Instant::now();
    let output = command.output().unwrap();
    (Said::of("endless", &output), begun.elapsed())
}

#[test]
fn endless_and_huge_input_is_an_error_with_the_limit_in_it() {
    let f = Folder::new("endless");
    // Files of this length take no room on the disk.
    for name in ["huge.yaml", "huge.unv", "huge.mat", "huge.csv"] {
        File::create(f.path(name)).unwrap().set_len(5 << 30).unwrap();
    }
    for line in [
        "check /dev/zero",
        "compare model.yaml /dev/zero",
        "update /dev/zero test.yaml",
        "identify /dev/zero",
        "health /dev/zero",
        "map model.yaml /dev/zero",
        "report model.yaml test.yaml --learn /dev/zero",
        "update model.yaml test.yaml --objective /dev/zero",
        "compare model.yaml test.yaml --profile huge.yaml",
        "check huge.yaml",
        "compare model.yaml huge.yaml",
        "identify huge.unv",
        "identify huge.mat",
        "identify shapes.csv --units SI --direction +z --geometry huge.csv",
        "undo huge.yaml",
    ] {
        // Memory enough for the limit, its copy and the program.
        let limited = format!("ulimit -v 4000000; exec \"$0\" {line}");
        let mut command = Command::new("sh");
        command.args(["-c", &limited, env!("CARGO_BIN_EXE_retune")]).current_dir(&f.0).env("RAYON_NUM_THREADS", "1");
        let (said, took) = of_endless(&mut command);
        assert!(said.code == 2 && took < SECONDS, "{line}: {took:?} {said:?}");
        assert!(said.err.contains("that are read") || said.err.contains("no more are read"), "{line}: {said:?}");
    }
    for line in ["check /dev/stdin", "compare model.yaml /dev/stdin", "identify /dev/stdin", "health /dev/stdin"] {
        let mut yes = Command::new("yes").stdout(Stdio::piped()).spawn().unwrap();
        let (said, took) = of_endless(f.line(line).stdin(yes.stdout.take().unwrap()));
        yes.wait().unwrap();
        assert!(said.code == 2 && took < SECONDS, "{line}: {took:?} {said:?}");
        assert!(said.err.contains("that are read") || said.err.contains("no more are read"), "{line}: {said:?}");
    }
}

#[test]
fn numbers_out_of_range_are_refused_with_the_range() {
    let f = Folder::new("range");
    for (line, word) in [
        ("compare model.yaml test.yaml --min-mac 90", "from 0 to 1"),
        ("compare model.yaml test.yaml --min-mac NaN", "from 0 to 1"),
        ("compare model.yaml test.yaml --frequency-window -1", "zero or above"),
        ("compare model.yaml test.yaml --bands 1 nan 3", "zero or above"),
        ("modes model.yaml -n -3", "from 1 to 2000"),
        ("modes model.yaml -n 0", "from 1 to 2000"),
        ("pretest model.yaml --sensors 0", "1 or above"),
        ("pretest model.yaml --noise-shape=-5%", "above zero"),
        ("update model.yaml test.yaml --budget 0", "1.."),
        ("update model.yaml test.yaml --budget -5", "-5"),
        ("update model.yaml test.yaml --seed -1", "-1"),
        ("update model.yaml test.yaml --reduced=2", "from 1e-9 to 0.1"),
        ("update model.yaml test.yaml --reduced=NaN", "from 1e-9 to 0.1"),
        ("sample model.yaml test.yaml --samples -5", "50..=1000000"),
        ("identify shapes.csv --band -5 30", "zero or above"),
        ("twin model.yaml -o x --band 30 5", "ascending"),
        ("identify shapes.csv --repeatability 0.1", "from 0 to 5 %"),
        ("identify shapes.csv --peak-height NaN", "zero or above"),
        ("identify shapes.csv --order 1", "from 2 to 400"),
        ("twin model.yaml -o x --noise-shape -5%", "from 0 to 1"),
        ("twin model.yaml -o x --damping nan", "--damping"),
        ("twin model.yaml -o x --averages 0", "from 1 to 10000"),
        ("map model.yaml test.yaml --tolerance -5mm", "zero or above"),
        ("learn model.yaml test.yaml --limit -1", "-1"),
        ("benchmark diagnosis --noise-factor 0", "above zero"),
        ("identify shapes.csv --direction ++z", "+x"),
        ("identify shapes.csv --direction -+z", "+x"),
    ] {
        let said = f.run(line);
        assert!(said.code == 2 && said.err.contains(word), "{line}: {said:?}");
        assert!(!said.err.contains("unexpected argument"), "{line}: {said:?}");
        assert!(!f.path("x").exists());
    }
}

/// Who owns a file that is overwritten stays its owner, where the system lets us.
#[test]
fn the_inode_of_a_file_changes_and_its_owner_does_not() {
    let f = Folder::new("owner");
    fs::write(f.path("out.yaml"), "old").unwrap();
    let before = fs::metadata(f.path("out.yaml")).unwrap();
    let mut open = File::open(f.path("out.yaml")).unwrap();
    assert_eq!(f.run("twin model.yaml -o out.yaml --modes 2 --force").code, 0);
    let after = fs::metadata(f.path("out.yaml")).unwrap();
    assert_eq!((before.uid(), before.gid()), (after.uid(), after.gid()));
    // One who had the old file open has it whole.
    let mut text = String::new();
    open.read_to_string(&mut text).unwrap();
    assert_eq!(text, "old");
}

#[test]
fn options_that_contradict_the_files_or_each_other_are_named() {
    let f = Folder::new("contradictions");
    for (line, word) in [
        (
            "identify shapes.csv --units SI --direction +z --band 3 30",
            "`--band`, `--method` and `--repeatability` identify modes from functions",
        ),
        ("identify shapes.csv --units SI --direction +z --method circle", "these files hold modes"),
        ("identify test.yaml", "test.yaml is a test file, which holds modes already"),
        ("identify model.yaml", "model.yaml is a model file"),
        ("health model.yaml", "model.yaml is a model file"),
        ("health test.yaml --direction +z", "--direction is for measurement files"),
        ("map model.yaml test.yaml --units SI", "--units is for measurement files"),
        ("twin model.yaml -o x --lines 50", "--frf"),
        ("twin model.yaml -o x --exciter tip", "--frf"),
        ("add model.yaml point-mass@tip --dry-run -o x", "cannot be used with"),
        ("update test.yaml model.yaml", "this is a model file; a test file begins with `retune_test: 1`"),
    ] {
        let said = f.run(line);
        assert!(said.code == 2 && said.err.contains(word), "{line}: {said:?}");
        assert!(!f.path("x").exists());
    }
}
