//! Measured frequency response functions against those of the model.

use super::test_mode_name;
use crate::correlation::Misfit;
use crate::correlation::{
    CorrelationError, band_residuals, frac, frequency_shift, is_driving_point, local_amplitude, observation_matrix,
    signatures,
};
use crate::data::{Channel, FrfFit, FrfSet, Sensor, channel_sensor};
use crate::linalg::{Complex, DMatrix};
use crate::modal::{ModalDamping, SolveOptions, synthesize};
use crate::model::solve_modes;
use crate::objective::{Comparison, direct_responses, loss_factor};
use crate::update::Assessment;

/// How functions are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct FunctionsOptions {
    /// Bands to compare in, Hz, ascending; when empty, one around each test mode, up to halfway to the next.
    pub bands_hz: Vec<[f64; 2]>,
    /// Standard deviation of calibration and the like relative to the measured value, beside the random error that
    /// coherence and averages tell.
    pub relative_sd: f64,
    /// Damping ratio of model modes without a measured partner; the median of the measured ones when absent. A model with damping of
    /// its own uses that.
    pub damping: Option<f64>,
    /// Loss factor of the whole structure beside the model's own damping; the functions are then found line by line.
    pub loss_factor: Option<f64>,
    /// Largest relative shift of frequency that FDAC looks for.
    pub shift_window: f64,
}

impl Default for FunctionsOptions {
    /// 2 % of calibration error, shifts up to 20 %.
    fn default() -> Self {
        Self { bands_hz: Vec::new(), relative_sd: 0.02, damping: None, loss_factor: None, shift_window: 0.2 }
    }
}

impl FunctionsOptions {
    /// As the functions of a test file enter a fit: its bands, standard deviation and loss factor.
    pub fn of_fit(fit: &FrfFit) -> Self {
        Self {
            bands_hz: fit.bands_hz.clone(),
            relative_sd: fit.relative_sd,
            loss_factor: fit.loss_factor,
            ..Self::default()
        }
    }
}

/// Where the model's functions come from.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelFunctions {
    /// Superposed from so many elastic modes, with measured damping ratios, and one for modes without a measured partner.
    Superposed {
        /// Elastic modes.
        n_modes: usize,
        /// Ratio of the modes without a partner.
        damping: f64,
    },
    /// From K, M and the model's own C at every line, with a loss factor beside it.
    Direct {
        /// Whether the model has damping of its own.
        is_damped: bool,
        /// The loss factor.
        loss_factor: f64,
    },
}

/// One function over all lines.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ChannelAgreement {
    /// Point of excitation.
    pub reference: String,
    /// Point of response.
    pub response: String,
    /// Whether both are the same place and direction.
    pub is_driving_point: bool,
    /// FRAC, in [0, 1].
    pub frac: Option<f64>,
    /// Local amplitude criterion, mean over the lines, in [0, 1].
    pub amplitude: Option<f64>,
    /// Mean of 20 lg(|H_model|/|H_test|) over the bands, dB.
    pub amplitude_db: f64,
    /// Root mean square of the same, dB.
    pub amplitude_rms_db: f64,
    /// Against the stated noise, over the bands.
    pub misfit: Misfit,
}

/// All functions in one band.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BandAgreement {
    /// From (included) and to (excluded), Hz.
    pub band_hz: (f64, f64),
    /// The test modes in it.
    pub modes: Vec<String>,
    /// Mean CSAC over the lines.
    pub csac: Option<f64>,
    /// Mean CSF over the lines.
    pub csf: Option<f64>,
    /// Median FRAC of the functions, over the lines of the band.
    pub frac: Option<f64>,
    /// Mean of 20 lg(|H_model|/|H_test|), dB.
    pub amplitude_db: f64,
    /// Root mean square of the same, dB.
    pub amplitude_rms_db: f64,
    /// Mean phase difference, degrees.
    pub phase_deg: f64,
    /// Root mean square of the same, degrees.
    pub phase_rms_deg: f64,
    /// Against the stated noise.
    pub misfit: Misfit,
}

/// Frequency shift seen by FDAC from one reference.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ReferenceShift {
    /// Point of excitation.
    pub reference: String,
    /// f_model/f_test of the best common stretch.
    pub ratio: f64,
    /// Mean FDAC with that stretch.
    pub fdac: f64,
    /// Mean FDAC without.
    pub fdac_unshifted: f64,
    /// At the line nearest to every test mode: its frequency, the model's frequency of largest FDAC, and that FDAC.
    pub ridge: Vec<(f64, f64, f64)>,
}

/// Agreement of functions.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Functions {
    /// Reference by reference, response by response.
    pub channels: Vec<ChannelAgreement>,
    /// Band by band.
    pub bands: Vec<BandAgreement>,
    /// Reference by reference.
    pub shifts: Vec<ReferenceShift>,
    /// Line by line: frequency, CSAC, CSF.
    pub lines: Vec<(f64, Option<f64>, Option<f64>)>,
    /// Channels of the file that no sensor of the test has, left out.
    pub left_out: Vec<String>,
    /// Where the model's functions come from.
    pub model: ModelFunctions,
}

/// Functions are superposed from at most this many elastic modes.
const MOST_MODES: usize = 400;

/// Compares measured functions with those of the model at the θ of the assessment.
///
/// The model's functions come from K, M and C at every line where the model has damping of its own or a loss factor is given, and it is no
/// large sparse one; else they are superposed from its modes with modal damping: measured ratios for paired modes, one ratio for the
/// others. They have the quantity (receptance, mobility, accelerance), the lines and the directions of the file.
///
/// Errors: no channel is a sensor of the test; lengths that do not fit; a reference or all responses unknown.
pub fn compare_functions(
    comparison: &Comparison<'_>,
    a: &Assessment,
    measured: &FrfSet,
    options: &FunctionsOptions,
) -> Result<Functions, CorrelationError> {
    let sensors = &comparison.test().sensors;
    let (test, responses, references, left_out) = placed(measured, sensors)?;
    let model = comparison.model();
    let rows = |list: &[Sensor]| observation_matrix(model, list);
    let (h, source) = model_functions(comparison, a, &test, [&rows(&responses)?, &rows(&references)?], options)?;
    let model = FrfSet { h, coherence: None, n_averages: None, ..test.clone() };
    let bands_hz = bands(comparison, &test, &options.bands_hz)?;
    let lines = signatures(&model, &test)?;
    let (by_frac, by_amplitude) = (frac(&model, &test)?, local_amplitude(&model, &test)?);
    let residuals = band_residuals(&model, &test, &bands_hz, options.relative_sd)?;
    let (references, responses) = (names(&test.references), names(&test.responses));
    let channels = residuals
        .channels
        .iter()
        .enumerate()
        .map(|(c, r)| {
            let (reference, response) = (c / test.responses.len(), c % test.responses.len());
            ChannelAgreement {
                reference: references[reference].clone(),
                response: responses[response].clone(),
                is_driving_point: is_driving_point(&test, reference, response),
                frac: by_frac[c],
                amplitude: by_amplitude[c],
                amplitude_db: r.amplitude_db,
                amplitude_rms_db: r.amplitude_rms_db,
                misfit: r.misfit,
            }
        })
        .collect();
    let mut bands = Vec::new();
    for (&[low, high], r) in bands_hz.iter().zip(&residuals.bands).filter(|(_, r)| r.n_values > 0) {
        let inside = |f: f64| f >= low && f < high;
        let mean = |of: &dyn Fn(usize) -> Option<f64>| {
            let values: Vec<f64> = (0..lines.len()).filter(|&l| inside(lines[l].frequency_hz)).filter_map(of).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let mut fracs: Vec<f64> =
            frac(&within(&model, [low, high]), &within(&test, [low, high]))?.into_iter().flatten().collect();
        fracs.sort_by(f64::total_cmp);
        let modes = &comparison.test().modes;
        bands.push(BandAgreement {
            band_hz: (low, high),
            modes: (0..modes.len())
                .filter(|&i| inside(modes[i].frequency_hz.value))
                .map(|i| test_mode_name(comparison, i))
                .collect(),
            csac: mean(&|l| lines[l].shape),
            csf: mean(&|l| lines[l].scale),
            frac: fracs.get(fracs.len() / 2).copied(),
            amplitude_db: r.amplitude_db,
            amplitude_rms_db: r.amplitude_rms_db,
            phase_deg: r.phase_deg,
            phase_rms_deg: r.phase_rms_deg,
            misfit: r.misfit,
        });
    }
    let mut shifts = Vec::new();
    if test.responses.len() > 1 {
        for reference in 0..test.references.len() {
            let shift = frequency_shift(&model, &test, reference, options.shift_window)?;
            let last = test.frequencies_hz.last().copied().unwrap_or(0.0);
            let at = |f: f64| {
                let above = test.frequencies_hz.partition_point(|g| *g < f).min(test.n_lines() - 1);
                let lines = [above.saturating_sub(1), above];
                let line = if f - test.frequencies_hz[lines[0]] < test.frequencies_hz[lines[1]] - f {
                    lines[0]
                } else {
                    lines[1]
                };
                let inside = f <= last && f >= test.frequencies_hz[0];
                inside.then(|| (test.frequencies_hz[line], shift.ridge[line].0, shift.ridge[line].1))
            };
            shifts.push(ReferenceShift {
                reference: references[reference].clone(),
                ratio: shift.ratio,
                fdac: shift.fdac,
                fdac_unshifted: shift.fdac_unshifted,
                ridge: comparison.test().modes.iter().filter_map(|m| at(m.frequency_hz.value)).collect(),
            });
        }
    }
    let lines = lines.iter().map(|s| (s.frequency_hz, s.shape, s.scale)).collect();
    Ok(Functions { channels, bands, shifts, lines, left_out, model: source })
}

/// The model's functions at the lines of the test, in the layout of an [`FrfSet`], and where they come from.
///
/// * `rows` - of the responses and of the references, (n x n_dof) each
fn model_functions(
    comparison: &Comparison<'_>,
    a: &Assessment,
    test: &FrfSet,
    [responses, references]: [&DMatrix<f64>; 2],
    options: &FunctionsOptions,
) -> Result<(Vec<Complex<f64>>, ModelFunctions), CorrelationError> {
    let model = comparison.model();
    let order = test.quantity.order();
    let is_damped = comparison.is_damped();
    if (is_damped || options.loss_factor.is_some())
        && let Ok(system) = model.assemble(&a.theta)
    {
        let loss_factor = loss_factor(model, &a.theta, options.loss_factor.unwrap_or(0.0));
        let h = direct_responses(&system, [responses, references], &test.frequencies_hz, order, loss_factor)
            .map_err(|e| CorrelationError::Model(e.to_string()))?;
        return Ok((h, ModelFunctions::Direct { is_damped, loss_factor }));
    }
    let p = &a.prediction;
    let n_elastic = MOST_MODES.min(model.dof_map().n_dof());
    let shift = p.modes.lambda.get(p.modes.n_rigid).copied().filter(|l| *l > 0.0);
    let modes = solve_modes(model, &a.theta, SolveOptions { n_elastic, shift })
        .map_err(|e| CorrelationError::Model(e.to_string()))?;
    let (ratios, damping) = damping(comparison, a, modes.len(), modes.n_rigid, options.damping);
    let h = synthesize(&modes, &ModalDamping { ratios }, responses, references, &test.frequencies_hz, order);
    Ok((h, ModelFunctions::Superposed { n_modes: modes.elastic().len(), damping }))
}

/// The names of channels, with their directions where one name has several.
fn names(channels: &[Channel]) -> Vec<String> {
    let is_shared = |c: &Channel| channels.iter().filter(|other| other.name == c.name).count() > 1;
    channels.iter().map(|c| if is_shared(c) { c.label() } else { c.name.clone() }).collect()
}

type Placed = (FrfSet, Vec<Sensor>, Vec<Sensor>, Vec<String>);

/// The functions whose channels are known, with their sensors; and the channels left out.
fn placed(set: &FrfSet, sensors: &[Sensor]) -> Result<Placed, CorrelationError> {
    let find =
        |channels: &[Channel]| -> Vec<Option<Sensor>> { channels.iter().map(|c| channel_sensor(c, sensors)).collect() };
    let (responses, references) = (find(&set.responses), find(&set.references));
    let kept = |found: &[Option<Sensor>]| (0..found.len()).filter(|&i| found[i].is_some()).collect::<Vec<_>>();
    let (kept_responses, kept_references) = (kept(&responses), kept(&references));
    for (what, channels, known) in
        [("response", &set.responses, &kept_responses), ("excitation", &set.references, &kept_references)]
    {
        if known.is_empty() {
            let names: Vec<&str> = channels.iter().take(5).map(|c| c.name.as_str()).collect();
            return Err(CorrelationError::NoChannel { what, names: names.join(", ") });
        }
    }
    let mut left_out = Vec::new();
    for (channels, found) in [(&set.responses, &responses), (&set.references, &references)] {
        for (channel, _) in channels.iter().zip(found).filter(|(_, f)| f.is_none()) {
            if !left_out.contains(&channel.name) {
                left_out.push(channel.name.clone());
            }
        }
    }
    let indices: Vec<usize> = (0..set.n_lines())
        .flat_map(|line| kept_references.iter().map(move |&r| (line, r)))
        .flat_map(|(line, r)| kept_responses.iter().map(move |&s| set.index(line, r, s)))
        .collect();
    let pick = |channels: &[Channel], kept: &[usize]| kept.iter().map(|&i| channels[i].clone()).collect();
    let subset = FrfSet {
        references: pick(&set.references, &kept_references),
        responses: pick(&set.responses, &kept_responses),
        h: indices.iter().map(|&i| set.h[i]).collect(),
        coherence: set.coherence.as_ref().map(|c| indices.iter().map(|&i| c[i]).collect()),
        ..set.clone()
    };
    Ok((subset, responses.into_iter().flatten().collect(), references.into_iter().flatten().collect(), left_out))
}

/// One ratio a mode, rigid-body modes first: measured ones where paired; and the ratio of the others.
fn damping(
    comparison: &Comparison<'_>,
    a: &Assessment,
    n_modes: usize,
    n_rigid: usize,
    given: Option<f64>,
) -> (Vec<f64>, f64) {
    /// Where nothing was measured or said.
    const USUAL: f64 = 0.01;
    let modes = &comparison.test().modes;
    let mut known: Vec<f64> = modes.iter().filter_map(|m| m.damping_ratio.map(|d| d.value)).collect();
    known.sort_by(f64::total_cmp);
    let other = given.unwrap_or_else(|| known.get(known.len() / 2).copied().unwrap_or(USUAL));
    let mut ratios = vec![other; n_modes];
    for p in &a.pairs {
        if let (Some(d), Some(ratio)) = (modes[p.test_mode].damping_ratio, ratios.get_mut(n_rigid + p.model_mode)) {
            *ratio = d.value;
        }
    }
    (ratios, other)
}

/// The bands that are given, else one around each test mode, up to halfway to the next, over the lines of the file.
fn bands(comparison: &Comparison<'_>, set: &FrfSet, given: &[[f64; 2]]) -> Result<Vec<[f64; 2]>, CorrelationError> {
    let (Some(first), Some(last)) = (set.frequencies_hz.first().copied(), set.frequencies_hz.last().copied()) else {
        return Ok(Vec::new());
    };
    if !given.is_empty() {
        if !given.iter().any(|[low, high]| set.frequencies_hz.iter().any(|f| f >= low && f < high)) {
            let text = format!("no line of the functions lies in the bands; they reach from {first} Hz to {last} Hz");
            return Err(CorrelationError::Model(text));
        }
        return Ok(given.to_vec());
    }
    let last = last * (1.0 + 1e-9);
    let inside: Vec<f64> =
        comparison.test().modes.iter().map(|m| m.frequency_hz.value).filter(|f| *f >= first && *f <= last).collect();
    let mut edges = vec![first];
    edges.extend(inside.windows(2).map(|w| 0.5 * (w[0] + w[1])).filter(|f| *f > first && *f < last));
    edges.push(last);
    Ok(edges.windows(2).map(|e| [e[0], e[1]]).collect())
}

/// The lines of a set inside a band.
fn within(set: &FrfSet, [low, high]: [f64; 2]) -> FrfSet {
    let lines: Vec<usize> =
        (0..set.n_lines()).filter(|&l| set.frequencies_hz[l] >= low && set.frequencies_hz[l] < high).collect();
    let channels = set.references.len() * set.responses.len();
    let h = lines.iter().flat_map(|&l| set.h[l * channels..(l + 1) * channels].iter().copied()).collect();
    FrfSet {
        frequencies_hz: lines.iter().map(|&l| set.frequencies_hz[l]).collect(),
        h,
        coherence: None,
        n_averages: None,
        ..set.clone()
    }
}
