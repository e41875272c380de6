//! From measurements to a test: modes by the method that is asked for, their health, and the test that a model can be compared with.

use super::{UpdateError, sensors_by_model};
use crate::catalogue::counted;
use crate::correlation::{MappingOptions, map_points, place_sensors};
use crate::data::{
    DEFAULT_DAMPING_SD, DEFAULT_FREQUENCY_SD, DEFAULT_SHAPE_SD, FrfSet, Measurements, ModalSet, Origin, Place,
    RelativeSd, Sensor, SpectrumKind, TestData, TestMode,
};
use crate::identify::health::{
    Finding, HealthOptions, check_damping, check_identification, check_shapes, check_test, reversed_time_finding,
};
use crate::identify::{
    Identification, IdentifyError, IdentifyOptions, PeakOptions, REPEATABILITY, SpectrumPeak, add_repeatability,
    circle_modes, identify, peak_modes, quadrature_modes, remove_exponential_window, sensors, spectrum_peaks,
    test_modes,
};
use crate::linalg::Complex;
use crate::model::{Model, extent};
use crate::units::four_digits;
use crate::update::Remark;
use std::borrow::Cow;

/// How modes are identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Poles by pLSCF over many model orders, then a maximum-likelihood fit.
    #[default]
    Plscf,
    /// Shapes from imaginary parts at the frequencies of pLSCF, corrected for neighbouring modes; first reference.
    Quadrature,
    /// Circle fits about the poles of pLSCF; first reference.
    Circle,
}

crate::catalogue::choice! { Method, "method";
    Plscf "plscf" "Poles by pLSCF over many model orders, then a maximum-likelihood fit",
    Quadrature "quadrature" "Shapes from imaginary parts at the frequencies of pLSCF, corrected for neighbouring modes; first reference",
    Circle "circle" "Circle fits about the poles of pLSCF; first reference",
}

impl Method {
    /// Its name in the field.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plscf => "pLSCF and maximum likelihood",
            Self::Quadrature => "quadrature picking",
            Self::Circle => "circle fits",
        }
    }
}

/// An exponential window that was laid over the signals.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Window {
    /// As the measurements state it.
    #[default]
    Stated,
    /// Its damping stays in.
    None,
    /// Of this rate, 1/s.
    Rate(f64),
}

/// Settings of [`identify_test`].
#[derive(Debug, Clone)]
pub struct IdentifySettings {
    /// Band, orders, rules.
    pub options: IdentifyOptions,
    /// How.
    pub method: Method,
    /// Peaks of a spectrum without force: least height over the valleys beside them, dB.
    pub peak_height_db: f64,
    /// How many of the lowest modes are rigid-body modes on the suspension: checked as such, not part of the test.
    pub n_suspension: usize,
    /// The exponential window.
    pub window: Window,
    /// What a repeated test would change: this share of a frequency, ten times as much of a shape.
    pub repeatability: f64,
    /// Whether the test is checked.
    pub checks_health: bool,
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self {
            options: IdentifyOptions::default(),
            method: Method::default(),
            peak_height_db: 10.0,
            n_suspension: 0,
            window: Window::default(),
            repeatability: REPEATABILITY,
            checks_health: true,
        }
    }
}

/// What a test file says of itself.
#[derive(Debug, Clone, Default)]
pub struct About {
    /// Name of the test.
    pub name: String,
    /// Where the numbers come from: names of files.
    pub sources: Vec<String>,
    /// Configuration of the model that was tested.
    pub configuration: Option<String>,
}

/// What an identification gives.
#[derive(Debug, Clone)]
pub struct Identified {
    /// What it was made of.
    pub way: Way,
    /// The modes, those on the suspension among them.
    pub modes: Vec<TestMode>,
    /// The test, without modes on the suspension; without sensors where a channel has no direction, see `test_lacks`.
    pub test: TestData,
    /// Why the test has no sensors, if it has none.
    pub test_lacks: Option<IdentifyError>,
    /// The check of the test.
    pub findings: Vec<Finding>,
    /// What is to be told besides.
    pub remarks: Vec<Remark>,
    /// Whether the measurements say that they are synthetic.
    pub is_synthetic: bool,
}

/// Where modes come from.
#[derive(Debug, Clone)]
pub enum Way {
    /// From frequency response functions.
    Functions {
        /// The functions, with the points that roved as responses.
        frfs: FrfSet,
        /// Poles, diagrams, pieces of the band.
        identification: Box<Identification>,
        /// How.
        method: Method,
        /// Rate of the exponential window whose damping was taken out, 1/s.
        window: Option<f64>,
    },
    /// Modes as the measurements hold them.
    Held {
        /// Names of their channels.
        channels: Vec<String>,
    },
    /// Peaks of spectra without force: name of each, and its peaks. The test holds those of the first.
    Peaks(Vec<(String, Vec<SpectrumPeak>)>),
}

/// Identifies the modes of measurements, checks the test, and gives the sensors their places in a model where one is given.
///
/// * `model` - in which the sensors get their places; the measurements then need positions
///
/// # Errors
/// No functions, modes or spectra; a band without lines; a channel without a direction, where a model is given.
pub fn identify_test(
    found: &Measurements,
    about: &About,
    model: Option<&Model>,
    settings: &IdentifySettings,
) -> Result<Identified, UpdateError> {
    if model.is_some() && found.geometry.is_none() && (found.frfs.is_some() || found.modes.is_some()) {
        return Err(UpdateError::NoPositions);
    }
    let mut out = match (&found.frfs, &found.modes) {
        (Some(frfs), _) => of_functions(found, frfs, about, model, settings)?,
        (None, _) if !found.spectra.is_empty() => of_spectra(found, about, settings)?,
        (None, Some(modes)) => held(found, modes, about, model, settings)?,
        (None, None) => return Err(UpdateError::NoMeasurements(instead(found))),
    };
    out.findings.sort_by_key(|f| std::cmp::Reverse(f.level));
    Ok(out)
}

/// What measurements hold that have no functions.
pub fn instead(found: &Measurements) -> String {
    if !found.spectra.is_empty() {
        format!("{}: no force was measured", counted(found.spectra.len(), "spectrum"))
    } else if let Some(geometry) = &found.geometry {
        format!(
            "a geometry of {}; give it to `--geometry`, or to `retune map`",
            counted(geometry.points.len(), "point")
        )
    } else {
        "nothing that this reads; the notes say what was left out".to_string()
    }
}

/// The functions with the points that roved as responses, and a note where they have changed places.
pub fn with_roving_responses(set: &FrfSet) -> (Cow<'_, FrfSet>, Option<Remark>) {
    let turned = set.by_reciprocity();
    let note = matches!(turned, Cow::Owned(_)).then(|| {
        Remark::Note(format!(
            "the force roved over {} and {} stayed: shapes are at the points of the force, by reciprocity",
            counted(set.references.len(), "point"),
            counted(set.responses.len(), "sensor")
        ))
    });
    (turned, note)
}

/// Sensors and modes of a set of modes, with the standard deviations of the documented defaults.
pub fn held_modes(found: &Measurements, modes: &ModalSet, origin: &Origin) -> (Vec<Sensor>, Vec<TestMode>) {
    let sd = RelativeSd { frequency: DEFAULT_FREQUENCY_SD, damping: DEFAULT_DAMPING_SD, shape: DEFAULT_SHAPE_SD };
    (modes.placed_sensors(found.geometry.as_ref()), modes.test_modes(origin, sd))
}

/// Names and positions of the sensors whose position is known.
pub fn points_of(test: &TestData) -> Vec<(String, [f64; 3])> {
    let position = |place: &Place| match place {
        Place::Node { position, .. } | Place::Element { position, .. } => *position,
    };
    test.sensors.iter().filter_map(|s| Some((s.name.clone(), position(&s.place)?))).collect()
}

/// Gives the sensors of a test their places in a model, where their positions are known; those without are left out and named.
///
/// # Errors
/// None of them lies on the model.
pub fn place(model: &Model, test: &mut TestData) -> Result<Vec<Remark>, UpdateError> {
    let points = points_of(test);
    let mapping = map_points(model, &points, MappingOptions::default());
    let positions: Vec<[f64; 3]> = points.iter().map(|p| p.1).collect();
    let (of_points, of_model) = (extent(&positions), model.geometry().size());
    let lengths = || format!("they span {} m and the model {} m", four_digits(of_points), four_digits(of_model));
    if mapping.points.is_empty() && !points.is_empty() {
        return Err(UpdateError::OffTheModel { sensors: points.len(), lengths: lengths() });
    }
    let without = |name: String| Remark::Warning(format!("sensor `{name}` has no place in the model and is left out"));
    let mut remarks: Vec<Remark> = place_sensors(test, &mapping).into_iter().map(without).collect();
    if points.len() >= FEW_POINTS && of_points < SMALL * of_model {
        let text = format!("the sensors may be in another unit of length: {}", lengths());
        remarks.insert(0, Remark::Warning(text));
    }
    Ok(remarks)
}

/// Points whose extent tells something.
const FEW_POINTS: usize = 4;

/// Sensors that span less than this share of the model are hardly those of its modes: metres taken for inches make it a fortieth, for millimetres a
/// thousandth.
const SMALL: f64 = 1.0 / 30.0;

fn of_functions(
    found: &Measurements,
    set: &FrfSet,
    about: &About,
    model: Option<&Model>,
    settings: &IdentifySettings,
) -> Result<Identified, UpdateError> {
    let (turned, note) = with_roving_responses(set);
    let frfs = turned.into_owned();
    let mut remarks: Vec<Remark> = note.into_iter().collect();
    let identification = identify(&frfs, &settings.options)?;
    let origin = origin(found, about, settings.method.name());
    let mut modes = match settings.method {
        Method::Plscf => test_modes(&identification.modes, &origin),
        Method::Circle => circle_modes(&frfs, 0, &identification.modes, &origin)?,
        Method::Quadrature => quadrature_modes(&frfs, 0, &identification.modes, &origin)?,
    };
    let window = take_out_window(settings.window, found, &mut modes, &mut remarks);
    let (sensors, test_lacks) = match sensors(&frfs, found.geometry.as_ref(), None) {
        Ok(sensors) => (sensors, None),
        Err(e) if model.is_some() => return Err(e.into()),
        Err(e) => (Vec::new(), Some(e)),
    };
    let description = format!(
        "Identified by {} from {}, {:.4} to {:.4} Hz, {}, {}; complex shapes, largest entry 1. \
         Standard deviations are those of the lines and {} % of a frequency, ten times that of a shape, for what a repeated \
         test would change.{}",
        settings.method.name(),
        counted(frfs.n_lines(), "line"),
        frfs.frequencies_hz.first().copied().unwrap_or(0.0),
        frfs.frequencies_hz.last().copied().unwrap_or(0.0),
        counted(frfs.responses.len(), "response"),
        counted(frfs.references.len(), "reference"),
        // 12 digits: a share of a percentage and back is rounded.
        crate::units::plain((1e14 * settings.repeatability).round() / 1e12),
        window.map_or_else(String::new, |w| format!(" The damping of an exponential window of {w} 1/s is taken out.")),
    );
    let mut test = TestData { sensors, modes: modes.clone(), ..described(found, about, description) };
    if let Some(model) = model {
        remarks.extend(place(model, &mut test)?);
    }
    let n_suspension = settings.n_suspension;
    let mut findings = Vec::new();
    if settings.checks_health {
        let options = HealthOptions { n_suspension, has_model: model.is_some() };
        findings = check_test(&frfs, Some(&identification), found.geometry.as_ref(), options)?;
        findings.extend(found.is_time_reversed.then(reversed_time_finding));
        if let Some(model) = model {
            findings.extend(sensors_by_model(model, &test, n_suspension)?);
        }
    } else {
        // What was left out, and why there is nothing, is not a question of health.
        let told = check_identification(&frfs, &identification).into_iter();
        remarks.extend(told.map(|finding| Remark::Warning(finding.text)));
    }
    without_suspension(&mut test, n_suspension);
    add_repeatability(&mut test.modes, settings.repeatability);
    let way = Way::Functions { frfs, identification: Box::new(identification), method: settings.method, window };
    Ok(Identified { way, modes, test, test_lacks, findings, remarks, is_synthetic: found.is_synthetic })
}

fn held(
    found: &Measurements,
    set: &ModalSet,
    about: &About,
    model: Option<&Model>,
    settings: &IdentifySettings,
) -> Result<Identified, UpdateError> {
    let (sensors, modes) = held_modes(found, set, &origin(found, about, "modes"));
    let description = "Modes as the file holds them; it states no standard deviations, so those are defaults.";
    let own = described(found, about, description.to_string());
    let mut test = TestData { sensors: sensors.clone(), modes: modes.clone(), ..own };
    let mut remarks: Vec<Remark> = modes
        .iter()
        .filter(|m| m.shape.is_none() && !sensors.is_empty())
        .map(|m| {
            Remark::Warning(format!(
                "the mode at {:.3} Hz has no shape in the file: its frequency alone is kept",
                m.frequency_hz.value
            ))
        })
        .collect();
    if let Some(model) = model {
        remarks.extend(place(model, &mut test)?);
    }
    let mut findings = Vec::new();
    if settings.checks_health {
        let options = HealthOptions { n_suspension: settings.n_suspension, has_model: model.is_some() };
        findings = [check_damping(&set.modes), check_shapes(&sensors, &modes, options)?].concat();
        if let Some(model) = model {
            findings.extend(sensors_by_model(model, &test, settings.n_suspension)?);
        }
    }
    without_suspension(&mut test, settings.n_suspension);
    let (way, is_synthetic) =
        (Way::Held { channels: sensors.into_iter().map(|s| s.name).collect() }, found.is_synthetic);
    Ok(Identified { way, modes, test, test_lacks: None, findings, remarks, is_synthetic })
}

fn of_spectra(found: &Measurements, about: &About, settings: &IdentifySettings) -> Result<Identified, UpdateError> {
    let mut all: Vec<(String, Vec<SpectrumPeak>)> = Vec::new();
    for spectrum in &found.spectra {
        let f = &spectrum.frequencies_hz;
        let limits = (f.first().copied().unwrap_or(0.0), f.last().copied().unwrap_or(0.0));
        let limits = settings.options.band_hz.unwrap_or(limits);
        // Of a power the root is an amplitude.
        let is_power = spectrum.kind != SpectrumKind::Linear;
        let size = |v: &Complex<f64>| if is_power { v.norm().sqrt() } else { v.norm() };
        let amplitude: Vec<f64> = spectrum.values.iter().map(size).collect();
        let options = PeakOptions { min_height_db: settings.peak_height_db, ..PeakOptions::resonances(limits) };
        all.push((spectrum.response.name.clone(), spectrum_peaks(f, &amplitude, &options)?));
    }
    let description = "Peaks of a response spectrum; no force was measured.".to_string();
    let mut test = described(found, about, description);
    let first = all.first().map_or(&[][..], |(_, peaks)| peaks);
    test.modes = peak_modes(first, &origin(found, about, settings.method.name()));
    Ok(Identified {
        modes: test.modes.clone(),
        way: Way::Peaks(all),
        test,
        test_lacks: None,
        findings: Vec::new(),
        remarks: Vec::new(),
        is_synthetic: found.is_synthetic,
    })
}

/// Takes the damping of an exponential window out of the modes; gives its rate, 1/s.
fn take_out_window(
    asked: Window,
    found: &Measurements,
    modes: &mut [TestMode],
    remarks: &mut Vec<Remark>,
) -> Option<f64> {
    let rate = match asked {
        Window::None => None,
        Window::Rate(rate) => Some(rate),
        Window::Stated => found.exponential_window,
    }?;
    let mut corrected = modes.to_vec();
    let lost = remove_exponential_window(&mut corrected, rate);
    if asked == Window::Stated {
        if !lost.is_empty() {
            remarks.push(Remark::Warning(format!(
                "dataset 1858 states an exponential window with the damping factor {rate}; as a rate in 1/s it is more than the damping of {} of {} modes, so that nothing is taken out; state it with `--exponential-window`",
                lost.len(),
                modes.len()
            )));
            return None;
        }
        remarks.push(Remark::Note(format!(
            "dataset 1858 states an exponential window with the damping factor {rate}, taken as a rate in 1/s: its damping is taken out; `--exponential-window none` leaves it in"
        )));
    }
    remarks.extend(lost.into_iter().map(|hz| {
        Remark::Warning(format!(
            "the mode at {hz:.3} Hz has no more damping than the window of {rate} 1/s adds: its damping ratio is left out"
        ))
    }));
    modes.clone_from_slice(&corrected);
    Some(rate)
}

fn without_suspension(test: &mut TestData, n_suspension: usize) {
    test.modes.drain(..n_suspension.min(test.modes.len()));
}

fn described(found: &Measurements, about: &About, description: String) -> TestData {
    let name = about.name.clone();
    let is_said = !found.is_synthetic || name.to_lowercase().contains("synthetic");
    TestData {
        name: if is_said { name } else { format!("{name} (synthetic)") },
        description,
        date: found.date,
        configuration: about.configuration.clone(),
        ..TestData::default()
    }
}

fn origin(found: &Measurements, about: &About, how: &str) -> Origin {
    let text = format!("{how} of {}", about.sources.join(", "));
    if found.is_synthetic { Origin::Synthetic(text) } else { Origin::Measured(text) }
}
