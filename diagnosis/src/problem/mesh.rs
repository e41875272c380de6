//! Is the mesh fine enough for the modes of the test?
//!
//! A coarse mesh makes frequencies too high, and a diagnosis would look for physics to lower them. The same file with three
//! elements for one says how much of beams; of shells and solids, whose mesh stays what it is, their own strains do.

use crate::error::{DiagnosisError, unsolvable};
use retune::correlation::PairingOptions;
use retune::data::TestData;
use retune::linalg::{DMatrix, DVector};
use retune::modal::{Modes, SolveOptions};
use retune::model::spec::ModelSpec;
use retune::model::{Model, Registry, solve_modes};
use retune::objective::{Comparison, LeastSquares, Objective};

/// Elements for one, by which a mesh is judged.
pub(crate) const FINER: u32 = 3;

/// Builds a specification.
pub(crate) fn build(spec: ModelSpec, registry: &Registry) -> Result<Model, DiagnosisError> {
    let first = |p: Vec<retune::yaml::Problem>| unsolvable(p.first().map(ToString::to_string).unwrap_or_default());
    Ok(Model::new(spec, registry).map_err(first)?.0)
}

/// The lowest elastic modes at θ.
pub(crate) fn modes(model: &Model, theta: &[f64], n_elastic: usize) -> Result<Modes, DiagnosisError> {
    solve_modes(model, theta, SolveOptions { n_elastic, shift: None }).map_err(unsolvable)
}

/// The same structure with several beams for one. A member without mass or torsional stiffness of its own, whose inner nodes
/// would hang in the air, stays as it is.
pub(crate) fn refined(model: &Model, theta: &[f64], times: u32) -> Result<Model, DiagnosisError> {
    let finer = |spec: &mut ModelSpec, name: &str| {
        if let Some(member) = spec.beams.get_mut(name) {
            member.subdivide = Some(times * member.subdivide.unwrap_or(1));
        }
    };
    let sound = |m: &Model| modes(m, theta, 1).is_ok_and(|found| found.n_mechanism == 0);
    let names: Vec<String> = model.spec().beams.keys().cloned().collect();
    if names.is_empty() {
        return Ok(model.clone());
    }
    let mut all = model.spec().clone();
    for name in &names {
        finer(&mut all, name);
    }
    if let Ok(m) = build(all, model.registry())
        && sound(&m)
    {
        return Ok(m);
    }
    let mut spec = model.spec().clone();
    for name in &names {
        let mut tried = spec.clone();
        finer(&mut tried, name);
        if build(tried.clone(), model.registry()).is_ok_and(|m| sound(&m)) {
            spec = tried;
        }
    }
    build(spec, model.registry())
}

/// Relative error of each of the lowest elastic frequencies that the mesh makes, by ascending frequency.
///
/// * `fine` - the model [`refined`]
pub(crate) fn mesh_errors(
    model: &Model,
    fine: &Model,
    theta: &[f64],
    n_elastic: usize,
) -> Result<Vec<f64>, DiagnosisError> {
    let (coarse, exact) = (modes(model, theta, n_elastic)?, modes(fine, theta, n_elastic)?);
    let hz = |m: &Modes| -> Vec<f64> { m.elastic().map(|i| m.frequency_hz(i)).collect() };
    Ok(hz(&coarse).iter().zip(hz(&exact)).map(|(c, e)| c / e - 1.0).collect())
}

/// By how many standard deviations, all together, the mesh moves the functions of a test; zero for a test without.
///
/// * `fine` - the model [`refined`]
pub(crate) fn functions_moved(
    model: &Model,
    fine: &Model,
    theta: &[f64],
    test: &TestData,
) -> Result<f64, DiagnosisError> {
    if test.frfs.is_none() || test.frf_fit.is_none() {
        return Ok(0.0);
    }
    let rows = |model: &Model| -> Result<_, DiagnosisError> {
        let comparison = Comparison::new(model, test, PairingOptions::default())?;
        let Some(objective) = LeastSquares::from_names(&comparison, &["frf-log"]) else { return Ok(DVector::zeros(0)) };
        Ok(objective.residuals(&objective.scaling().x(theta))?)
    };
    Ok((rows(fine)? - rows(model)?).norm())
}

/// Readings of modes at the rows of an observation matrix, those that no sensor sees left out.
pub(crate) fn seen(rows: &DMatrix<f64>, modes: &Modes, n: usize) -> Vec<nalgebra::DVector<f64>> {
    modes.elastic().take(n).map(|i| rows * modes.shapes.column(i)).filter(|at| at.amax() > 1e-9 * rows.amax()).collect()
}
