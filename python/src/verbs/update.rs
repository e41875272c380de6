//! `retune.update` and `retune.sample`

use super::settings::{OwnTerms, Searcher, failures, settings};
use super::shared::{OneProgress, Tests, made, sources};
use crate::answers::{Sampled, Updated};
use crate::error::Wrong;
use crate::own::settled;
use crate::running::{Stops, run};
use crate::tested::{Given, Pairing, all_tested, cases};
use pyo3::prelude::*;
use retune::optim::{Checkpoint, Evaluator, Progress, Shared, Threads, Tmcmc};
use retune::update::{Controls, sample_posterior_by, update_to_tests};
use std::path::PathBuf;
use std::sync::Arc;

/// `retune update`
#[pyfunction]
#[pyo3(signature = (model, tests, cost, objective, pairing, optimizer, seed, budget, reduced, checkpoint, resume, configuration, sensor_masses, residuals, progress))]
#[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
pub(crate) fn update(
    py: Python<'_>,
    model: Given,
    tests: Tests<'_>,
    cost: &str,
    objective: Option<&str>,
    pairing: Pairing,
    optimizer: Option<Searcher<'_>>,
    seed: u64,
    budget: Option<u64>,
    reduced: Option<f64>,
    checkpoint: Option<PathBuf>,
    resume: bool,
    configuration: Option<String>,
    sensor_masses: bool,
    residuals: OwnTerms<'_>,
    progress: OneProgress<'_, '_>,
) -> PyResult<Updated> {
    let settings = settings(cost, (objective, &residuals), &pairing, optimizer.as_ref(), seed, reduced)?;
    let mut failures = failures(&residuals);
    if let Some(Searcher::Own(own)) = &optimizer {
        failures.push(&own.0.failure);
    }
    let (given, tests) = (model, sources(&tests));
    let made = made(&given, &tests, "retune.update", Some(seed));
    let found = run(py, progress, Stops::WithItsBest, move |job| {
        let all = all_tested(&given, &tests, configuration.as_deref(), Some(sensor_masses))?;
        let checkpoint = match &checkpoint {
            Some(path) if resume => Some(Checkpoint::resume(path)?),
            Some(path) => Some(Checkpoint::create(path)?),
            None => None,
        };
        let mut observer = |p: &Progress<'_>| job.tell(p.method.to_string(), Some(p.evaluations), Some(p.cost));
        let controls = Controls {
            budget,
            cancel: Some(Arc::clone(&job.stop)),
            observer: Some(&mut observer),
            evaluator: None,
            checkpoint,
        };
        let update = update_to_tests(&cases(&all), &settings, controls)?;
        Ok(Updated { update, all, how: settings.pairing, made })
    });
    settled(found, failures)
}

/// `retune sample`
#[pyfunction]
#[pyo3(signature = (model, tests, samples, objective, pairing, seed, reduced, configuration, residuals, shard))]
#[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
pub(crate) fn sample(
    py: Python<'_>,
    model: Given,
    tests: Tests<'_>,
    samples: usize,
    objective: Option<&str>,
    pairing: Pairing,
    seed: u64,
    reduced: Option<f64>,
    configuration: Option<String>,
    residuals: OwnTerms<'_>,
    shard: Option<(usize, usize, PathBuf)>,
) -> PyResult<Sampled> {
    if !(50..=1_000_000).contains(&samples) {
        return Err(Wrong::text(format!("samples is {samples}; it is from 50 to 1000000")).into());
    }
    // The seed is of the sampler alone, as in the command.
    let settings = settings("least-squares", (objective, &residuals), &pairing, None, 0, reduced)?;
    let (given, tests) = (model, sources(&tests));
    let made = made(&given, &tests, "retune.sample", Some(seed));
    let found = run(py, None, Stops::WithItsBest, move |job| {
        let all = all_tested(&given, &tests, configuration.as_deref(), None)?;
        let sampler = Tmcmc { n_samples: samples, seed, cancel: Arc::clone(&job.stop), ..Tmcmc::default() };
        let shared = shard.map(|(index, of, folder)| Shared::new(&folder, index, of));
        let shared = shared.transpose().map_err(|e| Wrong::text(e.to_string()))?;
        let evaluator: &dyn Evaluator = shared.as_ref().map_or(&Threads, |shared| shared);
        let sampled = sample_posterior_by(&cases(&all), &settings, &sampler, evaluator)?;
        Ok(Sampled { sampled, all, made })
    });
    settled(found, failures(&residuals))
}
