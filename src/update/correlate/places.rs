//! Localisation on the structure: which elements and groups the disagreement sits in.

use super::{paired_shapes, pairs_with_shapes, shape_sd};
use crate::correlation::{
    CorrelationError, ElementMatrix, ExpandedMode, Expander, Localization, SingleChanges, by_group, element_energies,
    group_matrices, localize_with_groups, modal_scale_factor, single_changes,
};
use crate::linalg::{DMatrix, DVector};
use crate::model::{Model, ModelError};
use crate::objective::Comparison;
use crate::update::Assessment;
use indexmap::IndexMap;
use std::f64::consts::TAU;

/// Where the disagreement of shapes and frequencies sits.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Places {
    /// Members of the model file, the most suspicious first: `left_wing.2`.
    pub by_element: Localization,
    /// Entries of the model file: `left_wing`.
    pub by_group: Localization,
    /// The member whose stiffness, changed alone, explains most; best first.
    pub changes_by_element: SingleChanges,
    /// The same for whole entries.
    pub changes_by_group: SingleChanges,
    /// Share of each entry in the strain energy of the paired model modes, (entry, one share a pair).
    pub strain_energy: Vec<(String, Vec<f64>)>,
    /// Indices of the test modes that were used.
    pub test_modes: Vec<usize>,
    /// Their shapes at all dofs, on the scale of the test: what the sensors saw and what the model makes of the rest.
    #[serde(skip)]
    pub expanded: Vec<(usize, DVector<f64>)>,
}

/// How the disagreement is localised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacesOptions {
    /// The relative stiffness error of one member that the expansion is set to show, see
    /// [`Expander::model_error`](crate::correlation::Expander::model_error).
    pub relative_error: f64,
}

impl Default for PlacesOptions {
    fn default() -> Self {
        Self { relative_error: 0.1 }
    }
}

/// Why there is no localisation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacesError {
    /// The comparison failed.
    #[error(transparent)]
    Correlation(#[from] CorrelationError),
    /// The model failed.
    #[error("the model cannot be evaluated: {0}")]
    Model(#[from] ModelError),
    /// No pair has a shape.
    #[error("no measured shape is paired with a mode of the model, so nothing can be said about places")]
    NoShapes,
    /// No element has stiffness.
    #[error("no element of the model has stiffness")]
    NoStiffness,
}

/// Stiffness of every member of a model at θ in its dofs; the parts of a subdivided member together, members without
/// stiffness left out. The group of a member is its entry in the file.
pub fn member_stiffnesses(model: &Model, theta: &[f64]) -> Result<Vec<ElementMatrix>, ModelError> {
    let mut parts = Vec::new();
    for (i, element) in model.elements().iter().enumerate() {
        if element.matrices.is_some() {
            if let Some((dofs, matrix)) = model.superelement_stiffness(i, theta) {
                parts.push(ElementMatrix {
                    name: element.name.clone(),
                    group: Some(element.name.clone()),
                    dofs,
                    matrix,
                });
            }
            continue;
        }
        let stiffness = model.element_matrices(i, theta)?.stiffness;
        let connection = model.element_motion(i);
        let rows = &connection.rows;
        if stiffness.is_zero() || rows.is_empty() {
            continue;
        }
        let matrix = connection.reduce(&stiffness);
        if matrix.amax() == 0.0 {
            continue;
        }
        let member = element.name.split_once('/').map_or(element.name.as_str(), |(member, _)| member).to_owned();
        parts.push(ElementMatrix { name: element.name.clone(), group: Some(member), dofs: rows.clone(), matrix });
    }
    let mut members = group_matrices(&parts);
    for member in &mut members {
        let entry = member.name.rsplit_once('.').map_or(member.name.as_str(), |(entry, _)| entry);
        member.group = Some(entry.to_owned());
    }
    Ok(members)
}

/// Localises the disagreement of the paired modes that have shapes.
///
/// Each test shape is expanded at its measured frequency by minimum dynamic residual; the energy of the residual in each
/// element is compared with what the noise of shapes and frequencies alone would give. See
/// [`localize`](crate::correlation::localize) for the statistics and for what it cannot tell.
///
/// * `model` - the model that `comparison` compares, at the θ of `a`
pub fn places(
    model: &Model,
    comparison: &Comparison<'_>,
    a: &Assessment,
    options: PlacesOptions,
) -> Result<Places, PlacesError> {
    let pairs = pairs_with_shapes(a);
    if pairs.is_empty() {
        return Err(PlacesError::NoShapes);
    }
    let members = member_stiffnesses(model, &a.theta)?;
    if members.is_empty() {
        return Err(PlacesError::NoStiffness);
    }
    let p = &a.prediction;
    let (shapes, measured) = paired_shapes(comparison, a, &pairs);
    let shift = p.modes.lambda[p.modes.n_rigid].max(f64::MIN_POSITIVE);
    let expander = match &a.prediction.modes.basis {
        // A basis of far another shift has lost digits.
        Some(basis) if (1e-2..1e2).contains(&(basis.shift / shift)) => {
            Expander::from_basis(basis, comparison.sensors(), shift)?
        }
        _ => {
            let system = p.system()?;
            Expander::new(&system.stiffness, &system.mass, comparison.sensors(), shift)?
        }
    };
    let model_error = expander.model_error(options.relative_error, members.len());
    let (mut expanded, mut shapes_of) = (Vec::with_capacity(pairs.len()), Vec::with_capacity(pairs.len()));
    for (j, pair) in pairs.iter().enumerate() {
        let f = comparison.test().modes[pair.test_mode].frequency_hz;
        let omega_squared = (TAU * f.value).powi(2);
        let sd = DVector::from_vec(shape_sd(comparison, pair.test_mode));
        let y = measured.column(j).into_owned();
        // The model's shape has unit modal mass, so the squared scale is that of the test shape.
        let scale = modal_scale_factor(shapes.column(j).as_slice(), y.as_slice());
        let modal_mass = scale * scale;
        if modal_mass == 0.0 {
            continue;
        }
        let weight = expander.weight(model_error, omega_squared, modal_mass);
        let shape = expander.expand(&y, &sd, omega_squared, weight)?;
        shapes_of.push((pair.test_mode, shape.shape.clone()));
        expanded.push((shape, sd, 1.0 / (omega_squared * modal_mass), 2.0 * omega_squared * f.sd / f.value));
    }
    let modes: Vec<ExpandedMode<'_>> = expanded
        .iter()
        .map(|(expanded, sd, weight, omega_squared_sd)| ExpandedMode {
            expanded,
            sd,
            weight: *weight,
            omega_squared_sd: *omega_squared_sd,
        })
        .collect();
    let mut strain: Vec<(String, Vec<f64>)> = Vec::new();
    for pair in &pairs {
        let shape = p.modes.shapes.column(p.modes.n_rigid + pair.model_mode).into_owned();
        let energies = element_energies(&shape, &members, 1.0)?;
        let total: f64 = energies.iter().sum();
        for (i, (name, energy)) in by_group(&members, &energies).into_iter().enumerate() {
            if strain.len() <= i {
                strain.push((name, Vec::new()));
            }
            strain[i].1.push(if total > 0.0 { energy / total } else { 0.0 });
        }
    }
    let (residuals, effects) = effects(comparison, a, &members, &expander);
    let names: Vec<String> = members.iter().map(|m| m.name.clone()).collect();
    let mut groups: IndexMap<String, DVector<f64>> = IndexMap::new();
    for (member, effect) in members.iter().zip(effects.column_iter()) {
        let group = member.group_name().to_owned();
        *groups.entry(group).or_insert_with(|| DVector::zeros(residuals.len())) += effect;
    }
    let group_names: Vec<String> = groups.keys().cloned().collect();
    let group_effects = DMatrix::from_columns(&groups.into_values().collect::<Vec<_>>());
    let (by_element, by_group) = localize_with_groups(&modes, &members)?;
    Ok(Places {
        changes_by_element: single_changes(&residuals, &effects, &names)?,
        changes_by_group: single_changes(&residuals, &group_effects, &group_names)?,
        by_element,
        by_group,
        strain_energy: strain,
        test_modes: pairs.iter().map(|p| p.test_mode).collect(),
        expanded: shapes_of,
    })
}

/// A change of a fifth in one member moves a frequency by some per cent: two modes nearer than that may change places.
const CLOSE: f64 = 0.05;

/// Residuals of the paired modes and of the static readings, and what a relative change of each member's stiffness does to them.
///
/// A frequency and then a shape with its scale taken out, pair by pair, then the readings: all standard normal under noise alone. Modes whose
/// frequency is within [`CLOSE`] of another's are left out: a small change turns them into each other, and nothing about
/// that is linear.
///
/// * `expander` - of the model at the θ of `a` with the sensors of `comparison`
fn effects(
    comparison: &Comparison<'_>,
    a: &Assessment,
    members: &[ElementMatrix],
    expander: &Expander,
) -> (DVector<f64>, DMatrix<f64>) {
    let p = &a.prediction;
    let n_sensors = comparison.sensors().nrows();
    let mut residuals: Vec<f64> = Vec::new();
    let mut blocks: Vec<DMatrix<f64>> = Vec::new();
    for pair in &a.pairs {
        let index = p.modes.n_rigid + pair.model_mode;
        let near = |f: &f64| (f - pair.model_hz).abs() < CLOSE * pair.model_hz;
        if p.frequencies_hz.iter().filter(|f| near(f)).count() > 1 {
            continue;
        }
        let (lambda, phi) = (p.modes.lambda[index], p.modes.shapes.column(index));
        let mut forces = DMatrix::zeros(phi.len(), members.len());
        for (mut force, member) in forces.column_iter_mut().zip(members) {
            for (matrix, &from) in member.matrix.column_iter().zip(&member.dofs) {
                for (value, &to) in matrix.iter().zip(&member.dofs) {
                    force[to] += value * phi[from];
                }
            }
        }
        let Some(at_sensors) = expander.mode_change(lambda, &forces) else { continue };
        let f = comparison.test().modes[pair.test_mode].frequency_hz;
        residuals.push((pair.model_hz - f.value) / f.sd);
        let growth = forces.tr_mul(&phi);
        blocks.push(
            DMatrix::from_row_slice(1, members.len(), growth.as_slice()) * (pair.model_hz / (2.0 * lambda * f.sd)),
        );
        if pair.mac.is_none() {
            continue;
        }
        let sd = shape_sd(comparison, pair.test_mode);
        let (model, test) = (p.at_sensors.column(pair.model_mode), comparison.shapes().column(pair.test_mode));
        let used: Vec<usize> = (0..n_sensors).filter(|&i| !test[i].is_nan()).collect();
        let own = DVector::from_iterator(used.len(), used.iter().map(|&i| model[i] / sd[i]));
        let measured = DVector::from_iterator(used.len(), used.iter().map(|&i| test[i] / sd[i]));
        let norm = own.norm();
        if norm == 0.0 {
            continue;
        }
        let scale = own.dot(&measured) / (norm * norm);
        let direction = own.unscale(norm);
        // The part along the model's shape is the free scale.
        let along = direction.dot(&measured);
        residuals.extend((&direction * along - &measured).iter());
        let mut block = DMatrix::from_fn(used.len(), members.len(), |i, j| at_sensors[(used[i], j)] / sd[used[i]]);
        for mut column in block.column_iter_mut() {
            let along = direction.dot(&column);
            column.axpy(-along, &direction, 1.0);
            column *= scale;
        }
        blocks.push(block);
    }
    if let Some((own, block)) = static_effects(comparison, a, members) {
        residuals.extend(own);
        blocks.push(block);
    }
    let mut effects = DMatrix::zeros(residuals.len(), members.len());
    let mut first = 0;
    for block in blocks {
        effects.rows_mut(first, block.nrows()).copy_from(&block);
        first += block.nrows();
    }
    (DVector::from_vec(residuals), effects)
}

/// Residuals of the static readings, and what a relative change of each member's stiffness does to them; none without readings.
///
/// ```text
/// ∂reading/∂δ_e = -λᵀ K_e u,    K u = f,   K λ = s
/// ```
fn static_effects(
    comparison: &Comparison<'_>,
    a: &Assessment,
    members: &[ElementMatrix],
) -> Option<(Vec<f64>, DMatrix<f64>)> {
    if a.readings.is_empty() {
        return None;
    }
    let factor = comparison.solver().factor(comparison.model(), &a.prediction.matrices).ok()?;
    let u = factor.solve(comparison.loads());
    let tests = &comparison.test().static_tests;
    let measured = tests.iter().enumerate().flat_map(|(k, t)| t.readings.iter().map(move |r| (k, r)));
    let mut block = DMatrix::zeros(a.readings.len(), members.len());
    let rows: Vec<usize> = measured.clone().map(|(_, r)| r.sensor).collect();
    let adjoints = factor.solve(&comparison.sensors().select_rows(&rows).transpose());
    for (row, (k, reading)) in measured.enumerate() {
        let adjoint = adjoints.column(row).into_owned();
        let energy = |m: &ElementMatrix| -> f64 {
            let at = |v: &[f64]| DVector::from_iterator(m.dofs.len(), m.dofs.iter().map(|&d| v[d]));
            at(adjoint.as_slice()).dot(&(&m.matrix * at(u.column(k).as_slice())))
        };
        members.iter().enumerate().for_each(|(e, m)| block[(row, e)] = -energy(m) / reading.measured.sd);
    }
    Some((a.readings.iter().map(|r| (r.model - r.measured) / r.sd).collect(), block))
}
