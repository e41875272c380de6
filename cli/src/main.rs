//! The `retune` command.

use mimalloc::MiMalloc;
use std::process::ExitCode;

#[global_allocator]
static MEMORY: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    // Where the system does not tell, the name that it was started by finds it again.
    let own = std::env::current_exe().map_or_else(|_| std::env::args_os().next(), |path| Some(path.into()));
    ExitCode::from(retune_cli::command(own.into_iter().collect(), std::env::args_os().collect()))
}
