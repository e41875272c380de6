//! How good is a diagnosis? Twins with a known answer, on several structures, and the score.
//!
//! ```text
//! structure x (nothing | effect at a place, of a size | fault of a sensor | something outside the catalogue)
//!   -> a twin on a finer mesh, with noise -> diagnose with the coarse model -> is the answer right?
//! ```
//!
//! Every twin is synthetic. Places, sizes, sensors and noise are drawn from the seed; no structure, place or size is chosen by
//! hand. Sensors are chosen by effective independence, modes by what the coarse mesh resolves.

mod case;
mod foreign;
mod hidden;
mod score;
mod shard;
mod structures;

use case::Case;
pub use case::{Class, Outcome};
pub use foreign::foreign_mode;
pub use score::{Calibration, Score, Share};
pub use shard::{MergeError, Part, Shard, ShardError, merge, run_shard};
pub use structures::{STRUCTURES, Specimen};

use shard::CaseResult;

use crate::error::DiagnosisError;
use crate::settings::Settings;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// How much is tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Names of the structures; all when empty.
    pub structures: Vec<String>,
    /// Twins with nothing missing, on each structure.
    pub null: usize,
    /// Places and sizes of every effect, on each structure.
    pub effects: usize,
    /// Sensors with every fault, on each structure.
    pub faults: usize,
    /// Twins with every change outside the catalogue, on each structure.
    pub outside: usize,
    /// Modes of any frequency in and about the band and any shape that are added to every test: none is of the structure.
    pub foreign: usize,
    /// Sensors of a test, as far as the structure has places for them; at least as many as modes.
    pub sensors: usize,
    /// Modes of a test, at most.
    pub modes: usize,
    /// Relative noise of frequencies that the test states.
    pub frequency_noise: f64,
    /// Noise of shapes, relative to the largest entry, that the test states.
    pub shape_noise: f64,
    /// The noise that is there, over the one that is stated.
    pub noise_factor: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Only cases with this in the id of what is hidden; with the whole diagnosis in their outcome.
    pub only: Option<String>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            structures: Vec::new(),
            null: 5,
            effects: 1,
            faults: 1,
            outside: 1,
            foreign: 0,
            sensors: 28,
            modes: 8,
            frequency_noise: 0.003,
            shape_noise: 0.02,
            noise_factor: 1.0,
            seed: 1,
            only: None,
        }
    }
}

impl Plan {
    /// Whether a structure takes part.
    fn wants(&self, structure: &str) -> bool {
        self.structures.is_empty() || self.structures.iter().any(|s| s == structure)
    }
}

/// What came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Benchmark {
    /// Every case.
    pub outcomes: Vec<Outcome>,
    /// The score.
    pub score: Score,
}

impl Benchmark {
    /// Of the outcomes in the order of the cases.
    fn of(outcomes: Vec<Outcome>) -> Self {
        let score = Score::new(&outcomes);
        Self { outcomes, score }
    }
}

/// Runs the plan; `progress` is told how many of how many cases are done.
///
/// Errors: a structure that cannot be prepared. A case that cannot be posed (a truth without modes) is left out.
pub fn benchmark(
    plan: &Plan,
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Benchmark, DiagnosisError> {
    let (_, results) = run(plan, settings, Part::WHOLE, progress)?;
    Ok(Benchmark::of(results.into_iter().filter_map(|r| r.outcome).collect()))
}

/// Runs the cases of a part, and says how many cases there are in all.
fn run(
    plan: &Plan,
    settings: &Settings,
    part: Part,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<(usize, Vec<CaseResult>), DiagnosisError> {
    let mut cases: Vec<(Specimen, Vec<Case>)> = Vec::new();
    for (k, (name, text)) in STRUCTURES.iter().enumerate() {
        if plan.wants(name) {
            let specimen = Specimen::new(name, text, plan)?;
            let list = specimen.cases(plan, settings, plan.seed.wrapping_mul(1000).wrapping_add(k as u64));
            let wanted = |c: &Case| plan.only.as_ref().is_none_or(|only| c.id(&specimen).contains(only.as_str()));
            let list = list.into_iter().filter(wanted).collect();
            cases.push((specimen, list));
        }
    }
    let all: Vec<(&Specimen, &Case)> = cases.iter().flat_map(|(s, list)| list.iter().map(move |c| (s, c))).collect();
    let mine: Vec<usize> = part.positions(all.len()).collect();
    let done = AtomicUsize::new(0);
    let results = mine
        .par_iter()
        .with_max_len(1)
        .map(|&position| {
            let (specimen, case) = all[position];
            let outcome = specimen.run(case, plan, settings);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, mine.len());
            CaseResult { position, outcome: outcome.ok().flatten() }
        })
        .collect();
    Ok((all.len(), results))
}
