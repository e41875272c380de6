//! The house as drawn in ARCHITECTURE.md: who may import whom, how long a file may be, and that catalogues are complete.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Module -> modules of ours that it may name. Imports go to lower levels only.
const IMPORTS: &[(&str, &[&str])] = &[
    // packages below: `linalg`, and `base` with these rooms
    ("linalg", &[]),
    ("catalogue", &[]),
    ("deck", &[]),
    ("dof", &[]),
    ("hash", &[]),
    ("once", &[]),
    ("arrays", &["linalg"]),
    ("modal", &["linalg"]),
    ("units", &["catalogue"]),
    ("yaml", &["catalogue"]),
    ("data", &["linalg", "catalogue", "dof", "units", "yaml", "arrays"]),
    ("identify", &["linalg", "catalogue", "modal", "data"]),
    // level 0
    ("samples", &[]),
    ("mesh", &["catalogue", "deck"]),
    // level 1
    ("element", &["linalg", "catalogue", "dof"]),
    ("matrices", &["linalg", "catalogue", "hash", "arrays", "element"]),
    // level 2
    ("model", &["linalg", "catalogue", "hash", "once", "units", "yaml", "mesh", "element", "matrices", "modal"]),
    // level 3
    ("fault", &["linalg", "catalogue", "units", "model", "data", "identify"]),
    ("effect", &["linalg", "catalogue", "once", "units", "yaml", "element", "model", "modal"]),
    ("correlation", &["linalg", "catalogue", "units", "yaml", "element", "model", "modal", "data"]),
    // level 4
    ("objective", &["linalg", "catalogue", "once", "element", "model", "modal", "data", "correlation"]),
    // level 5: never model, modal or data
    ("optim", &["linalg", "catalogue", "hash", "once", "objective"]),
    // level 6
    (
        "update",
        &[
            "linalg",
            "catalogue",
            "units",
            "yaml",
            "element",
            "modal",
            "model",
            "data",
            "identify",
            "fault",
            "effect",
            "correlation",
            "objective",
            "optim",
        ],
    ),
    // packages above: `exchange`, `diagnosis`, `report`
    (
        "exchange",
        &[
            "deck",
            "linalg",
            "catalogue",
            "hash",
            "mesh",
            "units",
            "yaml",
            "element",
            "matrices",
            "modal",
            "model",
            "data",
        ],
    ),
    (
        "diagnosis",
        &[
            "linalg",
            "catalogue",
            "hash",
            "once",
            "samples",
            "units",
            "yaml",
            "element",
            "modal",
            "model",
            "data",
            "identify",
            "fault",
            "effect",
            "correlation",
            "objective",
            "optim",
            "update",
        ],
    ),
    // any; imported by nobody below the command
    (
        "report",
        &[
            "linalg",
            "catalogue",
            "units",
            "yaml",
            "element",
            "modal",
            "model",
            "data",
            "identify",
            "fault",
            "effect",
            "correlation",
            "objective",
            "optim",
            "update",
            "diagnosis",
        ],
    ),
];

/// The package below this one that has rooms of its own, which this one hands on.
const BASE: &str = "base/src";

/// Modules of the table that are packages of their own: `linalg` below, the others above.
const PACKAGES: &[&str] = &["linalg", "exchange", "diagnosis", "report"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn rust_files(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            rust_files(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

fn sources() -> Vec<PathBuf> {
    let mut files = Vec::new();
    rust_files(&root().join("src"), &mut files);
    rust_files(&root().join(BASE), &mut files);
    for package in PACKAGES {
        rust_files(&root().join(package).join("src"), &mut files);
    }
    files
}

/// The text of a file without comments and without what stands behind its first `#[cfg(test)]` on a module.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
    text[..end].lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

fn is_test_file(path: &Path) -> bool {
    let path = path.to_string_lossy();
    path.ends_with("tests.rs") || path.contains("/tests/") || path.contains("/fixture")
}

/// The module of `src/`, or the package, that a file belongs to.
fn module(path: &Path) -> String {
    if let Some(package) = PACKAGES.iter().find(|p| path.starts_with(root().join(p))) {
        return (*package).to_string();
    }
    let relative = path.strip_prefix(root().join("src")).or_else(|_| path.strip_prefix(root().join(BASE))).unwrap();
    let first = relative.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_string()
}

#[test]
fn imports_follow_the_table() {
    let table: BTreeMap<&str, &[&str]> = IMPORTS.iter().copied().collect();
    let mut wrong = Vec::new();
    for path in sources().into_iter().filter(|p| !is_test_file(p)) {
        let own = module(&path);
        if own == "lib" {
            continue;
        }
        let Some(allowed) = table.get(own.as_str()) else {
            wrong.push(format!("{}: module `{own}` is not in the import table", path.display()));
            continue;
        };
        let code = code(&path);
        // A package names the rooms of `src/` by the package they are in, and every other package by its name.
        let of_src = if PACKAGES.contains(&own.as_str()) { "retune::" } else { "crate::" };
        for prefix in [of_src, "retune_"] {
            for (i, _) in code.match_indices(prefix) {
                let rest = &code[i + prefix.len()..];
                let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if table.contains_key(name.as_str()) && name != own && !allowed.contains(&name.as_str()) {
                    wrong.push(format!("{}: `{own}` may not import `{name}`", path.display()));
                }
            }
        }
    }
    wrong.dedup();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Rooms of the diagnosis, each with those that it may import.
const ROOMS_OF_DIAGNOSIS: &[(&str, &[&str])] = &[
    ("problem", &[]),
    ("screen", &["problem"]),
    ("search", &["problem", "screen"]),
    ("verdict", &["problem", "screen", "search"]),
];

/// The files of a room, a folder counting as its file, each with those that it imports.
///
/// * `room` - from the sources of its package, `diagnosis/problem`; nothing for these as a whole
fn arrows(sources: &str, room: &str) -> BTreeMap<String, BTreeSet<String>> {
    let base = root().join(sources).join(room);
    let mut files = Vec::new();
    rust_files(&base, &mut files);
    let names: Vec<Vec<String>> = files
        .iter()
        .map(|p| p.strip_prefix(&base).unwrap().with_extension(""))
        .map(|p| p.iter().map(|c| c.to_string_lossy().into_owned()).collect())
        .collect();
    let known: BTreeSet<&String> = names.iter().map(|n| &n[0]).filter(|n| *n != "mod" && *n != "lib").collect();
    let mut out: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, name) in files.iter().zip(&names).filter(|(p, n)| n[0] != "mod" && n[0] != "lib" && !is_test_file(p)) {
        let text = code(path);
        let up = "super::".repeat(name.len());
        let crate_path =
            if room.is_empty() { "crate::".to_string() } else { format!("crate::{}::", room.replace('/', "::")) };
        for prefix in [up.as_str(), &crate_path] {
            for (at, _) in text.match_indices(prefix) {
                let before = text[..at].chars().next_back();
                if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                    continue;
                }
                let rest = &text[at + prefix.len()..];
                let list = rest.strip_prefix('{').and_then(|r| r.split('}').next());
                let list = list
                    .unwrap_or_else(|| rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or(""));
                let words = list.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                let of_room = words.filter(|w| known.iter().any(|k| k == w) && *w != name[0]);
                out.entry(name[0].clone()).or_default().extend(of_room.map(str::to_string));
            }
        }
    }
    out
}

/// Every folder below `base`, and itself, from it.
fn rooms(base: &Path, room: &str, out: &mut Vec<String>) {
    out.push(room.to_string());
    for entry in fs::read_dir(base.join(room)).unwrap().map(|e| e.unwrap()).filter(|e| e.path().is_dir()) {
        let name = entry.file_name().to_string_lossy().into_owned();
        rooms(base, &if room.is_empty() { name } else { format!("{room}/{name}") }, out);
    }
}

#[test]
fn no_room_has_a_circle_of_imports() {
    let (mut seen, mut circles) = (0, Vec::new());
    for sources in ["src", BASE, "linalg/src", "exchange/src", "diagnosis/src", "report/src", "cli/src", "python/src"] {
        let mut all = Vec::new();
        rooms(&root().join(sources), "", &mut all);
        for room in all {
            let mut arrows = arrows(sources, &room);
            seen += arrows.values().map(BTreeSet::len).sum::<usize>();
            // Files that import nothing that is left are taken away, until none is.
            while let Some(last) =
                arrows.iter().find(|(_, to)| !to.iter().any(|t| arrows.contains_key(t))).map(|(n, _)| n.clone())
            {
                arrows.remove(&last);
            }
            if !arrows.is_empty() {
                circles.push(format!("{sources}/{room}: among {:?}", arrows.keys().collect::<Vec<_>>()));
            }
        }
    }
    assert!(seen > 500, "the arrows are not found: {seen}");
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn rooms_of_the_diagnosis_stand_on_each_other() {
    let arrows = arrows("diagnosis/src", "");
    for (room, below) in ROOMS_OF_DIAGNOSIS {
        let rooms = arrows[*room].iter().filter(|to| ROOMS_OF_DIAGNOSIS.iter().any(|(other, _)| other == to));
        let wrong: Vec<&String> = rooms.filter(|to| !below.contains(&to.as_str())).collect();
        assert!(wrong.is_empty(), "`{room}` may not import {wrong:?}");
    }
}

/// Cargo does not look for tests here (`autotests = false`), so that a file that nobody names would never run.
#[test]
fn every_file_of_tests_is_run() {
    for package in [root(), root().join("cli")] {
        let (tests, manifest) = (package.join("tests"), package.join("Cargo.toml"));
        let (all, manifest) = (tests.join("all.rs"), fs::read_to_string(manifest).unwrap());
        let all = fs::read_to_string(all).unwrap();
        for entry in fs::read_dir(&tests).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let is_test = path.extension().is_some_and(|e| e == "rs") || path.join("main.rs").exists();
            let is_run =
                all.contains(&format!("\nmod {name};")) || manifest.contains(&format!("[[test]]\nname = \"{name}\""));
            assert!(!is_test || is_run, "{} is named neither in tests/all.rs nor in Cargo.toml", path.display());
        }
    }
}

#[test]
fn the_table_goes_down_only() {
    for (i, (module, allowed)) in IMPORTS.iter().enumerate() {
        for import in *allowed {
            let j = IMPORTS.iter().position(|m| m.0 == *import).unwrap();
            assert!(j < i, "`{module}` imports `{import}`, which stands above it");
        }
    }
}

#[test]
fn every_module_is_in_the_table() {
    let text = ["src", BASE].map(|sources| fs::read_to_string(root().join(sources).join("lib.rs")).unwrap()).concat();
    for line in text.lines().filter_map(|l| l.strip_prefix("pub mod ")) {
        let name = line.trim_end_matches(';');
        assert!(IMPORTS.iter().any(|m| m.0 == name), "`{name}` is not in the import table");
    }
}

#[test]
fn crates_that_may_be_replaced_are_named_in_one_room() {
    for path in sources().into_iter().filter(|p| !is_test_file(p)) {
        let code = code(&path);
        let own = module(&path);
        for (words, home) in [
            (&["faer::"][..], "linalg"),
            (&["serde_yaml::", "saphyr_parser::"][..], "yaml"),
            (&["sha2::"][..], "hash"),
            (&["OnceLock"][..], "once"),
        ] {
            for word in words {
                assert!(own == home || !code.contains(word), "{} names {word}", path.display());
            }
        }
    }
}

#[test]
fn no_file_is_longer_than_six_hundred_lines_without_tests() {
    let mut long = Vec::new();
    let mut files = sources();
    for folder in ["cli/src", "tools/src", "examples", "benches"] {
        rust_files(&root().join(folder), &mut files);
    }
    for path in files.into_iter().filter(|p| !is_test_file(p)) {
        let text = fs::read_to_string(&path).unwrap();
        let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
        let lines = text[..end].lines().count();
        if lines > 600 {
            long.push(format!("{}: {lines} lines", path.display()));
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

/// Files of a catalogue's folder that are not members.
const NOT_MEMBERS: &[(&str, &[&str])] = &[
    ("src/element", &["mod", "conformance", "direction", "input", "joint", "meshed", "strain_field", "tests"]),
    ("src/objective/residual", &["mod", "tests"]),
    ("src/matrices", &["mod", "tests", "coordinate_systems", "error", "inspect", "matrix", "process", "text", "write"]),
];

#[test]
fn every_file_of_a_catalogue_folder_is_listed() {
    for (folder, others) in NOT_MEMBERS {
        let list = fs::read_to_string(root().join(folder).join("mod.rs")).unwrap();
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            if path.extension().is_some_and(|e| e == "rs") && !others.contains(&stem.as_str()) {
                assert!(list.contains(&format!("    {stem}::")), "{folder}: `{stem}` is not listed");
            }
        }
    }
}

/// The front end of the report: TypeScript with the limit of Rust.
#[test]
fn no_typescript_file_is_longer_than_six_hundred_lines() {
    let mut long = Vec::new();
    let web = root().join("report/web");
    let mut folders = vec![web.join("src"), web.join("test")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "ts" || e == "css") {
                let lines = fs::read_to_string(&path).unwrap().lines().count();
                if lines > 600 {
                    long.push(format!("{}: {lines} lines", path.display()));
                }
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}
