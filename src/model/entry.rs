//! Entries of the matrices of a model: lower triangle, row ≥ column, each per unit of what its matrix is multiplied with.

use crate::linalg::DMatrix;

pub use crate::matrices::Entry;

/// The lower triangle of a dense matrix, without its zeros.
pub(super) fn lower_entries(a: &DMatrix<f64>) -> Vec<Entry> {
    let lower = (0..a.nrows()).flat_map(|row| (0..=row).map(move |column| (row, column)));
    lower.map(|(row, column)| Entry::new(row, column, a[(row, column)])).filter(|e| e.value != 0.0).collect()
}

/// Sorts by place and sums entries of one place, in the order they came.
pub(super) fn merge(list: &mut Vec<Entry>) {
    list.sort_by_key(|e| (e.row, e.column));
    list.dedup_by(|later, kept| {
        let same = (later.row, later.column) == (kept.row, kept.column);
        if same {
            kept.value += later.value;
        }
        same
    });
}
