//! `retune update`

use super::compare::{origins, pair_json, summary, unpaired_json};
use crate::args::{Cost, Pairing, Update};
use crate::output::{Failure, pairs, parameters, print, print_json, style, warn};
use crate::page::{Outputs, announce, provenance};
use crate::progress::{Line, cancel_flag};
use crate::{DONE, SHORT, files};
use retune::correlation::PairBy;
use retune::model::ParametricModel;
use retune::optim::{Checkpoint, OptimizerSpec};
use retune::report::text::cost_history;
use retune::update::{self, Controls, Settings, update};
use serde_json::json;

pub(crate) fn run(args: &Update) -> Result<u8, Failure> {
    let (test, mut test_warnings, test_text) = files::test(&args.test)?;
    let (model, model_warnings, model_text) =
        files::tested_model(&args.model, args.configuration.as_deref(), (&test, &args.test, &test_text))?;
    test_warnings.extend(files::check_sensors(&model, &test, &args.test, &test_text)?);
    if let Some(output) = &args.output {
        files::check_output(output, args.force)?;
    }
    let outputs = Outputs { page: args.report.as_ref(), force: args.force, ..Outputs::default() };
    outputs.check()?;
    warn(&args.model, &model_text, &model_warnings);
    warn(&args.test, &test_text, &test_warnings);
    let settings = Settings {
        cost: match args.cost {
            Cost::LeastSquares => update::Cost::LeastSquares,
            Cost::Paper => update::Cost::Paper,
            Cost::Frequencies => update::Cost::Frequencies,
        },
        pairing: args.pairing.map(|p| match p {
            Pairing::Mac => PairBy::Mac,
            Pairing::Order => PairBy::Order,
        }),
        optimizer: args.optimizer.as_deref().map(optimizer).transpose()?,
        seed: args.seed,
    };
    let checkpoint = match &args.checkpoint {
        Some(path) if args.resume => Some(Checkpoint::resume(path)?),
        Some(path) => Some(Checkpoint::create(path)?),
        None => None,
    };
    let cancel = cancel_flag();
    let mut line = Line::new();
    let controls =
        Controls { budget: args.budget, cancel: Some(cancel), observer: Some(&mut line), evaluator: None, checkpoint };
    let result = update(&model, &test, &settings, controls);
    drop(line);
    let u = result?;
    if let Some(output) = &args.output {
        let values: Vec<(&str, f64)> =
            u.parameters.iter().filter(|p| p.lower.is_some()).map(|p| (p.name.as_str(), p.after_si)).collect();
        files::write(output, &retune::model::set_parameter_values(&model_text, &values)?)?;
    }
    if args.json {
        print_json(&json!({
            "cost_before": u.cost_before,
            "cost_after": u.optimum.cost,
            "evaluations": u.optimum.evaluations + u.optimum.linearizations,
            "termination": u.optimum.termination.text(),
            "parameters": u.parameters.iter().map(|p| json!({
                "name": p.name, "unit": p.unit, "before": p.before, "after": p.after,
                "lower": p.lower, "upper": p.upper, "at_bound": p.at_bound,
            })).collect::<Vec<_>>(),
            "pairs": u.after.pairs.iter().map(pair_json).collect::<Vec<_>>(),
            "unpaired_test": u.after.unpaired_test.iter().map(unpaired_json).collect::<Vec<_>>(),
            "chi_squared": u.after.misfit.chi_squared,
            "n_data": u.after.misfit.n_data,
            "warnings": u.optimum.warnings,
        }));
    } else {
        let style = style(&std::io::stdout());
        let history: Vec<u64> = u.optimum.history.iter().map(|h| h.evaluations).collect();
        let costs: Vec<f64> = u.optimum.history.iter().map(|h| h.cost).collect();
        let mut out = format!("model  {}\ntest   {}\n", model.spec().name, test.name);
        out += &format!("data   {}\n\nbefore\n", origins(&test).join("; "));
        out += &pairs(&u.before, &style);
        out += &format!("\ncost   {}\n", cost_history(&history, &costs, style.width.saturating_sub(7)));
        out += &format!("       {:.6} -> {:.6}; {}\n", u.cost_before, u.optimum.cost, u.optimum.termination.text());
        if let Some(starts) = u.optimum.starts_in_words() {
            out += &format!("       {starts}\n");
        }
        out += "\nafter\n";
        out += &pairs(&u.after, &style);
        out += &summary(&u.after);
        out += "\n";
        out += &parameters(&u.parameters, &style);
        let on_bounds = u.parameters.iter().filter(|p| p.at_bound && p.lower.is_some()).count();
        if on_bounds > 0 {
            out += &format!(
                "\n{on_bounds} of {} parameters sit on a bound: that says something about the model, not about the parameters\n",
                model.parameters().free().len()
            );
        }
        if let Some(output) = &args.output {
            out += &format!("\nwritten: {}\n", output.display());
        }
        print(&out);
    }
    if args.report.is_some() {
        let mut data = retune::report::of_update(&model, &test, &u)?;
        data.meta.warnings.extend(model_warnings.iter().chain(&test_warnings).map(|p| p.message.clone()));
        data.meta.warnings.extend(u.optimum.warnings.iter().map(ToString::to_string));
        provenance(&mut data, &[("model", &args.model), ("test", &args.test)], Some(args.seed))?;
        let written = outputs.write(&data)?;
        if !args.json {
            announce(&written);
        }
    }
    for warning in &u.optimum.warnings {
        eprintln!("warning: {warning}");
    }
    Ok(if u.after.unpaired_test.is_empty() && u.optimum.cost.is_finite() { DONE } else { SHORT })
}

fn optimizer(text: &str) -> Result<OptimizerSpec, Failure> {
    retune::yaml::read::<OptimizerSpec>(text).map(|(spec, _)| spec).map_err(|problems| {
        let words: Vec<String> = problems.into_iter().map(|p| p.message).collect();
        Failure::text(format!("--optimizer: {}", words.join("; ")))
    })
}
