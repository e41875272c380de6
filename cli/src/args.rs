//! The command line, as clap reads it.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Updates finite-element models of structures to vibration tests, and finds the physics that the models miss.
#[derive(Debug, Parser)]
#[command(name = "retune", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 done; 1 finished, but a criterion or a fit falls short; 2 wrong input; 70 a bug.

Examples:
  retune check models/bff.yaml
  retune compare models/bff.yaml models/bff_gvt.yaml
  retune update models/bff.yaml models/bff_gvt.yaml -o updated.yaml")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Check(Check),
    Modes(Modes),
    Compare(Compare),
    Update(Update),
    Diagnose(Diagnose),
    Add(Add),
    Undo(Undo),
    Learn(Learn),
    Schema(Schema),
    List(List),
    Explain(Explain),
    Completions(Completions),
}

/// Is the model sound? Mass, centre of gravity, inertia, rigid-body modes, and everything doubtful.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune check models/bff.yaml")]
pub(crate) struct Check {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Frequencies and names of the modes of a model.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune modes models/bff.yaml -n 6")]
pub(crate) struct Modes {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Number of elastic modes.
    #[arg(short = 'n', long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=2000))]
    pub(crate) number: u16,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// How modes of model and test are paired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Pairing {
    /// Optimal assignment on MAC.
    Mac,
    /// By order of frequency, within symmetry classes where labels tell them.
    Order,
}

/// Compare a model with a test: pairs, frequency errors, MAC, and whether noise can explain the difference.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune compare models/bff.yaml models/bff_gvt.yaml")]
pub(crate) struct Compare {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file.
    pub(crate) test: PathBuf,
    /// How modes are paired.
    #[arg(long, value_enum, default_value_t = Pairing::Mac)]
    pub(crate) pairing: Pairing,
    /// Smallest MAC of a pair.
    #[arg(long, default_value_t = 0.3)]
    pub(crate) min_mac: f64,
    /// Largest frequency ratio of a pair, as 1 + window.
    #[arg(long, default_value_t = 0.5)]
    pub(crate) frequency_window: f64,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The cost to minimise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Cost {
    /// Residuals over their standard deviations.
    LeastSquares,
    /// Equation (4) of Gupta et al.: MAC and relative frequencies.
    Paper,
    /// Norm of the relative frequency errors.
    Frequencies,
}

/// Update a model to a test: change its bounded parameters until it fits.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune update models/bff.yaml models/bff_gvt.yaml -o updated.yaml
  retune update models/bff.yaml models/bff_gvt.yaml --cost paper --seed 3 -o updated.yaml
  retune update models/bff.yaml models/bff_gvt.yaml --optimizer '[differential-evolution, nelder-mead]'

Ctrl-C stops cleanly and keeps the best point so far.")]
pub(crate) struct Update {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file.
    pub(crate) test: PathBuf,
    /// Where to write the updated model: the same file with new values, comments and order kept.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// What to minimise.
    #[arg(long, value_enum, default_value_t = Cost::LeastSquares)]
    pub(crate) cost: Cost,
    /// How modes are paired; by MAC, for frequencies alone by order.
    #[arg(long, value_enum)]
    pub(crate) pairing: Option<Pairing>,
    /// A method of `retune list optimizers`, or YAML with settings.
    #[arg(long)]
    pub(crate) optimizer: Option<String>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Largest number of evaluations.
    #[arg(long)]
    pub(crate) budget: Option<u64>,
    /// Keep the state of the search in this file.
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Continue from the checkpoint of an interrupted run.
    #[arg(long, requires = "checkpoint")]
    pub(crate) resume: bool,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub(crate) force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is missing? Physical effects and measurement faults with probabilities, estimates and ties.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune diagnose models/bff.yaml models/bff_gvt.yaml")]
pub(crate) struct Diagnose {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file.
    pub(crate) test: PathBuf,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Trust the measurement: try effects only.
    #[arg(long)]
    pub(crate) no_faults: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Put an effect into a model file: the smallest edit, at its neutral value, recorded in `history`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune add models/bff.yaml point-mass@n8 --dry-run")]
pub(crate) struct Add {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Effect and place: mass-offset@left_wing.y
    pub(crate) effect: String,
    /// Why; kept in the file.
    #[arg(long, default_value = "")]
    pub(crate) because: String,
    /// Where to write; the model file itself when absent.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Print the edits and change nothing.
    #[arg(long)]
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
}

/// Diagnose, add, refit, until nothing more is justified.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune learn models/bff.yaml models/bff_gvt.yaml -o learned.yaml")]
pub(crate) struct Learn {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file.
    pub(crate) test: PathBuf,
    /// Where to write the model of every step: learned.yaml becomes learned.0.yaml, learned.1.yaml ...
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Take the most probable of tied effects instead of stopping.
    #[arg(long)]
    pub(crate) take_best: bool,
    /// Largest number of effects.
    #[arg(long, default_value_t = 5)]
    pub(crate) limit: u8,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Overwrite existing files.
    #[arg(long)]
    pub(crate) force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Which kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SchemaOf {
    /// Model files.
    Model,
    /// Test files.
    Test,
}

/// JSON Schema of a file format, for editors that complete and check YAML.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune schema model > model.schema.json")]
pub(crate) struct Schema {
    /// Which file format.
    #[arg(value_enum, default_value_t = SchemaOf::Model)]
    pub(crate) of: SchemaOf,
}

/// Which list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ListOf {
    /// Element types.
    Elements,
    /// Terms of the least-squares cost.
    Residuals,
    /// Optimisers.
    Optimizers,
    /// Physical effects that a diagnosis tries.
    Effects,
}

/// What there is: elements, residuals, optimizers, effects.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune list elements")]
pub(crate) struct List {
    /// Which list.
    #[arg(value_enum)]
    pub(crate) of: ListOf,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a member of a list is: equations, properties, sources.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune explain beam")]
pub(crate) struct Explain {
    /// A name from `retune list`.
    pub(crate) name: String,
}

/// Completions for a shell, to standard output.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune completions bash > ~/.local/share/bash-completion/completions/retune")]
pub(crate) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}
