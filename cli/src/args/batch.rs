//! One verb for many tests, and what shards have written together.

use super::Answer;
use clap::{Args, ValueEnum};
use retune_diagnosis::benchmark::Part;
use std::path::PathBuf;

/// What is done with every test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BatchVerb {
    /// `retune compare`.
    Compare,
    /// `retune update`.
    Update,
    /// `retune sample`.
    Sample,
    /// `retune diagnose`.
    Diagnose,
}

impl BatchVerb {
    /// The word of the command.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Compare => "compare",
            Self::Update => "update",
            Self::Sample => "sample",
            Self::Diagnose => "diagnose",
        }
    }
}

/// One job for every test: a verb, a model and the test alone. For hundreds of tests, on as many machines as there are.
///
/// The result of a job is a file in the folder, a line of JSON, named by the SHA-256 of the version, the verb, its options and the bytes of
/// all files. It is written whole or not at all: a job that was killed is done again, a finished one is not. A job without a result, for a file
/// that is wrong, has its error as a result. Without --shard the rest is done, and all results are printed.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune batch diagnose wing.yaml tests/*.yaml --folder results -- --effects point-mass --seed 3
  retune batch diagnose wing.yaml tests/*.yaml --folder results --shard 3/8     # on one machine of eight; see `retune merge`")]
pub(crate) struct Batch {
    /// What is done with every test.
    pub(crate) verb: BatchVerb,
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test files, each a job of its own.
    #[arg(required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Where the results are, one file a job; a folder that all machines see.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) folder: PathBuf,
    /// Do only this part of the jobs, counted from 1 as 3/8, and print nothing.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["output", "force"])]
    pub(crate) shard: Option<Part>,
    /// Write all results, a line of JSON each, instead of printing them.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing output file.
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
    /// Options of the verb, behind `--`.
    #[arg(last = true, allow_hyphen_values = true, value_name = "OPTION")]
    pub(crate) options: Vec<String>,
}

/// Merge what shards have written: of a benchmark into what one run of all its cases gives, of a batch into what one run of it prints.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune merge shard-*.json
  retune merge shard-*.json --cases -o benchmark.json
  retune merge results/*.json -o all.jsonl")]
pub(crate) struct Merge {
    /// What `retune benchmark --shard` has written, all of it, or what `retune batch` has; in any order.
    #[arg(required = true, num_args = 1.., value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Print every case of a benchmark.
    #[arg(long)]
    pub(crate) cases: bool,
    #[command(flatten)]
    pub(crate) answer: Answer,
}
