//! Where a model and a test disagree: over sensors, modes, frequency bands, elements and parameters.
//!
//! Every function takes a [`Comparison`] with its [`Assessment`] and answers one question; none of them changes anything.
//! [`super::assess`] comes first. The criteria themselves are those of [`crate::correlation`].

mod close;
mod functions;
mod orthogonality;
mod parameters;
mod places;
mod sensors;
mod suspicion;
mod verdict;

pub use close::mixed_modes;
pub use functions::{
    BandAgreement, ChannelAgreement, Functions, FunctionsOptions, ModelFunctions, ReferenceShift, compare_functions,
};
pub use orthogonality::{MassReduction, Orthogonality, orthogonality};
pub use parameters::{
    FrfSensitivity, MASS_ROWS, ParameterInformation, Sensitivities, SensitivityOptions, frf_sensitivities,
    sensitivities,
};
pub use places::{Places, PlacesError, PlacesOptions, member_stiffnesses, places};
pub use sensors::{ModeAgreement, SensorAgreement, SensorReport, mode_agreement, sensor_agreement};
pub use suspicion::{FirstLook, slip_of_unit, slips_of_modes, slips_of_readings};
pub use verdict::{judge, load_profile};

use super::{AssessedPair, Assessment};
use crate::linalg::DMatrix;
use crate::objective::Comparison;

/// Pairs whose test mode has a shape.
fn pairs_with_shapes(a: &Assessment) -> Vec<&AssessedPair> {
    a.pairs.iter().filter(|p| p.mac.is_some()).collect()
}

/// Shapes of these pairs at the sensors, model and test: (n_sensor x n_pairs) each, NaN where not measured.
fn paired_shapes(comparison: &Comparison<'_>, a: &Assessment, pairs: &[&AssessedPair]) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = comparison.shapes().nrows();
    let of = |shapes: &DMatrix<f64>, mode: &dyn Fn(&AssessedPair) -> usize| {
        DMatrix::from_fn(n, pairs.len(), |i, j| shapes[(i, mode(pairs[j]))])
    };
    (of(&a.prediction.at_sensors, &|p| p.model_mode), of(comparison.shapes(), &|p| p.test_mode))
}

/// Standard deviations of the shape of a test mode, one a sensor.
fn shape_sd(comparison: &Comparison<'_>, test_mode: usize) -> Vec<f64> {
    let n = comparison.shapes().nrows();
    comparison.test().modes[test_mode].shape_sd.as_ref().map_or(vec![f64::NAN; n], |sd| sd.iter().copied().collect())
}

/// The name of a test mode: `mode 3 (Sym 1st Torsion)`.
fn test_mode_name(comparison: &Comparison<'_>, mode: usize) -> String {
    let label = comparison.test().modes[mode].label.as_ref();
    label.map_or_else(|| format!("mode {}", mode + 1), |l| format!("mode {} ({l})", mode + 1))
}
