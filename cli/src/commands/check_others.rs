//! `retune check` of files that are not models: tests, objectives, criteria profiles.

use crate::args::Check;
use crate::files::{self, Kind};
use crate::output::{Failure, print, problems_json, render_problems, style, tell, totals};
use crate::{DONE, WRONG_INPUT};
use retune::catalogue::counted;
use retune::correlation::parse_profiles;
use retune::update::ObjectiveSpec;
use retune::yaml::{Problem, Severity};
use retune_report::text::{Tone, printable};
use serde_json::json;

/// Keys of an objective file: one without others is none of a model.
const OBJECTIVE: [&str; 4] = ["terms", "loss", "regularization", "limits"];

/// The answer for a file that is not a model; `None` for a model, and for what is neither.
pub(super) fn answer(args: &Check, text: &str) -> Option<Result<u8, Failure>> {
    let lines = || text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let found = if files::kind(&args.model.path) == Some(Kind::Test) {
        test(text)
    } else if lines().next()?.starts_with("- name:") {
        parse_profiles(text)
            .map(|all| (counted(all.len(), "criteria profile"), Vec::new()))
            .map_err(|e| vec![Problem::error("", e)])
    } else {
        let at_top = lines().filter(|line| line.starts_with(char::is_alphabetic));
        let keys: Vec<&str> = at_top.filter_map(|line| line.split(':').next()).collect();
        if keys.is_empty() || !keys.iter().all(|key| OBJECTIVE.contains(&key.trim())) {
            return None;
        }
        ObjectiveSpec::read(text).map(|spec| {
            let terms = if spec.terms.is_empty() {
                "all that a test has data for".into()
            } else {
                counted(spec.terms.len(), "term")
            };
            (format!("Objective: {terms}, {}", counted(spec.limits.len(), "limit")), Vec::new())
        })
    };
    Some(tell_of(args, text, found))
}

/// What a test file holds, and what is doubtful in it.
fn test(text: &str) -> Result<(String, Vec<Problem>), Vec<Problem>> {
    retune::data::read_test(text).map(|(test, warnings)| {
        let statics = match test.static_tests.len() {
            0 => String::new(),
            n => format!(", {}", counted(n, "static test")),
        };
        let holds = format!(
            "{}\n  {}, {}{statics}\n  its sensors are held against a model by `retune compare MODEL TEST`",
            printable(&test.name),
            counted(test.sensors.len(), "sensor"),
            counted(test.modes.len(), "mode")
        );
        (holds, warnings)
    })
}

fn tell_of(args: &Check, text: &str, found: Result<(String, Vec<Problem>), Vec<Problem>>) -> Result<u8, Failure> {
    if !args.against.is_empty() || args.model.configuration.is_some() {
        return Err(Failure::text(format!(
            "{}: `--against` and `--configuration` are of a model file, and this is none",
            args.model.path.display()
        )));
    }
    let (holds, warnings) = match found {
        Ok(found) => found,
        Err(problems) if args.answer.json => {
            args.answer.give(&json!({
                "ok": false,
                "errors": problems_json(&problems, Severity::Error),
                "warnings": problems_json(&problems, Severity::Warning),
            }));
            return Ok(WRONG_INPUT);
        }
        Err(problems) => return Err(Failure::problems(&args.model.path, text, &problems)),
    };
    if args.answer.needs_json() {
        let none: [&str; 0] = [];
        let warnings = problems_json(&warnings, Severity::Warning);
        args.answer.give(&json!({ "ok": true, "errors": none, "warnings": warnings }));
    }
    if args.answer.json {
        return Ok(DONE);
    }
    print(&format!("{holds}\n"));
    if !warnings.is_empty() {
        tell(&format!("\n{}", render_problems(&args.model.path, text, &warnings).trim_end()));
    }
    let style = style(&std::io::stdout());
    let (verdict, tone) =
        if warnings.is_empty() { ("sound", Tone::Good) } else { ("usable, with doubts", Tone::Warning) };
    print(&format!("\n{}: {}\n", style.paint(tone, verdict), totals(0, warnings.len())));
    Ok(DONE)
}
