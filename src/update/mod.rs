//! The workflow: compare a model with a test, update it, and say what came of it.
//!
//! [`assess`] compares at one θ; [`update`] is the whole fit, readable from top to bottom.

mod agreement;
mod alternatives;
mod assessment;
mod coarse_mesh;
mod correlate;
mod error;
mod guard;
mod identified;
mod marginals;
mod momentum;
mod objective;
mod objective_spec;
mod pairing;
mod peaks;
mod pretest;
mod reduced;
mod regularization;
mod search;
mod settings;
mod tested;
mod trust;
mod twin;
mod uncertainty;
mod valley;

pub use agreement::{Agreement, AgreementOptions, agreement, sensors_by_model};
pub use alternatives::Alternative;
pub use assessment::{AssessedPair, AssessedReading, Assessment, ModeName, UnpairedMode, assess, name_modes};
pub use coarse_mesh::{CoarseMesh, coarse_mesh_text};
pub use correlate::{
    BandAgreement, ChannelAgreement, FirstLook, FrfSensitivity, Functions, FunctionsOptions, MASS_ROWS, MassReduction,
    ModeAgreement, ModelFunctions, Orthogonality, ParameterInformation, Places, PlacesError, PlacesOptions,
    ReferenceShift, Sensitivities, SensitivityOptions, SensorAgreement, SensorReport, compare_functions,
    frf_sensitivities, judge, load_profile, member_stiffnesses, mixed_modes, mode_agreement, orthogonality, places,
    sensitivities, sensor_agreement, slip_of_unit, slips_of_modes, slips_of_readings,
};
pub use error::UpdateError;
pub use identified::{
    About, Identified, IdentifySettings, Method, Way, Window, held_modes, identify_test, instead, place, points_of,
    with_roving_responses,
};
pub use marginals::{Marginal, QUANTILES, marginals, sampled_values};
pub use momentum::{SensorChange, SensorCheck, ShapeMomentum, check_sensors_by_model};
pub use objective_spec::{LimitSpec, ObjectiveSpec, Regularization};
pub use pairing::as_given;
pub use pairing::{HowToPair, PairedTest, compared, freed, paired_at, paired_test};
pub use peaks::Peak;
pub use pretest::{Placement, Pretest, PretestOptions, TargetMode, pretest};
pub use reduced::ReducedSearch;
pub use search::with_objective;
pub use settings::{Cost, Settings};
pub use tested::{Remark, check_on_model, loaded, meet};
pub use twin::{
    TwinError, TwinFault, TwinFrfOptions, TwinOptions, TwinStory, driving_sensor, node_sensors, spread_sensors,
    twin_frfs, twin_modes,
};
pub use uncertainty::{Basis, Held, Inseparable, IntervalMethod, ParameterUncertainty, Uncertainty, uncertainty};

use self::pairing::SettledPairs;
use self::reduced::ReducedCases;
use crate::correlation::Misfit;
use crate::data::TestData;
use crate::identify::health::Finding;
use crate::linalg::DVector;
use crate::model::{Parameter, ParametricModel};
use crate::objective::{Augmented, Comparison, Objective, Scaling};
use crate::optim::{Checkpoint, Evaluator, Observer, OptimError, Optimizer, Optimum, Posterior, Run, Threads, Tmcmc};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What an update did.
#[derive(Debug, Clone)]
pub struct Update {
    /// The comparison with the first test before: at the estimates.
    pub before: Assessment,
    /// The comparison with the first test at the optimum.
    pub after: Assessment,
    /// The other tests of a fit to several.
    pub further: Vec<FurtherTest>,
    /// The cost at the start, of the objective that was minimised.
    pub cost_before: f64,
    /// The search: best point, termination, history.
    pub optimum: Optimum,
    /// Every parameter with its values before and after.
    pub parameters: Vec<ParameterChange>,
    /// How certain the free ones are.
    pub uncertainty: Uncertainty,
    /// Other sets of parameters that fit as well as these, best first; none for a cost that is not a misfit.
    pub alternatives: Vec<Alternative>,
    /// What the motions of the fitted model say of the sensors of every test; nothing of a model with many dofs.
    pub suspects: Vec<Vec<Finding>>,
    /// Names of the sensors of every test that took no part in the fit, as the motions of the model at the estimates contradict them.
    pub left_out: Vec<Vec<String>>,
    /// The weight of the pull towards the estimates, where there is one.
    pub regularization: Option<f64>,
    /// The search on reduced models, where it was asked for; `optimum` then counts evaluations of the full ones.
    pub reduced: Option<ReducedSearch>,
}

/// One more test of a fit to several.
#[derive(Debug, Clone)]
pub struct FurtherTest {
    /// Its name.
    pub name: String,
    /// The comparison at the estimates.
    pub before: Assessment,
    /// The comparison at the optimum.
    pub after: Assessment,
}

/// A parameter before and after an update, in the unit of its tables.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterChange {
    /// Its name.
    pub name: String,
    /// The unit of the values below.
    pub unit: String,
    /// Estimate in the file.
    pub before: f64,
    /// At the optimum.
    pub after: f64,
    /// Lower bound; `None` for a constant.
    pub lower: Option<f64>,
    /// Upper bound; `None` for a constant.
    pub upper: Option<f64>,
    /// Whether the optimum lies on a bound: a message about the model rather than a result.
    pub at_bound: bool,
    /// At the optimum, SI.
    pub after_si: f64,
}

/// How a run is watched, limited and stopped; none of it changes the result of a run that ends by itself.
#[derive(Default)]
pub struct Controls<'a> {
    /// Largest number of evaluations.
    pub budget: Option<u64>,
    /// Stops cleanly once true, keeping the best point.
    pub cancel: Option<Arc<AtomicBool>>,
    /// Told about every batch.
    pub observer: Option<&'a mut dyn Observer>,
    /// Who evaluates; threads when absent.
    pub evaluator: Option<&'a dyn Evaluator>,
    /// Where the state of the search is kept.
    pub checkpoint: Option<Checkpoint>,
}

impl Controls<'_> {
    /// A run over an objective under these controls.
    fn run<'r>(self, objective: &'r dyn Objective, seed: u64) -> Run<'r>
    where
        Self: 'r,
    {
        let mut run = Run::new(objective).seed(seed);
        if let Some(budget) = self.budget {
            run = run.budget(budget);
        }
        if let Some(cancel) = self.cancel {
            run = run.cancel(cancel);
        }
        if let Some(observer) = self.observer {
            run = run.observer(observer);
        }
        if let Some(evaluator) = self.evaluator {
            run = run.evaluator(evaluator);
        }
        if let Some(checkpoint) = self.checkpoint {
            run = run.checkpoint(checkpoint);
        }
        run
    }
}

/// A test, and the model in the configuration that was tested.
#[derive(Debug, Clone, Copy)]
pub struct TestCase<'a> {
    /// The model with the supports and masses of the test.
    pub model: &'a dyn ParametricModel,
    /// The test.
    pub test: &'a TestData,
}

/// Fits the free parameters of a model to a test.
///
/// ```text
/// pair and compare at the estimates -> minimise the cost over the bounds -> pair and compare at the optimum
///                                   -> how certain each parameter is
/// ```
pub fn update(
    model: &dyn ParametricModel,
    test: &TestData,
    settings: &Settings,
    controls: Controls<'_>,
) -> Result<Update, UpdateError> {
    update_to_tests(&[TestCase { model, test }], settings, controls)
}

/// Fits the parameters of one structure to several tests of it at once, each in its own configuration.
///
/// The models are the same structure with other supports and masses: they have the same parameters. The costs of the
/// tests add; priors and targets count once, with the first test whose model has them.
pub fn update_to_tests(
    cases: &[TestCase<'_>],
    settings: &Settings,
    controls: Controls<'_>,
) -> Result<Update, UpdateError> {
    let reduction = reduced::tolerance(cases, settings).map(|t| ReducedCases::new(cases, t)).transpose()?;
    let settled = match &reduction {
        Some(reduction) => Settled::new(&reduction.cases(), settings)?,
        None => Settled::new(cases, settings)?,
    };
    let given = cases;
    let cases = &settled.cases(cases)[..];
    let comparisons = compare_all(cases, settings)?;
    let model = comparisons[0].model();
    let scaling = Scaling::for_search(model);
    let assess_all = |theta: &[f64]| comparisons.iter().map(|c| assess(c, theta)).collect::<Result<Vec<_>, _>>();
    let nominal = model.parameters().nominal();
    let before = assess_all(&nominal)?;

    let starting_point = crate::objective::starting_point(model);
    let start = scaling.x(&starting_point);
    let data = objective::stack(&comparisons, settings, &scaling, settings.cost);
    let walls = settings.objective.walls(model, &scaling).map_err(UpdateError::Limits)?;
    let regularization = match settings.cost {
        Cost::LeastSquares => settings.objective.regularization,
        Cost::Paper | Cost::Frequencies => Regularization::None,
    };
    let weight = regularization::weight(regularization, &data, &start, &walls)?;
    let objective = Augmented::new(&data, weight, start.clone(), walls.clone());
    let squares = objective::stack(&comparisons, settings, &scaling, Cost::LeastSquares);
    let judge = Augmented::new(&squares, weight, start.clone(), walls.clone());
    // What is asked for often is asked of the reduced models.
    let reduced_cases = reduction.as_ref().map(ReducedCases::cases).unwrap_or_default();
    let reduced_cases = settled.cases(&reduced_cases);
    let on_reduced = reduction.as_ref().map(|_| compare_all(&reduced_cases, settings)).transpose()?;
    let often = on_reduced.as_ref().unwrap_or(&comparisons);
    let [reduced_data, reduced_squares] =
        [settings.cost, Cost::LeastSquares].map(|cost| objective::stack(often, settings, &scaling, cost));
    let judged_often = Augmented::new(&reduced_squares, weight, start.clone(), walls.clone());
    let cost_before = objective.cost(&start)?;
    // Where the pairs were found the parameters are near them: a fit that starts there does not stick on its way.
    let near = settled.theta.as_ref().map(|theta| scaling.x(theta));
    let begin = match &near {
        Some(x) if objective.cost(x).is_ok_and(|cost| cost < cost_before) => x,
        _ => &start,
    };
    let optimizer = settings.optimizer_for(model);
    let (cancel, is_free) = (controls.cancel.clone(), controls.budget.is_none());
    let afterwards = || Controls { cancel: cancel.clone(), ..Controls::default() };
    let as_before = |optimum: Optimum, objective: &dyn Objective| match settings.cost {
        Cost::LeastSquares => guard::unseen_as_before(optimum, objective, &start),
        Cost::Paper | Cost::Frequencies => optimum,
    };
    let (optimum, reduced) = match &reduction {
        None => {
            let found = optimizer.minimize(begin, &mut controls.run(&objective, settings.seed))?;
            (as_before(found, &objective), None)
        }
        Some(reduction) => {
            let searched = Augmented::new(&reduced_data, weight, start.clone(), walls.clone());
            let found = optimizer.minimize(begin, &mut controls.run(&searched, settings.seed))?;
            let found = as_before(found, &searched);
            let costs = [found.cost, objective.cost(&found.x)?];
            let summary = reduction.summary(found.evaluations + found.linearizations, costs);
            let refined =
                reduced::refiner(settings.cost).minimize(&found.x, &mut afterwards().run(&objective, settings.seed));
            let optimum = match refined {
                // Stopped: what the reduced model has found stands, with the cost of the full one.
                Err(OptimError::NoFinitePoint { evaluations: 0, .. }) => Optimum { cost: costs[1], ..found },
                refined => reduced::joined(found, refined?),
            };
            (optimum, Some(summary))
        }
    };

    let tried = optimum.x.clone();
    let partners = |x: &DVector<f64>| {
        let theta = scaling.theta(x);
        let of = |c: &Comparison<'_>| {
            let found = c.predict(&theta).ok()?;
            Some((0..c.test().modes.len()).map(|mode| found.partner(mode)).collect::<Vec<_>>())
        };
        comparisons.iter().map(of).collect::<Vec<_>>()
    };
    let (optimum, refused) = guard::no_worse(optimum, &judge, (&start, cost_before), partners);
    let theta = if optimum.x == start { starting_point.clone() } else { scaling.theta(&optimum.x) };
    let after = assess_all(&theta)?;
    let is_misfit = settings.cost == Cost::LeastSquares;
    let basis = if is_misfit {
        Basis::Minimum { allowance: (optimum.evaluations + optimum.linearizations).max(1_000) }
    } else {
        Basis::Propagated
    };
    let mut uncertainty = uncertainty(&judged_often, model, &scaling, &optimum.x, basis)?;
    if let Some(misfits) = refused {
        let at_start = assess_all(&starting_point)?;
        let there = assess_all(&scaling.theta(&tried))?;
        uncertainty.remarks.push(guard::refusal(misfits, &at_start, &there, optimum.x == start));
    } else if nominal == starting_point {
        uncertainty.remarks.extend(guard::pulled(&before, &after, is_misfit));
    }
    uncertainty.remarks.extend(doubt(cases, &after));
    uncertainty.remarks.extend(settled.without());
    let changes = |theta: &[f64], certain: &Uncertainty| changes(model, theta, certain);
    let mut alternatives = Vec::new();
    if is_misfit && !cancel.as_ref().is_some_and(|c| c.load(std::sync::atomic::Ordering::Relaxed)) {
        alternatives =
            self::alternatives::alternatives((model, &scaling), &judged_often, &optimum, changes, afterwards)?;
        if is_free && !is_large(model) {
            let in_words = |x: &DVector<f64>| changes(&scaling.theta(x), &uncertainty);
            let lower = guard::lower_elsewhere(&judge, &optimum, &optimizer, in_words, afterwards(), settings.seed);
            uncertainty.remarks.extend(lower);
        }
    }
    let parameters = changes(&theta, &uncertainty);
    let of = |c: &TestCase<'_>| {
        let is_small = c.model.dof_map().n_dof() <= agreement::LARGE;
        if is_small { agreement::suspects(c.model, &theta, c.test) } else { Ok(Vec::new()) }
    };
    let suspects = given.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    let mut pairs = before.into_iter().zip(after);
    let Some((before, after)) = pairs.next() else { return Err(UpdateError::NoData) };
    let further = cases[1..].iter().zip(pairs);
    let further =
        further.map(|(c, (before, after))| FurtherTest { name: c.test.name.clone(), before, after }).collect();
    let regularization = (weight > 0.0).then_some(weight);
    Ok(Update {
        before,
        after,
        further,
        cost_before,
        optimum,
        parameters,
        uncertainty,
        alternatives,
        suspects,
        left_out: settled.left_out.clone(),
        regularization,
        reduced,
    })
}

/// Every parameter with its values before and after, in the units of its tables.
fn changes(model: &dyn ParametricModel, theta: &[f64], certain: &Uncertainty) -> Vec<ParameterChange> {
    let on_bound = |name: &str| certain.parameters.iter().any(|k| k.name == name && k.on_bound);
    let change = |(p, &value): (&Parameter, &f64)| ParameterChange {
        name: p.name.clone(),
        unit: p.unit.clone(),
        before: p.display(p.value),
        after: p.display(value),
        lower: p.bounds.map(|b| p.display(b[0])),
        upper: p.bounds.map(|b| p.display(b[1])),
        at_bound: on_bound(&p.name),
        after_si: value,
    };
    model.parameters().iter().zip(theta).map(change).collect()
}

/// Dofs from which on a search has to be thrifty.
const LARGE: usize = 120;

/// Whether a solution of a model takes long enough for a search to be thrifty.
fn is_large(model: &dyn ParametricModel) -> bool {
    model.dof_map().n_dof() >= LARGE
}

/// The posterior of a model over its bounds, and what is to be known of it.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// Its samples and evidence.
    pub posterior: Posterior,
    /// Its peaks by descending share; none where there is one.
    pub peaks: Vec<Peak>,
    /// The best sample against the tests, all together: a posterior is that of a model which can be right.
    pub misfit: Misfit,
    /// What reduced models had to do with it, if they were asked for: their cost at the best sample beside that of the full models.
    pub reduced: Option<ReducedSearch>,
}

/// Samples the posterior of the free parameters, and the evidence of the model; the objective is the least-squares cost of
/// the settings, the prior uniform between the bounds.
///
/// # Errors
/// As [`update_to_tests`]; the sampler finds no point that can be evaluated, or is cancelled.
pub fn sample_posterior(cases: &[TestCase<'_>], settings: &Settings, sampler: &Tmcmc) -> Result<Sampled, UpdateError> {
    sample_posterior_by(cases, settings, sampler, &Threads)
}

/// [`sample_posterior`] with an evaluator of one's own: [`Shared`](crate::optim::Shared) for several processes.
///
/// # Errors
/// As [`sample_posterior`]; an evaluator that fails.
pub fn sample_posterior_by(
    cases: &[TestCase<'_>],
    settings: &Settings,
    sampler: &Tmcmc,
    evaluator: &dyn Evaluator,
) -> Result<Sampled, UpdateError> {
    let Some(tolerance) = reduced::tolerance(cases, settings) else {
        let settled = Settled::new(cases, settings)?;
        return Ok(sample(&settled.cases(cases), settings, sampler, evaluator)?.0);
    };
    let reduction = ReducedCases::new(cases, tolerance)?;
    let settled = Settled::new(&reduction.cases(), settings)?;
    let cases = &settled.cases(cases)[..];
    let (found, weight) = sample(&settled.cases(&reduction.cases()), settings, sampler, evaluator)?;
    let posterior = &found.posterior;
    let mut costs = [f64::NAN; 2];
    if let Some(best) = posterior.best() {
        let comparisons = compare_all(cases, settings)?;
        let model = comparisons[0].model();
        let scaling = Scaling::new(model);
        let data = objective::stack(&comparisons, settings, &scaling, Cost::LeastSquares);
        let start = scaling.x(&crate::objective::starting_point(model));
        let walls = settings.objective.walls(model, &scaling).map_err(UpdateError::Limits)?;
        costs = [posterior.costs[best], Augmented::new(&data, weight, start, walls).cost(&posterior.samples[best])?];
    }
    let summary = reduction.summary(posterior.evaluations, costs);
    Ok(Sampled { reduced: Some(summary), ..found })
}

/// The posterior, and the weight of the pull towards the estimates in it.
fn sample(
    cases: &[TestCase<'_>],
    settings: &Settings,
    sampler: &Tmcmc,
    evaluator: &dyn Evaluator,
) -> Result<(Sampled, f64), UpdateError> {
    let comparisons = compare_all(cases, settings)?;
    let model = comparisons[0].model();
    let scaling = Scaling::new(model);
    if scaling.is_empty() {
        return Err(UpdateError::NothingFree);
    }
    let data = objective::stack(&comparisons, settings, &scaling, Cost::LeastSquares);
    let walls = settings.objective.walls(model, &scaling).map_err(UpdateError::Limits)?;
    let start = scaling.x(&crate::objective::starting_point(model));
    let weight = regularization::weight(settings.objective.regularization, &data, &start, &walls)?;
    let objective = Augmented::new(&data, weight, start.clone(), walls);
    let posterior = sampler.sample_by(&objective, evaluator)?;
    let peaks = peaks::peaks((model, &scaling), &objective, &posterior);
    let theta = scaling.theta(posterior.best().map_or(&start, |best| &posterior.samples[best]));
    let misfits = comparisons.iter().map(|c| Ok(assess(c, &theta)?.misfit)).collect::<Result<Vec<_>, UpdateError>>()?;
    let misfit = Misfit::combine(&misfits, scaling.len())?;
    Ok((Sampled { posterior, peaks, misfit, reduced: None }, weight))
}

/// The tests of a fit with the standing of their modes.
struct Settled {
    tests: Vec<TestData>,
    /// Names of the sensors of every test that take no part.
    left_out: Vec<Vec<String>>,
    /// Where the parameters have come with the pairs.
    theta: Option<Vec<f64>>,
}

impl Settled {
    /// Decides which modes are of the structure.
    fn new(cases: &[TestCase<'_>], settings: &Settings) -> Result<Self, UpdateError> {
        let comparisons = compare_all(cases, settings)?;
        let model = comparisons[0].model();
        let scaling = Scaling::new(model);
        if scaling.is_empty() {
            return Err(UpdateError::NothingFree);
        }
        let start = scaling.x(&crate::objective::starting_point(model));
        let how = settings.how(cases[0].test);
        let SettledPairs { tests, contradicted, x } = how.settle(&comparisons, &start, 0.0)?;
        let tests: Vec<TestData> =
            tests.iter().zip(&contradicted).map(|(test, sensors)| trust::without(test, sensors)).collect();
        let all = || tests.iter().flat_map(|t| &t.modes);
        let has_other = tests.iter().any(TestData::has_more_than_modes);
        if all().next().is_some() && !has_other && all().all(|m| m.standing.is_aside()) {
            let reasons =
                all().enumerate().filter_map(|(i, m)| Some(format!("mode {}: {}", i + 1, m.standing.reason()?)));
            return Err(UpdateError::NoPartner { reasons: reasons.take(6).collect::<Vec<_>>().join("; ") });
        }
        let name = |(test, sensors): (&TestData, Vec<usize>)| {
            sensors.into_iter().map(|s| test.sensors[s].name.clone()).collect()
        };
        let left_out = tests.iter().zip(contradicted).map(name).collect();
        Ok(Self { tests, left_out, theta: how.infers().then(|| scaling.theta(&x)) })
    }

    /// Which sensors took no part, in words.
    fn without(&self) -> Option<String> {
        let many = self.tests.len() > 1;
        let of = |(test, names): (&TestData, &Vec<String>)| {
            let names = names.join(", ");
            if many { format!("{names} of `{}`", test.name) } else { names }
        };
        let all: Vec<String> =
            self.tests.iter().zip(&self.left_out).filter(|(_, names)| !names.is_empty()).map(of).collect();
        (!all.is_empty()).then(|| {
            format!(
                "shapes at {} took no part in the fit: the motions of the model contradict them, whatever its stiffness; put the sensors right in the test file",
                all.join(" and ")
            )
        })
    }

    /// The models with these tests.
    fn cases<'a>(&'a self, cases: &[TestCase<'a>]) -> Vec<TestCase<'a>> {
        cases.iter().zip(&self.tests).map(|(c, test)| TestCase { model: c.model, test }).collect()
    }
}

/// Models and tests made comparable, after a check that they belong together.
fn compare_all<'a>(cases: &[TestCase<'a>], settings: &Settings) -> Result<Vec<Comparison<'a>>, UpdateError> {
    let first = cases.first().ok_or(UpdateError::NoData)?;
    for case in cases {
        let test = case.test;
        if test.has_nothing() {
            return Err(UpdateError::NoData);
        }
        if case.model.parameters() != first.model.parameters() {
            return Err(UpdateError::DifferentParameters { test: case.test.name.clone() });
        }
    }
    let compare = |c: &TestCase<'a>| Comparison::new(c.model, c.test, settings.pairing(c.test));
    Ok(cases.iter().map(compare).collect::<Result<_, _>>()?)
}

/// Intervals are those of a right model; whether it can be right.
fn doubt(cases: &[TestCase<'_>], after: &[Assessment]) -> Option<String> {
    let missed: Vec<String> = cases
        .iter()
        .zip(after)
        .filter(|(_, a)| a.misfit.p_value < 1e-3)
        .map(|(c, a)| {
            format!("`{}`, chi-squared {:.0} for {} data", c.test.name, a.misfit.chi_squared, a.misfit.n_data)
        })
        .collect();
    (!missed.is_empty()).then(|| {
        format!(
            "the model misses data by more than their noise ({}): the intervals hold for a right model and are too narrow for this one",
            missed.join("; ")
        )
    })
}
