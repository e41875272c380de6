//! One comparison of a model with a test, as tables and reports show it.

use super::UpdateError;
use crate::correlation::{CorrelationError, Misfit, PairFlag};
use crate::data::{Standing, StaticReading, StaticTest, TestMode};
use crate::linalg::DMatrix;
use crate::modal::Modes;
use crate::model::{MassProperties, ModeLabel, ModelError, ParametricModel, label_modes};
use crate::objective::{Comparison, LeastSquares, PaperCost, Prediction, static_readings, why_unpaired};

/// A mode of the model with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeName {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Its name, such as `Sym 1st Bending`; `mode 4` where the model cannot tell.
    pub label: String,
    /// `S1B`
    pub short: String,
    /// `symmetric`, `antisymmetric`, or `None`.
    pub family: Option<&'static str>,
    /// Share of strain energy in torsion, where the model can tell.
    pub torsion: Option<f64>,
}

/// A test mode with its partner in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct AssessedPair {
    /// Index in the test, by ascending frequency.
    pub test_mode: usize,
    /// Index among the elastic modes of the model.
    pub model_mode: usize,
    /// Measured frequency, Hz.
    pub test_hz: f64,
    /// Frequency of the model, Hz.
    pub model_hz: f64,
    /// 100 (model - test)/test.
    pub error_percent: f64,
    /// MAC, where the test has a shape.
    pub mac: Option<f64>,
    /// The test's name for the mode.
    pub test_label: Option<String>,
    /// The model's name for the mode.
    pub model_label: String,
    /// What is odd about it.
    pub flags: Vec<PairFlag>,
    /// Probability of the pair, where it was inferred; of one that the test file names, by what is measured alone.
    pub probability: Option<f64>,
    /// Whether the test file names it (`pair_with`).
    pub by_user: bool,
}

impl AssessedPair {
    /// What speaks against a pair that the test file names, where what is measured does.
    pub fn doubt(&self) -> Option<String> {
        let p = self.probability.filter(|p| self.by_user && *p < 0.5)?;
        let mac = self.mac.map_or_else(String::new, |m| format!("their MAC is {m:.2} and "));
        Some(format!(
            "`pair_with` pairs test mode {} at {:.4} Hz with {} at {:.4} Hz: {mac}the frequency is {:+.1} % off; by what is measured the pair has a probability of {}",
            self.test_mode + 1,
            self.test_hz,
            self.model_label,
            self.model_hz,
            self.error_percent,
            if p < 1e-3 { "less than 0.001".to_string() } else { format!("{p:.3}") }
        ))
    }
}

/// A mode without a partner.
#[derive(Debug, Clone, PartialEq)]
pub struct UnpairedMode {
    /// Its index in its own list.
    pub mode: usize,
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its name.
    pub label: Option<String>,
    /// The largest MAC with any mode of the other list, and that mode.
    pub best: Option<(usize, f64)>,
    /// Why a test mode has no partner.
    pub reason: Option<String>,
    /// Probability that a test mode is not of the structure, where that was inferred.
    pub foreign: Option<f64>,
    /// Whether the user has left it out, or said that it is foreign.
    pub by_user: bool,
}

/// A reading of a static test beside the model's.
#[derive(Debug, Clone, PartialEq)]
pub struct AssessedReading {
    /// The static test.
    pub test: String,
    /// The sensor.
    pub sensor: String,
    /// Whether it is an angle, rad, instead of a deflection, m.
    pub is_angle: bool,
    /// What was read.
    pub measured: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// What the model gives.
    pub model: f64,
}

/// How the amplitudes of frequency response functions agree, where the test says how they enter a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssessedFunctions {
    /// Number of values in the chosen bands.
    pub n_values: usize,
    /// Σ (ln(|H_model|/|H_test|)/σ)².
    pub chi_squared: f64,
}

/// A comparison at one θ.
#[derive(Debug, Clone)]
pub struct Assessment {
    /// θ.
    pub theta: Vec<f64>,
    /// Pairs, by ascending test frequency.
    pub pairs: Vec<AssessedPair>,
    /// Test modes without a partner.
    pub unpaired_test: Vec<UnpairedMode>,
    /// Model modes without a partner, below 1.2 times the highest test frequency.
    pub unpaired_model: Vec<UnpairedMode>,
    /// Pairs, by position, that come in another order in the model than in the test.
    pub swapped: Vec<(usize, usize)>,
    /// Names and frequencies of the elastic modes of the model.
    pub model_modes: Vec<ModeName>,
    /// Readings of static tests.
    pub readings: Vec<AssessedReading>,
    /// Frequency response functions.
    pub functions: Option<AssessedFunctions>,
    /// MAC, rows elastic modes, columns test modes.
    pub mac: DMatrix<f64>,
    /// Equation (4) of Gupta et al. divided by 2n.
    pub paper_cost: f64,
    /// Norm of the relative frequency errors.
    pub frequency_norm: f64,
    /// Half the sum of squared residuals over their standard deviations.
    pub cost: f64,
    /// The residuals of frequencies, shapes, static readings and functions against what noise alone would give.
    pub misfit: Misfit,
    /// The share of each test mode in it: its frequency and its shape.
    pub misfit_per_mode: Vec<f64>,
    /// Mass properties of the model.
    pub mass_properties: Option<MassProperties>,
    /// The whole prediction.
    pub prediction: Prediction,
}

/// Names the modes of a model by energy and symmetry, elastic modes counted from one.
pub fn name_modes(model: &dyn ParametricModel, theta: &[f64], modes: &Modes) -> Result<Vec<ModeName>, ModelError> {
    let mut characters = model.characters(theta, &modes.shapes, modes.n_rigid)?;
    for c in characters.iter_mut().flat_map(|all| all.iter_mut().skip(modes.n_rigid).take(modes.n_mechanism)) {
        c.is_mechanism = true;
    }
    let labels: Option<Vec<ModeLabel>> = characters.as_deref().map(label_modes);
    Ok((0..modes.len())
        .map(|i| {
            let (label, short, family) = match &labels {
                Some(l) => (l[i].long.clone(), l[i].short.clone(), l[i].family),
                None => (format!("mode {}", i + 1), (i + 1).to_string(), None),
            };
            // What kind of strain a superelement has is not known.
            let torsion = characters.as_ref().map(|c| &c[i]).filter(|c| c.matrices == 0.0).map(|c| c.torsion);
            ModeName { frequency_hz: modes.frequency_hz(i), label, short, family, torsion }
        })
        .collect())
}

/// Probability of an inferred pair from which a second shape that is as like as the first leaves no doubt.
const DECIDED: f64 = 0.99;

/// Compares at θ.
pub fn assess(comparison: &Comparison<'_>, theta: &[f64]) -> Result<Assessment, UpdateError> {
    let prediction = comparison.predict_anew(theta)?;
    let model = comparison.model();
    let test = comparison.test();
    let named = name_modes(model, theta, &prediction.modes).map_err(|e| CorrelationError::Model(e.to_string()))?;
    let model_modes = named[prediction.modes.n_rigid..].to_vec();
    let pairs: Vec<AssessedPair> = prediction
        .pairs
        .pairs
        .iter()
        .map(|p| {
            let mode = &test.modes[p.experimental];
            let test_hz = mode.frequency_hz.value;
            let model_hz = prediction.frequencies_hz[p.analytical];
            let probability = match &mode.standing {
                // Of the pair that was inferred: a fit may have paired the mode anew since, unless it has followed it.
                Standing::Found { model_mode, probability, reference, .. }
                    if *model_mode == p.analytical || reference.is_some() =>
                {
                    Some(*probability)
                }
                _ => None,
            };
            // Without a shape there is no MAC to be low or ambiguous, and what the frequencies have decided is not.
            let flags = p
                .flags
                .iter()
                .copied()
                .filter(|f| mode.shape.is_some() || !matches!(f, PairFlag::LowMac | PairFlag::Ambiguous))
                .filter(|f| *f != PairFlag::Ambiguous || probability.is_none_or(|p| p < DECIDED))
                .collect();
            AssessedPair {
                test_mode: p.experimental,
                model_mode: p.analytical,
                test_hz,
                model_hz,
                error_percent: 100.0 * (model_hz - test_hz) / test_hz,
                mac: mode.shape.as_ref().map(|_| p.mac),
                test_label: mode.label.clone(),
                model_label: model_modes[p.analytical].label.clone(),
                flags,
                probability,
                by_user: mode.standing.is_named(),
            }
        })
        .collect();
    let mac = comparison.mac_of_all(&prediction);
    let best = |values: &mut dyn Iterator<Item = f64>| values.enumerate().max_by(|x, y| x.1.total_cmp(&y.1));
    let unpaired_test = prediction
        .pairs
        .unpaired_experimental
        .iter()
        .map(|u| UnpairedMode {
            mode: u.index,
            frequency_hz: test.modes[u.index].frequency_hz.value,
            label: test.modes[u.index].label.clone(),
            best: best(&mut mac.column(u.index).iter().copied()).filter(|_| test.modes[u.index].shape.is_some()),
            reason: Some(
                test.modes[u.index].standing.reason().unwrap_or_else(|| why_unpaired(comparison, &prediction, u.index)),
            ),
            foreign: match test.modes[u.index].standing {
                Standing::Aside { foreign, .. } => foreign,
                _ => None,
            },
            by_user: test.modes[u.index].standing.is_left_out(),
        })
        .collect();
    let highest = test.modes.iter().map(|m| m.frequency_hz.value).fold(0.0, f64::max);
    let unpaired_model = prediction
        .pairs
        .unpaired_analytical
        .iter()
        .filter(|u| prediction.frequencies_hz[u.index] <= 1.2 * highest)
        .map(|u| UnpairedMode {
            mode: u.index,
            frequency_hz: prediction.frequencies_hz[u.index],
            label: Some(model_modes[u.index].label.clone()),
            best: best(&mut mac.row(u.index).iter().copied()),
            reason: None,
            foreign: None,
            by_user: false,
        })
        .collect();
    let least_squares = LeastSquares::new(comparison);
    let residuals = least_squares.residuals_of(theta, &prediction);
    let frequency_norm = pairs.iter().map(|p| (p.error_percent / 100.0).powi(2)).sum::<f64>().sqrt();
    let readings = readings(comparison, &prediction);
    let of_functions = &residuals.as_slice()[least_squares.rows_of("frf-log")];
    let functions = (!of_functions.is_empty()).then(|| AssessedFunctions {
        n_values: of_functions.len(),
        chi_squared: of_functions.iter().map(|r| r * r).sum(),
    });
    let components = &residuals.as_slice()[least_squares.rows_of("shape-components")];
    let further = (readings.as_slice(), components, functions);
    let misfit = misfit(comparison, &prediction, residuals.as_slice(), further)?;
    let misfit_per_mode = misfit_per_mode(comparison, residuals.as_slice());
    Ok(Assessment {
        theta: theta.to_vec(),
        swapped: prediction.pairs.swapped.clone(),
        paper_cost: PaperCost::new(comparison).cost_of(&prediction),
        frequency_norm,
        cost: 0.5 * residuals.norm_squared(),
        misfit,
        misfit_per_mode,
        mass_properties: prediction.mass_properties,
        mac,
        pairs,
        unpaired_test,
        unpaired_model,
        model_modes,
        readings,
        functions,
        prediction,
    })
}

/// Frequencies and shapes come first among the residuals; each shape has one free scale, shapes turned to the test free angles.
fn misfit(
    comparison: &Comparison<'_>,
    prediction: &Prediction,
    residuals: &[f64],
    (readings, components, functions): (&[AssessedReading], &[f64], Option<AssessedFunctions>),
) -> Result<Misfit, CorrelationError> {
    let test = comparison.test();
    let n_modes = test.modes.len();
    let shapes = comparison.shapes();
    // A mode that is aside is not a datum; the shapes of such modes are blank here.
    let is_used = |m: &&TestMode| !m.standing.is_aside();
    let measured = shapes.iter().filter(|v| !v.is_nan()).count();
    let n_used = test.modes.iter().filter(is_used).count();
    let with_shape = test.modes.iter().filter(is_used).filter(|m| m.shape.is_some()).count();
    let n_rows = n_modes + if comparison.has_shapes() { shapes.len() } else { 0 };
    let of_modes: f64 = residuals[..n_rows].iter().map(|r| r * r).sum();
    let of_readings: f64 = readings.iter().map(|r| ((r.model - r.measured) / r.sd).powi(2)).sum();
    let n_angles = prediction.n_free_angles(|mode| test.modes[mode].shape.is_some());
    let n_of_modes = (n_used + measured).saturating_sub(with_shape + n_angles);
    let (of_functions, n_of_functions) = functions.map_or((0.0, 0), |f| (f.chi_squared, f.n_values));
    let of_components: f64 = components.iter().map(|r| r * r).sum();
    let chi_squared = of_modes + of_readings + of_components + of_functions;
    Misfit::new(chi_squared, n_of_modes + readings.len() + components.len() + n_of_functions)
}

fn readings(comparison: &Comparison<'_>, prediction: &Prediction) -> Vec<AssessedReading> {
    let test = comparison.test();
    let measured = test.static_tests.iter().flat_map(|t| t.readings.iter().map(move |r| (t, r)));
    let one = |((t, r), model): ((&StaticTest, &StaticReading), f64)| AssessedReading {
        test: t.name.clone(),
        sensor: test.sensors[r.sensor].name.clone(),
        is_angle: test.sensors[r.sensor].is_rotation,
        measured: r.measured.value,
        sd: r.measured.sd,
        model,
    };
    measured.zip(static_readings(comparison, prediction)).map(one).collect()
}

fn misfit_per_mode(comparison: &Comparison<'_>, residuals: &[f64]) -> Vec<f64> {
    let n_modes = comparison.test().modes.len();
    let n_sensors = if comparison.has_shapes() { comparison.shapes().nrows() } else { 0 };
    let square = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>();
    (0..n_modes)
        .map(|i| square(&residuals[i..=i]) + square(&residuals[n_modes + i * n_sensors..n_modes + (i + 1) * n_sensors]))
        .collect()
}
