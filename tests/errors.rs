//! Wrong model and test files, each with the exact messages beside it; and that no file whatever makes the program panic,
//! hang or fill the memory.
//!
//! `tests/errors/NAME.yaml` is the file, `NAME.txt` what is reported: one `line:column: severity: path: message` a line,
//! errors first. Names of test files start with `test_`; they are read against `models/verification/lumped_cantilever.yaml`.
//! After a change of wording, read every difference as the engineer who gets the message, then write them anew:
//!
//! ```text
//! RETUNE_BLESS=1 cargo test --test all errors::
//! ```

#![allow(clippy::format_collect, reason = "texts of a few lines, where reading matters more than one allocation")]

use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use retune::correlation::check_sensors;
use retune::data::read_test;
use retune::model::{Model, ParametricModel, Registry, lint, load};
use retune::yaml::{Problem, SourceMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn builtin(text: &str) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    load(text, &Registry::builtin())
}

fn cantilever() -> Model {
    builtin(&read(&root().join("models/verification/lumped_cantilever.yaml"))).unwrap().0
}

/// What `retune check` says of a model file.
fn model_problems(text: &str) -> Vec<Problem> {
    match builtin(text) {
        Err(problems) => problems,
        Ok((model, mut problems, map)) => {
            let sound = lint(&model).unwrap();
            problems.extend(map.place(sound.errors));
            problems.extend(map.place(sound.warnings));
            problems
        }
    }
}

/// What `retune compare` says of a test file.
fn test_problems(text: &str) -> Vec<Problem> {
    match read_test(text) {
        Err(problems) => problems,
        Ok((test, mut problems)) => {
            problems.extend(SourceMap::of(text).place(check_sensors(&cantilever(), &test.sensors)));
            problems
        }
    }
}

fn render(mut problems: Vec<Problem>) -> String {
    problems.sort_by_key(|p| (std::cmp::Reverse(p.severity), p.location));
    problems.iter().map(|p| p.render("").trim_start_matches([':', ' ']).to_string() + "\n").collect()
}

fn yaml_files(folder: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(root().join(folder))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "yaml"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_wrong_file_gets_its_exact_messages() {
    let bless = std::env::var_os("RETUNE_BLESS").is_some();
    let files = yaml_files("tests/errors");
    assert!(files.len() >= 45, "{} wrong files", files.len());
    let mut wrong = Vec::new();
    for path in files {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let text = read(&path);
        let said = render(if name.starts_with("test_") { test_problems(&text) } else { model_problems(&text) });
        if said.is_empty() {
            wrong.push(format!("{name} passes silently"));
        }
        let beside = path.with_extension("txt");
        if bless {
            fs::write(&beside, &said).unwrap();
        } else if fs::read_to_string(&beside).unwrap_or_default() != said {
            wrong.push(format!("{name}\n{said}"));
        }
    }
    assert!(wrong.is_empty(), "these messages differ from the files beside them:\n{}", wrong.join("\n"));
}

/// The file that the wrong test files are read against is itself without reproach.
#[test]
fn the_right_file_gets_no_message() {
    let text = read(&root().join("models/verification/lumped_cantilever.yaml"));
    assert_eq!(render(model_problems(&text)), "");
}

/// Words that break parsers, numbers that fill memories.
const TOKENS: &[&str] = &[
    "4000000000",
    "-1",
    "1e308",
    "1e-320",
    "1e999",
    ".nan",
    ".inf",
    "null",
    "~",
    "true",
    "''",
    "\"",
    "'",
    "[",
    "]",
    "{",
    "}",
    ":",
    ": ",
    ",",
    "-",
    "- ",
    "#",
    "&a",
    "*a",
    "<<",
    "!!binary",
    "!x",
    "|",
    ">",
    "---\n",
    "...\n",
    "\t",
    "\n",
    "\r",
    "\u{feff}",
    "\u{0}",
    "é",
    "µ",
    "²",
    "0",
    "0 m",
    "1 GPa",
    "m^99",
    "kg/m/s/N",
    "E_wing",
    "E_wing * m1",
    "n1",
    "n99",
    "subdivide: 10000",
    "nodes",
    "uz",
    "m1 + m1",
    "1/0",
    "*",
    "/",
    "(",
    ")",
    "^",
    "+",
    "%",
];

/// One change of a text: its kind, two places as fractions of the text, a token.
type Mutation = (u8, f64, f64, usize);

fn boundary(text: &str, fraction: f64) -> usize {
    let mut i = (fraction * text.len() as f64) as usize;
    while !text.is_char_boundary(i) {
        i -= 1;
    }
    i
}

/// Start and end of the word around a place.
fn word(text: &str, at: usize) -> (usize, usize) {
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '+');
    let start = text[..at].rfind(|c| !is_word(c)).map_or(0, |i| i + text[i..].chars().next().map_or(1, char::len_utf8));
    let end = text[at..].find(|c| !is_word(c)).map_or(text.len(), |i| at + i);
    (start, end)
}

fn mutate(text: &mut String, &(kind, a, b, token): &Mutation) {
    let (i, j) = (boundary(text, a), boundary(text, b));
    let token = TOKENS[token % TOKENS.len()];
    match kind {
        0 => text.insert_str(i, token),
        1 => {
            let end = text[i..].char_indices().nth(1 + (b * 12.0) as usize).map_or(text.len(), |(k, _)| i + k);
            text.replace_range(i..end, "");
        }
        2 => {
            let (start, end) = word(text, i);
            text.replace_range(start..end, token);
        }
        3 => {
            let (start, end) = word(text, i);
            let (from, to) = word(text, j);
            let other = text[from..to].to_string();
            text.replace_range(start..end, &other);
        }
        4 => {
            let line = text[j..].lines().next().unwrap_or_default().to_string() + "\n";
            let at = text[..i].rfind('\n').map_or(0, |k| k + 1);
            text.insert_str(at, &line);
        }
        _ => text.truncate(i),
    }
}

/// Peak memory of this process, bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kb| 1024 * kb)
}

/// Mutated files are read or refused: no panic, no hang, no memory without bound. `RETUNE_FUZZ_CASES` for more of them.
#[test]
fn mutated_files_never_panic() {
    let cases = std::env::var("RETUNE_FUZZ_CASES").ok().and_then(|c| c.parse().ok()).unwrap_or(2000);
    let mut texts: Vec<String> =
        yaml_files("models").iter().chain(&yaml_files("models/verification")).map(|p| read(p)).collect();
    texts.push(GOOD_TEST.to_string());
    let model = cantilever();
    let mutation = (0u8..6, 0.0..1.0f64, 0.0..1.0f64, 0..TOKENS.len());
    let strategy = (0..texts.len(), prop::collection::vec(mutation, 1..5));
    let mut runner = TestRunner::new(Config { cases, max_shrink_iters: 200, ..Config::with_source_file(file!()) });
    runner
        .run(&strategy, |(which, mutations)| {
            let mut text = texts[which].clone();
            for m in &mutations {
                mutate(&mut text, m);
            }
            let start = Instant::now();
            if let Ok((model, ..)) = builtin(&text)
                && model.dof_map().n_dof() <= 150
            {
                let _ = lint(&model);
            }
            if let Ok((test, _)) = read_test(&text) {
                let _ = check_sensors(&model, &test.sensors);
            }
            // A file takes milliseconds; a busy machine gets its share.
            prop_assert!(start.elapsed() < Duration::from_secs(20), "it took {:?}", start.elapsed());
            Ok(())
        })
        .unwrap();
    if let Some(bytes) = peak_memory() {
        assert!(bytes < 4 << 30, "reading took {} MB", bytes >> 20);
    }
}

const GOOD_TEST: &str = "\
retune_test: 1
name: hammer test of the cantilever
sources:
  bench: {kind: measured, text: hammer}
sensors:
  middle: {element: cantilever, fraction: 0.5, direction: +z}
  tip: {node: tip, direction: [0, 0.6, 0.8], position: [1 m, 0 m, 3 mm], mass: 2 g}
defaults: {frequency_sd: 0.5 %, shape_sd: 3 %}
modes:
  - {frequency: 3.9 Hz, source: bench, shape: {real: [0.35, 1.0], imaginary: [0.1, null]}}
  - {frequency: 24.8 Hz, damping: 0.4 %, source: bench, shape: {real: [-0.9, 1.0], sds: [0.1, 0.1]}}
mass_properties:
  mass: {value: 0.885 kg, sd: 5 g, source: bench}
";

/// Files made to break parsers: too long, too deep, too many.
#[test]
fn hostile_files_are_refused_quickly() {
    let long = "x".repeat(2_000_000);
    let nodes: String = (0..5000).map(|i| format!("  n{i}: [{i} mm, 0 m, 0 m]\n")).collect();
    let chain: String = (0..5000).map(|i| format!("n{i}, ")).collect();
    for text in [
        format!("retune: 1\nname: x\nnodes: {{{long}: [0, 0, 0]}}\nbeams: {{b: {{nodes: [{long}y, a]}}}}\n"),
        format!("retune: 1\nname: x\nnodes:\n{nodes}beams: {{b: {{chain: [{chain}], properties: {{EA: 1}}}}}}\n"),
        "[".repeat(200_000),
        "{a: ".repeat(200_000),
        "- ".repeat(200_000),
        format!("retune: 1\nname: x\nnodes: {{a: [{}0, 0, 0]}}\n", "1+".repeat(300_000)),
        format!("retune: 1\nname: x\nnodes: {{a: [1 {}, 0, 0]}}\n", "m".repeat(1_000_000)),
        format!("retune: 1\nname: x\nnodes: {{a: [1{}, 0, 0]}}\n", "0".repeat(1_000_000)),
        format!("retune: 1\nname: x\nnodes: {{a: {{between: [a, a]}}}}\n{}", "#".repeat(1_000_000)),
    ] {
        let start = Instant::now();
        assert!(builtin(&text).is_err(), "{}", &text[..60]);
        assert!(start.elapsed() < Duration::from_secs(30), "{:?} for {}", start.elapsed(), &text[..60]);
    }
}

/// Models that are right and large in one way: a result in seconds where a recursion ended the stack, or a loop within a loop took minutes.
#[test]
fn long_models_are_built_in_seconds() {
    let n = 20_000;
    let head = "retune: 1\nname: long\nactive_dofs: [uz, ry]\n";
    let names = |from: usize| (from..n).map(|i| format!("n{i}")).collect::<Vec<_>>().join(", ");
    let beam =
        format!("beams: {{m: {{chain: [{}], properties: {{EIy: 1 N m2, mass_per_length: 1 kg/m}}}}}}\n", names(0));
    let rules = |rule: &dyn Fn(usize) -> String| (0..n).map(|i| format!("  n{i}: {}\n", rule(i))).collect::<String>();
    let line = rules(&|i| format!("[{i} mm, 0, 0]"));
    // Every node beside the next one, so that the first place needs all others.
    let backwards = rules(&|i| {
        if i + 1 == n { "[0, 0, 0]".into() } else { format!("{{from: n{}, offset: [-1 mm, 0, 0]}}", i + 1) }
    });
    let links = |order: &dyn Fn(usize) -> usize| {
        (1..n).map(order).map(|i| format!("  l{i}: {{master: n{i}, slaves: [n{}]}}\n", i - 1)).collect::<String>()
    };
    let spring = format!(
        "springs: {{s: {{node: n{}, k: {{uz: 1 N/m, ry: 1 N m/rad}}}}}}\nmasses: {{m: {{node: n0, mass: 1 kg}}}}\n",
        n - 1
    );
    let small = "nodes: {a: [0, 0, 0], b: [1 m, 0, 0]}\nbeams: {m: {nodes: [a, b], properties: {EIy: 1 N m2, mass_per_length: 1 kg/m}}}\nsupports: {s: {node: a}}\n";
    let parameters: String = (0..160).map(|i| format!("  p{i}: {{value: 1, bounds: [0.5, 2]}}\n")).collect();
    let factors: String = (0..160).map(|i| format!("  f{i}: {{of: [m], scale: {{EIy: p{i}}}}}\n")).collect();
    let addends: String =
        (0..80).map(|i| format!("  f{i}: {{of: [m], add: {{EIy: p{i}, mass_per_length: p{}}}}}\n", i + 80)).collect();
    let configurations: String =
        (0..5000).map(|i| format!("  c{i}: {{without: [s], supports: {{t{i}: {{node: b}}}}}}\n")).collect();
    for (what, text) in [
        ("a chain", format!("{head}nodes:\n{line}{beam}supports: {{s: {{node: n0}}}}\n")),
        ("places from places", format!("{head}nodes:\n{backwards}{beam}supports: {{s: {{node: n0}}}}\n")),
        ("links first to last", format!("{head}nodes:\n{line}rigid_links:\n{}{spring}", links(&|k| k))),
        ("links last to first", format!("{head}nodes:\n{line}rigid_links:\n{}{spring}", links(&|k| n - k))),
        ("a product of parameters", format!("{head}parameters:\n{parameters}{small}overrides:\n{factors}")),
        ("a sum of parameters", format!("{head}parameters:\n{parameters}{small}overrides:\n{addends}")),
        ("configurations", format!("{head}{small}configurations:\n{configurations}")),
    ] {
        let start = Instant::now();
        let model = builtin(&text).unwrap_or_else(|p| panic!("{what}: {}", p[0].render(""))).0;
        if model.dof_map().n_dof() < 100 {
            lint(&model).unwrap();
        }
        // A second or two each on an idle machine.
        assert!(start.elapsed() < Duration::from_secs(40), "{what} took {:?}", start.elapsed());
    }
}
