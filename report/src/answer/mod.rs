//! The answer of every verb as JSON: what the command prints with `--json`, and what a program gets.
//!
//! Names and numbers of these are a contract; a field that goes away or changes its meaning is a change of the changelog. NaN and infinity
//! are null. Modes count from 1.

mod comparison;
mod identified;
mod pretest;
mod update;

pub use comparison::{
    assessment_mac, comparison, data_origins, functions, pair, parameter_information, readings, unpaired,
};
pub use identified::{findings, identified};
pub use pretest::pretest;
pub use update::{reduced, sampled, updated};

use super::LearningStep;
use retune::effect::Candidate;
use retune::update::ModeName;
use retune_diagnosis::Learned;
use serde_json::{Value, json};

/// `retune modes --json`.
pub fn modes(named: &[ModeName]) -> Value {
    let one = |m: &ModeName| json!({"frequency_hz": m.frequency_hz, "label": m.label, "short": m.short, "torsion_energy": m.torsion});
    json!({ "modes": named.iter().map(one).collect::<Vec<_>>() })
}

/// `retune learn --json`.
///
/// * `written` - the files that were written
///
/// # Errors
/// A step that has no JSON.
pub fn learned(learned: &Learned, written: &[String]) -> Result<Value, serde_json::Error> {
    let steps = learned.steps.iter().map(|s| serde_json::to_value(LearningStep::from(s)));
    Ok(json!({
        "steps": steps.collect::<Result<Vec<_>, _>>()?,
        "effects": learned.effects.iter().map(Candidate::id).collect::<Vec<_>>(),
        "stopped_for_tie": learned.stopped_for_tie,
        "attempt": learned.attempt.as_ref().map(|a| json!({"tried": a.ids, "misfit": a.misfit})),
        "written": written,
    }))
}

/// `retune twin --json`.
///
/// * `modes`, `functions` - how many were made, of what was asked for
/// * `source` - how the numbers came about
pub fn twin(modes: Option<usize>, functions: Option<usize>, sensors: usize, seed: u64, source: &str) -> Value {
    json!({
        "modes": modes, "functions": functions, "sensors": sensors, "seed": seed, "is_synthetic": true, "source": source,
    })
}
