//! Comparison of mode shapes and frequency responses: where a model agrees with a test, and where it does not.
//!
//! Functions of plain matrices: shapes are columns at the sensors (or at all dofs, where a function says so), analytical
//! ones first, experimental ones second, and NaN marks what was not measured. Start reading at [`mac_matrix`].

mod assignment;
mod channels;
mod chi_square_sum;
mod comac;
mod criteria;
mod expansion;
mod frf;
mod gamma_quantile;
mod identifiability;
mod inference;
mod labels;
mod loading;
mod localization;
mod mac;
mod macco;
mod mapping;
mod observe;
mod orthogonality;
mod pairing;
mod partners;
mod pretest;
mod single_change;
mod statistics;
mod subspace;
mod union;

pub use channels::{check_functions, fitted_channel};
pub use comac::{comac, enhanced_comac, scaled_comac};
pub use criteria::{
    BUILTIN_PROFILES, Check, CriteriaError, CriteriaProfile, Evidence, Judgement, ModeMarks, PairEvidence,
    ProbabilityOf, find_profile, parse_profiles,
};
pub use expansion::{ExpandedShape, Expander};
pub(crate) use frf::random_variance;
pub use frf::{
    BandResidual, BandResiduals, ByChannel, FrequencyShift, Signature, band_residuals, fdac, frac, frequency_shift,
    is_driving_point, local_amplitude, signatures, to_quantity,
};
pub use identifiability::{
    CollinearGroup, CoupledGroup, Identifiability, Information, collinear_groups, correlations, covariance,
    identifiability, information,
};
pub(crate) use inference::{Form, Level, Measured as MeasuredMode, Modelled, Pairings, best, level, marginals};
pub(crate) use labels::Label;
pub use loading::{Transducer, transducers, with_sensor_masses};
pub use localization::{
    ElementMatrix, ExpandedMode, Localization, Place, by_group, element_energies, group_matrices, localize,
    localize_with_groups, residual_force,
};
pub use mac::{ShapeScalar, auto_mac, mac_matrix, modal_scale_factor, to_complex, weighted_mac_matrix};
pub use mac::{UNSEEN, hide_unseen};
pub use macco::{SensorRemoval, spoiling_sensors, turned_sensors};
pub use mapping::{Leftover, MappedPoint, Mapping, MappingOptions, PlaceKind, map_points, place_sensors};
pub use observe::{
    check_sensors, observation_matrix, observation_matrix_at, observation_rows, read_rows, sensor_position,
    varying_sensors,
};
pub use orthogonality::{auto_orthogonality, cross_orthogonality, generalized_mass};
pub use pairing::{
    ModeList, ModePair, PairBy, PairFlag, PairedModes, PairingOptions, Plan, Tracked, Unpaired, pair_alike_modes,
    pair_modes, pair_planned_modes, track,
};
pub(crate) use partners::PartnerSearch;
pub use pretest::{
    DrivingPoint, Gain, SensorChoice, effective_independence, effective_masses, kinetic_energy_shares,
    rank_driving_points, rank_next_measurements, sensors_by_auto_mac, sensors_by_kinetic_energy,
};
pub use single_change::{SingleChange, SingleChanges, single_changes};
pub use statistics::{
    Misfit, ShapeResidual, band_misfits, odds, probability_of_cross_orthogonality, probability_of_frequency,
    probability_of_mac, sensor_misfits, shape_residual,
};
pub use subspace::{CloseModes, assess_close_modes, principal_angles, subspace_mac};

use crate::data::FrfQuantity;
use crate::linalg::LinalgError;

/// Why a comparison has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CorrelationError {
    /// A matrix or vector does not fit the others.
    #[error("{what}: {rows} x {columns}; expected {expected}")]
    Shape {
        /// Which one.
        what: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// What fits.
        expected: String,
    },
    /// A shape has entries that were not measured, where all are needed.
    #[error(
        "{set} mode {mode} (from 0) is not measured at every sensor; leave that sensor out of the mass, or the mode out of the set"
    )]
    IncompleteShape {
        /// "analytical" or "experimental".
        set: &'static str,
        /// The mode.
        mode: usize,
    },
    /// A number lies outside its range.
    #[error("{what} is {}; it must be {expected}", crate::units::plain(*value))]
    Range {
        /// What the number means.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range, in words.
        expected: &'static str,
    },
    /// A number of things that there are too few or too many of.
    #[error("{what} is {value}; it must be {expected}")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many.
        value: usize,
        /// The allowed range, in words and numbers.
        expected: String,
    },
    /// A sensor sits where the model has nothing.
    #[error("sensor `{sensor}` sits on {what} `{name}`, which the model does not have{suggestion}")]
    UnknownPlace {
        /// The sensor.
        sensor: String,
        /// "node" or "element".
        what: &'static str,
        /// Its name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// A partner that a user has named is none.
    #[error("pair_with of test mode {mode}: {reason}")]
    Partner {
        /// The test mode, from 1.
        mode: usize,
        /// Why not.
        reason: String,
    },
    /// The model failed.
    #[error("the model cannot be evaluated: {0}")]
    Model(String),
    /// The functions are of different kinds.
    #[error(
        "the model's functions are {analytical:?}, the test's {experimental:?}; convert the model's with `to_quantity` first"
    )]
    DifferentQuantity {
        /// Of the model.
        analytical: FrfQuantity,
        /// Of the test.
        experimental: FrfQuantity,
    },
    /// No channel of a measurement is a sensor of the test.
    #[error(
        "no {what} channel of the functions is a sensor of the test: they are called {names}; name the sensors alike, or put them on nodes of these names"
    )]
    NoChannel {
        /// "response" or "excitation".
        what: &'static str,
        /// The first of them.
        names: String,
    },
    /// The mass cannot be reduced to the sensors in that way.
    #[error("{method} reduction of the mass to the sensors: {reason}")]
    Reduction {
        /// Which reduction.
        method: &'static str,
        /// Why not.
        reason: String,
    },
    /// A kernel failed.
    #[error("the comparison has no result")]
    Linalg(#[from] LinalgError),
}

#[cfg(test)]
mod tests;
