//! `retune diagnose`

use crate::args::{Diagnose, SearchOptions};
use crate::files::{self, Tested};
use crate::interrupt::stop_flag;
use crate::output::{Failure, base_pairs, print, print_json, shown, style, tell};
use crate::page::{Outputs, announce, provenance};
use crate::progress::Spinner;
use crate::{DONE, SHORT, writing};
use retune::catalogue::did_you_mean;
use retune::data::{TestData, joined};
use retune::effect::{Effect, Effects};
use retune::fault::Faults;
use retune::model::ParametricModel;
use retune_diagnosis::{Effort, Settings, Until, Verdict, diagnose_tests};
use retune_report::{
    Case, ReportData, add_diagnosis, add_live, add_tests, answer, assess_paired, diagnosis, of_comparison, text,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(args: &Diagnose) -> Result<u8, Failure> {
    let how = args.pairing.how();
    let outputs = Outputs { page: args.report.as_ref(), force: args.overwrite.force, ..Outputs::default() };
    outputs.check()?;
    args.output.iter().try_for_each(|path| writing::check_output(path, args.overwrite.force))?;
    let all = files::tested(&args.model, &args.tests.paths, None)?;
    let (model, ..) = files::model(&args.model, None)?;
    for what in model.left_out_of_effects() {
        note!("{what}");
    }
    let tests: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
    let spinner = Spinner::new();
    let settings = Settings {
        seed: args.random.seed,
        faults: if args.no_faults { Faults::none() } else { Faults::builtin() },
        pairing: how,
        ..search_settings(&args.search, &spinner)?
    };
    let found = diagnose_tests(&model, &tests, &settings);
    drop(spinner);
    let d = found?;
    let (first, together) = (&all[0], joined(&tests).test);
    if args.print.json {
        print_json(&serde_json::to_value(&d)?);
    } else {
        let found = diagnosis(&d, &first.model, &together);
        let style = style(&std::io::stdout());
        let of_each = d.pairs.iter().zip(&all).enumerate();
        let pairs: String = of_each.map(|(k, (p, t))| base_pairs(p, d.pairs_with.get(k), &t.test, &style)).collect();
        print(
            &(head(&model.spec().name, &all)
                + "\n"
                + &text::diagnosis(&found, [&shown(&args.model), &shown(&args.tests.paths[0])], &style)
                + "\n"
                + &pairs),
        );
    }
    if let Some(path) = &args.output {
        let text = serde_json::to_string_pretty(&d)? + "\n";
        if writing::write(path, &text) && !args.print.json {
            announce(&[shown(path)]);
        }
    }
    if args.report.is_some() {
        let assessment = assess_paired(&first.model, &first.model.parameters().nominal(), &first.test, &how)?;
        let case = Case { model: &first.model, test: &first.test, assessment: &assessment };
        let mut data = of_comparison(case)?;
        add_diagnosis(&mut data, &d, &first.model, &together);
        add_live(&mut data, case, &others(&all), &how, None, &d.hypotheses);
        about_files(&mut data, &all, &args.model, &args.tests.paths, args.random.seed);
        let written = outputs.write(&data)?;
        if !args.print.json {
            announce(&written);
        }
    }
    Ok(if d.verdict == Verdict::Adequate && !d.is_partial { DONE } else { SHORT })
}

/// What is tried and for how long, and who is told.
pub(super) fn search_settings(options: &SearchOptions, spinner: &Spinner) -> Result<Settings, Failure> {
    let mut effects = if options.effects.is_empty() { Effects::builtin() } else { Effects::none() };
    for name in &options.effects {
        let known = Effects::builtin();
        let Some(effect) = known.find(name) else {
            let suggestion = did_you_mean(name, known.iter().map(Effect::name));
            let text = format!("there is no effect `{name}`{suggestion} (`retune list effects` has them all)");
            return Err(Failure::text(text));
        };
        effects = effects.with(effect);
    }
    let mut until = Until::the_end().stopped_by(stop_flag());
    if let Some(budget) = options.budget {
        until = until.elapsed(budget);
    }
    let mut listener = spinner.listener();
    if options.trace {
        let begun = Instant::now();
        listener = listener.with_steps(move |step| tell(&format!("{:7.1} s  {step}", begun.elapsed().as_secs_f64())));
    }
    let effort = Effort::default().times(options.effort);
    Ok(Settings { effects, places: options.places.clone(), effort, listener, until, ..Settings::default() })
}

/// The model and the tests, a line each.
pub(super) fn head(model: &str, all: &[Tested]) -> String {
    let mut out = format!("model  {}\n", text::printable(model));
    for t in all {
        let configuration = t.test.configuration.as_ref().filter(|_| all.len() > 1);
        let configuration = configuration.map_or_else(String::new, |c| format!(", configuration {c}"));
        out += &format!(
            "test   {}{configuration}\ndata   {}\n",
            text::printable(&t.test.name),
            answer::data_origins(&t.test).join("; ")
        );
    }
    out
}

/// Warnings and provenance of a page about several tests.
pub(super) fn about_files(data: &mut ReportData, all: &[Tested], model: &Path, tests: &[PathBuf], seed: u64) {
    warn_of_tests(data, all, "The diagnosis rests on");
    let mut read: Vec<(&str, &Path)> = vec![("model", model)];
    read.extend(tests.iter().map(|t| ("test", t.as_path())));
    provenance(data, &read, Some(seed));
}

/// The tests beside the first.
pub(super) fn others(all: &[Tested]) -> Vec<retune_report::Tested<'_>> {
    all.iter().skip(1).map(|t| (&t.model, &t.test)).collect()
}

/// What was warned of while the files were read, and which of several tests the pictures show.
///
/// * `opening` - of a sentence that goes on with the number of tests
pub(super) fn warn_of_tests(data: &mut ReportData, all: &[Tested], opening: &str) {
    data.meta.warnings.extend(all.iter().flat_map(|t| t.warnings.clone()));
    add_tests(data, &all.iter().map(|t| &t.test).collect::<Vec<_>>());
    if all.len() > 1 {
        let names: Vec<&str> = all.iter().map(|t| t.test.name.as_str()).collect();
        data.meta.warnings.push(format!(
            "{opening} {} tests together ({}); shapes, pairs and functions are those of the first.",
            all.len(),
            names.join(", ")
        ));
    }
}
