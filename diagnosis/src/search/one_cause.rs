//! Could one cause make the modes that look foreign? A look before the search for it, which takes longer than the diagnosis itself.
//!
//! A single cause that brings a mode of shape y at a frequency ω is one of these:
//!
//! * A fault of one or two sensors, or of a frequency: without the two worst sensors y is a mode of the model, at any frequency.
//! * A change of few directions B, the range of ΔZ = ΔK - ω² ΔM with new coordinates condensed: K φ - ω² M φ = -ΔZ φ has forces in B alone, so
//!   whatever the size of the change
//!
//! ```text
//! φ = H(ω) B q,    H = (K - ω² M)⁻¹        y lies in the span of the columns of S H(ω) B, S the rows of the sensors
//! ```
//!
//! * A change of many parts: then one of its sizes gives the model a mode like y, near that frequency.
//!
//! All is asked at the fit without those modes, with room for what the parameters still move.

use super::starts::start_sizes;
use crate::error::DiagnosisError;
use crate::problem::changed::with_effect;
use crate::problem::fit::mac;
use crate::problem::scene::{Case, Scene, Sought};
use crate::screen::effects::Screened;
use crate::screen::stage::placed;
use crate::settings::Settings;
use crate::thresholds::{ALIKE_SHAPE, EXPLAINS, IS_A_MODE, LEFT_ROWS, NEAR_FREQUENCY, SPOILED};
use rayon::prelude::*;
use retune::correlation::observation_matrix_at;
use retune::effect::Candidate;
use retune::linalg::{DMatrix, DVector, thin_qr};
use retune::model::{ChangeAt, ParametricModel};
use retune::objective::Scaling;
use std::f64::consts::TAU;

/// Dofs up to which the receptance is computed.
const MOST_DOFS: usize = 1500;
/// Rows up to which the directions of a change are sought.
const MOST_ROWS: usize = 120;

/// Share of the largest eigenvalue of a change below which another is none.
const NULL: f64 = 1e-10;

/// A shape that looks foreign, as it was measured.
struct Unknown<'a> {
    case: &'a Case,
    omega: f64,
    /// Sensors where it was measured, and its entries there.
    sensors: Vec<usize>,
    shape: DVector<f64>,
}

/// What could be the single cause of modes that look foreign.
pub(crate) enum OneCause {
    /// Nothing.
    None,
    /// A fault of the measurement, or one of these effects.
    These(Sought),
    /// That cannot be told.
    Any,
}

/// What could make every one of these modes alone.
///
/// * `scene` - without these modes
/// * `x` - parameters that fit the others
/// * `modes` - those that look foreign, of which those with a shape tell
pub(crate) fn one_cause_of(
    scene: &Scene,
    x: &DVector<f64>,
    modes: &[usize],
    settings: &Settings,
) -> Result<OneCause, DiagnosisError> {
    let theta = Scaling::new(scene.solved()).theta(x);
    let unknown: Vec<Unknown<'_>> = modes.iter().filter_map(|&m| unknown(scene, m)).collect();
    if unknown.is_empty() || unknown.iter().any(|u| u.case.model.dof_map().n_dof() > MOST_DOFS) {
        return Ok(OneCause::Any);
    }
    let reach = unknown.iter().map(|u| Reach::of(u, &theta)).collect::<Result<Vec<_>, _>>()?;
    let placed = placed(scene, settings);
    scene.place(&placed);
    // Each with its share of the shape that it explains worst; none where it acts in too many directions to tell, unless another shape rules it out.
    let told = |c: Candidate| {
        let each: Vec<Option<f64>> = unknown.iter().zip(&reach).map(|(u, reach)| reach.share(scene, u, &c)).collect();
        let least = each.iter().flatten().copied().fold(1.0, f64::min);
        let is_told = least <= EXPLAINS || !each.contains(&None);
        (c, is_told.then_some(least))
    };
    let candidates: Vec<(Candidate, Option<f64>)> = placed.into_par_iter().map(told).collect();
    let mut strange = Vec::new();
    for u in &unknown {
        if !is_a_mode(scene, &theta, u)? {
            strange.push(u);
        }
    }
    let at_some_size = |c: &Candidate| strange.iter().all(|u| at_some_size(scene, &theta, u, c).unwrap_or(true));
    let is_possible = strange.is_empty()
        || candidates.iter().any(|c| c.1.is_some_and(|share| share > EXPLAINS))
        || candidates.par_iter().any(|(c, told)| told.is_none() && at_some_size(c));
    if !is_possible {
        return Ok(OneCause::None);
    }
    let mut sought = Sought::default();
    for (c, share) in &candidates {
        match *share {
            Some(share) if share > EXPLAINS => {
                sought.shown.insert(c.id(), share);
            }
            Some(_) => {}
            None => {
                sought.possible.insert(c.id());
            }
        }
    }
    Ok(OneCause::These(sought))
}

fn unknown(scene: &Scene, mode: usize) -> Option<Unknown<'_>> {
    let case = scene.cases.iter().find(|c| c.modes().contains(&mode))?;
    let measured = &case.test.modes[mode - case.first_mode];
    let shape = measured.shape.as_ref()?;
    let sensors: Vec<usize> = (0..shape.len()).filter(|&s| !shape[s].re.is_nan()).collect();
    let entries = DVector::from_iterator(sensors.len(), sensors.iter().map(|&s| shape[s].re));
    Some(Unknown { case, omega: TAU * measured.frequency_hz.value, sensors, shape: entries })
}

/// Whether a shape is a mode of the model, at any frequency, but for the worst sensors.
fn is_a_mode(scene: &Scene, theta: &[f64], u: &Unknown<'_>) -> Result<bool, DiagnosisError> {
    let comparison = u.case.comparison(&scene.how)?;
    let prediction = comparison.predict(theta)?;
    let like = |column: usize| {
        let model: Vec<f64> = u.sensors.iter().map(|&s| prediction.at_sensors[(s, column)]).collect();
        without_the_worst(&model, u.shape.as_slice()) > IS_A_MODE
    };
    Ok((0..prediction.at_sensors.ncols()).any(like))
}

/// MAC without the sensors whose loss raises it most.
fn without_the_worst(model: &[f64], test: &[f64]) -> f64 {
    let mut left: Vec<usize> = (0..test.len()).collect();
    for _ in 0..SPOILED.min(test.len().saturating_sub(LEFT_ROWS)) {
        let without = |k: usize| mac(left.iter().filter(|&&i| i != k).map(|&i| (model[i], test[i])));
        let Some(&worst) = left.iter().max_by(|&&a, &&b| without(a).total_cmp(&without(b))) else { break };
        left.retain(|&i| i != worst);
    }
    mac(left.iter().map(|&i| (model[i], test[i])))
}

/// What forces on a structure move at the sensors that measured a shape, at its frequency.
struct Reach<'a> {
    /// Parameters of the model.
    theta: &'a [f64],
    /// S H(ω), (n_sensor x n_dof); none where ω is a frequency of the model.
    receptance: Option<DMatrix<f64>>,
}

impl<'a> Reach<'a> {
    fn of(u: &Unknown<'_>, theta: &'a [f64]) -> Result<Self, DiagnosisError> {
        let model = &*u.case.model;
        let theta = &theta[..model.parameters().len()];
        let system = model.assemble(theta).map_err(crate::error::unsolvable)?;
        let rows = observation_matrix_at(model, &u.case.test.sensors, theta)?.select_rows(&u.sensors);
        let dynamic = system.stiffness - system.mass * (u.omega * u.omega);
        // H is symmetric: its rows at the sensors are solutions for loads there.
        let h = dynamic.lu().solve(&rows.transpose()).map(|h| h.transpose());
        let receptance = h.filter(|h| h.iter().all(|v| v.is_finite()));
        Ok(Self { theta, receptance })
    }

    /// The share of the shape that forces in the directions of a candidate explain, above what as many random columns would; none where it has
    /// too many of them.
    fn share(&self, scene: &Scene, u: &Unknown<'_>, candidate: &Candidate) -> Option<f64> {
        let h = self.receptance.as_ref()?;
        let change = scene.change(u.case, candidate)?;
        let at = change.at(self.theta, &candidate.typical()).ok()?;
        // What acts on many more rows than there are sensors has more directions too.
        if !at.acts() || at.old_rows().len() > MOST_ROWS {
            return None;
        }
        let directions = directions(&at, u.omega * u.omega)?;
        if directions.ncols() == 0 || directions.ncols() + LEFT_ROWS > u.shape.len() {
            return None;
        }
        // Columns of rotations and displacements have other units.
        let moved = h.select_columns(at.old_rows()) * directions;
        let scaled: Vec<DVector<f64>> = moved.column_iter().filter_map(|c| c.into_owned().try_normalize(0.0)).collect();
        if scaled.is_empty() {
            return Some(0.0);
        }
        let q = thin_qr(&DMatrix::from_columns(&scaled)).ok()?.q;
        let share = q.tr_mul(&u.shape).norm_squared() / u.shape.norm_squared();
        let (n, r) = (u.shape.len() as f64, q.ncols() as f64);
        Some(1.0 - (1.0 - share) * n / (n - r))
    }
}

/// The range of ΔZ = ΔK - ω² ΔM on the rows of the model that a change touches, its new coordinates condensed; none where these resonate.
fn directions(change: &ChangeAt<'_>, omega_squared: f64) -> Option<DMatrix<f64>> {
    let (size, old) = (change.rows().len(), change.old_rows().len());
    let [stiffness, mass] = change.times(&DMatrix::identity(size, size));
    let zero = || DMatrix::zeros(size, size);
    let z = stiffness.unwrap_or_else(zero) - mass.unwrap_or_else(zero) * omega_squared;
    let mut own = z.view((0, 0), (old, old)).into_owned();
    if size > old {
        let inner = z.view((old, old), (size - old, size - old)).into_owned();
        let across = z.view((old, 0), (size - old, old)).into_owned();
        own -= across.tr_mul(&inner.lu().solve(&across)?);
    }
    let eigen = own.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let kept: Vec<usize> = (0..old).filter(|&i| eigen.eigenvalues[i].abs() > NULL * largest).collect();
    Some(eigen.eigenvectors.select_columns(&kept))
}

/// Whether a candidate of some size gives the model a mode like this one.
fn at_some_size(scene: &Scene, theta: &[f64], u: &Unknown<'_>, candidate: &Candidate) -> Result<bool, DiagnosisError> {
    let changed = with_effect(scene, candidate)?;
    let own = scene.cases.iter().position(|c| std::ptr::eq(c, u.case)).unwrap_or(0);
    let comparison = changed.cases[own].comparison(&scene.how)?;
    let screened = Screened { candidate: candidate.clone(), columns: Vec::new() };
    for sizes in start_sizes(candidate, &screened, None) {
        let Ok(prediction) = comparison.predict(&[theta, &sizes].concat()) else { continue };
        let like = |(a, hz): (usize, &f64)| {
            let is_near = (TAU * hz / u.omega).ln().abs() < NEAR_FREQUENCY;
            is_near
                && mac(u.sensors.iter().enumerate().map(|(i, &s)| (prediction.at_sensors[(s, a)], u.shape[i])))
                    > ALIKE_SHAPE
        };
        if prediction.frequencies_hz.iter().enumerate().any(like) {
            return Ok(true);
        }
    }
    Ok(false)
}
