//! The book: its commands run, its snippets are read, its links lead somewhere, and its reference is what the command writes.
//!
//! On pages of the guide and the how-tos a fenced block means what its first line says:
//!
//! ```text
//! yaml,file=NAME     the file NAME, whole
//! yaml,append=NAME   the next part of the file NAME
//! yaml,part=NAME     lines that stand in the file NAME, in this order
//! sh                 commands; they run, one after another, in the folder of the page
//! text               after `sh`: lines that the commands print, in this order; `...` stands for others
//! text,shown         lines that other machines may print with other digits: shown only, as console, python and others
//! ```
//!
//! Commands are those of `retune`, `cd`, and `sed -i '/FIRST/,/LAST/ s/one/other/' FILE`. A command may end in `# exit code N`. Pages of the reference are written anew by `RETUNE_WRITE=1 cargo test -p retune-cli --test all documents`.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// All files of Markdown below a folder.
fn pages_in(folder: &Path) -> Vec<PathBuf> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.unwrap().path();
        if path.is_dir() {
            pages.extend(pages_in(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            pages.push(path);
        }
    }
    pages.sort();
    pages
}

/// A fenced block: the line of its fence, what the fence says, and its text.
struct Block {
    line: usize,
    info: String,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (i, line) in page.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(info)) => {
                open = Some(Block { line: i + 1, info: info.trim().to_string(), text: String::new() });
            }
            (Some(_), Some("")) => blocks.extend(open.take()),
            (Some(block), _) => block.text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

/// The words of a command, with quotes as in a shell.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match (quote, c) {
            (Some(q), _) if c == q => quote = None,
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, ' ') => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// A command and the exit code that it is said to have.
fn command(line: &str) -> (Vec<String>, i32) {
    let (line, comment) = line.split_once(" #").unwrap_or((line, ""));
    let code = comment.trim().strip_prefix("exit code ").map_or(0, |n| n.trim().parse().unwrap());
    (words(line), code)
}

/// `/FIRST/,/LAST/ s/one/other/`: in the lines from the first that holds FIRST to the next that holds LAST.
fn replaced(text: &str, edit: &str) -> String {
    let ["", first, ",", last, " s", one, other, ""] = edit.split('/').collect::<Vec<_>>()[..] else {
        panic!("`{edit}` is not of the form `/FIRST/,/LAST/ s/one/other/`")
    };
    let (mut is_begun, mut is_done) = (false, false);
    let mut out = String::new();
    for line in text.lines() {
        is_begun |= line.contains(first);
        let is_in = is_begun && !is_done;
        out += &if is_in { line.replacen(one, other, 1) } else { line.to_string() };
        out.push('\n');
        is_done |= is_in && line.contains(last);
    }
    out
}

fn squeezed(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs a page in a folder of its own; the first thing that is not as the page says.
fn perform(page: &Path) -> Result<(), String> {
    let text = fs::read_to_string(page).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut at = folder.path().to_path_buf();
    let mut printed: Option<String> = None;
    for block in blocks(&text) {
        let here = format!("{}:{}", page.display(), block.line);
        let (kind, option) = block.info.split_once(',').unwrap_or((&block.info, ""));
        let said = if block.info == "text" { printed.take() } else { None };
        match (kind, option.split_once('=')) {
            ("yaml" | "csv" | "nastran", Some((how, name))) => {
                let path = at.join(name);
                if how == "part" {
                    let whole = fs::read_to_string(&path).map_err(|e| format!("{here}: {name}: {e}"))?;
                    let mut lines = whole.lines().map(squeezed);
                    for expected in block.text.lines().map(squeezed).filter(|l| !l.is_empty() && l != "...") {
                        if !lines.any(|line| line == expected) {
                            return Err(format!("{here}: `{expected}` does not stand in {name} in this order"));
                        }
                    }
                    continue;
                }
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                let before = match how {
                    "file" => String::new(),
                    "append" => fs::read_to_string(&path).map_err(|e| format!("{here}: {name}: {e}"))?,
                    _ => return Err(format!("{here}: a block says `file=`, `append=` or `part=`, not `{how}=`")),
                };
                fs::write(path, before + &block.text).unwrap();
            }
            ("yaml", None) => return Err(format!("{here}: a block of YAML says to which file it belongs")),
            ("sh", _) => {
                let mut out = String::new();
                for line in
                    block.text.replace("\\\n", " ").lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'))
                {
                    let (words, code) = command(line);
                    if words[0] == "cd" {
                        at = at.join(&words[1]);
                        continue;
                    }
                    if let ["sed", "-i", edit, name] = words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
                        let text = fs::read_to_string(at.join(name)).unwrap();
                        let edited = replaced(&text, edit);
                        if edited == text {
                            return Err(format!("{here}: `{line}` changes nothing"));
                        }
                        fs::write(at.join(name), edited).unwrap();
                        continue;
                    }
                    if words[0] != "retune" {
                        return Err(format!("{here}: `{}` is not run: show it in a block `console`", words[0]));
                    }
                    let done = Command::new(env!("CARGO_BIN_EXE_retune"))
                        .args(&words[1..])
                        .current_dir(&at)
                        .stdin(Stdio::null())
                        .env("COLUMNS", "100")
                        .output()
                        .unwrap();
                    let said =
                        format!("{}{}", String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
                    if done.status.code() != Some(code) {
                        return Err(format!(
                            "{here}: `{line}` ended with {:?}, not {code}:\n{said}",
                            done.status.code()
                        ));
                    }
                    out += &said;
                }
                printed = Some(out);
            }
            ("text", None) if option != "shown" => {
                let Some(said) = said else { continue };
                let mut lines = said.lines().map(squeezed);
                for expected in block.text.lines().map(squeezed).filter(|l| !l.is_empty() && l != "...") {
                    if !lines.any(|line| line == expected) {
                        return Err(format!("{here}: nothing prints `{expected}` in this order; there is\n{said}"));
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

#[test]
fn every_command_and_snippet_of_the_guide_and_the_how_tos_runs() {
    let docs = root().join("docs");
    let mut pages = pages_in(&docs.join("guide"));
    pages.extend(pages_in(&docs.join("how-to")));
    assert!(pages.len() > 10, "only {} pages", pages.len());
    if let Ok(wanted) = std::env::var("RETUNE_PAGE") {
        pages.retain(|page| page.to_string_lossy().contains(&wanted));
    }
    let failures: Vec<String> = pages
        .iter()
        .filter_map(|page| {
            let start = Instant::now();
            let failure = perform(page).err();
            println!("{:6.1} s  {}", start.elapsed().as_secs_f64(), page.display());
            failure
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

fn run(folder: &Path, line: &str) -> String {
    let done = Command::new(env!("CARGO_BIN_EXE_retune"))
        .args(words(line))
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(matches!(done.status.code(), Some(0 | 1)), "{line}: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// Pages of the reference and the commands that write them.
const REFERENCE: [(&str, &str); 15] = [
    ("command-line.md", "list verbs --markdown"),
    ("exit-codes.md", "list exit-codes --markdown"),
    ("units.md", "list units --markdown"),
    ("elements.md", "list elements --markdown"),
    ("effects.md", "list effects --markdown"),
    ("faults.md", "list faults --markdown"),
    ("residuals.md", "list residuals --markdown"),
    ("optimizers.md", "list optimizers --markdown"),
    ("profiles.md", "list profiles --markdown"),
    ("matrix-formats.md", "list matrices --markdown"),
    ("model-file.md", "schema model --markdown"),
    ("test-file.md", "schema test --markdown"),
    ("objective-file.md", "schema objective --markdown"),
    ("profile-file.md", "schema profiles --markdown"),
    ("optimizer-settings.md", "schema optimizer --markdown"),
];

fn committed_or_written(name: &str, text: &str) -> bool {
    let path = root().join("docs/reference").join(name);
    if std::env::var_os("RETUNE_WRITE").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
    }
    fs::read_to_string(&path).is_ok_and(|committed| committed == text)
}

#[test]
fn the_reference_is_what_the_command_writes() {
    let stale: Vec<&str> = REFERENCE
        .iter()
        .filter(|(name, line)| !committed_or_written(name, &run(&root(), line)))
        .map(|(name, _)| *name)
        .collect();
    assert!(
        stale.is_empty(),
        "docs/reference is not what the command writes: {}; `RETUNE_WRITE=1 cargo test -p retune-cli --test all documents` writes it anew",
        stale.join(", ")
    );
}

/// Verbs with `--json`, on what `retune init beam` writes.
const ANSWERS: [&str; 17] = [
    "check model.yaml",
    "modes model.yaml",
    "compare model.yaml test.yaml",
    "pretest model.yaml -n 3",
    "sensitivity model.yaml test.yaml",
    "update model.yaml test.yaml",
    "sample model.yaml test.yaml --samples 50",
    "diagnose model.yaml test.yaml --effects point-mass,sprung-mass",
    "learn model.yaml test.yaml --effects point-mass",
    "report model.yaml test.yaml",
    "twin model.yaml -o twin.yaml --frf twin.unv --band 2 200 --lines 400 --exciter tip.uz --noise-response '0.5 %' --noise-force '0.1 %'",
    "identify twin.unv --units SI -o gvt.yaml --force",
    "health twin.unv --units SI",
    "map model.yaml gvt.yaml",
    "matrices matrices_K.mtx matrices_M.mtx matrices_dofs.csv",
    "list elements",
    "benchmark diagnosis --structure cantilever --null 1 --effects 0 --faults 0 --outside 0",
];

/// The keys of an answer with the kinds of their values; entries of lists are taken together.
fn keys_of(value: &Value, path: &str, out: &mut Vec<(String, BTreeSet<&'static str>)>) {
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "`true` or `false`",
        Value::Number(_) => "number",
        Value::String(_) => "text",
        Value::Array(_) => "list",
        Value::Object(_) => "object",
    };
    if !path.is_empty() {
        match out.iter_mut().find(|(known, _)| known == path) {
            Some((_, kinds)) => {
                kinds.insert(kind);
            }
            None => out.push((path.to_string(), BTreeSet::from([kind]))),
        }
    }
    match value {
        Value::Array(items) => items.iter().for_each(|item| match item {
            Value::Array(_) | Value::Object(_) => keys_of(item, &format!("{path}[]"), out),
            _ => {}
        }),
        Value::Object(map) => {
            for (key, value) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                keys_of(value, &path, out);
            }
        }
        _ => {}
    }
}

#[test]
fn the_reference_has_the_json_of_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "init beam");
    run(folder.path(), "export model.yaml --matrices -o matrices");
    let mut text = String::from(
        "<!-- Written by `RETUNE_WRITE=1 cargo test -p retune-cli --test all documents`; a test compares. -->\n\n# JSON of every verb\n\n\
         Keys of what verbs print with `--json`, as these commands print them on the project that `retune init beam` writes. `[]` stands \
         for every entry of a list. Where a key has no value it is `null` or absent. Quantities are in SI unless the key names a unit.\n",
    );
    for line in ANSWERS {
        let answer = run(folder.path(), &format!("{line} --json"));
        let answer: Value = serde_json::from_str(&answer).unwrap_or_else(|e| panic!("{line}: {e}\n{answer}"));
        let mut keys = Vec::new();
        keys_of(&answer, "", &mut keys);
        let verb = line.split(' ').next().unwrap();
        text += &format!("\n## {verb}\n\n```text\nretune {line} --json\n```\n\n| key | value |\n| --- | --- |\n");
        for (path, kinds) in keys {
            text += &format!("| `{path}` | {} |\n", kinds.into_iter().collect::<Vec<_>>().join(", "));
        }
    }
    assert!(
        committed_or_written("json.md", &text),
        "docs/reference/json.md is not what the verbs print; `RETUNE_WRITE=1 cargo test -p retune-cli --test all documents` writes it anew"
    );
}

/// The anchor of a heading, as mdBook makes it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    kept.chars()
        .filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '_' || c == '-' => Some(c),
            _ => None,
        })
        .collect()
}

fn anchors(page: &str) -> BTreeSet<String> {
    let mut is_code = false;
    let mut out = BTreeSet::new();
    for line in page.lines() {
        is_code ^= line.starts_with("```");
        if let Some(heading) = line.strip_prefix('#').filter(|_| !is_code) {
            out.insert(anchor(&heading.trim_start_matches('#').replace('`', "")));
        }
    }
    out
}

#[test]
fn every_link_leads_somewhere() {
    let root = root();
    let mut pages = pages_in(&root.join("docs"));
    for name in ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "CODE_OF_CONDUCT.md"]
    {
        pages.extend([root.join(name)].into_iter().filter(|p| p.exists()));
    }
    let mut broken = Vec::new();
    for page in &pages {
        let text = fs::read_to_string(page).unwrap();
        // A link may have code as its text, so that code is not taken out of the whole.
        let text = text.split("```").step_by(2).collect::<Vec<_>>().join("");
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.starts_with("http") || link.starts_with("mailto:") || link.contains(' ') || link.is_empty() {
                continue;
            }
            let (file, fragment) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let Ok(there) = fs::read_to_string(&target) else {
                broken.push(format!("{}: {link}", page.display()));
                continue;
            };
            if !fragment.is_empty() && !anchors(&there).contains(fragment) {
                broken.push(format!("{}: {link}: no such heading", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_page_is_in_the_table_of_contents() {
    let docs = root().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<PathBuf> =
        summary.split("](").skip(1).filter_map(|r| r.split(')').next()).map(|p| docs.join(p)).collect();
    let there: BTreeSet<PathBuf> = pages_in(&docs).into_iter().filter(|p| !p.ends_with("SUMMARY.md")).collect();
    let missing: Vec<&PathBuf> = there.symmetric_difference(&listed).collect();
    assert!(missing.is_empty(), "in one of docs/ and docs/SUMMARY.md only: {missing:?}");
}

/// `docs/…` in comments, messages and pages.
#[test]
fn pages_that_sources_name_exist() {
    fn files(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                if !matches!(name.as_str(), "target" | "node_modules") && !name.starts_with('.') {
                    files(&path, out);
                }
            } else if matches!(path.extension().and_then(|e| e.to_str()), Some("rs" | "md" | "yaml" | "py" | "toml")) {
                out.push(path);
            }
        }
    }
    let root = root();
    let mut all = Vec::new();
    files(&root, &mut all);
    let mut missing = Vec::new();
    for path in all.iter().filter(|p| !p.ends_with("tests/published.rs") && !p.ends_with("cli/tests/documents.rs")) {
        let text = fs::read_to_string(path).unwrap();
        for rest in text.split("docs/").skip(1) {
            let end =
                rest.find(|c: char| !(c.is_alphanumeric() || matches!(c, '-' | '_' | '/' | '.'))).unwrap_or(rest.len());
            let name = rest[..end].trim_end_matches('.');
            let is_page = Path::new(name).extension().is_some_and(|e| e == "md");
            if is_page && !root.join("docs").join(name).exists() {
                missing.push(format!("{}: docs/{name}", path.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}
