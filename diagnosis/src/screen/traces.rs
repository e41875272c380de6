//! What a fault of the measurement would change at a fit, by re-weighting rows: its screening.

use crate::error::DiagnosisError;
use crate::problem::fit::{Fit, project, shape_rows};
use crate::problem::prior::Prior;
use crate::problem::rows::Posed;
use crate::problem::scene::Scene;
use crate::thresholds::VISIBLE;
use crate::until::Until;
use rayon::prelude::*;
use retune::data::Sensor;
use retune::fault::{At, Faults, Number, PlacedFault};
use retune::linalg::{Complex, DMatrix, DVector};

/// What a fault explains at the base fit.
#[derive(Debug, Clone)]
pub(crate) enum Trace {
    /// A fixed change δ of the residual: T = -2 δ'·r' - |δ'|².
    Fixed(DVector<f64>),
    /// A direction with a free multiple.
    Free(DVector<f64>),
    /// The rows of one sensor, for a noisy one.
    Block(Vec<usize>),
    /// Rows that are replaced: cost before minus cost as noise alone. Holds rows and the readings over their σ.
    Replaced(Vec<usize>, Vec<f64>),
}

/// Step of differences: rows are nearly linear in ln g and in angles; those of functions are, those of shapes in g.
const STEP: f64 = 1e-4;

/// What each fault would change at the fit; `None` where the model cannot tell (it has no motion in that direction), and where there was no time: with
/// functions each takes a sweep over their lines.
pub(crate) fn traces(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    faults: &[PlacedFault],
    until: &Until,
) -> Vec<Option<Trace>> {
    let may = || !scene.has_functions() || !until.is_over();
    faults.par_iter().map(|fault| may().then(|| trace(scene, fit, weight, fault)).flatten()).collect()
}

/// Modes in which the sensor of a fault counts at a fit.
fn measured_modes(scene: &Scene, fit: &Fit, fault: &PlacedFault) -> Vec<usize> {
    let of_tests = (0..scene.cases.len()).filter(|&k| fault.is_in(k)).flat_map(|k| scene.cases[k].modes());
    let sensor = fault.at.sensor();
    of_tests.filter(|&m| fit.inverse_sd[(sensor, m)] > 0.0 && !fit.unpaired.contains(&m)).collect()
}

/// What the sensors that a fault has moved or turned would read of the modes of the model: the sensor, and a reading for every mode. `None` where
/// nothing moves one of them.
fn readings_in_truth(scene: &Scene, fit: &Fit, fault: &PlacedFault, number: f64) -> Option<Vec<(usize, Vec<f64>)>> {
    let stated = &scene.test.sensors;
    let sensors = fault.sensors_in_truth(stated, number);
    let moved = (0..sensors.len()).filter(|&s| sensors[s] != stated[s]);
    moved.map(|s| Some((s, readings_of(scene, fit, fault, (s, &sensors[s]))?))).collect()
}

/// What a sensor reads of the modes of the model; `None` where nothing moves it.
fn readings_of(scene: &Scene, fit: &Fit, fault: &PlacedFault, (s, sensor): (usize, &Sensor)) -> Option<Vec<f64>> {
    let mut readings = vec![0.0; fit.rows.n_modes];
    let mut moves = false;
    let having = scene.cases.iter().enumerate().filter(|(k, c)| fault.is_in(*k) && c.sensors.contains(&s));
    for (_, case) in having {
        let row = case.observe(std::slice::from_ref(sensor)).ok()?;
        moves |= row.amax() > 0.0;
        case.modes().for_each(|m| readings[m] = (&row * &fit.modes_at[m])[0]);
    }
    moves.then_some(readings)
}

/// Every fault that the test could show at a fit.
pub(crate) fn faults_at(scene: &Scene, fit: &Fit, faults: &Faults) -> Vec<PlacedFault> {
    let all = faults.placed(&scene.bench());
    all.into_par_iter().filter(|fault| !reads_noise_only(scene, fit, fault)).collect()
}

/// Whether a sensor along another axis would read noise only, less than three standard deviations in all modes together: it cannot be told
/// from a dead one, and that is what it is called.
fn reads_noise_only(scene: &Scene, fit: &Fit, fault: &PlacedFault) -> bool {
    const SEEN: f64 = 9.0;
    let At::Axis(s, _) = fault.at else { return false };
    if fault.number() != Number::None || scene.has_functions() {
        return false;
    }
    let modes = measured_modes(scene, fit, fault);
    if modes.is_empty() {
        return false;
    }
    let Some(readings) = readings_in_truth(scene, fit, fault, fault.number().neutral()) else { return true };
    let signal = |&m: &usize| {
        let mut mode = ReadMode::of(fit, m);
        for (s, of_modes) in &readings {
            mode.model[*s] = of_modes[m];
        }
        (mode.rows()[s] + mode.test[s] * mode.inverse_sd[s]).powi(2)
    };
    modes.iter().map(signal).sum::<f64>() < SEEN
}

/// What the model and the test have of a mode at all sensors, and 1/σ.
struct ReadMode {
    model: Vec<f64>,
    test: Vec<f64>,
    inverse_sd: Vec<f64>,
}

impl ReadMode {
    fn of(fit: &Fit, mode: usize) -> Self {
        let column = |a: &DMatrix<f64>| -> Vec<f64> { a.column(mode).iter().copied().collect() };
        Self { model: column(&fit.shapes), test: column(&fit.test_shapes), inverse_sd: column(&fit.inverse_sd) }
    }

    /// Its weighted residual, with its free scale.
    fn rows(&self) -> Vec<f64> {
        shape_rows(&self.model, &self.test, &self.inverse_sd)
    }

    /// Without a fault of its test.
    fn without(mut self, fault: &PlacedFault, number: f64) -> Self {
        let mut shape: Vec<Complex<f64>> = self.test.iter().map(|t| Complex::new(*t, 0.0)).collect();
        let mut sd: Vec<f64> = self.inverse_sd.iter().map(|w| w.recip()).collect();
        fault.fault.shape(&fault.at, number, &mut shape, Some(&mut sd));
        self.test = shape.iter().map(|t| t.re).collect();
        self.inverse_sd = sd.iter().map(|sd| sd.recip()).collect();
        self
    }
}

fn trace(scene: &Scene, fit: &Fit, weight: f64, fault: &PlacedFault) -> Option<Trace> {
    let number = fault.number();
    let is_of_functions = !fault.at.is_of_channels() && fault.at.modes().is_empty();
    match number {
        Number::Mixture => return when_taken_out(scene, fit, weight, fault).ok(),
        Number::None if is_of_functions => return when_taken_out(scene, fit, weight, fault).ok(),
        Number::Factor { .. } | Number::Angle { .. } if is_of_functions || scene.has_functions() => {
            return number_slope(scene, fit, weight, fault, number.neutral()).ok().map(Trace::Free);
        }
        Number::Frequency { .. } => return of_frequency(scene, fit, weight, fault),
        _ if !fault.at.is_of_channels() => return of_mode_list(scene, fit, weight, fault),
        _ => {}
    }
    let (rows, s) = (fit.rows, fault.at.sensor());
    let measured = measured_modes(scene, fit, fault);
    if measured.is_empty() {
        return None;
    }
    let own_rows = || measured.iter().map(|&m| rows.shape(m, s)).collect();
    match number {
        Number::Scatter => return Some(Trace::Block(own_rows())),
        Number::Silence => {
            let reading = |&m: &usize| weight * fit.test_shapes[(s, m)] * fit.inverse_sd[(s, m)];
            return Some(Trace::Replaced(own_rows(), measured.iter().map(reading).collect()));
        }
        _ => {}
    }
    // A factor is looked at in its logarithm.
    let moved = match number {
        Number::Factor { .. } => STEP.exp(),
        Number::Angle { .. } => STEP,
        _ => number.neutral(),
    };
    let is_free = number != Number::None;
    let elsewhere = readings_in_truth(scene, fit, fault, moved)?;
    let mut delta = DVector::zeros(fit.r.len());
    for &m in &measured {
        let mut mode = ReadMode::of(fit, m);
        let before = is_free.then(|| mode.rows());
        for (s, readings) in &elsewhere {
            mode.model[*s] = readings[m];
        }
        for (k, v) in mode.without(fault, moved).rows().into_iter().enumerate() {
            let row = rows.shape(m, k);
            delta[row] = match &before {
                Some(before) => weight * (v - before[k]) / STEP,
                None => weight * v - fit.r[row],
            };
        }
    }
    let is_seen = delta.norm() > VISIBLE;
    is_seen.then_some(if is_free { Trace::Free(delta) } else { Trace::Fixed(delta) })
}

/// What a fault changes in the frequencies of the list.
fn of_mode_list(scene: &Scene, fit: &Fit, weight: f64, fault: &PlacedFault) -> Option<Trace> {
    let mut modes = scene.test.modes.clone();
    fault.fault.modes(&fault.at, fault.number().neutral(), &mut modes);
    let mut delta = DVector::zeros(fit.r.len());
    for m in fault.at.modes() {
        let f = modes[m].frequency_hz;
        delta[m] = weight * (fit.frequencies[m] - f.value) / f.sd - fit.r[m];
    }
    delta.iter().all(|v| v.is_finite()).then_some(Trace::Fixed(delta))
}

/// ∂r/∂ln g of a factor on a frequency.
fn of_frequency(scene: &Scene, fit: &Fit, weight: f64, fault: &PlacedFault) -> Option<Trace> {
    let mut delta = DVector::zeros(fit.r.len());
    for m in fault.at.modes() {
        let f = scene.test.modes[m].frequency_hz;
        delta[m] = weight * f.value / f.sd;
    }
    fault.at.modes().iter().all(|&m| fit.frequencies[m].is_finite()).then_some(Trace::Free(delta))
}

/// What the rows become without a fault, at the parameters of a fit.
fn when_taken_out(scene: &Scene, fit: &Fit, weight: f64, fault: &PlacedFault) -> Result<Trace, DiagnosisError> {
    let delta = corrected_rows(scene, fit, weight, fault, fault.number().neutral())? - &fit.r;
    Ok(Trace::Fixed(of_measured(fit, delta)))
}

/// ∂r/∂ln g of a factor, or ∂r/∂α of an angle, at a fit whose test it has corrected by `number`.
pub(crate) fn number_slope(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    fault: &PlacedFault,
    number: f64,
) -> Result<DVector<f64>, DiagnosisError> {
    let is_factor = matches!(fault.number(), Number::Factor { .. });
    let moved = |h: f64| if is_factor { number * h.exp() } else { number + h };
    let [above, below] = [STEP, -STEP].map(|h| corrected_rows(scene, fit, weight, fault, moved(h)));
    Ok(of_measured(fit, (above? - below?) / (2.0 * STEP)))
}

/// The rows at the parameters of a fit, of tests that a fault has corrected.
fn corrected_rows(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    fault: &PlacedFault,
    number: f64,
) -> Result<DVector<f64>, DiagnosisError> {
    let changed = scene.corrected(fault, number);
    let comparisons = changed.comparisons()?;
    let posed = Posed::new(&changed, &comparisons, vec![Prior::NONE; fit.x.len()], weight);
    Ok(posed.data_rows(&fit.theta)?)
}

/// Zero beyond the measured rows.
fn of_measured(fit: &Fit, mut rows: DVector<f64>) -> DVector<f64> {
    let measured = fit.rows.measured;
    rows.rows_mut(measured, rows.len() - measured).fill(0.0);
    rows
}

impl Trace {
    /// The same with the base projected out.
    pub(crate) fn projected(&self, q: &DMatrix<f64>) -> Self {
        match self {
            Trace::Fixed(d) => Trace::Fixed(project(q, d)),
            Trace::Free(d) => Trace::Free(project(q, d)),
            other => other.clone(),
        }
    }

    /// Twice the gain of log-likelihood for a projected residual, numbers at their best values.
    pub(crate) fn score(&self, r: &DVector<f64>) -> f64 {
        match self {
            Trace::Fixed(d) | Trace::Free(d) => self.score_along(d.dot(r), d.norm_squared()),
            Trace::Block(rows) => {
                let m = rows.len() as f64;
                let sum: f64 = rows.iter().map(|&i| r[i] * r[i]).sum();
                if sum > m { sum - m - m * (sum / m).ln() } else { 0.0 }
            }
            Trace::Replaced(rows, readings) => {
                let now: f64 = rows.iter().map(|&i| r[i] * r[i]).sum();
                (now - readings.iter().map(|v| v * v).sum::<f64>()).max(0.0)
            }
        }
    }

    /// What a residual is asked for along, where its score follows from that product alone.
    pub(crate) fn direction(&self) -> Option<&DVector<f64>> {
        match self {
            Trace::Fixed(d) | Trace::Free(d) => Some(d),
            Trace::Block(_) | Trace::Replaced(..) => None,
        }
    }

    /// The score by the product of a residual with [`Self::direction`].
    ///
    /// * `own` - |direction|²
    pub(crate) fn score_along(&self, along: f64, own: f64) -> f64 {
        match self {
            Trace::Fixed(_) => (-2.0 * along - own).max(0.0),
            // What is left of a channel by which the base is determined is not a hypothesis.
            _ if own < VISIBLE * VISIBLE => 0.0,
            _ => along.powi(2) / own,
        }
    }

    /// The gain, κ or angle that fits best; `neutral` where there is none.
    pub(crate) fn number(&self, r: &DVector<f64>, neutral: f64) -> f64 {
        match self {
            Trace::Free(d) => (neutral - d.dot(r) / d.norm_squared().max(f64::MIN_POSITIVE)).clamp(-20.0, 20.0),
            Trace::Block(rows) => {
                let mean = rows.iter().map(|&i| r[i] * r[i]).sum::<f64>() / rows.len() as f64;
                mean.sqrt().max(1.0)
            }
            _ => neutral,
        }
    }
}

/// The score of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FaultScore {
    /// Index of the fault.
    pub(crate) index: usize,
    /// T.
    pub(crate) t: f64,
    /// The gain, or κ, that fits best.
    pub(crate) number: f64,
    /// Which of the robust fits it was found at; none for the fit itself.
    pub(crate) robust: Option<usize>,
}

impl FaultScore {
    /// A fault that is tried whatever its first-order score.
    pub(crate) fn unscored(index: usize) -> Self {
        Self { index, t: 0.0, number: 1.0, robust: None }
    }
}
