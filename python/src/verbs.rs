//! The verbs: arguments in, results out, everything between by the library.

use crate::answers::{Compared, Diagnosed, Identified, Learned, Sampled, Twin, Updated, compared};
use crate::error::Wrong;
use crate::model::{Model, quantity_of};
use crate::own::{Failure, OwnEffect, OwnFault, OwnOptimizer, OwnResidual, settled};
use crate::page::Made;
use crate::running::{Job, Stops, run};
use crate::test::{Frfs, Test, TestSource};
use crate::tested::{Given, Pairing, Tested, all_tested, cases, tested};
use pyo3::prelude::*;
use retune::catalogue::{Choice as _, did_you_mean};
use retune::data::convert::Duplicates;
use retune::data::{Answers, Measurements, TestData, corrected_functions, joined, read_measurements};
use retune::diagnosis::{self, Listener, Until, diagnose_tests, learn_from_tests};
use retune::effect::{Effect, Effects};
use retune::fault::{Fault, Faults};
use retune::identify::{IdentifyOptions, forward_in_time};
use retune::model::{Model as Structure, ParametricModel as _};
use retune::objective::Residuals;
use retune::optim::{Checkpoint, Evaluator, OptimizerSpec, Own, Progress, Shared, Threads, Tmcmc};
use retune::report::{Case, add_before, add_diagnosis, add_responses, answer, assess_paired, html, json, live_unasked};
use retune::units::Scalar;
use retune::update::{
    self as workflows, About, AgreementOptions, Controls, Cost, IdentifySettings, MassReduction, Method, ObjectiveSpec,
    Placement, PretestOptions, Settings, TwinFault, TwinFrfOptions, TwinOptions, TwinStory, Window, agreement,
    identify_test, load_profile, node_sensors, sample_posterior_by, twin_frfs, twin_modes, update_to_tests,
};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

type Tests<'py> = Vec<PyRef<'py, Test>>;
type OneProgress<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

fn made(given: &Given, tests: &[Arc<TestSource>], call: &'static str, seed: Option<u64>) -> Made {
    Made { given: given.clone(), tests: tests.to_vec(), call, seed }
}

fn sources(tests: &Tests<'_>) -> Vec<Arc<TestSource>> {
    tests.iter().map(|t| Arc::clone(&t.0)).collect()
}

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

/// Residual terms of the user's.
pub(crate) type OwnTerms<'py> = Vec<PyRef<'py, OwnResidual>>;

pub(crate) fn failures(terms: &OwnTerms<'_>) -> Vec<&'static Failure> {
    terms.iter().map(|own| &own.0.failure).collect()
}

/// A method by its name or settings, or one of the user's.
#[derive(FromPyObject)]
pub(crate) enum Searcher<'py> {
    /// YAML.
    Said(String),
    /// A Python object.
    Own(PyRef<'py, OwnOptimizer>),
}

/// Settings that update, sample and an objective share.
pub(crate) fn settings(
    cost: &str,
    (objective, terms): (Option<&str>, &OwnTerms<'_>),
    pairing: &Pairing,
    optimizer: Option<&Searcher<'_>>,
    seed: u64,
    reduced: Option<f64>,
) -> Result<Settings, Wrong> {
    let cost = Cost::parse(cost).map_err(|e| Wrong::text(format!("cost: {e}")))?;
    if let Some(t) = reduced.filter(|t| !(1e-9..=0.1).contains(t)) {
        return Err(Wrong::text(format!("reduced is {t}; it is a relative error of frequencies from 1e-9 to 0.1")));
    }
    let residuals = terms.iter().fold(Residuals::builtin(), |all, own| all.with(own.0));
    if cost != Cost::LeastSquares && !terms.is_empty() {
        return Err(Wrong::text(
            "residuals are terms of the cost least-squares; the other costs are whole as they are",
        ));
    }
    let objective = match objective {
        None => ObjectiveSpec { residuals, ..ObjectiveSpec::default() },
        Some(text) => ObjectiveSpec::read_with(text, residuals).map_err(|p| Wrong::problems(Some("objective"), p))?,
    };
    let method = |searcher: &Searcher<'_>| match searcher {
        Searcher::Said(text) => retune::yaml::read::<OptimizerSpec>(text).map(|(spec, _)| spec),
        Searcher::Own(own) => Ok(OptimizerSpec::Own(Own(own.0))),
    };
    let optimizer = optimizer.map(method).transpose().map_err(|p| Wrong::problems(Some("optimizer"), p))?;
    Ok(Settings { cost, pairing: pairing.how()?, optimizer, seed, objective, reduced })
}

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
    let found = run(py, None, Stops::WithItsBest, move |job| {
        let all = all_tested(&given, &tests, configuration.as_deref(), None)?;
        let sampler = Tmcmc { n_samples: samples, seed, cancel: Arc::clone(&job.stop), ..Tmcmc::default() };
        let shared = shard.map(|(index, of, folder)| Shared::new(&folder, index, of));
        let shared = shared.transpose().map_err(|e| Wrong::text(e.to_string()))?;
        let evaluator: &dyn Evaluator = shared.as_ref().map_or(&Threads, |shared| shared);
        let sampled = sample_posterior_by(&cases(&all), &settings, &sampler, evaluator)?;
        Ok(Sampled { sampled, all })
    });
    settled(found, failures(&residuals))
}

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
    settings: diagnosis::Settings,
    budget: Option<Duration>,
}

impl SearchOptions<'_> {
    fn tried(&self) -> Result<Tried, Wrong> {
        let known = Effects::builtin();
        let mut effects = if self.effects.is_empty() { Effects::builtin() } else { Effects::none() };
        for member in &self.effects {
            effects = effects.with(match member {
                EffectMember::Own(own) => own.0,
                EffectMember::Named(name) => known.find(name).ok_or_else(|| {
                    let suggestion = did_you_mean(name, known.iter().map(Effect::name));
                    Wrong::text(format!("there is no effect `{name}`{suggestion}"))
                })?,
            });
        }
        let mut faults = if self.faults.is_none() { Faults::builtin() } else { Faults::none() };
        let known = Faults::builtin();
        for member in self.faults.iter().flatten() {
            faults = faults.with(match member {
                FaultMember::Own(own) => own.0,
                FaultMember::Named(name) => known.find(name).ok_or_else(|| {
                    let suggestion = did_you_mean(name, known.iter().map(Fault::name));
                    Wrong::text(format!("there is no fault `{name}`{suggestion}"))
                })?,
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
        let settings = diagnosis::Settings {
            effects,
            places: self.places.clone(),
            effort: diagnosis::Effort::default().times(self.effort),
            faults,
            pairing: self.pairing.how()?,
            seed: self.seed,
            ..diagnosis::Settings::default()
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
    fn of(self, job: &Job) -> diagnosis::Settings {
        let mut until = Until::the_end().stopped_by(Arc::clone(&job.stop));
        if let Some(budget) = self.budget {
            until = until.elapsed(budget);
        }
        let job = job.clone();
        let listener = Listener::new(move |what| job.tell(what.to_string(), None, None));
        diagnosis::Settings { listener, until, ..self.settings }
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
    let (given, tests) = (Given::File(Arc::clone(&model.0)), sources(&tests));
    let made = made(&given, &tests, "retune.diagnose", Some(options.seed));
    let (tried, failures) = (options.tried()?, options.failures());
    let found = run(py, progress, Stops::WithItsBest, move |job| {
        let (base, all) = scene(&given, &tests)?;
        let settings = tried.of(job);
        let data: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
        let diagnosis = diagnose_tests(&base, &data, &settings)?;
        Ok(Diagnosed { diagnosis, all, how: settings.pairing, made })
    });
    settled(found, failures)
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
    let (given, tests) = (Given::File(Arc::clone(&model.0)), sources(&tests));
    let made = made(&given, &tests, "retune.learn", Some(options.seed));
    let (tried, failures) = (options.tried()?, options.failures());
    let found = run(py, progress, Stops::WithItsBest, move |job| {
        let (base, all) = scene(&given, &tests)?;
        let settings = tried.of(job);
        let data: Vec<&TestData> = all.iter().map(|t| &t.test).collect();
        let learned = learn_from_tests(&base, &data, &settings, take_best, usize::from(limit))?;
        Ok(Learned { learned, all, made })
    });
    settled(found, failures)
}

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

/// A number as a user writes it: `0.3 %`, `0.003`.
fn scalar(name: &str, text: &str, unit: &str) -> Result<f64, Wrong> {
    let value = Scalar::parse(text).map_err(|e| Wrong::text(format!("{name}: {e}")))?;
    value.constant_in(unit).map_err(|e| Wrong::text(format!("{name}: {e}")))
}

fn positive(name: &str, text: &str) -> Result<f64, Wrong> {
    let value = scalar(name, text, "1")?;
    if value > 0.0 { Ok(value) } else { Err(Wrong::text(format!("{name} is {text}; it must be above zero"))) }
}

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

fn synthetic(
    source: &crate::model::Source,
    sensors: Option<Vec<retune::data::Sensor>>,
    args: &TwinArguments,
) -> Result<Twin, Wrong> {
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
        let exciters = if args.exciters.is_empty() {
            sensors.first().map(|s| s.name.clone()).into_iter().collect()
        } else {
            args.exciters.clone()
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

type Remarks = Vec<(&'static str, String)>;

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
            let settings = diagnosis::Settings {
                seed,
                pairing: how,
                until: Until::the_end().stopped_by(Arc::clone(&job.stop)),
                listener: Listener::new(move |what| job.tell(what.to_string(), None, None)),
                ..diagnosis::Settings::default()
            };
            let found = diagnosis::diagnose(structure, data_of_test, &settings)?;
            add_diagnosis(&mut data, &found, structure, &joined(&[data_of_test]).test);
            hypotheses = found.hypotheses;
        }
        let assessment = assess_paired(structure, &structure.parameters().nominal(), data_of_test, &how)?;
        let case = Case { model: structure, test: data_of_test, assessment: &assessment };
        let before = earlier.as_ref().map(|(b, a)| Case { model: &b.model, test: data_of_test, assessment: a });
        data.live = live_unasked(case, &how, before.map(|b| b.model), &hypotheses);
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
