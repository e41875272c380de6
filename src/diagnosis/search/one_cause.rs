//! Could one cause make the modes that look foreign? A look before the search for it, which takes longer than the diagnosis itself.
//!
//! A single cause that brings a mode of shape y at a frequency ω is one of these:
//!
//! * A fault of one or two sensors, or of a frequency: without the two worst sensors y is a mode of the model, at any frequency.
//! * A change at a few dofs B: K φ - ω² M φ = -ΔZ φ has forces at B alone, so whatever the size of the change
//!
//! ```text
//! φ = H(ω) B q,    H = (K - ω² M)⁻¹        y lies in the span of the columns of S H(ω) B, S the rows of the sensors
//! ```
//!
//! * A change of many parts: then one of its sizes gives the model a mode like y, near that frequency.
//!
//! All is asked at the fit without those modes, with room for what the parameters still move.

use super::starts::start_sizes;
use crate::correlation::observation_matrix_at;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::problem::changed::with_effect;
use crate::diagnosis::problem::fit::mac;
use crate::diagnosis::problem::scene::{Case, Scene};
use crate::diagnosis::screen::effects::Screened;
use crate::diagnosis::screen::stage::placed;
use crate::diagnosis::settings::Settings;
use crate::diagnosis::thresholds::{ALIKE_SHAPE, EXPLAINS, IS_A_MODE, LEFT_ROWS, NEAR_FREQUENCY, SPOILED};
use crate::effect::{Candidate, Context, Structure};
use crate::element::Dof;
use crate::linalg::{DMatrix, DVector, thin_qr};
use crate::model::ParametricModel;
use crate::objective::Scaling;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Dofs up to which the receptance is computed.
const MOST_DOFS: usize = 1500;

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
    /// A fault of the measurement, or one of these effects, by their ids.
    These(BTreeSet<String>),
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
    let context = Context::default();
    let reach = unknown.iter().map(|u| Reach::of(u, &theta, &context)).collect::<Result<Vec<_>, _>>()?;
    // Each with whether it explains all of them; none where it acts at too many dofs to tell.
    let told = |c: Candidate| {
        let each: Vec<Option<bool>> = unknown.iter().zip(&reach).map(|(u, reach)| reach.at_few_dofs(u, &c)).collect();
        let explains = if each.contains(&Some(false)) { Some(false) } else { (!each.contains(&None)).then_some(true) };
        (c, explains)
    };
    let candidates: Vec<(Candidate, Option<bool>)> = placed(scene, settings).into_par_iter().map(told).collect();
    let mut strange = Vec::new();
    for u in &unknown {
        if !is_a_mode(scene, &theta, u)? {
            strange.push(u);
        }
    }
    let at_some_size = |c: &Candidate| strange.iter().all(|u| at_some_size(scene, &theta, u, c).unwrap_or(true));
    let is_possible = strange.is_empty()
        || candidates.iter().any(|c| c.1 == Some(true))
        || candidates.par_iter().any(|(c, told)| told.is_none() && at_some_size(c));
    if !is_possible {
        return Ok(OneCause::None);
    }
    let left = candidates.into_iter().filter(|c| c.1 != Some(false));
    Ok(OneCause::These(left.map(|(c, _)| c.id()).collect()))
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

/// What forces at the dofs of a structure move at the sensors that measured a shape, at its frequency.
struct Reach<'a> {
    structure: Structure<'a>,
    /// S H(ω), (n_sensor x n_dof); none where ω is a frequency of the model.
    receptance: Option<DMatrix<f64>>,
}

impl<'a> Reach<'a> {
    fn of(u: &Unknown<'a>, theta: &[f64], context: &'a Context) -> Result<Self, DiagnosisError> {
        let model = &*u.case.model;
        let system = model.assemble(theta).map_err(crate::diagnosis::error::unsolvable)?;
        let rows = observation_matrix_at(model, &u.case.test.sensors, theta)?.select_rows(&u.sensors);
        let dynamic = system.stiffness - system.mass * (u.omega * u.omega);
        // H is symmetric: its rows at the sensors are solutions for loads there.
        let h = dynamic.lu().solve(&rows.transpose()).map(|h| h.transpose());
        let receptance = h.filter(|h| h.iter().all(|v| v.is_finite()));
        Ok(Self { structure: Structure::new(&u.case.model, context), receptance })
    }

    /// Whether forces at the dofs of a candidate's place give the shape; none where it has too many.
    fn at_few_dofs(&self, u: &Unknown<'_>, candidate: &Candidate) -> Option<bool> {
        let h = self.receptance.as_ref()?;
        let nodes = self.structure.nodes_of(&candidate.location);
        let dofs = u.case.model.dof_map();
        let mut columns: Vec<DVector<f64>> = Vec::new();
        for node in nodes {
            for dof in Dof::ALL {
                let rows = dofs.express(node, dof);
                if !rows.is_empty() {
                    let zero = DVector::zeros(h.nrows());
                    columns.push(rows.iter().fold(zero, |sum, &(row, factor)| sum + factor * h.column(row)));
                }
            }
            if columns.len() + LEFT_ROWS > u.shape.len() {
                return None;
            }
        }
        if columns.is_empty() {
            return None;
        }
        // Columns of rotations and displacements have other units.
        let scaled: Vec<DVector<f64>> = columns.into_iter().filter_map(|c| c.try_normalize(0.0)).collect();
        let q = thin_qr(&DMatrix::from_columns(&scaled)).ok()?.q;
        let share = q.tr_mul(&u.shape).norm_squared() / u.shape.norm_squared();
        let (n, r) = (u.shape.len() as f64, q.ncols() as f64);
        Some(1.0 - (1.0 - share) * n / (n - r) > EXPLAINS)
    }
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
