//! Measurement files: identifying modes, checking, mapping and imitating tests.

use super::{Answer, OneModel, Overwrite, Print, Random, Share, values};
use clap::Args;
use retune::catalogue::Choice;
use retune::data::FrfQuantity;
use retune::data::convert::{Duplicates, LocalAxes};
use retune::update::Method;
use std::path::PathBuf;

/// Answers to what measurement files may leave open; nothing is guessed.
#[derive(Debug, Args)]
pub(crate) struct Measurement {
    /// Units of the files: SI, mm-N-s, in-lbf-s, m-N-g, ..., or `labels` to believe the labels of the axes.
    #[arg(long, value_name = "SYSTEM")]
    pub(crate) units: Option<String>,
    /// What the functions are, where they do not say it.
    #[arg(long, value_name = "QUANTITY", value_parser = values::choice::<FrfQuantity>())]
    pub(crate) quantity: Option<FrfQuantity>,
    /// Unit of the functions of a table without a row of units, such as `m/s2/N`.
    #[arg(long)]
    pub(crate) unit: Option<String>,
    /// What variables of MATLAB and NumPy files are, where their names do not say it: `frequency=wn,shapes=V`,
    /// `frequency=x,functions=Hre+Him`; `functions=H:lines-responses-references` also says what runs along the axes.
    #[arg(long, value_name = "ROLE=NAME,...")]
    pub(crate) variables: Option<String>,
    /// Which of several functions of one pair of points counts.
    #[arg(long, value_name = "WHICH", value_parser = values::choice::<Duplicates>())]
    pub(crate) duplicates: Option<Duplicates>,
    /// Unit of the frequencies, whatever the files say: Hz, kHz, rad/s, deg/s, rpm.
    #[arg(long, value_name = "UNIT")]
    pub(crate) frequency_unit: Option<String>,
    /// Which of the matrices of local axes (dataset 2420) are axes; by the program that wrote the file when absent.
    #[arg(long, value_name = "PART", value_parser = values::choice::<LocalAxes>())]
    pub(crate) local_axes: Option<LocalAxes>,
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

impl Measurement {
    /// The options that are given.
    pub(crate) fn given(&self) -> Vec<&'static str> {
        // Named one by one, so that a new option is not forgotten here.
        let Self {
            units,
            quantity,
            unit,
            duplicates,
            frequency_unit,
            local_axes,
            variables,
            direction,
            geometry,
            geometry_units,
            frame,
        } = self;
        [
            ("--units", units.is_some()),
            ("--quantity", quantity.is_some()),
            ("--unit", unit.is_some()),
            ("--duplicates", duplicates.is_some()),
            ("--frequency-unit", frequency_unit.is_some()),
            ("--local-axes", local_axes.is_some()),
            ("--variables", variables.is_some()),
            ("--direction", direction.is_some()),
            ("--geometry", geometry.is_some()),
            ("--geometry-units", geometry_units.is_some()),
            ("--frame", frame.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, is_given)| is_given.then_some(name))
        .collect()
    }
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
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], value_parser = values::hertz)]
    pub(crate) band: Option<Vec<f64>>,
    /// How the modes are found.
    #[arg(long, value_name = "METHOD", default_value = Method::Plscf.word(), value_parser = values::choice::<Method>())]
    pub(crate) method: Method,
    /// Peaks of a spectrum without force: least height over the valleys beside them, dB.
    #[arg(long, default_value_t = 10.0, value_name = "DB", value_parser = values::not_negative)]
    pub(crate) peak_height: f64,
    /// Poles of the highest model order of each octave.
    #[arg(long, default_value_t = 40, value_parser = values::count(2, 400))]
    pub(crate) order: u16,
    /// How many of the lowest modes are rigid-body modes on the suspension: checked as such, not written.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = values::whole::<u16>)]
    pub(crate) suspension: u16,
    /// Exponential window that was laid over the signals, whose damping is taken out: its rate, `5 1/s`, or time constant, `0.2 s`; `none`
    /// leaves it in. By dataset 1858 of a universal file when absent.
    #[arg(long, value_name = "RATE")]
    pub(crate) exponential_window: Option<String>,
    /// What a repeated test would change of a frequency, and ten times as much of a shape: the standard deviations of the test file contain
    /// it, 0.1 % unless stated; with 0 they are those of the lines alone.
    #[arg(long, value_name = "SHARE", value_parser = values::repeatability)]
    pub(crate) repeatability: Option<f64>,
    /// Model in which the sensors get their places, by `retune map`.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Configuration of the model that was tested, for the test file.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Name of the test; that of the first file when absent.
    #[arg(long)]
    pub(crate) name: Option<String>,
    /// Write a page with the stabilisation diagram, the complex mode indicator function and the shapes.
    #[arg(long, value_name = "PAGE")]
    pub(crate) report: Option<PathBuf>,
    /// Leave out the check of the test.
    #[arg(long)]
    pub(crate) no_health: bool,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Check whether a test can be trusted: dead and noisy channels, signs, swaps, gains, axes, driving points, double modes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune health run1.unv --geometry points.unv
  retune health test.yaml
  retune health shapes.csv --direction +z
  retune health test.yaml --model models/bff.yaml
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
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], value_parser = values::hertz)]
    pub(crate) band: Option<Vec<f64>>,
    /// How many of the lowest modes are rigid-body modes on the suspension.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = values::whole::<u16>)]
    pub(crate) suspension: u16,
    /// Model that judges signs, swaps and gains of the sensors in place of their neighbours; it need not be updated.
    #[arg(long)]
    pub(crate) model: Option<PathBuf>,
    /// Configuration of the model; that which the test names when absent.
    #[arg(long, value_name = "NAME", requires = "model")]
    pub(crate) configuration: Option<String>,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// Find places in a model for the points of a test: nodes, else elements, with rigid arms; what has no place is listed.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune map models/bff.yaml geometry.unv --units in-lbf-s
  retune map models/bff.yaml test.yaml --tolerance '5 mm' -o placed.yaml

Exit code 1 when a point has no place.")]
pub(crate) struct Map {
    #[command(flatten)]
    pub(crate) model: OneModel,
    /// Test file whose sensors have positions, or a file with geometry.
    pub(crate) test: PathBuf,
    /// A point this near to a node sits on it.
    #[arg(long, default_value = "5 mm", value_name = "LENGTH", allow_hyphen_values = true, value_parser = values::length)]
    pub(crate) tolerance: f64,
    /// Longest rigid arm; a tenth of the diagonal of the model when absent.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = values::length)]
    pub(crate) reach: Option<f64>,
    /// Where to write the test with its sensors in place.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) measurement: Measurement,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}

/// Make a synthetic test of a model: modes and functions at sensors, with noise, measurement faults and hidden changes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune twin models/bff_truth.yaml -o twin.yaml --sensors models/bff_gvt.yaml --noise-frequency '0.3 %' --noise-shape '2 %'
  retune twin models/bff_truth.yaml --frf twin.unv --sensors models/bff_gvt.yaml --exciter p12 --band 3 35 --noise-response '1 %'
  retune twin models/bff.yaml -o twin.yaml --set m8_13=70g --patch hidden.yaml --fault sensor-sign@p11 --fault sensor-swap@p3+p4")]
pub(crate) struct Twin {
    #[command(flatten)]
    pub(crate) model: OneModel,
    /// Where to write a test file with modes.
    #[arg(short, long, value_name = "TEST")]
    pub(crate) output: Option<PathBuf>,
    /// Where to write functions: a universal file, or a table when the name ends with .csv.
    #[arg(long, value_name = "FILE")]
    pub(crate) frf: Option<PathBuf>,
    /// Test file with the sensors; a sensor on every node when absent.
    #[arg(long, value_name = "TEST")]
    pub(crate) sensors: Option<PathBuf>,
    /// Largest number of modes.
    #[arg(long, default_value_t = 10, value_parser = values::count(1, 2000))]
    pub(crate) modes: u16,
    /// Band of modes and functions, Hz.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], value_parser = values::hertz)]
    pub(crate) band: Option<Vec<f64>>,
    /// Frequency lines of the functions.
    #[arg(long, requires = "frf", default_value_t = 1025, value_parser = values::count(2, u16::MAX))]
    pub(crate) lines: u16,
    /// Sensors at which the force acts, one after the other; where it drives the modes of the band best when absent.
    #[arg(long, requires = "frf", num_args = 1.., value_name = "SENSOR")]
    pub(crate) exciter: Vec<String>,
    /// What the functions are; accelerance when absent.
    #[arg(long, requires = "frf", value_name = "QUANTITY", value_parser = values::choice::<FrfQuantity>())]
    pub(crate) quantity: Option<FrfQuantity>,
    /// Standard deviation of frequencies, as a share of each.
    #[arg(long, default_value = "0 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::share)]
    pub(crate) noise_frequency: Share,
    /// Standard deviation of damping ratios, as a share of each.
    #[arg(long, default_value = "0 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::share)]
    pub(crate) noise_damping: Share,
    /// Standard deviation of shape entries, as a share of the largest entry.
    #[arg(long, default_value = "0 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::share)]
    pub(crate) noise_shape: Share,
    /// Noise of the force, as a share of it.
    #[arg(long, requires = "frf", default_value = "0 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::share)]
    pub(crate) noise_force: Share,
    /// Noise of each response, as a share of its root mean square.
    #[arg(long, requires = "frf", default_value = "0 %", value_name = "SHARE", allow_hyphen_values = true, value_parser = values::share)]
    pub(crate) noise_response: Share,
    /// Averages of the functions.
    #[arg(long, requires = "frf", default_value_t = 16, value_parser = values::count(1, 10000))]
    pub(crate) averages: u16,
    /// Damping ratio of every mode; by default the model's own damping, 1 % where it has none.
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true, value_parser = values::damping)]
    pub(crate) damping: Option<f64>,
    /// A parameter of the model: `m8_13=70g`; a number without a unit is in the unit of the model file.
    #[arg(long, value_name = "PARAMETER=VALUE")]
    pub(crate) set: Vec<String>,
    /// A partial model file laid over the model: what the test has and the model lacks.
    #[arg(long, value_name = "FILE")]
    pub(crate) patch: Option<PathBuf>,
    /// A fault of the measurement, with its number where it has one: sensor-sign@p11, sensor-gain@p5=1.5, sensor-turned@p1.x+p1.y=10 (degrees);
    /// `retune list faults` has them all.
    #[arg(long, value_name = "FAULT")]
    pub(crate) fault: Vec<String>,
    #[command(flatten)]
    pub(crate) random: Random,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    #[command(flatten)]
    pub(crate) print: Print,
}
