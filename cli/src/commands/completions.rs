//! `retune completions`

use crate::DONE;
use crate::args::{Cli, Completions};
use crate::output::Failure;
use crate::writing::hand_over;
use clap::CommandFactory;

pub(crate) fn run(args: &Completions) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "retune", &mut script);
    hand_over(&args.to, &String::from_utf8_lossy(&script))?;
    Ok(DONE)
}
