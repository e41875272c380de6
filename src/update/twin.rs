//! Synthetic tests: modes and frequency responses of a model at sensors, with noise and faults of the measurement.
//!
//! For tests of this crate, for examples, and for planning: what would a test with these sensors and this noise tell? Everything
//! is seeded; modes, and functions of each exciter, have random streams of their own, so that one does not change when
//! another is left out. Everything that is written says that it is synthetic.

mod fault;

pub use fault::TwinFault;

use super::name_modes;
use crate::catalogue::did_you_mean;
use crate::correlation::{CorrelationError, observation_matrix_at, rank_driving_points};
use crate::data::{Channel, FrfQuantity, FrfSet, Measured, Origin, Place, Sensor, Standing, TestData, TestMode};
use crate::element::Dof;
use crate::fault::FaultError;
use crate::linalg::{Complex, DMatrix, DVector};
use crate::modal::{ModalDamping, Modes, SolveOptions, synthesize};
use crate::model::{Matrices, ModelError, ParametricModel, solve_modes, spread};
use crate::objective::Damped;
use crate::optim::Draw;
use fault::Inflicted;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Functions are superposed from at most this many elastic modes.
const MOST_MODES: usize = 400;
/// Modes that are computed at first to reach the end of a band.
const FIRST_MODES: usize = 20;

/// A mode that moves the sensors by less than this share of its largest entry is seen by none.
const UNSEEN: f64 = 1e-9;

/// Damping ratios below this are not measured: a dashpot that a mode does not work has left rounding.
const LEAST_RATIO: f64 = 1e-6;

/// Damping ratio of every mode of a model that has no damping.
const OWN_DAMPING: f64 = 0.01;

/// Random streams.
const MODES_STREAM: u64 = 1;
const FRF_STREAM: u64 = 2;

/// Settings of a synthetic test.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinOptions {
    /// Most elastic modes to write.
    pub n_modes: usize,
    /// Only modes in this band, Hz.
    pub band_hz: Option<(f64, f64)>,
    /// Relative standard deviation of frequencies.
    pub frequency_noise: f64,
    /// Damping ratio of every mode; absent: what the model's own damping gives a mode, 1 % of a model without.
    pub damping: Option<f64>,
    /// Relative standard deviation of damping ratios.
    pub damping_noise: f64,
    /// Standard deviation of shape entries, relative to the largest entry.
    pub shape_noise: f64,
    /// Faults of the measurement.
    pub faults: Vec<TwinFault>,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for TwinOptions {
    /// Ten modes with the model's own damping, without noise and faults.
    fn default() -> Self {
        Self {
            n_modes: 10,
            band_hz: None,
            frequency_noise: 0.0,
            damping: None,
            damping_noise: 0.0,
            shape_noise: 0.0,
            faults: Vec::new(),
            seed: 0,
        }
    }
}

/// How the numbers of a synthetic test came about, for the files that hold them.
#[derive(Debug, Clone, Copy)]
pub struct TwinStory<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// Name of its file.
    pub file: &'a str,
    /// Name of the file with the hidden changes.
    pub patch: Option<&'a str>,
    /// Parameters that were set: `m8_13=70g`.
    pub set: &'a [String],
    /// Faults of the measurement: `sensor-sign@p11`.
    pub faults: &'a [String],
    /// Noise of frequencies, in words.
    pub noise_frequency: &'a str,
    /// Noise of shapes, in words.
    pub noise_shape: &'a str,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl TwinStory<'_> {
    /// In a sentence.
    pub fn text(&self) -> String {
        let mut parts = vec![format!("computed by `retune twin` from {} ({})", self.model, self.file)];
        parts.extend(self.patch.map(|patch| format!("with the hidden changes of {patch}")));
        parts.extend(self.set.iter().map(|set| format!("with {set}")));
        parts.extend(self.faults.iter().map(|fault| format!("with the fault {fault}")));
        parts.push(format!(
            "noise {} of frequencies and {} of shapes, seed {}",
            self.noise_frequency, self.noise_shape, self.seed
        ));
        parts.join(", ")
    }

    /// Writes it over a test of [`twin_modes`]: name, description, configuration.
    pub fn sign(&self, test: &mut TestData, configuration: Option<&str>) {
        let is_said = self.model.to_lowercase().contains("synthetic");
        test.name = if is_said { self.model.to_string() } else { format!("{} (synthetic)", self.model) };
        test.description = format!("SYNTHETIC: every number was {}", self.text());
        test.configuration = configuration.map(str::to_string);
    }
}

/// Lines, exciters and noise of synthetic functions.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinFrfOptions {
    /// Frequency lines, Hz, ascending.
    pub lines_hz: Vec<f64>,
    /// Names of the sensors at which, and along which, the force acts, one after the other.
    pub exciters: Vec<String>,
    /// What is measured.
    pub quantity: FrfQuantity,
    /// Standard deviation of the noise of the force, relative to the force.
    pub force_noise: f64,
    /// Standard deviation of the noise of a response, relative to the root mean square of that response over the lines.
    pub response_noise: f64,
    /// Averages of the estimator, at least 1.
    pub n_averages: usize,
}

/// Why there is no synthetic test.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TwinError {
    /// A sensor sits where the model has nothing.
    #[error(transparent)]
    Correlation(#[from] CorrelationError),
    /// The model has no matrices or no modes.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A fault that is not in the catalogue, or not at this place.
    #[error(transparent)]
    Place(#[from] FaultError),
    /// A fault with a wrong number.
    #[error("fault `{text}`: {problem}")]
    Fault {
        /// The fault.
        text: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A name that no sensor has.
    #[error("there is no sensor `{name}`{suggestion}")]
    NoSensor {
        /// The name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// A number out of its range.
    #[error("{what} is {value}; it must be {expected}")]
    Range {
        /// What.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// Nothing to measure with, or nothing to measure.
    #[error("{0}")]
    Nothing(&'static str),
}

/// A sensor on every node for each translation that exists there, for tests that name no sensors: `n4`, or `n4.ux` where a
/// node has several.
pub fn node_sensors(model: &dyn ParametricModel) -> Vec<Sensor> {
    sensors_at(model, &nodes_that_move(model))
}

/// Nodes at which places are looked for: of a mesh with more those that are farthest from each other.
const MOST_NODES: usize = 600;

/// Sensors for every translation of every node, or of some hundred nodes that are spread evenly over a mesh; how many nodes these are, and how many
/// move.
pub fn spread_sensors(model: &dyn ParametricModel) -> (Vec<Sensor>, [usize; 2]) {
    let all = nodes_that_move(model);
    let nodes = spread(model.dof_map().positions(), &all, MOST_NODES);
    (sensors_at(model, &nodes), [nodes.len(), all.len()])
}

/// Nodes with a translation that is not held, by index.
fn nodes_that_move(model: &dyn ParametricModel) -> Vec<usize> {
    let dofs = model.dof_map();
    let moves = |n: usize| Dof::ALL[..3].iter().any(|d| !dofs.express(n, *d).is_empty());
    (0..dofs.node_names().len()).filter(|&n| !dofs.is_coordinate(n) && moves(n)).collect()
}

fn sensors_at(model: &dyn ParametricModel, nodes: &[usize]) -> Vec<Sensor> {
    let dofs = model.dof_map();
    let mut sensors = Vec::new();
    for &index in nodes {
        let node = &dofs.node_names()[index];
        let moving: Vec<Dof> = Dof::ALL[..3].iter().copied().filter(|d| !dofs.express(index, *d).is_empty()).collect();
        for dof in &moving {
            let mut direction = [0.0; 3];
            direction[*dof as usize] = 1.0;
            sensors.push(Sensor {
                name: if moving.len() == 1 { node.clone() } else { format!("{node}.{dof}") },
                place: Place::Node { node: node.clone(), position: None },
                direction,
                offset: None,
                is_rotation: false,
                mass: None,
            });
        }
    }
    sensors
}

/// Modes of a model at θ as a test would give them.
///
/// ```text
/// f = f_r (1 + ε_f n),   ψ_k = φ_k + ε_ψ max|φ| n      n standard normal, φ scaled to a largest entry of 1
/// ```
/// Faults act on φ before the noise, and on the list of modes after it. Rigid-body modes, and modes that no sensor sees, are left out.
///
/// * `origin` - how the numbers came about, for the file
///
/// # Errors
/// A sensor or fault that does not fit; numbers out of range; no mode in the band.
pub fn twin_modes(
    model: &dyn ParametricModel,
    theta: &[f64],
    sensors: &[Sensor],
    options: &TwinOptions,
    origin: &str,
) -> Result<TestData, TwinError> {
    check(options, sensors)?;
    let modes = modes_of(model, theta, options)?;
    let (low, high) = options.band_hz.unwrap_or((0.0, f64::INFINITY));
    let stated = observation_matrix_at(model, sensors, theta)? * &modes.shapes;
    // What no sensor sees but for rounding is not measured.
    let is_seen = |at: &DMatrix<f64>, r: usize| {
        sensors.is_empty() || at.column(r).amax() >= UNSEEN * modes.shapes.column(r).amax()
    };
    let in_band = |r: &usize| (low..=high).contains(&modes.frequency_hz(*r));
    let listed = modes.elastic().skip(modes.n_mechanism).filter(in_band).filter(|&r| is_seen(&stated, r));
    let listed: Vec<usize> = listed.take(options.n_modes).collect();
    let frequencies_hz: Vec<f64> = listed.iter().map(|&r| modes.frequency_hz(r)).collect();
    let faults = Inflicted::new(model, sensors, &options.faults, &frequencies_hz)?;
    let observed = faults.observe(model, theta, sensors)?;
    let mut at = &observed * &modes.shapes;
    let (first, mut hz) = (modes.n_rigid, modes.elastic().map(|r| modes.frequency_hz(r)).collect::<Vec<_>>());
    let coupled = if options.damping.is_none() { coupled_modes(model, theta, options.n_modes)? } else { None };
    if let Some(coupled) = &coupled {
        let mut elastic = at.columns(first, hz.len()).into_owned();
        coupled.put(&observed, &mut hz, &mut elastic);
        at.columns_mut(first, hz.len()).copy_from(&elastic);
    }
    faults.mix(&mut at, &listed, &frequencies_hz);
    let named = name_modes(model, theta, &modes)?;
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    rng.set_stream(MODES_STREAM);
    let origin = Origin::Synthetic(origin.to_string());
    let has_names = model.mirror().is_some();
    let mut ratios = damping(model, theta, &modes, options.damping)?.ratios;
    let constant = model.modal_damping().map_or(0.0, |zeta| zeta.at(theta));
    for r in modes.elastic() {
        if let Some(ratio) = coupled.as_ref().and_then(|c| c.ratio(r - first)) {
            ratios[r] = constant + ratio;
        }
    }
    let mut out = Vec::new();
    for r in listed.into_iter().filter(|&r| is_seen(&at, r)) {
        let f = hz[r - first];
        let column = at.column(r);
        let largest = column.iter().fold(0.0_f64, |a, v| if v.abs() > a.abs() { *v } else { a });
        let scale = if largest == 0.0 { 1.0 } else { largest };
        let frequency = f * (1.0 + options.frequency_noise * rng.normal());
        let damping = ratios[r] * (1.0 + options.damping_noise * rng.normal());
        let shape = DVector::from_fn(column.len(), |i, _| {
            Complex::new(column[i] / scale + options.shape_noise * faults.noise(i) * rng.normal(), 0.0)
        });
        let is_visible = shape.iter().any(|v| v.re != 0.0);
        out.push(TestMode {
            label: has_names.then(|| named[r].label.clone()),
            frequency_hz: measured(frequency, options.frequency_noise * f),
            damping_ratio: (ratios[r] >= LEAST_RATIO)
                .then(|| measured(damping.clamp(LEAST_RATIO, 0.99), options.damping_noise * ratios[r])),
            origin: origin.clone(),
            shape_sd: (is_visible && options.shape_noise > 0.0)
                .then(|| DVector::from_element(shape.len(), options.shape_noise)),
            shape: is_visible.then_some(shape),
            shape_origin: is_visible.then(|| origin.clone()),
            components: Vec::new(),
            standing: Standing::Open,
            space: None,
        });
    }
    if out.is_empty() {
        return Err(TwinError::Nothing("the model has no elastic mode in the band"));
    }
    out.sort_by(|a, b| a.frequency_hz.value.total_cmp(&b.frequency_hz.value));
    faults.put_into_list(&mut out)?;
    Ok(TestData {
        name: String::new(),
        description: String::new(),
        date: None,
        configuration: None,
        sensors: sensors.to_vec(),
        modes: out,
        mass_properties: Vec::new(),
        static_tests: Vec::new(),
        frfs: None,
        frf_fit: None,
        corrections: Vec::new(),
    })
}

/// Frequency response functions of a model at θ as an analyser would estimate them.
///
/// ```text
/// X = H F + rms(H) ε_x n_x,   F_m = F + ε_f n_f        F, n complex normal with E|.|² = 1, per line and average
/// H_1 = Σ X F_m* / Σ |F_m|²,   γ² = |Σ X F_m*|² / (Σ |X|² Σ |F_m|²)
/// ```
/// Without noise H itself, by superposition of all elastic modes (at most 400) and the rigid-body modes. The noise of the force
/// lowers H_1 by the factor 1/(1 + ε_f²), as it does in the laboratory.
///
/// # Errors
/// As [`twin_modes`]; lines that do not ascend from above 0 Hz.
pub fn twin_frfs(
    model: &dyn ParametricModel,
    theta: &[f64],
    sensors: &[Sensor],
    options: &TwinOptions,
    frf: &TwinFrfOptions,
) -> Result<FrfSet, TwinError> {
    check(options, sensors)?;
    for (what, value) in [("noise of the force", frf.force_noise), ("noise of the response", frf.response_noise)] {
        range(what, value, (0.0..10.0).contains(&value), "between 0 and 10")?;
    }
    range("number of averages", frf.n_averages as f64, (1..=10_000).contains(&frf.n_averages), "between 1 and 10000")?;
    let lines = &frf.lines_hz;
    if let Some(bad) =
        (0..lines.len()).find(|&l| !(lines[l].is_finite() && lines[l] > if l > 0 { lines[l - 1] } else { 0.0 }))
    {
        return Err(TwinError::Range {
            what: "a frequency line",
            value: lines[bad],
            expected: "above the one before and above 0",
        });
    }
    if lines.is_empty() || frf.exciters.is_empty() {
        return Err(TwinError::Nothing("functions need frequency lines and an exciter"));
    }
    let modes = modes(model, theta, MOST_MODES)?;
    let exciters = frf.exciters.iter().map(|name| index(sensors, name)).collect::<Result<Vec<_>, _>>()?;
    let forces: Vec<Sensor> = exciters.iter().map(|&i| sensors[i].clone()).collect();
    let listed = modes.elastic().skip(modes.n_mechanism);
    let frequencies_hz: Vec<f64> = listed.map(|r| modes.frequency_hz(r)).collect();
    let faults = Inflicted::new(model, sensors, &options.faults, &frequencies_hz)?;
    let responses = faults.observe(model, theta, sensors)?;
    let acting: Vec<Sensor> = exciters.iter().map(|&i| sensors[faults.acts_at(i)].clone()).collect();
    let references = observation_matrix_at(model, &acting, theta)?;
    let damping = damping(model, theta, &modes, options.damping)?;
    let h = synthesize(&modes, &damping, &responses, &references, lines, frf.quantity.order());
    let channel = |s: &Sensor| Channel { name: s.name.clone(), direction: Some(s.direction) };
    let mut set = FrfSet {
        quantity: frf.quantity,
        frequencies_hz: lines.clone(),
        references: forces.iter().map(channel).collect(),
        responses: sensors.iter().map(channel).collect(),
        h,
        coherence: None,
        n_averages: None,
    };
    faults.put_into_functions(&mut set, sensors);
    if frf.force_noise > 0.0 || frf.response_noise > 0.0 {
        estimate(&mut set, frf, &faults, options.seed);
    }
    Ok(set)
}

/// The sensor at which a force drives all modes of a band best, of those modes that any sensor sees.
///
/// [`rank_driving_points`] of the sensors; the first sensor where the band has no modes.
///
/// # Errors
/// As [`twin_frfs`].
pub fn driving_sensor(
    model: &dyn ParametricModel,
    theta: &[f64],
    sensors: &[Sensor],
    band_hz: (f64, f64),
) -> Result<usize, TwinError> {
    let options = TwinOptions { band_hz: Some(band_hz), ..TwinOptions::default() };
    let modes = modes_of(model, theta, &options)?;
    let observed = observation_matrix_at(model, sensors, theta)?;
    let in_band: Vec<usize> =
        modes.elastic().filter(|&r| (band_hz.0..=band_hz.1).contains(&modes.frequency_hz(r))).collect();
    let phi = observed * modes.shapes.select_columns(&in_band);
    // A mode that moves no sensor would choose by its rounding.
    let least = UNSEEN * phi.amax();
    let seen: Vec<usize> = (0..in_band.len()).filter(|&c| phi.column(c).amax() > least).collect();
    let omega_squared: Vec<f64> = seen.iter().map(|&c| modes.lambda[in_band[c]]).collect();
    let best = rank_driving_points(&phi.select_columns(&seen), &omega_squared);
    Ok(best.first().map_or(0, |p| p.candidate))
}

/// Replaces exact functions by estimates from noisy averages.
fn estimate(set: &mut FrfSet, frf: &TwinFrfOptions, faults: &Inflicted, seed: u64) {
    let (n_lines, n_responses) = (set.n_lines(), set.responses.len());
    let mut coherence = vec![1.0; set.h.len()];
    for reference in 0..set.references.len() {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(FRF_STREAM + reference as u64);
        let mut rms: Vec<f64> = (0..n_responses)
            .map(|k| {
                let power: f64 = (0..n_lines).map(|l| set.at(l, reference, k).norm_sqr()).sum();
                (power / n_lines as f64).sqrt()
            })
            .collect();
        // A dead channel has the noise of a typical one.
        let dead: Vec<bool> = (0..n_responses).map(|k| faults.is_silent(k)).collect();
        let mut alive: Vec<f64> = rms.iter().zip(&dead).filter(|(_, d)| !**d).map(|(r, _)| *r).collect();
        alive.sort_by(f64::total_cmp);
        let typical = alive.get(alive.len() / 2).copied().unwrap_or(1.0);
        rms.iter_mut().zip(&dead).filter(|(_, d)| **d).for_each(|(r, _)| *r = typical);
        let mut cross = vec![Complex::new(0.0, 0.0); n_responses];
        let mut auto = vec![0.0; n_responses];
        for line in 0..n_lines {
            cross.fill(Complex::new(0.0, 0.0));
            auto.fill(0.0);
            let mut force_power = 0.0;
            for _ in 0..frf.n_averages {
                let force = complex_normal(&mut rng);
                let measured = force + complex_normal(&mut rng) * frf.force_noise;
                force_power += measured.norm_sqr();
                for k in 0..n_responses {
                    let noise = complex_normal(&mut rng) * (frf.response_noise * faults.noise(k) * rms[k]);
                    let x = set.at(line, reference, k) * force + noise;
                    cross[k] += x * measured.conj();
                    auto[k] += x.norm_sqr();
                }
            }
            for k in 0..n_responses {
                let at = set.index(line, reference, k);
                set.h[at] = cross[k] / force_power;
                let product = auto[k] * force_power;
                coherence[at] = if product > 0.0 { cross[k].norm_sqr() / product } else { 0.0 };
            }
        }
    }
    // One average has coherence 1 whatever the noise, so it tells nothing.
    set.coherence = (frf.n_averages > 1).then_some(coherence);
    set.n_averages = Some(frf.n_averages);
}

/// Real and imaginary part with variance 1/2 each.
fn complex_normal(rng: &mut ChaCha8Rng) -> Complex<f64> {
    Complex::new(rng.normal(), rng.normal()) * std::f64::consts::FRAC_1_SQRT_2
}

fn measured(value: f64, sd: f64) -> Measured {
    Measured { value, sd, sd_is_default: sd <= 0.0 }
}

/// As many modes as are asked for; those up to the end of a band, and no more than twice as many.
fn modes_of(model: &dyn ParametricModel, theta: &[f64], options: &TwinOptions) -> Result<Modes, TwinError> {
    let Some((_, high)) = options.band_hz else { return modes(model, theta, options.n_modes) };
    let mut n = options.n_modes.max(FIRST_MODES);
    loop {
        let found = modes(model, theta, n.min(MOST_MODES))?;
        let is_all = found.elastic().len() < n || n >= MOST_MODES || found.is_empty();
        if is_all || found.frequency_hz(found.len() - 1) > high {
            return Ok(found);
        }
        n *= 2;
    }
}

fn modes(model: &dyn ParametricModel, theta: &[f64], n_elastic: usize) -> Result<Modes, TwinError> {
    let n_elastic = n_elastic.min(model.dof_map().n_dof());
    Ok(solve_modes(model, theta, SolveOptions { n_elastic, shift: None })?)
}

/// What dashpots make of the modes, where they couple them.
fn coupled_modes(model: &dyn ParametricModel, theta: &[f64], n_modes: usize) -> Result<Option<Damped>, TwinError> {
    let system = model.assemble_sparse(theta)?;
    if system.damping.is_none() {
        return Ok(None);
    }
    // As many as a comparison has.
    Ok(Damped::new(&Matrices::Sparse(system), &modes(model, theta, 2 * n_modes + 4)?))
}

/// The damping ratio of each mode: the one that is given, else what the model's own damping does in it.
///
/// ```text
/// ζ_r = ζ_0 + φ_rᵀ C φ_r / (2 ω_r)       φᵀ M φ = 1; rigid-body modes have none
/// ```
/// Of the uncoupled equations; modes that C couples have others.
fn damping(
    model: &dyn ParametricModel,
    theta: &[f64],
    modes: &Modes,
    given: Option<f64>,
) -> Result<ModalDamping, TwinError> {
    let uniform = |ratio| Ok(ModalDamping::uniform(modes.len(), ratio));
    if let Some(ratio) = given {
        return uniform(ratio);
    }
    let (c, constant) = (model.assemble_sparse(theta)?.damping, model.modal_damping().map(|zeta| zeta.at(theta)));
    let Some(c) = c else { return uniform(constant.unwrap_or(OWN_DAMPING)) };
    let work = c.mul(&modes.shapes);
    let ratio = |r: usize| {
        let omega = modes.lambda[r].max(0.0).sqrt();
        let is_rigid = r < modes.n_rigid + modes.n_mechanism;
        if is_rigid || omega == 0.0 {
            0.0
        } else {
            constant.unwrap_or(0.0) + modes.shapes.column(r).dot(&work.column(r)) / (2.0 * omega)
        }
    };
    let ratios: Vec<f64> = (0..modes.len()).map(ratio).collect();
    if let Some(worst) = ratios.iter().find(|z| !(0.0..1.0).contains(*z)) {
        let expected = "between 0 and 1 in every mode; give `--damping` for one ratio in all";
        return Err(TwinError::Range {
            what: "the damping ratio that the model gives a mode",
            value: *worst,
            expected,
        });
    }
    Ok(ModalDamping { ratios })
}

fn index(sensors: &[Sensor], name: &str) -> Result<usize, TwinError> {
    sensors.iter().position(|s| s.name == name).ok_or_else(|| TwinError::NoSensor {
        name: name.to_string(),
        suggestion: did_you_mean(name, sensors.iter().map(|s| s.name.as_str())),
    })
}

fn range(what: &'static str, value: f64, is_ok: bool, expected: &'static str) -> Result<(), TwinError> {
    if is_ok { Ok(()) } else { Err(TwinError::Range { what, value, expected }) }
}

fn check(options: &TwinOptions, sensors: &[Sensor]) -> Result<(), TwinError> {
    if sensors.is_empty() {
        return Err(TwinError::Nothing("there is no sensor"));
    }
    for (what, value) in [
        ("noise of frequencies", options.frequency_noise),
        ("noise of damping ratios", options.damping_noise),
        ("noise of shapes", options.shape_noise),
        ("damping", options.damping.unwrap_or(0.0)),
    ] {
        range(what, value, (0.0..1.0).contains(&value), "at least 0 and below 1")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
