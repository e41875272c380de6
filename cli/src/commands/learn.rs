//! `retune learn`

use super::diagnose::{about_files, head, search_settings};
use crate::args::Learn;
use crate::files::{self, Tested};
use crate::output::{Failure, print, print_json, shown, style};
use crate::page::{Outputs, announce};
use crate::progress::Spinner;
use crate::{DONE, SHORT, writing};
use retune::data::{TestData, joined, write_test};
use retune::model::Model;
use retune_diagnosis::{Estimate, Learned, Settings, Step, Verdict, learn_from_tests};
use retune_report::{
    LearningStep, add_live_of_learning, answer, diagnosis, learning_steps, misfit_before_any_fit, of_learning, text,
};
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &Learn) -> Result<u8, Failure> {
    let outputs = Outputs { page: args.report.as_ref(), force: args.overwrite.force, ..Outputs::default() };
    outputs.check()?;
    let step_file = |stem: &Path, step: usize| stem.with_extension(format!("{step}.yaml"));
    let test_file = |stem: &Path, k: usize| match args.tests.paths.len() {
        1 => stem.with_extension("test.yaml"),
        _ => stem.with_extension(format!("test.{}.yaml", k + 1)),
    };
    if let Some(stem) = &args.output {
        (0..=usize::from(args.limit))
            .try_for_each(|step| writing::check_output(&step_file(stem, step), args.overwrite.force))?;
        (0..args.tests.paths.len())
            .try_for_each(|k| writing::check_output(&test_file(stem, k), args.overwrite.force))?;
    }
    let all = files::tested(&args.model, &args.tests.paths, None)?;
    let (model, _, model_text) = files::model(&args.model, None)?;
    let tests: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
    let how = args.pairing.how();
    let spinner = Spinner::new();
    let settings = Settings { seed: args.random.seed, pairing: how, ..search_settings(&args.search, &spinner)? };
    let found = learn_from_tests(&model, &tests, &settings, args.take_best, usize::from(args.limit));
    drop(spinner);
    let learned = found?;
    let mut written: Vec<PathBuf> = Vec::new();
    if let Some(stem) = &args.output {
        for (i, text) in learned.model_texts(&model_text)?.iter().enumerate() {
            let path = step_file(stem, i);
            if writing::write(&path, &files::beside(text, &args.model, &path)?) {
                written.push(path);
            }
        }
    }
    let is_corrected = learned.steps.iter().any(|s| s.corrected.is_some());
    if let Some(stem) = args.output.as_ref().filter(|_| is_corrected) {
        for (k, test) in learned.tests.iter().enumerate() {
            let path = test_file(stem, k);
            if writing::write(&path, &write_test(test)) {
                written.push(path);
            }
        }
    }
    let cases: Vec<(&Model, &TestData)> = all.iter().map(|t| (&t.model, &t.test)).collect();
    if args.print.json {
        let written: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
        print_json(&answer::learned(&learned, &written)?);
    } else {
        print(&in_words(&learned, &model, &all, &misfit_before_any_fit(&cases)?, usize::from(args.limit)));
        for path in &written {
            print(&format!("written: {}\n", shown(path)));
        }
    }
    if args.report.is_some() {
        let mut data = of_learning(&cases, &learned)?;
        add_live_of_learning(&mut data, &cases, &learned);
        about_files(&mut data, &all, &args.model, &args.tests.paths, args.random.seed);
        let written = outputs.write(&data)?;
        if !args.print.json {
            announce(&written);
        }
    }
    let adequate = learned.steps.last().is_some_and(|s| s.diagnosis.verdict == Verdict::Adequate);
    Ok(if adequate { DONE } else { SHORT })
}

fn in_words(
    learned: &Learned,
    model: &Model,
    all: &[Tested],
    initial: &(f64, Vec<Option<f64>>),
    limit: usize,
) -> String {
    let tests: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
    let test = &joined(&tests).test;
    let style = style(&std::io::stdout());
    let records: Vec<LearningStep> = learned.steps.iter().map(LearningStep::from).collect();
    let mut out = head(&model.spec().name, all) + "\n";
    out += &text::steps(&learning_steps(&records, Some((initial.0, &initial.1)), test), &style);
    let mut say = |line: String| {
        for part in text::broken(&line, style.width) {
            out += &part;
            out.push('\n');
        }
    };
    say(String::new());
    for s in &learned.steps {
        if !s.tie.is_empty() {
            let what = s.added.as_ref().map_or_else(
                || {
                    let first = s.diagnosis.hypotheses.first().map_or("", |h| h.id.as_str());
                    format!("stopped: the data cannot tell {first} (which --take-best would take) from")
                },
                |c| format!("warning: {} was taken, but the data cannot tell it from", c.id()),
            );
            say(format!("{what} {}", s.tie.join(", ")));
        }
        for id in &s.dropped {
            say(format!("taken out again as unnecessary: {id}"));
        }
    }
    for s in &learned.steps {
        for e in &s.correction {
            let id = s.corrected.as_deref().unwrap_or_default();
            say(format!("taken out of the data: {id}, {}", in_numbers(e)));
        }
    }
    if let Some(last) = learned.steps.last() {
        for e in &last.sizes {
            say(format!("found: {}", in_numbers(e)));
        }
        say(why_it_ends(learned, last, limit));
        out.push('\n');
        out += &text::diagnosis(&diagnosis(&last.diagnosis, &last.model, test), text::FILES, &style);
    }
    out
}

/// `point_mass.s1.mass 7.51 kg (90 %: 7.10 … 7.92)`
fn in_numbers(e: &Estimate) -> String {
    let unit = if e.unit == "1" { String::new() } else { format!(" {}", e.unit) };
    let [lower, upper] = e.interval.map(text::brief);
    format!("{} {}{unit} (90 %: {lower} … {upper})", e.parameter, text::brief(e.value))
}

/// Why nothing more was added.
fn why_it_ends(learned: &Learned, last: &Step, limit: usize) -> String {
    if let Some(attempt) = &learned.attempt {
        let (together, are) = if attempt.ids.len() > 1 { (" on top of each other", "are") } else { ("", "is") };
        return format!(
            "stopped: a change of many parts explains the test as well as one effect does. {}{together} left a misfit of {:.0} and {are} not \
             clearly more probable: taken back",
            attempt.ids.join(", "),
            attempt.misfit
        );
    }
    match last.diagnosis.verdict {
        Verdict::Adequate => "done: the rest looks like noise".to_string(),
        Verdict::NoiseOrModel => {
            "stopped: the rest is noise only if there is more of it than can be believed".to_string()
        }
        _ if learned.stopped_for_tie => String::new(),
        // A step for every addition, and the last.
        _ if learned.steps.len() > limit => format!("stopped after {limit} additions: --limit allows no more"),
        _ => "stopped: nothing in the catalogue explains what remains".to_string(),
    }
}
