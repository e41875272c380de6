//! `retune update`

use super::compare::summary;
use super::diagnose::others;
use super::measured::findings_text;
use crate::args::Update;
use crate::interrupt::{before_search, stop_flag};
use crate::output::{Failure, mac_matrix, pairs, print, print_json, shown, style};
use crate::page::{Outputs, announce, provenance};
use crate::progress::Line;
use crate::{DONE, SHORT, files, uncertain, writing};
use retune::catalogue::counted;
use retune::data::TestData;
use retune::effect::set_parameter_values;
use retune::optim::{Checkpoint, OptimizerSpec};
use retune::update::{
    Assessment, Controls, ObjectiveSpec, ReducedSearch, Settings, TestCase, UnpairedMode, update_to_tests,
};
use retune_report::text::{cost_history, printable};
use retune_report::{Case, add_live, add_tests, answer};
use std::path::Path;

/// The objective of a file, or the default.
pub(crate) fn objective(path: Option<&Path>) -> Result<ObjectiveSpec, Failure> {
    let Some(path) = path else { return Ok(ObjectiveSpec::default()) };
    let text = files::read(path)?;
    ObjectiveSpec::read(&text).map_err(|problems| Failure::problems(path, &text, &problems))
}

/// What Ctrl-C means before there is a best point.
const BEFORE: &str = "stopped before the search began: nothing was evaluated yet, and nothing was written";

pub(crate) fn run(args: &Update) -> Result<u8, Failure> {
    before_search(BEFORE);
    let mut all = files::tested(&args.model.path, &args.tests.paths, args.model.configuration())?;
    for tested in &mut all {
        tested.model = files::loaded(tested.model.clone(), &tested.test, args.loading.sensor_masses)?;
    }
    let objective = objective(args.search.objective.as_deref())?;
    if let Some(output) = &args.output {
        // New values may be longer than the old ones.
        writing::check_room(output, args.overwrite.force, all[0].model_text.len() + 4096)?;
    }
    let outputs = Outputs { page: args.report.as_ref(), force: args.overwrite.force, ..Outputs::default() };
    outputs.check()?;
    let settings = Settings {
        cost: args.cost,
        pairing: args.pairing.how(),
        optimizer: args.optimizer.as_deref().map(optimizer).transpose()?,
        seed: args.random.seed,
        objective,
        reduced: args.search.reduced,
    };
    if let Some(path) = &args.checkpoint {
        writing::reserve(path)?;
    }
    let checkpoint = match &args.checkpoint {
        Some(path) if args.resume => Some(Checkpoint::resume(path)?),
        Some(path) => Some(Checkpoint::create(path)?),
        None => None,
    };
    let cancel = stop_flag();
    let mut line = Line::new();
    let controls =
        Controls { budget: args.budget, cancel: Some(cancel), observer: Some(&mut line), evaluator: None, checkpoint };
    let cases: Vec<TestCase<'_>> = all.iter().map(|t| TestCase { model: &t.model, test: &t.test }).collect();
    let result = update_to_tests(&cases, &settings, controls);
    drop(line);
    let u = result?;
    let mut is_written = false;
    if let Some(output) = &args.output {
        let values: Vec<(&str, f64)> =
            u.parameters.iter().filter(|p| p.lower.is_some()).map(|p| (p.name.as_str(), p.after_si)).collect();
        let text = set_parameter_values(&all[0].model_text, &values)?;
        is_written = writing::write(output, &files::beside(&text, &args.model.path, output)?);
    }
    let mut assessed: Vec<(&Assessment, &Assessment)> = vec![(&u.before, &u.after)];
    assessed.extend(u.further.iter().map(|f| (&f.before, &f.after)));
    if args.print.json {
        let tests: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
        print_json(&answer::updated(&u, &tests));
    } else {
        let style = style(&std::io::stdout());
        let history: Vec<u64> = u.optimum.history.iter().map(|h| h.evaluations).collect();
        let costs: Vec<f64> = u.optimum.history.iter().map(|h| h.cost).collect();
        let mut out = format!("model  {}\n", printable(&all[0].model.spec().name));
        for t in &all {
            out +=
                &format!("test   {}\ndata   {}\n", printable(&t.test.name), answer::data_origins(&t.test).join("; "));
        }
        for (t, (before, _)) in all.iter().zip(&assessed) {
            out += &format!("\nbefore{}\n", named(t, all.len()));
            out += &pairs(before, None, &style);
        }
        out += &format!("\ncost   {}\n", cost_history(&history, &costs, style.width.saturating_sub(7)));
        let fell = format!("       {:.6} -> {:.6}; {}\n", u.cost_before, u.optimum.cost, u.optimum.termination.text());
        out += &uncertain::folded(&fell, &style);
        let paths = u.optimum.paths;
        if paths.batch > 0 {
            out += &format!(
                "       {} by the fast kernel, {} by the full computation that checks it\n",
                counted(paths.batch as usize, "candidate"),
                paths.reference
            );
        }
        if let Some(r) = &u.reduced {
            out += &uncertain::folded(&reduced_text(r), &style);
        }
        if let Some(starts) = u.optimum.starts_in_words() {
            out += &format!("       {starts}\n");
        }
        if let Some(weight) = u.regularization {
            out += &format!("       pull towards the estimates: weight {weight:.3e}\n");
        }
        for (t, (_, after)) in all.iter().zip(&assessed) {
            out += &format!("\nafter{}\n", named(t, all.len()));
            out += &pairs(after, None, &style);
            out += &mac_matrix(after, &t.test, &style);
            out += &summary(after);
        }
        for (t, found) in all.iter().zip(&u.suspects).filter(|(_, found)| !found.is_empty()) {
            out += &format!("\nsensors against the motions of the fitted model{}\n", named(t, all.len()));
            out += &findings_text(found, &style);
        }
        out += "\n";
        out += &uncertain::parameters(&u, &style);
        if let Some(output) = args.output.as_ref().filter(|_| is_written) {
            out += &format!("\nwritten: {}\n", shown(output));
        }
        print(&out);
    }
    if args.report.is_some() {
        let first = &all[0];
        let mut data = retune_report::of_update(&first.model, &first.test, &u)?;
        let case = Case { model: &first.model, test: &first.test, assessment: &u.after };
        add_live(&mut data, case, &others(&all), &settings.pairing, Some(&first.model), &[]);
        data.meta.warnings.extend(u.uncertainty.remarks.iter().cloned());
        add_tests(&mut data, &all.iter().map(|t| &t.test).collect::<Vec<_>>());
        if all.len() > 1 {
            let n = all.len();
            data.meta.warnings.push(format!("The fit is to {n} tests; modes, pairs and steps show the first."));
        }
        data.meta.warnings.extend(u.optimum.warnings.iter().map(ToString::to_string));
        let read: Vec<(&str, &Path)> = std::iter::once(("model", args.model.path.as_path()))
            .chain(args.tests.paths.iter().map(|path| ("test", path.as_path())))
            .collect();
        provenance(&mut data, &read, Some(args.random.seed));
        let written = outputs.write(&data)?;
        if !args.print.json {
            announce(&written);
        }
    }
    for warning in &u.optimum.warnings {
        warning!("{warning}");
    }
    // What is not of the structure leaves the fit as good as it is.
    let is_lost = |u: &&UnpairedMode| !u.by_user && u.foreign.is_none();
    let lost: usize = assessed.iter().map(|(_, a)| a.unpaired_test.iter().filter(is_lost).count()).sum();
    if lost > 0 {
        let (modes, have) = if lost == 1 { ("mode", "has") } else { ("modes", "have") };
        warning!(
            "{lost} measured {modes} of the structure {have} no partner and took no part in the fit; the exit code is {SHORT}"
        );
    }
    Ok(if lost == 0 && u.optimum.cost.is_finite() { DONE } else { SHORT })
}

/// What reduced models had to do with a result.
pub(crate) fn reduced_text(r: &ReducedSearch) -> String {
    let dofs: Vec<String> = r.dofs.iter().map(|(full, own)| format!("{own} of {}", counted(*full, "dof"))).collect();
    format!(
        "       reduced model: {} from {} samples, frequencies within {:.0e} (estimated{}); {}; cost at its best point {:.6}, of the full model {:.6}\n",
        dofs.join(", "),
        r.n_samples,
        r.accuracy,
        if r.accuracy > r.tolerance { format!("; {:.0e} was asked for", r.tolerance) } else { String::new() },
        counted(r.evaluations as usize, "evaluation"),
        r.costs[0],
        r.costs[1]
    )
}

/// ": name" where there are several tests.
fn named(t: &files::Tested, n_tests: usize) -> String {
    if n_tests > 1 { format!(": {}", t.test.name) } else { String::new() }
}

fn optimizer(text: &str) -> Result<OptimizerSpec, Failure> {
    retune::yaml::read::<OptimizerSpec>(text).map(|(spec, _)| spec).map_err(|problems| {
        let words: Vec<String> = problems.into_iter().map(|p| p.message).collect();
        Failure::text(format!("--optimizer: {}", words.join("; ")))
    })
}
