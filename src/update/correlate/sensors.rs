//! Agreement sensor by sensor and mode by mode.

use super::{paired_shapes, pairs_with_shapes, shape_sd};
use crate::correlation::{
    CorrelationError, Misfit, SensorRemoval, ShapeResidual, comac, enhanced_comac, scaled_comac, sensor_misfits,
    shape_residual, spoiling_sensors, turned_sensors,
};
use crate::objective::Comparison;
use crate::update::Assessment;

/// How one sensor agrees over all pairs.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SensorAgreement {
    /// Its name.
    pub sensor: String,
    /// COMAC, in [0, 1]; `None` where it does not move or did not measure.
    pub comac: Option<f64>,
    /// COMAC of shapes of equal weight.
    pub scaled_comac: Option<f64>,
    /// Enhanced COMAC: 0 is perfect.
    pub enhanced_comac: Option<f64>,
    /// Its squared residuals over all modes against what noise alone gives.
    pub misfit: Misfit,
}

/// All sensors, and which of them spoil the MAC.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SensorReport {
    /// In the order of the test.
    pub sensors: Vec<SensorAgreement>,
    /// Mean MAC of the pairs with all sensors.
    pub mean_mac: f64,
    /// Sensors whose removal raises the mean MAC most, one after the other (MACCO).
    pub removals: Vec<SensorRemoval>,
    /// Sensors that raise it by 0.01 each and more where they are turned over, one after the other.
    pub turns: Vec<SensorRemoval>,
}

/// Gain in the mean MAC for which a sensor is called turned over.
const LEAST_TURN: f64 = 0.01;

/// How one pair agrees, against noise.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ModeAgreement {
    /// Index of the test mode.
    pub test_mode: usize,
    /// (f_model - f_test)/σ_f.
    pub frequency_residual: f64,
    /// The shape alone; `None` without one.
    pub shape: Option<Misfit>,
    /// Frequency and shape together.
    pub misfit: Misfit,
}

fn residuals(comparison: &Comparison<'_>, a: &Assessment) -> Result<Vec<ShapeResidual<f64>>, CorrelationError> {
    let pairs = pairs_with_shapes(a);
    let (model, test) = paired_shapes(comparison, a, &pairs);
    pairs
        .iter()
        .enumerate()
        .map(|(j, p)| {
            shape_residual(model.column(j).as_slice(), test.column(j).as_slice(), &shape_sd(comparison, p.test_mode))
        })
        .collect()
}

/// COMAC and its kin, misfits and MACCO, sensor by sensor; `None` when no pair has a shape.
///
/// * `n_removed` - sensors that the MACCO list takes away at most
pub fn sensor_agreement(
    comparison: &Comparison<'_>,
    a: &Assessment,
    n_removed: usize,
) -> Result<Option<SensorReport>, CorrelationError> {
    let pairs = pairs_with_shapes(a);
    if pairs.is_empty() {
        return Ok(None);
    }
    let (model, test) = paired_shapes(comparison, a, &pairs);
    let misfits = sensor_misfits(&residuals(comparison, a)?)?;
    let (plain, scaled) = (comac(&model, &test), scaled_comac(&model, &test));
    let enhanced = enhanced_comac(&model, &test);
    let sensors = comparison.test().sensors.iter().enumerate().map(|(i, s)| SensorAgreement {
        sensor: s.name.clone(),
        comac: plain[i],
        scaled_comac: scaled[i],
        enhanced_comac: enhanced[i],
        misfit: misfits[i],
    });
    let mean_mac = pairs.iter().filter_map(|p| p.mac).sum::<f64>() / pairs.len() as f64;
    Ok(Some(SensorReport {
        sensors: sensors.collect(),
        mean_mac,
        removals: spoiling_sensors(&model, &test, n_removed),
        turns: turned_sensors(&model, &test, LEAST_TURN),
    }))
}

/// Misfits pair by pair, in the order of `a.pairs`.
pub fn mode_agreement(comparison: &Comparison<'_>, a: &Assessment) -> Result<Vec<ModeAgreement>, CorrelationError> {
    let mut shapes = pairs_with_shapes(a).into_iter().zip(residuals(comparison, a)?);
    let mut out = Vec::with_capacity(a.pairs.len());
    for p in &a.pairs {
        let f = comparison.test().modes[p.test_mode].frequency_hz;
        let frequency_residual = (p.model_hz - f.value) / f.sd;
        let frequency = Misfit::new(frequency_residual * frequency_residual, 1)?;
        let shape = if p.mac.is_some() { shapes.next().map(|(_, r)| r.misfit) } else { None };
        let misfit = Misfit::combine([Some(frequency), shape].iter().flatten(), 0)?;
        out.push(ModeAgreement { test_mode: p.test_mode, frequency_residual, shape, misfit });
    }
    Ok(out)
}
