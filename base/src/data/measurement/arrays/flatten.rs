//! Values of MATLAB to named arrays: structures and cells come apart into `structure.field`.

use super::{Variable, Workspace};
use crate::data::{mat, npy};

/// The arrays of a workspace of MATLAB.
///
/// A structure gives `name.field`. An array of structures, or a cell, gives for each field one array with the elements along a last
/// axis where they are all of one size: `modes(3).freq` becomes a vector `modes.freq` of the frequencies of all modes.
pub(in crate::data::measurement) fn of_matlab(variables: Vec<(String, mat::Value)>) -> Workspace {
    let mut out = Workspace::default();
    for (name, value) in variables {
        gather(name, vec![value], &mut out);
    }
    out
}

fn gather(name: String, mut values: Vec<mat::Value>, out: &mut Workspace) {
    use mat::Value::{Cell, Complex, Real, Structure};
    let is_one = values.len() == 1;
    match values.first() {
        Some(Structure { fields, .. }) => {
            let names: Vec<String> = fields.iter().map(|(n, _)| n.clone()).collect();
            let mut columns: Vec<Vec<mat::Value>> = names.iter().map(|_| Vec::new()).collect();
            for value in values {
                match value {
                    // Of several structures each must be a single one, with the same fields.
                    Structure { fields, .. } if is_same(&fields, &names) && (is_one || is_single(&fields)) => {
                        for (column, (_, of_field)) in columns.iter_mut().zip(fields) {
                            column.extend(of_field);
                        }
                    }
                    _ => {
                        out.others.push(name);
                        return;
                    }
                }
            }
            for (field, column) in names.into_iter().zip(columns) {
                gather(format!("{name}.{field}"), column, out);
            }
        }
        Some(Cell { .. }) if is_one => match values.pop() {
            Some(Cell { values, .. }) if !values.is_empty() => gather(name, values, out),
            _ => out.others.push(name),
        },
        Some(Real { dims, .. } | Complex { dims, .. }) => {
            let dims = dims.clone();
            match stacked(dims, values) {
                Some(array) => out.variables.push(Variable { name, array, is_matlab: true }),
                None => out.others.push(name),
            }
        }
        _ => out.others.push(name),
    }
}

fn is_same(fields: &[(String, Vec<mat::Value>)], names: &[String]) -> bool {
    fields.len() == names.len() && fields.iter().zip(names).all(|((a, _), b)| a == b)
}

fn is_single(fields: &[(String, Vec<mat::Value>)]) -> bool {
    fields.iter().all(|(_, values)| values.len() == 1)
}

/// One array of several of one size, along a last axis.
fn stacked(dims: Vec<usize>, values: Vec<mat::Value>) -> Option<npy::Array> {
    use retune_linalg::Complex as C;
    let (mut dims, n) = (dims, values.len());
    let is_complex = values.iter().any(|v| matches!(v, mat::Value::Complex { .. }));
    let (mut real, mut complex): (Vec<f64>, Vec<C<f64>>) = (Vec::new(), Vec::new());
    for value in values {
        match value {
            mat::Value::Real { dims: own, values } if own == dims => {
                if is_complex {
                    complex.extend(values.iter().map(|x| C::new(*x, 0.0)));
                } else if n == 1 {
                    real = values;
                } else {
                    real.extend(values);
                }
            }
            mat::Value::Complex { dims: own, values } if own == dims => {
                if n == 1 {
                    complex = values;
                } else {
                    complex.extend(values);
                }
            }
            _ => return None,
        }
    }
    if n > 1 {
        dims.push(n);
    }
    Some(if is_complex { by_rows(dims, complex, npy::Values::Complex) } else { by_rows(dims, real, npy::Values::Real) })
}

/// MATLAB's order, first index fastest, turned to rows.
fn by_rows<T: Copy>(dims: Vec<usize>, values: Vec<T>, wrap: fn(Vec<T>) -> npy::Values) -> npy::Array {
    if dims.iter().filter(|n| **n != 1).count() <= 1 {
        return npy::Array { shape: dims, values: wrap(values) };
    }
    let values = npy::to_c_order(&dims, values);
    npy::Array { shape: dims, values: wrap(values) }
}
