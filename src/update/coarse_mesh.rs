//! Frequencies that the mesh of a model falsifies by as much as a test would see.

use super::{Assessment, UpdateError};
use crate::correlation::CorrelationError;
use crate::data::TestData;
use crate::model::Model;

/// Share of a standard deviation that is worth a remark.
const SEEN: f64 = 1.0 / 3.0;

/// A pair whose frequency the mesh moves.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseMesh {
    /// Index of the mode in the test.
    pub test_mode: usize,
    /// Relative error of the model's frequency by its mesh, as [`Model::mesh_errors`] estimates it.
    pub relative: f64,
    /// The same in standard deviations of the measured frequency.
    pub deviations: f64,
    /// The part in which most of it arises.
    pub part: String,
}

/// The pairs whose frequencies the mesh of shells and solids moves by more than a third of a standard deviation.
///
/// # Errors
/// An element without matrices.
pub(super) fn coarse_mesh(model: &Model, test: &TestData, a: &Assessment) -> Result<Vec<CoarseMesh>, UpdateError> {
    let modes = &a.prediction.modes;
    let of = |k: usize| modes.n_rigid + a.pairs[k].model_mode;
    let which: Vec<usize> = (0..a.pairs.len()).map(of).collect();
    let errors = model.mesh_errors(&a.theta, modes, &which).map_err(|e| CorrelationError::Model(e.to_string()))?;
    let found = a.pairs.iter().filter_map(|pair| {
        let error = errors.iter().find(|e| e.mode == modes.n_rigid + pair.model_mode)?;
        let measured = &test.modes[pair.test_mode].frequency_hz;
        let deviations = error.relative * pair.model_hz / measured.sd;
        let part = error.part.clone();
        Some(CoarseMesh { test_mode: pair.test_mode, relative: error.relative, deviations, part })
    });
    Ok(found.filter(|c| c.deviations.abs() > SEEN).collect())
}

/// What they say, in a sentence; `None` where there is none.
pub fn coarse_mesh_text(found: &[CoarseMesh], n_pairs: usize) -> Option<String> {
    let worst = found.iter().max_by(|a, b| a.deviations.abs().total_cmp(&b.deviations.abs()))?;
    let what = if worst.relative < 0.0 { "low" } else { "high" };
    Some(format!(
        "it is coarse: by its own strains it moves {} of {n_pairs} frequencies by more than a third of their standard deviation, most that of test \
         mode {}, about {:.2} % too {what}, in `{}`; mesh it more finely before parameters take that up",
        found.len(),
        worst.test_mode + 1,
        100.0 * worst.relative.abs(),
        worst.part
    ))
}
