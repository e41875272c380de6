//! `retune prepare`

use crate::args::Prepare;
use crate::interrupt;
use crate::output::{Failure, print, print_json, shown};
use crate::{DONE, files};
use retune::catalogue::counted;
use retune::model::{SOLVER_FOLDER, SolverRun, solver_runs};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::Ordering;

pub(crate) fn run(args: &Prepare) -> Result<u8, Failure> {
    let text = files::read(&args.model)?;
    let folder = args.model.parent().unwrap_or(Path::new(""));
    let runs = solver_runs(&text, &mut |file| files::matrices(&folder.join(file)))
        .map_err(|problems| Failure::problems(&args.model, &text, &problems))?;
    if runs.is_empty() {
        return Err(Failure::text(format!(
            "{}: no superelement has a `solver`, so there is nothing to run",
            shown(&args.model)
        )));
    }
    let kept = folder.join(SOLVER_FOLDER);
    let stop = interrupt::stop_flag();
    let mut list = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let is_there = run.process.is_there(&kept) && !args.again;
        let label = format!("{} of {}: {}", i + 1, runs.len(), told(run));
        let (did, seconds) = if is_there {
            ("kept", None)
        } else if args.dry_run {
            ("to do", None)
        } else {
            let took = run.process.run(&kept, &|| stop.load(Ordering::SeqCst));
            let took = took.map_err(|e| Failure::text(format!("run {label}: {e}")))?;
            ("done", Some(took.as_secs_f64()))
        };
        if !args.print.json {
            let took = seconds.map_or_else(String::new, |s| format!(" in {s:.1} s"));
            print(&format!("{did}{took}: {label}\n"));
        }
        list.push(entry(run, did, seconds));
    }
    if args.print.json {
        print_json(&json!({"folder": kept.to_string_lossy(), "runs": list}));
    } else {
        let of = runs[0].process.command().join(" ");
        let what = if args.dry_run { format!("`{of}`, nothing was run") } else { format!("kept in {}", shown(&kept)) };
        print(&format!("{}: {what}\n", counted(runs.len(), "run")));
    }
    Ok(DONE)
}

fn told(run: &SolverRun) -> String {
    if run.told.is_empty() { run.superelement.clone() } else { format!("{} at {}", run.superelement, run.told) }
}

fn entry(run: &SolverRun, did: &str, seconds: Option<f64>) -> Value {
    let values: serde_json::Map<String, Value> = run.values.iter().map(|(n, v)| (n.clone(), json!(v))).collect();
    json!({
        "superelement": run.superelement,
        "parameters": values,
        "command": run.process.command(),
        "folder": run.folder(),
        "state": did,
        "seconds": seconds,
    })
}
