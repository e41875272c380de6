//! `retune completions`

use crate::DONE;
use crate::args::{Cli, Completions};
use crate::output::Failure;
use clap::CommandFactory;

pub(crate) fn run(args: &Completions) -> Result<u8, Failure> {
    clap_complete::generate(args.shell, &mut Cli::command(), "retune", &mut std::io::stdout());
    Ok(DONE)
}
