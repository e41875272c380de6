//! `retune.identify`, and functions of measurement files

use super::shared::Remarks;
use crate::answers::Identified;
use crate::error::Wrong;
use crate::model::Model;
use crate::running::{Stops, run};
use crate::test::{Frfs, quantity_of};
use pyo3::prelude::*;
use retune::catalogue::Choice as _;
use retune::data::convert::Duplicates;
use retune::data::{Answers, Measurements, read_measurements};
use retune::identify::{IdentifyOptions, forward_in_time};
use retune::update::{self as workflows, About, IdentifySettings, Method, Window, identify_test};
use std::path::PathBuf;
use std::sync::Arc;

/// Answers to what measurement files leave open.
#[derive(FromPyObject)]
pub(crate) struct ReadOptions {
    #[pyo3(item)]
    units: Option<String>,
    #[pyo3(item)]
    quantity: Option<String>,
    #[pyo3(item)]
    unit: Option<String>,
    #[pyo3(item)]
    duplicates: Option<String>,
    #[pyo3(item)]
    frequency_unit: Option<String>,
    #[pyo3(item)]
    direction: Option<String>,
    #[pyo3(item)]
    geometry: Option<PathBuf>,
    #[pyo3(item)]
    geometry_units: Option<String>,
    #[pyo3(item)]
    variables: Option<String>,
    #[pyo3(item)]
    frame: Option<String>,
}

impl ReadOptions {
    fn read(&self, files: &[PathBuf]) -> Result<(Measurements, Remarks), Wrong> {
        let answers = Answers {
            units: self.units.as_deref(),
            quantity: self.quantity.as_deref().map(quantity_of).transpose()?,
            unit: self.unit.as_deref(),
            duplicates: (self.duplicates.as_deref().map(Duplicates::parse).transpose())
                .map_err(|e| Wrong::text(format!("duplicates: {e}")))?
                .unwrap_or_default(),
            frequency_unit: self.frequency_unit.as_deref(),
            local_axes: None,
            direction: self.direction.as_deref(),
            geometry_units: self.geometry_units.as_deref(),
            variables: self.variables.as_deref(),
            frame: self.frame.as_deref(),
        };
        let (options, frame) = answers.options().map_err(Wrong::text)?;
        let mut found = read_measurements(files, self.geometry.as_deref(), &options)?;
        let mut remarks: Remarks = Vec::new();
        for (path, note) in &found.notes {
            let place = if path.as_os_str().is_empty() { String::new() } else { format!("{}: ", path.display()) };
            remarks.push(("note", format!("{place}{note}")));
        }
        if forward_in_time(&mut found) {
            let text = "the functions are written for exp(-iωt): the imaginary parts of all of them are reversed";
            remarks.push(("warning", text.to_string()));
        }
        if let Some(frame) = frame {
            found.turn(&frame);
        }
        Ok((found, remarks))
    }
}

/// The frequency response functions of measurement files, with remarks.
#[pyfunction]
pub(crate) fn read_frfs(py: Python<'_>, files: Vec<PathBuf>, options: ReadOptions) -> PyResult<(Frfs, Remarks)> {
    run(py, None, Stops::Never, move |_| {
        let (found, remarks) = options.read(&files)?;
        let instead = || workflows::UpdateError::NoMeasurements(workflows::instead(&found));
        let set = found.frfs.clone().ok_or_else(instead)?;
        Ok((Frfs { set: Arc::new(set), geometry: found.geometry, is_synthetic: found.is_synthetic }, remarks))
    })
}

/// How modes are identified.
#[derive(FromPyObject)]
pub(crate) struct IdentifyArguments {
    #[pyo3(item)]
    band: Option<(f64, f64)>,
    #[pyo3(item)]
    method: String,
    #[pyo3(item)]
    peak_height: f64,
    #[pyo3(item)]
    order: usize,
    #[pyo3(item)]
    suspension: usize,
    #[pyo3(item)]
    exponential_window: Option<f64>,
    #[pyo3(item)]
    repeatability: f64,
    #[pyo3(item)]
    health: bool,
    #[pyo3(item)]
    name: Option<String>,
    #[pyo3(item)]
    configuration: Option<String>,
}

impl IdentifyArguments {
    fn settings(&self) -> Result<IdentifySettings, Wrong> {
        if let Some((low, high)) = self.band.filter(|(low, high)| !(low < high && *low >= 0.0)) {
            return Err(Wrong::text(format!("band is ({low}, {high}): give two ascending frequencies in Hz")));
        }
        Ok(IdentifySettings {
            options: IdentifyOptions { band_hz: self.band, max_order: self.order, ..IdentifyOptions::default() },
            method: Method::parse(&self.method).map_err(|e| Wrong::text(format!("method: {e}")))?,
            peak_height_db: self.peak_height,
            n_suspension: self.suspension,
            window: match self.exponential_window {
                None => Window::Stated,
                Some(0.0) => Window::None,
                Some(rate) if rate > 0.0 && rate.is_finite() => Window::Rate(rate),
                Some(rate) => {
                    return Err(Wrong::text(format!("exponential_window is {rate}; it is a rate in 1/s, 0 for none")));
                }
            },
            repeatability: self.repeatability,
            checks_health: self.health,
        })
    }
}

/// `retune identify`, of files or of functions.
#[pyfunction]
#[pyo3(signature = (files, frfs, options, arguments, model))]
pub(crate) fn identify(
    py: Python<'_>,
    files: Vec<PathBuf>,
    frfs: Option<PyRef<'_, Frfs>>,
    options: ReadOptions,
    arguments: IdentifyArguments,
    model: Option<PyRef<'_, Model>>,
) -> PyResult<Identified> {
    let settings = arguments.settings()?;
    let structure = model.map(|m| Arc::clone(&m.0.model));
    let given = frfs.map(|f| Measurements {
        frfs: Some((*f.set).clone()),
        geometry: f.geometry.clone(),
        is_synthetic: f.is_synthetic,
        ..Measurements::default()
    });
    let stem = files.first().and_then(|f| f.file_stem()).map(|s| s.to_string_lossy().into_owned());
    let about = About {
        name: arguments.name.or(stem).unwrap_or_else(|| "test".to_string()),
        sources: if given.is_some() {
            vec!["arrays".to_string()]
        } else {
            files.iter().filter_map(|f| Some(f.file_name()?.to_string_lossy().into_owned())).collect()
        },
        configuration: arguments.configuration,
    };
    run(py, None, Stops::Never, move |_| {
        let (found, mut remarks) = match given {
            Some(mut found) => {
                forward_in_time(&mut found);
                (found, Vec::new())
            }
            None => options.read(&files)?,
        };
        let identified = identify_test(&found, &about, structure.as_deref(), &settings)?;
        remarks.extend(identified.remarks.iter().map(|r| match r {
            workflows::Remark::Note(text) => ("note", text.clone()),
            workflows::Remark::Warning(text) => ("warning", text.clone()),
        }));
        Ok(Identified { identified, remarks })
    })
}
