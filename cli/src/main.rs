//! The `retune` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(retune_cli::command(std::env::args_os().collect()))
}
