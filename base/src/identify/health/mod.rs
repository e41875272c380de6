//! Health of the test: is the measurement itself to blame, before a model is?
//!
//! Every check returns [`Finding`]s with the numbers behind them and what to do. None needs a model, and where one would be
//! needed the finding says so instead of guessing:
//!
//! - [`check_functions`]: missing and dead functions, driving points that feed energy back, reciprocity.
//! - [`check_modes`]: noisy and dead channels, signs of driving-point residues, double modes, modes that the sensors
//!   cannot tell apart.
//! - [`check_identification`]: functions that lack lines, an identification without a mode.
//! - [`check_geometry`]: with the positions of the sensors: sign, gain, swap, dead entries, by the smoothness of the shapes.
//! - [`check_rigid_body`]: with measured rigid-body shapes: the same, sharper, and wrong axes.
//! - [`check_test`]: all of these that one test allows; [`check_shapes`]: those that need shapes only.
//! - [`check_silent`]: channels that read nothing in some modes.
//! - [`check_damping`]: modes of a file whose damping no passive structure has.
//! - [`compare_runs`]: shifts of frequency between runs: drift or mass loading.
//! - [`check_suspension`]: are the rigid-body modes far enough below the first elastic one?

pub mod codes;
mod driving_point;
mod functions;
mod geometry;
mod hypotheses;
mod modes;
mod outcome;
mod runs;
mod silent;
mod whole;

pub use functions::check_functions;
pub use geometry::{SensorGeometry, check_geometry, check_rigid_body};
pub use modes::{check_damping, check_modes, check_suspension};
pub use outcome::{check_identification, reversed_time_finding};
pub use runs::compare_runs;
pub use silent::check_silent;
pub use whole::{HealthOptions, check_shapes, check_test};

/// How serious a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Worth knowing; also what could not be checked.
    Info,
    /// Probably harmful; look at it before using the data.
    Warning,
    /// The data contradict themselves.
    Fault,
}

impl Level {
    /// "info", "warning", "fault".
    pub fn word(self) -> &'static str {
        match self {
            Level::Info => "info",
            Level::Warning => "warning",
            Level::Fault => "fault",
        }
    }
}

/// One result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// How serious.
    pub level: Level,
    /// A stable word for programs: "driving-point-sign".
    pub code: &'static str,
    /// What it is about: a channel, a mode, a pair.
    pub subject: String,
    /// The numbers behind it, with names.
    pub evidence: Vec<(&'static str, f64)>,
    /// What was found, for people.
    pub text: String,
    /// What to do about it.
    pub remedy: &'static str,
}

#[cfg(test)]
mod calibration;
#[cfg(test)]
mod tests;
