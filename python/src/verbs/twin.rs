//! `retune.twin`

use super::shared::scalar;
use crate::answers::Twin;
use crate::error::Wrong;
use crate::model::Model;
use crate::running::{Stops, run};
use crate::source::Source;
use crate::test::{Test, TestSource, quantity_of};
use pyo3::prelude::*;
use retune::catalogue::did_you_mean;
use retune::model::{Model as Structure, ParametricModel as _};
use retune::update::{
    TwinFault, TwinFrfOptions, TwinOptions, TwinStory, driving_sensor, node_sensors, twin_frfs, twin_modes,
};
use retune_report::answer;
use std::sync::Arc;

/// What a synthetic test is made with.
#[derive(FromPyObject)]
pub(crate) struct TwinArguments {
    #[pyo3(item)]
    modes: Option<usize>,
    #[pyo3(item)]
    band: Option<(f64, f64)>,
    #[pyo3(item)]
    lines: Option<Vec<f64>>,
    #[pyo3(item)]
    exciters: Vec<String>,
    #[pyo3(item)]
    quantity: String,
    #[pyo3(item)]
    noise_frequency: String,
    #[pyo3(item)]
    noise_damping: String,
    #[pyo3(item)]
    noise_shape: String,
    #[pyo3(item)]
    noise_force: String,
    #[pyo3(item)]
    noise_response: String,
    #[pyo3(item)]
    averages: usize,
    #[pyo3(item)]
    damping: Option<String>,
    #[pyo3(item)]
    set: Vec<(String, String)>,
    #[pyo3(item)]
    patch: Option<(String, String)>,
    #[pyo3(item)]
    faults: Vec<String>,
    #[pyo3(item)]
    seed: u64,
}

/// `retune twin`
#[pyfunction]
#[pyo3(signature = (model, sensors, arguments))]
pub(crate) fn twin(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    sensors: Option<PyRef<'_, Test>>,
    arguments: TwinArguments,
) -> PyResult<Twin> {
    let (source, given) = (Arc::clone(&model.0), sensors.map(|t| t.0.data.sensors.clone()));
    run(py, None, Stops::Never, move |_| synthetic(&source, given, &arguments))
}

fn synthetic(source: &Source, sensors: Option<Vec<retune::data::Sensor>>, args: &TwinArguments) -> Result<Twin, Wrong> {
    let mut structure = Arc::clone(&source.model);
    if let Some((name, text)) = &args.patch {
        let wrong = |problems| Wrong::problems(Some(name), problems);
        let spec = structure.spec().overlaid(text).map_err(wrong)?;
        structure = Arc::new(Structure::new(spec, structure.registry()).map_err(wrong)?.0);
    }
    let parameters = structure.parameters();
    let mut theta = parameters.nominal();
    for (name, value) in &args.set {
        let index = parameters.index_of(name).ok_or_else(|| {
            Wrong::text(format!("set: no parameter `{name}`{}", did_you_mean(name, parameters.names())))
        })?;
        theta[index] = parameters.get(index).parse(value).map_err(|e| Wrong::text(format!("set: {e}")))?.0;
    }
    let sensors = sensors.unwrap_or_else(|| node_sensors(&*structure));
    let options = TwinOptions {
        n_modes: args.modes.unwrap_or(10),
        band_hz: args.band,
        frequency_noise: scalar("noise_frequency", &args.noise_frequency, "1")?,
        damping: args.damping.as_deref().map(|text| scalar("damping", text, "1")).transpose()?,
        damping_noise: scalar("noise_damping", &args.noise_damping, "1")?,
        shape_noise: scalar("noise_shape", &args.noise_shape, "1")?,
        faults: args.faults.iter().map(|f| f.parse()).collect::<Result<Vec<TwinFault>, _>>()?,
        seed: args.seed,
    };
    let set: Vec<String> = args.set.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let file = source.file_name();
    let story = TwinStory {
        model: &structure.spec().name,
        file: &file,
        patch: args.patch.as_ref().map(|p| p.0.as_str()),
        set: &set,
        faults: &args.faults,
        noise_frequency: &args.noise_frequency,
        noise_shape: &args.noise_shape,
        seed: args.seed,
    };
    let text = story.text();
    let mut test = None;
    if args.modes.is_some() {
        let mut data = twin_modes(&*structure, &theta, &sensors, &options, &text)?;
        story.sign(&mut data, source.configuration.as_deref());
        test = Some(Arc::new(TestSource::written(&data)?));
    }
    let mut frfs = None;
    if let Some(lines) = &args.lines {
        let exciters = match lines.as_slice() {
            [low, .., high] if args.exciters.is_empty() && !sensors.is_empty() => {
                vec![sensors[driving_sensor(&*structure, &theta, &sensors, (*low, *high))?].name.clone()]
            }
            _ => args.exciters.clone(),
        };
        let of_functions = TwinFrfOptions {
            lines_hz: lines.clone(),
            exciters,
            quantity: quantity_of(&args.quantity)?,
            force_noise: scalar("noise_force", &args.noise_force, "1")?,
            response_noise: scalar("noise_response", &args.noise_response, "1")?,
            n_averages: args.averages,
        };
        frfs = Some(Arc::new(twin_frfs(&*structure, &theta, &sensors, &options, &of_functions)?));
    }
    let n_modes = test.as_ref().map(|t| t.data.modes.len());
    let n_functions = frfs.as_ref().map(|set| set.references.len() * set.responses.len());
    let json = answer::twin(n_modes, n_functions, sensors.len(), args.seed, &text).to_string();
    Ok(Twin { json, test, frfs })
}
