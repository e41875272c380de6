//! `retune sample`

use super::update::{objective, reduced_json, reduced_text, tolerance};
use crate::args::Sample;
use crate::interrupt::{before_search, stop_flag};
use crate::output::{self, Failure, print, print_json, style};
use crate::uncertain::folded;
use crate::{DONE, files, writing};
use retune::catalogue::counted;
use retune::correlation::correlations;
use retune::model::ParametricModel;
use retune::objective::Scaling;
use retune::optim::{Posterior, Tmcmc};
use retune::report::text::{Align, Table, number};
use retune::update::{Peak, Sampled, Settings, TestCase, sample_posterior};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Quantiles that are printed.
const QUANTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

pub(crate) fn run(args: &Sample) -> Result<u8, Failure> {
    before_search(BEFORE);
    let all = files::tested(&args.model, &args.tests, args.configuration.as_deref())?;
    let settings = Settings {
        objective: objective(args.objective.as_deref())?,
        pairing: args.pairing.how(),
        reduced: tolerance(args.reduced)?,
        ..Settings::default()
    };
    if let Some(output) = &args.output {
        writing::check_output(output, args.force)?;
    }
    let cases: Vec<TestCase<'_>> = all.iter().map(|t| TestCase { model: &t.model, test: &t.test }).collect();
    let sampler = Tmcmc { n_samples: args.samples as usize, seed: args.seed, cancel: stop_flag(), ..Tmcmc::default() };
    let Sampled { posterior: found, peaks, reduced } = sample_posterior(&cases, &settings, &sampler)?;
    let model = &all[0].model;
    let scaling = Scaling::new(model);
    let shown = |j: usize, x: f64| {
        let i = scaling.free()[j];
        let p = model.parameters().get(i);
        let [lower, _] = p.bounds.unwrap_or([p.value; 2]);
        p.display(lower + x * scaling.width()[j])
    };
    let table = table(&found, model, &scaling, &shown);
    let written = args.output.as_ref().filter(|output| writing::write(output, &table));
    let rho = correlations(&found.covariance());
    let mean = found.mean();
    let name = |j: usize| model.parameters().get(scaling.free()[j]).name.as_str();
    let unit = |j: usize| model.parameters().get(scaling.free()[j]).unit.as_str();
    let sd = |j: usize| (shown(j, found.covariance()[(j, j)].sqrt()) - shown(j, 0.0)).abs();
    if args.json {
        let one = |j: usize| -> Value {
            let others = (0..mean.len()).filter(|&k| k != j).map(|k| (name(k).to_string(), json!(rho[(j, k)])));
            json!({
                "name": name(j), "unit": unit(j), "mean": shown(j, mean[j]), "sd": sd(j),
                "interval": [shown(j, found.quantile(j, 0.05)), shown(j, found.quantile(j, 0.95))],
                "median": shown(j, found.quantile(j, 0.5)),
                "correlations": Value::Object(others.collect()),
            })
        };
        print_json(&json!({
            "parameters": (0..mean.len()).map(one).collect::<Vec<_>>(),
            "samples": found.samples.len(),
            "log_evidence": found.log_evidence,
            "log_evidence_se": found.log_evidence_se,
            "stages": found.n_stages,
            "evaluations": found.evaluations,
            "acceptance": found.acceptance,
            "peaks": peaks.iter().map(|p| peak_json(p, &name, &unit)).collect::<Vec<_>>(),
            "reduced": reduced.as_ref().map(reduced_json),
            "lowest_cost": found.costs.iter().copied().fold(f64::INFINITY, f64::min),
        }));
        return Ok(DONE);
    }
    let mut columns = vec![("parameter", Align::Left), ("mean", Align::Right), ("sd", Align::Right)];
    columns.extend(["5 %", "25 %", "50 %", "75 %", "95 %"].map(|q| (q, Align::Right)));
    columns.push(("unit", Align::Left));
    let mut rows = Table::new(columns);
    for j in 0..mean.len() {
        let mut row = vec![name(j).into(), number(shown(j, mean[j])).into(), number(sd(j)).into()];
        row.extend(QUANTILES.map(|q| number(shown(j, found.quantile(j, q))).into()));
        row.push(unit(j).into());
        rows.row(row);
    }
    let mut out = format!("model  {}\n", model.spec().name);
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
    if !peaks.is_empty() {
        out += &folded(&peaks_text(&peaks, &name, &unit), &style(&std::io::stdout()));
    }
    if let Some(r) = &reduced {
        out += &folded(reduced_text(r).trim_start(), &style(&std::io::stdout()));
    }
    if let Some(output) = written {
        let _ = writeln!(out, "written: {}", output::shown(output));
    }
    print(&out);
    Ok(DONE)
}

/// What Ctrl-C means before there are samples.
const BEFORE: &str = "stopped before sampling began: nothing was evaluated yet, and nothing was written";

/// The peaks of a posterior, a line each.
fn peaks_text<'a>(peaks: &[Peak], name: &dyn Fn(usize) -> &'a str, unit: &dyn Fn(usize) -> &'a str) -> String {
    let mut out = format!(
        "\nthe posterior has {} peaks with nothing probable between them; the means and standard deviations above are of all together\n",
        peaks.len()
    );
    for p in peaks {
        let value = |k: usize| format!("{} = {} ± {} {}", name(k), number(p.mean[k]), number(p.sd[k]), unit(k));
        let values: Vec<String> = (0..p.mean.len()).map(|k| value(k).trim_end().to_string()).collect();
        let _ = writeln!(out, "  {:.0} % of the samples: {}", 100.0 * p.share, values.join(", "));
    }
    out
}

fn peak_json<'a>(p: &Peak, name: &dyn Fn(usize) -> &'a str, unit: &dyn Fn(usize) -> &'a str) -> Value {
    let one = |k: usize| json!({"name": name(k), "unit": unit(k), "mean": p.mean[k], "sd": p.sd[k]});
    json!({"share": p.share, "parameters": (0..p.mean.len()).map(one).collect::<Vec<_>>()})
}

/// The samples as CSV: parameters in the units of the tables, and half the squared misfit.
fn table(
    found: &Posterior,
    model: &dyn ParametricModel,
    scaling: &Scaling,
    shown: &dyn Fn(usize, f64) -> f64,
) -> String {
    let heads: Vec<String> = scaling
        .free()
        .iter()
        .map(|&i| model.parameters().get(i))
        .map(|p| if p.unit.is_empty() { p.name.clone() } else { format!("{} [{}]", p.name, p.unit) })
        .collect();
    let mut out = format!("{},cost\n", heads.join(","));
    for (x, cost) in found.samples.iter().zip(&found.costs) {
        let values: Vec<String> = (0..x.len()).map(|j| format!("{:e}", shown(j, x[j]))).collect();
        let _ = writeln!(out, "{},{cost:e}", values.join(","));
    }
    out
}
