//! Models and tests brought together, as the command does it.

use crate::error::Wrong;
use crate::external::{External, ExternalModel};
use crate::source::Source;
use crate::test::TestSource;
use pyo3::prelude::*;
use retune::data::TestData;
use retune::model::{Model, ParametricModel};
use retune::update::{HowToPair, Remark, TestCase, UpdateError, check_on_model, loaded, meet};
use retune::yaml::{Problem, Severity, SourceMap};
use std::sync::Arc;

/// The model of a verb.
#[derive(Debug, Clone)]
pub(crate) enum Given {
    /// Of a file or text.
    File(Arc<Source>),
    /// Around a solver of the user's.
    External(Arc<ExternalModel>),
}

impl<'py> FromPyObject<'_, 'py> for Given {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(model) = object.cast::<crate::model::Model>() {
            return Ok(Self::File(Arc::clone(&model.get().0)));
        }
        Ok(Self::External(Arc::clone(&object.cast::<External>()?.get().0)))
    }
}

/// A model that was tested.
#[derive(Debug, Clone)]
pub(crate) enum Structure {
    File(Arc<Model>),
    External(Arc<ExternalModel>),
}

impl Structure {
    /// For fits.
    pub(crate) fn parametric(&self) -> &dyn ParametricModel {
        match self {
            Self::File(model) => &**model,
            Self::External(model) => &**model,
        }
    }

    /// For what asks a model about its elements.
    pub(crate) fn file(&self) -> Result<&Model, Wrong> {
        match self {
            Self::File(model) => Ok(model),
            Self::External(model) => {
                let name = &model.name;
                Err(Wrong::text(format!("{name} has no elements that are known here: this needs a model file")))
            }
        }
    }
}

/// A test, and the model in its configuration.
#[derive(Debug, Clone)]
pub(crate) struct Tested {
    pub(crate) test: TestData,
    pub(crate) model: Structure,
    /// What is to be told, as (category, text): `note` or `warning`.
    pub(crate) remarks: Vec<(&'static str, String)>,
}

/// The tests beside the first, for a page.
pub(crate) fn others(all: &[Tested]) -> Result<Vec<(&Model, &TestData)>, Wrong> {
    all.iter().skip(1).map(|t| Ok((t.model.file()?, &t.test))).collect()
}

/// The model in the configuration that is asked for, else in the one that the test was made in; slips, and the places of the sensors.
pub(crate) fn tested(
    source: &Source,
    test: &TestSource,
    configuration: Option<&str>,
    sensor_masses: Option<bool>,
) -> Result<Tested, Wrong> {
    let mut data = test.data.clone();
    if data.has_nothing() {
        return Err(UpdateError::NoData.into());
    }
    let asked = configuration.or(source.configuration.as_deref());
    let mut model = match asked.or(data.configuration.as_deref()) {
        wanted if wanted == source.configuration.as_deref() => Arc::clone(&source.model),
        None => Arc::clone(&source.model),
        Some(name) => source.configured(name)?.model,
    };
    let configured = |name: &str| {
        let found = source.configured(name).ok()?;
        Arc::try_unwrap(found.model).ok()
    };
    let mut remarks: Vec<(&'static str, String)> = Vec::new();
    for remark in meet(&model, &mut data, asked.is_some(), &configured) {
        remarks.push(match remark {
            Remark::Note(text) => ("note", text),
            Remark::Warning(text) => ("warning", format!("{}: {text}", data.name)),
        });
    }
    let problems = SourceMap::of(&test.text).place(check_on_model(&model, &data));
    let file = test.home.name();
    if problems.iter().any(|p| p.severity == Severity::Error) {
        return Err(Wrong::problems(file.as_deref(), problems));
    }
    let shown = |p: &Problem| p.render(file.as_deref().unwrap_or(&data.name));
    remarks.extend(problems.iter().map(|p| ("warning", shown(p))));
    let Some(wanted) = sensor_masses else { return Ok(Tested { test: data, model: Structure::File(model), remarks }) };
    match loaded(&model, &data)? {
        None if wanted => return Err(Wrong::text("no sensor of the test states a `mass`")),
        Some((with, _)) if wanted => model = Arc::new(with),
        Some((_, total)) => {
            let text = format!("the sensors weigh {:.1} g together; sensor_masses=True puts them in", 1e3 * total);
            remarks.push(("note", text));
        }
        None => {}
    }
    Ok(Tested { test: data, model: Structure::File(model), remarks })
}

/// [`tested`] for several tests; one that is given twice would count twice.
pub(crate) fn all_tested(
    given: &Given,
    tests: &[Arc<TestSource>],
    configuration: Option<&str>,
    sensor_masses: Option<bool>,
) -> Result<Vec<Tested>, Wrong> {
    if tests.is_empty() {
        return Err(Wrong::text("there is no test"));
    }
    for (i, test) in tests.iter().enumerate() {
        let same = |other: &Arc<TestSource>| Arc::ptr_eq(other, test) || other.text == test.text;
        if tests[..i].iter().any(same) {
            return Err(Wrong::text(format!(
                "the test `{}` is given twice: its data would count twice",
                test.data.name
            )));
        }
    }
    let one = |test: &Arc<TestSource>| match given {
        Given::File(source) => tested(source, test, configuration, sensor_masses),
        Given::External(model) => {
            if test.data.has_nothing() {
                return Err(UpdateError::NoData.into());
            }
            // Another solver has its own configurations, and its sensors stand on its nodes.
            if configuration.is_some() || sensor_masses == Some(true) {
                let name = &model.name;
                return Err(Wrong::text(format!(
                    "{name} is not a model file: it has no configurations, and takes no masses"
                )));
            }
            let model = Structure::External(Arc::clone(model));
            Ok(Tested { test: test.data.clone(), model, remarks: Vec::new() })
        }
    };
    tests.iter().map(one).collect()
}

/// For the library.
pub(crate) fn cases(all: &[Tested]) -> Vec<TestCase<'_>> {
    all.iter().map(|t| TestCase { model: t.model.parametric(), test: &t.test }).collect()
}

/// How modes are paired: (rule, smallest MAC, frequency window).
#[derive(FromPyObject)]
pub(crate) struct Pairing(String, Option<f64>, Option<f64>);

impl Pairing {
    pub(crate) fn how(&self) -> Result<HowToPair, Wrong> {
        let by = HowToPair::by_word(&self.0).map_err(|e| Wrong::text(format!("pairing: {e}")))?;
        if let Some(mac) = self.1.filter(|v| !(0.0..=1.0).contains(v)) {
            return Err(Wrong::text(format!("min_mac is {mac}; it must be from 0 to 1, as a MAC is: 0.9 and not 90")));
        }
        if let Some(window) = self.2.filter(|v| !(v.is_finite() && *v >= 0.0)) {
            return Err(Wrong::text(format!("frequency_window is {window}; it must be zero or above, and finite")));
        }
        Ok(HowToPair { by, min_mac: self.1, frequency_window: self.2 })
    }
}
