//! MATLAB files: sparse and dense matrices by the names of their variables.

use super::{Contents, File, Matrix, MatrixError, MatrixReader};
use crate::arrays::mat::{self, Value};

/// MATLAB files of versions 4 and 5.
#[derive(Debug, Clone, Copy)]
pub struct Matlab;

const FORMAT: &str = "MATLAB";

impl MatrixReader for Matlab {
    fn name(&self) -> &'static str {
        "matlab"
    }

    fn summary(&self) -> &'static str {
        "MATLAB (.mat of version 5, `save -v7`, or 4): sparse and dense real matrices by the names of their variables, in structures too."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        // Four small numbers at the top could be many things: version 4 only by the name.
        mat::is_mat(file.bytes)
            && (file.bytes.get(126..128).is_some_and(|b| matches!(b, b"IM" | b"MI"))
                || file.extension() == "mat"
                || file.bytes.starts_with(b"MATLAB")
                || file.bytes.starts_with(b"\x89HDF"))
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let held = mat::read(file.bytes).map_err(|e| MatrixError::broken(FORMAT, e))?;
        let mut contents = Contents { notes: held.notes, ..Contents::default() };
        for (name, value) in &held.variables {
            collect(name, value, &mut contents);
        }
        if contents.matrices.is_empty() {
            return Err(MatrixError::broken(FORMAT, "none of its variables is a real matrix"));
        }
        Ok(contents)
    }
}

fn collect(name: &str, value: &Value, contents: &mut Contents) {
    let mut matrix = Matrix { name: name.to_string(), ..Matrix::default() };
    let read = match value {
        Value::Sparse { rows, columns, entries } => {
            (matrix.n_rows, matrix.n_columns) = (*rows, *columns);
            entries.iter().try_for_each(|(row, column, v)| {
                (v.im == 0.0 && v.re.is_finite()).then_some(())?;
                matrix.push(*row, *column, v.re)
            })
        }
        Value::Real { dims, values } if dims.len() == 2 && dims.iter().all(|d| *d > 1) => {
            (matrix.n_rows, matrix.n_columns) = (dims[0], dims[1]);
            values.iter().enumerate().filter(|(_, v)| **v != 0.0).try_for_each(|(i, v)| {
                v.is_finite().then_some(())?;
                matrix.push(i % dims[0], i / dims[0], *v)
            })
        }
        Value::Structure { fields, .. } => {
            for (field, values) in fields {
                if let [only] = values.as_slice() {
                    collect(&format!("{name}.{field}"), only, contents);
                }
            }
            return;
        }
        _ => return,
    };
    match read {
        Some(()) => contents.matrices.push(matrix),
        None => contents.notes.push(format!("`{name}` is complex or has a value that is not finite, and is left out")),
    }
}
