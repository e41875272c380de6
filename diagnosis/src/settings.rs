//! How to diagnose.

use super::effort::Effort;
use super::listener::Listener;
use super::until::Until;
use retune::effect::Effects;
use retune::fault::Faults;
use retune::update::HowToPair;

/// How to diagnose.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The effects to try.
    pub effects: Effects,
    /// Names of nodes, elements, members, chains or groups: effects are tried where they have a node or an element of these; of none, everywhere.
    pub places: Vec<String>,
    /// The faults of the measurement to try.
    pub faults: Faults,
    /// How modes are paired.
    pub pairing: HowToPair,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How much is tried.
    pub effort: Effort,
    /// Probability of a false alarm that is accepted, above 0.01: so much of it goes to the tests of what remains.
    pub alarm_level: f64,
    /// Told what is being done.
    pub listener: Listener,
    /// Until when it may search.
    pub until: Until,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            effects: Effects::builtin(),
            places: Vec::new(),
            faults: Faults::builtin(),
            pairing: HowToPair::default(),
            seed: 0,
            effort: Effort::default(),
            alarm_level: 0.05,
            listener: Listener::default(),
            until: Until::the_end(),
        }
    }
}

impl Settings {
    /// Whether some of the built-in effects or some of the places are not tried.
    pub(crate) fn is_narrowed(&self) -> bool {
        !self.places.is_empty() || Effects::builtin().iter().any(|e| self.effects.find(e.name()).is_none())
    }
}
