//! Everything that a comparison tells: each part, or why there is none.

use super::coarse_mesh::{CoarseMesh, coarse_mesh};
use super::{
    Assessment, Functions, FunctionsOptions, HowToPair, MassReduction, ModeAgreement, Orthogonality, PairedTest,
    Places, PlacesOptions, Sensitivities, SensitivityOptions, SensorCheck, SensorReport, UpdateError, assess,
    check_sensors_by_model, compare_functions, compared, judge, mixed_modes, mode_agreement, orthogonality,
    paired_test, places, sensitivities, sensor_agreement,
};
use crate::correlation::{CloseModes, CorrelationError, CriteriaProfile, Judgement};
use crate::data::{FrfSet, TestData};
use crate::identify::health::{Finding, Level, check_silent};
use crate::model::{MOST_DENSE_DOFS, Model, ParametricModel};
use crate::objective::Comparison;

/// Sensors that MACCO takes away.
const REMOVED: usize = 5;
/// Above this number of dofs the places, the parameters and the sensors take seconds and wait to be asked for.
pub(super) const LARGE: usize = 600;

/// What a comparison is asked for; by default all that a model of few dofs answers at once.
#[derive(Debug, Clone, Copy, Default)]
pub struct AgreementOptions<'a> {
    /// How modes are paired.
    pub pairing: HowToPair,
    /// How the mass is reduced to the sensors. One that is asked for and does not exist is an error.
    pub reduction: MassReduction,
    /// Places also of a model with many dofs.
    pub places: bool,
    /// Parameters also of a model with many dofs.
    pub parameters: bool,
    /// Sensors against the motions of the model also for a model with many dofs.
    pub suspects: bool,
    /// Measured functions, in place of those that the test names.
    pub functions: Option<&'a FrfSet>,
    /// Edges of the bands of the functions, Hz, ascending; those of the test, or halfway between its modes, when empty.
    pub band_edges_hz: &'a [f64],
    /// Criteria to judge by.
    pub profile: Option<&'a CriteriaProfile>,
}

/// A model and a test side by side; of each part that there is not, why.
#[derive(Debug)]
pub struct Agreement {
    /// The test with the standing of its modes.
    pub test: TestData,
    /// Pairs, MAC, misfit.
    pub assessment: Assessment,
    /// How each pair stands against noise.
    pub modes: Vec<ModeAgreement>,
    /// Close modes that agree as a space and not one by one.
    pub mixed: Vec<CloseModes>,
    /// Every sensor.
    pub sensors: Result<SensorReport, String>,
    /// Orthogonality in the mass of the model.
    pub orthogonality: Result<Orthogonality, String>,
    /// Elements and groups.
    pub places: Result<Places, String>,
    /// What the test tells of the parameters.
    pub parameters: Result<Sensitivities, String>,
    /// Measured functions beside those of the model.
    pub functions: Option<Functions>,
    /// Pairs whose frequencies a coarse mesh moves.
    pub coarse_mesh: Vec<CoarseMesh>,
    /// What the motions of the model say of the sensors.
    pub suspects: Vec<Finding>,
    /// The judgement by the profile.
    pub judgement: Option<Judgement>,
}

/// Compares a model at its estimates with a test.
///
/// * `test` - sensors checked, see [`crate::correlation::check_sensors`]
///
/// # Errors
/// Nothing to compare with; sensors without a place; a reduction that was asked for and does not exist; functions that do not fit.
pub fn agreement(model: &Model, test: &TestData, options: &AgreementOptions<'_>) -> Result<Agreement, UpdateError> {
    if test.has_nothing() {
        return Err(UpdateError::NoData);
    }
    let PairedTest { test, check } = paired_test(model, None, test, &options.pairing)?;
    let comparison = compared(model, &test, &options.pairing)?;
    let assessment = assess(&comparison, &model.parameters().nominal())?;
    let a = &assessment;
    let n_dof = model.dof_map().n_dof();
    let orthogonality = with_orthogonality(&comparison, a, options.reduction)?;
    let waits = |asked: bool, option: &str| {
        (n_dof > LARGE && !asked).then(|| format!("{n_dof} dofs take a while: ask with --{option}"))
    };
    let is_too_large = n_dof > MOST_DENSE_DOFS;
    let too_large =
        || format!("found in models of up to {MOST_DENSE_DOFS} dofs; in this one of {n_dof}, `diagnose` names places");
    let places = match is_too_large.then(too_large).or_else(|| waits(options.places, "localize")) {
        Some(why) => Err(why),
        None => places(model, &comparison, a, PlacesOptions::default()).map_err(|e| e.to_string()),
    };
    let of_parameters = SensitivityOptions { n_modes: test.modes.len().max(1) };
    let parameters = match waits(options.parameters, "sensitivity") {
        Some(why) => Err(why),
        None => sensitivities(model, &test, of_parameters).map_err(|e| e.to_string()),
    };
    let functions = functions(&comparison, a, options)?;
    let modes = mode_agreement(&comparison, a)?;
    let mixed = mixed_modes(&comparison, a).map_err(CorrelationError::from)?;
    let sensors = sensor_agreement(&comparison, a, REMOVED)?.ok_or_else(|| NO_SHAPES.to_string());
    let suspects = match check {
        Some(check) => suspicions(check, &test),
        None if options.suspects || n_dof <= LARGE => suspects(model, &model.parameters().nominal(), &test)?,
        None => Vec::new(),
    };
    let coarse_mesh = coarse_mesh(model, &test, a)?;
    let judgement = options.profile.map(|p| judge(&comparison, a, orthogonality.as_ref().ok(), p));
    drop(comparison);
    Ok(Agreement {
        test,
        assessment,
        modes,
        mixed,
        sensors,
        orthogonality,
        places,
        parameters,
        functions,
        coarse_mesh,
        suspects,
        judgement,
    })
}

const NO_SHAPES: &str = "no measured shape is paired with a mode of the model";

/// What a model at its estimates says of the sensors of a test.
///
/// # Errors
/// As [`check_sensors_by_model`].
pub fn sensors_by_model(model: &Model, test: &TestData, n_suspension: usize) -> Result<Vec<Finding>, UpdateError> {
    let theta = model.parameters().nominal();
    Ok(check_sensors_by_model(model, &theta, &test.sensors, &test.modes, n_suspension)?.findings)
}

/// What is wrong with the sensors of a test, as the motions of a model at θ tell; what cannot be decided is for the check of the test.
///
/// # Errors
/// As [`check_sensors_by_model`].
pub(super) fn suspects(
    model: &dyn ParametricModel,
    theta: &[f64],
    test: &TestData,
) -> Result<Vec<Finding>, UpdateError> {
    if test.modes.iter().all(|m| m.shape.is_none()) {
        return Ok(Vec::new());
    }
    Ok(suspicions(check_sensors_by_model(model, theta, &test.sensors, &test.modes, 0)?, test))
}

fn suspicions(check: SensorCheck, test: &TestData) -> Vec<Finding> {
    let mut found = check.findings;
    found.retain(|f| f.level > Level::Info);
    found.extend(check_silent(&test.sensors, &test.modes));
    found
}

fn with_orthogonality(
    comparison: &Comparison<'_>,
    a: &Assessment,
    reduction: MassReduction,
) -> Result<Result<Orthogonality, String>, UpdateError> {
    match orthogonality(comparison, a, reduction) {
        // A reduction that was asked for and does not exist is a wrong question.
        Err(e) if reduction != MassReduction::Auto => Err(e.into()),
        Err(e) => Ok(Err(e.to_string())),
        Ok(found) => Ok(found.ok_or_else(|| NO_SHAPES.to_string())),
    }
}

fn functions(
    comparison: &Comparison<'_>,
    a: &Assessment,
    asked: &AgreementOptions<'_>,
) -> Result<Option<Functions>, UpdateError> {
    let test = comparison.test();
    let (set, mut options) = match (asked.functions, &test.frfs, &test.frf_fit) {
        (Some(set), ..) => (set, FunctionsOptions::default()),
        (None, Some(set), Some(fit)) => (set, FunctionsOptions::of_fit(fit)),
        _ if asked.band_edges_hz.is_empty() => return Ok(None),
        _ => return Err(UpdateError::NoFunctions),
    };
    if !asked.band_edges_hz.is_empty() {
        options.bands_hz = asked.band_edges_hz.windows(2).map(|e| [e[0], e[1]]).collect();
    }
    Ok(Some(compare_functions(comparison, a, set, &options)?))
}
