//! `retune.pretest`

use super::shared::positive;
use crate::error::Wrong;
use crate::model::Model;
use crate::running::{Stops, run};
use crate::test::Test;
use pyo3::prelude::*;
use retune::catalogue::Choice as _;
use retune::update::{self as workflows, Placement, PretestOptions};
use retune_report::answer;
use std::sync::Arc;

/// `retune pretest`: the JSON.
#[pyfunction]
#[pyo3(signature = (model, modes, sensors, by, test, noise_shape, noise_frequency))]
#[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
pub(crate) fn pretest(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    modes: Option<usize>,
    sensors: Option<usize>,
    by: Option<String>,
    test: Option<PyRef<'_, Test>>,
    noise_shape: &str,
    noise_frequency: &str,
) -> PyResult<String> {
    let options = PretestOptions {
        n_modes: modes,
        n_sensors: sensors,
        shape_noise: positive("noise_shape", noise_shape)?,
        frequency_noise: positive("noise_frequency", noise_frequency)?,
    };
    let by = by.as_deref().map(Placement::parse).transpose().map_err(|e| Wrong::text(format!("by: {e}")))?;
    let structure = Arc::clone(&model.0.model);
    let given = test.map_or_else(Vec::new, |t| t.0.data.sensors.clone());
    run(py, None, Stops::Never, move |_| {
        let plan = workflows::pretest(&*structure, &given, &options)?;
        Ok(answer::pretest(&plan, &plan.choices(by)).to_string())
    })
}
