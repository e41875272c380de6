//! `retune diagnose`

use super::compare::origins;
use crate::args::Diagnose;
use crate::output::{Failure, print, print_json, style, warn};
use crate::{DONE, SHORT, files};
use retune::diagnosis::{Diagnosis, HypothesisResult, Settings, Verdict, diagnose};
use retune::report::text::{Align, Cell, Style, Table, Tone, number};

/// Rows of the table of hypotheses.
const SHOWN: usize = 10;

pub(crate) fn run(args: &Diagnose) -> Result<u8, Failure> {
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
        print(&(head + &text(&d, &style(&std::io::stdout()))));
    }
    Ok(if d.verdict == Verdict::Adequate { DONE } else { SHORT })
}

/// A diagnosis for people.
pub(crate) fn text(d: &Diagnosis, style: &Style) -> String {
    let mut out = format!("{}: {}\n\n", d.verdict.word(), d.sentence);
    out += &format!(
        "chi-squared of the fitted model {:.0} for {:.0} degrees of freedom\n",
        d.misfit, d.degrees_of_freedom
    );
    out += &format!(
        "tried {} effects in their places ({} leave a trace in these data) and {} faults of the measurement;\n",
        d.screened_effects, d.visible_effects, d.screened_faults
    );
    out += &format!("the best would be as good by chance in {}\n\n", retune::correlation::odds(d.p_value));
    let mut table = Table::new([
        ("hypothesis", Align::Left),
        ("probability", Align::Right),
        ("ln B", Align::Right),
        ("misfit", Align::Right),
        ("held out", Align::Right),
        ("estimate", Align::Right),
        ("90 %", Align::Left),
        ("", Align::Left),
    ]);
    let percent = |p: f64| format!("{:.1} %", 100.0 * p);
    let line = |what: &str, p: f64| -> Vec<Cell> {
        let blank = || Cell::from("");
        vec![what.into(), percent(p).as_str().into(), blank(), blank(), blank(), blank(), blank(), blank()]
    };
    table.row(line("nothing is missing", d.probability_none));
    for (i, h) in d.hypotheses.iter().take(SHOWN).enumerate() {
        let tied = i > 0 && d.hypotheses[0].tied_with.contains(&h.id);
        table.row(row(h, tied));
    }
    table.row(line("something outside the catalogue", d.probability_other));
    out += &table.render(style);
    out += "\nmisfit is the sum of ((model - test)/sd)² after a refit; held out predicts each mode from the others\n";
    if let Some(best) = d.hypotheses.first().filter(|_| d.verdict != Verdict::Adequate) {
        out += &format!("\n{}\n{}\n", best.id, best.patch.trim_end());
    }
    if !d.next_measurements.is_empty() {
        out += "\nwhat would separate the tied ones (expected ln B of the worst pair)\n";
        for n in d.next_measurements.iter().take(5) {
            out += &format!("  {:6.1}  {}\n", n.expected_ln_bayes, n.what);
        }
    }
    for w in &d.warnings {
        out += &format!("\nnote: {w}");
    }
    out + "\n"
}

fn row(h: &HypothesisResult, tied: bool) -> Vec<Cell> {
    let estimate = match (h.estimate, &h.unit) {
        (Some(v), Some(u)) if u != "1" => format!("{} {u}", number(v)),
        (Some(v), _) => number(v),
        _ => String::new(),
    };
    let interval = h.interval.map_or_else(String::new, |[l, u]| format!("{} … {}", number(l), number(u)));
    vec![
        h.id.as_str().into(),
        format!("{:.1} %", 100.0 * h.probability).into(),
        format!("{:.1}", h.ln_bayes).into(),
        format!("{:.0} → {:.0}", h.misfit_before, h.misfit_after).into(),
        format!("{:.0} → {:.0}", h.held_out_before, h.held_out_after).into(),
        estimate.into(),
        interval.into(),
        Cell::new(if tied { "tied" } else { "" }, Tone::Warning),
    ]
}
