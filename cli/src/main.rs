//! The `retune` command.
//!
//! Exit codes: 0 done; 1 finished, but a criterion or a fit falls short; 2 wrong input; 70 a bug of ours.

mod args;
mod commands;
mod files;
mod output;
mod page;
mod progress;
mod uncertain;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// Done.
const DONE: u8 = 0;
/// Finished, but a criterion or a fit falls short.
const SHORT: u8 = 1;
/// Wrong input.
const WRONG_INPUT: u8 = 2;
/// A bug of ours.
const BUG: u8 = 70;
/// Stack of a thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            let _ = e.print();
            return ExitCode::from(if e.use_stderr() { WRONG_INPUT } else { DONE });
        }
    };
    let run = || match &cli.command {
        Command::Check(a) => commands::check::run(a),
        Command::Modes(a) => commands::modes::run(a),
        Command::Identify(a) => commands::identify::run(a),
        Command::Health(a) => commands::health::run(a),
        Command::Map(a) => commands::map::run(a),
        Command::Twin(a) => commands::twin::run(a),
        Command::Compare(a) => commands::compare::run(a),
        Command::Pretest(a) => commands::pretest::run(a),
        Command::Sensitivity(a) => commands::sensitivity::run(a),
        Command::Update(a) => commands::update::run(a),
        Command::Sample(a) => commands::sample::run(a),
        Command::Report(a) => commands::report::run(a),
        Command::Diagnose(a) => commands::diagnose::run(a),
        Command::Add(a) => commands::add::run(a),
        Command::Undo(a) => commands::add::run_undo(a),
        Command::Learn(a) => commands::learn::run(a),
        Command::Benchmark(a) => commands::benchmark::run(a),
        Command::Schema(a) => commands::schema::run(a),
        Command::List(a) => commands::list::run(a),
        Command::Explain(a) => commands::explain::run(a),
        Command::Completions(a) => commands::completions::run(a),
    };
    // A search hands hundreds of short batches a second to the threads of the pool: it runs on one of them itself.
    let _ = rayon::ThreadPoolBuilder::new().stack_size(STACK).build_global();
    let on_pool = || rayon::scope(|_| run());
    let code = match std::panic::catch_unwind(std::panic::AssertUnwindSafe(on_pool)) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            failure.print();
            WRONG_INPUT
        }
        Err(_) => {
            eprintln!("retune: this is a bug in retune; please report it with the command and its files");
            BUG
        }
    };
    ExitCode::from(code)
}
