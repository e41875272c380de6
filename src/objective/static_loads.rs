//! Static tests of a model: load vectors and readings.

use super::responses::rows_of;
use super::starting_point::starting_point;
use crate::correlation::{CorrelationError, observation_matrix};
use crate::data::{Sensor, StaticReading, StaticTest, TestData};
use crate::linalg::DMatrix;
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
    let loads = load_vectors(model, test)?;
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

/// Loads to which a test asks for answers beside the modes, and unit loads at what reads the functions, as columns, (n_dof x any number): what is
/// missing of the motion under one counts in an answer times what is missing of the other.
///
/// # Errors
/// A load or a channel on nothing.
pub fn loads_of(model: &dyn ParametricModel, test: &TestData) -> Result<DMatrix<f64>, CorrelationError> {
    let mut loads = load_vectors(model, test)?;
    if let (Some(set), Some(_)) = (&test.frfs, &test.frf_fit) {
        for channels in [&set.references, &set.responses] {
            let rows = rows_of(model, test, channels)?;
            let first = loads.ncols();
            loads = loads.resize_horizontally(first + rows.nrows(), 0.0);
            loads.columns_mut(first, rows.nrows()).tr_copy_from(&rows);
        }
    }
    Ok(loads)
}

fn load_vectors(model: &dyn ParametricModel, test: &TestData) -> Result<DMatrix<f64>, CorrelationError> {
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
    Ok(loads)
}

/// All readings, test by test.
pub(super) fn readings(test: &TestData) -> impl Iterator<Item = (usize, &StaticTest, &StaticReading)> {
    test.static_tests.iter().enumerate().flat_map(|(k, t)| t.readings.iter().map(move |r| (k, t, r)))
}
