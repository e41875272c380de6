//! `retune learn`

use crate::args::Learn;
use crate::output::{Failure, print, print_json, style, warn};
use crate::{DONE, SHORT, files};
use retune::diagnosis::{Learned, Settings, Step, Verdict, learn};
use retune::effect::{Candidate, set_parameter_values};
use retune::model::ParametricModel;
use retune::report::text::{Align, Table};
use serde_json::json;
use std::path::PathBuf;

pub(crate) fn run(args: &Learn) -> Result<u8, Failure> {
    let (test, test_warnings, test_text) = files::test(&args.test)?;
    let (model, model_warnings, model_text) = files::tested_model(&args.model, None, (&test, &args.test, &test_text))?;
    warn(&args.model, &model_text, &model_warnings);
    warn(&args.test, &test_text, &test_warnings);
    let settings = Settings { seed: args.seed, ..Settings::default() };
    let learned = learn(&model, &test, &settings, args.take_best, usize::from(args.limit))?;
    let mut written: Vec<PathBuf> = Vec::new();
    if let Some(stem) = &args.output {
        let mut present: Vec<Candidate> = Vec::new();
        for (i, step) in learned.steps.iter().enumerate() {
            present.retain(|c| !step.dropped.contains(&c.id()));
            let path = stem.with_extension(format!("{i}.yaml"));
            files::check_output(&path, args.force)?;
            files::write(&path, &step_text(&model_text, &present, step)?)?;
            written.push(path);
            present.extend(step.added.clone());
        }
    }
    if args.json {
        print_json(&json!({
            "steps": learned.steps.iter().map(|s| Ok(json!({
                "misfit": s.misfit,
                "misfit_per_mode": s.misfit_per_mode,
                "held_out_per_mode": s.held_out,
                "added": s.added.as_ref().map(Candidate::id),
                "corrected": s.corrected,
                "tied_with": s.tie,
                "dropped": s.dropped,
                "diagnosis": serde_json::to_value(&s.diagnosis)?,
            }))).collect::<Result<Vec<_>, serde_json::Error>>()?,
            "effects": learned.effects.iter().map(Candidate::id).collect::<Vec<_>>(),
            "stopped_for_tie": learned.stopped_for_tie,
            "written": written.iter().map(|p| p.display().to_string()).collect::<Vec<_>>(),
        }));
    } else {
        print(&text(&learned));
        for path in &written {
            print(&format!("written: {}\n", path.display()));
        }
    }
    let adequate = learned.steps.last().is_some_and(|s| s.diagnosis.verdict == Verdict::Adequate);
    Ok(if adequate { DONE } else { SHORT })
}

/// The model of a step as an edit of the user's file.
fn step_text(original: &str, present: &[Candidate], step: &Step) -> Result<String, Failure> {
    let mut out = original.to_string();
    for c in present {
        out = c.patch.add_to_text(&out, &c.id(), "found by retune learn")?;
    }
    let values: Vec<(&str, f64)> = step
        .model
        .parameters()
        .iter()
        .zip(&step.theta)
        .filter(|(p, _)| p.bounds.is_some())
        .map(|(p, v)| (p.name.as_str(), *v))
        .collect();
    Ok(set_parameter_values(&out, &values)?)
}

fn text(learned: &Learned) -> String {
    let n_modes = learned.steps.first().map_or(0, |s| s.misfit_per_mode.len());
    let names: Vec<String> = (1..=n_modes).map(|m| format!("mode {m}")).collect();
    let mut columns = vec![("step", Align::Right), ("misfit", Align::Right), ("held out", Align::Right)];
    columns.extend(names.iter().map(|n| (n.as_str(), Align::Right)));
    columns.push(("then", Align::Left));
    let mut table = Table::new(columns);
    for (i, s) in learned.steps.iter().enumerate() {
        let then = match (&s.added, &s.corrected) {
            (Some(c), _) => format!("add {}", c.id()),
            (_, Some(fault)) => format!("correct {fault}"),
            _ => s.diagnosis.verdict.word().to_string(),
        };
        let mut row = vec![
            i.to_string().into(),
            format!("{:.1}", s.misfit).into(),
            format!("{:.1}", s.held_out.iter().sum::<f64>()).into(),
        ];
        row.extend(s.misfit_per_mode.iter().map(|m| format!("{m:.1}").into()));
        row.push(then.into());
        table.row(row);
    }
    let mut out = table.render(&style(&std::io::stdout()));
    for s in &learned.steps {
        if !s.tie.is_empty() {
            let what = s.added.as_ref().map_or_else(
                || "stopped: the data cannot decide; --take-best would take the first of".to_string(),
                |c| format!("warning: {} was taken, but the data cannot tell it from", c.id()),
            );
            out += &format!("{what} {}\n", s.tie.join(", "));
        }
        for id in &s.dropped {
            out += &format!("taken out again as unnecessary: {id}\n");
        }
    }
    if let Some(last) = learned.steps.last() {
        out += &format!("{}: {}\n", last.diagnosis.verdict.word(), last.diagnosis.sentence);
    }
    out
}
