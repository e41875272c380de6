//! `retune.report`

use super::shared::{OneProgress, Remarks, made};
use crate::answers::compared;
use crate::model::Model;
use crate::running::{Stops, run};
use crate::test::{Frfs, Test};
use crate::tested::{Given, Pairing, tested};
use pyo3::prelude::*;
use retune::data::{corrected_functions, joined};
use retune::model::ParametricModel as _;
use retune_diagnosis::{Listener, Until};
use retune_report::{Case, add_before, add_diagnosis, add_live, add_responses, assess_paired, html, json};
use std::sync::Arc;

/// `retune report`: the page and its data as JSON, with remarks.
#[pyfunction]
#[pyo3(signature = (model, test, before, diagnose, frfs, pairing, seed, configuration, progress))]
#[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
pub(crate) fn report(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    test: PyRef<'_, Test>,
    before: Option<PyRef<'_, Model>>,
    diagnose: bool,
    frfs: Option<PyRef<'_, Frfs>>,
    pairing: Pairing,
    seed: u64,
    configuration: Option<String>,
    progress: OneProgress<'_, '_>,
) -> PyResult<(String, String, Remarks)> {
    let how = pairing.how()?;
    let (source, test) = (Arc::clone(&model.0), Arc::clone(&test.0));
    let made =
        made(&Given::File(Arc::clone(&source)), std::slice::from_ref(&test), "retune.report", diagnose.then_some(seed));
    let before = before.map(|m| Arc::clone(&m.0));
    let frfs = frfs.map(|f| (Arc::clone(&f.set), f.is_synthetic));
    run(py, progress, Stops::WithItsBest, move |job| {
        let tested = tested(&source, &test, configuration.as_deref(), None)?;
        let (structure, data_of_test) = (tested.model.file()?, &tested.test);
        let mut data = compared(&tested, &how)?;
        let earlier = before.map(|b| {
            let at = b.model.parameters().nominal();
            assess_paired(&b.model, &at, data_of_test, &how).map(|assessment| (b, assessment))
        });
        let earlier = earlier.transpose()?;
        if let Some((b, assessment)) = &earlier {
            add_before(&mut data, &b.model, assessment, data_of_test);
        }
        let mut hypotheses = Vec::new();
        if diagnose {
            let job = job.clone();
            let settings = retune_diagnosis::Settings {
                seed,
                pairing: how,
                until: Until::the_end().stopped_by(Arc::clone(&job.stop)),
                listener: Listener::new(move |what| job.tell(what.to_string(), None, None)),
                ..retune_diagnosis::Settings::default()
            };
            let found = retune_diagnosis::diagnose(structure, data_of_test, &settings)?;
            add_diagnosis(&mut data, &found, structure, &joined(&[data_of_test]).test);
            hypotheses = found.hypotheses;
        }
        let assessment = assess_paired(structure, &structure.parameters().nominal(), data_of_test, &how)?;
        let case = Case { model: structure, test: data_of_test, assessment: &assessment };
        let before = earlier.as_ref().map(|(b, a)| Case { model: &b.model, test: data_of_test, assessment: a });
        add_live(&mut data, case, &[], &how, before.map(|b| b.model), &hypotheses);
        if let Some((set, is_synthetic)) = &frfs {
            let origin = if *is_synthetic { "synthetic" } else { "measured" };
            let set = corrected_functions((**set).clone(), &data_of_test.sensors, &data_of_test.corrections);
            add_responses(&mut data, case, before, &set, origin)?;
        } else if let Some(set) = &data_of_test.frfs {
            let origin = data_of_test.modes.first().map_or("measured", |m| m.origin.word());
            add_responses(&mut data, case, before, set, origin)?;
        }
        made.sign(&mut data);
        Ok((html(&data)?, json(&data)?, tested.remarks.clone()))
    })
}
