//! Reading models and tests, with problems shown in place.

use crate::ledger;
use crate::output::{Failure, remarks, shown, warn};
use retune::data::{TestData, corrected_functions, read_test};
use retune::effect::move_files;
use retune::model::{Model, Registry, doubts, load_in};
use retune::update::{UpdateError, check_on_model, loaded as with_masses, meet};
use retune::yaml::{Problem, Severity, SourceMap};
use std::path::{Path, PathBuf};

/// Files above this size are not YAML that a person wrote: 16 MiB take seconds and a gigabyte to parse.
pub(crate) const LARGEST: u64 = 16 << 20;

/// The text of a file.
pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    read_at_most(path, LARGEST)
}

/// The text of a file of so many bytes at most.
pub(crate) fn read_at_most(path: &Path, largest: u64) -> Result<String, Failure> {
    let fail = |e: &dyn std::fmt::Display| Failure::text(format!("cannot read {}: {e}", path.display()));
    let bytes = ledger::read(path, largest).map_err(|e| fail(&e))?;
    retune::yaml::text_of(bytes).map_err(|e| fail(&e))
}

/// Files of matrices of 10⁶ dofs have gigabytes.
const LARGEST_MATRICES: u64 = 8 << 30;

/// The bytes of a file of matrices.
pub(crate) fn matrices(path: &Path) -> std::io::Result<Vec<u8>> {
    ledger::read(path, LARGEST_MATRICES)
}

/// A model from the text of its file; what its superelements name is read from beside it.
pub(crate) fn load(
    path: &Path,
    text: &str,
    configuration: Option<&str>,
) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    load_in(text, configuration, &Registry::builtin(), &mut |file| matrices(&folder.join(file)))
}

/// The text of a model file that is to stand at another place than it was read from: the files that it names are found from there.
pub(crate) fn beside(text: &str, from: &Path, to: &Path) -> Result<String, Failure> {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize()
    };
    let (Ok(from), Ok(to)) = (folder(from), folder(to)) else { return Ok(text.to_string()) };
    if from == to {
        return Ok(text.to_string());
    }
    let moved = |name: &str| {
        let path = from.join(name);
        // A path from the root leads there from anywhere.
        if Path::new(name).is_absolute() || !path.is_file() {
            return None;
        }
        let path = folder(&path).ok()?.join(path.file_name()?);
        Some(relative(&path, &to))
    };
    Ok(move_files(text, &moved)?)
}

/// A path as it is seen from a folder; the whole path where they have no root in common.
fn relative(path: &Path, folder: &Path) -> String {
    let (own, other): (Vec<_>, Vec<_>) = (path.components().collect(), folder.components().collect());
    let common = own.iter().zip(&other).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return path.display().to_string();
    }
    let up = std::iter::repeat_n("..".to_string(), other.len() - common);
    let down = own[common..].iter().map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// A model in one of its configurations, and its warnings, with what makes every result of it doubtful.
pub(crate) fn model(path: &Path, configuration: Option<&str>) -> Result<(Model, Vec<Problem>, String), Failure> {
    refuse_others(path)?;
    let text = read(path)?;
    match load(path, &text, configuration) {
        Ok((model, warnings, map)) => {
            let warnings = with_doubts(&model, warnings, &map);
            Ok((model, warnings, text))
        }
        Err(problems) => {
            let hint = is_test(path).then(|| order(path, Kind::Model)).flatten();
            Err(Failure::problems(path, &text, &problems).with_hint_of(hint))
        }
    }
}

/// Refuses a measurement or a deck where a model is expected, as its name tells.
fn refuse_others(path: &Path) -> Result<(), Failure> {
    let (name, extension) = (shown(path), extension(path));
    let instead = match extension.as_str() {
        "bdf" | "nas" | "inp" => format!("`retune import {name} -o model.yaml` makes one of a deck"),
        e if MEASURED.contains(&e) => {
            "it holds a measurement, which `retune identify` makes a test file of".to_string()
        }
        _ => return Ok(()),
    };
    if !path.exists() || kind(path).is_some() {
        return Ok(());
    }
    Err(Failure::text(format!("{name} is not a model file: {instead}")))
}

/// A word where files are in the wrong order: the command line has a file of the kind that is expected, and beside it stands the other.
fn order(path: &Path, expected: Kind) -> Option<String> {
    let other = of_command_line(expected).filter(|other| other != path)?;
    let (model, test) = if expected == Kind::Model { (&*other, path) } else { (path, &*other) };
    Some(format!("the model comes before the tests: `... {} {}`", shown(model), shown(test)))
}

/// The first file of a kind among the words of the command line.
fn of_command_line(wanted: Kind) -> Option<PathBuf> {
    std::env::args_os().skip(1).map(PathBuf::from).find(|word| word.is_file() && kind(word) == Some(wanted))
}

/// Extensions of files of measurements.
const MEASURED: [&str; 8] = ["csv", "unv", "uff", "bunv", "mat", "npy", "lvm", "txt"];

/// The extension of a path in small letters.
fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn with_doubts(model: &Model, mut warnings: Vec<Problem>, map: &SourceMap) -> Vec<Problem> {
    warnings.extend(map.place(doubts(model)));
    warnings
}

/// A model in the configuration asked for, else in the one that the test was made in; a loss factor that the test leaves to the model
/// is settled.
pub(crate) fn tested_model(
    path: &Path,
    configuration: Option<&str>,
    (test, test_path, test_text): (&mut TestData, &Path, &str),
) -> Result<(Model, Vec<Problem>, String), Failure> {
    let (model, warnings, text) = configured_model(path, configuration, (test, test_path, test_text))?;
    let configured = |name: &str| load(path, &text, Some(name)).ok().map(|(model, ..)| model);
    remarks(Some(test_path), &meet(&model, test, configuration.is_some(), &configured));
    Ok((model, warnings, text))
}

fn configured_model(
    path: &Path,
    configuration: Option<&str>,
    (test, test_path, test_text): (&TestData, &Path, &str),
) -> Result<(Model, Vec<Problem>, String), Failure> {
    if let (None, Some(name)) = (configuration, &test.configuration) {
        let text = read(path)?;
        return match load(path, &text, Some(name)) {
            Ok((model, warnings, map)) => {
                let warnings = with_doubts(&model, warnings, &map);
                Ok((model, warnings, text))
            }
            // An unknown name is the test's mistake.
            Err(problems) if problems.iter().any(|p| p.path == "configurations") => {
                let renamed = problems.into_iter().map(|p| Problem::error("configuration", p.message)).collect();
                Err(Failure::problems(test_path, test_text, &SourceMap::of(test_text).place(renamed)))
            }
            Err(problems) => Err(Failure::problems(path, &text, &problems)),
        };
    }
    model(path, configuration)
}

/// A test and its warnings.
pub(crate) fn test(path: &Path) -> Result<(TestData, Vec<Problem>, String), Failure> {
    if path.exists() && MEASURED.contains(&extension(path).as_str()) && !is_test(path) {
        let name = path.display();
        return Err(Failure::text(format!(
            "{name} is not a test file: `retune identify {name} -o test.yaml` makes one of measurements; functions also enter a fit by `frfs: {{files: [{name}]}}` in a test file"
        )));
    }
    let text = read(path)?;
    match read_test(&text) {
        Ok((mut test, warnings)) => {
            if let Some(fit) = &test.frf_fit {
                let folder = path.parent().unwrap_or(Path::new(""));
                let files: Vec<_> = fit.files.iter().map(|f| folder.join(f)).collect();
                let refused = |why: &dyn std::fmt::Display| {
                    let place = Problem::error("frfs.files", why);
                    Failure::problems(path, &text, &SourceMap::of(&text).place(vec![place]))
                };
                let found = ledger::measurements(&files, None, &fit.reading).map_err(|e| refused(&e))?;
                test.frfs = found.frfs.map(|set| corrected_functions(set, &test.sensors, &test.corrections));
                if test.frfs.is_none() {
                    return Err(refused(&"these files hold no frequency response functions"));
                }
            }
            Ok((test, warnings, text))
        }
        Err(problems) => {
            let hint = (kind(path) == Some(Kind::Model)).then(|| order(path, Kind::Test)).flatten();
            Err(Failure::problems(path, &text, &problems).with_hint_of(hint))
        }
    }
}

/// The model with the masses of the sensors, when asked for; else a word about what they weigh.
pub(crate) fn loaded(model: Model, test: &TestData, wanted: bool) -> Result<Model, Failure> {
    match with_masses(&model, test).map_err(|e| Failure::text(format!("--sensor-masses: {e}")))? {
        None if wanted => Err(Failure::text("--sensor-masses: no sensor of the test states a `mass`")),
        None => Ok(model),
        Some((loaded, _)) if wanted => Ok(loaded),
        Some((_, total)) => {
            note!("the sensors weigh {:.1} g together; `--sensor-masses` puts them into the model", 1e3 * total);
            Ok(model)
        }
    }
}

/// A test, the model in its configuration, and the model's text.
pub(crate) struct Tested {
    pub(crate) test: TestData,
    pub(crate) model: Model,
    pub(crate) model_text: String,
    /// What was warned of.
    pub(crate) warnings: Vec<String>,
}

/// Reads tests, and a model in the configuration of each; warnings are shown.
pub(crate) fn tested(path: &Path, tests: &[PathBuf], configuration: Option<&str>) -> Result<Vec<Tested>, Failure> {
    let mut all = Vec::with_capacity(tests.len());
    for (i, path) in tests.iter().enumerate() {
        let same = |other: &PathBuf| matches!((other.canonicalize(), path.canonicalize()), (Ok(a), Ok(b)) if a == b);
        if tests[..i].iter().any(same) {
            return Err(Failure::text(format!("{} is given twice: its data would count twice", path.display())));
        }
    }
    for (i, test_path) in tests.iter().enumerate() {
        let (mut test, mut warnings, text) = test(test_path)?;
        if test.has_nothing() {
            return Err(Failure::text(format!("{}: {}", test_path.display(), UpdateError::NoData)));
        }
        let (model, model_warnings, model_text) = tested_model(path, configuration, (&mut test, test_path, &text))?;
        warnings.extend(check_sensors(&model, &test, test_path, &text)?);
        if i == 0 {
            warn(path, &model_text, &model_warnings);
        }
        warn(test_path, &text, &warnings);
        let of_model = model_warnings.iter().filter(|_| i == 0);
        let warnings = of_model.chain(&warnings).map(|p| p.message.clone()).collect();
        all.push(Tested { test, model, model_text, warnings });
    }
    Ok(all)
}

/// A file of ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `retune: 1`
    Model,
    /// `retune_test: 1`
    Test,
}

/// Which file of ours a file is, if it is one: its first key says so.
pub(crate) fn kind(path: &Path) -> Option<Kind> {
    let text = if path.is_dir() { return None } else { read(path).ok()? };
    text.lines().find_map(|line| match line.split(':').next() {
        Some("retune") => Some(Kind::Model),
        Some("retune_test") => Some(Kind::Test),
        _ => None,
    })
}

/// Whether a file is a test file.
pub(crate) fn is_test(path: &Path) -> bool {
    kind(path) == Some(Kind::Test)
}

/// The problems of a test's sensors on a model: warnings to show, or a failure.
pub(crate) fn check_sensors(model: &Model, test: &TestData, path: &Path, text: &str) -> Result<Vec<Problem>, Failure> {
    let problems = SourceMap::of(text).place(check_on_model(model, test));
    if problems.iter().any(|p| p.severity == Severity::Error) {
        let failure = Failure::problems(path, text, &problems);
        // A file that `identify` has written without a model names its points, and they are not nodes.
        let is_unplaced = |p: &Problem| p.path.starts_with("sensors") && p.message.contains("has no node");
        let has_positions = test.sensors.iter().any(|s| s.place.position().is_some());
        return Err(if has_positions && problems.iter().any(is_unplaced) {
            let (test, model) = (shown(path), of_command_line(Kind::Model));
            let model = model.map_or_else(|| "MODEL".to_string(), |model| shown(&model));
            failure.with_hint(format!("the sensors state their positions: `retune map {model} {test} -o placed.yaml` finds their nodes and elements in the model"))
        } else {
            failure
        });
    }
    Ok(problems)
}
