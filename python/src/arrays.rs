//! NumPy arrays from the matrices of the library, and the other way.

use crate::error::Wrong;
use numpy::ndarray::{Array2, ShapeBuilder as _};
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use retune::linalg::{DMatrix, DVector};

/// A vector that changes hands without a copy.
pub(crate) fn vector<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    values.into_pyarray(py)
}

/// A matrix that changes hands without a copy: its columns stay contiguous (order F).
pub(crate) fn matrix(py: Python<'_>, a: DMatrix<f64>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shape = (a.nrows(), a.ncols());
    let values: Vec<f64> = a.data.into();
    let array = Array2::from_shape_vec(shape.f(), values).map_err(Wrong::from)?;
    Ok(array.into_pyarray(py))
}

/// Values of an array, contiguous or not.
pub(crate) fn values<T: numpy::Element + Copy>(array: &PyReadonlyArray1<'_, T>) -> Vec<T> {
    array.as_array().iter().copied().collect()
}

/// A point of the unit box.
pub(crate) fn point(array: &PyReadonlyArray1<'_, f64>, n: usize) -> Result<DVector<f64>, Wrong> {
    let x = DVector::from_vec(values(array));
    if x.len() == n {
        Ok(x)
    } else {
        Err(Wrong::text(format!("x has {} entries; there are {n} free parameters", x.len())))
    }
}
