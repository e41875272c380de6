//! What is missing: diagnosing, adding, learning, and how good that is.

use super::{Answer, Overwrite, PairingOptions, Print, Random, Tests, values};
use clap::{Args, ValueEnum};
use retune_diagnosis::benchmark::Part;
use std::path::PathBuf;
use std::time::Duration;

/// What is tried, and for how long. Ctrl-C ends a search with the best answer so far.
#[derive(Debug, Args)]
pub(crate) struct SearchOptions {
    /// Only these effects: point-mass,joint-flexibility.
    #[arg(long, value_name = "EFFECT", value_delimiter = ',')]
    pub(crate) effects: Vec<String>,
    /// Effects only where they have a node or an element of these: nodes, elements, members, chains, groups.
    #[arg(long, value_name = "PLACE", value_delimiter = ',')]
    pub(crate) places: Vec<String>,
    /// Answer after this time with the best so far: 60s, 5min.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = values::time)]
    pub(crate) budget: Option<Duration>,
    /// How much is tried, as a factor: 0.5 fits half as many hypotheses from half as many starts.
    #[arg(long, default_value_t = 1.0, value_parser = values::positive, value_name = "FACTOR")]
    pub(crate) effort: f64,
    /// Print every step of the search to standard error: what it fitted, and what leads after it.
    #[arg(long)]
    pub(crate) trace: bool,
}

/// Find what is missing: physical effects and measurement faults, with probabilities, estimates and ties.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune diagnose models/bff.yaml models/bff_gvt.yaml
  retune diagnose models/bff.yaml models/bff_gvt.yaml --report diagnosis.html
  retune diagnose models/bff.yaml models/bff_gvt.yaml --effects point-mass,mass-offset --places left_wing --budget 60s --trace
  retune diagnose models/bff.yaml models/bff_gvt.yaml models/bff_bench.yaml")]
pub(crate) struct Diagnose {
    /// Model file.
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) tests: Tests,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    #[command(flatten)]
    pub(crate) random: Random,
    /// Trust the measurement: try effects only.
    #[arg(long)]
    pub(crate) no_faults: bool,
    #[command(flatten)]
    pub(crate) search: SearchOptions,
    /// Write the diagnosis as JSON.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write a page with pictures: the hypotheses on the structure, beside the comparison.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Put an effect into a model file: the smallest edit, at its neutral value, recorded under `history`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune add models/bff.yaml point-mass@n8 --dry-run")]
pub(crate) struct Add {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Effect and place: mass-offset@left_wing.y; in one configuration only: root-flexibility@bench/left_wing.1:n5.ry
    pub(crate) effect: String,
    /// Test whose sensors the effect needs: sensor-mass.
    #[arg(long, value_name = "TEST")]
    pub(crate) test: Option<PathBuf>,
    /// Why; kept in the file.
    #[arg(long, default_value = "")]
    pub(crate) because: String,
    /// Where to write; the model file itself when absent.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Print the edits and change nothing.
    #[arg(long, conflicts_with_all = ["output", "force"])]
    pub(crate) dry_run: bool,
}

/// Take the last addition out of a model file.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune undo wing.yaml")]
pub(crate) struct Undo {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Where to write; the model file itself when absent.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
}

/// Diagnose, add and refit, until nothing more is justified.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  retune learn models/bff.yaml models/bff_gvt.yaml -o learned.yaml --report learned.html"
)]
pub(crate) struct Learn {
    /// Model file.
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) tests: Tests,
    /// Where to write the model of every step: learned.yaml becomes learned.0.yaml, learned.1.yaml ...
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Take the most probable of tied effects instead of stopping.
    #[arg(long)]
    pub(crate) take_best: bool,
    #[command(flatten)]
    pub(crate) search: SearchOptions,
    /// Largest number of effects.
    #[arg(long, default_value_t = 5)]
    pub(crate) limit: u8,
    /// Write a page with pictures: the error falling step by step, every diagnosis, the last model.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    #[command(flatten)]
    pub(crate) random: Random,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Measure how good diagnoses are, on synthetic twins with known answers.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune benchmark diagnosis --structure cantilever
  retune benchmark diagnosis --seed 26 --shard 3/8 -o shard-3.json     # on one machine of eight; see `retune merge`")]
pub(crate) struct Benchmark {
    /// What to measure.
    pub(crate) what: BenchmarkWhat,
    /// Only these structures.
    #[arg(long, value_name = "NAME")]
    pub(crate) structure: Vec<String>,
    /// Twins with nothing missing, on each structure.
    #[arg(long, default_value_t = 5, value_parser = values::whole::<usize>)]
    pub(crate) null: usize,
    /// Places and sizes of every effect, on each structure.
    #[arg(long, default_value_t = 1, value_parser = values::whole::<usize>)]
    pub(crate) effects: usize,
    /// Sensors with every fault, on each structure.
    #[arg(long, default_value_t = 1, value_parser = values::whole::<usize>)]
    pub(crate) faults: usize,
    /// Twins with every change outside the catalogue, on each structure.
    #[arg(long, default_value_t = 1, value_parser = values::whole::<usize>)]
    pub(crate) outside: usize,
    /// Modes of no structure that are added to every test.
    #[arg(long, default_value_t = 0, value_parser = values::whole::<usize>)]
    pub(crate) foreign: usize,
    /// Sensors of a test, as far as a structure has places for them.
    #[arg(long, default_value_t = 28, value_parser = values::whole::<usize>)]
    pub(crate) sensors: usize,
    /// Modes of a test, at most.
    #[arg(long, default_value_t = 8, value_parser = values::whole::<usize>)]
    pub(crate) modes: usize,
    /// The noise that is there, over the one that the test states.
    #[arg(long, default_value_t = 1.0, value_parser = values::positive)]
    pub(crate) noise_factor: f64,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1, value_parser = values::whole::<u64>)]
    pub(crate) seed: u64,
    /// Print every case.
    #[arg(long)]
    pub(crate) cases: bool,
    /// Only cases with this in the name of what is hidden, with all their hypotheses.
    #[arg(long, value_name = "TEXT")]
    pub(crate) case: Option<String>,
    /// Run only this part of the cases, counted from 1 as 3/8, and write it for `retune merge`: to FILE, or to standard output. A FILE that
    /// has it already is kept.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["cases", "json"])]
    pub(crate) shard: Option<Part>,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// What is measured.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum BenchmarkWhat {
    /// `retune diagnose` on twins with a hidden effect, a fault, or nothing.
    Diagnosis,
}
