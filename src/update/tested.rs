//! Before a model meets a test: what the test leaves to the model, and what is doubtful about the two together.
//!
//! Every verb that takes a model and a test asks these, so that the command and a program see the same model, the same test and the
//! same remarks.

use super::{FirstLook, slip_of_unit, slips_of_readings};
use crate::correlation::{CorrelationError, check_functions, check_sensors, with_sensor_masses};
use crate::data::{FrfFit, TestData};
use crate::model::{Model, ParametricModel, Registry};
use crate::objective::is_damped;
use crate::units::four_digits;
use crate::yaml::Problem;

/// Models that are solved once more without anybody waiting for it.
const QUICK: usize = 1000;

/// Configurations that are tried without anybody waiting for it.
const FEW: usize = 30;

/// How many times better another configuration is: parameters that are still to be updated leave much in every one.
const FAR: f64 = 4.0;

/// Something to tell that is no error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Remark {
    /// What was done.
    Note(String),
    /// What is doubtful.
    Warning(String),
}

impl Remark {
    /// Its text.
    pub fn text(&self) -> &str {
        match self {
            Self::Note(text) | Self::Warning(text) => text,
        }
    }
}

/// Settles what a test leaves to the model that was tested, and looks for slips: of units, of readings, of a configuration.
///
/// * `is_asked` - whether the configuration was asked for, whatever the test names
/// * `configured` - the model in a configuration, if that can be had
pub fn meet(
    model: &Model,
    test: &mut TestData,
    is_asked: bool,
    configured: &dyn Fn(&str) -> Option<Model>,
) -> Vec<Remark> {
    let mut remarks: Vec<Remark> = settle_loss_factor(model, test).into_iter().map(Remark::Note).collect();
    if model.dof_map().n_dof() > QUICK {
        return remarks;
    }
    let mut warn = |text: String| remarks.push(Remark::Warning(text));
    if let Ok(Some(slip)) = slip_of_unit(model, test) {
        warn(slip);
    }
    slips_of_readings(model, test).unwrap_or_default().into_iter().for_each(&mut warn);
    let is_few = model.spec().configurations.len() <= FEW;
    if !is_asked && test.configuration.is_none() && is_few {
        better_configuration(model, test, configured).into_iter().for_each(warn);
    }
    remarks
}

/// Gives the functions of a model without damping the loss factor that the measured damping ratios tell, where the file gives none.
fn settle_loss_factor(model: &Model, test: &mut TestData) -> Option<String> {
    let usual = FrfFit::usual_loss_factor(&test.modes);
    let fit = test.frf_fit.as_mut().filter(|fit| fit.loss_factor.is_none())?;
    if is_damped(model) {
        return None;
    }
    fit.loss_factor = usual;
    Some(match usual {
        Some(eta) => format!(
            "frfs: no `loss_factor` is given, and the model has no damping: {} is taken, twice the median of the measured damping ratios",
            four_digits(eta)
        ),
        None => "frfs: no `loss_factor` is given, the model has no damping, and none was measured: near resonances its amplitudes will be too large"
            .to_string(),
    })
}

/// Says so when another configuration explains a test far better that names none.
fn better_configuration(model: &Model, test: &TestData, configured: &dyn Fn(&str) -> Option<Model>) -> Option<String> {
    let own = FirstLook::new(model, test).ok()?;
    let look = |name: &String| FirstLook::new(&configured(name)?, test).ok();
    let names = model.spec().configurations.keys();
    let better = names.filter_map(|name| Some((look(name)?, name))).filter(|(l, _)| l.is_far_better(&own, FAR));
    let (best, name) = better.min_by(|a, b| a.0.chi_squared.total_cmp(&b.0.chi_squared))?;
    Some(format!(
        "it names no configuration; before any update `{name}` explains it {} times better than the base model: is `configuration: {name}` missing?",
        four_digits(own.chi_squared / best.chi_squared)
    ))
}

/// The problems of the sensors and functions of a test on a model, without their places in the file.
pub fn check_on_model(model: &Model, test: &TestData) -> Vec<Problem> {
    let mut problems = check_sensors(model, &test.sensors);
    problems.extend(check_functions(model, test));
    problems
}

/// The model with the masses of the sensors of a test, and what they weigh together, kg; none where no sensor states its mass.
///
/// # Errors
/// A sensor without a place; a model that refuses the masses.
pub fn loaded(model: &Model, test: &TestData) -> Result<Option<(Model, f64)>, CorrelationError> {
    let (spec, total) = with_sensor_masses(model, &test.sensors)?;
    if total <= 0.0 {
        return Ok(None);
    }
    let (model, _) = Model::new(spec, &Registry::builtin())
        .map_err(|p| CorrelationError::Model(p.first().map_or(String::new(), |p| p.message.clone())))?;
    Ok(Some((model, total)))
}
