//! Before a model meets a test: what the test leaves to the model, and what is doubtful about the two together.
//!
//! Every verb that takes a model and a test asks these, so that the command and a program see the same model, the same test and the
//! same remarks.

use super::{FirstLook, slip_of_unit, slips_of_modes, slips_of_readings};
use crate::correlation::{CorrelationError, check_functions, check_sensors, with_sensor_masses};
use crate::data::{DampingError, FrfFit, TestData};
use crate::linalg::Complex;
use crate::model::{Model, ParametricModel};
use crate::objective::{is_damped, silent_functions};
use crate::units::four_digits;
use crate::yaml::Problem;
use std::sync::Arc;

/// Models that are solved once more without anybody waiting for it.
const QUICK: usize = 1000;

/// Configurations that are tried without anybody waiting for it.
const FEW: usize = 30;

/// How many times better another configuration is: parameters that are still to be updated leave much in every one.
const FAR: f64 = 4.0;

/// Something to tell that is not an error.
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
    remarks.extend(leave_out_silent_functions(model, test).map(Remark::Note));
    let mut warn = |text: String| remarks.push(Remark::Warning(text));
    if let Ok(Some(slip)) = slip_of_unit(model, test) {
        warn(slip);
    }
    slips_of_modes(model, test).unwrap_or_default().into_iter().for_each(&mut warn);
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
    fit.loss_factor = usual.map(|[eta, _]| eta);
    let error = usual.zip(test.frfs.as_ref()).and_then(|([eta, sd], set)| DampingError::new(sd, eta, set, &test.modes));
    fit.damping_error = error.map(Arc::new);
    Some(match usual {
        Some([eta, sd]) => format!(
            "frfs: no `loss_factor` is given, and the model has no damping: {} is taken, twice the median of the measured damping ratios; that of \
             a mode may differ from it by {:.0} %, as these scatter",
            four_digits(eta),
            1e2 * sd
        ),
        None => "frfs: no `loss_factor` is given, the model has no damping, and none was measured: near resonances its amplitudes will be too large"
            .to_string(),
    })
}

/// Functions that a note names.
const NAMED: usize = 4;

/// Takes the functions out of the fit that the model leaves without amplitude, because the force does not move their direction: the logarithm of
/// their ratio is infinite whatever the parameters are. What moves them in truth may be what the model lacks; then they count with it.
fn leave_out_silent_functions(model: &Model, test: &mut TestData) -> Option<String> {
    let silent = silent_functions(model, test).ok()?;
    let set = test.frfs.as_mut()?;
    let has_value = |&(reference, response): &(usize, usize)| {
        (0..set.n_lines()).any(|line| {
            let h = set.at(line, reference, response);
            h.is_finite() && h.norm_sqr() > 0.0
        })
    };
    let silent: Vec<(usize, usize)> = silent.into_iter().filter(has_value).collect();
    if silent.is_empty() || silent.len() == set.references.len() * set.responses.len() {
        return None;
    }
    let level = |reference: usize, response: usize| {
        let values = (0..set.n_lines()).map(|line| set.at(line, reference, response).norm_sqr());
        values.filter(|v| v.is_finite()).fold(0.0, f64::max).sqrt()
    };
    let named = |&(reference, response): &(usize, usize)| {
        let strongest = (0..set.responses.len()).map(|r| level(reference, r)).fold(0.0, f64::max);
        let db = 20.0 * (level(reference, response) / strongest).log10();
        format!("{} -> {} ({db:.0} dB)", set.references[reference].name, set.responses[response].name)
    };
    let mut names: Vec<String> = silent.iter().take(NAMED).map(named).collect();
    if silent.len() > NAMED {
        names.push(format!("{} more", silent.len() - NAMED));
    }
    for &(reference, response) in &silent {
        for line in 0..set.n_lines() {
            let i = set.index(line, reference, response);
            set.h[i] = Complex::new(f64::NAN, f64::NAN);
        }
    }
    Some(format!(
        "frfs: of the model the force does not move {}: {} left out of the fit (in brackets what was measured, against the strongest function of that force)",
        names.join(", "),
        if silent.len() == 1 { "it is" } else { "they are" }
    ))
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
    let (model, _) = Model::new(spec, model.registry())
        .map_err(|p| CorrelationError::Model(p.first().map_or(String::new(), |p| p.message.clone())))?;
    Ok(Some((model, total)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{FrfQuantity, read_test};
    use crate::model::{Registry, load};
    use crate::update::{TwinFrfOptions, TwinOptions, twin_frfs};

    const BEAM: &str = "
retune: 1
name: cantilever
nodes: {a: [0, 0, 0], b: [1 m, 0, 0]}
beams: {w: {nodes: [a, b], properties: {EA: 1e6 N, EIy: 50 N m2, EIz: 80 N m2, GJ: 20 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 0.01 kg m}, subdivide: 4}}
supports: {wall: {node: a}}
";
    const TEST: &str = "
retune_test: 1
name: shaker
sources: {made: {kind: synthetic, text: by hand}}
sensors: {up: {node: b, direction: +z}, side: {node: b, direction: +y}}
modes: [{frequency: 3.96 Hz, source: made}]
";

    /// A force along z of a straight beam moves nothing along y; a cable moves there in truth.
    #[test]
    fn functions_that_a_model_leaves_silent_are_left_out_with_a_note() {
        let model = load(BEAM, &Registry::builtin()).unwrap().0;
        let mut test = read_test(TEST).unwrap_or_else(|p| panic!("{p:?}")).0;
        let functions = TwinFrfOptions {
            lines_hz: (1..=30).map(f64::from).collect(),
            exciters: vec!["up".to_string()],
            quantity: FrfQuantity::Accelerance,
            force_noise: 0.0,
            response_noise: 0.0,
            n_averages: 1,
        };
        let theta = model.parameters().nominal();
        let options = TwinOptions { damping: Some(0.02), ..TwinOptions::default() };
        let mut set = twin_frfs(&model, &theta, &test.sensors, &options, &functions).unwrap();
        for line in 0..set.n_lines() {
            let (own, other) = (set.index(line, 0, 0), set.index(line, 0, 1));
            set.h[other] = set.h[own] * 1e-3;
        }
        test.frfs = Some(set);
        test.frf_fit = Some(FrfFit { relative_sd: 0.05, loss_factor: Some(0.04), ..FrfFit::default() });
        let remarks = meet(&model, &mut test, false, &|_| None);
        let told =
            remarks.iter().map(Remark::text).find(|t| t.starts_with("frfs:")).unwrap_or_else(|| panic!("{remarks:?}"));
        assert!(told.contains("does not move up -> side (-60 dB): it is left out"), "{told}");
        let set = test.frfs.as_ref().unwrap();
        assert!((0..set.n_lines()).all(|line| set.at(line, 0, 1).re.is_nan() && set.at(line, 0, 0).is_finite()));
        // Once is enough.
        assert!(meet(&model, &mut test, false, &|_| None).iter().all(|r| !r.text().contains("does not move")));
    }
}
