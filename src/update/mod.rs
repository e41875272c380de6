//! The workflow: compare a model with a test, update it, and say what came of it.
//!
//! [`assess`] compares at one θ; [`update`] is the whole fit, readable from top to bottom.

mod assessment;
mod correlate;
mod pretest;
mod settings;
mod twin;

pub use assessment::{AssessedPair, Assessment, ModeName, UnpairedMode, assess, name_modes};
pub use correlate::{
    BandAgreement, ChannelAgreement, FrfSensitivity, Functions, FunctionsOptions, MASS_ROWS, MassReduction,
    ModeAgreement, Orthogonality, ParameterInformation, Places, PlacesError, PlacesOptions, ReferenceShift,
    Sensitivities, SensitivityOptions, SensorAgreement, SensorReport, compare_functions, frf_sensitivities, judge,
    load_profile, member_stiffnesses, mode_agreement, orthogonality, places, sensitivities, sensor_agreement,
};
pub use pretest::{Pretest, PretestOptions, TargetMode, pretest};
pub use settings::{Cost, Settings};
pub use twin::{SensorFault, TwinError, TwinFrfOptions, TwinOptions, node_sensors, twin_frfs, twin_modes};

use crate::correlation::CorrelationError;
use crate::data::TestData;
use crate::model::ParametricModel;
use crate::objective::{Comparison, EvalError, LeastSquares, Objective, PaperCost, Scaling};
use crate::optim::{Checkpoint, Evaluator, Observer, OptimError, Optimizer, Optimum, Run};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What an update did.
#[derive(Debug, Clone)]
pub struct Update {
    /// The comparison before: at the estimates, moved into their bounds.
    pub before: Assessment,
    /// The comparison at the optimum.
    pub after: Assessment,
    /// The cost at the start, of the objective that was minimised.
    pub cost_before: f64,
    /// The search: best point, termination, history.
    pub optimum: Optimum,
    /// Every parameter with its values before and after.
    pub parameters: Vec<ParameterChange>,
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

/// Why there is no comparison or no update.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// Model and test do not fit together.
    #[error(transparent)]
    Correlation(#[from] CorrelationError),
    /// The model has no modes at its estimates.
    #[error("the model cannot be evaluated at its estimates: {0}")]
    Start(#[from] EvalError),
    /// The search failed.
    #[error(transparent)]
    Optimizer(#[from] OptimError),
    /// Nothing may change.
    #[error(
        "no parameter of the model has bounds, so nothing can be updated; give `bounds: [low, high]` to those that may change"
    )]
    NothingFree,
    /// Nothing to compare with.
    #[error("the test has no modes to compare with")]
    NoModes,
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

/// Fits the free parameters of a model to a test.
///
/// ```text
/// pair and compare at the estimates -> minimise the cost over the bounds -> pair and compare at the optimum
/// ```
pub fn update(
    model: &dyn ParametricModel,
    test: &TestData,
    settings: &Settings,
    controls: Controls<'_>,
) -> Result<Update, UpdateError> {
    if test.modes.is_empty() {
        return Err(UpdateError::NoModes);
    }
    let comparison = Comparison::new(model, test, settings.pairing())?;
    let scaling = Scaling::new(model);
    if scaling.is_empty() {
        return Err(UpdateError::NothingFree);
    }
    let before = assess(&comparison, &model.parameters().nominal())?;
    let paper;
    let least_squares;
    let objective: &dyn Objective = match settings.cost {
        Cost::Paper => {
            paper = PaperCost::new(&comparison);
            &paper
        }
        Cost::Frequencies => {
            paper = PaperCost::frequencies_only(&comparison);
            &paper
        }
        Cost::LeastSquares => {
            least_squares = LeastSquares::new(&comparison);
            &least_squares
        }
    };
    let start = scaling.x(&crate::objective::starting_point(model));
    let cost_before = objective.cost(&start)?;
    let optimum = settings.optimizer().minimize(&start, &mut controls.run(objective, settings.seed))?;
    let theta = scaling.theta(&optimum.x);
    let after = assess(&comparison, &theta)?;
    let parameters = model
        .parameters()
        .iter()
        .zip(&theta)
        .map(|(p, &value)| ParameterChange {
            name: p.name.clone(),
            unit: p.unit.clone(),
            before: p.display(p.value),
            after: p.display(value),
            lower: p.bounds.map(|b| p.display(b[0])),
            upper: p.bounds.map(|b| p.display(b[1])),
            at_bound: p.at_bound(value),
            after_si: value,
        })
        .collect();
    Ok(Update { before, after, cost_before, optimum, parameters })
}
