//! Where the answer of a verb goes.

use crate::output::{Failure, print_json};
use crate::writing;
use clap::Args;
use serde_json::Value;
use std::path::PathBuf;

/// Text for people, or JSON for programs.
#[derive(Debug, Args)]
pub(crate) struct Answer {
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the result as JSON.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing output file.
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

impl Answer {
    /// Before the work: can the output be written?
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.output.as_ref().map_or(Ok(()), |path| writing::check_output(path, self.force))
    }

    /// Whether JSON is needed at all.
    pub(crate) fn needs_json(&self) -> bool {
        self.json || self.output.is_some()
    }

    /// Writes the answer and prints it, as was asked for.
    pub(crate) fn give(&self, value: &Value) {
        if let Some(path) = &self.output {
            let _ = writing::write(path, &format!("{value:#}\n"));
        }
        if self.json {
            print_json(value);
        }
    }
}
