//! Files of NumPy: sparse matrices of SciPy (`scipy.sparse.save_npz`), arrays of `.npz`, one array of `.npy`.
//!
//! A sparse matrix is an archive with `format`, `shape`, `data` and, by format, `indices` and `indptr` (csr, csc, bsr), `row` and `col` (coo),
//! or `offsets` (dia). An archive without `format` holds dense matrices by name.
//!
//! Source: SciPy documentation, scipy.sparse.save_npz and the classes of each format.

use super::{Contents, File, Matrix, MatrixError, MatrixReader};
use crate::arrays::npy::{self, Array, Values};
use crate::arrays::npz;

/// Files of NumPy and SciPy.
#[derive(Debug, Clone, Copy)]
pub struct Numpy;

const FORMAT: &str = "NumPy";

impl MatrixReader for Numpy {
    fn name(&self) -> &'static str {
        "numpy"
    }

    fn summary(&self) -> &'static str {
        "NumPy and SciPy (.npz, .npy): scipy.sparse.save_npz in any of its formats, numpy.savez and numpy.save of dense matrices."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        npz::is_zip(file.bytes) || file.bytes.starts_with(b"\x93NUMPY")
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let broken = |e: &dyn std::fmt::Display| MatrixError::broken(FORMAT, e);
        if !npz::is_zip(file.bytes) {
            let array = npy::read(file.bytes).map_err(|e| broken(&e))?;
            let matrix = dense(file.stem(), &array)
                .ok_or_else(|| broken(&format_args!("its array of shape {:?} is not a real matrix", array.shape)))?;
            return Ok(Contents::of(matrix));
        }
        let (arrays, words) = npz::read_with_words(file.bytes).map_err(|e| broken(&e))?;
        let find = |name: &str| arrays.iter().find(|(n, _)| n == name).map(|(_, a)| a);
        if let (Some(format), Some(_)) = (words.iter().find(|w| w.0 == "format").map(|w| w.1.as_str()), find("shape")) {
            return Ok(Contents::of(sparse(file.stem(), format, &find)?));
        }
        let mut contents = Contents::default();
        for (name, array) in &arrays {
            match dense(name, array) {
                Some(matrix) => contents.matrices.push(matrix),
                None => contents
                    .notes
                    .push(format!("`{name}` of shape {:?} is not a real matrix and is left out", array.shape)),
            }
        }
        if contents.matrices.is_empty() {
            return Err(broken(&"none of its arrays is a real matrix"));
        }
        Ok(contents)
    }
}

/// An array of two dimensions; complex numbers without imaginary parts count as real.
fn dense(name: &str, array: &Array) -> Option<Matrix> {
    let &[n_rows, n_columns] = array.shape.as_slice() else { return None };
    let values = real(array)?;
    let mut matrix = Matrix { name: name.to_string(), n_rows, n_columns, ..Matrix::default() };
    for (i, value) in values.iter().enumerate().filter(|(_, v)| **v != 0.0) {
        if !value.is_finite() {
            return None;
        }
        matrix.push(i / n_columns, i % n_columns, *value)?;
    }
    Some(matrix)
}

fn real(array: &Array) -> Option<Vec<f64>> {
    match &array.values {
        Values::Real(v) => Some(v.clone()),
        Values::Complex(v) => v.iter().map(|z| (z.im == 0.0).then_some(z.re)).collect(),
    }
}

fn sparse<'a>(name: &str, format: &str, find: &dyn Fn(&str) -> Option<&'a Array>) -> Result<Matrix, MatrixError> {
    let broken = |why: String| MatrixError::broken(FORMAT, why);
    let reals = |name: &str| {
        let array = find(name)
            .ok_or_else(|| broken(format!("a sparse matrix of format `{format}` needs the array `{name}`")))?;
        let values = real(array).ok_or_else(|| {
            broken(format!(
                "`{name}` is complex, and matrices of a model are real: export K and M without structural damping"
            ))
        })?;
        if values.iter().all(|v| v.is_finite()) {
            Ok(values)
        } else {
            Err(broken(format!("`{name}` has a value that is not finite")))
        }
    };
    let whole = |name: &str| -> Result<Vec<i64>, MatrixError> {
        let values = reals(name)?;
        let exact = values.iter().map(|v| (v.fract() == 0.0 && v.abs() < 9e15).then_some(*v as i64));
        exact.collect::<Option<_>>().ok_or_else(|| broken(format!("`{name}` has a value that is not a whole number")))
    };
    let shape = whole("shape")?;
    let size: Option<Vec<usize>> =
        shape.iter().map(|n| usize::try_from(*n).ok().filter(|n| u32::try_from(*n).is_ok())).collect();
    let Some([n_rows, n_columns]) = size.as_deref() else {
        return Err(broken(format!("its shape is {shape:?}, and a matrix has two lengths")));
    };
    let mut matrix = Matrix { name: name.to_string(), n_rows: *n_rows, n_columns: *n_columns, ..Matrix::default() };
    let outside = || broken("an index lies outside its shape".to_string());
    let mut push = |row: i64, column: i64, value: f64| {
        let (Ok(row), Ok(column)) = (usize::try_from(row), usize::try_from(column)) else { return Err(outside()) };
        matrix.push(row, column, value).ok_or_else(outside)
    };
    match format {
        "coo" => {
            let (rows, columns, data) = (whole("row")?, whole("col")?, reals("data")?);
            if rows.len() != data.len() || columns.len() != data.len() {
                return Err(broken("`row`, `col` and `data` differ in length".to_string()));
            }
            for ((row, column), value) in rows.into_iter().zip(columns).zip(data) {
                push(row, column, value)?;
            }
        }
        "csr" | "csc" | "bsr" => {
            let (indices, starts, data) = (whole("indices")?, whole("indptr")?, reals("data")?);
            let block: Vec<usize> = match find("data").map(|a| a.shape.as_slice()) {
                Some([_, r, c]) if format == "bsr" => vec![*r, *c],
                Some([_]) if format != "bsr" => vec![1, 1],
                _ => return Err(broken("`data` has the wrong number of dimensions".to_string())),
            };
            let per_block = block[0].saturating_mul(block[1]);
            if per_block.checked_mul(indices.len()) != Some(data.len()) {
                return Err(broken("`indices` and `data` differ in length".to_string()));
            }
            for (major, ends) in starts.windows(2).enumerate() {
                let range = usize::try_from(ends[0]).ok().zip(usize::try_from(ends[1]).ok());
                let Some((from, to)) = range.filter(|(a, b)| a <= b && *b <= indices.len()) else {
                    return Err(broken("`indptr` does not ascend within `indices`".to_string()));
                };
                for k in from..to {
                    for (i, &value) in data[k * per_block..(k + 1) * per_block].iter().enumerate() {
                        let (major, minor) = (major as i64, indices[k]);
                        match format {
                            "csc" => push(minor, major, value)?,
                            "csr" => push(major, minor, value)?,
                            _ if value != 0.0 => {
                                let place = |at: i64, size: usize, within: usize| {
                                    at.saturating_mul(size as i64).saturating_add(within as i64)
                                };
                                push(
                                    place(major, block[0], i / block[1]),
                                    place(minor, block[1], i % block[1]),
                                    value,
                                )?;
                            }
                            _ => {}
                        }
                    }
                }
            }
        }
        "dia" => {
            let (offsets, data) = (whole("offsets")?, reals("data")?);
            let Some(&[n_diagonals, length]) = find("data").map(|a| a.shape.as_slice()) else {
                return Err(broken("`data` has the wrong number of dimensions".to_string()));
            };
            if n_diagonals != offsets.len() {
                return Err(broken("`offsets` and `data` differ in length".to_string()));
            }
            for (diagonal, offset) in offsets.iter().enumerate() {
                for column in 0..length.min(*n_columns) {
                    let row = column as i64 - offset;
                    let value = data[diagonal * length + column];
                    if (0..*n_rows as i64).contains(&row) && value != 0.0 {
                        push(row, column as i64, value)?;
                    }
                }
            }
        }
        other => {
            return Err(broken(format!(
                "a sparse matrix of format `{}` is not read; convert it by `.tocsc()`",
                other.escape_debug()
            )));
        }
    }
    Ok(matrix)
}

/// Writes a sparse matrix as `scipy.sparse.load_npz` reads it: format csc, a triangle with its mirror image.
pub(super) fn write(matrix: &Matrix) -> Vec<u8> {
    let all = matrix.full();
    let mut starts = vec![0_i64; matrix.n_columns + 1];
    for e in &all {
        starts[e.column as usize + 1] += 1;
    }
    for j in 0..matrix.n_columns {
        starts[j + 1] += starts[j];
    }
    let rows: Vec<i64> = all.iter().map(|e| i64::from(e.row)).collect();
    let data: Vec<f64> = all.iter().map(|e| e.value).collect();
    let vector = |values: Vec<f64>| npy::write(&Array { shape: vec![values.len()], values: Values::Real(values) });
    npz::write(&[
        ("indices", npy::write_integers(&rows)),
        ("indptr", npy::write_integers(&starts)),
        ("format", npy::write_word("csc")),
        ("shape", npy::write_integers(&[matrix.n_rows as i64, matrix.n_columns as i64])),
        ("data", vector(data)),
    ])
}
