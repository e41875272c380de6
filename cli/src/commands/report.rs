//! `retune report`

use super::diagnose::{others, warn_of_tests};
use super::measured;
use crate::args::{Report, WhenLive};
use crate::output::{Failure, print, style};
use crate::page::{Outputs, announce, provenance};
use crate::{DONE, files};
use retune::data::{TestData, corrected_functions, joined};
use retune::model::{Model, ParametricModel};
use retune::update::Assessment;
use retune_diagnosis::{Settings, diagnose, diagnose_tests};
use retune_report::data::ReportData;
use retune_report::{
    Case, LearningStep, NotLive, add_before, add_diagnosis, add_learning, add_live, add_parameters, add_responses,
    add_versions, assess_paired, json, live_tests, misfit_before_any_fit, of_comparison, steps, text,
};
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &Report) -> Result<u8, Failure> {
    let outputs = Outputs {
        page: args.output.as_ref(),
        json: args.data.as_ref(),
        svg: args.svg.as_ref(),
        vtk: args.vtk.as_ref(),
        force: args.overwrite.force,
    };
    outputs.check()?;
    let all = files::tested(&args.model.path, &args.tests.paths, args.model.configuration())?;
    let (model, test) = (&all[0].model, &all[0].test);
    let tests: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
    let together = joined(&tests).test;

    let how = args.pairing.how();
    let assessment = assess_paired(model, &model.parameters().nominal(), test, &how)?;
    let case = Case { model, test, assessment: &assessment };
    let mut data = of_comparison(case)?;
    warn_of_tests(&mut data, &all, "The page is about");
    let mut read: Vec<(&str, PathBuf)> = vec![("model", args.model.path.clone())];
    read.extend(args.tests.paths.iter().map(|path| ("test", path.clone())));

    let learned = args.learn.as_deref().map(history_of).transpose()?;
    let versions: &[PathBuf] = match &learned {
        Some(History::Versions(list)) => list,
        _ => &args.history,
    };
    let earlier = versions.iter().map(|path| version(args, path, test)).collect::<Result<Vec<_>, _>>()?;
    read.extend(versions.iter().map(|path| ("earlier version", path.clone())));
    if let Some((_, first, before)) = earlier.first() {
        add_before(&mut data, first, before, test);
        let models: Vec<&Model> = earlier.iter().map(|(_, model, _)| model).collect();
        add_parameters(&mut data, &models, model);
        let all = earlier.iter().map(|(name, _, a)| (name.as_str(), a));
        let now = name(&args.model.path);
        let list: Vec<(&str, &Assessment)> = all.chain([(now.as_str(), &assessment)]).collect();
        data.steps = Some(steps(&list, test));
    }
    if let Some(History::Steps(list)) = &learned {
        let cases: Vec<(&Model, &TestData)> = all.iter().map(|t| (&t.model, &t.test)).collect();
        add_learning(&mut data, model, &together, list, misfit_before_any_fit(&cases)?);
        read.extend(args.learn.iter().map(|path| ("history of learning", path.clone())));
    }
    let mut diagnosis = match &learned {
        Some(History::Steps(list)) => list.last().map(|step| step.diagnosis.clone()),
        _ => None,
    };
    if args.diagnose {
        let settings = Settings { seed: args.random.seed, pairing: how, ..Settings::default() };
        let found = match tests.as_slice() {
            [test] => diagnose(model, test, &settings)?,
            // Each is met in the configuration that it names.
            _ => diagnose_tests(&files::model(&args.model.path, None)?.0, &tests, &settings)?,
        };
        add_diagnosis(&mut data, &found, model, &together);
        diagnosis = Some(found);
    }
    if args.json || outputs.page.or(outputs.json).is_some() {
        let hypotheses = diagnosis.as_ref().map_or(&[][..], |d| &d.hypotheses);
        let first = earlier.first().map(|e| &e.1);
        match args.live {
            WhenLive::Never => {}
            WhenLive::Auto => add_live(&mut data, case, &others(&all), &how, first, hypotheses),
            WhenLive::Always => {
                let beside = others(&all);
                let found = live_tests(case, &beside, &how, first, hypotheses).zip(&all);
                data.live = found
                    .filter_map(|(found, t)| found.inspect_err(|e| does_not_compute(&t.test.name, e)).ok())
                    .collect();
            }
        }
    }
    let versions: Vec<(&str, &Model)> = earlier.iter().map(|(name, model, _)| (name.as_str(), model)).collect();
    data.live.iter_mut().for_each(|live| add_versions(live, &versions));
    let before = earlier.first().map(|(_, model, a)| Case { model, test, assessment: a });
    if let (Some(set), true) = (&test.frfs, args.frf.is_empty()) {
        let origin = test.modes.first().map_or("measured", |m| m.origin.word());
        add_responses(&mut data, case, before, set, origin)?;
    }
    if !args.frf.is_empty() {
        let found = measured::read(&args.frf, &args.measurement)?;
        let origin = if found.is_synthetic { "synthetic" } else { "measured" };
        let set = corrected_functions(measured::functions(&found)?.clone(), &test.sensors, &test.corrections);
        add_responses(&mut data, case, before, &set, origin)?;
        read.extend(args.frf.iter().map(|path| ("frequency responses", path.clone())));
    }
    let read: Vec<(&str, &Path)> = read.iter().map(|(role, path)| (*role, path.as_path())).collect();
    provenance(&mut data, &read, args.diagnose.then_some(args.random.seed));
    let written = outputs.write(&data)?;
    if args.json {
        print(&json(&data)?);
    } else if written.is_empty() {
        print(&text::summary(&data, &style(&std::io::stdout())));
    } else {
        say_verdict(&data);
        announce(&written);
    }
    Ok(DONE)
}

fn does_not_compute(test: &str, why: &NotLive) {
    warning!("the page does not compute what `{test}` is held against: {why}");
}

/// The verdict in one line, so that nobody must open the page for it.
fn say_verdict(data: &ReportData) {
    if let Some(v) = &data.meta.verdict {
        let style = style(&std::io::stdout());
        for line in
            text::wrap(&text::printable(&format!("{} {}: {}.", v.sentence, v.number, v.number_label)), style.width)
        {
            print(&format!("{line}\n"));
        }
    }
}

/// Bytes of a history of learning, at most: 256 MiB.
const LARGEST_HISTORY: u64 = 256 << 20;

/// What `--learn` names.
enum History {
    Steps(Vec<LearningStep>),
    Versions(Vec<PathBuf>),
}

fn history_of(path: &Path) -> Result<History, Failure> {
    if path.is_dir() {
        let entries =
            std::fs::read_dir(path).map_err(|e| Failure::text(format!("cannot read {}: {e}", path.display())))?;
        let mut list: Vec<PathBuf> = entries
            .filter_map(|e| Some(e.ok()?.path()))
            .filter(|p| p.extension().is_some_and(|e| e == "yaml" || e == "yml"))
            .collect();
        // learned.10.yaml comes after learned.9.yaml.
        list.sort_by_key(|p| {
            let digits: String = name(p).chars().rev().take_while(char::is_ascii_digit).collect();
            (digits.chars().rev().collect::<String>().parse::<u64>().unwrap_or(0), p.clone())
        });
        return if list.is_empty() {
            Err(Failure::text(format!("{} has no model files (.yaml)", path.display())))
        } else {
            Ok(History::Versions(list))
        };
    }
    let text = files::read_at_most(path, LARGEST_HISTORY)?;
    let wrong = |e: &dyn std::fmt::Display| {
        Failure::text(format!("{} is not an output of `retune learn --json`: {e}", path.display()))
    };
    let mut value: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| wrong(&format_args!("it is not JSON ({e})")))?;
    let steps = value.get_mut("steps").map(serde_json::Value::take).ok_or_else(|| wrong(&"it has no `steps`"))?;
    Ok(History::Steps(serde_json::from_value(steps).map_err(|e| wrong(&e))?))
}

/// An earlier version with its name and its comparison.
fn version(args: &Report, path: &Path, test: &TestData) -> Result<(String, Model, Assessment), Failure> {
    let configuration = args.model.configuration().or(test.configuration.as_deref());
    let (model, ..) = files::model(path, configuration)?;
    let assessment = assess_paired(&model, &model.parameters().nominal(), test, &args.pairing.how())?;
    Ok((name(path), model, assessment))
}

fn name(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}
