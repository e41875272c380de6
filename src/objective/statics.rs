//! Static tests of a model: loads, displacements under them, and their derivatives.

use super::prediction::{Comparison, Prediction, starting_point};
use super::residual::Point;
use crate::correlation::{CorrelationError, observation_matrix};
use crate::data::{Sensor, StaticReading, StaticTest, TestData};
use crate::linalg::{DMatrix, DVector};
use crate::model::{ModalSolver, ParametricModel};

/// The load vectors of the static tests as columns, (n_dof x n_tests).
///
/// A load does the work value · reading of a sensor in its place, so that it is value times that sensor's row.
///
/// Errors: a load on nothing; a structure that is free to move.
pub(super) fn loads(
    model: &dyn ParametricModel,
    test: &TestData,
    solver: &ModalSolver,
) -> Result<DMatrix<f64>, CorrelationError> {
    let n = model.dof_map().n_dof();
    let mut loads = DMatrix::zeros(n, test.static_tests.len());
    for (k, t) in test.static_tests.iter().enumerate() {
        let places: Vec<Sensor> = t.loads.iter().map(Sensor::of_load).collect();
        let rows = observation_matrix(model, &places)?;
        for (row, load) in rows.row_iter().zip(&t.loads) {
            let mut column = loads.column_mut(k);
            column += row.transpose() * load.value;
        }
    }
    if let Some(first) = test.static_tests.first() {
        let (_, modes) =
            solver.solve(model, &starting_point(model), 1).map_err(|e| CorrelationError::Model(e.to_string()))?;
        if modes.n_rigid + modes.n_mechanism > 0 {
            return Err(CorrelationError::Model(format!(
                "the structure is free to move, so the static test `{}` has no answer; name a configuration with supports in the test file",
                first.name
            )));
        }
    }
    Ok(loads)
}

/// All readings, test by test.
pub(super) fn readings(test: &TestData) -> impl Iterator<Item = (usize, &StaticTest, &StaticReading)> {
    test.static_tests.iter().enumerate().flat_map(|(k, t)| t.readings.iter().map(move |r| (k, t, r)))
}

/// What the sensors read under the loads, in the order of the tests and their readings; NaN where K has no inverse.
///
/// ```text
/// K u = f,   reading = s · u
/// ```
pub fn static_readings(comparison: &Comparison<'_>, prediction: &Prediction) -> Vec<f64> {
    let n_readings = readings(comparison.test()).count();
    if n_readings == 0 {
        return Vec::new();
    }
    let Some(factor) = prediction.system().ok().and_then(|s| s.stiffness.clone().cholesky()) else {
        return vec![f64::NAN; n_readings];
    };
    let u = factor.solve(comparison.loads());
    readings(comparison.test()).map(|(k, _, r)| comparison.sensors().row(r.sensor).tr_dot(&u.column(k))).collect()
}

/// Whether a reading belongs to a residual, by the kind of its sensor.
fn is_of(comparison: &Comparison<'_>, r: &StaticReading, rotation: bool) -> bool {
    comparison.test().sensors[r.sensor].is_rotation == rotation
}

/// Number of readings of a kind.
pub(super) fn count(comparison: &Comparison<'_>, rotation: bool) -> usize {
    readings(comparison.test()).filter(|(_, _, r)| is_of(comparison, r, rotation)).count()
}

/// "tip in bending"
pub(super) fn row_name(comparison: &Comparison<'_>, rotation: bool, row: usize) -> String {
    let found = readings(comparison.test()).filter(|(_, _, r)| is_of(comparison, r, rotation)).nth(row);
    found.map_or_else(String::new, |(_, t, r)| {
        let what = if rotation { "angle" } else { "deflection" };
        format!("static {what} at {} in {}", comparison.test().sensors[r.sensor].name, t.name)
    })
}

/// Residuals of a kind.
pub(super) fn evaluate(at: &Point<'_>, rotation: bool, out: &mut [f64]) {
    if out.is_empty() {
        return;
    }
    let model = static_readings(at.comparison, at.prediction);
    let own = readings(at.comparison.test()).zip(&model).filter(|((_, _, r), _)| is_of(at.comparison, r, rotation));
    for (o, ((_, _, r), value)) in out.iter_mut().zip(own) {
        *o = (value - r.measured.value) / r.measured.sd;
    }
}

/// Their exact derivatives.
///
/// ```text
/// ∂reading = -λ · ∂K u,   K λ = s
/// ```
pub(super) fn differentiate(at: &Point<'_>, rotation: bool, out: &mut DMatrix<f64>) {
    out.fill(0.0);
    if out.nrows() == 0 {
        return;
    }
    let Some(factor) = at.prediction.system().ok().and_then(|s| s.stiffness.clone().cholesky()) else { return };
    let u = factor.solve(at.comparison.loads());
    let own: Vec<(usize, f64, DVector<f64>)> = readings(at.comparison.test())
        .filter(|(_, _, r)| is_of(at.comparison, r, rotation))
        .map(|(k, _, r)| {
            (k, r.measured.sd, factor.solve(&at.comparison.sensors().row(r.sensor).transpose().into_owned()))
        })
        .collect();
    for (column, &j) in at.scaling.free().iter().enumerate() {
        let Ok(d) = at.comparison.model().assemble_derivative(at.theta, j) else { continue };
        let force = &d.stiffness * &u;
        for (row, (k, sd, adjoint)) in own.iter().enumerate() {
            out[(row, column)] = -adjoint.dot(&force.column(*k)) / sd;
        }
    }
}
