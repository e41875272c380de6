//! `retune.diagnose` and `retune.learn`

use super::shared::{OneProgress, Tests, made, sources};
use crate::answers::{Diagnosed, Learned};
use crate::error::Wrong;
use crate::model::Model;
use crate::own::{Failure, OwnEffect, OwnFault, settled};
use crate::page::Made;
use crate::running::{Job, Stops, run};
use crate::test::TestSource;
use crate::tested::{Given, Pairing, Tested, all_tested};
use pyo3::prelude::*;
use retune::catalogue::did_you_mean;
use retune::data::TestData;
use retune::effect::{Effect, Effects};
use retune::fault::{Fault, Faults};
use retune::model::Model as Structure;
use retune::update::HowToPair;
use retune_diagnosis::{Listener, Until, diagnose_tests, learn_from_tests};
use std::sync::Arc;
use std::time::Duration;

/// An effect by its name, or one of the user's.
#[derive(FromPyObject)]
pub(crate) enum EffectMember<'py> {
    /// Its name.
    Named(String),
    /// A Python object.
    Own(PyRef<'py, OwnEffect>),
}

/// A fault by its name, or one of the user's.
#[derive(FromPyObject)]
pub(crate) enum FaultMember<'py> {
    /// Its name.
    Named(String),
    /// A Python object.
    Own(PyRef<'py, OwnFault>),
}

/// A member of a list that is known by its name.
fn known_as<'a, T>(what: &str, name: &str, found: Option<T>, all: impl Iterator<Item = &'a str>) -> Result<T, Wrong> {
    found.ok_or_else(|| Wrong::text(format!("there is no {what} `{name}`{}", did_you_mean(name, all))))
}

/// What a diagnosis tries, and for how long.
#[derive(FromPyObject)]
pub(crate) struct SearchOptions<'py> {
    #[pyo3(item)]
    effects: Vec<EffectMember<'py>>,
    #[pyo3(item)]
    places: Vec<String>,
    #[pyo3(item)]
    budget: Option<f64>,
    #[pyo3(item)]
    effort: f64,
    #[pyo3(item)]
    seed: u64,
    /// All when absent.
    #[pyo3(item)]
    faults: Option<Vec<FaultMember<'py>>>,
    #[pyo3(item)]
    pairing: Pairing,
}

/// The same, free of Python.
struct Tried {
    settings: retune_diagnosis::Settings,
    budget: Option<Duration>,
}

impl SearchOptions<'_> {
    fn tried(&self) -> Result<Tried, Wrong> {
        let known = Effects::builtin();
        let mut effects = if self.effects.is_empty() { Effects::builtin() } else { Effects::none() };
        for member in &self.effects {
            effects = effects.with(match member {
                EffectMember::Own(own) => own.0,
                EffectMember::Named(name) => {
                    known_as("effect", name, known.find(name), known.iter().map(Effect::name))?
                }
            });
        }
        let known = Faults::builtin();
        let mut faults = if self.faults.is_none() { Faults::builtin() } else { Faults::none() };
        for member in self.faults.iter().flatten() {
            faults = faults.with(match member {
                FaultMember::Own(own) => own.0,
                FaultMember::Named(name) => known_as("fault", name, known.find(name), known.iter().map(Fault::name))?,
            });
        }
        let wrong = |seconds: f64| Wrong::text(format!("budget is {seconds}; it is a time above zero, in seconds"));
        let budget = |seconds: f64| {
            let budget = Duration::try_from_secs_f64(seconds).ok().filter(|b| !b.is_zero());
            budget.ok_or_else(|| wrong(seconds))
        };
        if !(self.effort > 0.0 && self.effort.is_finite()) {
            return Err(Wrong::text(format!("effort is {}; it is a factor above zero", self.effort)));
        }
        let settings = retune_diagnosis::Settings {
            effects,
            places: self.places.clone(),
            effort: retune_diagnosis::Effort::default().times(self.effort),
            faults,
            pairing: self.pairing.how()?,
            seed: self.seed,
            ..retune_diagnosis::Settings::default()
        };
        Ok(Tried { settings, budget: self.budget.map(budget).transpose()? })
    }

    /// What members of the user's may have raised.
    fn failures(&self) -> Vec<&'static Failure> {
        let effects = self.effects.iter().filter_map(|m| match m {
            EffectMember::Own(own) => Some(&own.0.failure),
            EffectMember::Named(_) => None,
        });
        let faults = self.faults.iter().flatten().filter_map(|m| match m {
            FaultMember::Own(own) => Some(&own.0.failure),
            FaultMember::Named(_) => None,
        });
        effects.chain(faults).collect()
    }
}

impl Tried {
    /// Settings that end with the job, or when the time is over that begins now.
    fn of(self, job: &Job) -> retune_diagnosis::Settings {
        let mut until = Until::the_end().stopped_by(Arc::clone(&job.stop));
        if let Some(budget) = self.budget {
            until = until.elapsed(budget);
        }
        let job = job.clone();
        let listener = Listener::new(move |what| job.tell(what.to_string(), None, None));
        retune_diagnosis::Settings { listener, until, ..self.settings }
    }
}

/// The model of the file and the tests, each with the model in its configuration.
type Scene = (Arc<Structure>, Vec<Tested>);

fn scene(given: &Given, tests: &[Arc<TestSource>]) -> Result<Scene, Wrong> {
    let Given::File(model) = given else { return Err(Wrong::text("a diagnosis needs a model file")) };
    if let Some(name) = &model.configuration {
        return Err(Wrong::text(format!(
            "the model is in its configuration `{name}`; a diagnosis takes the base model, and each test names its configuration"
        )));
    }
    Ok((Arc::clone(&model.model), all_tested(given, tests, None, None)?))
}

/// What a search has found, and what it was made of.
struct Searched<T> {
    found: T,
    all: Vec<Tested>,
    how: HowToPair,
    made: Made,
}

/// Searches with the settings of the options until Ctrl-C or the end of the budget, and raises what a member of the user's has raised.
///
/// * `search` - on the model, the tests and the settings
fn searched<T: Send + 'static>(
    py: Python<'_>,
    (model, tests): (&Model, &Tests<'_>),
    options: &SearchOptions<'_>,
    progress: OneProgress<'_, '_>,
    call: &'static str,
    search: impl FnOnce(&Structure, &[&TestData], &retune_diagnosis::Settings) -> Result<T, Wrong> + Send + 'static,
) -> PyResult<Searched<T>> {
    let (given, tests) = (Given::File(Arc::clone(&model.0)), sources(tests));
    let made = made(&given, &tests, call, Some(options.seed));
    let tried = options.tried()?;
    let found = run(py, progress, Stops::WithItsBest, move |job| {
        let (base, all) = scene(&given, &tests)?;
        let settings = tried.of(job);
        let data: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
        let found = search(&base, &data, &settings)?;
        Ok(Searched { found, all, how: settings.pairing, made })
    });
    settled(found, options.failures())
}

/// `retune diagnose`
#[pyfunction]
#[pyo3(signature = (model, tests, options, progress))]
pub(crate) fn diagnose(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    tests: Tests<'_>,
    options: SearchOptions<'_>,
    progress: OneProgress<'_, '_>,
) -> PyResult<Diagnosed> {
    let search = |base: &Structure, data: &[&TestData], settings: &_| Ok(diagnose_tests(base, data, settings)?);
    let Searched { found: diagnosis, all, how, made } =
        searched(py, (&model, &tests), &options, progress, "retune.diagnose", search)?;
    Ok(Diagnosed { diagnosis, all, how, made })
}

/// `retune learn`
#[pyfunction]
#[pyo3(signature = (model, tests, options, take_best, limit, progress))]
pub(crate) fn learn(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    tests: Tests<'_>,
    options: SearchOptions<'_>,
    take_best: bool,
    limit: u8,
    progress: OneProgress<'_, '_>,
) -> PyResult<Learned> {
    let search = move |base: &Structure, data: &[&TestData], settings: &_| {
        Ok(learn_from_tests(base, data, settings, take_best, usize::from(limit))?)
    };
    let Searched { found: learned, all, made, .. } =
        searched(py, (&model, &tests), &options, progress, "retune.learn", search)?;
    Ok(Learned { learned, all, made })
}
