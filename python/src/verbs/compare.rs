//! `retune.compare`

use super::shared::{Tests, made, sources};
use crate::answers::Compared;
use crate::error::Wrong;
use crate::model::Model;
use crate::running::{Stops, run};
use crate::test::Frfs;
use crate::tested::{Given, Pairing, Tested, all_tested};
use pyo3::prelude::*;
use retune::catalogue::Choice as _;
use retune::data::corrected_functions;
use retune::update::{AgreementOptions, MassReduction, agreement, load_profile};
use std::sync::Arc;

/// `retune compare`
///
/// * `profile` - text of a file with profiles, and a name
#[pyfunction]
#[pyo3(signature = (model, tests, pairing, reduction, everything, frfs, bands, profile, configuration, sensor_masses))]
#[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
pub(crate) fn compare(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    tests: Tests<'_>,
    pairing: Pairing,
    reduction: &str,
    everything: bool,
    frfs: Option<PyRef<'_, Frfs>>,
    bands: Vec<f64>,
    profile: Option<(Option<String>, Option<String>)>,
    configuration: Option<String>,
    sensor_masses: bool,
) -> PyResult<Compared> {
    let how = pairing.how()?;
    let reduction = MassReduction::parse(reduction).map_err(|e| Wrong::text(format!("reduction: {e}")))?;
    if bands.windows(2).any(|w| w[0] >= w[1]) {
        return Err(Wrong::text(format!("bands are {bands:?}: give ascending frequencies in Hz")).into());
    }
    let profile = profile.map(|(text, name)| load_profile(text.as_deref(), name.as_deref()));
    let profile = profile.transpose().map_err(Wrong::from)?;
    let (given, tests) = (Given::File(Arc::clone(&model.0)), sources(&tests));
    let made = made(&given, &tests, "retune.compare", None);
    let set = frfs.map(|f| Arc::clone(&f.set));
    run(py, None, Stops::Never, move |_| {
        let all = all_tested(&given, &tests, configuration.as_deref(), Some(sensor_masses))?;
        let one = |t: &Tested| {
            let set =
                set.as_ref().map(|set| corrected_functions((**set).clone(), &t.test.sensors, &t.test.corrections));
            let options = AgreementOptions {
                pairing: how,
                reduction,
                places: everything,
                parameters: everything,
                suspects: everything,
                functions: set.as_ref(),
                band_edges_hz: &bands,
                profile: profile.as_ref(),
            };
            Ok::<_, Wrong>(agreement(t.model.file()?, &t.test, &options)?)
        };
        let parts = all.iter().map(one).collect::<Result<Vec<_>, _>>()?;
        Ok(Compared { parts, all, profile, how, made })
    })
}
