//! What the verbs on measurements share: reading files, answers to their questions, findings.

use crate::args::Measurement;
use crate::files::{self, Kind};
use crate::ledger;
use crate::output::{Failure, remarks, style};
use retune::catalogue::counted;
use retune::data::{Answers, FrfSet, MeasurementError, Measurements};
use retune::identify::health::{Finding, Level};
use retune::model::Parameter;
use retune::update::{UpdateError, instead, with_roving_responses};
use retune_report::text::{Style, Tone, number, paragraph, printable};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Longest line of running text.
const LINE: usize = 100;

/// Reads measurement files with the answers of the command line; notes go to standard error.
pub(crate) fn read(files: &[PathBuf], args: &Measurement) -> Result<Measurements, Failure> {
    for path in files {
        let what = match files::kind(path) {
            Some(Kind::Model) => "a model file",
            Some(Kind::Test) => "a test file, which holds modes already",
            None => continue,
        };
        return Err(Failure::text(format!("{} is {what}; measurement files are expected here", path.display())));
    }
    let answers = Answers {
        units: args.units.as_deref(),
        quantity: args.quantity,
        unit: args.unit.as_deref(),
        duplicates: args.duplicates.unwrap_or_default(),
        frequency_unit: args.frequency_unit.as_deref(),
        local_axes: args.local_axes,
        direction: args.direction.as_deref(),
        geometry_units: args.geometry_units.as_deref(),
        variables: args.variables.as_deref(),
        frame: args.frame.as_deref(),
    };
    let (options, frame) = answers.options().map_err(Failure::text)?;
    let mut found = ledger::measurements(files, args.geometry.as_deref(), &options).map_err(|e| match e {
        MeasurementError::Convert(e) => Failure::text(e.on_command_line()),
        other => Failure::from(other),
    })?;
    if let Some(frame) = frame {
        found.turn(&frame);
    }
    Ok(found)
}

/// Refuses answers about measurement files beside a test file.
pub(crate) fn refuse_answers(path: &Path, args: &Measurement) -> Result<(), Failure> {
    let given = args.given();
    if given.is_empty() {
        return Ok(());
    }
    Err(Failure::text(format!(
        "{} is a test file, which states its units, places and directions itself; {} is for measurement files",
        path.display(),
        given.join(", ")
    )))
}

/// The functions of measurements, or what there is instead.
pub(crate) fn functions(found: &Measurements) -> Result<&FrfSet, Failure> {
    found.frfs.as_ref().ok_or_else(|| UpdateError::NoMeasurements(instead(found)).into())
}

/// The functions with the points that roved as responses.
pub(crate) fn shape_functions(found: &Measurements) -> Result<Cow<'_, FrfSet>, Failure> {
    let (set, remark) = with_roving_responses(functions(found)?);
    remarks(None, remark.as_slice());
    Ok(set)
}

/// The value of a parameter from the command line, SI: a plain number is in the unit that the file declares for it, and what was understood
/// is said; a value outside its bounds is refused.
pub(crate) fn parameter_value(option: &str, text: &str, parameter: &Parameter) -> Result<f64, Failure> {
    let (value, is_plain) = parameter.parse(text).map_err(|e| Failure::text(format!("{option} {e}")))?;
    if is_plain && !parameter.unit.is_empty() && parameter.unit != "1" {
        let (name, shown) = (&parameter.name, number(parameter.display(value)));
        note!("{option} {name}={text}: read as {shown} {}, the unit of `{name}` in the model file", parameter.unit);
    }
    Ok(value)
}

/// Two limits of a band.
pub(crate) fn band(limits: Option<&[f64]>) -> Result<Option<(f64, f64)>, Failure> {
    match limits {
        Some(&[low, high]) if low < high && low >= 0.0 => Ok(Some((low, high))),
        Some(list) => Err(Failure::text(format!("--band {list:?}: give two ascending frequencies in Hz"))),
        None => Ok(None),
    }
}

/// Whether the check found an error.
pub(crate) fn has_fault(findings: &[Finding]) -> bool {
    findings.iter().any(|f| f.level == Level::Fault)
}

/// A number of the evidence: a count without decimals.
fn evidence_text(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e6 { format!("{value:.0}") } else { number(value) }
}

/// Findings, worst first, each with its evidence and what to do.
pub(crate) fn findings_text(findings: &[Finding], style: &Style) -> String {
    if findings.is_empty() {
        return format!("{}: nothing found\n", style.paint(Tone::Good, "health"));
    }
    let mut out = String::new();
    for f in findings {
        let tone = match f.level {
            Level::Fault => Tone::Bad,
            Level::Warning => Tone::Warning,
            Level::Info => Tone::Dim,
        };
        // Painted after wrapping: escapes have no width.
        let text = wrapped(&format!("{}: {}", f.level.word(), printable(&f.text)), "    ");
        out += &text.replacen(f.level.word(), &style.paint(tone, f.level.word()), 1);
        let evidence: Vec<String> =
            f.evidence.iter().map(|(name, value)| format!("{name} {}", evidence_text(*value))).collect();
        let colon = if evidence.is_empty() { "" } else { ": " };
        out += &wrapped(&format!("    {}{colon}{}", f.code, evidence.join(", ")), "        ");
        out += &wrapped(&format!("    to do: {}", f.remedy), "        ");
    }
    let count = |level: Level| findings.iter().filter(|f| f.level == level).count();
    let word = |level: Level, name: &str| counted(count(level), name);
    let _ = writeln!(
        out,
        "{}, {}, {}",
        word(Level::Fault, "fault"),
        word(Level::Warning, "warning"),
        word(Level::Info, "remark")
    );
    out
}

/// Text broken between words at the width of the terminal; lines after the first begin with `indent`.
pub(crate) fn wrapped(text: &str, indent: &str) -> String {
    paragraph(text, indent, style(&std::io::stdout()).width.min(LINE))
}
