//! `retune completions`

use crate::DONE;
use crate::args::{Cli, Completions};
use crate::output::Failure;
use clap::CommandFactory;

pub(crate) fn run(args: &Completions) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "retune", &mut script);
    args.to.hand_over(&String::from_utf8_lossy(&script))?;
    Ok(DONE)
}
