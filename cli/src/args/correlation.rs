//! Comparing, planning a test, sensitivities.

use super::{Answer, Loading, Measurement, OneModel, Overwrite, PairingOptions, Print, Tests, values};
use clap::Args;
use retune::catalogue::Choice;
use retune::update::{MassReduction, Placement};
use std::path::PathBuf;

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
    #[command(flatten)]
    pub(crate) model: OneModel,
    #[command(flatten)]
    pub(crate) tests: Tests,
    /// Every sensor: COMAC, scaled and enhanced COMAC, misfit, and which sensors spoil the MAC.
    #[arg(long)]
    pub(crate) sensors: bool,
    /// Auto- and cross-orthogonality in the model's mass, reduced to the sensors.
    #[arg(long)]
    pub(crate) orthogonality: bool,
    /// How the mass is reduced.
    #[arg(long, value_name = "HOW", default_value = MassReduction::Auto.word(), value_parser = values::choice::<MassReduction>())]
    pub(crate) reduction: MassReduction,
    /// Elements and groups, ranked by how much of the disagreement sits there.
    #[arg(long)]
    pub(crate) localize: bool,
    /// What the test tells about each parameter, and the combinations through which they act.
    #[arg(long)]
    pub(crate) sensitivity: bool,
    /// All of these.
    #[arg(long)]
    pub(crate) all: bool,
    /// Measured frequency response functions: FRAC, CSAC, CSF, amplitude and phase by band, frequency shift by FDAC.
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub(crate) frf: Vec<PathBuf>,
    /// Edges of the bands of the functions, Hz; when absent the bands of the test file, else halfway between the test modes.
    #[arg(long, num_args = 2.., value_name = "HZ", value_parser = values::hertz)]
    pub(crate) bands: Vec<f64>,
    /// Judge by a criteria profile: a built-in name, or a YAML file with profiles (`file.yaml`, `file.yaml:NAME`).
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) profile: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) pairing: PairingOptions,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    #[command(flatten)]
    pub(crate) loading: Loading,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// Plan a test: which modes, where to measure, where to excite, and what one more sensor would tell.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune pretest models/bff.yaml -n 6 --sensors 12
  retune pretest models/bff.yaml --test models/bff_gvt.yaml
  retune pretest models/frame.yaml --sensors 6 --by auto-mac -o plan.yaml")]
pub(crate) struct Pretest {
    #[command(flatten)]
    pub(crate) model: OneModel,
    /// Number of target modes; six when absent, or as many as there are places for sensors.
    #[arg(short = 'n', long, value_parser = values::count(1, 200))]
    pub(crate) modes: Option<u16>,
    /// Number of sensors to choose; when absent twice the modes, or as many as there are places.
    #[arg(long, value_parser = values::count(1, u16::MAX))]
    pub(crate) sensors: Option<u16>,
    /// How they are chosen; all ways side by side when absent.
    #[arg(long, value_name = "WAY", value_parser = values::choice::<Placement>())]
    pub(crate) by: Option<Placement>,
    /// Test files whose sensors are judged and added to; candidates are all translations of nodes.
    #[arg(long, value_name = "TEST", num_args = 1..)]
    pub(crate) test: Vec<PathBuf>,
    /// Where to write the chosen sensors: a test file with the modes that the model predicts at them. Of several ways `--by` says which.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Standard deviation of a shape entry, as a share of the largest entry.
    #[arg(long, default_value = "2 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::positive_share)]
    pub(crate) noise_shape: f64,
    /// Standard deviation of a frequency, as a share of it.
    #[arg(long, default_value = "0.5 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::positive_share)]
    pub(crate) noise_frequency: f64,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Show what each parameter does to frequencies, shapes, functions and mass, and what a test can tell about it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune sensitivity models/bff.yaml
  retune sensitivity models/bff.yaml models/bff_gvt.yaml --json")]
pub(crate) struct Sensitivity {
    #[command(flatten)]
    pub(crate) model: OneModel,
    /// Test files: the sensors and standard deviations of each, and the model in the configuration that it names.
    #[arg(value_name = "TEST")]
    pub(crate) tests: Vec<PathBuf>,
    /// Number of modes.
    #[arg(short = 'n', long, default_value_t = 6, value_parser = values::count(1, 200))]
    pub(crate) modes: u16,
    /// Damping ratio of the functions.
    #[arg(long, default_value = "1 %", value_name = "RATIO", allow_hyphen_values = true, value_parser = values::damping)]
    pub(crate) damping: f64,
    #[command(flatten)]
    pub(crate) answer: Answer,
}
