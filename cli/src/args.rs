//! The command line, as clap reads it.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

mod correlation;

pub(crate) use correlation::{Compare, Placement, Pretest, Sensitivity};

/// Updates finite-element models of structures to vibration tests, and finds the physics that the models miss.
#[derive(Debug, Parser)]
#[command(name = "retune", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 done; 1 finished, but a criterion or a fit falls short; 2 wrong input; 70 a bug.

Examples:
  retune check models/bff.yaml
  retune identify run1.unv run2.unv -o test.yaml
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
    Identify(Identify),
    Health(Health),
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
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
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
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a frequency response function is: response over force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MeasuredQuantity {
    /// Displacement over force.
    Receptance,
    /// Velocity over force.
    Mobility,
    /// Acceleration over force.
    Accelerance,
}

/// Which of several functions of one pair of points counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Repeated {
    /// The first.
    First,
    /// The last.
    Last,
}

/// Answers to what measurement files may leave open; nothing is guessed.
#[derive(Debug, Args)]
pub(crate) struct Measurement {
    /// Units of the files: SI, mm-N-s, in-lbf-s, m-N-g, ..., or `labels` to believe the labels of the axes.
    #[arg(long, value_name = "SYSTEM")]
    pub(crate) units: Option<String>,
    /// What the functions are, where they do not say it.
    #[arg(long, value_enum)]
    pub(crate) quantity: Option<MeasuredQuantity>,
    /// Unit of the functions of a table without a row of units, such as `m/s2/N`.
    #[arg(long)]
    pub(crate) unit: Option<String>,
    /// Which of several functions of one pair of points counts.
    #[arg(long, value_enum)]
    pub(crate) duplicates: Option<Repeated>,
    /// Direction of channels that do not know theirs: `+x` ... `-z`.
    #[arg(long, allow_hyphen_values = true, value_name = "AXIS")]
    pub(crate) direction: Option<String>,
    /// Positions of the points, where the files themselves have none: a universal file, an OpenModal folder, or a table `point,x,y,z`.
    #[arg(long, value_name = "FILE")]
    pub(crate) geometry: Option<PathBuf>,
    /// Units of the geometry, where they are not those of the functions.
    #[arg(long, value_name = "SYSTEM")]
    pub(crate) geometry_units: Option<String>,
    /// Where the axes of the geometry lie in the model: `{origin: [1 m, 0 m, 0 m], x: -y, z: +z}`, two axes of the three.
    #[arg(long, value_name = "FRAME")]
    pub(crate) frame: Option<String>,
}

/// How modes are identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Poles by pLSCF over many model orders, then a maximum-likelihood fit.
    Plscf,
    /// Shapes from imaginary parts at the frequencies of pLSCF, corrected for neighbouring modes; first reference.
    Quadrature,
    /// Circle fits about the poles of pLSCF; first reference.
    Circle,
}

/// Identify modes from frequency response functions: frequencies, damping, shapes, each with its standard deviation.
///
/// Reads universal files, tables (column frequency_hz), OpenModal folders, NumPy arrays, MATLAB files; of a spectrum without
/// force it gives the peaks, and modes that the files themselves hold are taken over. Checks the test itself on the way; exit
/// code 1 when that finds a fault.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune identify run1.unv run2.unv -o test.yaml
  retune identify frfs.csv --geometry points.unv --band 3 35 --model models/bff.yaml -o test.yaml
  retune identify openmodal_export/ --units SI --geometry-units in-lbf-s
  retune identify shapes.csv --direction +z -o test.yaml")]
pub(crate) struct Identify {
    /// Measurement files.
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Where to write the test file.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    /// Limits of the band, Hz.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"])]
    pub(crate) band: Option<Vec<f64>>,
    /// How.
    #[arg(long, value_enum, default_value_t = Method::Plscf)]
    pub(crate) method: Method,
    /// Peaks of a spectrum without force: least height over the valleys beside them, dB.
    #[arg(long, default_value_t = 10.0, value_name = "DB")]
    pub(crate) peak_height: f64,
    /// Poles of the highest model order of each octave.
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u16).range(2..=400))]
    pub(crate) order: u16,
    /// How many of the lowest modes are rigid-body modes on the suspension: checked as such, not written.
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) suspension: u16,
    /// Model in which the sensors get their places, by `retune map`.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Configuration of the model that was tested, for the test file.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Name of the test; that of the first file when absent.
    #[arg(long)]
    pub(crate) name: Option<String>,
    /// Leave out the check of the test.
    #[arg(long)]
    pub(crate) no_health: bool,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub(crate) force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Can the test be trusted? Dead and noisy channels, signs, swaps, gains, axes, driving points, double modes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune health run1.unv --geometry points.unv
  retune health test.yaml
  retune health shapes.csv --direction +z
  retune health monday.unv --against friday.unv

Exit code 1 when the data contradict themselves.")]
pub(crate) struct Health {
    /// Measurement files, or one test file.
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    /// Another run with the same sensors: did frequencies shift?
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub(crate) against: Vec<PathBuf>,
    /// Limits of the band, Hz.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"])]
    pub(crate) band: Option<Vec<f64>>,
    /// How many of the lowest modes are rigid-body modes on the suspension.
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(crate) suspension: u16,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Find places in a model for the points of a test: nodes, else elements, with rigid arms; and what is left over.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune map models/bff.yaml geometry.unv --units in-lbf-s
  retune map models/bff.yaml test.yaml --tolerance '5 mm' -o placed.yaml

Exit code 1 when a point has no place.")]
pub(crate) struct Map {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file whose sensors have positions, or a file with geometry.
    pub(crate) test: PathBuf,
    /// A point this near to a node sits on it.
    #[arg(long, default_value = "5 mm", allow_hyphen_values = true)]
    pub(crate) tolerance: String,
    /// Longest rigid arm; a tenth of the diagonal of the model when absent.
    #[arg(long)]
    pub(crate) reach: Option<String>,
    /// Where to write the test with its sensors in place.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    /// Configuration of the model: a name under its `configurations`; that which the test names when absent.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub(crate) force: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Make synthetic test data from a model: modes and functions at sensors, with noise, sensor faults and hidden changes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune twin models/bff_truth.yaml -o twin.yaml --sensors models/bff_gvt.yaml --noise-frequency '0.3 %' --noise-shape '2 %'
  retune twin models/bff_truth.yaml --frf twin.unv --sensors models/bff_gvt.yaml --exciter p12 --band 3 35 --noise-response '1 %'
  retune twin models/bff.yaml -o twin.yaml --set m8_13=70g --patch hidden.yaml --fault sign:p11 --fault swap:p3,p4")]
pub(crate) struct Twin {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Where to write a test file with modes.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    /// Where to write functions: a universal file, or a table when the name ends with .csv.
    #[arg(long, value_name = "FILE")]
    pub(crate) frf: Option<PathBuf>,
    /// Test file with the sensors; a sensor on every node when absent.
    #[arg(long, value_name = "TEST")]
    pub(crate) sensors: Option<PathBuf>,
    /// Most modes.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=2000))]
    pub(crate) modes: u16,
    /// Band of modes and functions, Hz.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"])]
    pub(crate) band: Option<Vec<f64>>,
    /// Frequency lines of the functions.
    #[arg(long, default_value_t = 1025, value_parser = clap::value_parser!(u16).range(2..))]
    pub(crate) lines: u16,
    /// Sensors at which the force acts, one after the other; the first sensor when absent.
    #[arg(long, num_args = 1.., value_name = "SENSOR")]
    pub(crate) exciter: Vec<String>,
    /// What the functions are; accelerance when absent.
    #[arg(long, value_enum)]
    pub(crate) quantity: Option<MeasuredQuantity>,
    /// Standard deviation of frequencies.
    #[arg(long, default_value = "0 %")]
    pub(crate) noise_frequency: String,
    /// Standard deviation of damping ratios.
    #[arg(long, default_value = "0 %")]
    pub(crate) noise_damping: String,
    /// Standard deviation of shape entries, of the largest entry.
    #[arg(long, default_value = "0 %")]
    pub(crate) noise_shape: String,
    /// Noise of the force, of the force.
    #[arg(long, default_value = "0 %")]
    pub(crate) noise_force: String,
    /// Noise of each response, of its root mean square.
    #[arg(long, default_value = "0 %")]
    pub(crate) noise_response: String,
    /// Averages of the functions.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..=10000))]
    pub(crate) averages: u16,
    /// Damping ratio of every mode.
    #[arg(long, default_value = "1 %")]
    pub(crate) damping: String,
    /// A parameter of the model: `m8_13=70g`.
    #[arg(long, value_name = "PARAMETER=VALUE")]
    pub(crate) set: Vec<String>,
    /// A partial model file laid over the model: what the test has and the model lacks.
    #[arg(long, value_name = "FILE")]
    pub(crate) patch: Option<PathBuf>,
    /// A fault: sign:SENSOR, gain:SENSOR,FACTOR, swap:SENSOR,SENSOR, dead:SENSOR, axis:SENSOR,+x.
    #[arg(long, value_name = "FAULT")]
    pub(crate) fault: Vec<String>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Overwrite existing output files.
    #[arg(long)]
    pub(crate) force: bool,
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

/// What the test had and the model file has not.
#[derive(Debug, Args)]
pub(crate) struct Loading {
    /// Put the `mass` of the sensors into the model: they were on the structure when it was tested.
    #[arg(long)]
    pub(crate) sensor_masses: bool,
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
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test files; each is compared with the model in the configuration that it names, and all are fitted at once.
    #[arg(required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Where to write the updated model: the same file with new values, comments and order kept.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// What to minimise.
    #[arg(long, value_enum, default_value_t = Cost::LeastSquares)]
    pub(crate) cost: Cost,
    /// A file with terms and weights, loss, regularisation and limits of the least-squares cost.
    #[arg(long, value_name = "FILE")]
    pub(crate) objective: Option<PathBuf>,
    /// How modes are paired; by MAC, without shapes and for frequencies alone by order.
    #[arg(long, value_enum)]
    pub(crate) pairing: Option<Pairing>,
    /// A method of `retune list optimizers`, or YAML with settings.
    #[arg(long)]
    pub(crate) optimizer: Option<String>,
    #[command(flatten)]
    pub(crate) loading: Loading,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Largest number of evaluations.
    #[arg(long)]
    pub(crate) budget: Option<u64>,
    /// Keep the state of the search in this file.
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Write a page with pictures: before and after, cost, parameters in their bounds.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    /// Continue from the checkpoint of an interrupted run.
    #[arg(long, requires = "checkpoint")]
    pub(crate) resume: bool,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub(crate) force: bool,
    /// Configuration of the model: a name under its `configurations`; that which the test names when absent.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Sample the posterior of the parameters: means, quantiles, correlations, and the evidence of the model.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  retune sample models/bff.yaml models/bff_gvt.yaml models/bff_bench.yaml --samples 2000 -o samples.csv

The prior is uniform between the bounds; prior_sd of a parameter acts on top of it. Evidences of two models compare on the
same tests: the difference of ln Z is the logarithm of the odds.")]
pub(crate) struct Sample {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test files; each is compared with the model in the configuration that it names.
    #[arg(required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Where to write the samples: a CSV table, one column a parameter, in the units of the tables.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Number of samples.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(50..=1_000_000))]
    pub(crate) samples: u32,
    /// A file with terms and weights, loss, regularisation and limits of the least-squares cost.
    #[arg(long, value_name = "FILE")]
    pub(crate) objective: Option<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub(crate) force: bool,
    /// Configuration of the model: a name under its `configurations`; that which the test names when absent.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// One page where an engineer sees the comparison, the diagnosis and the error falling: a single file, no network.
///
/// Without an output it prints the same on the terminal.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune report updated.yaml models/bff_gvt.yaml -o report.html
  retune report v3.yaml gvt.yaml --history v1.yaml v2.yaml -o report.html --svg figures
  retune report wing.yaml gvt.yaml --diagnose --frf run1.unv run2.unv -o report.html
  retune learn wing.yaml gvt.yaml --json > learned.json; retune report wing.yaml gvt.yaml --learn learned.json -o report.html")]
pub(crate) struct Report {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file.
    pub(crate) test: PathBuf,
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
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    /// The report's data as JSON.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// A folder for single figures as SVG.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) svg: Option<PathBuf>,
    /// A folder for model and modes as VTK, for ParaView.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) vtk: Option<PathBuf>,
    /// Seed of all random numbers of the diagnosis.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Configuration of the model: a name under its `configurations`; that which the test names when absent.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Overwrite existing files.
    #[arg(long)]
    pub(crate) force: bool,
}

/// What is missing? Physical effects and measurement faults with probabilities, estimates and ties.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune diagnose models/bff.yaml models/bff_gvt.yaml
  retune diagnose models/bff.yaml models/bff_gvt.yaml --report diagnosis.html
  retune diagnose models/bff.yaml models/bff_gvt.yaml models/bff_bench.yaml")]
pub(crate) struct Diagnose {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test files; each is compared with the model in the configuration that it names, all with the same parameters.
    #[arg(required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Trust the measurement: try effects only.
    #[arg(long)]
    pub(crate) no_faults: bool,
    /// Write a page with pictures: the hypotheses on the structure, beside the comparison.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    /// Overwrite an existing page.
    #[arg(long)]
    pub(crate) force: bool,
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
    /// Effect and place: mass-offset@left_wing.y; in one configuration only: root-flexibility@bench/left_wing.1:n5.ry
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
#[command(
    after_help = "Example:\n  retune learn models/bff.yaml models/bff_gvt.yaml -o learned.yaml --report learned.html"
)]
pub(crate) struct Learn {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test files; each is compared with the model in the configuration that it names, all with the same parameters.
    #[arg(required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Where to write the model of every step: learned.yaml becomes learned.0.yaml, learned.1.yaml ...
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Take the most probable of tied effects instead of stopping.
    #[arg(long)]
    pub(crate) take_best: bool,
    /// Largest number of effects.
    #[arg(long, default_value_t = 5)]
    pub(crate) limit: u8,
    /// Write a page with pictures: the error falling step by step, every diagnosis, the last model.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
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

/// How good is a diagnosis? Synthetic twins with a known answer, and the score.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune benchmark diagnosis --structure cantilever")]
pub(crate) struct Benchmark {
    /// What to measure.
    pub(crate) what: BenchmarkWhat,
    /// Only these structures.
    #[arg(long, value_name = "NAME")]
    pub(crate) structure: Vec<String>,
    /// Twins with nothing missing, on each structure.
    #[arg(long, default_value_t = 20)]
    pub(crate) null: usize,
    /// Places and sizes of every effect, on each structure.
    #[arg(long, default_value_t = 2)]
    pub(crate) effects: usize,
    /// Sensors with every fault, on each structure.
    #[arg(long, default_value_t = 2)]
    pub(crate) faults: usize,
    /// Twins with every change outside the catalogue, on each structure.
    #[arg(long, default_value_t = 3)]
    pub(crate) outside: usize,
    /// The noise that is there, over the one that the test states.
    #[arg(long, default_value_t = 1.0)]
    pub(crate) noise_factor: f64,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print every case.
    #[arg(long)]
    pub(crate) cases: bool,
    /// Only cases with this in the name of what is hidden, with all their hypotheses.
    #[arg(long, value_name = "TEXT")]
    pub(crate) case: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is measured.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum BenchmarkWhat {
    /// `retune diagnose` on twins with a hidden effect, a fault, or nothing.
    Diagnosis,
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
    /// Criteria profiles of `retune compare --profile`.
    Profiles,
}

/// What there is: elements, residuals, optimizers, effects, profiles.
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
