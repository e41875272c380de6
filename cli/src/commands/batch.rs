//! `retune batch`

use crate::args::Batch;
use crate::output::{Failure, print, shown};
use crate::progress::bar;
use crate::{BUG, DONE, SHORT, again, files, ledger, writing};
use retune::catalogue::counted;
use retune::data::read_test;
use retune::hash::Hash;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Bytes of a file that a result depends on, at most.
const LARGEST: u64 = 8 << 30;

/// What came of a job, as a line of its file: key, verb, names of the tests, result, error, warnings. `retune.batch` of the Python package
/// writes the same.
#[derive(Debug)]
pub(crate) struct Done {
    /// The hash of what it was made of, which is the name of its file.
    pub(crate) key: String,
    /// Names of its tests.
    tests: Vec<String>,
    content: Value,
}

impl Done {
    /// From a line; nothing where it is not a result.
    pub(crate) fn from_line(line: &str) -> Option<Self> {
        let content: Value = serde_json::from_str(line).ok()?;
        let has = |name: &str| content.get(name).is_some();
        let key = content.get("key")?.as_str()?.to_string();
        let tests =
            content.get("tests")?.as_array()?.iter().map(|t| Some(t.as_str()?.to_string())).collect::<Option<_>>()?;
        ["verb", "result", "error", "warnings"].into_iter().all(has).then_some(Self { key, tests, content })
    }

    fn is_error(&self) -> bool {
        !self.content["error"].is_null()
    }

    fn line(&self) -> String {
        format!("{}\n", self.content)
    }
}

/// A job: a test, and the hash of everything that its result depends on.
struct Job<'a> {
    test: &'a Path,
    name: String,
    key: String,
}

pub(crate) fn run(args: &Batch) -> Result<u8, Failure> {
    if let Some(output) = &args.output {
        writing::check_output(output, args.force)?;
    }
    if let Some(word) = args.options.iter().find(|word| is_of_the_batch(word)) {
        return Err(Failure::text(format!(
            "{word}: the results of a batch are files of its folder; give it no output of its own"
        )));
    }
    std::fs::create_dir_all(&args.folder)
        .map_err(|e| Failure::text(format!("cannot make the folder {}: {e}", shown(&args.folder))))?;
    let common = of_all_jobs(args)?;
    let jobs = args.tests.iter().map(|test| job(test, &common)).collect::<Result<Vec<_>, _>>()?;
    let mine =
        args.shard.map_or_else(|| (0..jobs.len()).collect::<Vec<_>>(), |part| part.positions(jobs.len()).collect());
    let bar = bar("jobs");
    bar.set_length(mine.len() as u64);
    let (mut bugs, mut errors) = (Vec::new(), 0);
    for index in mine {
        let job = &jobs[index];
        let path = path_of(&args.folder, &job.key);
        let known = read(&path).filter(|done| done.key == job.key);
        let done = match known {
            Some(done) => done,
            None => {
                // What is there was cut short, or will be written by another process that does the same job: the same bytes.
                writing::check_output(&path, true)?;
                let Some(done) = perform(args, job)? else {
                    bugs.push(shown(job.test));
                    continue;
                };
                if !writing::write(&path, &done.line()) {
                    return Ok(DONE);
                }
                done
            }
        };
        errors += usize::from(done.is_error());
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(first) = bugs.first() {
        warning!("{} of the jobs ended by a bug of retune and have no result, the first of {first}", bugs.len());
        return Ok(BUG);
    }
    if errors > 0 {
        warning!("{} without a result: `error` says why", counted(errors, "job"));
    }
    if args.shard.is_none() {
        let all = jobs.iter().map(|job| {
            let path = path_of(&args.folder, &job.key);
            read(&path).ok_or_else(|| Failure::text(format!("cannot read {} again", shown(&path))))
        });
        give(args.output.as_deref(), all.collect::<Result<Vec<_>, _>>()?);
    }
    Ok(if errors > 0 { SHORT } else { DONE })
}

/// Prints or writes results by the names of their tests, each once.
pub(crate) fn give(output: Option<&Path>, all: Vec<Done>) {
    let sorted: BTreeMap<(Vec<String>, String), Done> =
        all.into_iter().map(|done| ((done.tests.clone(), done.key.clone()), done)).collect();
    let text: String = sorted.values().map(Done::line).collect();
    match output {
        Some(path) => {
            let _ = writing::write(path, &text);
        }
        None => print(&text),
    }
}

/// A result, if the file is one.
pub(crate) fn read(path: &Path) -> Option<Done> {
    Done::from_line(&std::fs::read_to_string(path).ok()?)
}

fn path_of(folder: &Path, key: &str) -> PathBuf {
    folder.join(format!("{key}.json"))
}

/// Whether an option of the verb says where its result goes, which the batch does.
fn is_of_the_batch(word: &str) -> bool {
    let long = ["--output", "--report", "--json", "--force", "--checkpoint", "--resume", "--frf-output"];
    word.starts_with("-o") || long.contains(&word.split('=').next().unwrap_or(word))
}

/// What every job depends on: the version, the verb, its options and the files that they name, the model.
fn of_all_jobs(args: &Batch) -> Result<Hash, Failure> {
    let mut hash = Hash::new();
    enter(&mut hash, env!("CARGO_PKG_VERSION").as_bytes());
    enter(&mut hash, args.verb.word().as_bytes());
    for word in &args.options {
        enter(&mut hash, word.as_bytes());
        let file = Path::new(word.split_once('=').map_or(word.as_str(), |(_, value)| value));
        if file.is_file() {
            enter_file(&mut hash, file)?;
        }
    }
    enter_file(&mut hash, &args.model)?;
    Ok(hash)
}

fn job<'a>(test: &'a Path, common: &Hash) -> Result<Job<'a>, Failure> {
    let mut hash = common.clone();
    let text = enter_file(&mut hash, test)?;
    // A file that is no test has an error as its result, under its own name.
    let stem = || test.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let name = read_test(&text).map_or_else(|_| stem(), |(test, _)| test.name);
    Ok(Job { test, name, key: hash.digits() })
}

/// One thing more of what a result depends on, with its length, so that two things are never one.
fn enter(hash: &mut Hash, bytes: &[u8]) {
    hash.add(&(bytes.len() as u64).to_le_bytes());
    hash.add(bytes);
}

/// A file by its bytes, and those that it names in its folder; its text.
fn enter_file(hash: &mut Hash, path: &Path) -> Result<String, Failure> {
    let text = files::read(path)?;
    enter(hash, text.as_bytes());
    let folder = path.parent().unwrap_or(Path::new(""));
    let is_of_a_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '/' | '+' | '-');
    let mut named: Vec<&str> = text.split(|c| !is_of_a_name(c)).filter(|word| word.contains('.')).collect();
    named.sort_unstable();
    named.dedup();
    for word in named {
        let file = folder.join(word);
        if file.is_file() {
            let unreadable = |e: std::io::Error| Failure::text(format!("cannot read {}: {e}", shown(&file)));
            enter(hash, word.as_bytes());
            enter(hash, &ledger::read(&file, LARGEST).map_err(unreadable)?);
        }
    }
    Ok(text)
}

/// Performs a job in a process of its own, for signals, files and threads are of a process; nothing where that ends by a bug.
fn perform(args: &Batch, job: &Job<'_>) -> Result<Option<Done>, Failure> {
    let program = again();
    let Some((first, rest)) = program.split_first() else {
        return Err(Failure::text("this program does not know how it was started"));
    };
    let done = Command::new(first)
        .args(rest)
        .arg(args.verb.word())
        .arg(&args.model)
        .arg(job.test)
        .args(&args.options)
        .arg("--json")
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .output()
        .map_err(|e| Failure::text(format!("cannot start {}: {e}", shown(Path::new(first)))))?;
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    let result: Option<Value> = serde_json::from_slice(&done.stdout).ok();
    let out = |result: Value, error: Option<&str>| {
        let warnings: Vec<&str> = told.lines().filter_map(|line| line.strip_prefix("warning: ")).collect();
        let (verb, tests) = (args.verb.word(), vec![job.name.clone()]);
        let content = json!({"key": job.key, "verb": verb, "tests": tests, "result": result, "error": error, "warnings": warnings});
        Done { key: job.key.clone(), tests, content }
    };
    Ok(match (done.status.code(), result) {
        (Some(0 | 1), Some(result)) => Some(out(result, None)),
        (Some(2), _) => Some(out(Value::Null, Some(told.trim_end()))),
        // A signal, or a bug.
        _ => None,
    })
}
