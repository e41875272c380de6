//! `retune sample`

use super::update::{objective, reduced_text};
use crate::args::Sample;
use crate::interrupt::{before_search, stop_flag};
use crate::output::{self, Failure, print, print_json, style};
use crate::page::{Outputs, announce, provenance};
use crate::uncertain::folded;
use crate::{DONE, files, writing};
use retune::catalogue::counted;
use retune::correlation::Misfit;
use retune::model::ParametricModel;
use retune::optim::{Evaluator, Posterior, Shared, Threads, Tmcmc};
use retune::update::{Marginal, Peak, Settings, TestCase, marginals, sample_posterior_by, sampled_values};
use retune_report::text::{Align, Table, number, printable};
use retune_report::{answer, of_posterior};
use std::fmt::Write as _;
use std::path::Path;

pub(crate) fn run(args: &Sample) -> Result<u8, Failure> {
    before_search(BEFORE);
    let all = files::tested(&args.model.path, &args.tests.paths, args.model.configuration())?;
    let settings = Settings {
        objective: objective(args.search.objective.as_deref())?,
        pairing: args.pairing.how(),
        reduced: args.search.reduced,
        ..Settings::default()
    };
    if let Some(output) = &args.output {
        writing::check_output(output, args.overwrite.force)?;
    }
    let outputs = Outputs { page: args.report.as_ref(), force: args.overwrite.force, ..Outputs::default() };
    outputs.check()?;
    let cases: Vec<TestCase<'_>> = all.iter().map(|t| TestCase { model: &t.model, test: &t.test }).collect();
    let sampler =
        Tmcmc { n_samples: args.samples as usize, seed: args.random.seed, cancel: stop_flag(), ..Tmcmc::default() };
    let shared = match (args.shard, &args.folder) {
        (Some(part), Some(folder)) => {
            Some(Shared::new(folder, part.index(), part.of()).map_err(|e| Failure::text(e.to_string()))?)
        }
        _ => None,
    };
    let evaluator: &dyn Evaluator = shared.as_ref().map_or(&Threads, |shared| shared);
    let sampled = sample_posterior_by(&cases, &settings, &sampler, evaluator)?;
    let model = &all[0].model;
    let table = table(&sampled.posterior, model);
    let written = args.output.as_ref().filter(|output| writing::write(output, &table));
    let page = if args.report.is_some() {
        let mut data = of_posterior(model, &all[0].test, &sampled);
        data.meta.warnings.extend(all.iter().flat_map(|t| t.warnings.clone()));
        let read: Vec<(&str, &Path)> = std::iter::once(("model", args.model.path.as_path()))
            .chain(args.tests.paths.iter().map(|path| ("test", path.as_path())))
            .collect();
        provenance(&mut data, &read, Some(args.random.seed));
        outputs.write(&data)?
    } else {
        Vec::new()
    };
    if args.print.json {
        print_json(&answer::sampled(&sampled, model));
        return Ok(DONE);
    }
    let (found, marginals) = (&sampled.posterior, marginals(&sampled.posterior, model));
    let mut columns = vec![("parameter", Align::Left), ("mean", Align::Right), ("sd", Align::Right)];
    columns.extend(["5 %", "25 %", "50 %", "75 %", "95 %"].map(|q| (q, Align::Right)));
    columns.push(("unit", Align::Left));
    let mut rows = Table::new(columns);
    for m in &marginals {
        let mut row = vec![m.name.as_str().into(), number(m.mean).into(), number(m.sd).into()];
        row.extend(m.quantiles.map(|q| number(q).into()));
        row.push(m.unit.as_str().into());
        rows.row(row);
    }
    let mut out = format!("model  {}\n", printable(&model.spec().name));
    for t in &all {
        out += &format!("test   {}\n", t.test.name);
    }
    out.push('\n');
    out += &rows.render(&style(&std::io::stdout()));
    let _ = writeln!(
        out,
        "\nln Z = {:.2} ± {:.2} (standard error), the evidence of the model over its bounds\n{} after {} and {}; {:.0} % of the last steps accepted",
        found.log_evidence,
        found.log_evidence_se,
        counted(found.samples.len(), "sample"),
        counted(found.n_stages, "stage"),
        counted(found.evaluations as usize, "evaluation"),
        100.0 * found.acceptance
    );
    out += &folded(&misfit_text(&sampled.misfit), &style(&std::io::stdout()));
    if !sampled.peaks.is_empty() {
        out += &folded(&peaks_text(&sampled.peaks, &marginals), &style(&std::io::stdout()));
    }
    if let Some(r) = &sampled.reduced {
        out += &folded(reduced_text(r).trim_start(), &style(&std::io::stdout()));
    }
    if let Some(output) = written {
        let _ = writeln!(out, "written: {}", output::shown(output));
    }
    print(&out);
    announce(&page);
    Ok(DONE)
}

/// What Ctrl-C means before there are samples.
const BEFORE: &str = "stopped before sampling began: nothing was evaluated yet, and nothing was written";

/// p-value below which the model is not the one whose parameters are meant.
const WRONG: f64 = 0.01;

/// The best sample against the tests.
fn misfit_text(misfit: &Misfit) -> String {
    let warning = "; the intervals are those of a model that can be right, and this one cannot be: `retune diagnose` looks for what it lacks";
    format!("the best sample: {misfit}{}\n", if misfit.p_value < WRONG { warning } else { "" })
}

/// The peaks of a posterior, a line each.
fn peaks_text(peaks: &[Peak], all: &[Marginal]) -> String {
    let mut out = format!(
        "\nthe posterior has {} peaks with nothing probable between them; the means and standard deviations above are of all together\n",
        peaks.len()
    );
    for p in peaks {
        let value = |(k, m): (usize, &Marginal)| {
            format!("{} = {} ± {} {}", m.name, number(p.mean[k]), number(p.sd[k]), m.unit).trim_end().to_string()
        };
        let values: Vec<String> = all.iter().enumerate().map(value).collect();
        let _ = writeln!(out, "  {:.0} % of the samples: {}", 100.0 * p.share, values.join(", "));
    }
    out
}

/// The samples as CSV: parameters in the units of the tables, and half the squared misfit.
fn table(found: &Posterior, model: &dyn ParametricModel) -> String {
    let heads: Vec<String> = marginals(found, model)
        .iter()
        .map(|m| if m.unit.is_empty() { m.name.clone() } else { format!("{} [{}]", m.name, m.unit) })
        .collect();
    let mut out = format!("{},cost\n", heads.join(","));
    for (row, cost) in sampled_values(found, model).row_iter().zip(&found.costs) {
        let values: Vec<String> = row.iter().map(|v| format!("{v:e}")).collect();
        let _ = writeln!(out, "{},{cost:e}", values.join(","));
    }
    out
}
