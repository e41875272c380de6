//! Matrices as rows of sums.

use retune::linalg::DMatrix;

/// The rows of an observation matrix as sums.
pub(super) fn rows_of(sensors: &DMatrix<f64>) -> Vec<Vec<(usize, f64)>> {
    let row = |r: usize| sensors.row(r).iter().copied().enumerate().filter(|(_, v)| *v != 0.0).collect();
    (0..sensors.nrows()).map(row).collect()
}
