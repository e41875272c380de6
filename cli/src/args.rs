//! The command line, as clap reads it.

use clap::{Arg, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use retune::catalogue::Choice;
use retune::update::{Cost, HowToPair};
use retune_diagnosis::benchmark::Part;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;

mod answer;
mod batch;
mod correlation;
mod deck;
mod diagnosis;
mod export;
mod groups;
mod init;
mod matrices;
mod measured;
mod values;

pub(crate) use answer::Answer;
pub(crate) use batch::{Batch, Merge};
pub(crate) use correlation::{Compare, Pretest, Sensitivity};
pub(crate) use deck::{Import, ParametersOf};
pub(crate) use diagnosis::{Add, Benchmark, BenchmarkWhat, Diagnose, Learn, SearchOptions, Undo};
pub(crate) use export::{Export, Reduction};
pub(crate) use groups::{OneModel, Overwrite, Print, Random, Search, Tests};
pub(crate) use init::{Completions, Explain, Init, InitOf, List, ListOf, Manual, Schema, SchemaOf};
pub(crate) use matrices::{Matrices, Prepare};
pub(crate) use measured::{Health, Identify, Map, Measurement, Twin};
pub(crate) use values::{Rule, Share};

/// Updates finite-element models of structures to vibration tests, and finds the physics that the models miss.
#[derive(Debug, Parser)]
#[command(name = "retune", version, propagate_version = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 done; 1 finished, but a criterion is missed, or a diagnosis is anything but `adequate`; 2 wrong input, or an output that cannot be written;
70 a bug; 130 stopped before there was a result.

Examples:
  retune init beam -o beam
  retune check models/bff.yaml
  retune identify run1.unv run2.unv -o test.yaml
  retune compare models/bff.yaml models/bff_gvt.yaml
  retune update models/bff.yaml models/bff_gvt.yaml -o updated.yaml"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The command line that was given, without the name of the program: a page states it.
static GIVEN: OnceLock<Vec<OsString>> = OnceLock::new();

/// The words of the command line, without the name of the program.
pub(crate) fn given() -> &'static [OsString] {
    GIVEN.get().map_or(&[], Vec::as_slice)
}

/// Reads the command line. A negative number is a value and no option, so that its range is what is told.
pub(crate) fn parse(words: Vec<OsString>) -> Result<Cli, clap::Error> {
    let numbers = |arg: Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    let mut command = Cli::command().mut_subcommands(|verb| verb.mut_args(numbers));
    GIVEN.get_or_init(|| words.iter().skip(1).cloned().collect());
    let matches = command.try_get_matches_from_mut(words)?;
    Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Init(Init),
    Check(Check),
    Modes(Modes),
    Identify(Identify),
    Health(Health),
    Import(Import),
    Export(Export),
    Map(Map),
    Twin(Twin),
    Compare(Compare),
    Pretest(Pretest),
    Sensitivity(Sensitivity),
    Update(Update),
    Sample(Sample),
    Report(Report),
    Diagnose(Diagnose),
    Add(Add),
    Undo(Undo),
    Learn(Learn),
    Benchmark(Benchmark),
    Batch(Batch),
    Merge(Merge),
    Matrices(Matrices),
    Prepare(Prepare),
    Schema(Schema),
    List(List),
    Explain(Explain),
    Completions(Completions),
    Manual(Manual),
}

/// Check a model: mass, centre of gravity, inertia, rigid-body modes, and warnings about anything doubtful.
///
/// Test files, objective files and criteria profiles are checked too, as far as that is possible without a model.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  retune check models/bff.yaml\n  retune check wing.yaml --against wing.f06 wing.op2"
)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) model: OneModel,
    /// Compare the model with what a solver computed for the deck that it was imported from: `.f06`, `.op2`, `.pch` of Nastran, `.dat` of
    /// Abaqus and CalculiX, `.frd` of CalculiX.
    #[arg(long, value_name = "RESULTS", num_args = 1..)]
    pub(crate) against: Vec<PathBuf>,
    /// Largest relative difference of frequencies that `--against` lets pass.
    #[arg(long, value_name = "SHARE", default_value = "0.001 %", requires = "against", value_parser = values::positive_share)]
    pub(crate) tolerance: f64,
    /// Elastic modes that `--against` compares.
    #[arg(short = 'n', long, value_name = "MODES", default_value_t = 20, requires = "against", value_parser = values::count(1, 500))]
    pub(crate) number: u16,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// Compute the natural frequencies of a model, and name its modes.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune modes models/bff.yaml -n 6")]
pub(crate) struct Modes {
    #[command(flatten)]
    pub(crate) model: OneModel,
    /// Number of elastic modes.
    #[arg(short = 'n', long, default_value_t = 10, value_parser = values::count(1, 2000))]
    pub(crate) number: u16,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// How modes are paired, and within which limits.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct PairingOptions {
    /// How modes are paired. `pair_with`, `use` and `foreign` of a mode in the test file take precedence.
    #[arg(long, value_name = "RULE", default_value = "probable", value_parser = values::rule())]
    pub(crate) pairing: Rule,
    /// Smallest MAC of a pair.
    #[arg(long, value_name = "MAC", value_parser = values::mac)]
    pub(crate) min_mac: Option<f64>,
    /// Largest frequency ratio of a pair, as 1 + window.
    #[arg(long, value_name = "WINDOW", value_parser = values::not_negative)]
    pub(crate) frequency_window: Option<f64>,
}

impl PairingOptions {
    /// For the library.
    pub(crate) fn how(self) -> HowToPair {
        HowToPair { by: self.pairing.0, min_mac: self.min_mac, frequency_window: self.frequency_window }
    }
}

/// What the test had and the model file has not.
#[derive(Debug, Args)]
pub(crate) struct Loading {
    /// Add the `mass` of the sensors to the model: they were on the structure when it was tested.
    #[arg(long)]
    pub(crate) sensor_masses: bool,
}

/// Update a model to one test or several: change its bounded parameters until it fits, and say how certain they are.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune update models/bff.yaml models/bff_gvt.yaml -o updated.yaml
  retune update models/bff.yaml models/bff_gvt.yaml --cost paper --seed 3 -o updated.yaml
  retune update models/bff.yaml models/bff_gvt.yaml models/bff_bench.yaml
  retune update models/bff.yaml models/bff_gvt.yaml --objective objective.yaml
  retune update models/bff.yaml models/bff_gvt.yaml --optimizer '[differential-evolution, nelder-mead]'

Ctrl-C stops cleanly and keeps the best point so far.")]
pub(crate) struct Update {
    #[command(flatten)]
    pub(crate) model: OneModel,
    #[command(flatten)]
    pub(crate) tests: Tests,
    /// Where to write the updated model: the same file with new values; comments and order are kept.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// What to minimise.
    #[arg(long, value_name = "COST", default_value = Cost::LeastSquares.word(), value_parser = values::choice::<Cost>())]
    pub(crate) cost: Cost,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    /// A method of `retune list optimizers`, in full or as `lm`, `de`, `nm`; or YAML with settings.
    #[arg(long)]
    pub(crate) optimizer: Option<String>,
    #[command(flatten)]
    pub(crate) loading: Loading,
    #[command(flatten)]
    pub(crate) random: Random,
    /// Largest number of evaluations.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) budget: Option<u64>,
    #[command(flatten)]
    pub(crate) search: Search,
    /// Keep the state of the search in this file.
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Write a page with pictures: before and after, cost, parameters in their bounds.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    /// Continue from the checkpoint of an interrupted run.
    #[arg(long, requires = "checkpoint")]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Sample the posterior of the parameters: means, quantiles, correlations, and the evidence of the model.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  retune sample models/bff.yaml models/bff_gvt.yaml models/bff_bench.yaml --samples 2000 -o samples.csv

The prior is uniform between the bounds; prior_sd of a parameter acts on top of it. Evidences of two models compare on the
same tests: the difference of ln Z is the logarithm of the odds.")]
pub(crate) struct Sample {
    #[command(flatten)]
    pub(crate) model: OneModel,
    #[command(flatten)]
    pub(crate) tests: Tests,
    /// Where to write the samples: a CSV table with one column per parameter, in the units of the tables.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Number of samples.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(50..=1_000_000))]
    pub(crate) samples: u32,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    /// Write a page with the posterior of each parameter and of each two of them.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) search: Search,
    #[command(flatten)]
    pub(crate) random: Random,
    /// Evaluate only this part of every generation, counted from 1 as 3/8, and take the rest from the folder, into which processes with the other
    /// parts write it. Each of them has the samples that one run has. For models that take long to solve.
    #[arg(long, value_name = "I/N", requires = "folder")]
    pub(crate) shard: Option<Part>,
    /// The folder of the shards, one that all machines see. What is in it is not evaluated again.
    #[arg(long, value_name = "FOLDER", requires = "shard")]
    pub(crate) folder: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Whether a page computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum WhenLive {
    /// Where that takes less than a second and a megabyte: up to 400 dofs.
    Auto,
    /// With a model of up to 30 000 dofs, on a few coordinates; where it cannot, a warning says why.
    Always,
    /// It only shows.
    Never,
}

/// Write one page for an engineer: the comparison, the diagnosis, and how the error fell; a single file that needs no network.
///
/// Without an output the same is printed on the terminal.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune report updated.yaml models/bff_gvt.yaml -o report.html
  retune report updated.yaml gvt.yaml bench.yaml --diagnose -o report.html
  retune report v3.yaml gvt.yaml --history v1.yaml v2.yaml -o report.html --svg figures
  retune report wing.yaml gvt.yaml --diagnose --live -o report.html
  retune report wing.yaml gvt.yaml --diagnose --frf run1.unv run2.unv -o report.html
  retune learn wing.yaml gvt.yaml --json > learned.json; retune report wing.yaml gvt.yaml --learn learned.json -o report.html")]
pub(crate) struct Report {
    #[command(flatten)]
    pub(crate) model: OneModel,
    #[command(flatten)]
    pub(crate) tests: Tests,
    /// The page: one HTML file that needs no network.
    #[arg(short, long, value_name = "PAGE")]
    pub(crate) output: Option<PathBuf>,
    /// Earlier versions of the model, oldest first: the page shows the error falling.
    #[arg(long, num_args = 1.., value_name = "MODEL", conflicts_with = "learn")]
    pub(crate) history: Vec<PathBuf>,
    /// Diagnose the model too: what is missing, where, how sure.
    #[arg(long, conflicts_with = "learn")]
    pub(crate) diagnose: bool,
    /// A history of learning: the output of `retune learn --json`, or a folder of model versions in the order of their names.
    #[arg(long, value_name = "FILE|FOLDER")]
    pub(crate) learn: Option<PathBuf>,
    /// Measurement files with frequency response functions, to show beside those of the model.
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub(crate) frf: Vec<PathBuf>,
    /// Whether the page computes: a slider for each parameter and a switch for each hypothesis then move frequencies, shapes and misfit.
    #[arg(long, value_enum, value_name = "WHEN", num_args = 0..=1, require_equals = true, default_value = "auto", default_missing_value = "always")]
    pub(crate) live: WhenLive,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    /// Write the numbers of the page as JSON.
    #[arg(long, value_name = "FILE")]
    pub(crate) data: Option<PathBuf>,
    /// Print the numbers of the page as JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
    /// A folder for single figures as SVG.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) svg: Option<PathBuf>,
    /// A folder for model and modes as VTK, for ParaView.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) vtk: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) random: Random,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
}
