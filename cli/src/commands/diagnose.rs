//! `retune diagnose`

use super::compare::origins;
use crate::args::Diagnose;
use crate::output::{Failure, print, print_json, style, warn};
use crate::page::{Outputs, announce, provenance};
use crate::{DONE, SHORT, files};
use retune::diagnosis::{Settings, Verdict, diagnose};
use retune::model::ParametricModel;
use retune::report::{Case, add_diagnosis, assess_for_report, diagnosis, of_comparison, text};

pub(crate) fn run(args: &Diagnose) -> Result<u8, Failure> {
    let outputs = Outputs { page: args.report.as_ref(), force: args.force, ..Outputs::default() };
    outputs.check()?;
    let (test, test_warnings, test_text) = files::test(&args.test)?;
    let (model, model_warnings, model_text) = files::tested_model(&args.model, None, (&test, &args.test, &test_text))?;
    warn(&args.model, &model_text, &model_warnings);
    warn(&args.test, &test_text, &test_warnings);
    let settings = Settings { seed: args.seed, faults: !args.no_faults, ..Settings::default() };
    let d = diagnose(&model, &test, &settings)?;
    if args.json {
        print_json(&serde_json::to_value(&d)?);
    } else {
        let head =
            format!("model  {}\ntest   {}\ndata   {}\n\n", model.spec().name, test.name, origins(&test).join("; "));
        print(&(head + &text::diagnosis(&diagnosis(&d, &model, &test), &style(&std::io::stdout()))));
    }
    if args.report.is_some() {
        let assessment = assess_for_report(&model, &model.parameters().nominal(), &test)?;
        let mut data = of_comparison(Case { model: &model, test: &test, assessment: &assessment })?;
        add_diagnosis(&mut data, &d, &model, &test);
        data.meta.warnings.extend(model_warnings.iter().chain(&test_warnings).map(|p| p.message.clone()));
        provenance(&mut data, &[("model", &args.model), ("test", &args.test)], Some(args.seed))?;
        let written = outputs.write(&data)?;
        if !args.json {
            announce(&written);
        }
    }
    Ok(if d.verdict == Verdict::Adequate { DONE } else { SHORT })
}
