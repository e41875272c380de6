//! The `retune` command, as a library: [`command`] is what the binary calls, and what the command of the Python package calls.
//!
//! Exit codes: 0 done; 1 finished, but a criterion is missed, or a diagnosis is anything but `adequate`; 2 wrong input, or an output that cannot be written; 70 a bug
//! of ours; 130 stopped before there was a result.

// A stream that is closed or full must not end the program: `output` writes to both.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod output;

mod args;
mod commands;
mod files;
mod interrupt;
mod ledger;
mod lists;
mod markdown;
mod page;
mod progress;
mod schemas;
mod uncertain;
mod writing;

use args::{Cli, Command};
use output::{LONGEST, print, shortened, tell, tell_kept};
use retune_report::text::printable;
use std::ffi::OsString;
use std::io::IsTerminal as _;
use std::sync::OnceLock;

/// Done.
const DONE: u8 = 0;
/// Finished, but a criterion is missed.
const SHORT: u8 = 1;
/// Wrong input.
const WRONG_INPUT: u8 = 2;
/// Stopped before there was a result: the number that shells give to Ctrl-C.
const STOPPED: u8 = 130;
/// A bug of ours.
const BUG: u8 = 70;
/// What each exit code means.
const EXIT_CODES: [(u8, &str); 5] = [
    (DONE, "done"),
    (
        SHORT,
        "finished, but a criterion is missed, a measured mode of the structure has no partner, a test contradicts itself, or a diagnosis is anything but `adequate`",
    ),
    (WRONG_INPUT, "wrong input, or an output that cannot be written"),
    (BUG, "a bug of retune: please report it with the command and its files"),
    (STOPPED, "stopped before there was a result"),
];
/// Stack of a thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// The words that start this program once more.
static AGAIN: OnceLock<Vec<OsString>> = OnceLock::new();

/// The words that start this program once more: what has jobs starts a process for each.
fn again() -> &'static [OsString] {
    AGAIN.get().map_or(&[], Vec::as_slice)
}

/// Performs a command line, and gives the exit code. Once a process: signals, the files that were read and the threads are of the process.
///
/// * `program` - the words that start this program: its path, or an interpreter and a module
/// * `words` - the command line, the name of the program first
pub fn command(program: Vec<OsString>, words: Vec<OsString>) -> u8 {
    AGAIN.get_or_init(|| program);
    interrupt::watch();
    let code = match args::parse(words) {
        Ok(cli) => perform(&cli),
        Err(e) => answer(&e),
    };
    if tell_kept() && code != BUG { WRONG_INPUT } else { code }
}

/// Help, the version, or why the command line is wrong.
fn answer(e: &clap::Error) -> u8 {
    let text = e.render();
    if e.use_stderr() {
        // The message quotes what was typed.
        let plain: Vec<String> =
            text.to_string().trim_end().lines().map(|line| shortened(&printable(line), LONGEST)).collect();
        tell(&plain.join("\n"));
        WRONG_INPUT
    } else {
        let is_coloured = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        print(&if is_coloured { text.ansi().to_string() } else { text.to_string() });
        DONE
    }
}

fn perform(cli: &Cli) -> u8 {
    let run = || match &cli.command {
        Command::Init(a) => commands::init::run(a),
        Command::Check(a) => commands::check::run(a),
        Command::Modes(a) => commands::modes::run(a),
        Command::Identify(a) => commands::identify::run(a),
        Command::Export(a) => commands::export::run(a),
        Command::Import(a) => commands::import::run(a),
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
        Command::Batch(a) => commands::batch::run(a),
        Command::Merge(a) => commands::merge::run(a),
        Command::Matrices(a) => commands::matrices::run(a),
        Command::Prepare(a) => commands::prepare::run(a),
        Command::Schema(a) => commands::schema::run(a),
        Command::List(a) => commands::list::run(a),
        Command::Explain(a) => commands::explain::run(a),
        Command::Completions(a) => commands::completions::run(a),
        Command::Manual(a) => commands::manual::run(a),
    };
    // A search hands hundreds of short batches a second to the threads of the pool: it runs on one of them itself.
    let _ = rayon::ThreadPoolBuilder::new().stack_size(STACK).build_global();
    let on_pool = || rayon::scope(|_| run());
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(on_pool)) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            failure.print();
            if interrupt::was_stopped() { STOPPED } else { WRONG_INPUT }
        }
        Err(_) => {
            tell("retune: this is a bug in retune; please report it with the command and its files");
            BUG
        }
    }
}
