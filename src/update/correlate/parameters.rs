//! What every parameter does to frequencies, shapes, functions and mass, and what a test can tell of it.

use crate::correlation::{
    CollinearGroup, Identifiability, Information, collinear_groups, identifiability, information,
};
use crate::data::TestData;
use crate::linalg::{Complex, DMatrix, DVector};
use crate::modal::{ModalDamping, Modes};
use crate::model::{MassProperties, Matrices, ModalSolver, ParametricModel};
use crate::objective::{Comparison, EvalError, LeastSquares, Objective, Scaling};
use crate::update::{ModeName, Settings, UpdateError, name_modes};
use std::f64::consts::TAU;

/// Singular values of the sensitivities below this share of the largest count as zero: exact derivatives leave about
/// 1e-12 where a combination has no effect, and a combination that moves the data by less than 1e-9 of what the strongest
/// one does is beyond every measurement.
const NO_EFFECT: f64 = 1e-9;
/// Relative standard deviation of a mass on scales.
const SCALES: f64 = 0.005;
/// Cosine above which two parameters do nearly the same to the data.
const COLLINEAR: f64 = 0.95;

/// Which modes are differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SensitivityOptions {
    /// Elastic modes.
    pub n_modes: usize,
}

/// What the test tells of one parameter.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ParameterInformation {
    /// Its name.
    pub name: String,
    /// Unit of the numbers below.
    pub unit: String,
    /// Value at which all is taken.
    pub value: f64,
    /// Its bounds.
    pub bounds: (f64, f64),
    /// Standard deviation that the test leaves when all others are known; `None` without any effect.
    pub sd_alone: Option<f64>,
    /// Standard deviation with all others free; `None` when the test does not determine it.
    pub sd: Option<f64>,
    /// (sd_alone/sd)²; 0 where undetermined.
    pub share: f64,
}

/// Sensitivities of a model, and what a test can tell with them.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    /// Names of the free parameters.
    pub names: Vec<String>,
    /// Their units in tables.
    pub units: Vec<String>,
    /// Width of each interval in that unit.
    pub widths: Vec<f64>,
    /// The modes.
    pub modes: Vec<ModeName>,
    /// ∂f/∂θ in Hz per unit of the parameter, (modes x parameters).
    pub frequency: DMatrix<f64>,
    /// Change of the shape at the sensors over the whole interval, relative, across the shape itself:
    /// width ‖(I - φφᵀ/φᵀφ) ∂φ/∂θ‖/‖φ‖, (modes x parameters); NaN for double modes.
    pub shape: DMatrix<f64>,
    /// ∂(mass, centre of gravity, inertia about it)/∂θ per unit: kg, m, kg m²; ten rows in the order of
    /// [`MASS_ROWS`]; no rows when the model does not know them.
    pub mass: DMatrix<f64>,
    /// Rank, combinations and groups, from the residuals of the test; `None` without a test.
    pub identifiability: Option<Identifiability>,
    /// The same with the total mass known, where that adds a combination: frequencies and shapes stay as they are when all
    /// stiffness and all mass grow together.
    pub weighed: Option<Identifiability>,
    /// Parameters that do nearly the same to the test.
    pub collinear: Vec<CollinearGroup>,
    /// What the test tells of each parameter; with the total mass known to 0.5 % where [`Self::weighed`] is there.
    pub information: Vec<ParameterInformation>,
}

/// What the rows of [`Sensitivities::mass`] are.
pub const MASS_ROWS: [&str; 10] = [
    "mass kg",
    "cg x m",
    "cg y m",
    "cg z m",
    "Ixx kg m2",
    "Iyy kg m2",
    "Izz kg m2",
    "Ixy kg m2",
    "Ixz kg m2",
    "Iyz kg m2",
];

/// Sensitivities at the estimates, moved into their bounds, for the bounded parameters of a model.
///
/// * `test` - its sensors observe the shapes, and its standard deviations make residuals of them
///
/// Frequencies and shapes are differentiated exactly (Fox and Kapoor, Nelson), mass properties by differences. What the
/// test tells comes from all of its data that an update would use, paired with open gates as there; priors and targets do not count. Local:
/// true near the point.
///
/// Errors: no bounded parameter; the model cannot be evaluated.
pub fn sensitivities(
    model: &dyn ParametricModel,
    test: &TestData,
    options: SensitivityOptions,
) -> Result<Sensitivities, UpdateError> {
    let scaling = Scaling::new(model);
    if scaling.is_empty() {
        return Err(UpdateError::NothingFree);
    }
    let theta = crate::objective::starting_point(model);
    let comparison = Comparison::new(model, test, Settings::default().pairing(test))?;
    let failed = |e: &dyn std::fmt::Display| UpdateError::Start(EvalError::Unsolvable { reason: e.to_string() });
    let n_elastic = options.n_modes.min(model.dof_map().n_dof());
    let solver = ModalSolver::new(model, &theta, n_elastic).map_err(|e| failed(&e))?;
    let (matrices, modes) = solver.solve(model, &theta, n_elastic).map_err(|e| failed(&e))?;
    let slopes = matrices.derivatives(model, &theta, scaling.free()).map_err(|e| failed(&e))?;
    let elastic = modes.elastic().skip(modes.n_mechanism);
    let of: Vec<usize> = elastic.clone().collect();
    let derivatives = solver.differentiate(model, &matrices, &slopes, &modes, &of).map_err(|e| failed(&e))?;
    let parameters = model.parameters();
    let unit = |k: usize| parameters.get(scaling.free()[k]).unit_factor;
    let n = scaling.len();
    let n_elastic = elastic.len();
    let mut frequency = DMatrix::zeros(n_elastic, n);
    let mut shape = DMatrix::from_element(n_elastic, n, f64::NAN);
    for ((row, mode), d) in elastic.clone().enumerate().zip(derivatives) {
        let (lambda, phi) = (modes.lambda[mode], modes.shapes.column(mode).into_owned());
        let per_lambda = modes.frequency_hz(mode) / (2.0 * lambda);
        for (k, slope) in slopes.iter().enumerate() {
            frequency[(row, k)] = per_lambda * slope.eigenvalue_derivative(lambda, &phi) * unit(k);
        }
        let Some(d) = d else { continue };
        let own = comparison.sensors() * &phi;
        let size = own.norm_squared();
        for k in 0..n {
            let turned = comparison.sensors() * d.shape.column(k);
            let across = if size > 0.0 { &turned - &own * (own.dot(&turned) / size) } else { turned };
            shape[(row, k)] = if size > 0.0 { across.norm() / size.sqrt() * scaling.width()[k] } else { 0.0 };
        }
    }
    let named = name_modes(model, &theta, &modes).map_err(|e| failed(&e))?;
    let mass = mass_sensitivities(model, &theta, &scaling).map_err(|e| failed(&e))?;
    let names: Vec<String> = scaling.free().iter().map(|&i| parameters.get(i).name.clone()).collect();
    let mut out = Sensitivities {
        units: scaling.free().iter().map(|&i| parameters.get(i).unit.clone()).collect(),
        widths: (0..n).map(|k| scaling.width()[k] / unit(k)).collect(),
        modes: elastic.map(|i| named[i].clone()).collect(),
        names,
        frequency,
        shape,
        mass: DMatrix::from_fn(mass.nrows(), n, |i, k| mass[(i, k)] * unit(k)),
        identifiability: None,
        weighed: None,
        collinear: Vec::new(),
        information: Vec::new(),
    };
    if LeastSquares::new(&comparison).terms().iter().any(|term| term.is_data() && !term.is_empty(&comparison)) {
        inform(&mut out, &comparison, &scaling, &theta)?;
    }
    Ok(out)
}

/// Adds what the test tells.
fn inform(
    out: &mut Sensitivities,
    comparison: &Comparison<'_>,
    scaling: &Scaling,
    theta: &[f64],
) -> Result<(), UpdateError> {
    let objective = LeastSquares::new(comparison).without(|term| !term.is_data());
    let jacobian = objective.linearize(&scaling.x(theta))?.jacobian;
    // Coefficients of combinations in the units of the tables.
    let seen = identifiability(&jacobian, &out.names, Some(&out.widths), NO_EFFECT)?;
    let mut known = jacobian.clone();
    if let Ok(Some(whole)) = comparison.model().mass_properties(theta)
        && whole.mass > 0.0
        && out.mass.nrows() > 0
    {
        let row = known.nrows();
        known = known.insert_row(row, 0.0);
        for k in 0..scaling.len() {
            known[(row, k)] = out.mass[(0, k)] * out.widths[k] / (SCALES * whole.mass);
        }
        let weighed = identifiability(&known, &out.names, Some(&out.widths), NO_EFFECT)?;
        if weighed.rank > seen.rank {
            out.weighed = Some(weighed);
        }
    }
    if out.weighed.is_none() {
        known = jacobian.clone();
    }
    let parameters = comparison.model().parameters();
    let found = information(&known, None, NO_EFFECT)?;
    out.information = scaling
        .free()
        .iter()
        .zip(scaling.width())
        .zip(&found)
        .map(|((&i, width), Information { sd_alone, sd, share })| {
            let p = parameters.get(i);
            let [lower, upper] = p.range();
            ParameterInformation {
                name: p.name.clone(),
                unit: p.unit.clone(),
                value: p.display(theta[i]),
                bounds: (p.display(lower), p.display(upper)),
                sd_alone: sd_alone.is_finite().then(|| p.display(sd_alone * width)),
                sd: sd.map(|sd| p.display(sd * width)),
                share: *share,
            }
        })
        .collect();
    out.identifiability = Some(seen);
    out.collinear = collinear_groups(&jacobian, COLLINEAR);
    Ok(())
}

/// ∂(mass, cg, inertia)/∂θ in SI, (10 x free) or no rows.
fn mass_sensitivities(
    model: &dyn ParametricModel,
    theta: &[f64],
    scaling: &Scaling,
) -> Result<DMatrix<f64>, crate::model::ModelError> {
    let row = |p: MassProperties| {
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = p.inertia;
        [p.mass, p.cg[0], p.cg[1], p.cg[2], xx, yy, zz, -xy, -xz, -yz]
    };
    if model.mass_properties(theta)?.is_none() {
        return Ok(DMatrix::zeros(0, scaling.len()));
    }
    let mut out = DMatrix::zeros(MASS_ROWS.len(), scaling.len());
    for (k, (&j, width)) in scaling.free().iter().zip(scaling.width()).enumerate() {
        // Mass properties are rational functions of θ: a step of 1e-6 of the interval leaves an error of about 1e-9.
        let step = 1e-6 * width;
        let shifted = |sign: f64| {
            let mut theta = theta.to_vec();
            theta[j] += sign * step;
            model.mass_properties(&theta)
        };
        if let (Some(above), Some(below)) = (shifted(1.0)?, shifted(-1.0)?) {
            let (above, below) = (row(above), row(below));
            for i in 0..MASS_ROWS.len() {
                out[(i, k)] = (above[i] - below[i]) / (2.0 * step);
            }
        }
    }
    Ok(out)
}

/// Sensitivities of frequency response functions over their lines.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FrfSensitivity {
    /// Lines, Hz.
    pub frequencies_hz: Vec<f64>,
    /// For every parameter and line: change over the whole interval, relative,
    /// width √(Σ|∂H/∂θ|²/Σ|H|²) over all functions.
    pub relative: Vec<Vec<f64>>,
}

/// ∂H/∂θ of receptances between rows of displacement, exact.
///
/// ```text
/// H = S Z⁻¹ Bᵀ,   ∂H = -S Z⁻¹ (∂K - ω² ∂M) Z⁻¹ Bᵀ,   Z⁻¹ = Φ diag(1/(ω_r² - ω² + 2iζω_rω)) Φᵀ
/// ```
///
/// * `matrices`, `modes` - at the estimates, moved into their bounds; all modes of the model: with fewer, Z⁻¹ lacks the others
/// * `at_responses`, `at_references` - the modes where it is read and driven, (n x n_modes)
/// * `damping` - ratio of every mode; the damping matrix that it makes is held while θ changes
///
/// The relative change is the same for receptance, mobility and accelerance.
pub fn frf_sensitivities(
    model: &dyn ParametricModel,
    (matrices, modes): (&Matrices, &Modes),
    (at_responses, at_references): (&DMatrix<f64>, &DMatrix<f64>),
    frequencies_hz: &[f64],
    damping: f64,
) -> Result<FrfSensitivity, UpdateError> {
    let scaling = Scaling::new(model);
    let theta = crate::objective::starting_point(model);
    let failed = |e: &dyn std::fmt::Display| UpdateError::Start(EvalError::Unsolvable { reason: e.to_string() });
    let mut relative = vec![vec![0.0; frequencies_hz.len()]; scaling.len()];
    let ratios = ModalDamping::uniform(modes.len(), damping).ratios;
    for (k, (&j, width)) in scaling.free().iter().zip(scaling.width()).enumerate() {
        let d = matrices.derivative(model, &theta, j).map_err(|e| failed(&e))?;
        // In modal coordinates.
        let stiffness = modes.shapes.tr_mul(&d.stiffness_times(&modes.shapes));
        let mass = modes.shapes.tr_mul(&d.mass_times(&modes.shapes));
        for (line, f) in frequencies_hz.iter().enumerate() {
            let omega = TAU * f;
            let gain = DVector::from_fn(modes.len(), |r, _| {
                let omega_r = modes.lambda[r].max(0.0).sqrt();
                Complex::new(modes.lambda[r] - omega * omega, 2.0 * ratios[r] * omega_r * omega).inv()
            });
            let change = (&stiffness - &mass * (omega * omega)).map(Complex::from);
            let weighted =
                |rows: &DMatrix<f64>| DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, r| gain[r] * rows[(i, r)]);
            let (left, right) = (weighted(at_responses), weighted(at_references));
            let h = &left * at_references.transpose().map(Complex::from);
            let dh = &left * change * right.transpose();
            let size = h.iter().map(nalgebra::Complex::norm_sqr).sum::<f64>();
            let moved = dh.iter().map(nalgebra::Complex::norm_sqr).sum::<f64>();
            relative[k][line] = if size > 0.0 { width * (moved / size).sqrt() } else { 0.0 };
        }
    }
    Ok(FrfSensitivity { frequencies_hz: frequencies_hz.to_vec(), relative })
}
