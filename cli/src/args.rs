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
    Report(Report),
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

/// One page where an engineer sees the comparison: structure, animated modes, pairs, MAC, mass properties.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune report updated.yaml models/bff_gvt.yaml -o report.html
  retune report v3.yaml gvt.yaml --history v1.yaml v2.yaml -o report.html --svg figures")]
pub(crate) struct Report {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file.
    pub(crate) test: PathBuf,
    /// The page: one HTML file that needs no network.
    #[arg(short, long, required_unless_present_any = ["json", "svg", "vtk"])]
    pub(crate) output: Option<PathBuf>,
    /// Earlier versions of the model, oldest first: the page shows the error falling.
    #[arg(long, num_args = 1..)]
    pub(crate) history: Vec<PathBuf>,
    /// The report's data as JSON.
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
    /// A folder for single figures as SVG.
    #[arg(long)]
    pub(crate) svg: Option<PathBuf>,
    /// A folder for model and modes as VTK, for ParaView.
    #[arg(long)]
    pub(crate) vtk: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    pub(crate) force: bool,
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
}

/// What there is: elements, residuals, optimizers.
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
