//! Comparing, planning a test, sensitivities.

use super::{Answer, Loading, Measurement, PairingOptions, values};
use clap::{Args, ValueEnum};
use retune::update::MassReduction;
use std::path::PathBuf;

/// How the mass is reduced to the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Reduction {
    /// The best there is for these sensors.
    Auto,
    /// None: the sensors see every dof.
    Full,
    /// Static.
    Guyan,
    /// Improved reduced system.
    Irs,
    /// Dynamic, at the mean of the paired modes.
    Dynamic,
    /// Exact in the paired modes.
    Serep,
}

impl From<Reduction> for MassReduction {
    fn from(reduction: Reduction) -> Self {
        match reduction {
            Reduction::Auto => Self::Auto,
            Reduction::Full => Self::Full,
            Reduction::Guyan => Self::Guyan,
            Reduction::Irs => Self::Irs,
            Reduction::Dynamic => Self::Dynamic,
            Reduction::Serep => Self::Serep,
        }
    }
}

/// Compare a model with a test: pairs, frequency errors, MAC, whether noise can explain the difference, and where it sits.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune compare models/bff.yaml models/bff_gvt.yaml
  retune compare models/bff_updated.yaml models/bff_gvt.yaml --profile common-practice
  retune compare models/bff.yaml models/bff_gvt.yaml --localize --sensors
  retune compare models/bff_truth.yaml models/bff_gvt.yaml --frf run1.unv --all

Exit code 1 when a profile is given and fails. `retune list profiles` shows the profiles; a file may hold others.")]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own on the command line")]
pub(crate) struct Compare {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test files; each is compared with the model in the configuration that it names.
    #[arg(required = true, num_args = 1.., value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Every sensor: COMAC, scaled and enhanced COMAC, misfit, and which sensors spoil the MAC.
    #[arg(long)]
    pub(crate) sensors: bool,
    /// Auto- and cross-orthogonality in the model's mass, reduced to the sensors.
    #[arg(long)]
    pub(crate) orthogonality: bool,
    /// How the mass is reduced.
    #[arg(long, value_enum, default_value_t = Reduction::Auto)]
    pub(crate) reduction: Reduction,
    /// Elements and groups, ranked by how much of the disagreement sits there.
    #[arg(long)]
    pub(crate) localize: bool,
    /// What the test tells of every parameter, and the combinations through which they act.
    #[arg(long)]
    pub(crate) sensitivity: bool,
    /// Everything that there is.
    #[arg(long)]
    pub(crate) all: bool,
    /// Measured frequency response functions: FRAC, CSAC, CSF, amplitude and phase by band, frequency shift by FDAC.
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub(crate) frf: Vec<PathBuf>,
    /// Edges of the bands of the functions, Hz; when absent the bands of the test file, else halfway between the test modes.
    #[arg(long, num_args = 2.., value_name = "HZ", value_parser = values::not_negative)]
    pub(crate) bands: Vec<f64>,
    /// Judge by a criteria profile: a built-in name, or a YAML file with profiles (`file.yaml`, `file.yaml:NAME`).
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) profile: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    /// Configuration of the model: a name under its `configurations`; that which the test names when absent.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    #[command(flatten)]
    pub(crate) loading: Loading,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// How sensors are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Placement {
    /// Effective independence: modal coordinates come out with the least noise.
    EffectiveIndependence,
    /// So that the modes can be told apart by MAC.
    AutoMac,
    /// Where the modes have most kinetic energy.
    KineticEnergy,
}

/// Before a test: which modes, where to measure, where to excite, what one more sensor would tell.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune pretest models/bff.yaml -n 6 --sensors 12
  retune pretest models/bff.yaml --test models/bff_gvt.yaml
  retune pretest models/frame.yaml --sensors 6 --by auto-mac -o plan.yaml")]
pub(crate) struct Pretest {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Number of target modes; six when absent, or as many as there are places for sensors.
    #[arg(short = 'n', long, value_parser = clap::value_parser!(u16).range(1..=200))]
    pub(crate) modes: Option<u16>,
    /// Number of sensors to choose; when absent twice the modes, or as many as there are places.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) sensors: Option<u16>,
    /// How they are chosen; all ways side by side when absent.
    #[arg(long, value_enum)]
    pub(crate) by: Option<Placement>,
    /// Test file whose sensors are judged and added to; candidates are all translations of nodes.
    #[arg(long, value_name = "TEST")]
    pub(crate) test: Option<PathBuf>,
    /// Where to write the chosen sensors: a test file with the modes that the model predicts at them. Of several ways `--by` says which.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing output file.
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
    /// Standard deviation of a shape entry, of the largest entry.
    #[arg(long, default_value = "2 %", allow_hyphen_values = true)]
    pub(crate) noise_shape: String,
    /// Standard deviation of a frequency.
    #[arg(long, default_value = "0.5 %", allow_hyphen_values = true)]
    pub(crate) noise_frequency: String,
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// What every parameter does to frequencies, shapes, functions and mass; and what a test can tell of it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune sensitivity models/bff.yaml
  retune sensitivity models/bff.yaml models/bff_gvt.yaml --json")]
pub(crate) struct Sensitivity {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Test file: its sensors and standard deviations.
    pub(crate) test: Option<PathBuf>,
    /// Number of modes.
    #[arg(short = 'n', long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=200))]
    pub(crate) modes: u16,
    /// Damping ratio of the functions.
    #[arg(long, default_value = "1 %", allow_hyphen_values = true)]
    pub(crate) damping: String,
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    #[command(flatten)]
    pub(crate) answer: Answer,
}
