//! The content of a test file.

use super::{Correction, DampingError, Date, FrfSet, MeasurementOptions};
use crate::dof::Dof;
use retune_linalg::{Complex, DVector};
use std::sync::Arc;

/// Where a number comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Measured on the structure; the text says by whom, where, when.
    Measured(String),
    /// Computed by a model, with or without added noise; the text says how.
    Synthetic(String),
}

impl Origin {
    /// "measured" or "synthetic".
    pub fn word(&self) -> &'static str {
        match self {
            Origin::Measured(_) => "measured",
            Origin::Synthetic(_) => "synthetic",
        }
    }
}

/// A value with its standard deviation, both in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// One standard deviation.
    pub sd: f64,
    /// Whether `sd` is a documented default because the file gives none.
    pub sd_is_default: bool,
}

/// Where a sensor sits.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// On a node, or rigidly connected to it at a position.
    Node {
        /// Name of the node.
        node: String,
        /// Position in global axes, m, when it is not the node's own.
        position: Option<[f64; 3]>,
    },
    /// On an element, by its shape functions, or rigidly connected to that point of it.
    Element {
        /// Name of the element.
        element: String,
        /// 0 at its first node, 1 at its second.
        fraction: f64,
        /// Position in global axes, m, when it is not on the line between the nodes.
        position: Option<[f64; 3]>,
    },
}

impl Place {
    /// The position that is stated beside the node or the element, m in global axes.
    pub fn position(&self) -> Option<[f64; 3]> {
        match self {
            Self::Node { position, .. } | Self::Element { position, .. } => *position,
        }
    }
}

/// A sensor: one place, one signed direction, one row of the observation matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Its name in the test.
    pub name: String,
    /// Where it sits.
    pub place: Place,
    /// Rigid arm in global axes from the node or point of its place to the sensor, m; only where the place has no position.
    pub offset: Option<[f64; 3]>,
    /// Direction in global axes, of unit length; the sensor reads the component along it.
    pub direction: [f64; 3],
    /// Whether it reads a rotation about the direction instead of a displacement along it.
    pub is_rotation: bool,
    /// Mass of the transducer, kg, when it loads the structure.
    pub mass: Option<f64>,
}

impl Sensor {
    /// What a load of a static test acts on, as the sensor that would read its work.
    pub fn of_load(load: &StaticLoad) -> Self {
        Self {
            name: "load".to_string(),
            place: load.place.clone(),
            direction: load.direction,
            offset: load.offset,
            is_rotation: load.is_moment,
            mass: None,
        }
    }
}

/// The mode of the model that a user names as the partner of a measured one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Partner {
    /// The n-th elastic mode of the model at its estimates, from 1.
    Number(usize),
    /// Its name there: `2nd Vertical Bending` or `S1B`.
    Label(String),
}

/// A mode of the model that a fit finds again wherever its frequency goes: by the momentum M φ of its shape φ, as φ'ᵀ M φ is nearly one for
/// the mode φ' that continues it and nearly zero for every other.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Nodes and dofs of the momentum.
    pub dofs: Arc<Vec<(String, Dof)>>,
    /// M φ, (n_dofs), φ of unit modal mass.
    pub momentum: Vec<f64>,
    /// Whether nothing else counts: the user has named the mode, or it has no measured shape.
    pub alone: bool,
}

/// What a measured mode is taken for.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Standing {
    /// Open: the pairing decides.
    #[default]
    Open,
    /// The user leaves it out (`use: false`).
    Unused,
    /// The user says that it is not of the structure (`foreign: true`).
    Foreign,
    /// The user names its partner (`pair_with`).
    With(Partner),
    /// The pairing has found it to be of the structure. Not written to files.
    Found {
        /// Its partner among the elastic modes of the model, from 0, where that was decided.
        model_mode: usize,
        /// Number of that mode, from 0, among those of its symmetry that no shape of the test takes: for a mode without a shape.
        rank: usize,
        /// Symmetry of that mode, where the label of the test denies it.
        family: Option<String>,
        /// Whether this very mode is the partner at every point; otherwise pairs are free among what was found.
        is_fixed: bool,
        /// Probability of the pair; of one that the user has named, by what is measured alone.
        probability: f64,
        /// Whether the user has named it.
        by_user: bool,
        /// What a fit follows it by, where the sensors do not tell the modes of the model apart, or the mode is known by its name.
        reference: Option<Arc<Reference>>,
    },
    /// The pairing has found no partner: it is left aside. Not written to files.
    Aside {
        /// Probability that it is not of the structure, where that was inferred.
        foreign: Option<f64>,
        /// Why it has no partner.
        reason: String,
    },
}

impl Standing {
    /// Whether the mode takes part in nothing.
    pub fn is_aside(&self) -> bool {
        matches!(self, Self::Unused | Self::Foreign | Self::Aside { .. })
    }

    /// Whether the user has left the mode out, or said that it is foreign.
    pub fn is_left_out(&self) -> bool {
        matches!(self, Self::Unused | Self::Foreign)
    }

    /// Whether a fit follows the mode by the whole shape of its partner.
    pub fn is_followed(&self) -> bool {
        matches!(self, Self::Found { reference: Some(_), .. })
    }

    /// Whether the user has named its partner.
    pub fn is_named(&self) -> bool {
        matches!(self, Self::With(_) | Self::Found { by_user: true, .. })
    }

    /// Why a mode has no partner, where it was put aside.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Unused => Some("the test file leaves it out (`use: false`)".into()),
            Self::Foreign => Some("the test file says that it is not of the structure (`foreign: true`)".into()),
            Self::Aside { reason, .. } => Some(reason.clone()),
            Self::Open | Self::With(_) | Self::Found { .. } => None,
        }
    }
}

/// A component of a mode shape whose scale is known.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeComponent {
    /// Index of the sensor.
    pub sensor: usize,
    /// Index of the sensor at which the shape is one; without it the shape has unit modal mass, φᵀ M φ = 1 kg.
    pub relative_to: Option<usize>,
    /// Its value, up to the sign of the whole shape: 1/√kg, of a rotation 1/(m √kg).
    pub measured: Measured,
}

impl ShapeComponent {
    /// The same with its sensors called by other numbers; `None` where one has none.
    pub fn renumbered(&self, number: impl Fn(usize) -> Option<usize>) -> Option<Self> {
        let relative_to = match self.relative_to {
            Some(k) => Some(number(k)?),
            None => None,
        };
        Some(Self { sensor: number(self.sensor)?, relative_to, measured: self.measured })
    }
}

/// One measured mode.
#[derive(Debug, Clone, PartialEq)]
pub struct TestMode {
    /// The test's own name for it, if it has one.
    pub label: Option<String>,
    /// Natural frequency, Hz.
    pub frequency_hz: Measured,
    /// Damping ratio, 1.
    pub damping_ratio: Option<Measured>,
    /// Where frequency and damping come from.
    pub origin: Origin,
    /// Shape at the sensors, any scale; NaN where a sensor did not measure.
    pub shape: Option<DVector<Complex<f64>>>,
    /// Standard deviation of each shape entry, in the unit of the shape (real and imaginary part each).
    pub shape_sd: Option<DVector<f64>>,
    /// Where the shape comes from.
    pub shape_origin: Option<Origin>,
    /// Components of the shape whose scale is known.
    pub components: Vec<ShapeComponent>,
    /// What it is taken for.
    pub standing: Standing,
    /// Modes of one name here are close ones whose shapes are mixtures: what they span is compared, not each shape alone.
    pub space: Option<String>,
}

/// A mass property that can be measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MassQuantity {
    /// Total mass, kg.
    Mass,
    /// Coordinate of the centre of gravity along axis 0, 1, 2, m.
    Cg(usize),
    /// Entry (i, j) of the inertia tensor about the centre of gravity, kg m².
    Inertia(usize, usize),
}

/// A measured mass property.
#[derive(Debug, Clone, PartialEq)]
pub struct MassProperty {
    /// Which.
    pub quantity: MassQuantity,
    /// Its value, SI.
    pub measured: Measured,
    /// Where it comes from.
    pub origin: Origin,
}

/// A static test: loads on a supported structure, and what moved.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticTest {
    /// Its name.
    pub name: String,
    /// The loads, all at once.
    pub loads: Vec<StaticLoad>,
    /// What the sensors read, against the unloaded structure.
    pub readings: Vec<StaticReading>,
    /// Where the readings come from.
    pub origin: Origin,
}

/// A force or moment on a point of the structure.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticLoad {
    /// Where it acts.
    pub place: Place,
    /// Rigid arm in global axes from the node or point of its place to the load, m; only where the place has no position.
    pub offset: Option<[f64; 3]>,
    /// Direction in global axes, of unit length.
    pub direction: [f64; 3],
    /// Whether it is a moment about the direction instead of a force along it.
    pub is_moment: bool,
    /// Its size, N or N m.
    pub value: f64,
}

/// The change of one sensor under the loads.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticReading {
    /// Index of the sensor.
    pub sensor: usize,
    /// Displacement, m, or rotation, rad.
    pub measured: Measured,
}

/// How frequency response functions enter a fit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrfFit {
    /// Files of the functions, relative to the test file.
    pub files: Vec<String>,
    /// Answers to what the files leave open.
    pub reading: MeasurementOptions,
    /// Only lines in these bands, Hz; all lines when empty.
    pub bands_hz: Vec<[f64; 2]>,
    /// Only these of them, Hz, ascending; all when absent.
    pub lines_hz: Option<Vec<f64>>,
    /// Standard deviation of a value, relative to it.
    pub relative_sd: f64,
    /// Loss factor η of the whole structure, K (1 + i η), beside the model's own damping; zero when absent.
    pub loss_factor: Option<f64>,
    /// What the scatter of that of the modes does to the functions, where the file gives none.
    pub damping_error: Option<Arc<DampingError>>,
}

impl FrfFit {
    /// The loss factor of a model without damping of its own, for a file that gives none: twice the median of the measured damping
    /// ratios, which is what an amplitude at resonance shows; and how much the ratios scatter about it, relative to it. `None` where nothing was
    /// measured.
    pub fn usual_loss_factor(modes: &[TestMode]) -> Option<[f64; 2]> {
        /// Modes of one structure hardly agree better.
        const LEAST: f64 = 0.05;
        /// Standard deviation of a normal distribution over its median absolute deviation.
        const OF_MEDIAN: f64 = 1.4826;
        let ratios: Vec<f64> = modes.iter().filter_map(|m| m.damping_ratio.map(|d| d.value)).collect();
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        let middle = median(ratios.clone()).filter(|ratio| *ratio > 0.0)?;
        let scatter = median(ratios.iter().map(|ratio| (ratio / middle - 1.0).abs()).collect())?;
        Some([2.0 * middle, (OF_MEDIAN * scatter).max(LEAST)])
    }

    /// Whether a line is in its bands.
    pub fn is_in_bands(&self, hz: f64) -> bool {
        hz > 0.0 && (self.bands_hz.is_empty() || self.bands_hz.iter().any(|[l, h]| (*l..=*h).contains(&hz)))
    }

    /// Whether a line enters a fit.
    pub fn uses(&self, hz: f64) -> bool {
        let is_chosen = |lines: &Vec<f64>| lines.binary_search_by(|f| f.total_cmp(&hz)).is_ok();
        self.is_in_bands(hz) && self.lines_hz.as_ref().is_none_or(is_chosen)
    }
}

/// Everything a test file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TestData {
    /// Name of the test.
    pub name: String,
    /// A paragraph for people.
    pub description: String,
    /// The day on which it was measured.
    pub date: Option<Date>,
    /// Configuration of the model that was tested, when it has several.
    pub configuration: Option<String>,
    /// Sensors, in the order of every shape.
    pub sensors: Vec<Sensor>,
    /// Measured modes, by ascending frequency.
    pub modes: Vec<TestMode>,
    /// Measured mass properties.
    pub mass_properties: Vec<MassProperty>,
    /// Static tests.
    pub static_tests: Vec<StaticTest>,
    /// Frequency response functions, when given.
    pub frfs: Option<FrfSet>,
    /// How they enter a fit, when they do.
    pub frf_fit: Option<FrfFit>,
    /// What has been taken out of the readings, and functions from files still have.
    pub corrections: Vec<Correction>,
}

impl TestData {
    /// Whether there is something beside modes that a model could be compared with.
    pub fn has_more_than_modes(&self) -> bool {
        !self.mass_properties.is_empty() || self.has_answers()
    }

    /// Whether it has answers to loads: static tests, or functions that a fit uses.
    pub fn has_answers(&self) -> bool {
        !self.static_tests.is_empty() || self.frfs.is_some() && self.frf_fit.is_some()
    }

    /// The same without its functions.
    #[must_use]
    pub fn without_functions(&self) -> Self {
        Self { frfs: None, frf_fit: None, ..self.clone() }
    }

    /// Whether there is nothing in it that a model could be compared with.
    pub fn has_nothing(&self) -> bool {
        self.modes.is_empty() && !self.has_more_than_modes()
    }
}

/// Brings a shape, whose scale is free, to one in which squares are numbers: by a power of two, which changes no digit, and only where
/// its largest entry is beyond 1e±60. Its standard deviations are in the same scale.
pub(in crate::data) fn usable_scale(shape: &mut DVector<Complex<f64>>, sd: &mut DVector<f64>) {
    const USUAL: std::ops::Range<f64> = 1e-60..1e60;
    const MOST: f64 = 1000.0;
    let size = |v: &Complex<f64>| v.re.abs().max(v.im.abs());
    let largest = shape.iter().map(size).filter(|v| v.is_finite()).fold(0.0, f64::max);
    if largest > 0.0 && !USUAL.contains(&largest) {
        let scale = (-largest.log2().floor()).clamp(-MOST, MOST).exp2();
        shape.apply(|v| *v *= scale);
        sd.apply(|v| *v *= scale);
    }
}
