//! How to diagnose.

use super::listener::Listener;
use crate::effect::Effects;
use crate::fault::Faults;
use crate::update::HowToPair;

/// How to diagnose.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The effects to try.
    pub effects: Effects,
    /// The faults of the measurement to try.
    pub faults: Faults,
    /// How modes are paired.
    pub pairing: HowToPair,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Probability of a false alarm that is accepted, above 0.01: so much of it goes to the tests of what remains.
    pub alarm_level: f64,
    /// Told what is being done.
    pub listener: Listener,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            effects: Effects::builtin(),
            faults: Faults::builtin(),
            pairing: HowToPair::default(),
            seed: 0,
            alarm_level: 0.05,
            listener: Listener::default(),
        }
    }
}
