//! `retune benchmark`

use crate::DONE;
use crate::args::{Answer, Benchmark, BenchmarkWhat};
use crate::output::{Failure, print, shown};
use crate::progress::bar;
use crate::{files, writing};
use retune::catalogue::did_you_mean;
use retune_diagnosis::benchmark::{
    Benchmark as Measured, Class, Part, Plan, STRUCTURES, Score, Shard, Share, benchmark, run_shard,
};
use retune_diagnosis::{Settings, Verdict};
use std::fmt::Write as _;

/// Bytes of a shard, at most: whole diagnoses of many cases are in it.
pub(crate) const LARGEST_SHARD: u64 = 1 << 30;

pub(crate) fn run(args: &Benchmark) -> Result<u8, Failure> {
    if args.shard.is_none() {
        args.answer.check()?;
    }
    let BenchmarkWhat::Diagnosis = args.what;
    let known = || STRUCTURES.iter().map(|s| s.0);
    if let Some(name) = args.structure.iter().find(|name| !known().any(|k| k == *name)) {
        let names: Vec<&str> = known().collect();
        let suggestion = did_you_mean(name, known());
        return Err(Failure::text(format!(
            "there is no structure `{name}`{suggestion}; there are {}",
            names.join(", ")
        )));
    }
    if args.modes == 0 {
        return Err(Failure::text("--modes 0: a test has at least one mode"));
    }
    let plan = Plan {
        structures: args.structure.clone(),
        null: args.null,
        effects: args.effects,
        faults: args.faults,
        outside: args.outside,
        foreign: args.foreign,
        sensors: args.sensors,
        modes: args.modes,
        noise_factor: args.noise_factor,
        seed: args.seed,
        only: args.case.clone(),
        ..Plan::default()
    };
    let settings = Settings::default();
    let bar = bar("cases");
    let progress = |done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
    };
    if let Some(part) = args.shard {
        if is_there(args, &plan, &settings, part)? {
            return Ok(DONE);
        }
        let text = run_shard(&plan, &settings, part, &progress)?.to_text()?;
        bar.finish_and_clear();
        match &args.answer.output {
            Some(path) => {
                let _ = writing::write(path, &text);
            }
            None => print(&text),
        }
        return Ok(DONE);
    }
    let result = benchmark(&plan, &settings, &progress)?;
    bar.finish_and_clear();
    give(&args.answer, &result, args.cases || args.case.is_some())
}

/// Whether the output has the shard already, so that nothing need be run.
fn is_there(args: &Benchmark, plan: &Plan, settings: &Settings, part: Part) -> Result<bool, Failure> {
    let Some(path) = args.answer.output.as_ref().filter(|path| !args.answer.force && writing::is_there(path)) else {
        args.answer.check()?;
        return Ok(false);
    };
    let shard = Shard::read(&files::read_at_most(path, LARGEST_SHARD)?);
    match shard.and_then(|shard| shard.check(plan, settings, part)) {
        Ok(()) => {
            note!("{} is shard {part} of this benchmark already; nothing is run", shown(path));
            Ok(true)
        }
        Err(why) => Err(Failure::text(format!("{} exists: {why}; give --force to overwrite it", shown(path)))),
    }
}

/// Gives the result of all cases.
pub(crate) fn give(answer: &Answer, result: &Measured, cases: bool) -> Result<u8, Failure> {
    if answer.needs_json() {
        answer.give(&serde_json::to_value(result)?);
    }
    if !answer.json {
        print(&text(result, cases));
    }
    Ok(DONE)
}

fn text(result: &Measured, cases: bool) -> String {
    let mut out = String::new();
    if cases {
        for o in result.outcomes.iter().filter(|o| o.verdict.is_some()) {
            let good = if o.class == Class::Nothing {
                o.verdict == Some(Verdict::Adequate)
            } else if o.class == Class::Outside {
                o.verdict == Some(Verdict::Unexplained)
            } else {
                o.right
            };
            let _ = writeln!(
                out,
                "{} {:16} {:52} gain {:8.0} {:18} {:52} p {:.3} ties {} {}{}{} removed {:.2} noise {:.2}",
                if good { " " } else { "x" },
                o.structure,
                o.id,
                o.gain,
                o.verdict.map_or("", Verdict::word),
                o.found_id,
                o.stated,
                o.ties,
                if o.tied { "tied " } else { "" },
                if o.alike { "alike " } else { "" },
                if o.refitted { "" } else { "not-refitted" },
                o.removed,
                o.noise_factor,
            );
            for h in o.diagnosis.iter().flat_map(|d| &d.hypotheses) {
                let sizes: Vec<String> =
                    h.estimates.iter().map(|e| format!("{} {:.4e}", e.parameter, e.value)).collect();
                let _ = writeln!(
                    out,
                    "      {:.3}  ln B {:10.1}  misfit {:10.1}  {}  {}",
                    h.probability,
                    h.ln_bayes,
                    h.misfit_after,
                    h.id,
                    sizes.join(", ")
                );
            }
            if let Some(d) = &o.diagnosis {
                let _ = writeln!(
                    out,
                    "      none {:.3}, other {:.3}, misfit {:.1} of {:.1}, of the truth {:.1} with {:?}; {}",
                    d.probability_none,
                    d.probability_other,
                    d.misfit,
                    d.degrees_of_freedom,
                    o.misfit_of_truth,
                    o.sizes,
                    d.sentence
                );
            }
        }
        out.push('\n');
    }
    out + &score(&result.score)
}

fn score(s: &Score) -> String {
    let mut out = String::from("| question | share | cases | bar |\n| --- | --- | --- | --- |\n");
    let mut line = |what: &str, share: Share, bar: &str| {
        let value = if share.of > 0 { format!("{:.1} %", 100.0 * share.value()) } else { "–".into() };
        let _ = writeln!(out, "| {what} | {value} | {} of {} | {bar} |", share.count, share.of);
    };
    line("false alarms where nothing is missing", s.false_alarms, "≤ 5 %");
    line("hidden effects that can be seen (misfit gain above 30)", s.visible_effects, "");
    line("visible effects: kind and place first", s.right_first, "≥ 90 %");
    line("visible effects: that, or the same trace in these data, first", s.alike_first, "");
    line("visible effects: kind first", s.right_kind, "");
    line("visible effects: in the tie set", s.in_tie_set, "≥ 97 %");
    line("visible effects: wrong and alone", s.wrong_and_alone, "≤ 3 %");
    line("visible effects: nine tenths of the error gone after `add`", s.error_removed, "≥ 90 %");
    line("hidden faults that can be seen", s.faults_visible, "");
    line("visible faults: kind and sensor first", s.faults_right, "≥ 90 %");
    line("visible changes outside the catalogue: called adequate", s.outside_adequate, "0 %");
    line("visible changes outside the catalogue: unexplained", s.outside_unexplained, "≥ 60 %");
    line("modes of no structure: named as such", s.foreign_named, "≥ 98 %");
    line("modes of the structure: called foreign", s.true_lost, "≤ 2 %");
    let _ = writeln!(
        out,
        "\nexpected calibration error {:.3} (bar 0.08); stated, right, cases:",
        s.calibration.expected_error
    );
    for (stated, right, cases) in &s.calibration.bins {
        let _ = writeln!(out, "  {stated:.2}  {right:.2}  {cases}");
    }
    out.push_str("\n| structure | false alarms | kind and place first | in the tie set |\n| --- | --- | --- | --- |\n");
    for (name, shares) in &s.structures {
        let cells: Vec<String> = shares.iter().map(|s| format!("{} of {}", s.count, s.of)).collect();
        let _ = writeln!(out, "| {name} | {} |", cells.join(" | "));
    }
    out.push_str("\n| hidden | found |\n| --- | --- |\n");
    for (hidden, found) in &s.confusion {
        let mut found: Vec<(&String, &usize)> = found.iter().collect();
        found.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
        let cells: Vec<String> = found.iter().map(|(f, n)| format!("{f} {n}")).collect();
        let _ = writeln!(out, "| {hidden} | {} |", cells.join(", "));
    }
    out
}
