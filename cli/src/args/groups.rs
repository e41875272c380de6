//! Arguments that several verbs have, each in one wording.

use super::values;
use clap::Args;
use std::path::PathBuf;

/// A model, in one of its configurations.
#[derive(Debug, Args)]
pub(crate) struct OneModel {
    /// Model file.
    #[arg(id = "model", value_name = "MODEL")]
    pub(crate) path: PathBuf,
    /// Configuration of the model: a name under its `configurations`. When absent, the one that the test names, else the model as it
    /// stands.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
}

impl OneModel {
    /// The configuration that is asked for.
    pub(crate) fn configuration(&self) -> Option<&str> {
        self.configuration.as_deref()
    }
}

/// One test or several.
#[derive(Debug, Args)]
pub(crate) struct Tests {
    /// Test files; the model is compared with each in the configuration that it names, all with the same parameters.
    #[arg(id = "tests", required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) paths: Vec<PathBuf>,
}

/// What may be lost.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct Overwrite {
    /// Overwrite files that exist.
    #[arg(long)]
    pub(crate) force: bool,
}

/// For people or for programs.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct Print {
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Where random numbers begin.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct Random {
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0, value_parser = values::whole::<u64>)]
    pub(crate) seed: u64,
}

/// What is minimised or sampled, and on which model.
#[derive(Debug, Args)]
pub(crate) struct Search {
    /// A file with terms and weights, loss, regularisation and limits of the least-squares cost.
    #[arg(long, value_name = "FILE")]
    pub(crate) objective: Option<PathBuf>,
    /// Work on a reduced model whose frequencies are right to this share within the bounds; models of 10 000 dofs or more do so unasked, where they can.
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, require_equals = true, default_missing_value = "0.01 %", value_parser = values::tolerance)]
    pub(crate) reduced: Option<f64>,
}

/// What a page shows beside the comparison.
#[derive(Debug, Args)]
pub(crate) struct Page {
    /// Write a page with pictures: one HTML file that needs no network.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
}
